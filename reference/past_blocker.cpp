// A polygon seen past a blocker: Lambert's formula leaves only the mean over the seeing polygon to quadrature.
#include <cmath>
#include <queue>

#include <glm/glm.hpp>

#include "error.h"
#include "reference/closed_forms.h"

namespace viewpeel::reference {
namespace {

constexpr size_t kMostTriangles = 2'000'000;

glm::dvec3 normalOf(std::span<const glm::dvec3> polygon) {
  glm::dvec3 sum(0);
  for (size_t k = 1; k + 1 < polygon.size(); ++k) sum += glm::cross(polygon[k] - polygon[0], polygon[k + 1] - polygon[0]);
  return glm::normalize(sum);
}

// What the point p with normal n sees of b when the part of the blocker on p's side of b is in the way.
double visibleFromPoint(const glm::dvec3& p, const glm::dvec3& n, std::span<const glm::dvec3> b, std::span<const glm::dvec3> blocker) {
  Loop shadow(b.begin(), b.end());
  glm::dvec3 inside(0);
  for (const glm::dvec3& corner : blocker) inside += corner / double(blocker.size());
  // The cone from p over the blocker is bounded by the planes through p and its edges.
  for (size_t k = 0; k < blocker.size() && !shadow.empty(); ++k) {
    glm::dvec3 plane = glm::cross(blocker[k] - p, blocker[(k + 1) % blocker.size()] - p);
    if (glm::dot(plane, inside - p) < 0) plane = -plane;
    shadow = clip(shadow, plane, glm::dot(plane, p));
  }
  return pointToPolygon(p, n, b) - (shadow.empty() ? 0 : pointToPolygon(p, n, shadow));
}

struct Triangle {
  glm::dvec3 a, b, c;
  double integral, error;
  bool operator<(const Triangle& other) const { return error < other.error; }
};

// Seven points, exact to degree 5 (Radon 1948), times the area.
template <class F>
double integrate(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, F f) {
  const double r = std::sqrt(15.0), w[2] = {(155 - r) / 1200, (155 + r) / 1200}, s[2] = {(6 - r) / 21, (6 + r) / 21};
  double sum = 0.225 * f((a + b + c) / 3.0);
  for (int k = 0; k < 2; ++k) {
    const double t = 1 - 2 * s[k];
    sum += w[k] * (f(t * a + s[k] * (b + c)) + f(t * b + s[k] * (a + c)) + f(t * c + s[k] * (a + b)));
  }
  return sum * glm::length(glm::cross(b - a, c - a)) / 2;
}

}  // namespace

double polygonPastBlocker(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b, std::span<const glm::dvec3> blocker, double tolerance) {
  const glm::dvec3 na = normalOf(a), nb = normalOf(b);
  // Only what is in front of both can come between them.
  const Loop in_front = clip(clip(blocker, na, glm::dot(na, a[0])), nb, glm::dot(nb, b[0]));
  const Loop seeing = clip(a, nb, glm::dot(nb, b[0]));
  if (in_front.empty()) return polygonToPolygon(a, b);
  if (seeing.empty()) return 0;
  const auto f = [&](const glm::dvec3& p) { return visibleFromPoint(p, na, b, in_front); };
  const double area = areaOf(a);

  // A triangle's error is what cutting it in four changes; the worst is cut next, until the errors add up to less than the tolerance.
  std::priority_queue<Triangle> queue;
  double sum = 0, error = 0;
  const auto add = [&](const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r) {
    const glm::dvec3 pq = (p + q) / 2.0, qr = (q + r) / 2.0, rp = (r + p) / 2.0;
    const double whole = integrate(p, q, r, f);
    const double parts = integrate(p, pq, rp, f) + integrate(pq, q, qr, f) + integrate(rp, qr, r, f) + integrate(pq, qr, rp, f);
    queue.push({p, q, r, parts, std::abs(parts - whole)});
    sum += parts;
    error += std::abs(parts - whole);
  };
  for (size_t k = 1; k + 1 < seeing.size(); ++k) add(seeing[0], seeing[k], seeing[k + 1]);
  while (error > tolerance * area && queue.size() < kMostTriangles) {
    const Triangle worst = queue.top();
    queue.pop();
    sum -= worst.integral;
    error -= worst.error;
    const glm::dvec3 ab = (worst.a + worst.b) / 2.0, bc = (worst.b + worst.c) / 2.0, ca = (worst.c + worst.a) / 2.0;
    add(worst.a, ab, ca);
    add(ab, worst.b, bc);
    add(ca, bc, worst.c);
    add(ab, bc, ca);
  }
  if (queue.size() >= kMostTriangles) throw Error(ErrorCode::limit, "the view past a blocker does not converge; ask for a larger tolerance");
  return sum / area;
}

}  // namespace viewpeel::reference

#include "reference/exact/projection.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <unordered_map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <viewpeel/error.h>

namespace viewpeel::reference {
namespace {

double toDouble(const mpz_class& integer, long exponent) {
  long binary_exponent = 0;
  const double mantissa = mpz_get_d_2exp(&binary_exponent, integer.get_mpz_t());
  return std::ldexp(mantissa, static_cast<int>(binary_exponent + exponent));
}

struct HashPoint {
  size_t operator()(const glm::dvec3& p) const {
    uint64_t hash = 0;
    for (const double x : {p.x, p.y, p.z}) {
      uint64_t bits = 0;
      const double positive_zero = x + 0.0;
      std::memcpy(&bits, &positive_zero, sizeof bits);
      hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
    return hash;
  }
};

}  // namespace

Dyadic splitDouble(double x) {
  if (x == 0) return {0, 0};
  int exponent = 0;
  auto mantissa = static_cast<int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
  exponent -= 53;
  for (; mantissa % 2 == 0; mantissa /= 2) ++exponent;
  return {mpz_class(static_cast<long>(mantissa)), exponent};
}

mpq_class toRational(const Dyadic& x) {
  mpq_class result(x.mantissa);
  if (x.exponent >= 0) mpq_mul_2exp(result.get_mpq_t(), result.get_mpq_t(), static_cast<mp_bitcnt_t>(x.exponent));
  else mpq_div_2exp(result.get_mpq_t(), result.get_mpq_t(), static_cast<mp_bitcnt_t>(-x.exponent));
  return result;
}

IntegerCorners::IntegerCorners(const Scene& scene) {
  std::unordered_map<glm::dvec3, uint32_t, HashPoint> by_corner;
  std::vector<std::array<Dyadic, 3>> parts;
  for (const glm::dvec3& corner : scene.corners) {
    const auto [entry, is_new] = by_corner.try_emplace(corner, static_cast<uint32_t>(parts.size()));
    point_of_corner.push_back(entry->second);
    if (!is_new) continue;
    parts.push_back({splitDouble(corner.x), splitDouble(corner.y), splitDouble(corner.z)});
    for (const Dyadic& part : parts.back()) exponent = std::min(exponent, part.exponent);
  }
  points.resize(parts.size());
  for (size_t k = 0; k < parts.size(); ++k)
    for (size_t axis = 0; axis < 3; ++axis)
      points[k][axis] = parts[k][axis].mantissa << static_cast<mp_bitcnt_t>(parts[k][axis].exponent - exponent);
}

int slope(const glm::dvec3& normal, const glm::dvec3& u) {
  const Ball sum = Ball{normal.x} * Ball{u.x} + Ball{normal.y} * Ball{u.y} + Ball{normal.z} * Ball{u.z};
  if (const int sign = certainSign(sum)) return sign;
  mpq_class exact = 0;
  for (int k = 0; k < 3; ++k) exact += toRational(splitDouble(normal[k])) * toRational(splitDouble(u[k]));
  return sgn(exact);
}

Projection::Projection(const Scene& scene, const IntegerCorners& corners, const glm::dvec3& u) : scene_(scene) {
  const double longest = std::max({std::abs(u.x), std::abs(u.y), std::abs(u.z)});
  if (!(longest > 0) || !std::isfinite(u.x + u.y + u.z))
    throw Error(ErrorCode::bad_usage, "a direction must be finite and not zero");
  int scale = 0;
  std::frexp(longest, &scale);
  for (int k = 0; k < 3; ++k) {
    u_[k] = std::ldexp(u[k], -scale);
    if (std::abs(u[k]) == longest) axis_ = k;
  }

  const int i = (axis_ + 1) % 3, j = (axis_ + 2) % 3, k = axis_;
  std::array<Dyadic, 3> parts;
  long u_exponent = 0;
  for (int c = 0; c < 3; ++c) {
    parts[c] = splitDouble(u_[c]);
    u_exponent = std::min(u_exponent, parts[c].exponent);
  }
  std::array<mpz_class, 3> integer_u;
  for (int c = 0; c < 3; ++c)
    integer_u[c] = parts[c].mantissa << static_cast<mp_bitcnt_t>(parts[c].exponent - u_exponent);
  exponent_ = corners.exponent + u_exponent;

  std::unordered_map<glm::dvec3, std::vector<uint32_t>, HashPoint> by_corner;
  std::vector<uint32_t> vertex_of_point;
  for (const auto& point : corners.points) {
    Vertex vertex;
    vertex.x = point[i] * integer_u[k] - point[k] * integer_u[i];
    vertex.y = point[j] * integer_u[k] - point[k] * integer_u[j];
    vertex.rounded = {toDouble(vertex.x, exponent_), toDouble(vertex.y, exponent_)};
    largest_ = std::max({largest_, std::abs(vertex.rounded.x), std::abs(vertex.rounded.y)});
    std::vector<uint32_t>& same = by_corner[glm::dvec3(vertex.rounded, 0)];
    const auto equal = [&](uint32_t v) { return vertices_[v].x == vertex.x && vertices_[v].y == vertex.y; };
    auto match = std::find_if(same.begin(), same.end(), equal);
    if (match == same.end()) {
      match = same.insert(same.end(), static_cast<uint32_t>(vertices_.size()));
      vertices_.push_back(std::move(vertex));
    }
    vertex_of_point.push_back(*match);
  }
  std::vector<uint32_t> vertex_of_corner;
  for (const uint32_t point : corners.point_of_corner) vertex_of_corner.push_back(vertex_of_point[point]);

  for (uint32_t index = 0; index < scene.polygons.size(); ++index) {
    const Polygon& polygon = scene.polygons[index];
    const int sign = slope(scene.planes[polygon.plane].normal, u_);
    if (sign == 0) continue;
    const bool front_up = polygon.front_along_plane_normal == (sign > 0);
    Outline outline{index, front_up, makeOutline(polygon, vertex_of_corner), {}, {}};
    if (outline.vertices.size() < 3) continue;
    outline.low = outline.high = vertices_[outline.vertices[0]].rounded;
    for (const uint32_t v : outline.vertices) {
      outline.low = glm::min(outline.low, vertices_[v].rounded);
      outline.high = glm::max(outline.high, vertices_[v].rounded);
    }
    outline.low -= largest_ * Ball::kUnit;
    outline.high += largest_ * Ball::kUnit;
    outlines_.push_back(std::move(outline));
  }
}

Ball Projection::cross(uint32_t a, uint32_t b, uint32_t c) const {
  const glm::dvec2 p = vertices_[b].rounded - vertices_[a].rounded, q = vertices_[c].rounded - vertices_[a].rounded;
  // Each component of p and q is within `off` of its exact value: 1 ulp for each end, 1 for the subtraction.
  const double off = 4 * Ball::kUnit * largest_;
  const double p_length = std::abs(p.x) + std::abs(p.y), q_length = std::abs(q.x) + std::abs(q.y);
  return {p.x * q.y - p.y * q.x, 1.01 * (off * (p_length + q_length + 2 * off) + Ball::kUnit * p_length * q_length)};
}

mpz_class Projection::exactCross(uint32_t a, uint32_t b, uint32_t c) const {
  const Vertex &p = vertices_[a], &q = vertices_[b], &r = vertices_[c];
  return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

int Projection::orientation(uint32_t a, uint32_t b, uint32_t c) const {
  if (a == b || b == c || a == c) return 0;
  if (const int sign = certainSign(cross(a, b, c))) return sign;
  return sgn(exactCross(a, b, c));
}

double Projection::areaFactor() const { return 0.5 / (std::abs(u_[axis_]) * glm::length(u_)); }

double Projection::lengthInProjection(uint32_t a, uint32_t b) const {
  const glm::dvec2 step = (vertices_[b].rounded - vertices_[a].rounded) / u_[axis_];
  glm::dvec3 in_space(0);
  in_space[(axis_ + 1) % 3] = step.x;
  in_space[(axis_ + 2) % 3] = step.y;
  const glm::dvec3 along = glm::normalize(u_);
  return glm::length(in_space - glm::dot(in_space, along) * along);
}

// Returns the corners themselves where they turn one way throughout; up to four such corners are convex. Otherwise it
// returns the convex hull of the exact points (A. M. Andrew's monotone chain, 1979).
std::vector<uint32_t> Projection::makeOutline(const Polygon& polygon,
                                              const std::vector<uint32_t>& vertex_of_corner) const {
  const auto first = vertex_of_corner.begin() + polygon.first_corner;
  std::vector<uint32_t> outline(first, first + polygon.corner_count);
  const size_t count = outline.size();
  if (count <= 4) {
    int sum = 0;
    for (size_t k = 0; k < count; ++k)
      sum += orientation(outline[k], outline[(k + 1) % count], outline[(k + 2) % count]);
    if (sum == static_cast<int>(count)) return outline;
    if (sum == -static_cast<int>(count)) return {outline.rbegin(), outline.rend()};
  }
  std::sort(outline.begin(), outline.end(), [&](uint32_t a, uint32_t b) {
    const Vertex &p = vertices_[a], &q = vertices_[b];
    const int by_x = cmp(p.x, q.x);
    return by_x != 0 ? by_x < 0 : cmp(p.y, q.y) < 0;
  });
  outline.erase(std::unique(outline.begin(), outline.end()), outline.end());
  std::vector<uint32_t> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const size_t base = hull.size();
    for (const uint32_t v : outline) {
      while (hull.size() >= base + 2 && orientation(hull[hull.size() - 2], hull.back(), v) <= 0) hull.pop_back();
      hull.push_back(v);
    }
    hull.pop_back();
    std::reverse(outline.begin(), outline.end());
  }
  return hull;
}

}  // namespace viewpeel::reference

#include "reference/exact/edge_cuts.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace viewpeel::reference {

void EdgeCuts::appendSpan(uint32_t outline, std::vector<Span>& spans) const {
  const std::vector<uint32_t>& vertices = projection_.outlines()[outline].vertices;
  const auto count = static_cast<uint32_t>(vertices.size());
  thread_local std::vector<int> sides;
  sides.resize(count);
  bool any_left = false, any_right = false;
  uint32_t on_line = 0;
  for (uint32_t k = 0; k < count; ++k) {
    sides[k] = projection_.orientation(a_, b_, vertices[k]);
    any_left |= sides[k] > 0;
    any_right |= sides[k] < 0;
    on_line += sides[k] == 0;
  }

  Span span{outline, 0, {}, {}};
  if (any_left && any_right) {
    // A counter-clockwise outline comes down across the line where the line enters, and goes up where it leaves.
    for (uint32_t k = 0; k < count; ++k) {
      const uint32_t next = (k + 1) % count, after = (k + 2) % count;
      if (sides[k] == 0) continue;
      const bool through_vertex = sides[next] == 0;
      if (sides[k] + sides[through_vertex ? after : next] != 0) continue;
      const uint32_t c = vertices[through_vertex ? next : k], d = vertices[next];
      (sides[k] > 0 ? span.enter : span.leave) = makeCut(c, d);
    }
  } else if (on_line == 2) {
    uint32_t first = 0;
    while (sides[first] != 0 || sides[(first + 1) % count] != 0) ++first;
    span.side = any_left ? 1 : -1;
    span.enter = makeCut(vertices[first], vertices[first]);
    span.leave = makeCut(vertices[(first + 1) % count], vertices[(first + 1) % count]);
    if (any_right) std::swap(span.enter, span.leave);
  } else {
    return;
  }
  if (compare(span.enter, end()) >= 0 || compare(span.leave, begin()) <= 0) return;
  if (compare(span.enter, begin()) < 0) span.enter = begin();
  if (compare(span.leave, end()) > 0) span.leave = end();
  spans.push_back(span);
}

int EdgeCuts::compare(const Cut& p, const Cut& q) const {
  if (const int sign = certainSign(p.t - q.t)) return sign;
  if ((p.c == q.c && p.d == q.d) || (p.c == q.d && p.d == q.c)) return 0;
  const Fraction s = exactFraction(p), t = exactFraction(q);
  return cmp(mpz_class(s.numerator * t.denominator), mpz_class(t.numerator * s.denominator));
}

mpq_class EdgeCuts::exactParameter(const Cut& cut) const {
  const Fraction t = exactFraction(cut);
  mpq_class result(t.numerator, t.denominator);
  result.canonicalize();
  return result;
}

Cut EdgeCuts::makeCut(uint32_t c, uint32_t d) const {
  if (c == d && c == a_) return begin();
  if (c == d && c == b_) return end();
  Cut cut{{}, c, d};
  if (c == d) {
    const glm::dvec2 a = projection_.vertices()[a_].rounded, b = projection_.vertices()[b_].rounded;
    const glm::dvec2 p = projection_.vertices()[c].rounded;
    const int k = std::abs(b.x - a.x) > std::abs(b.y - a.y) ? 0 : 1;
    const auto rounded = [](double x) { return Ball{x, Ball::kUnit * std::abs(x)}; };
    cut.t = (rounded(p[k]) - rounded(a[k])) / (rounded(b[k]) - rounded(a[k]));
  } else {
    const Ball a_side = projection_.cross(c, d, a_), b_side = projection_.cross(c, d, b_);
    cut.t = a_side / (a_side - b_side);
  }
  // A piece of the edge adds to an area in proportion to t, so a shallow angle must not cost accuracy.
  if (!(cut.t.error < 1e-12)) {
    const double t = exactParameter(cut).get_d();
    cut.t = {t, Ball::kUnit * std::abs(t)};
  }
  return cut;
}

EdgeCuts::Fraction EdgeCuts::exactFraction(const Cut& cut) const {
  Fraction result;
  if (cut.c == cut.d) {
    const Vertex &a = projection_.vertices()[a_], &b = projection_.vertices()[b_], &p = projection_.vertices()[cut.c];
    const bool by_x = a.x != b.x;
    result.numerator = by_x ? p.x - a.x : p.y - a.y;
    result.denominator = by_x ? b.x - a.x : b.y - a.y;
  } else {
    result.numerator = projection_.exactCross(cut.c, cut.d, a_);
    result.denominator = result.numerator - projection_.exactCross(cut.c, cut.d, b_);
  }
  if (result.denominator < 0) {
    result.numerator = -result.numerator;
    result.denominator = -result.denominator;
  }
  return result;
}

}  // namespace viewpeel::reference

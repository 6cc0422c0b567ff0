#include "scene/cut_away.h"

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

namespace viewpeel {
namespace {

using Corners = std::vector<glm::dvec3>;

constexpr double kLeastPiece = 1e-14;  // as a share of the polygon's area

// Returns the part of a convex polygon where dot(normal, x) >= offset.
Corners clip(const Corners& corners, const glm::dvec3& normal, double offset) {
  Corners kept;
  for (size_t k = 0; k < corners.size(); ++k) {
    const glm::dvec3 &a = corners[k], &b = corners[(k + 1) % corners.size()];
    const double at_a = glm::dot(normal, a) - offset, at_b = glm::dot(normal, b) - offset;
    if (at_a >= 0) kept.push_back(a);
    if ((at_a > 0 && at_b < 0) || (at_a < 0 && at_b > 0)) kept.push_back(a + (b - a) * (at_a / (at_a - at_b)));
  }
  return kept;
}

}  // namespace

glm::dvec3 twiceAreaNormal(const Corners& corners) {
  glm::dvec3 sum(0);
  for (size_t k = 1; k + 1 < corners.size(); ++k)
    sum += glm::cross(corners[k] - corners[0], corners[k + 1] - corners[0]);
  return sum;
}

std::vector<Corners> cutAway(const Corners& corners, const glm::dvec3& normal, const std::vector<Corners>& holes) {
  const double least = kLeastPiece * glm::length(twiceAreaNormal(corners));
  std::vector<Corners> pieces = {corners};
  for (Corners hole : holes) {
    if (glm::dot(twiceAreaNormal(hole), normal) < 0) std::reverse(hole.begin(), hole.end());
    std::vector<Corners> left;
    for (Corners piece : pieces)
      for (size_t k = 0; k < hole.size() && !piece.empty(); ++k) {
        const glm::dvec3 &a = hole[k], &b = hole[(k + 1) % hole.size()];
        const glm::dvec3 inward = glm::cross(normal, b - a);
        const double length = glm::length(inward);
        if (!(length > 0)) continue;
        const double offset = glm::dot(inward, a);
        Corners outside = clip(piece, -inward, -offset);
        if (glm::length(twiceAreaNormal(outside)) > least) left.push_back(std::move(outside));
        piece = clip(piece, inward, offset);
      }
    pieces = std::move(left);
  }
  return pieces;
}

}  // namespace viewpeel

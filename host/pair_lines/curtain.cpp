#include "pair_lines/curtain.h"

#include <cmath>

#include <glm/glm.hpp>

#include "pair_lines/shafts.h"

namespace viewpeel {

bool Curtain::isCrossedBy(const glm::dvec3& p, const glm::dvec3& q) const {
  bool is_odd = false;
  for (const uint32_t member : members_) {
    const Blocker& blocker = blockers_[member];
    const double from = glm::dot(blocker.normal, p) - blocker.offset, to = glm::dot(blocker.normal, q) - blocker.offset;
    if (std::min(from, to) > kTouchingShaft || std::max(from, to) < -kTouchingShaft) continue;
    const bool is_across = std::min(from, to) < -kTouchingShaft && std::max(from, to) > kTouchingShaft;
    if (!is_across) return false;
    const glm::dvec3 x = glm::mix(p, q, from / (from - to));
    double beyond = -INFINITY;
    for (uint32_t e = 0; e < blocker.corner_count; ++e)
      beyond = std::max(beyond, glm::dot(blocker.edge_normals[e], x) - blocker.edge_offsets[e]);
    if (std::abs(beyond) <= kTouchingShaft) return false;
    is_odd ^= beyond < 0;
  }
  return is_odd;
}

}  // namespace viewpeel

#include "pair_lines/blocker_list.h"

namespace viewpeel {

void BlockerList::close() {
  constexpr double kBeyond = 1e30;
  for (size_t k = size_; k % kBlockerLanes != 0; ++k) {
    Group& group = groups_[k / kBlockerLanes];
    group.indices[k % kBlockerLanes] = UINT32_MAX;
    for (auto& bound : group.bounds) bound[k % kBlockerLanes] = kBeyond;
  }
}

}  // namespace viewpeel

#include "engines/work.h"

#include <algorithm>

namespace viewpeel {

void addWork(const Work& part, Work& sum) {
  sum.directions = std::max(sum.directions, part.directions);  // engines of several windows count the same directions
  for (uint64_t Work::*member : {&Work::lattice_points, &Work::tiles, &Work::active_tiles, &Work::list_entries,
                                 &Work::rows, &Work::spans, &Work::samples, &Work::rounds, &Work::tests,
                                 &Work::fragments, &Work::gaps, &Work::repeats, &Work::resumed, &Work::memory_bytes})
    sum.*member += part.*member;
  sum.pass_seconds.resize(part.pass_seconds.size());
  for (size_t k = 0; k < part.pass_seconds.size(); ++k)
    sum.pass_seconds[k] = {part.pass_seconds[k].first, sum.pass_seconds[k].second + part.pass_seconds[k].second};
}

}  // namespace viewpeel

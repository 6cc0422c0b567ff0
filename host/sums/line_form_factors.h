// Form factors of a run in which pairs have lines of their own.
#pragma once
#include <viewpeel/form_factors.h>
#include "sums/line_sums.h"
#include "sums/replicate_sums.h"

namespace viewpeel {

// The form factors between ids, and of each with environment and leak.
//   In: lines: of pairs of faces; by: of the result; counted: lines of common directions, by the result's ids: faces
//   or surfaces;
//   measure_area, count_area: as in ReplicateSums
//   Out: pairs by their own lines. Environment is what a row's pairs leave, less the leak that common directions
//   counted, where they saw lines of the row leave the scene, or where it is beyond doubt. Rows of a scene in which no
//   line leaves or leaks are as they add up.
//   Error: of environment: that of the row's pairs together and of the leak.
FormFactors lineFormFactors(const LineSums& lines, By by, const ReplicateSums& counted, double measure_area,
                            double count_area);

// Makes the same of exchange areas between faces, and of faces with kLeak, however they were found.
//   In: entries: of independent errors, sorted; surface: of each face
FormFactors lineFormFactors(std::vector<FormFactors::Entry> entries, const std::vector<uint32_t>& surface, By by,
                            const ReplicateSums& counted, double measure_area, double count_area);

}  // namespace viewpeel

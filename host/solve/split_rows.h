// Rows whose emissivity depends on the angle are split in two: docs/method.md, section 15.
#pragma once
#include <optional>

#include <viewpeel/solve.h>

#include "engines/shared_products.h"
#include "solve/heat_answers.h"

namespace viewpeel {

// SplitRows have an emitter, which absorbs all that reaches it, and a reflector for each directional row. Along each
// direction the emitter has the share e(angle) of the row's lines, and the reflector has the rest. Diffuse rows stay as
// they are.
struct SplitRows {
  Ids ids;                              // with areas e A of emitters, and (1 - e) A of reflectors
  Enclosure enclosure;                  // emissivities are 1 for emitters, 0 for reflectors
  AnswerRows answers;                   // for each row of the enclosure before the split: its rows after it
  std::optional<PolygonShares> shares;  // unset where all rows are diffuse
};

// Splits the directional rows of an enclosure.
//   In: scene: need not be kept; ids: of its faces or surfaces; enclosure: with a material for each
//   Throws: Error bad_usage for a law that is not sound, or an emissivity above 1 at some angle.
//   Cost: O(polygons).
SplitRows splitRows(const Scene& scene, const Ids& ids, const Enclosure& enclosure);

}  // namespace viewpeel

// Refuses enclosures that have no solution, each in one line.
#pragma once
#include <viewpeel/solve.h>
#include "solve/closed_exchange.h"

namespace viewpeel {

// Refuses materials that do not go with the rows, an open scene without an environment, and rows without a temperature
// to refer to.
//   Throws: Error bad_usage or bad_input, naming row and remedy.    Cost: O(pairs).
void requireMaterials(const ClosedExchange& closed, const Enclosure& enclosure, const Ids& ids);

}  // namespace viewpeel

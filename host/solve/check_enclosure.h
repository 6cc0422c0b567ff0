// requireMaterials() refuses enclosures that have no solution, with one line for the first fault.
#pragma once
#include <viewpeel/solve.h>
#include "solve/closed_exchange.h"

namespace viewpeel {

// Refuses materials that do not match the rows, an open scene without an environment, and rows that exchange with
// nothing of a given temperature.
//   Throws: Error bad_usage or bad_input, naming row and remedy.    Cost: O(pairs).
void requireMaterials(const ClosedExchange& closed, const Enclosure& enclosure, const Ids& ids);

}  // namespace viewpeel

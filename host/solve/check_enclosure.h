// These functions refuse enclosures that have no solution, with one line that names the first fault.
#pragma once
#include <viewpeel/solve.h>
#include "solve/closed_exchange.h"

namespace viewpeel {

// Refuses materials that do not match the rows, and an open scene without an environment.
//   In: closed: its pairs are not read
//   Throws: Error bad_usage or bad_input, naming row and remedy.    Cost: O(rows).
void requireMaterials(const ClosedExchange& closed, const Enclosure& enclosure, const Ids& ids);

// Refuses rows that exchange heat, directly or through others, with nothing of a given temperature.
//   Throws: Error bad_input, naming row and remedy.    Cost: O(pairs).
void requireReferences(const ClosedExchange& closed, const Enclosure& enclosure, const Ids& ids);
[[noreturn]] void refuseWithoutReference(const std::string& name);

// Returns whether all rows have heat fluxes, so that temperatures alone have errors.    Cost: O(rows).
bool areAllFluxesGiven(const Enclosure& enclosure);

// Refuses a tolerance that is not above 0, and one of temperatures, or of heat, where all of them are given.
//   Throws: Error bad_usage.
void requireTolerance(const HeatTolerance& tolerance, const Enclosure& enclosure);

}  // namespace viewpeel

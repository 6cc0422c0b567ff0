// describeHeat() writes the program's summary of heat flows and temperatures.
#pragma once
#include <string>

#include <viewpeel/solve.h>

namespace viewpeel::program {

// Returns a table of the surfaces with the largest heat flows, then the balance, errors, and lacks of rows.
//   In: by: whether errors are stated for polygons or surfaces
std::string describeHeat(const HeatSolution& solution, By by);

}  // namespace viewpeel::program

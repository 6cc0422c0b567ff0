// The program prints this summary of heat flows and temperatures.
#pragma once
#include <string>

#include <viewpeel/solve.h>

namespace viewpeel::program {

// Tabulates the surfaces with the largest heat flows, then the balance, errors, and what rows lack.
//   In: by: whose errors are meant
std::string describeHeat(const HeatSolution& solution, By by);

}  // namespace viewpeel::program

// These rules settle a request: which choices are allowed, and which reduce the work.
#pragma once
#include <string>

#include <viewpeel/request.h>

namespace viewpeel {

constexpr uint32_t kUsualDirections = 400;            // of a replicate, unless a plan or the request says
constexpr double kSurfaceUnoccludedTolerance = 2e-4;  // largest at which surfaces use unoccluded form factors
constexpr size_t kMostUnoccludedFaces = 20'000;       // above this, counts of blocked pairs take gigabytes
constexpr size_t kMostPairLineFaces = 8'000;          // above this, a plan estimates whether finding all pairs pays
constexpr double kCoarseTolerance = 0.02;             // above this, large open scenes without rays have no pair lines
constexpr double kPromiseDelta = 0.01;                // probability that a promised tolerance fails
// A guarantee within E counts a leak of up to this part of E as environment: lines that graze an edge may end on backs
// by rounding.
constexpr double kGrazedPart = 0.1;
// A run whose goal is a time takes a tolerance from this range.
constexpr double kCoarsestTimed = 0.25, kFinestTimed = 1e-6;

// Returns the amount of the goal where it is a FixedAmount, else the request's. With 0 directions the plan chooses the
// number.
Amount amountOf(const Request& request);

// Refuses goals, limits and amounts that are meaningless, such as a negative time.
//   Throws: Error bad_usage, naming the program's option.
void requireNumbers(const Request& request);

// Returns whether unoccluded form factors are possible: for the whole matrix, not for medians nor a guarantee by
// surface.
bool mayUseUnoccluded(const Request& request);

// Returns whether pair lines are possible: the goal must say how many lines a pair needs, and the engine must suit.
bool mayUsePairLines(const Request& request);

// Returns the option by which a request asks for common directions alone; empty where there is none.
std::string optionAgainstPairLines(const Request& request);

// Returns the option by which a request asks for an estimate, so that its tolerance is no promise; empty where there is
// none.
std::string optionAgainstPromise(const Request& request);

}  // namespace viewpeel

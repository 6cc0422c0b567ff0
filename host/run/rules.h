// These rules settle a request: which choices it may have, and which pay.
#pragma once
#include <string>

#include <viewpeel/request.h>

namespace viewpeel {

constexpr uint32_t kUsualDirections = 400;            // of a replicate, where neither a plan nor the request says
constexpr double kSurfaceUnoccludedTolerance = 2e-4;  // up to which unoccluded form factors pay between surfaces
constexpr size_t kMostUnoccludedFaces = 20'000;       // beyond which blocked pairs take gigabytes
constexpr size_t kMostPairLineFaces = 8'000;          // beyond which finding what blocks each pair takes minutes
constexpr double kPairLineTolerance = 0.02;           // up to which pair lines pay
constexpr double kPromiseDelta = 0.01;                // with which a promised tolerance may fail

// Returns the amount of a FixedAmount where that is the goal, else the request's own. Directions of 0 are to be
// planned.
Amount amountOf(const Request& request);

// Refuses numbers that mean nothing: goals, limits and amounts.
//   Throws: Error bad_usage, naming the program's option.
void requireNumbers(const Request& request);

// Unoccluded form factors need the whole matrix, blocked pairs counted, and of a guarantee means by polygon.
bool mayUseUnoccluded(const Request& request);

// Pair lines need a goal that says how many each pair gets, and an engine for the few common directions beside them.
bool mayUsePairLines(const Request& request);

// Returns the option by which a request asks for an estimate, so that its tolerance is not promised; empty where none
// does.
std::string optionAgainstPromise(const Request& request);

}  // namespace viewpeel

// An UnoccludedExchange computes exchange areas of pairs of polygons with nothing in between.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <viewpeel/scene.h>
#include "vulkan/device.h"

namespace viewpeel {

// These bounds hold for the error of every pair that is not reported: relative, or absolute in the form factor from the
// smaller polygon.
constexpr double kUnoccludedRelativeError = 1e-6;
constexpr double kUnoccludedAbsoluteError = 1e-9;

// Side 2k is the front of polygon k, side 2k + 1 its back.
struct SidePair {
  uint32_t i = 0, j = 0;
};

constexpr uint32_t frontSide(uint32_t polygon_index) { return 2 * polygon_index; }
constexpr uint32_t backSide(uint32_t polygon_index) { return 2 * polygon_index + 1; }

struct UnoccludedOptions {
  uint32_t chunk_pairs = 1u << 19;  // pairs on the device at once: 96 bytes each
  uint32_t near_pairs = 1u << 14;   // of them integrated along their contours at once: about 1.3 KB each
  uint32_t thread_count = 0;        // on the processor; 0: one per core
};

// An UnreachedPair is a pair whose accuracy was not reached.
struct UnreachedPair {
  uint64_t pair = 0;  // index into the pairs of the call
  double error = 0;   // estimated, of its exchange area
};

// UnoccludedWork counts the work since the object was made.
struct UnoccludedWork {
  uint64_t pairs = 0, unseen_pairs = 0;                      // of all calls; of polygons that do not see each other
  std::array<uint64_t, 5> far_pairs{};                       // by product rules of 2, 3, 4, 5, 6 points a coordinate
  uint64_t near_pairs = 0, again_pairs = 0;                  // by their contours; of these pairs, with more points
  uint64_t line_integrals = 0;                               // over pairs of edges
  std::vector<std::pair<std::string, double>> pass_seconds;  // on the device
};

class HostUnoccluded;

// Its areas are A_i F_ij = A_j F_ji of pairs of sides of a scene's polygons, docs/method.md, eq. (35) and (36).
//   Far pairs take product Gauss rules of 2..6 points a coordinate, chosen by a bound on their error. The others take
//     the contour integral. Its inner integral has a closed form, its outer one Gauss rules graded towards the places
//     where the inner one is singular.
class UnoccludedExchange {
 public:
  //   In: a scene as buildScene makes it. It is not referred to afterwards; the device is.
  //   Throws: Error device where memory cannot be had; Error limit (2^31 polygons or more).
  //   Cost: 192 bytes a polygon on the device; kernels are compiled: 0.3 s on lavapipe.
  UnoccludedExchange(const Device& device, const Scene& scene, const UnoccludedOptions& options = {});
  // Computes on the processor's threads: other rounding, and nothing to compile.
  explicit UnoccludedExchange(const Scene& scene, const UnoccludedOptions& options = {});
  ~UnoccludedExchange();

  // Computes the exchange areas of pairs of sides.
  //   In: pairs of sides, in any order; `areas` of the same size.
  //   Out: areas: A_i F_ij of each pair, unit-ball units squared, the same bits for (i, j) and (j, i) and for any
  //     options. They are exactly 0 between sides of one polygon. They are 0, too, where one side lies behind the
  //     other's plane or within rounding of it (2^-50, and more where a thin polygon's corners do not fix its plane).
  //     Sides of one plane that face each other, as touching solids do, exchange the area of their overlap. Returned:
  //     the pairs that have not reached the accuracy, by index; their areas are the best there is.
  //   Error: kUnoccludedRelativeError or kUnoccludedAbsoluteError, whichever allows more; kUnoccludedRelativeError
  //     alone for far pairs. It rests on bounds on every rule's error, of which the bound of graded rules was measured
  //     (line_rules.h), and on rounding. The corners are taken as exact. tests/device/unoccluded_test.cpp.
  //   Throws: Error bad_usage (a side that the scene does not have; spans of different sizes); Error device.
  //   Cost: 16..1296 kernel values a far pair; up to 25 line integrals a near one, of 4 to 24 points, or four times
  //     this number where edges touch. Memory as the options say.
  //   Source: E. M. Sparrow, A new and simpler formulation for radiative angle factors, J. Heat Transfer 85(2), 1963,
  //     81-87.
  std::vector<UnreachedPair> compute(std::span<const SidePair> pairs, std::span<double> areas);

  const UnoccludedWork& work() const;

 private:
  struct State;
  std::unique_ptr<State> state_;  // on a device
  std::unique_ptr<HostUnoccluded> host_;
};

}  // namespace viewpeel

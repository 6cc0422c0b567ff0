// An UnoccludedExchange computes unoccluded exchange areas of pairs of polygons, on a device or on the processor.
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

// The error of every pair that compute() does not return is within one of these bounds. The first is relative, the
// second absolute in the form factor from the smaller polygon.
constexpr double kUnoccludedRelativeError = 1e-6;
constexpr double kUnoccludedAbsoluteError = 1e-9;

// A SidePair is a pair of sides. Side 2k is the front of polygon k, side 2k + 1 its back.
struct SidePair {
  uint32_t i = 0, j = 0;
};

constexpr uint32_t frontSide(uint32_t polygon_index) { return 2 * polygon_index; }
constexpr uint32_t backSide(uint32_t polygon_index) { return 2 * polygon_index + 1; }

struct UnoccludedOptions {
  uint32_t chunk_pairs = 1u << 19;  // pairs on the device at once; each takes 96 bytes
  uint32_t near_pairs = 1u << 14;   // pairs integrated along their contours at once; each takes about 1.3 KB
  uint32_t thread_count = 0;        // threads on the processor; 0: one a core
};

// An UnreachedPair is a pair whose area is less accurate than the bounds above.
struct UnreachedPair {
  uint64_t pair = 0;  // index into the pairs of the call
  double error = 0;   // estimated error of its exchange area, unit-ball units squared
};

// UnoccludedWork counts the work of all calls.
struct UnoccludedWork {
  uint64_t pairs = 0, unseen_pairs = 0;      // all pairs; pairs of polygons that cannot see each other
  std::array<uint64_t, 5> far_pairs{};       // pairs by the product rules of 2, 3, 4, 5, 6 points a coordinate
  uint64_t cut_pairs = 0;                    // pairs whose parts in front of each other take product rules
  uint64_t near_pairs = 0, again_pairs = 0;  // pairs integrated along their contours; repeats with more points
  uint64_t line_integrals = 0;               // integrals over pairs of edges
  std::vector<std::pair<std::string, double>> pass_seconds;  // name of each pass on the device, and its time in s
};

class HostUnoccluded;

// An UnoccludedExchange computes A_i F_ij = A_j F_ji of pairs of sides of a scene's polygons with nothing in between,
// docs/method.md, eq. (35) and (36). Far pairs are integrated by product Gauss rules of 2 to 6 points a coordinate,
// chosen by a bound on their error. Near pairs are integrated along their contours. There the inner integral has a
// closed form, and the outer one takes Gauss rules, graded towards the places where the inner one is singular.
class UnoccludedExchange {
 public:
  // Makes an object that computes on a device.
  //   In: device: the caller keeps it alive; scene: as buildScene makes it, need not be kept
  //   Throws: Error memory where the device has too little; Error limit for 2^31 polygons or more; Error device.
  //   Cost: 192 bytes a polygon on the device; compiling kernels takes 0.3 s on lavapipe.
  UnoccludedExchange(const Device& device, const Scene& scene, const UnoccludedOptions& options = {});
  // Makes an object that computes on the processor's threads. Its rounding differs, and it has nothing to compile.
  explicit UnoccludedExchange(const Scene& scene, const UnoccludedOptions& options = {});
  ~UnoccludedExchange();

  // Computes the exchange areas of pairs of sides.
  //   In: pairs: pairs of sides, in any order; areas: double[pairs]
  //   Out: areas: A_i F_ij of each pair, unit-ball units squared, the same bits for (i, j) and (j, i) and for any
  //     options. They are exactly 0 between sides of one polygon, and where one side lies behind the other's plane or
  //     within rounding of it. Rounding is 2^-50, more where a thin polygon's corners do not fix its plane. Sides of
  //     one plane that face each other, as touching solids do, exchange the area of their overlap. It returns the
  //     pairs whose error may exceed the bounds, sorted by index; their areas are from the rules with the most
  //     points.
  //   Error: kUnoccludedRelativeError or kUnoccludedAbsoluteError, whichever allows more; kUnoccludedRelativeError
  //     alone for far pairs. Both follow from bounds on rounding and on the error of every rule; the error of graded
  //     rules was measured (line_rules.h). The corners are taken as exact. tests/device/unoccluded_test.cpp.
  //   Throws: Error bad_usage for a side that the scene does not have, or spans of different sizes; Error device.
  //   Cost: 16 to 1296 values of the integrand a far pair; up to 25 line integrals a near pair, each of 4 to 24 points,
  //     or four times as many where edges touch. Memory as UnoccludedOptions says.
  //   Source: E. M. Sparrow, A new and simpler formulation for radiative angle factors, J. Heat Transfer 85(2), 1963,
  //     81-87.
  std::vector<UnreachedPair> compute(std::span<const SidePair> pairs, std::span<double> areas);

  const UnoccludedWork& work() const;

 private:
  struct State;
  std::unique_ptr<State> state_;  // empty where the processor computes
  std::unique_ptr<HostUnoccluded> host_;
};

}  // namespace viewpeel

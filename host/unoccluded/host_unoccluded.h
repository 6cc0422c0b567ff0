// HostUnoccluded computes unoccluded exchange areas on the processor, pair by pair.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "unoccluded/edge_integrals.h"
#include "unoccluded/shapes.h"
#include "unoccluded/unoccluded.h"

namespace viewpeel {

// A HostUnoccluded takes each pair through the same steps that the kernels in shaders/unoccluded take in passes. The
// comments there give the reasons of each step.
class HostUnoccluded {
 public:
  // Prepares the shapes of all polygons and the rules.
  //   In: scene: copied; thread_count: 0 for one a core
  explicit HostUnoccluded(const Scene& scene, size_t thread_count = 0);

  // Does what UnoccludedExchange::compute does, but does not check that the scene has these sides.
  std::vector<UnreachedPair> compute(std::span<const SidePair> pairs, std::span<double> areas);

  // Found is the exchange area of a pair, with a bound on its error: of rules, of rounding, and of rounded corners.
  struct Found {
    double area = 0, error = 0;  // unit-ball units squared
    bool is_reached = true;      // whether the error is within kUnoccludedRelativeError or kUnoccludedAbsoluteError
  };
  // Computes the exchange area of one pair. Several threads may call it at once.    Out: work: raised
  Found find(const SidePair& pair, UnoccludedWork& work) const;
  // Does the same as find(), with two methods that the kernels do not have. Distant polygons that reach behind each
  // other's planes are cut there, and their parts take product rules. Near pairs take closed forms of parallel edges:
  // where all edges are parallel or perpendicular to each other, rounding is the only error.
  //   Error: Found::error; tests/unit/unoccluded_error_test.cpp.
  Found findClosely(const SidePair& pair, UnoccludedWork& work) const;

  uint64_t sideCount() const { return 2 * shapes_.size(); }
  const UnoccludedWork& work() const { return work_; }

 private:
  struct Sides;
  struct Point {
    double at, weight;
  };
  using Depths = std::array<double, 4>;
  static constexpr size_t kMostFar = unoccluded_data::kMostFarPoints;
  static constexpr uint32_t unseen = unoccluded_data::kPairLists;  // what classify returns where nothing is exchanged

  Sides sidesOf(const SidePair& pair) const;
  enum class Lines { by_rules, parallel_closed };
  Found find(const SidePair& pair, Lines lines, UnoccludedWork& work) const;
  uint32_t classify(const Sides& sides, double& far_error) const;
  static double roundingOf(const Sides& sides);
  static double errorOfCorners(const unoccluded_data::ShapeData& a, const unoccluded_data::ShapeData& b);
  uint32_t chooseRule(const Sides& sides, double& far_error) const;
  std::optional<Found> integrateCut(const Sides& sides) const;
  double integrateFar(const Sides& sides, uint32_t rule) const;
  double integrateNear(const Sides& sides, size_t round, Lines lines, double& error, double& further_rounding,
                       UnoccludedWork& work) const;

  size_t threads_;
  std::vector<unoccluded_data::ShapeData> shapes_;
  std::array<unoccluded_data::FarBound, unoccluded_data::kFarRules> bounds_;
  std::array<std::vector<Point>, unoccluded_data::kFarRules> far_points_;
  EdgeRules edge_rules_;
  UnoccludedWork work_;
};

}  // namespace viewpeel

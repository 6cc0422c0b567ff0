// A Planner finds the plan of a run. It counts pilots for times and variances (measure_pilots.cpp). It predicts the
// cost of a lattice and the variance of its counts (lattice_loads.cpp). Then it chooses (plan.cpp).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "estimator/pilot_variances.h"
#include "estimator/plan.h"

namespace viewpeel {

constexpr int kFirstResolution = 64;      // of the first pilot
constexpr uint32_t kPilotReplicates = 8;  // replicates of a pilot
constexpr double kMostPilotSeconds = 30;  // of each pilot

// A Shape describes the lattices of a plan. The groups have the resolutions base x 4^m, up to `finest`, which the
// neediest polygon gets.
struct Shape {
  int base = kFirstResolution;
  int finest = kFirstResolution;
  bool operator==(const Shape&) const = default;
};

// A Load is the work of one direction on a Shape, and the largest lattice variance of an id (latticeVariance).
struct Load {
  double groups = 1, points = 1, variance = 0;  // points: lattice points, or scanlines
  // This is what one line adds to the form factor of the worst id. A run states no standard error below the error of
  // one line.
  double line = 0;
  int finest = 0;  // resolution
};

struct Pilot {
  uint32_t directions = 0;
  Shape shape;
  PilotVariances variances;  // of a replicate of `directions` directions
  Load load;
};

// A Timing is the measured time of a direction on a lattice.
struct Timing {
  Load load;
  double seconds = 0;
};

// A SizeClass has polygons that need about the same resolution.
struct SizeClass {
  double fineness = 0;                    // largest of its ids, as finenessOf() returns them
  double perimeter_per_area_squared = 0;  // largest of its ids, unit-ball units
  double area = 0;                        // share of the area of all polygons
  double least_area = 1;                  // smallest area of its ids, unit-ball units squared
  double radius = 0;                      // largest of its polygons, as boxRadius() returns them
  std::vector<uint32_t> polygons;
};

// Returns the lattice variance of a form factor of an id of area A and perimeter P, if one other id sees all of it:
// docs/method.md, eq. (24). It is the smaller of two values, one for lattices finer than the id, one for coarser
// lattices. With scanlines the first has the 0.0194 of eq. (8), and the second is (4 / A^2) h (A / 2)^(3/2).
//   In: area: A, unit-ball units squared; h: spacing, unit-ball units
double latticeVariance(Sampling sampling, double perimeter_per_area_squared, double area, double h);

// Returns P / A^2 of every id: double[id], in unit-ball units.
std::vector<double> perimetersPerAreaSquared(const Scene& scene, const Ids& ids);

// Returns the resolution that each id needs for the lattice variance of the neediest id: double[id], as fractions of
// that id's resolution.
std::vector<double> finenessOf(const std::vector<double>& perimeters_per_area_squared);

// Returns the resolution for an id. It is fine enough for the id's lattice variance, and gives the id enough points
// over the whole run, which has `directions` directions a replicate.
double neededResolution(Sampling sampling, double fineness, double area, int finest, double directions);

// Returns whether two lattices have the same groups.
bool areAlike(const std::vector<SizeGroup>& a, const std::vector<SizeGroup>& b);

// A Planner makes one plan.
class Planner {
 public:
  Planner(const Scene& scene, const Ids& ids, const EstimateOptions& options, const Lattices& lattices);
  Plan plan(double most_seconds);

 private:
  struct Choice {
    uint32_t directions = 0;
    Shape shape;
    double seconds = 0, variance = INFINITY;
    bool counts_too_large = false;  // every plan that reaches the goal would overflow its sums
  };
  DrawnDirections directionsOf(uint32_t count, uint64_t replicate) const;
  void makeEngine(uint32_t directions, const Shape& shape);
  double timeDirections(uint32_t count);
  void measure(uint32_t directions, const Shape& shape);
  bool takesLonger(const Choice& choice);
  double errorOfVisibilities(const std::vector<PilotCounts>& counted, double measure_area, double count_area) const;
  Choice choose() const;
  Choice choose(bool by_time) const;
  // Returns the most seconds that one pilot may take.
  double allowedSeconds() const { return std::min(kMostPilotSeconds, 0.1 * options_.seconds.value_or(INFINITY)); }
  // Returns the seconds that are left of the given time, less a fifth for making engines.
  double secondsLeft() const { return std::max(0.8 * (*options_.seconds - pilot_seconds_), 0.1 * *options_.seconds); }
  uint32_t mostDirections() const;
  double directionVariance(double directions) const;
  bool isDoubtful(const Choice& choice) const;
  Load loadOf(const Shape& shape, double directions) const;
  double secondsOf(const Load& load) const;
  double secondsOfPilots() const;
  double neededBy(const SizeClass& size, const Shape& shape, double directions) const;
  std::vector<int> resolutionsOf(const Shape& shape, double directions) const;
  size_t windowsOf(const std::vector<int>& resolutions, int base) const;
  bool areCountsTooLarge(const Load& load, double directions, double replicates) const;
  std::vector<SizeGroup> groupsOf(const Shape& shape, double directions) const;

  const Scene& scene_;
  const Ids& ids_;
  const EstimateOptions& options_;
  const Lattices& lattices_;
  std::vector<double> ratios_;                // perimetersPerAreaSquared
  std::vector<double> areas_;                 // by id, unit-ball units squared
  double whole_area_ = 0, largest_face_ = 0;  // area of all ids, and of the largest face, in the same units
  // ranks_ has each id's position in an order that keeps neighbours in space together: uint32_t[id]. Pairs of few lines
  // take their visibility from neighbours in this order (neighbour_visibility.h). It is empty where form factors come
  // from counts alone.
  std::vector<uint32_t> ranks_;
  std::vector<uint32_t> id_of_face_;  // uint32_t[face] where unoccluded form factors are used; else empty
  std::vector<SizeClass> classes_;
  // This is the number of windows by {first size class, end of the size classes, resolution}.
  mutable std::map<std::array<int, 3>, size_t> windows_;
  std::vector<Pilot> pilots_;
  std::vector<Timing> timings_;  // of pilots, and of lattices that were timed alone
  std::vector<SizeGroup> groups_;
  std::unique_ptr<Engine> engine_;
  double pilot_seconds_ = 0;
  uint64_t pilot_replicates_ = 0;
  double most_counts_of_direction_ = 1;  // so far
};

}  // namespace viewpeel

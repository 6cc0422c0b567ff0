// A Planner finds the plan of a run: it times and measures pilots (measure_pilots.cpp), predicts what a lattice costs
// and how its counts vary (lattice_loads.cpp), and chooses (plan.cpp).
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
constexpr uint32_t kPilotReplicates = 8;  // of a pilot
constexpr double kMostPilotSeconds = 30;  // of each pilot

// A Shape is the lattice of a plan: groups at `base` x 4^m, up to the resolution that the neediest polygon gets.
struct Shape {
  int base = kFirstResolution;
  int finest = kFirstResolution;
  bool operator==(const Shape&) const = default;
};

// A Load is the work of a direction, and the lattice variance of the worst id, by latticeVariance.
struct Load {
  double groups = 1, points = 1, variance = 0;  // points, or scanlines
  // This is one line's part in the form factor of the worst id. Standard errors are no less than one line's in the
  // whole run.
  double line = 0;
  int finest = 0;  // resolution
};

struct Pilot {
  uint32_t directions = 0;
  Shape shape;
  PilotVariances variances;  // at this number of directions
  Load load;
};

// A Timing is the measured time of a direction on a lattice.
struct Timing {
  Load load;
  double seconds = 0;
};

// A SizeClass has polygons that need about the same resolution.
struct SizeClass {
  double fineness = 0;
  double perimeter_per_area_squared = 0;
  double area = 0;        // share of all
  double least_area = 1;  // of an id, unit-ball units squared
  double radius = 0;      // of a polygon's box
  std::vector<uint32_t> polygons;
};

// Returns the variance of a form factor of an id of area A and perimeter P, all of which one other id sees:
// docs/method.md, eq. (24). With scanlines it is a quarter of the former, or h times the squared length of a line in
// the id, (A / 2)^(3/2) for a square.
double latticeVariance(Sampling sampling, double perimeter_per_area_squared, double area, double h);

// Returns how many lattice points, or scanlines, of a direction meet an id, on the average: of its mean projection,
// taken for a square.
double expectedPoints(Sampling sampling, double area, double h);

// Returns P / A^2 of ids, in unit-ball units.
std::vector<double> perimetersPerAreaSquared(const Scene& scene, const Ids& ids);

// Returns the resolutions, as fractions of the neediest id's own, at which the lattice variance of every id equals the
// neediest one's.
std::vector<double> finenessOf(const std::vector<double>& perimeters_per_area_squared);

// Returns the resolution for an id: fine enough for its lattice variance, and for enough points in the whole run of
// `directions` a replicate.
double neededResolution(Sampling sampling, double fineness, double area, int finest, double directions);

// Returns whether two lattices have the same groups.
bool areAlike(const std::vector<SizeGroup>& a, const std::vector<SizeGroup>& b);

// A Planner makes one plan.
class Planner {
 public:
  Planner(const Scene& scene, const Ids& ids, const EstimateOptions& options, const Lattices& lattices);
  Plan plan();

 private:
  struct Choice {
    uint32_t directions = 0;
    Shape shape;
    double seconds = 0, variance = INFINITY;
    bool counts_too_large = false;  // of all plans that reach the goal
  };
  DrawnDirections directionsOf(uint32_t count, uint64_t replicate) const;
  void makeEngine(uint32_t directions, const Shape& shape);
  double timeDirections(uint32_t count);
  void measure(uint32_t directions, const Shape& shape);
  bool takesLonger(const Choice& choice);
  double largestErrorOfVisibilities(const std::vector<PilotCounts>& counted, double measure_area,
                                    double count_area) const;
  Choice choose() const;
  Choice choose(bool by_time) const;
  // The directions are a pilot's.
  double allowedSeconds() const { return std::min(kMostPilotSeconds, 0.1 * options_.seconds.value_or(INFINITY)); }
  // The seconds are those left of the given time, with some to spare for making engines.
  double secondsLeft() const { return std::max(0.8 * (*options_.seconds - pilot_seconds_), 0.1 * *options_.seconds); }
  double directionVariance(double directions) const;
  bool isDoubtful(const Choice& choice) const;
  Load loadOf(const Shape& shape, double directions) const;
  double secondsOf(const Load& load) const;
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
  std::vector<double> areas_;                 // of ids, unit-ball units squared
  double whole_area_ = 0, largest_face_ = 0;  // of all ids, of a face; likewise
  // Ranks of ids by place, where form factors are visibilities times unoccluded ones. Few lines are joined by their
  // neighbours' (neighbour_visibility.h).
  std::vector<uint32_t> ranks_;
  std::vector<uint32_t> id_of_face_;  // with unoccluded form factors
  std::vector<SizeClass> classes_;
  mutable std::map<std::array<int, 3>, size_t> windows_;  // of classes from one to another at a resolution
  std::vector<Pilot> pilots_;
  std::vector<Timing> timings_;  // of pilots and trials
  std::vector<SizeGroup> groups_;
  std::unique_ptr<Engine> engine_;
  double pilot_seconds_ = 0;
  uint64_t pilot_replicates_ = 0;
};

}  // namespace viewpeel

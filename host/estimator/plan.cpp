#include "estimator/plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include <glm/geometric.hpp>

#include "directions/random.h"
#include "directions/replicates.h"
#include "engines/engine_factory.h"
#include "engines/lattice.h"
#include "estimator/pilot_variances.h"
#include "estimator/find_prior.h"
#include "scene/perimeter.h"
#include "sums/neighbour_visibility.h"
#include "sums/pair_count.h"
#include "scene/rank_by_place.h"
#include "stopwatch.h"

namespace viewpeel {
namespace {

constexpr uint32_t kPilotReplicates = 8, kFirstDirections = 16,
                   kPilotDirections = 32;  // of the first pilot, and of others at least
constexpr int kFirstResolution = 64;
constexpr double kFewPoints = 5;  // of an id in the whole run, below which no line may hit it
constexpr double kLatticePoints = 100, kUsualReplicates = 8;  // every id gets this many points in this many replicates
constexpr double kDefaultTolerance = 1e-3;
// Of the most counts: along some directions there are more than the average.
constexpr double kAllowed = 0.8;
// A plan takes at most this many replicates to a goal that other choices reach with fewer.
constexpr double kMostReplicates = 128;
constexpr double kMostPoints = 8192.0 * 8192, kMostScanlines = 4 * 8192;  // of a direction
constexpr double kMostPilotSeconds = 30;                                  // of each pilot
constexpr uint32_t kTimedDirections = 4;                                  // that time a lattice
// A lattice needs no trial up to this multiple of the points that were timed, and of the expected seconds.
constexpr double kMostBeyond = 4;
constexpr int kMostTrials = 4;
// A pilot confirms a predicted variance whose standard error is beyond this multiple of it.
constexpr double kMostDoubt = 4;

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

// Returns the variance of a form factor of an id of area A and perimeter P, all of which one other id sees:
// docs/method.md, eq. (24). With scanlines it is a quarter of the former, or h times the squared length of a line in
// the id, (A / 2)^(3/2) for a square.
double latticeVariance(Sampling sampling, double perimeter_per_area_squared, double area, double h) {
  if (sampling == Sampling::scanline)
    return std::min(0.061 * h * h * h * perimeter_per_area_squared, std::numbers::sqrt2 * h / std::sqrt(area));
  return std::min(0.229 * h * h * h * perimeter_per_area_squared, 2 * h * h / area);
}

// Returns how many lattice points, or scanlines, of a direction meet an id, on the average: of its mean projection,
// taken for a square.
double expectedPoints(Sampling sampling, double area, double h) {
  return sampling == Sampling::scanline ? std::sqrt(area / 2) / h : area / 2 / (h * h);
}

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

// Returns P / A^2 of ids, in unit-ball units.
std::vector<double> perimetersPerAreaSquared(const Scene& scene, const Ids& ids) {
  std::vector<double> ratios(ids.count(), 0);
  for (size_t k = 0; k < scene.polygons.size(); ++k) ratios[ids.of_polygon[k]] += perimeterOf(scene, scene.polygons[k]);
  for (uint32_t id = 0; id < ids.count(); ++id) ratios[id] /= std::pow(ids.areas[id] / (scene.scale * scene.scale), 2);
  return ratios;
}

// Returns the resolutions, as fractions of the neediest id's own, at which the lattice variance of every id equals the
// neediest one's.
std::vector<double> finenessOf(const std::vector<double>& perimeters_per_area_squared) {
  const double most = *std::max_element(perimeters_per_area_squared.begin(), perimeters_per_area_squared.end());
  std::vector<double> fineness;
  for (double ratio : perimeters_per_area_squared) fineness.push_back(std::cbrt(ratio / most));
  return fineness;
}

// Returns the resolution for an id: fine enough for its lattice variance, and for enough points in the whole run of
// `directions` a replicate.
double neededResolution(Sampling sampling, double fineness, double area, int finest, double directions) {
  const double times =
      expectedPoints(sampling, area, 2) * kUsualReplicates * directions;  // on a lattice of one spacing across
  return std::max(fineness * finest,
                  sampling == Sampling::scanline ? kLatticePoints / times : std::sqrt(kLatticePoints / times));
}

bool areAlike(const std::vector<SizeGroup>& a, const std::vector<SizeGroup>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const SizeGroup& x, const SizeGroup& y) {
    return x.resolution == y.resolution && x.polygons == y.polygons;
  });
}

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

Planner::Planner(const Scene& scene, const Ids& ids, const EstimateOptions& options, const Lattices& lattices)
    : scene_(scene), ids_(ids), options_(options), lattices_(lattices), ratios_(perimetersPerAreaSquared(scene, ids)) {
  const std::vector<double> fineness = finenessOf(ratios_);
  for (double area : ids.areas) {
    areas_.push_back(area / (scene.scale * scene.scale));
    whole_area_ += areas_.back();
  }
  std::map<int, SizeClass> classes;
  for (size_t k = 0; k < scene.polygons.size(); ++k) {
    const uint32_t id = ids.of_polygon[k];
    SizeClass& size = classes[static_cast<int>(std::ceil(4 * std::log2(fineness[id])))];
    size.fineness = std::max(size.fineness, fineness[id]);
    size.perimeter_per_area_squared = std::max(size.perimeter_per_area_squared, ratios_[id]);
    size.area += scene.polygons[k].area / whole_area_;
    size.least_area = std::min(size.least_area, areas_[id]);
    size.radius = std::max(size.radius, boxRadius(scene, static_cast<uint32_t>(k)));
    size.polygons.push_back(static_cast<uint32_t>(k));
  }
  std::vector<double> faces(scene.faces.size(), 0);
  for (const Polygon& polygon : scene.polygons)
    largest_face_ = std::max(largest_face_, faces[polygon.face] += polygon.area);
  for (const auto& [key, size] : classes) classes_.push_back(size);
  if (lattices.face_ids) {
    id_of_face_.resize(lattices.face_ids->count());
    for (uint32_t k = 0; k < scene.polygons.size(); ++k)
      id_of_face_[lattices.face_ids->of_polygon[k]] = ids.of_polygon[k];
  }
  if (lattices.face_ids && options.by == By::polygon && !options.relative && pairCount(ids.count()) <= kMostRowPairs)
    ranks_ = rankByPlace(scene, ids.of_polygon, ids.count());
}

DrawnDirections Planner::directionsOf(uint32_t count, uint64_t replicate) const {
  DrawnDirections drawn =
      options_.drawn_directions
          ? options_.drawn_directions(count, replicate)
          : DrawnDirections{sampleDirections(options_.sampler, count, options_.seed, replicate), {}, 1};
  for (size_t k = 0; k < drawn.weights.size(); ++k) drawn.directions[k].weight = drawn.weights[k];
  return drawn;
}

double Planner::neededBy(const SizeClass& size, const Shape& shape, double directions) const {
  return neededResolution(lattices_.lattice.sampling, size.fineness, size.least_area, shape.finest, directions);
}

std::vector<SizeGroup> Planner::groupsOf(const Shape& shape, double directions) const {
  if (lattices_.may_group)
    return planGroups(scene_, ids_, lattices_.lattice.sampling, shape.base, shape.finest, directions);
  return groupAsOne(scene_, shape.base);
}

void Planner::makeEngine(uint32_t directions, const Shape& shape) {
  auto groups = groupsOf(shape, directions);
  if (engine_ && areAlike(groups, groups_)) return;
  engine_.reset();
  groups_ = std::move(groups);
  engine_ = viewpeel::makeEngine(lattices_, scene_, ids_, groups_);
  // The first count compiles and tunes kernels.
  engine_->count(directionsOf(4, kTrialReplicates.end - 1).directions);
}

// The time is of `directions` directions.
double Planner::timeDirections(uint32_t count) {
  const auto start = Clock::now();
  engine_->count(directionsOf(count, kTrialReplicates.end - 2).directions);
  return secondsSince(start);
}

// Tries a lattice that is much finer than all timed lattices. Points of windows and of the whole scene, hit or not, do
// not all take the same time. The difference of two calls leaves out the fixed time of a call. The smaller of two
// trials leaves out the delay of a busy machine.
bool Planner::takesLonger(const Choice& choice) {
  const auto start = Clock::now();
  const Load load = loadOf(choice.shape, choice.directions);
  for (const Timing& timing : timings_)
    if (load.points < kMostBeyond * timing.load.points && load.finest < kMostBeyond * timing.load.finest &&
        load.groups <= timing.load.groups)
      return false;
  makeEngine(choice.directions, choice.shape);
  // The engine compiles here whatever it changed after its first count.
  timeDirections(kTimedDirections);
  const double most = kMostBeyond * secondsOf(load);
  double each = INFINITY;
  for (int trial = 0; trial < 2 && each > most; ++trial) {
    const double few = timeDirections(kTimedDirections);
    each = std::min(each, std::max(timeDirections(3 * kTimedDirections) - few, 0.0) / (2 * kTimedDirections));
  }
  if (each > most) timings_.push_back({load, each});
  pilot_seconds_ += secondsSince(start);
  return each > most;
}

void Planner::measure(uint32_t directions, const Shape& shape) {
  const auto begun = Clock::now();
  makeEngine(directions, shape);
  if (pilots_.empty())
    directions = static_cast<uint32_t>(
        std::clamp(allowedSeconds() / (2 * kPilotReplicates * timeDirections(2) / 2), 1.0, double(directions)));
  // The counts are of both lattices and every replicate.
  std::vector<PilotCounts> counted;
  double weight_unit = 1;
  const auto start = Clock::now();
  for (uint32_t r = 0; r < kPilotReplicates; ++r) {
    DrawnDirections drawn = directionsOf(directions, kPlanReplicates.first + pilot_replicates_);
    weight_unit = drawn.weight_unit;
    counted.push_back({engine_->count(drawn.directions), {}});
    Random random(options_.seed, kPlanLatticeReplicates.first + pilot_replicates_++);
    for (Direction& direction : drawn.directions) {
      const uint32_t weight = direction.weight;
      direction = directionAlong(direction.u, random);
      direction.weight = weight;
    }
    counted.back().second = engine_->count(drawn.directions);
  }
  const double seconds = secondsSince(start);

  const double measure_area = engine_->unitArea() * scene_.scale * scene_.scale / directions * weight_unit;
  Pilot pilot{directions, shape, pilotVariances(counted, ids_, id_of_face_, measure_area, options_),
              loadOf(shape, directions)};
  if (!ranks_.empty()) {
    // Both variances use the visibilities of the pilot, and are scaled to the run's own standard error.
    const double count_area = ids_.requested.empty() ? measure_area * directions / 2 : INFINITY,
                 stated =
                     std::pow(largestErrorOfVisibilities(counted, measure_area / 2, count_area), 2) * kPilotReplicates;
    // A direction counts on two lattices, and each has half of the variance.
    const double found = pilot.variances.of_directions + pilot.variances.of_lattices / 2;
    if (found > 0)
      for (double* variance : {&pilot.variances.of_directions, &pilot.variances.of_lattices, &pilot.variances.doubt})
        *variance *= stated / found;
  }
  pilot_seconds_ += secondsSince(begun);
  pilots_.push_back(pilot);
  timings_.push_back({pilot.load, seconds / (2 * kPilotReplicates * directions)});
}

// Returns the largest standard error that the run would state after the pilot. Pairs that few lines hit have the
// standard error of their own lines and their neighbours'. Unoccluded form factors are the lines' own counts.
double Planner::largestErrorOfVisibilities(const std::vector<PilotCounts>& counted, double measure_area,
                                           double count_area) const {
  VisibilitySums sums(ids_);
  PairCounts all;
  for (const PilotCounts& replicate : counted) all = addCounts(addCounts(all, replicate.first), replicate.second);
  const std::vector<PairVisibility> seen = fitVisibilities(withRows(std::move(all)));
  for (const PilotCounts& replicate : counted) sums.add(withRows(addCounts(replicate.first, replicate.second), seen));
  std::vector<PairPrior> prior;
  for (const VisibilitySums::PairSum& pair : sums.pairs())
    if (pair.i != pair.j && (pair.j < kEnvironment || pair.facing > 0))
      prior.push_back({pair.i, pair.j, 0, 0,
                       pair.j < kEnvironment
                           ? 2 * measure_area * double(pair.facing + pair.blocked) / double(counted.size())
                           : INFINITY});
  const std::vector<uint64_t> lines = countsOfLines(ids_, groups_, engine_->unitArea());
  const NeighbourVisibility neighbours(sums, lines, ranks_);
  return largestStandardError(
      {ids_, sums.find(prior, lines, measure_area, count_area, {}, {}, &neighbours).entries, {}});
}

double Planner::directionVariance(double directions) const {
  const Pilot& last = pilots_.back();
  double exponent = options_.sampler == Sampler::iid && !options_.drawn_directions ? 1 : 2;
  for (const Pilot& pilot : pilots_)
    if (pilot.directions * 3 <= last.directions && pilot.variances.of_directions > 0 &&
        last.variances.of_directions > 0)
      exponent = std::clamp(std::log(pilot.variances.of_directions / last.variances.of_directions) /
                                std::log(double(last.directions) / pilot.directions),
                            1.0, 3.0);
  return last.variances.of_directions * std::pow(last.directions / directions, exponent);
}

// Returns whether the predicted variance is of lattices alone, which hid the directions' in the pilot. Then its
// lattices hardly hit pairs that the plan's own hit often.
bool Planner::isDoubtful(const Choice& choice) const {
  const Pilot& last = pilots_.back();
  return last.variances.doubt * std::pow(last.directions / double(choice.directions), 2) / double(options_.replicates) >
         kMostDoubt * choice.variance;
}

Load Planner::loadOf(const Shape& shape, double directions) const {
  const bool is_scanline = lattices_.lattice.sampling == Sampling::scanline;
  Load load{1, is_scanline ? double(shape.base) : double(shape.base) * shape.base};
  std::map<double, double> fine;  // share of the area by resolution
  const std::vector<int> resolutions = resolutionsOf(shape, directions);
  load.finest = *std::max_element(resolutions.begin(), resolutions.end());
  for (size_t k = 0; k < classes_.size(); ++k) {
    const SizeClass& size = classes_[k];
    const double resolution = resolutions[k];
    if (resolution > shape.base) fine[resolution] += size.area;
    load.variance = std::max(load.variance, latticeVariance(lattices_.lattice.sampling, size.perimeter_per_area_squared,
                                                            size.least_area, 2 / resolution));
    // A direction adds half of what it counts together with others (replicate_sums.cpp).
    if (ranks_.empty()) load.line = std::max(load.line, 8 / (resolution * resolution * size.least_area) + 8 / 27.0);
  }
  // A window reaches beyond its polygons.
  for (const auto& [resolution, share] : fine)
    load.points += (is_scanline ? resolution : resolution * resolution) * std::min(1.0, 2 * share);
  load.groups += double(windowsOf(resolutions, shape.base));
  return load;
}

// Returns the resolutions that groupBySize makes of the classes: no finer than windows can be, and with no more windows
// than there may be.
std::vector<int> Planner::resolutionsOf(const Shape& shape, double directions) const {
  std::vector<int> resolutions(classes_.size(), shape.base);
  for (int finest = maxWindowResolution(lattices_.lattice.sampling); lattices_.may_group; finest /= kGroupStep) {
    bool is_fine = false;
    for (size_t k = 0; k < classes_.size(); ++k) {
      int& resolution = resolutions[k] = shape.base;
      const double needed = neededBy(classes_[k], shape, directions) * kEnough;
      while (resolution < needed && resolution <= finest / kGroupStep &&
             classes_[k].radius * resolution * kGroupStep <= kMostWindowPoints)
        resolution *= kGroupStep;
      is_fine = is_fine || resolution > shape.base;
    }
    if (!is_fine || windowsOf(resolutions, shape.base) <= kMostWindows) break;
  }
  return resolutions;
}

// Returns the number of windows beside the whole scene's lattice. Classes of one resolution are taken to follow each
// other.
size_t Planner::windowsOf(const std::vector<int>& resolutions, int base) const {
  size_t windows = 0;
  for (size_t first = 0, end = 0; first < resolutions.size(); first = end) {
    for (end = first; end < resolutions.size() && resolutions[end] == resolutions[first];) ++end;
    if (resolutions[first] == base) continue;
    size_t& count = windows_[{static_cast<int>(first), static_cast<int>(end), resolutions[first]}];
    if (count == 0) {
      std::vector<uint32_t> polygons;
      for (size_t k = first; k < end; ++k)
        polygons.insert(polygons.end(), classes_[k].polygons.begin(), classes_[k].polygons.end());
      count = countWindows(scene_, std::move(polygons), resolutions[first]);
    }
    windows += count;
  }
  return windows;
}

// Returns whether counts are too large for unoccluded form factors. It looks at the counts of a row in a replicate, the
// sum over a surface's faces, and the squares over all replicates (control_variate_sums.h). A face's projection is half
// of its area on the average.
bool Planner::areCountsTooLarge(const Load& load, double directions, double replicates) const {
  if (id_of_face_.empty()) return false;
  const double count_area =
      pointArea(load.finest) / (lattices_.lattice.sampling == Sampling::scanline ? 1 << kScanlineBits : 1);
  const double of_row = directions * largest_face_ / 2 / count_area, of_all = directions * whole_area_ / 2 / count_area,
               most = kAllowed * double(kMostCounts);
  return of_row > most || of_all > 2 * most || replicates * of_row * of_row > 8 * most * most;
}

// Returns the time of a direction. It costs something for every group, and for every lattice point over the group's
// polygons. Where pilots cannot part the two, each gets half.
double Planner::secondsOf(const Load& load) const {
  const Timing& last = timings_.back();
  double per_group = 0.5 * last.seconds / last.load.groups, per_point = 0.5 * last.seconds / last.load.points;
  for (const Timing& timing : timings_) {
    const double determinant = timing.load.groups * last.load.points - last.load.groups * timing.load.points;
    if (std::abs(determinant) < 0.5 * timing.load.groups * last.load.points) continue;
    per_point = std::clamp((timing.load.groups * last.seconds - last.load.groups * timing.seconds) / determinant, 0.0,
                           last.seconds / last.load.points);
    per_group = (last.seconds - per_point * last.load.points) / last.load.groups;
  }
  return per_group * load.groups + per_point * load.points;
}

// Chooses the least time to the goal; the least error in the time there is, where there is no goal or no time for it.
Planner::Choice Planner::choose() const {
  const Choice choice = choose(options_.seconds && !options_.tolerance && !options_.relative);
  return options_.seconds && choice.seconds > secondsLeft() ? choose(true) : choice;
}

Planner::Choice Planner::choose(bool by_time) const {
  const double replicates = double(options_.replicates);
  double goal = kDefaultTolerance;
  if (options_.tolerance) goal = *options_.tolerance;
  else if (options_.relative) goal = *options_.relative;
  double least_area = 1;
  for (const SizeClass& size : classes_) least_area = std::min(least_area, size.least_area);

  // Where no choice is quick enough, the quickest is taken. Where no error is small enough, the choice is the one that
  // gets there first with more replicates, if they are not too many.
  const auto meets = [&](const Choice& c) { return by_time ? c.seconds <= secondsLeft() : c.variance <= goal * goal; };
  const auto rankOf = [&](const Choice& c) {
    if (meets(c)) return 0;
    return !by_time && c.variance * replicates <= goal * goal * kMostReplicates ? 1 : 2;
  };
  const auto costOf = [&](const Choice& c) {
    if (by_time) return meets(c) ? c.variance : c.seconds;
    return meets(c) ? c.seconds : c.seconds * c.variance;
  };
  Choice best;
  bool is_limited = false;
  for (int n = 8; n <= 48; ++n) {
    const auto directions = static_cast<uint32_t>(std::lround(std::pow(2.0, n / 2.0)));
    const double in_all = directions * replicates;
    for (int f = lattices_.resolution ? 40 : 8; f <= 40; ++f) {
      const int finest =
          lattices_.resolution ? lattices_.resolution : static_cast<int>(std::lround(std::pow(2.0, f / 2.0)));
      for (int step = 1; step == 1 || (lattices_.may_group && finest / step >= 8); step *= kGroupStep) {
        const Shape shape{(finest + step - 1) / step, finest};
        if (shape.base > kMaxResolution) continue;
        // One lattice serves all: fine enough for the least of them, or as fine as there is.
        if (!lattices_.may_group && !lattices_.resolution &&
            finest < std::min(neededBy({1, 0, 0, least_area}, shape, directions), kMaxResolution / 1.5))
          continue;
        const Load load = loadOf(shape, directions);
        if (load.points > (lattices_.lattice.sampling == Sampling::scanline ? kMostScanlines : kMostPoints) &&
            best.directions)
          continue;
        const Choice choice{directions, shape, secondsOf(load) * in_all,
                            (directionVariance(directions) + pilots_.back().variances.of_lattices * load.variance /
                                                                 pilots_.back().load.variance *
                                                                 pilots_.back().directions / directions) /
                                    replicates +
                                std::pow(load.line / in_all, 2)};
        if (best.directions &&
            areCountsTooLarge(load, directions,
                              std::max(replicates, by_time ? 0 : replicates * choice.variance / (goal * goal)))) {
          is_limited = true;
          continue;
        }
        const bool is_better =
            rankOf(choice) != rankOf(best) ? rankOf(choice) < rankOf(best) : costOf(choice) < costOf(best);
        if (best.directions == 0 || is_better) best = choice;
      }
    }
  }
  best.counts_too_large = is_limited && !by_time && rankOf(best) == 2;
  return best;
}

Plan Planner::plan() {
  const int first = lattices_.resolution ? lattices_.resolution : kFirstResolution;
  measure(kFirstDirections, {first, first});
  Choice choice = choose();
  // Another pilot, nearer to the plan, counts where it costs little beside the run, or where a variance cannot be had
  // without it.
  for (int more = 0; more < 2; ++more) {
    const Pilot& last = pilots_.back();
    const double share = 0.03 * double(options_.replicates) / kPilotReplicates;
    const double most =
        allowedSeconds() / (2 * kPilotReplicates * choice.seconds / (choice.directions * double(options_.replicates)));
    const auto directions =
        static_cast<uint32_t>(std::clamp(std::min(share * choice.directions, most), double(kPilotDirections), 1e6));
    const bool is_doubtful = isDoubtful(choice);
    if (!is_doubtful && directions < 3 * last.directions &&
        std::max(choice.shape.finest, last.shape.finest) <= 2 * std::min(choice.shape.finest, last.shape.finest))
      break;
    if ((!is_doubtful && choice.seconds < 10 * pilot_seconds_) || std::max(directions, last.directions) > 2 * most)
      break;
    measure(std::max(directions, last.directions), choice.shape);
    choice = choose();
  }
  for (int trial = 0; trial < kMostTrials && takesLonger(choice); ++trial) choice = choose();
  Plan plan;
  plan.directions = choice.directions;
  plan.finest = choice.shape.finest;
  plan.groups = groupsOf(choice.shape, choice.directions);
  plan.seconds = choice.seconds;
  plan.standard_error = std::sqrt(choice.variance);
  plan.pilot_seconds = pilot_seconds_;
  plan.counts_too_large = choice.counts_too_large;
  std::vector<double> points(ids_.count(), 0);
  for (const SizeGroup& group : plan.groups)
    for (uint32_t k : group.polygons)
      points[ids_.of_polygon[k]] +=
          expectedPoints(lattices_.lattice.sampling, scene_.polygons[k].area, 2.0 / group.resolution) *
          choice.directions * double(options_.replicates);
  for (uint32_t id = 0; id < ids_.count(); ++id)
    if (!options_.drawn_directions && points[id] < kFewPoints) plan.barely_covered.push_back(id);
  if (!areAlike(plan.groups, groups_)) {
    engine_.reset();
    engine_ = viewpeel::makeEngine(lattices_, scene_, ids_, plan.groups);
  }
  plan.engine = std::move(engine_);
  return plan;
}

}  // namespace

std::unique_ptr<Engine> makeEngine(const Lattices& lattices, const Scene& scene, const Ids& ids,
                                   const std::vector<SizeGroup>& groups) {
  return makeEngine(lattices.make_engine, scene, lattices.face_ids ? *lattices.face_ids : ids, lattices.lattice,
                    groups);
}

std::vector<SizeGroup> planGroups(const Scene& scene, const Ids& ids, Sampling sampling, int base, int finest,
                                  double directions) {
  const std::vector<double> fineness = finenessOf(perimetersPerAreaSquared(scene, ids));
  std::vector<double> needed;
  for (uint32_t id : ids.of_polygon)
    needed.push_back(
        neededResolution(sampling, fineness[id], ids.areas[id] / (scene.scale * scene.scale), finest, directions));
  return groupBySize(scene, needed, base, maxWindowResolution(sampling));
}

Plan planEstimate(const Scene& scene, const Ids& ids, const EstimateOptions& options, const Lattices& lattices) {
  return Planner(scene, ids, options, lattices).plan();
}

}  // namespace viewpeel

// This file counts the pilots of a planner. They give it the time of a direction and the variances of form factors.
#include "directions/random.h"
#include "directions/replicates.h"
#include "engines/lattice.h"
#include "estimator/find_prior.h"
#include "estimator/planner.h"
#include "hash.h"
#include "stopwatch.h"
#include "sums/neighbour_visibility.h"
#include "sums/pair_count.h"

namespace viewpeel {
namespace {

constexpr uint32_t kTimedDirections = 4;  // directions counted to time a lattice
// A lattice with up to this multiple of the points of a timed lattice is not timed again. A timed lattice is rejected
// beyond this multiple of its predicted seconds.
constexpr double kMostBeyond = 4;
constexpr double kBytesOfPair = 300;  // in pilotVariances

// Keeps one pair of so many, the same pairs of every replicate, and all environment and leak.
void thin(PairCounts& counts, double one_pair_of) {
  if (!(one_pair_of > 1)) return;
  std::erase_if(counts, [&](const PairCount& count) {
    Hash hash;
    hash.add((uint64_t(count.i) << 32) + count.j);
    return count.j < kEnvironment && hash.value() % static_cast<uint64_t>(one_pair_of) != 0;
  });
  counts.shrink_to_fit();
}

}  // namespace

bool areAlike(const std::vector<SizeGroup>& a, const std::vector<SizeGroup>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const SizeGroup& x, const SizeGroup& y) {
    return x.resolution == y.resolution && x.polygons == y.polygons;
  });
}

DrawnDirections Planner::directionsOf(uint32_t count, uint64_t replicate) const {
  DrawnDirections drawn =
      options_.drawn_directions
          ? options_.drawn_directions(count, replicate)
          : DrawnDirections{sampleDirections(options_.sampler, count, options_.seed, replicate), {}, 1};
  for (size_t k = 0; k < drawn.weights.size(); ++k) drawn.directions[k].weight = drawn.weights[k];
  return drawn;
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

// Returns the seconds that the engine takes to count this many directions.
double Planner::timeDirections(uint32_t count) {
  const auto start = Clock::now();
  engine_->count(directionsOf(count, kTrialReplicates.end - 2).directions);
  return secondsSince(start);
}

// Times a lattice that is much finer than every timed lattice, and returns whether it takes longer than predicted. The
// prediction may fail because the time of a lattice point depends on its window, and on whether a polygon covers it.
// The difference of two calls removes the fixed time of a call. The smaller of two trials removes most of a busy
// machine's delays.
bool Planner::takesLonger(const Choice& choice) {
  if (lattices_.costs) return false;
  const auto start = Clock::now();
  const Load load = loadOf(choice.shape, choice.directions);
  for (const Timing& timing : timings_)
    if (load.points < kMostBeyond * timing.load.points && load.finest < kMostBeyond * timing.load.finest &&
        load.groups <= timing.load.groups)
      return false;
  makeEngine(choice.directions, choice.shape);
  // This call is not timed: the engine may still compile or tune its kernels.
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
  if (pilots_.empty()) {
    const double each = lattices_.costs ? secondsOf(loadOf(shape, directions)) : timeDirections(2) / 2;
    directions =
        static_cast<uint32_t>(std::clamp(allowedSeconds() / (2 * kPilotReplicates * each), 1.0, double(directions)));
  }
  // Each replicate counts the same directions on two lattices.
  std::vector<PilotCounts> counted;
  double weight_unit = 1, one_pair_of = 1;
  const auto start = Clock::now();
  for (uint32_t r = 0; r < kPilotReplicates; ++r) {
    DrawnDirections drawn = directionsOf(directions, kPlanReplicates.first + pilot_replicates_);
    weight_unit = drawn.weight_unit;
    counted.push_back({engine_->count(drawn.directions), {}});
    const double counts = double(counted.back().first.size());
    most_counts_of_direction_ = std::max(most_counts_of_direction_, counts / directions);
    if (r == 0)
      one_pair_of = std::ceil(
          std::max(1.0, 2 * kPilotReplicates * counts * kBytesOfPair / (options_.most_counts * sizeof(PairCount))));
    thin(counted.back().first, one_pair_of);
    Random random(options_.seed, kPlanLatticeReplicates.first + pilot_replicates_++);
    for (Direction& direction : drawn.directions) {
      const uint32_t weight = direction.weight;
      direction = directionAlong(direction.u, random);
      direction.weight = weight;
    }
    counted.back().second = engine_->count(drawn.directions);
    thin(counted.back().second, one_pair_of);
  }
  const double seconds = secondsSince(start);

  const double measure_area = engine_->unitArea() * scene_.scale * scene_.scale / directions * weight_unit;
  Pilot pilot{directions, shape, pilotVariances(counted, ids_, id_of_face_, measure_area, options_),
              loadOf(shape, directions)};
  if (!ranks_.empty()) {
    // The run's standard error comes from visibilities times unoccluded form factors. Both variances are scaled so that
    // they add up to it.
    const double count_area = ids_.requested.empty() ? measure_area * directions / 2 : INFINITY,
                 stated = std::pow(errorOfVisibilities(counted, measure_area / 2, count_area), 2) * kPilotReplicates;
    // A replicate of the pilot is a mean over two lattices, which halves the lattice variance.
    const double found = pilot.variances.of_directions + pilot.variances.of_lattices / 2;
    if (found > 0)
      for (double* variance : {&pilot.variances.of_directions, &pilot.variances.of_lattices, &pilot.variances.doubt})
        *variance *= stated / found;
  }
  pilot_seconds_ += secondsSince(begun);
  pilots_.push_back(pilot);
  timings_.push_back({pilot.load, seconds / (2 * kPilotReplicates * directions)});
}

// Returns the largest standard error, or the root mean square of all, that the run would state after the counts of the
// pilot. As in the run, the error of a pair of few lines rests on its own lines and its neighbours'. The pilot has no
// unoccluded form factors, and takes the pair's counts, facing and blocked, in their place.
double Planner::errorOfVisibilities(const std::vector<PilotCounts>& counted, double measure_area,
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
  const FormFactors found(ids_, sums.find(prior, lines, measure_area, count_area, {}, {}, &neighbours).entries, {});
  return options_.rms ? measureStandardErrors(found, 0).rms_with_zeros : largestStandardError(found);
}

// Returns the most directions of a replicate.
uint32_t Planner::mostDirections() const {
  return static_cast<uint32_t>(std::clamp(options_.most_counts / most_counts_of_direction_, 1.0, 1e9));
}

double Planner::directionVariance(double directions) const {
  const Pilot& last = pilots_.back();
  const double more = directions / last.directions;
  const bool is_iid = options_.sampler == Sampler::iid && !options_.drawn_directions;
  return last.variances.of_directions * (is_iid ? 1 / more : varianceLeft(last.variances, more));
}

}  // namespace viewpeel

#include "estimator/plan.h"

#include "engines/engine_factory.h"
#include "engines/lattice.h"
#include "estimator/planner.h"

namespace viewpeel {
namespace {

constexpr uint32_t kLeastPilotDirections = 16;  // of the first pilot; least of a further pilot
// An id that gets fewer lattice points, or scanlines, than this in the whole run is reported: no line may hit it.
constexpr double kFewPoints = 5;
constexpr double kDefaultTolerance = 1e-3;
// A choice that needs more replicates than the request has is accepted up to this number.
constexpr double kMostReplicates = 128;
constexpr double kMostPoints = 8192.0 * 8192, kMostScanlines = 4 * 8192;  // of a direction
constexpr int kMostTrials = 4;
// A predicted variance is doubtful where its standard error is above this multiple of it. Another pilot then checks it.
constexpr double kMostDoubt = 4;

}  // namespace

// Returns whether the predicted variance is doubtful: the pilot's lattices varied so much that they hid the variance of
// directions. This happens where the pilot's coarse lattices hardly hit pairs that the plan's lattices hit often.
bool Planner::isDoubtful(const Choice& choice) const {
  const Pilot& last = pilots_.back();
  return last.variances.doubt * std::pow(last.directions / double(choice.directions), 2) / double(options_.replicates) >
         kMostDoubt * choice.variance;
}

// Returns the choice that reaches the goal in the least time. If only a time is given, or the goal takes longer than
// that time, it returns the choice with the least error in the time.
Planner::Choice Planner::choose() const {
  const Choice choice = choose(options_.seconds && !options_.hasErrorGoal());
  return options_.seconds && choice.seconds > secondsLeft() ? choose(true) : choice;
}

Planner::Choice Planner::choose(bool by_time) const {
  const double replicates = double(options_.replicates);
  double goal = kDefaultTolerance;
  if (options_.tolerance) goal = *options_.tolerance;
  else if (options_.relative) goal = *options_.relative;
  else if (options_.rms) goal = *options_.rms;
  double least_area = 1;
  for (const SizeClass& size : classes_) least_area = std::min(least_area, size.least_area);

  // Where no choice meets the time, the quickest wins. Where no choice meets the error with the replicates of the
  // request, the choice wins that reaches it first with up to kMostReplicates.
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
    if (best.directions && directions > mostDirections()) continue;
    const double in_all = directions * replicates;
    for (int f = lattices_.resolution ? 40 : 8; f <= 40; ++f) {
      const int finest =
          lattices_.resolution ? lattices_.resolution : static_cast<int>(std::lround(std::pow(2.0, f / 2.0)));
      for (int step = 1; step == 1 || (lattices_.may_group && finest / step >= 8); step *= kGroupStep) {
        const Shape shape{(finest + step - 1) / step, finest};
        if (shape.base > kMaxResolution) continue;
        // Without groups one lattice has to be fine enough for the smallest polygon, or the finest there is.
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

Plan Planner::plan(double most_seconds) {
  const int first = lattices_.resolution ? lattices_.resolution : kFirstResolution;
  measure(kLeastPilotDirections, {first, first});
  Choice choice = choose();
  Plan plan;
  // A further pilot, whose lattice is nearer to the plan's, is counted where it costs little beside the run, or where
  // the predicted variance is doubtful.
  for (int more = 0; more < 2; ++more) {
    if (choice.seconds > most_seconds) return plan;
    const Pilot& last = pilots_.back();
    const double share = 0.03 * double(options_.replicates) / kPilotReplicates;
    const double most =
        allowedSeconds() / (2 * kPilotReplicates * choice.seconds / (choice.directions * double(options_.replicates)));
    const auto directions = static_cast<uint32_t>(
        std::clamp(std::min(share * choice.directions, most), double(kLeastPilotDirections), 1e6));
    const bool is_doubtful = isDoubtful(choice);
    if (!is_doubtful && directions < 3 * last.directions &&
        std::max(choice.shape.finest, last.shape.finest) <= 2 * std::min(choice.shape.finest, last.shape.finest))
      break;
    if ((!is_doubtful && choice.seconds < 10 * secondsOfPilots()) || std::max(directions, last.directions) > 2 * most)
      break;
    measure(std::max(directions, last.directions), choice.shape);
    choice = choose();
  }
  for (int trial = 0; trial < kMostTrials && takesLonger(choice); ++trial) choice = choose();
  if (choice.seconds > most_seconds) return plan;
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

std::unique_ptr<Engine> makeEngine(const Lattices& lattices, const Scene& scene, const Ids& ids,
                                   const std::vector<SizeGroup>& groups) {
  return makeEngine(lattices.make_engine, scene, lattices.face_ids ? *lattices.face_ids : ids, lattices.lattice,
                    groups);
}

Plan planEstimate(const Scene& scene, const Ids& ids, const EstimateOptions& options, const Lattices& lattices,
                  double most_seconds) {
  return Planner(scene, ids, options, lattices).plan(most_seconds);
}

}  // namespace viewpeel

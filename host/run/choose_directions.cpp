// This file decides whether common directions alone count the form factors between surfaces, or rays alone. A surface
// of many polygons meets many lines of every direction, so that it may need fewer directions than there are pairs of
// polygons to find. A small surface, such as a sensor in a city, needs fewer rays of its own than directions.

#include "estimator/plan_lines.h"
#include "run/run_state.h"
#include "threads.h"

namespace viewpeel {
namespace {

// Processor seconds of a direction: for each group of polygons, for each polygon of the scene in each group, and for
// each lattice point or scanline. Offices, rooms and cities of 2,320 to 19,994 polygons took 0.8 to 1.4 times as long.
constexpr double kSecondsOfGroup = 1e-4, kSecondsOfPolygon = 2e-8, kSecondsOfPoint = 1.5e-8, kSecondsOfScanline = 2e-6;
// The number of directions that the planner's first pilot counts. It is counted only where lines may take at least
// kPilotsInLines times as long.
constexpr double kPilotDirectionsInAll = 256, kPilotsInLines = 10;
// A pilot of rays is cast only where the directions take longer than it does together with this share of the guess.
constexpr double kLeastOfGuess = 2.0 / 3;
// Rays keep a sum for each pair of polygons that they meet, 72 bytes; directions keep one for each pair of surfaces.
// With more polygons than these, of at least 128 rays each, sums could take 2 GB or more.
constexpr size_t kMostPolygonsOfRays = 200'000;

DirectionCosts costsOf(const Scene& scene, Sampling sampling) {
  return {kSecondsOfGroup + double(scene.polygons.size()) * kSecondsOfPolygon,
          sampling == Sampling::scanline ? kSecondsOfScanline : kSecondsOfPoint};
}

}  // namespace

// Decides whether common directions alone count, in an estimate between surfaces. The decision depends on the scene and
// the seed, not on measured times.
//   Out: why pairs have no lines; then plan_between_surfaces is set. Empty where rays alone count, for which
//     line_mixture is set then, or where lines are drawn.
std::string FormFactorRun::State::takeDirectionsAlone() {
  if (!setup.mayCountSurfaces()) return "";
  Lattices lattices = setup.lattices();
  lattices.costs = costsOf(setup.scene(), setup.sampling());
  const size_t face_count = setup.faceIds().count();
  const double least = kPilotsInLines * kPilotDirectionsInAll * lattices.costs->of_group;
  if (!mayPayDirectionsAlone(face_count, least)) return "";
  const double most = mostSecondsOfDirectionsAlone(pairNumbers(), face_count, may_leave, setup.isLarge(), mayPromise());
  if (most < least) return "";
  EstimateOptions options = setup.estimate();
  *options.tolerance /= kErrorsInGoal;
  Plan found = planEstimate(setup.scene(), setup.ids(), options, lattices, most);
  if (!found.engine) return "";
  if (mayHaveRays() && setup.scene().polygons.size() <= kMostPolygonsOfRays &&
      secondsOfRays(pilotRays() + kLeastOfGuess * guessRaysAlone(setup.faceIds(), setup.estimate())) < found.seconds) {
    if (PlannedRays planned = planRays(); secondsOfRays(numberOfRays(planned.alone)) < found.seconds) {
      countAlongRays(raysAlone(std::move(planned.alone)));
      return "";
    }
  }
  found.seconds /= setup.request().threads ? setup.request().threads : double(threadCount());
  plan_between_surfaces = std::move(found);
  if (no_promise.empty())
    refusePromise("a promise needs lines of all pairs, which take more than twice the time of common directions");
  setup.countSurfaces();
  return "between surfaces common directions take less time";
}

}  // namespace viewpeel

#include "bench/support/coverage_cases.h"

#include <algorithm>
#include <array>

#include "engines/host_engine.h"
#include "estimator/estimate.h"
#include "estimator/find_prior.h"
#include "reference/closed_forms/past_blocker.h"
#include "reference/closed_forms/rectangles.h"
#include "scenes/generate.h"
#include "scenes/named_scenes.h"

namespace viewpeel::bench {
namespace {

constexpr uint64_t kLongRunSeed = 2'000'000'000;

Case twoSquares(const InputScene& input, double factor) {
  return {buildScene(input), {{{0, 1}, factor}, {{0, kEnvironment}, 1 - factor}, {{1, kEnvironment}, 1 - factor}}};
}

struct Patch {
  int axis, side;
  std::array<reference::Interval, 3> extent;  // along the axes other than `axis`
};

reference::Interval distances(reference::Interval interval, int side) {
  return side == 0 ? interval : reference::Interval{1 - interval.high, 1 - interval.low};
}

double factorInCube(const Patch& a, const Patch& b) {
  if (a.axis == b.axis) {
    const int x = (a.axis + 1) % 3, y = (a.axis + 2) % 3;
    return a.side == b.side ? 0 : reference::parallelRectangles(a.extent[x], a.extent[y], b.extent[x], b.extent[y], 1);
  }
  const int along = 3 - a.axis - b.axis;
  return reference::perpendicularRectangles(distances(a.extent[b.axis], b.side), a.extent[along], b.extent[along],
                                            distances(b.extent[a.axis], a.side));
}

// Returns the inside of a unit cube, every face cut into `cuts` x `cuts` patches.
Case cutCube(int cuts) {
  InputScene input{"cube", {"cube"}, {}};
  std::vector<Patch> patches;
  const auto part = [cuts](int k) { return reference::Interval{double(k) / cuts, double(k + 1) / cuts}; };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int k = 0; k < cuts * cuts; ++k) {
        Patch patch{axis, side, {}};
        const int x = (axis + 1) % 3, y = (axis + 2) % 3;
        patch.extent[x] = part(k % cuts);
        patch.extent[y] = part(k / cuts);
        patches.push_back(patch);
        glm::dvec3 origin(0), along_x(0), along_y(0);
        origin[axis] = side, origin[x] = patch.extent[x].low, origin[y] = patch.extent[y].low;
        along_x[x] = along_y[y] = 1.0 / cuts;
        if (side == 1) std::swap(along_x, along_y);  // fronts inward
        test_scenes::addFace(input, "cube", test_scenes::parallelogram(origin, along_x, along_y));
      }
  Case cube{buildScene(input), {}, true};
  for (uint32_t i = 0; i < patches.size(); ++i)
    for (uint32_t j = i + 1; j < patches.size(); ++j)
      if (const double factor = factorInCube(patches[i], patches[j]); factor > 0) cube.truths[{i, j}] = factor;
  return cube;
}

// Returns a case of three squares: the first two see each other past the third.
Case pastABlocker(const InputScene& input) {
  const double factor =
      reference::formFactorPastBlocker(input.faces[0].corners, input.faces[1].corners, input.faces[2].corners).value;
  return {buildScene(input), {{{0, 1}, factor}}};
}

// Returns two facing squares of 8 x 8 parts past a blocker. Few lines or none meet most pairs.
Case partsPastABlocker() {
  InputScene input = test_scenes::squaresInParts(8, 1.0 / 8, 1);
  const auto count = static_cast<uint32_t>(input.faces.size());
  const std::vector<glm::dvec3> blocker = test_scenes::squaresPastABlocker().faces[2].corners;
  test_scenes::addFace(input, "blocker", blocker);
  Case parts{buildScene(input), {}};
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = i + 1; j < count; j += 2) {
      const reference::Approximation factor =
          reference::formFactorPastBlocker(input.faces[i].corners, input.faces[j].corners, blocker);
      parts.truths[{i, j}] = factor.value > 1e-12 ? factor.value : 0;  // smaller values are rounding
    }
  return parts;
}

// Returns a case whose truth is a long run of the host engine.
Case byLongRun(Scene scene) {
  constexpr int kResolution = 256;
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine =
      makeHostEngine(scene, ids, {.resolution = kResolution, .sampling = Sampling::scanline, .count_blocked = true});
  FaceExchanges exchanges(nullptr, scene, ids);
  EstimateOptions options{.directions = 16384, .replicates = 8, .seed = kLongRunSeed};
  options.exchanges = &exchanges;
  const FoundPrior found =
      findPrior(*engine, exchanges, scene, ids, groupAsOne(scene, kResolution), options, choosePriorPilot(options));
  options.prior = &found.prior;
  const Estimate estimate = estimateFormFactors(*engine, scene, ids, options);
  Case run{std::move(scene), {}, true};
  for (const FormFactors::Entry& entry : estimate.form_factors.entries())
    if (entry.i < entry.j && entry.j < kEnvironment)
      run.truths[{entry.i, entry.j}] = estimate.form_factors.formFactor(entry.i, entry.j).value;
  return run;
}

}  // namespace

Truths sumBySurface(const Truths& truths, const Ids& ids, const Ids& surface_ids) {
  Truths sums;
  for (const auto& [pair, truth] : truths) {
    if (pair.second >= kEnvironment) continue;
    const auto [i, j] = std::minmax(ids.surface[pair.first], ids.surface[pair.second]);
    sums[{i, j}] += (i == j ? 2 : 1) * truth * ids.areas[pair.first] / surface_ids.areas[i];
  }
  return sums;
}

Case makeCase(const std::string& name) {
  if (name == "facing")
    return twoSquares(test_scenes::parallelSquares(), reference::parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, 1));
  if (name == "edge")
    return twoSquares(test_scenes::perpendicularSquares(),
                      reference::perpendicularRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}));
  if (name == "far")
    return twoSquares(test_scenes::stackOfSheets({0, 10}),
                      reference::parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, 10));
  if (name == "blocked") return pastABlocker(test_scenes::squaresPastABlocker());
  if (name == "parts") return partsPastABlocker();
  if (name == "gap") return pastABlocker(test_scenes::squaresPastAnEdge());
  if (name == "office") return byLongRun(loadScene(VIEWPEEL_SOURCE "/scenes/office.obj"));
  if (name == "room") return byLongRun(buildScene(roomWithBoxes(1)));
  if (name == "city") return byLongRun(buildScene(city(600)));
  return cutCube(6);
}

}  // namespace viewpeel::bench

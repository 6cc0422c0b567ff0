#include "scenes/stress.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "engines/compute_engine.h"
#include "engines/graphics_engine.h"
#include "engines/host_engine.h"
#include "directions/sampler.h"
#include "reference/exact/exact_pair_areas.h"
#include "reference/exact/lattice_check.h"
#include "scenes/named_scenes.h"
#include "scenes/random.h"

namespace viewpeel::stress {
namespace {

namespace ts = test_scenes;

using Random = SceneRandom;

// Returns a convex polygon within a ball: its corners are at random angles of a circle that is compressed to 1 /
// aspect.
ts::Corners polygonIn(glm::dvec3 centre, double radius, uint32_t corner_count, double aspect, Random& random) {
  const glm::dmat3 frame = random.rotation();
  std::vector<double> angles_rad;
  for (uint32_t k = 0; k < corner_count; ++k)
    angles_rad.push_back((k + random.uniform(0.05, 0.95)) * 2 * std::numbers::pi / corner_count);
  ts::Corners corners;
  for (double a : angles_rad)
    corners.push_back(centre + radius * (std::cos(a) * frame[0] + std::sin(a) / aspect * frame[1]));
  return corners;
}

InputScene makeSoup(Random& random, bool slivers) {
  InputScene scene{"soup", {}, {}};
  struct Ball {
    glm::dvec3 centre;
    double radius;
  };
  std::vector<Ball> balls;
  for (int tries = 0; tries < 400 && balls.size() < 40; ++tries) {
    const Ball ball{{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)},
                    0.7 * std::pow(10, random.uniform(-3, 0))};
    if (std::any_of(balls.begin(), balls.end(), [&](const Ball& other) {
          return glm::distance(ball.centre, other.centre) < ball.radius + other.radius;
        }))
      continue;
    balls.push_back(ball);
    const uint32_t corner_count = random.below(6) == 0 ? 3 + random.below(62) : 3 + random.below(4);
    ts::addFace(
        scene, fmt::format("p{}", balls.size()),
        polygonIn(ball.centre, ball.radius, corner_count, slivers ? std::pow(10, random.uniform(0, 6)) : 1, random));
  }
  return scene;
}

// Makes boxes with corners in multiples of 1/8 in the cells of a 3 x 3 x 3 grid: many reach the sides of their cell and
// touch their neighbours.
InputScene makeBoxes(Random& random) {
  InputScene scene{"boxes", {}, {}};
  ts::addBox(scene, "room", glm::dvec3(0), glm::dvec3(3), true);
  for (uint32_t cell = 0; cell < 27; ++cell) {
    if (random.below(3) == 0) continue;
    glm::dvec3 low, high;
    for (int axis = 0; axis < 3; ++axis) {
      const double origin = double(axis == 0 ? cell % 3 : axis == 1 ? cell / 3 % 3 : cell / 9);
      low[axis] = origin + random.below(4) / 8.0;
      high[axis] = origin + (5 + random.below(4)) / 8.0;
    }
    ts::addBox(scene, fmt::format("b{}", cell), low, high, false);
  }
  return scene;
}

ts::Corners square(double x, double y, double edge, double z, bool up) {
  ts::Corners corners = ts::parallelogram({x, y, z}, {edge, 0, 0}, {0, edge, 0});
  if (!up) std::reverse(corners.begin(), corners.end());
  return corners;
}

InputScene makeSheets(Random& random) {
  InputScene scene{"sheets", {}, {}};
  double z = 0;
  for (int k = 0; k < 12; ++k) {
    ts::addFace(scene, fmt::format("s{}", k),
                square(random.uniform(0, 0.3), random.uniform(0, 0.3), random.uniform(0.5, 1), z, random.flip()));
    z += 0.7 * std::pow(10, random.uniform(-7, 0));
  }
  return scene;
}

InputScene makeDoubles(Random& random) {
  InputScene scene{"doubles", {}, {}};
  for (int level = 0; level < 3; ++level)
    for (int k = 0; k < 5; ++k) {
      const double x = random.below(4) / 4.0, y = random.below(4) / 4.0, edge = (1 + random.below(3)) / 2.0;
      for (uint32_t copies = 1 + random.below(2); copies > 0; --copies)
        ts::addFace(scene, fmt::format("d{}_{}", level, k), square(x, y, edge, level * 0.4, random.flip()));
    }
  return scene;
}

std::vector<glm::dvec3> hardDirections(const Scene& scene, Random& random) {
  std::vector<glm::dvec3> directions = {random.onSphere(), random.onSphere()};
  glm::dvec3 axis(0);
  axis[random.below(3)] = random.flip() ? 1 : -1;
  directions.push_back(axis);
  if (random.flip()) directions.push_back(glm::normalize(glm::dvec3(1, random.flip() ? 1 : 0, random.flip() ? -1 : 1)));
  const Polygon& polygon = scene.polygons[random.below(static_cast<uint32_t>(scene.polygons.size()))];
  const glm::dvec3 edge = glm::normalize(scene.corners[polygon.first_corner + 1] - scene.corners[polygon.first_corner]);
  directions.push_back(edge);
  directions.push_back(glm::normalize(edge + std::pow(10, random.uniform(-16, -1)) * random.onSphere()));
  return directions;
}

using Pairs = std::map<std::pair<uint32_t, uint32_t>, uint64_t>;

Pairs byPair(const PairCounts& counts) {
  Pairs pairs;
  for (const PairCount& c : counts) pairs[{c.i, c.j}] = c.count;
  return pairs;
}

struct Region {
  double area = 0, perimeter = 0;
};

}  // namespace

const char* nameOf(Kind kind) {
  constexpr std::array kNames = {"soup", "slivers", "boxes", "turned", "sheets", "doubles"};
  return kNames[static_cast<size_t>(kind)];
}

InputScene makeScene(Kind kind, uint64_t seed) {
  Random random(seed * std::size(kKinds) + static_cast<uint64_t>(kind));
  switch (kind) {
    case Kind::soup:
      return makeSoup(random, false);
    case Kind::slivers:
      return makeSoup(random, true);
    case Kind::boxes:
      return makeBoxes(random);
    case Kind::turned: {
      const InputScene scene = makeBoxes(random);
      return ts::transformed(scene, random.rotation(), 1, 3e4 * random.onSphere());
    }
    case Kind::sheets:
      return makeSheets(random);
    case Kind::doubles:
      return makeDoubles(random);
  }
  return {};
}

void Tally::add(const Tally& other) {
  scenes += other.scenes;
  directions += other.directions;
  regions += other.regions;
  polygons += other.polygons;
  lines += other.lines;
  lost_lines += other.lost_lines;
  unequal += other.unequal;
  if (other.worst <= worst && !worst_case.empty()) return;
  worst = other.worst;
  worst_case = other.worst_case;
}

Tally judge(const Device& device, Kind kind, uint64_t seed, bool shrunk) {
  constexpr int kResolution = 48;
  constexpr uint32_t kLattices = 32, kDrawn = 3;  // the graphics engine draws only a few of the lattices
  const Scene scene = buildScene(makeScene(kind, seed));
  const Ids ids = makeIds(scene, By::polygon, false);
  Random random(~seed);
  const std::vector<glm::dvec3> directions = hardDirections(scene, random);
  const auto compute = makeComputeEngine(device, scene, ids, {.resolution = kResolution});
  // The graphics engine refuses three or more coincident polygons.
  const bool is_drawable = std::ranges::all_of(scene.polygons, [](const Polygon& polygon) {
    return polygon.tie_rank == kContactRank || polygon.tie_rank == kSheetRank;
  });
  const auto graphics = is_drawable ? makeGraphicsEngine(device, scene, ids, {.resolution = kResolution}) : nullptr;
  const LatticeOptions scanlines{
      .resolution = kResolution, .sampling = Sampling::scanline, .count_blocked = true, .thread_count = 1};
  const auto host = makeHostEngine(scene, ids, {.resolution = kResolution, .thread_count = 1});
  const auto compute_scanlines = makeComputeEngine(device, scene, ids, scanlines),
             host_scanlines = makeHostEngine(scene, ids, scanlines);
  Scene judged = scene;
  if (shrunk) {
    const Polygon& largest = *std::max_element(scene.polygons.begin(), scene.polygons.end(),
                                               [](const Polygon& a, const Polygon& b) { return a.area < b.area; });
    glm::dvec3* corners = &judged.corners[largest.first_corner];
    for (uint32_t k = 1; k < largest.corner_count; ++k) corners[k] = (corners[0] + corners[k]) / 2.0;
  }
  const auto exact = reference::computeExactPairAreas(judged, directions, {.perimeters = true, .thread_count = 1});
  const double h = 2.0 / kResolution;
  Tally tally;
  tally.scenes = 1;
  tally.polygons = scene.polygons.size();
  for (size_t d = 0; d < directions.size(); ++d) {
    const auto lattices = sampleLattices(directions[d], kLattices, seed * 31 + d);
    const Pairs counts = byPair(compute->count(lattices));
    const std::span drawn(lattices.data(), kDrawn);
    if (graphics) tally.unequal += byPair(graphics->count(drawn)) != byPair(compute->count(drawn));
    tally.unequal += byPair(host->count(lattices)) != counts;
    tally.unequal += byPair(host_scanlines->count(drawn)) != byPair(compute_scanlines->count(drawn));
    ++tally.directions;
    std::map<std::pair<uint32_t, uint32_t>, Region> regions;
    for (const auto& [pair, count] : counts) regions[pair];
    for (const reference::PairArea& area : exact[d].pairs) {
      const uint32_t i = ids.of_polygon[area.a], j = area.b < kEnvironment ? ids.of_polygon[area.b] : area.b;
      Region& region = regions[{std::min(i, j), std::max(i, j)}];
      region.area += area.area;
      region.perimeter += area.perimeter;
    }
    for (const auto& [pair, region] : regions) {
      const auto at = counts.find(pair);
      const uint64_t count = at == counts.end() ? 0 : at->second;
      if (isClosed(kind)) {
        tally.lines += count * (pair.second < kEnvironment ? 2 : 1);
        if (pair.second >= kEnvironment && region.area < 1e-12) tally.lost_lines += count;
      }
      const double variance = h * h * region.area + 4 * reference::kLatticeVariance * h * h * h * region.perimeter;
      const bool is_thin = 4 * region.area < h * region.perimeter;
      const double range = h * h + (is_thin ? h * region.perimeter / 2 : 0),
                   log = std::log(2 / kFalseAlarmRate) / kLattices;
      const double allowed =
          log * range / 3 + std::sqrt(log * log * range * range / 9 + 2 * log * variance) + 0x1p-24 * region.perimeter;
      const double off = std::abs(double(count) * h * h / kLattices - region.area);
      ++tally.regions;
      if (off / allowed < tally.worst) continue;
      tally.worst = off / allowed;
      tally.worst_case = fmt::format(
          "{} seed {} direction {} = ({}, {}, {}), pair {} {}: {} points of {} lattices, area {}, perimeter {}",
          nameOf(kind), seed, d, directions[d].x, directions[d].y, directions[d].z, pair.first, pair.second, count,
          kLattices, region.area, region.perimeter);
    }
  }
  return tally;
}

}  // namespace viewpeel::stress

#include "scenes/triangulated_city.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include <viewpeel/error.h>
#include "scenes/random.h"

namespace viewpeel::bench {
namespace {

using Side = std::vector<glm::dvec2>;  // from a corner to the next, both included
using Sides = std::vector<Side>;       // all around

// Lengths are metres.
constexpr double kPitch = 36, kJitter = 5;         // of the nodes between streets
constexpr double kWallColumn = 8, kWallRow = 6.5;  // at most, between corners along and up a wall
constexpr double kLeastHeight = 3, kMostHeight = 80;
constexpr uint32_t kTrianglesPerCell = 200;  // a plot with its building, before trees

double rounded(double x) {
  const volatile float single = float(x);  // volatile, for GCC 12 at -O2 leaves out the rounding of two side by side
  return double(single);
}
glm::dvec2 rounded(glm::dvec2 p) { return {rounded(p.x), rounded(p.y)}; }
PlanPolygon rounded(PlanPolygon polygon) {
  for (glm::dvec2& p : polygon) p = rounded(p);
  return polygon;
}

// Neighbouring walls have the same corners: a side is cut alike from either end.
Side makeSide(glm::dvec2 a, glm::dvec2 b) {
  const auto columns = static_cast<uint32_t>(std::ceil(glm::distance(a, b) / kWallColumn));
  Side side{a};
  for (uint32_t k = 1; k < columns; ++k) side.push_back(rounded(a + (b - a) * (double(k) / columns)));
  side.push_back(b);
  return side;
}

Side reversed(Side side) {
  std::reverse(side.begin(), side.end());
  return side;
}

Sides makeSides(const PlanPolygon& corners, bool in_columns) {
  Sides sides;
  for (size_t k = 0; k < corners.size(); ++k) {
    const glm::dvec2 a = corners[k], b = corners[(k + 1) % corners.size()];
    sides.push_back(in_columns ? makeSide(a, b) : Side{a, b});
  }
  return sides;
}

PlanPolygon outlineOf(const Sides& sides) {
  PlanPolygon outline;
  for (const Side& side : sides) outline.insert(outline.end(), side.begin(), side.end() - 1);
  return outline;
}

// Returns heights from one to another, both included; the ones above `levels`, where there are any.
std::vector<double> makeLevels(double low, double high) {
  const auto rows = static_cast<uint32_t>(std::ceil((high - low) / kWallRow));
  std::vector<double> levels;
  for (uint32_t k = 0; k <= rows; ++k) levels.push_back(rounded(low + (high - low) * (double(k) / rows)));
  return levels;
}

struct Box {
  PlanPolygon outline;
  double low, high;
};

struct Tree {
  size_t plot;
  Box crown;          // a hedge is one that stands on the pavement
  PlanPolygon trunk;  // none of a hedge
};

struct Wall {
  Side side;
  std::vector<double> levels;
};

struct Part {  // of a building, under one roof
  std::vector<Wall> walls;
  PlanPolygon eaves;
  double height;  // of the eaves above the sea
  double apex;    // of a tent above its eaves; 0: a flat roof
  std::vector<Box> boxes;
};

struct Building {
  PlanPolygon footprint;
  std::vector<Part> parts;
};

struct Plan {
  PlanPolygon rim;
  std::vector<PlanPolygon> plots;
  std::vector<double> pavements;    // heights, by plot
  std::vector<Building> buildings;  // by plot; parks have no parts
  std::vector<Tree> trees;
  std::vector<double> heights;
};

// --- what stands where --------------------------------------------------------------------------------------------

double drawHeight(SceneRandom& random, size_t building) {
  const double kind = random.uniform();
  if (building == 0) return kLeastHeight;
  if (building == 1 || kind < 0.06) return random.uniform(40, kMostHeight);
  return kind < 0.2 ? random.uniform(kLeastHeight, 7) : random.uniform(7, 28);
}

// Puts boxes on a flat roof: stair heads, and chimneys with triangles of a tenth of a square metre.
std::vector<Box> placeRoofBoxes(const PlanPolygon& eaves, double height, SceneRandom& random) {
  std::vector<Box> boxes;
  const uint32_t wanted = 1 + random.below(4);
  for (uint32_t tries = 0; tries < 100 && boxes.size() < wanted; ++tries) {
    const bool chimney = random.flip();
    const glm::dvec2 half_size(chimney ? random.uniform(0.15, 0.4) : random.uniform(1, 2),
                               chimney ? random.uniform(0.15, 0.4) : random.uniform(1, 2.2));
    const glm::dvec2 centre = eaves[0] + glm::dvec2(random.uniform(-25, 25), random.uniform(-25, 25));
    const double reach = glm::length(half_size) + 0.4;
    if (!contains(eaves, centre) || distanceTo(eaves, centre) < reach) continue;
    if (std::any_of(boxes.begin(), boxes.end(), [&](const Box& box) {
          return contains(box.outline, centre) || distanceTo(box.outline, centre) < reach;
        }))
      continue;
    const glm::dvec2 along = glm::normalize(eaves[1] - eaves[0]);
    const double turned_rad = random.uniform() < 0.7 ? std::atan2(along.y, along.x) : random.uniform(0, 3);
    boxes.push_back({rounded(rectangle(centre, half_size, turned_rad)), height,
                     rounded(height + (chimney ? random.uniform(0.8, 1.5) : random.uniform(2.2, 3.5)))});
  }
  return boxes;
}

Part makePart(std::vector<Wall> walls, const Sides& eaves, double height, bool tent, SceneRandom& random) {
  Part part{std::move(walls), outlineOf(eaves), height, 0, {}};
  if (tent) part.apex = random.uniform(1.5, 4);
  else part.boxes = placeRoofBoxes(part.eaves, height, random);
  return part;
}

std::vector<Wall> raise(const Sides& sides, const std::vector<double>& levels) {
  std::vector<Wall> walls;
  for (const Side& side : sides) walls.push_back({side, levels});
  return walls;
}

Building makeSingle(const PlanPolygon& footprint, double low, double height, bool convex, SceneRandom& random) {
  const Sides sides = makeSides(footprint, true);
  const std::vector<double> levels = makeLevels(low, low + height);
  const bool tent = convex && height < 15 && random.uniform() < 0.4;
  return {outlineOf(sides), {makePart(raise(sides, levels), sides, levels.back(), tent, random)}};
}

// Makes two parts with a common wall, of which the second is the higher one.
Building makePair(const PlanPolygon& quad, double low, double height, double more, SceneRandom& random) {
  const double a = random.uniform(0.35, 0.65), b = random.uniform(0.35, 0.65);
  const glm::dvec2 m = rounded(quad[0] + a * (quad[1] - quad[0])), n = rounded(quad[3] + b * (quad[2] - quad[3]));
  const Side common = makeSide(m, n);
  const Sides first{makeSide(quad[0], m), common, makeSide(n, quad[3]), makeSide(quad[3], quad[0])},
      second{makeSide(m, quad[1]), makeSide(quad[1], quad[2]), makeSide(quad[2], n), reversed(common)};
  const std::vector<double> low_levels = makeLevels(low, low + height),
                            high_levels = makeLevels(low_levels.back(), low + height + more);
  std::vector<double> levels = low_levels;
  levels.insert(levels.end(), high_levels.begin() + 1, high_levels.end());
  const std::vector<Wall> first_walls = raise({first[0], first[2], first[3]}, low_levels);
  std::vector<Wall> second_walls = raise({second[0], second[1], second[2]}, levels);
  second_walls.push_back({second[3], high_levels});
  return {outlineOf({first[0], second[0], second[1], second[2], first[2], first[3]}),
          {makePart(first_walls, first, low_levels.back(), false, random),
           makePart(second_walls, second, levels.back(), false, random)}};
}

Building makeBuilding(const PlanPolygon& cell, double pavement, Plan& plan, SceneRandom& random) {
  const double height = drawHeight(random, plan.heights.size());
  const PlanPolygon quad = inset(cell, random.uniform(2, 3.5));
  const double a = random.uniform(0.4, 0.49), b = random.uniform(0.4, 0.49);
  const size_t corner = random.below(4);
  plan.heights.push_back(height);
  switch (random.below(5)) {
    case 0:
      return makeSingle(rounded(quad), pavement, height, true, random);
    case 1:
      return makeSingle(rounded(notchCorner(quad, corner, a, b)), pavement, height, false, random);
    case 2:
      return makeSingle(rounded(cutCorner(quad, corner, a / 2, b)), pavement, height, true, random);
    case 3: {
      const glm::dvec2 centre = meanOf(quad);
      const double reach = distanceTo(quad, centre), flat_rad = random.uniform(0.5, 0.75);
      const PlanPolygon turned = rectangle(centre, reach * glm::dvec2(std::cos(flat_rad), std::sin(flat_rad)),
                                           random.uniform(0, 2 * std::numbers::pi));
      const bool notched = random.flip();
      return makeSingle(rounded(notched ? notchCorner(turned, corner, a, b) : turned), pavement, height, !notched,
                        random);
    }
    default: {
      const double more = std::min(random.uniform(3, 20), kMostHeight - height);
      if (more < 3) return makeSingle(rounded(quad), pavement, height, true, random);
      plan.heights.push_back(height + more);
      return makePair(rounded(quad), pavement, height, more, random);
    }
  }
}

void layOut(Plan& plan, uint32_t cells, SceneRandom& random) {
  const auto rows = static_cast<uint32_t>(std::sqrt(cells)), columns = cells / rows;
  const double turned_rad = random.uniform(0.1, 1.4);
  const glm::dvec2 x(std::cos(turned_rad), std::sin(turned_rad)), y(-x.y, x.x);
  std::vector<PlanPolygon> nodes(rows + 1);
  for (uint32_t r = 0; r <= rows; ++r)
    for (uint32_t c = 0; c <= columns; ++c)
      nodes[r].push_back(rounded(x * (c * kPitch + random.uniform(-kJitter, kJitter)) +
                                 y * (r * kPitch + random.uniform(-kJitter, kJitter))));
  for (uint32_t c = 0; c < columns; ++c) plan.rim.push_back(nodes[0][c]);
  for (uint32_t r = 0; r < rows; ++r) plan.rim.push_back(nodes[r][columns]);
  for (uint32_t c = columns; c > 0; --c) plan.rim.push_back(nodes[rows][c]);
  for (uint32_t r = rows; r > 0; --r) plan.rim.push_back(nodes[r][0]);
  for (uint32_t r = 0; r < rows; ++r)
    for (uint32_t c = 0; c < columns; ++c) {
      const PlanPolygon cell =
          inset({nodes[r][c], nodes[r][c + 1], nodes[r + 1][c + 1], nodes[r + 1][c]}, random.uniform(2.5, 4.5));
      const uint32_t sides = 1 + random.below(3);
      plan.plots.push_back(
          outlineOf(makeSides(rounded(roundCorners(cell, sides, random.uniform(0.11, 0.2) * std::sqrt(sides))), true)));
      plan.pavements.push_back(rounded(random.uniform(kKerbHeight, 0.18)));
      const bool park = plan.plots.size() % 6 == 3;
      plan.buildings.push_back(park ? Building{} : makeBuilding(cell, plan.pavements.back(), plan, random));
    }
}

bool isFree(const Plan& plan, const Tree& tree, glm::dvec2 centre, double reach) {
  const PlanPolygon &plot = plan.plots[tree.plot], &footprint = plan.buildings[tree.plot].footprint;
  if (!contains(plot, centre) || distanceTo(plot, centre) < reach) return false;
  if (!footprint.empty() && (contains(footprint, centre) || distanceTo(footprint, centre) < reach)) return false;
  return std::none_of(plan.trees.begin(), plan.trees.end(), [&](const Tree& other) {
    return other.plot == tree.plot &&
           (contains(other.crown.outline, centre) || distanceTo(other.crown.outline, centre) < reach);
  });
}

void plant(Plan& plan, size_t most, SceneRandom& random) {
  for (uint32_t tries = 0; tries < 200 * most && plan.trees.size() < most; ++tries) {
    const bool hedge = random.uniform() < 0.25;
    Tree tree{random.below(static_cast<uint32_t>(plan.plots.size())), {}, {}};
    const glm::dvec2 half_size(random.uniform(0.5, hedge ? 2 : 1.6), random.uniform(0.4, hedge ? 0.6 : 1.6)),
        centre = plan.plots[tree.plot][0] + glm::dvec2(random.uniform(-45, 45), random.uniform(-45, 45));
    const double turned_rad = random.uniform(0, 3), pavement = plan.pavements[tree.plot],
                 low = hedge ? pavement : rounded(pavement + random.uniform(1.8, 3.5));
    tree.crown = {rounded(rectangle(centre, half_size, turned_rad)), low,
                  rounded(low + (hedge ? random.uniform(0.6, 1.6) : random.uniform(2, 6)))};
    if (!hedge) tree.trunk = rounded(rectangle(centre, glm::dvec2(random.uniform(0.1, 0.2)), turned_rad));
    if (isFree(plan, tree, centre, glm::length(half_size) + 0.25)) plan.trees.push_back(std::move(tree));
  }
}

// --- triangles ----------------------------------------------------------------------------------------------------

class Triangles {
 public:
  InputScene scene;

  void beginSurface(const std::string& name) { scene.surface_names.push_back(name); }

  // Adds a level region: inside the first loop, outside the others.
  void addLevel(double height, const std::vector<PlanPolygon>& loops, double most_area, bool facing_up = true) {
    PlanPolygon points;
    std::vector<std::vector<uint32_t>> indices;
    for (const PlanPolygon& loop : loops) {
      indices.emplace_back();
      for (const glm::dvec2 p : loop) {
        indices.back().push_back(static_cast<uint32_t>(points.size()));
        points.push_back(p);
      }
    }
    for (auto [a, b, c] : triangulate(points, indices, most_area)) {
      if (!facing_up) std::swap(b, c);
      const auto at = [&](uint32_t k) { return glm::dvec3(rounded(points[k]), height); };
      add(at(a), at(b), at(c));
    }
  }

  // A wall has coordinates in its own plane: distance from the first corner, height. Its front lies to the right of its
  // side.
  void addWall(const Side& side, const std::vector<double>& levels) {
    PlanPolygon points;
    std::vector<glm::dvec3> places;
    const glm::dvec2 first = side.front(), last = side.back();
    const auto append = [&](glm::dvec2 p, double height) {
      points.emplace_back(glm::distance(first, p), height);
      places.emplace_back(p, height);
    };
    for (const glm::dvec2 p : side) append(p, levels.front());
    for (size_t k = 1; k < levels.size(); ++k) append(last, levels[k]);
    for (size_t k = side.size() - 1; k-- > 0;) append(side[k], levels.back());
    for (size_t k = levels.size() - 1; k-- > 1;) append(first, levels[k]);
    std::vector<uint32_t> loop(points.size());
    for (uint32_t k = 0; k < loop.size(); ++k) loop[k] = k;
    const double length = glm::distance(first, last);
    for (const auto& [a, b, c] : triangulate(points, {loop}, kMostCityArea)) {
      for (size_t k = places.size(); k < points.size(); ++k)
        places.emplace_back(rounded(first + (last - first) * (points[k].x / length)), rounded(points[k].y));
      add(places[a], places[b], places[c]);
    }
  }

  void addWalls(const PlanPolygon& outline, double low, double high) {
    for (const Side& side : makeSides(outline, false)) addWall(side, {low, high});
  }

  void addTent(const PlanPolygon& eaves, double height, double apex) {
    const glm::dvec3 top(rounded(meanOf(eaves)), rounded(height + apex));
    for (size_t k = 0; k < eaves.size(); ++k)
      add(glm::dvec3(eaves[k], height), glm::dvec3(eaves[(k + 1) % eaves.size()], height), top);
  }

 private:
  void add(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    scene.faces.push_back({{a, b, c}, static_cast<uint32_t>(scene.surface_names.size() - 1), 0});
  }
};

void addPart(Triangles& triangles, const Part& part) {
  for (const Wall& wall : part.walls) triangles.addWall(wall.side, wall.levels);
  if (part.apex > 0) return triangles.addTent(part.eaves, part.height, part.apex);
  std::vector<PlanPolygon> roof{part.eaves};
  for (const Box& box : part.boxes) {
    roof.push_back(box.outline);
    triangles.addWalls(box.outline, box.low, box.high);
    triangles.addLevel(box.high, {box.outline}, kMostCityArea);
  }
  triangles.addLevel(part.height, roof, kMostCityArea);
}

void addTree(Triangles& triangles, const Tree& tree, double pavement) {
  triangles.addWalls(tree.crown.outline, tree.crown.low, tree.crown.high);
  triangles.addLevel(tree.crown.high, {tree.crown.outline}, kMostCityArea);
  if (tree.trunk.empty()) return;
  triangles.addWalls(tree.trunk, pavement, tree.crown.low);
  triangles.addLevel(tree.crown.low, {tree.crown.outline, tree.trunk}, kMostCityArea, false);
}

TriangulatedCity build(const Plan& plan, size_t tree_count) {
  Triangles triangles;
  TriangulatedCity city{{}, plan.rim, {}, plan.heights};
  std::vector<PlanPolygon> ground{plan.rim};
  ground.insert(ground.end(), plan.plots.begin(), plan.plots.end());
  triangles.beginSurface("ground");
  triangles.addLevel(0, ground, INFINITY);
  for (size_t k = 0; k < plan.plots.size(); ++k) {
    CityPlot plot{plan.plots[k], {}};
    const Building& building = plan.buildings[k];
    if (!building.parts.empty()) {
      plot.footprints.push_back(building.footprint);
      triangles.beginSurface(fmt::format("building_{}", k + 1));
      for (const Part& part : building.parts) addPart(triangles, part);
    }
    bool any = false;
    for (size_t t = 0; t < tree_count; ++t) {
      const Tree& tree = plan.trees[t];
      if (tree.plot != k) continue;
      if (!std::exchange(any, true)) triangles.beginSurface(fmt::format("trees_{}", k + 1));
      plot.footprints.push_back(tree.trunk.empty() ? tree.crown.outline : tree.trunk);
      addTree(triangles, tree, plan.pavements[k]);
    }
    std::vector<PlanPolygon> pavement{plot.outline};
    pavement.insert(pavement.end(), plot.footprints.begin(), plot.footprints.end());
    triangles.beginSurface(fmt::format("plot_{}", k + 1));
    triangles.addWalls(plot.outline, 0, plan.pavements[k]);
    triangles.addLevel(plan.pavements[k], pavement, kMostCityArea);
    city.plots.push_back(std::move(plot));
  }
  city.scene = std::move(triangles.scene);
  city.scene.file = fmt::format("city of {} triangles", city.scene.faces.size());
  return city;
}

}  // namespace

TriangulatedCity triangulatedCity(uint32_t n, uint64_t seed) {
  constexpr double kTrianglesPerTree = 31;  // a crown with its trunk, a hedge now and then, and holes around them
  SceneRandom random(seed);
  Plan plan;
  layOut(plan, std::max(4u, static_cast<uint32_t>(0.85 * n / kTrianglesPerCell)), random);
  plant(plan, static_cast<size_t>(n / kTrianglesPerTree), random);
  size_t tree_count = 0;
  for (int rounds = 0;; ++rounds) {
    TriangulatedCity city = build(plan, tree_count);
    const double lacking = (double(n) - double(city.scene.faces.size())) / kTrianglesPerTree;
    const double wanted = std::max(0.0, std::round(double(tree_count) + lacking));
    if (std::abs(lacking) < 0.7 || rounds == 5 || size_t(wanted) == tree_count) return city;
    if (wanted > double(plan.trees.size()))
      throw Error(ErrorCode::check, fmt::format("a city of {} triangles: {} trees find no place; choose another seed",
                                                n, wanted - double(plan.trees.size())));
    tree_count = static_cast<size_t>(wanted);
  }
}

}  // namespace viewpeel::bench

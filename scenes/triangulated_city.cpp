#include "scenes/triangulated_city.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include <viewpeel/error.h>
#include "scenes/city_plan.h"
#include "scenes/random.h"

namespace viewpeel::bench {
namespace {

using namespace city_plan;

constexpr uint32_t kTrianglesPerCell = 200;  // a plot with its building, before trees

class Triangles {
 public:
  InputScene scene;

  void beginSurface(const std::string& name) { scene.surface_names.push_back(name); }

  // Adds a level region inside the first loop and outside the others.
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

TriangulatedCity build(const CityPlan& plan, size_t tree_count) {
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
  constexpr double kTrianglesPerTree = 31;  // a crown with its trunk, sometimes a hedge, and the holes around them
  SceneRandom random(seed);
  CityPlan plan;
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

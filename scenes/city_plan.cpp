#include "scenes/city_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/glm.hpp>

#include "scenes/triangulated_city.h"

namespace viewpeel::bench::city_plan {
namespace {

// All lengths are in metres.
constexpr double kPitch = 36, kJitter = 5;         // distance of the nodes between streets, and their random shift
constexpr double kWallColumn = 8, kWallRow = 6.5;  // most between corners along a wall, and up a wall
constexpr double kLeastHeight = 3, kMostHeight = 80;

// Returns a side with its points. A side is divided alike from either end, so that neighbouring walls share corners.
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

PlanPolygon outlineOf(const Sides& sides) {
  PlanPolygon outline;
  for (const Side& side : sides) outline.insert(outline.end(), side.begin(), side.end() - 1);
  return outline;
}

// Returns heights from `low` to `high`, both included, with at most the distance of two rows of a wall.
std::vector<double> makeLevels(double low, double high) {
  const auto rows = static_cast<uint32_t>(std::ceil((high - low) / kWallRow));
  std::vector<double> levels;
  for (uint32_t k = 0; k <= rows; ++k) levels.push_back(rounded(low + (high - low) * (double(k) / rows)));
  return levels;
}

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

// Makes a building of two parts with a common wall; the second part is higher.
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

Building makeBuilding(const PlanPolygon& cell, double pavement, CityPlan& plan, SceneRandom& random) {
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

bool isFree(const CityPlan& plan, const Tree& tree, glm::dvec2 centre, double reach) {
  const PlanPolygon &plot = plan.plots[tree.plot], &footprint = plan.buildings[tree.plot].footprint;
  if (!contains(plot, centre) || distanceTo(plot, centre) < reach) return false;
  if (!footprint.empty() && (contains(footprint, centre) || distanceTo(footprint, centre) < reach)) return false;
  return std::none_of(plan.trees.begin(), plan.trees.end(), [&](const Tree& other) {
    return other.plot == tree.plot &&
           (contains(other.crown.outline, centre) || distanceTo(other.crown.outline, centre) < reach);
  });
}

}  // namespace

double rounded(double x) {
  const volatile float single = float(x);  // volatile, for GCC 12 at -O2 leaves out the rounding of two side by side
  return double(single);
}
glm::dvec2 rounded(glm::dvec2 p) { return {rounded(p.x), rounded(p.y)}; }
PlanPolygon rounded(PlanPolygon polygon) {
  for (glm::dvec2& p : polygon) p = rounded(p);
  return polygon;
}

Sides makeSides(const PlanPolygon& corners, bool in_columns) {
  Sides sides;
  for (size_t k = 0; k < corners.size(); ++k) {
    const glm::dvec2 a = corners[k], b = corners[(k + 1) % corners.size()];
    sides.push_back(in_columns ? makeSide(a, b) : Side{a, b});
  }
  return sides;
}

void layOut(CityPlan& plan, uint32_t cells, SceneRandom& random) {
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

void plant(CityPlan& plan, size_t most, SceneRandom& random) {
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

}  // namespace viewpeel::bench::city_plan

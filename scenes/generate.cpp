#include "scenes/generate.h"

#include <cmath>
#include <numbers>
#include <span>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "scenes/random.h"
#include "scenes/named_scenes.h"

namespace viewpeel::bench {
namespace {

using Random = SceneRandom;

uint32_t addSurface(InputScene& scene, const std::string& name) {
  scene.surface_names.push_back(name);
  return static_cast<uint32_t>(scene.surface_names.size() - 1);
}

// Adds a parallelogram from `origin`, cut into rows x columns quads; a x b points along the front. Corners on a cut are
// the same on both sides.
void addGrid(InputScene& scene, uint32_t surface, glm::dvec3 origin, glm::dvec3 a, glm::dvec3 b, uint32_t columns,
             uint32_t rows) {
  const auto corner = [&](uint32_t x, uint32_t y) {
    return origin + a * (double(x) / columns) + b * (double(y) / rows);
  };
  for (uint32_t y = 0; y < rows; ++y)
    for (uint32_t x = 0; x < columns; ++x)
      scene.faces.push_back({{corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)}, surface, 0});
}

// Adds the sides of a box, each in cuts x cuts quads. There are six surfaces, one a side, or one for all.
void addCutBox(InputScene& scene, std::span<const uint32_t> surfaces, glm::dvec3 low, glm::dvec3 high, bool inward,
               uint32_t cuts) {
  const auto sides = test_scenes::sidesOfBox(low, high, inward);
  for (size_t k = 0; k < sides.size(); ++k)
    addGrid(scene, surfaces[k % surfaces.size()], sides[k].origin, sides[k].a, sides[k].b, cuts, cuts);
}

constexpr uint32_t kTriangleSurfaces = 100;

constexpr double kBay = 3, kFloor = 3, kSill = 1.2;  // metres; a window reaches from the sill to the next floor
constexpr uint32_t kBays = 7, kStreetTiles = 3;      // bays along a side of a building; bays across a street
constexpr double kBuilding = kBays * kBay, kStreet = kStreetTiles * kBay, kPitch = kBuilding + kStreet;

uint32_t floorsOf(Random& random) {
  const bool tower = random.uniform() < 0.05;
  return static_cast<uint32_t>(tower ? random.uniform(15, 41) : random.uniform(2, 13));
}

uint32_t quadsOf(uint32_t floors) {
  constexpr uint32_t kTiles = kBays + kStreetTiles;
  return floors * kBays * 4 * 2 + kBays * kBays + kTiles * kTiles - kBays * kBays;
}

void addBuilding(InputScene& scene, uint32_t streets, uint32_t number, glm::dvec3 at, uint32_t floors) {
  const uint32_t walls = addSurface(scene, fmt::format("building_{}", number));
  const uint32_t windows = addSurface(scene, fmt::format("building_{}_windows", number));
  // Corners are multiples of the bay from the city's corner, so neighbouring tiles share them exactly.
  const auto addQuad = [&](uint32_t surface, glm::dvec3 p, glm::dvec3 q, glm::dvec3 up) {
    scene.faces.push_back({{p, q, q + up, p + up}, surface, 0});
  };
  for (uint32_t y = 0; y < kBays + kStreetTiles; ++y)
    for (uint32_t x = 0; x < kBays + kStreetTiles; ++x) {
      const bool built = x < kBays && y < kBays;
      const glm::dvec3 p = at + glm::dvec3(x * kBay, y * kBay, built ? floors * kFloor : 0);
      addQuad(built ? walls : streets, p, p + glm::dvec3(kBay, 0, 0), {0, kBay, 0});
    }
  const glm::dvec3 corners[] = {at, at + glm::dvec3(kBuilding, 0, 0), at + glm::dvec3(kBuilding, kBuilding, 0),
                                at + glm::dvec3(0, kBuilding, 0)};
  for (int side = 0; side < 4; ++side) {
    const glm::dvec3 bay = (corners[(side + 1) % 4] - corners[side]) / double(kBays);
    for (uint32_t k = 0; k < floors; ++k)
      for (uint32_t x = 0; x < kBays; ++x) {
        const glm::dvec3 p = corners[side] + bay * double(x) + glm::dvec3(0, 0, k * kFloor);
        addQuad(walls, p, p + bay, {0, 0, kSill});
        addQuad(windows, p + glm::dvec3(0, 0, kSill), p + bay + glm::dvec3(0, 0, kSill), {0, 0, kFloor - kSill});
      }
  }
}

}  // namespace

InputScene roomWithBoxes(uint32_t refine) {
  InputScene scene{fmt::format("room with boxes, refined {}", refine), {}, {}};
  constexpr double kGap = 0.02;
  std::vector<uint32_t> walls;
  for (const char* name : {"west_wall", "east_wall", "south_wall", "north_wall", "floor", "ceiling"})
    walls.push_back(addSurface(scene, name));
  addCutBox(scene, walls, {0, 0, 0}, {6, 5, 3}, true, 8 * refine);
  Random random(1);
  for (uint32_t k = 0; k < 10; ++k) {  // one box in each of 4 x 3 cells but two
    const uint32_t column = k % 4, row = k / 4;
    const double x = 1.5 * column, y = 5 / 3.0 * row;
    const glm::dvec3 low(x + random.uniform(0.1, 0.4), y + random.uniform(0.1, 0.4), kGap);
    const glm::dvec3 high(x + random.uniform(0.9, 1.4), y + random.uniform(1.0, 1.5), random.uniform(0.4, 2.4));
    const uint32_t box = addSurface(scene, fmt::format("box_{}", k + 1));
    addCutBox(scene, std::span(&box, 1), low, high, false, 2 * refine);
  }
  return scene;
}

InputScene randomTriangles(uint32_t n) {
  InputScene scene{fmt::format("{} random triangles", n), {}, {}};
  Random random(2);
  // A line meets n x area x chord / (2 volume) triangles on average: 60 on the diameter at n = 100,000. Corners lie on
  // a sphere of radius r about the centre, so the mean area is pi/5 r^2.
  constexpr double kMeanArea = std::numbers::pi / 5, kDepth = 60;
  const double volume = 4 / 3.0 * std::numbers::pi;
  const double r = std::sqrt(kDepth * volume / (1e5 * kMeanArea)) * std::cbrt(1e5 / n);
  for (uint32_t k = 0; k < kTriangleSurfaces; ++k) addSurface(scene, fmt::format("triangles_{}", k + 1));
  scene.faces.reserve(n);
  for (uint32_t k = 0; k < n; ++k) {
    const glm::dvec3 centre = std::cbrt(random.uniform()) * random.onSphere();
    const glm::dvec3 a = centre + r * random.onSphere(), b = centre + r * random.onSphere(),
                     c = centre + r * random.onSphere();
    scene.faces.push_back({{a, b, c}, k % kTriangleSurfaces, 0});
  }
  return scene;
}

InputScene city(uint32_t n) {
  InputScene scene{fmt::format("city of about {} quads", n), {}, {}};
  Random random(3);
  constexpr double kMeanQuads = 566;  // quads of a building with its share of the streets
  const auto side = static_cast<uint32_t>(std::max(1.0, std::round(std::sqrt(n / kMeanQuads))));
  const uint32_t streets = addSurface(scene, "streets");
  scene.faces.reserve(n + 3000);
  for (uint32_t k = 0;; ++k) {
    const uint32_t floors = floorsOf(random);
    if (k > 0 && scene.faces.size() + quadsOf(floors) / 2 > n) return scene;
    const uint32_t column = k % side, row = k / side;
    addBuilding(scene, streets, k + 1, {column * kPitch, row * kPitch, 0}, floors);
  }
}

InputScene spreadOfSizes() {
  InputScene scene{"spread of sizes", {}, {}};
  const auto addSquare = [&](const std::string& name, glm::dvec3 corner, double edge, bool up) {
    const glm::dvec3 a(edge, 0, 0), b(0, edge, 0);
    scene.faces.push_back({up ? std::vector{corner, corner + a, corner + a + b, corner + b}
                              : std::vector{corner, corner + b, corner + a + b, corner + a},
                           addSurface(scene, name), 0});
  };
  addSquare("floor", {-1, -1, -1}, 14, true);
  double x = 0;
  for (int k = 0; k < 5; ++k) {
    const double edge = std::pow(10.0, -k);
    for (const auto& [name, times] : {std::pair("near", 1), std::pair("far", 10)}) {
      addSquare(fmt::format("{}_{}_up", name, k), {x, 0, 0}, edge, true);
      addSquare(fmt::format("{}_{}_down", name, k), {x, 0, times * edge}, edge, false);
      x += edge + 1;
    }
  }
  return scene;
}

InputScene twoPlates(uint32_t cuts) {
  InputScene scene{"two plates", {}, {}};
  addGrid(scene, addSurface(scene, "lower"), {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, cuts, cuts);
  addGrid(scene, addSurface(scene, "upper"), {0, 0, 1}, {0, 1, 0}, {1, 0, 0}, cuts, cuts);
  return scene;
}

InputScene cubeOfPatches(uint32_t cuts) {
  InputScene scene{"inside of a cube", {}, {}};
  const uint32_t cube = addSurface(scene, "cube");
  addCutBox(scene, std::span(&cube, 1), {0, 0, 0}, {1, 1, 1}, true, cuts);
  return scene;
}

InputScene refined(const Scene& scene, uint32_t refine) {
  InputScene result{scene.file, {}, {}};
  for (const Surface& surface : scene.surfaces) result.surface_names.push_back(surface.name);
  for (const Polygon& polygon : scene.polygons) {
    const glm::dvec3* corners = &scene.corners[polygon.first_corner];
    const bool triangle = polygon.corner_count == 3;
    const auto at = [&](uint32_t x, uint32_t y) {  // the triangle: corners[0] + x, y along its sides
      const double s = double(x) / refine, t = double(y) / refine;
      const glm::dvec3 p =
          triangle ? (1 - s - t) * corners[0] + s * corners[1] + t * corners[2]
                   : (1 - t) * ((1 - s) * corners[0] + s * corners[1]) + t * ((1 - s) * corners[3] + s * corners[2]);
      return scene.centre + scene.scale * p;
    };
    const auto add = [&](std::vector<glm::dvec3> cut) {
      result.faces.push_back({std::move(cut), scene.faces[polygon.face].surface, 0});
    };
    for (uint32_t y = 0; y < refine; ++y)
      for (uint32_t x = 0; x + (triangle ? y : 0) < refine; ++x) {
        if (!triangle) {
          add({at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
          continue;
        }
        add({at(x, y), at(x + 1, y), at(x, y + 1)});
        if (x + y + 1 < refine) add({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
      }
  }
  return result;
}

}  // namespace viewpeel::bench

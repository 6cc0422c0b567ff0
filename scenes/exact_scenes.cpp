#include "scenes/exact_scenes.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "scenes/named_scenes.h"

namespace viewpeel::tests {
namespace {

// Assigns the plane of the corners, shared with earlier polygons within 1e-12.
void assignPlane(Scene& scene, Polygon& polygon) {
  const glm::dvec3* corners = &scene.corners[polygon.first_corner];
  glm::dvec3 twice_area(0), middle(0);
  for (uint32_t k = 0; k < polygon.corner_count; ++k) {
    twice_area += glm::cross(corners[k] - corners[0], corners[(k + 1) % polygon.corner_count] - corners[0]);
    middle += corners[k] / static_cast<double>(polygon.corner_count);
  }
  polygon.area = glm::length(twice_area) / 2;
  const glm::dvec3 normal = glm::normalize(twice_area);
  const double offset = glm::dot(normal, middle);
  for (uint32_t k = 0; k < scene.planes.size(); ++k) {
    for (const double sign : {1.0, -1.0}) {
      if (glm::distance(scene.planes[k].normal, sign * normal) > 1e-12) continue;
      if (std::abs(scene.planes[k].offset - sign * offset) > 1e-12) continue;
      polygon.plane = k;
      polygon.front_along_plane_normal = sign > 0;
      return;
    }
  }
  polygon.plane = static_cast<uint32_t>(scene.planes.size());
  polygon.front_along_plane_normal = true;
  scene.planes.push_back({normal, offset});
}

using Corners = std::vector<glm::dvec3>;

std::vector<Corners> subdivide(const Corners& quad, uint32_t parts) {
  std::vector<Corners> result;
  const auto at = [&](uint32_t s, uint32_t t) {
    const double x = static_cast<double>(s) / parts, y = static_cast<double>(t) / parts;
    return (1 - x) * (1 - y) * quad[0] + x * (1 - y) * quad[1] + x * y * quad[2] + (1 - x) * y * quad[3];
  };
  for (uint32_t t = 0; t < parts; ++t)
    for (uint32_t s = 0; s < parts; ++s) result.push_back({at(s, t), at(s + 1, t), at(s + 1, t + 1), at(s, t + 1)});
  return result;
}

std::vector<Corners> boxQuads(const glm::dvec3& low, const glm::dvec3& high, bool inwards) {
  const auto sides = test_scenes::sidesOfBox(low, high, inwards);
  std::vector<Corners> quads;
  for (const size_t k : {4, 5, 2, 3, 0, 1})  // -z, +z, -y, +y, -x, +x
    quads.push_back(test_scenes::parallelogram(sides[k].origin, sides[k].a, sides[k].b));
  return quads;
}

Corners square(double x0, double y0, double x1, double y1, double z, bool up) {
  Corners corners = {{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}};
  if (!up) std::reverse(corners.begin(), corners.end());
  return corners;
}

}  // namespace

void SceneBuilder::addPolygon(const std::string& name, const std::vector<glm::dvec3>& corners) {
  Polygon polygon;
  polygon.first_corner = static_cast<uint32_t>(scene.corners.size());
  polygon.corner_count = static_cast<uint32_t>(corners.size());
  polygon.face = static_cast<uint32_t>(scene.faces.size());
  scene.corners.insert(scene.corners.end(), corners.begin(), corners.end());
  assignPlane(scene, polygon);
  scene.polygons.push_back(polygon);
  if (scene.surfaces.empty() || scene.surfaces.back().name != name) scene.surfaces.push_back({name, 0});
  scene.faces.push_back({static_cast<uint32_t>(scene.surfaces.size() - 1), ++scene.surfaces.back().face_count});
}

void SceneBuilder::addBox(const std::string& name, const glm::dvec3& low, const glm::dvec3& high, bool inwards) {
  for (const Corners& quad : boxQuads(low, high, inwards)) addPolygon(name, quad);
}

Scene turn(const Scene& scene, const glm::dmat3& rotation) {
  Scene turned = scene;
  turned.planes.clear();
  for (glm::dvec3& corner : turned.corners) corner = rotation * corner;
  for (Polygon& polygon : turned.polygons) assignPlane(turned, polygon);
  return turned;
}

Scene flip(const Scene& scene, uint32_t polygon_index) {
  Scene flipped = scene;
  Polygon& polygon = flipped.polygons[polygon_index];
  const auto first = flipped.corners.begin() + polygon.first_corner;
  std::reverse(first, first + polygon.corner_count);
  polygon.front_along_plane_normal = !polygon.front_along_plane_normal;
  return flipped;
}

Scene makeRoom() {
  SceneBuilder builder;
  builder.addBox("room", glm::dvec3(-0.5), glm::dvec3(0.5), true);
  return builder.scene;
}

Scene makeCubeInCube() {
  SceneBuilder builder;
  builder.addBox("room", glm::dvec3(-0.5), glm::dvec3(0.5), true);
  builder.addBox("cube", {-0.2, -0.15, -0.3}, {0.2, 0.25, 0.1});
  return builder.scene;
}

Scene makeTwoPlates() {
  SceneBuilder builder;
  builder.addPolygon("lower", square(-0.4, -0.4, 0.4, 0.4, -0.2, true));
  builder.addPolygon("upper", square(-0.1, -0.3, 0.3, 0.5, 0.3, false));
  return builder.scene;
}

Scene makeStaircase() {
  SceneBuilder builder;
  builder.addBox("room", glm::dvec3(-0.5), glm::dvec3(0.5), true);
  for (int step = 0; step < 3; ++step) {
    const double x0 = -0.5 + 0.25 * step, x1 = x0 + 0.25, z0 = -0.5 + 0.125 * step, z1 = z0 + 0.125;
    const double y0 = -0.5 + 0.125 * step, y1 = 0.5;
    builder.addPolygon("riser", {{x0, y0, z0}, {x0, y0, z1}, {x0, y1, z1}, {x0, y1, z0}});
    builder.addPolygon("tread", square(x0, y0, x1, y1, z1, true));
    builder.addPolygon("side", {{x0, y0, -0.5}, {x1, y0, -0.5}, {x1, y0, z1}, {x0, y0, z1}});
  }
  return builder.scene;
}

Scene makeStack() {
  SceneBuilder builder;
  builder.addBox("room", glm::dvec3(-0.5), glm::dvec3(0.5), true);
  builder.addBox("bottom", {-0.3, -0.3, -0.5}, {0.2, 0.2, -0.2});
  builder.addBox("middle", {-0.1, -0.3, -0.2}, {0.3, 0.1, 0.1});
  builder.addBox("top", {-0.1, -0.2, 0.1}, {0.2, 0.1, 0.3});
  return builder.scene;
}

Scene makeTiles() {
  SceneBuilder builder;
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x) {
      const double left = -0.45 + 0.3 * x + (y == 2 ? 0.07 : 0.0), low = -0.45 + 0.3 * y;
      builder.addPolygon("tile", square(left, low, left + 0.3, low + 0.3, 0, true));
    }
  builder.addPolygon("plate", square(-0.2, -0.45, 0.4, 0.3, 0.25, false));
  builder.addPolygon("triangle", {{-0.45, -0.45, 0.4}, {-0.15, 0.15, 0.4}, {0.45, -0.15, 0.4}});
  return builder.scene;
}

Scene makeDuplicates() {
  SceneBuilder builder;
  for (const bool up : {true, false, true, false}) builder.addPolygon("same", square(-0.3, -0.3, 0.3, 0.3, 0, up));
  builder.addPolygon("part", square(-0.3, -0.1, 0.3, 0.5, 0, true));
  builder.addPolygon("roof", square(-0.4, -0.3, 0.2, 0.3, 0.25, false));
  builder.addPolygon("roof", square(-0.4, -0.3, 0.2, 0.3, 0.25, true));
  return builder.scene;
}

Scene makeCreases() {
  SceneBuilder builder;
  const glm::dvec3 a(-0.3, 0, 0.1), b(0.4, 0, 0);
  for (int leaf = 0; leaf < 5; ++leaf) {
    const double angle_rad = 0.3 + 0.35 * leaf;
    const glm::dvec3 out = 0.5 * glm::dvec3(0.1 * leaf, std::cos(angle_rad), std::sin(angle_rad));
    builder.addPolygon("leaf", {a, b, b + out, a + out});
  }
  builder.addPolygon("below", square(-0.4, -0.4, 0.4, 0.5, -0.3, true));
  return builder.scene;
}

Scene makeSoup(uint32_t triangle_count, uint32_t seed) {
  SceneBuilder builder;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] { return glm::dvec3(uniform(random), uniform(random), uniform(random)); };
  struct Ball {
    glm::dvec3 centre;
    double radius;
  };
  std::vector<Ball> balls;
  const double largest = 0.6 / std::cbrt(static_cast<double>(triangle_count));
  while (balls.size() < triangle_count) {
    const Ball ball{0.55 * point(), largest * (0.6 + 0.4 * uniform(random))};
    const auto meets = [&](const Ball& other) {
      return glm::distance(ball.centre, other.centre) < ball.radius + other.radius;
    };
    if (std::any_of(balls.begin(), balls.end(), meets)) continue;
    balls.push_back(ball);
    Corners corners;
    for (int k = 0; k < 3; ++k) corners.push_back(ball.centre + ball.radius * glm::normalize(point()));
    builder.addPolygon("triangle", corners);
  }
  return builder.scene;
}

Scene makeOffice(uint32_t desks_per_side, uint32_t subdivision) {
  SceneBuilder builder;
  const auto add = [&](const std::string& name, const glm::dvec3& low, const glm::dvec3& high, bool inwards,
                       uint32_t parts) {
    for (const Corners& quad : boxQuads(low, high, inwards))
      for (const Corners& part : subdivide(quad, parts)) builder.addPolygon(name, part);
  };
  add("room", {-0.6, -0.6, -0.3}, {0.6, 0.6, 0.3}, true, 2 * subdivision);
  for (uint32_t y = 0; y < desks_per_side; ++y)
    for (uint32_t x = 0; x < desks_per_side; ++x) {
      const double size = 0.8 / desks_per_side;
      const glm::dvec3 origin(-0.55 + 1.1 / desks_per_side * x, -0.55 + 1.1 / desks_per_side * y, -0.3);
      add("desk", origin + glm::dvec3(0, 0, 0.15), origin + glm::dvec3(size, 0.6 * size, 0.17), false, subdivision);
      for (const glm::dvec2 leg : {glm::dvec2(0, 0), glm::dvec2(0.9, 0), glm::dvec2(0, 0.5), glm::dvec2(0.9, 0.5)}) {
        const glm::dvec3 foot = origin + glm::dvec3(size * leg, 0);
        add("leg", foot, foot + glm::dvec3(0.1 * size, 0.1 * size, 0.15), false, subdivision);
      }
    }
  return builder.scene;
}

}  // namespace viewpeel::tests

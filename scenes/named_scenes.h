// These functions make named scenes for tests, as a reader would make them of a file.
#pragma once
#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include <viewpeel/engine.h>
#include <viewpeel/scene.h>

namespace viewpeel::test_scenes {

using Corners = std::vector<glm::dvec3>;

inline void addFace(InputScene& scene, const std::string& surface, const Corners& corners) {
  if (scene.surface_names.empty() || scene.surface_names.back() != surface) scene.surface_names.push_back(surface);
  scene.faces.push_back({corners, static_cast<uint32_t>(scene.surface_names.size() - 1), 0});
}

// Returns a parallelogram from `origin` with sides a and b, counter-clockwise.
inline Corners parallelogram(glm::dvec3 origin, glm::dvec3 a, glm::dvec3 b) {
  return {origin, origin + a, origin + a + b, origin + b};
}

// A BoxSide is one of the six faces of an axis-parallel box: a parallelogram from `origin`, a x b along its front.
struct BoxSide {
  glm::dvec3 origin, a, b;
};

// Returns the sides of a box, fronts inward or outward: -x, +x, -y, +y, -z, +z.
inline std::array<BoxSide, 6> sidesOfBox(glm::dvec3 low, glm::dvec3 high, bool inward) {
  const glm::dvec3 size = high - low;
  std::array<BoxSide, 6> sides;
  for (int axis = 0; axis < 3; ++axis)
    for (int upper = 0; upper < 2; ++upper) {
      BoxSide side{low, glm::dvec3(0), glm::dvec3(0)};
      if (upper) side.origin[axis] = high[axis];
      side.a[(axis + 1) % 3] = size[(axis + 1) % 3];
      side.b[(axis + 2) % 3] = size[(axis + 2) % 3];
      if ((upper == 1) == inward) std::swap(side.a, side.b);
      sides[2 * axis + upper] = side;
    }
  return sides;
}

// Adds the sides of a box, all in one surface, or each in a surface "namex0", "namex1", and so on.
inline void addBox(InputScene& scene, const std::string& surface, glm::dvec3 low, glm::dvec3 high, bool inward,
                   bool face_names = false) {
  const std::array<BoxSide, 6> sides = sidesOfBox(low, high, inward);
  for (size_t k = 0; k < sides.size(); ++k)
    addFace(scene, face_names ? surface + "xyz"[k / 2] + "01"[k % 2] : surface,
            parallelogram(sides[k].origin, sides[k].a, sides[k].b));
}

// Returns two unit squares that face each other at distance 1.
inline InputScene parallelSquares() {
  InputScene scene{"parallel squares", {}, {}};
  addFace(scene, "lower", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  addFace(scene, "upper", {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}});
  return scene;
}

// Returns two squares with edges of length `edge` that face each other at `height`, each in cuts x cuts parts. Faces
// alternate: a part of the lower square, then the part above it.
inline InputScene squaresInParts(uint32_t cuts, double edge, double height) {
  InputScene scene{"two squares in parts", {"low", "high"}, {}};
  for (uint32_t k = 0; k < cuts * cuts; ++k) {
    const uint32_t column = k % cuts, row = k / cuts;
    const double x = edge * column, y = edge * row;
    scene.faces.push_back({parallelogram({x, y, 0}, {edge, 0, 0}, {0, edge, 0}), 0, 0});
    scene.faces.push_back({parallelogram({x, y, height}, {0, edge, 0}, {edge, 0, 0}), 1, 0});
  }
  return scene;
}

// Returns two squares far apart that see each other past the edge of a third polygon. About one direction in 200 meets
// both.
inline InputScene squaresPastAnEdge(double edge = 0.4) {
  InputScene scene{"squares past an edge", {}, {}};
  addFace(scene, "lower", {{0, 0, 0}, {0.5, 0, 0}, {0.5, 0.5, 0}, {0, 0.5, 0}});
  addFace(scene, "upper", {{0, 0, 6}, {0, 0.5, 6}, {0.5, 0.5, 6}, {0.5, 0, 6}});
  addFace(scene, "blocker", {{-0.1, -1, 3}, {edge, -1, 3}, {edge, 1, 3}, {-0.1, 1, 3}});
  return scene;
}

// Returns parallel squares with a smaller one between them, off their middle.
inline InputScene squaresPastABlocker() {
  InputScene scene = parallelSquares();
  addFace(scene, "blocker", {{0.2, 0.1, 0.4}, {0.7, 0.1, 0.4}, {0.7, 0.6, 0.4}, {0.2, 0.6, 0.4}});
  return scene;
}

// Returns two unit squares at a right angle that share an edge.
inline InputScene perpendicularSquares() {
  InputScene scene{"perpendicular squares", {}, {}};
  addFace(scene, "floor", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  addFace(scene, "wall", {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}});
  return scene;
}

inline InputScene insideOfCube() {
  InputScene scene{"inside of a cube", {}, {}};
  addBox(scene, "", {0, 0, 0}, {1, 1, 1}, true, true);
  return scene;
}

// Returns a cube of edge `inner` in the middle of a cube of edge 1.
inline InputScene cubeInCube(double inner) {
  InputScene scene{"cube in cube", {}, {}};
  addBox(scene, "outer", {0, 0, 0}, {1, 1, 1}, true);
  addBox(scene, "inner", glm::dvec3(0.5 - inner / 2), glm::dvec3(0.5 + inner / 2), false);
  return scene;
}

// Returns unit squares above one another at the given heights. Squares of even index face up, of odd index down.
inline InputScene stackOfSheets(const std::vector<double>& heights) {
  InputScene scene{"stack of sheets", {}, {}};
  for (size_t k = 0; k < heights.size(); ++k) {
    const double z = heights[k];
    Corners corners{{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}};
    if (k % 2) std::reverse(corners.begin(), corners.end());
    addFace(scene, "sheet" + std::to_string(k), corners);
  }
  return scene;
}

// Returns a closed room of patches with boxes in it that touch its floor and each other: T-junctions, coplanar and
// touching polygons.
inline InputScene roomWithTouchingBoxes() {
  InputScene scene{"room with touching boxes", {}, {}};
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y) addFace(scene, "floor", parallelogram({x, y, 0}, {1, 0, 0}, {0, 1, 0}));
  for (int x = 0; x < 3; ++x) addFace(scene, "ceiling", parallelogram({x * 4 / 3.0, 0, 3}, {0, 4, 0}, {4 / 3.0, 0, 0}));
  addFace(scene, "walls", parallelogram({0, 0, 0}, {0, 4, 0}, {0, 0, 3}));
  addFace(scene, "walls", parallelogram({4, 0, 0}, {0, 0, 3}, {0, 4, 0}));
  addFace(scene, "walls", parallelogram({0, 0, 0}, {0, 0, 3}, {4, 0, 0}));
  addFace(scene, "walls", parallelogram({0, 4, 0}, {4, 0, 0}, {0, 0, 3}));
  addBox(scene, "lower box", {0.5, 0.5, 0}, {2, 1.75, 1}, false);
  addBox(scene, "upper box", {0.75, 0.75, 1}, {1.5, 1.5, 1.5}, false);
  addBox(scene, "box at wall", {3, 2, 0}, {4, 3, 2}, false);
  return scene;
}

// Returns triangles of random size and direction in a ball, with random fronts. They may cross, so the scene is for
// tests that compare two engines.
inline InputScene triangleSoup(int count, double size, uint64_t seed) {
  InputScene scene{std::string("triangle soup, seed ").append(std::to_string(seed)), {}, {}};
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] { return glm::dvec3(uniform(random), uniform(random), uniform(random)); };
  for (int k = 0; k < count; ++k) {
    const glm::dvec3 centre = point();
    addFace(scene, "soup", {centre + size * point(), centre + size * point(), centre + size * point()});
  }
  return scene;
}

// Returns a scene with every face turned, scaled and moved: x -> scale R x + offset.
inline InputScene transformed(InputScene scene, const glm::dmat3& rotation, double scale, glm::dvec3 offset) {
  scene.file += ", moved";
  for (InputFace& face : scene.faces)
    for (glm::dvec3& corner : face.corners) corner = scale * (rotation * corner) + offset;
  return scene;
}

// Returns directions along axes and diagonals: polygons are edge-on, depths tie, and lattice points fall on edges.
inline std::vector<Direction> alongAxesAndEdges() {
  std::vector<Direction> directions;
  for (int axis = 0; axis < 3; ++axis)
    for (double sign : {1.0, -1.0})
      for (double offset : {0.0, 0.5}) {
        glm::dvec3 u(0), x(0);
        u[axis] = sign;
        x[(axis + 1) % 3] = 1;
        directions.push_back({x, glm::cross(u, x), u, {offset, offset}});
      }
  const glm::dvec3 u = glm::normalize(glm::dvec3(1, 1, 0)), x(0, 0, 1);
  directions.push_back({x, glm::cross(u, x), u, {0, 0}});
  return directions;
}

}  // namespace viewpeel::test_scenes

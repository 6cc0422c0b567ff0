// A Projection is a scene seen along one direction, in exact coordinates: sheared along u onto the coordinate plane
// across the largest component of u. Corners and u are doubles, so in units of a power of two everything here is an
// integer:
//   (x, y) = (p_i u_k - p_k u_i, p_j u_k - p_k u_j)      k the largest component of u, i and j the others.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <gmpxx.h>

#include "reference/exact/ball.h"
#include <viewpeel/scene.h>

namespace viewpeel::reference {

// IntegerCorners are the corners of a scene as integers, with equal ones merged: corner = integer * 2^exponent. Threads
// share them and only read.
struct IntegerCorners {
  explicit IntegerCorners(const Scene& scene);

  std::vector<std::array<mpz_class, 3>> points;
  std::vector<uint32_t> point_of_corner;  // Scene::corners -> points
  long exponent = 0;
};

// A Dyadic is the number mantissa * 2^exponent. splitDouble(x) is exactly x.
struct Dyadic {
  mpz_class mantissa;
  long exponent = 0;
};
Dyadic splitDouble(double x);
mpq_class toRational(const Dyadic& x);

// A Vertex is a corner in the projection. Points that coincide exactly are one Vertex.
struct Vertex {
  mpz_class x, y;      // units of Projection::exponent
  glm::dvec2 rounded;  // the same point, with coordinates to 1 ulp
};

struct Outline {
  uint32_t polygon = 0;            // into Scene::polygons
  bool front_up = true;            // its front faces +u
  std::vector<uint32_t> vertices;  // counter-clockwise, strictly convex, 3 or more
  glm::dvec2 low{0}, high{0};      // bounds of the exact outline
};

class Projection {
 public:
  // Shears the scene along u.
  //   In: u finite and not zero, any length. Throws: Error bad_usage otherwise.
  //   Cost: O(corners) work and memory.
  Projection(const Scene& scene, const IntegerCorners& corners, const glm::dvec3& u);

  // Returns only polygons with an area in the projection and a plane that does not contain u, in the order of the
  // scene.
  const std::vector<Outline>& outlines() const { return outlines_; }
  const std::vector<Vertex>& vertices() const { return vertices_; }

  // Returns cross(b - a, c - a), positive where a, b, c turn left. Error: the ball holds the exact value.
  Ball cross(uint32_t a, uint32_t b, uint32_t c) const;
  mpz_class exactCross(uint32_t a, uint32_t b, uint32_t c) const;
  int orientation(uint32_t a, uint32_t b, uint32_t c) const;  // exact sign of cross

  const Scene& scene() const { return scene_; }
  const glm::dvec3& u() const { return u_; }  // scaled by a power of two to a largest component in [1/2, 1)
  int axis() const { return axis_; }
  long exponent() const { return exponent_; }

  // Returns the factor that makes twice an area in `rounded` coordinates an area in P(u).    Error: 4 ulp.
  double areaFactor() const;

  // Returns the distance in P(u) of two vertices. Error: a few ulp of the coordinates.
  double lengthInProjection(uint32_t a, uint32_t b) const;

 private:
  std::vector<uint32_t> makeOutline(const Polygon& polygon, const std::vector<uint32_t>& vertex_of_corner) const;

  const Scene& scene_;
  glm::dvec3 u_;
  int axis_ = 2;
  long exponent_ = 0;
  double largest_ = 0;  // |coordinate| of all vertices
  std::vector<Vertex> vertices_;
  std::vector<Outline> outlines_;
};

// Returns the exact sign of normal . u.
int slope(const glm::dvec3& normal, const glm::dvec3& u);

}  // namespace viewpeel::reference

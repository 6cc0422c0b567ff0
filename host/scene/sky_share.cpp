#include "scene/sky_share.h"

#include <array>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

#include "scene/sight.h"

namespace viewpeel {
namespace {

using glm::dvec3;

constexpr uint32_t kSets = 8, kRays = 8192;  // rays of a set
constexpr double kLeastCosine = 0.01;        // as Sight's

// Triangles of the polygons, with the sums of their areas.
struct Triangles {
  std::vector<std::array<dvec3, 3>> corners;
  std::vector<uint32_t> polygon;
  std::vector<double> sums;

  Triangles(const Scene& scene, const std::vector<uint32_t>& polygons) {
    for (const uint32_t k : polygons) {
      const dvec3* c = &scene.corners[scene.polygons[k].first_corner];
      for (uint32_t j = 1; j + 1 < scene.polygons[k].corner_count; ++j) {
        corners.push_back({c[0], c[j], c[j + 1]});
        polygon.push_back(k);
        sums.push_back((sums.empty() ? 0 : sums.back()) + glm::length(glm::cross(c[j] - c[0], c[j + 1] - c[0])));
      }
    }
  }
};

// Points of four dimensions fill the unit cube evenly: multiples of powers of 1/g, g^5 = g + 1, from a random start.
class Points {
 public:
  explicit Points(Sight& sight) {
    constexpr double kRoot = 1.1673039782614187;
    for (size_t d = 0; d < 4; ++d) at_[d] = sight.uniform(), step_[d] = std::pow(kRoot, -double(d + 1));
  }
  const std::array<double, 4>& next() {
    for (size_t d = 0; d < 4; ++d) at_[d] = at_[d] + step_[d] < 1 ? at_[d] + step_[d] : at_[d] + step_[d] - 1;
    return at_;
  }

 private:
  std::array<double, 4> at_, step_;
};

// Returns the share of one set of rays.
double shareOf(Sight& sight, const Triangles& triangles, const dvec3& normal) {
  const dvec3 across = glm::normalize(glm::cross(normal, std::abs(normal.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const dvec3 along = glm::cross(normal, across);
  uint32_t rays[2] = {0, 0}, out[2] = {0, 0};  // down, up
  Points points(sight);
  for (uint32_t k = 0; k < kRays; ++k) {
    const std::array<double, 4>& x = points.next();
    const double place = x[0] * triangles.sums.back();
    const uint32_t t = pickBySums(triangles.sums, place);
    const double before = t ? triangles.sums[t - 1] : 0;
    double u = (place - before) / (triangles.sums[t] - before), v = x[1];
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const std::array<dvec3, 3>& c = triangles.corners[t];
    const double height = std::sqrt(kLeastCosine * kLeastCosine + (1 - kLeastCosine * kLeastCosine) * x[2]);
    const double angle = 2 * std::numbers::pi * x[3], radius = std::sqrt(1 - height * height);
    const dvec3 direction = height * normal + radius * (std::cos(angle) * across + std::sin(angle) * along);
    const bool is_up = direction.z > 0;
    ++rays[is_up];
    const Sight::End end = sight.look(triangles.polygon[t], c[0] + u * (c[1] - c[0]) + v * (c[2] - c[0]), direction);
    out[is_up] += end.polygon == Sight::kNothing;
  }
  const auto part = [&](int up) { return rays[up] ? (1 + (up ? normal.z : -normal.z)) / 2 * out[up] / rays[up] : 0.0; };
  return part(0) + part(1) > 0 ? part(1) / (part(0) + part(1)) : 0.5;
}

}  // namespace

std::vector<SkyShare> findSkyShares(const Scene& scene, const std::vector<std::vector<uint32_t>>& polygons) {
  Sight sight(scene);
  std::vector<SkyShare> shares;
  for (const std::vector<uint32_t>& of_surface : polygons) {
    const Triangles triangles(scene, of_surface);
    const dvec3 normal = frontNormal(scene, scene.polygons[of_surface.front()]);
    double sum = 0, squares = 0;
    for (uint32_t set = 0; set < kSets; ++set) {
      const double share = shareOf(sight, triangles, normal);
      sum += share, squares += share * share;
    }
    const double variance = std::max(0.0, squares / kSets - sum / kSets * (sum / kSets)) / (kSets - 1);
    shares.push_back({sum / kSets, std::sqrt(variance)});
  }
  return shares;
}

}  // namespace viewpeel

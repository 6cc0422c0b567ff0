#include "cpu_twin.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include <glm/glm.hpp>

namespace viewpeel {
namespace {

struct Point {
  int64_t x, y;
};

// Twice the signed area of a triangle.
int64_t cross(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

struct Flat {
  std::vector<Point> corners;  // snapped, counter-clockwise
  bool front_up = false;
  double z_min = 2, z_max = -2;
  int64_t z0 = 0, zx = 0, zy = 0;
  int shift = 0;
  int64_t low = 0, high = 0;

  bool covers(Point p) const {
    for (size_t k = 0; k < corners.size(); ++k) {
      const Point a = corners[k], b = corners[(k + 1) % corners.size()];
      if (a.x == b.x && a.y == b.y) continue;
      const int64_t side = cross(a, b, p);
      if (side < 0 || (side == 0 && (b.y < a.y || (b.y == a.y && b.x < a.x)))) return false;
    }
    return true;
  }
};

double dotInOrder(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Flat flatten(const Scene& scene, const Polygon& polygon, const Direction& direction, int resolution, int bits) {
  Flat flat;
  const double per_spacing = resolution * 0.5, unit = std::ldexp(1.0, 27);
  for (uint32_t k = 0; k < polygon.corner_count; ++k) {
    const glm::dvec3& corner = scene.corners[polygon.first_corner + k];
    const auto snap = [&](const glm::dvec3& axis, double offset) {
      return static_cast<int64_t>(std::floor((dotInOrder(corner, axis) * per_spacing + offset) * std::ldexp(1.0, bits) + 0.5));
    };
    flat.corners.push_back({snap(direction.x_axis, direction.offset.x), snap(direction.y_axis, direction.offset.y)});
    const double z = dotInOrder(corner, direction.u);
    flat.z_min = std::min(flat.z_min, z);
    flat.z_max = std::max(flat.z_max, z);
  }
  int64_t twice_area = 0;
  for (size_t k = 2; k < flat.corners.size(); ++k) twice_area += cross(flat.corners[0], flat.corners[k - 1], flat.corners[k]);
  if (twice_area == 0) {
    flat.corners.clear();
    return flat;
  }
  flat.front_up = twice_area > 0;
  if (!flat.front_up) std::reverse(flat.corners.begin(), flat.corners.end());

  const Plane& plane = scene.planes[polygon.plane];
  const double nx = dotInOrder(plane.normal, direction.x_axis), ny = dotInOrder(plane.normal, direction.y_axis);
  const double nz = dotInOrder(plane.normal, direction.u);
  const double dx = -nx / (nz * per_spacing) * unit, dy = -ny / (nz * per_spacing) * unit;
  const double d0 = (plane.offset / nz + 1.0) * unit - dx * direction.offset.x - dy * direction.offset.y;
  const int exponent = std::ilogb(std::abs(d0) + (std::abs(dx) + std::abs(dy)) * resolution + 1.0);
  if (std::abs(nz) > 1e-12 && exponent < 60) {
    flat.shift = std::min(60 - exponent, 30);
    const auto fixed = [&](double d) { return static_cast<int64_t>(std::floor(std::ldexp(d, flat.shift) + 0.5)); };
    flat.z0 = fixed(d0);
    flat.zx = fixed(dx);
    flat.zy = fixed(dy);
  } else {
    flat.z0 = static_cast<int64_t>((0.5 * (flat.z_min + flat.z_max) + 1.0) * unit);
  }
  const double slack = 4.0 + 2.0 * std::min(1.0 / std::max(std::abs(nz), 1e-30), 1e6);
  flat.low = static_cast<int64_t>(std::max((flat.z_min + 1.0) * unit - slack, 0.0));
  flat.high = static_cast<int64_t>(std::min((flat.z_max + 1.0) * unit + slack, 2.0 * unit));
  return flat;
}

}  // namespace

PairCounts countPairsOnCpu(const Scene& scene, const Ids& ids, const std::vector<Direction>& directions, int resolution,
                           Fault fault) {
  const int bits = 25 - std::bit_width(static_cast<uint32_t>(resolution / 2 + 1));
  const int64_t one = int64_t(1) << bits;
  std::map<std::pair<uint32_t, uint32_t>, uint64_t> counters;
  const auto add = [&](uint32_t i, uint32_t j) { ++counters[{std::min(i, j), std::max(i, j)}]; };
  for (const Direction& direction : directions) {
    std::vector<Flat> flats;
    for (const Polygon& polygon : scene.polygons) flats.push_back(flatten(scene, polygon, direction, resolution, bits));
    const int reach = resolution / 2 + 2;
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        std::vector<std::tuple<int64_t, bool, uint32_t>> layers;  // depth, front down, polygon
        for (uint32_t k = 0; k < flats.size(); ++k)
          if (!flats[k].corners.empty() && flats[k].covers({x * one, y * one})) {
            const int64_t z = (flats[k].z0 + flats[k].zx * x + flats[k].zy * y) >> flats[k].shift;
            layers.emplace_back(std::clamp(z, flats[k].low, flats[k].high), !flats[k].front_up, k);
          }
        std::sort(layers.begin(), layers.end());
        if (fault == Fault::last_layer_dropped && !layers.empty()) layers.pop_back();
        if (fault == Fault::two_depths_swapped && layers.size() > 3) std::swap(layers[1], layers[2]);
        for (size_t k = 0; k <= layers.size() && !layers.empty(); ++k) {
          const bool has_lower = k > 0, has_upper = k < layers.size();
          const uint32_t lower = has_lower ? ids.of_polygon[std::get<2>(layers[k - 1])] : 0;
          const uint32_t upper = has_upper ? ids.of_polygon[std::get<2>(layers[k])] : 0;
          const bool lower_sees = has_lower && (ids.two_sided || !std::get<1>(layers[k - 1]));
          const bool upper_sees = has_upper && (ids.two_sided || std::get<1>(layers[k]));
          if (lower_sees && upper_sees) add(lower, upper);
          else if (lower_sees) add(lower, has_upper ? kLeak : kEnvironment);
          else if (upper_sees) add(upper, has_lower ? kLeak : kEnvironment);
        }
      }
  }
  PairCounts counts;
  for (const auto& [key, count] : counters) counts.push_back({key.first, key.second, count});
  return counts;
}

}  // namespace viewpeel

#include "tests/support/cpu_twin.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>

#include <glm/glm.hpp>

namespace viewpeel {
namespace {

struct Point {
  int64_t x, y;
};

// Returns twice the signed area of a triangle.
int64_t cross(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

struct Flat {
  std::vector<Point> corners;  // snapped, counter-clockwise
  bool front_up = false;
  int place_at_tie = 0;  // order along +u among polygons of equal depth
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
      return static_cast<int64_t>(
          std::floor((dotInOrder(corner, axis) * per_spacing + offset) * std::ldexp(1.0, bits) + 0.5));
    };
    flat.corners.push_back({snap(direction.x_axis, direction.offset.x), snap(direction.y_axis, direction.offset.y)});
    const double z = dotInOrder(corner, direction.u);
    flat.z_min = std::min(flat.z_min, z);
    flat.z_max = std::max(flat.z_max, z);
  }
  int64_t twice_area = 0;
  for (size_t k = 2; k < flat.corners.size(); ++k)
    twice_area += cross(flat.corners[0], flat.corners[k - 1], flat.corners[k]);
  if (twice_area == 0) {
    flat.corners.clear();
    return flat;
  }
  flat.front_up = twice_area > 0;
  flat.place_at_tie = flat.front_up ? static_cast<int>(polygon.tie_rank) : 7 - static_cast<int>(polygon.tie_rank);
  if (!flat.front_up) std::reverse(flat.corners.begin(), flat.corners.end());

  const Plane& plane = scene.planes[polygon.plane];
  const double nx = dotInOrder(plane.normal, direction.x_axis), ny = dotInOrder(plane.normal, direction.y_axis);
  const double nz = dotInOrder(plane.normal, direction.u);
  const double dx = -nx / (nz * per_spacing) * unit, dy = -ny / (nz * per_spacing) * unit;
  const double d0 = (plane.offset / nz + 1.0) * unit - dx * direction.offset.x - dy * direction.offset.y;
  const int exponent = std::ilogb(std::abs(d0) + (std::abs(dx) + std::abs(dy)) * std::max(resolution, 32) + 1.0);
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

__extension__ using Wide = __int128;
struct TwinLayer {
  int64_t depth;
  int place_at_tie;
  uint32_t polygon;
  bool front_down;
  bool operator<(const TwinLayer& other) const {
    return std::tie(depth, place_at_tie, polygon) < std::tie(other.depth, other.place_at_tie, other.polygon);
  }
};
using Layers = std::vector<TwinLayer>;

class Counters {
 public:
  Counters(const Ids& ids, bool blocked) : ids_(ids), blocked_(blocked) {}

  // Adds the gaps of one line, and the pairs that the line counts as blocked.
  void add(const Layers& layers, uint64_t weight) {
    for (size_t a = 0; blocked_ && a < layers.size(); ++a)
      for (size_t b = a + 2; b < layers.size(); ++b) {
        if (!ids_.two_sided && (layers[a].front_down || !layers[b].front_down)) continue;
        const uint32_t near = layers[a].polygon, far = layers[b].polygon;
        if (areRequested(near, far)) counterOf(ids_.of_polygon[near], ids_.of_polygon[far]).second += weight;
      }
    for (size_t k = 0; k <= layers.size() && !layers.empty(); ++k) {
      const bool has_lower = k > 0, has_upper = k < layers.size();
      const uint32_t lower = has_lower ? layers[k - 1].polygon : 0, upper = has_upper ? layers[k].polygon : 0;
      const bool lower_sees = has_lower && (ids_.two_sided || !layers[k - 1].front_down);
      const bool upper_sees = has_upper && (ids_.two_sided || layers[k].front_down);
      const bool lower_emits = ids_.rolesOf(lower) & kEmits, upper_emits = ids_.rolesOf(upper) & kEmits;
      const uint32_t i = ids_.of_polygon[lower], j = ids_.of_polygon[upper];
      if (lower_sees && upper_sees) {
        if (areRequested(lower, upper)) counterOf(i, j).first += weight;
      } else if (ids_.counts_environment && lower_sees && lower_emits) {
        counterOf(i, has_upper ? kLeak : kEnvironment).first += weight;
      } else if (ids_.counts_environment && upper_sees && upper_emits) {
        counterOf(j, has_lower ? kLeak : kEnvironment).first += weight;
      }
    }
  }

  PairCounts counts() const {
    PairCounts all;
    for (const auto& [key, numbers] : counters_) all.push_back({key.first, key.second, numbers.first, numbers.second});
    return all;
  }

 private:
  bool areRequested(uint32_t a, uint32_t b) const {
    const uint32_t a_roles = ids_.rolesOf(a), b_roles = ids_.rolesOf(b);
    return ((a_roles & kEmits) && (b_roles & kReceives)) || ((b_roles & kEmits) && (a_roles & kReceives));
  }
  std::pair<uint64_t, uint64_t>& counterOf(uint32_t i, uint32_t j) {
    return counters_[{std::min(i, j), std::max(i, j)}];
  }

  const Ids& ids_;
  bool blocked_;
  std::map<std::pair<uint32_t, uint32_t>, std::pair<uint64_t, uint64_t>> counters_;  // facing, blocked
};

// Returns the columns [low, high) of row y that a polygon covers, in units of 2^-column_bits of a spacing. Bisection
// from a column inside finds both ends, by the covering test.
std::pair<int64_t, int64_t> spanOf(const Flat& flat, int64_t y, int column_bits, int bits) {
  const int64_t unit = int64_t(1) << (bits - column_bits);
  const auto covers = [&](int64_t column) { return flat.covers({column * unit, y << bits}); };
  // A column inside must lie near one of the places where the row crosses edges.
  std::vector<int64_t> crossings;
  for (size_t k = 0; k < flat.corners.size(); ++k) {
    const Point a = flat.corners[k], b = flat.corners[(k + 1) % flat.corners.size()];
    if (a.y == b.y) {
      if (a.y == y << bits) crossings.insert(crossings.end(), {a.x / unit, b.x / unit});
      continue;
    }
    if (std::min(a.y, b.y) <= y << bits && y << bits <= std::max(a.y, b.y))
      crossings.push_back(static_cast<int64_t>(std::floor(
          (double(a.x) + double(b.x - a.x) * double((y << bits) - a.y) / double(b.y - a.y)) / double(unit))));
  }
  for (int64_t crossing : crossings)
    for (int64_t inside = crossing - 2; inside <= crossing + 2; ++inside) {
      if (!covers(inside)) continue;
      const auto lastCovered = [&](int64_t step) {
        int64_t reach = inside;
        for (int64_t stride = int64_t(1) << 24; stride > 0; stride /= 2)
          while (covers(reach + step * stride)) reach += step * stride;
        return reach;
      };
      return {lastCovered(-1), lastCovered(1) + 1};
    }
  return {0, 0};
}

Layers layersAt(const std::vector<Flat>& flats, const std::vector<uint32_t>& covering, int64_t column, int64_t y,
                int column_bits) {
  Layers layers;
  for (uint32_t k : covering) {
    // Depth is computed from the first column of its cell.
    const int64_t cell = column >> (column_bits + 3) << 3, in_cell = column - (cell << column_bits);
    const int64_t z =
        (flats[k].z0 + flats[k].zx * cell + flats[k].zy * y + int64_t(Wide(flats[k].zx) * in_cell >> column_bits)) >>
        flats[k].shift;
    layers.push_back({std::clamp(z, flats[k].low, flats[k].high), flats[k].place_at_tie, k, !flats[k].front_up});
  }
  std::sort(layers.begin(), layers.end());
  return layers;
}

}  // namespace

PairCounts countPairsOnCpu(const Scene& scene, const Ids& ids, const std::vector<Direction>& directions, int resolution,
                           bool blocked, Fault fault, const Window& window) {
  const int bits =
      25 - std::bit_width(static_cast<uint32_t>(resolution / 2) +
                          static_cast<uint32_t>(std::ceil(resolution * 0.5 * glm::length(window.centre))) + 1);
  const int64_t one = int64_t(1) << bits;
  Counters counters(ids, blocked);
  for (Direction direction : directions) {
    direction.offset -= glm::floor(direction.offset + resolution * 0.5 *
                                                          glm::dvec2(dotInOrder(window.centre, direction.x_axis),
                                                                     dotInOrder(window.centre, direction.y_axis)));
    std::vector<Flat> flats;
    for (const Polygon& polygon : scene.polygons) flats.push_back(flatten(scene, polygon, direction, resolution, bits));
    const int reach = static_cast<int>(resolution * 0.5 * window.radius) + 2;
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        std::vector<uint32_t> covering;
        for (uint32_t k = 0; k < flats.size(); ++k)
          if (!flats[k].corners.empty() && flats[k].covers({x * one, y * one})) covering.push_back(k);
        Layers layers = layersAt(flats, covering, x, y, 0);
        if (fault == Fault::last_layer_dropped && !layers.empty()) layers.pop_back();
        if (fault == Fault::two_depths_swapped && layers.size() > 3) std::swap(layers[1], layers[2]);
        counters.add(layers, direction.weight);
      }
  }
  return counters.counts();
}

PairCounts countIntervalsOnCpu(const Scene& scene, const Ids& ids, const std::vector<Direction>& directions,
                               int resolution, bool blocked) {
  constexpr int kColumnBits = 10;
  constexpr int kCellColumns = 32;
  const int bits = 25 - std::bit_width(static_cast<uint32_t>(resolution / 2 + 1));
  Counters counters(ids, blocked);
  for (const Direction& direction : directions) {
    std::vector<Flat> flats;
    for (const Polygon& polygon : scene.polygons) flats.push_back(flatten(scene, polygon, direction, resolution, bits));
    const int reach = resolution / 2 + 2;
    for (int y = -reach; y <= reach; ++y) {
      std::vector<std::pair<int64_t, int64_t>> spans;
      std::vector<int64_t> ends;
      for (int64_t column = -reach - kCellColumns; column <= reach + kCellColumns; ++column)
        if (column % kCellColumns == 0) ends.push_back(column << kColumnBits);
      for (const Flat& flat : flats) {
        spans.push_back(flat.corners.empty() ? std::pair<int64_t, int64_t>(0, 0) : spanOf(flat, y, kColumnBits, bits));
        if (spans.back().first < spans.back().second)
          ends.insert(ends.end(), {spans.back().first, spans.back().second});
      }
      std::sort(ends.begin(), ends.end());
      for (size_t e = 0; e + 1 < ends.size(); ++e) {
        const int64_t from = ends[e], to = ends[e + 1], middle = (from + to - 1) >> 1;
        if (from == to) continue;
        std::vector<uint32_t> covering;
        for (uint32_t k = 0; k < flats.size(); ++k)
          if (spans[k].first <= middle && middle < spans[k].second) covering.push_back(k);
        counters.add(layersAt(flats, covering, middle, y, kColumnBits),
                     direction.weight * static_cast<uint64_t>(to - from));
      }
    }
  }
  return counters.counts();
}

}  // namespace viewpeel

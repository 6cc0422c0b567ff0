#include "unoccluded/row_exchange.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>

#include "unoccluded/far_rules.h"
#include "unoccluded/gauss.h"

namespace viewpeel {
namespace {

constexpr float kMostError = 0.05f;  // pairs with a larger relative error are computed in double precision
// Rounding moves a depth by at most this, in unit-ball units: a depth is a normal times coordinates of up to 1, three
// products in single precision.
constexpr float kRounding = 5e-7f;
// The rule's mean of max(0, depth) over a polygon is off by at most this many radii of the polygon (see addPolygon).
constexpr float kCutError = 0.1f;

constexpr size_t kLanes = RowExchange::kLanes;
// A pair is integrated in one of these ways: not at all, by the product rule, by the product rule although a plane cuts
// a polygon, or by HostUnoccluded.
constexpr int32_t kUnseen = 0, kFar = 1, kCut = 2, kNear = 4;

using Floats = RowExchange::Floats;
using Flags = RowExchange::Flags;

Floats load(const std::vector<float>& from, size_t k) {
  Floats lanes;
  std::memcpy(&lanes, &from[k], sizeof lanes);
  return lanes;
}

Floats lanesOf(float number) { return Floats{} + number; }
Floats greater(Floats a, Floats b) { return a > b ? a : b; }
Floats lengthOf(Floats x, Floats y, Floats z) {
  Floats length = x * x + y * y + z * z;
  for (size_t k = 0; k < kLanes; ++k) length[k] = std::sqrt(length[k]);
  return length;
}

}  // namespace

RowExchange::RowExchange(const Scene& scene, const Ids& ids)
    : near_(scene, 1),
      two_sided_(ids.two_sided),
      unit_(scene.scale * scene.scale),
      polygon_(scene.polygons.size()),
      bound_(farBound(2)) {
  std::iota(polygon_.begin(), polygon_.end(), 0u);
  std::stable_sort(polygon_.begin(), polygon_.end(),
                   [&](uint32_t a, uint32_t b) { return ids.of_polygon[a] < ids.of_polygon[b]; });
  const std::vector<unoccluded_data::ShapeData> shapes = makeShapes(scene);
  const std::vector<GaussPoint> rule = gaussPoints(2);
  first_.assign(ids.count() + 1, 0);
  for (uint32_t k : polygon_) {
    const unoccluded_data::ShapeData& s = shapes[k];
    id_.push_back(ids.of_polygon[k]);
    ++first_[ids.of_polygon[k] + 1];
    plane_.push_back(s.plane);
    area_.push_back(static_cast<float>(s.area));
    radius_.push_back(static_cast<float>(s.radius));
    reach_.push_back(static_cast<float>(s.reach));
    skew_.push_back(static_cast<float>(s.skew));
    const glm::dvec3 mean = meanCorner(s);
    const auto [along_u, along_v, along_uv] = stretchOf(s);
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<glm::length_t>(axis);
      middle_[axis].push_back(static_cast<float>(mean[at]));
      normal_[axis].push_back(static_cast<float>(s.normal[at]));
    }
    for (size_t p = 0; p < 4; ++p) {
      const double u = static_cast<double>(rule[p % 2].node), v = static_cast<double>(rule[p / 2].node);
      const glm::dvec3 point = mean + u * along_u + v * (along_v + u * along_uv);
      for (size_t axis = 0; axis < 3; ++axis)
        points_[p][axis].push_back(static_cast<float>(point[static_cast<glm::length_t>(axis)]));
      weights_[p].push_back(static_cast<float>(s.density + s.density_u * u + s.density_v * v));
    }
  }
  // Arrays are padded, because vector instructions read beyond the last polygon.
  const size_t padded = id_.size() + kLanes;
  plane_.resize(padded);
  for (std::vector<float>* column : {&radius_, &reach_, &skew_, &area_}) column->resize(padded);
  for (size_t axis = 0; axis < 3; ++axis) {
    middle_[axis].resize(padded);
    normal_[axis].resize(padded);
    for (size_t p = 0; p < 4; ++p) points_[p][axis].resize(padded);
  }
  for (std::vector<float>& weights : weights_) weights.resize(padded);
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
}

void RowExchange::compute(uint32_t i, std::span<BoundedExchange> later) const {
  for (uint32_t a = first_[i]; a < first_[i + 1]; ++a) addPolygon(a, first_[i + 1], later, i + 1);
}

// Adds the exchange areas of polygon a with all polygons from place `first` on.
//
// Where a plane cuts a polygon, its depth is max(0, depth). Along a line, where depth is linear, the rule's mean of it
// is off by at most 0.045 of half the range of the depth. The error is largest where the depth is 0 at a point of the
// rule. Over the square, one coordinate after the other, the error is at most twice as much. kCutError is larger,
// because weights need not be constant.
void RowExchange::addPolygon(uint32_t a, uint32_t first, std::span<BoundedExchange> later, uint32_t first_id) const {
  for (size_t start = first; start < id_.size(); start += kLanes) {
    Floats errors;
    const Flags ways = classify(a, start, errors);
    if (!(ways[0] | ways[1] | ways[2] | ways[3])) continue;
    const Floats areas = integrate(a, start);
    for (size_t k = 0; k < std::min(kLanes, id_.size() - start); ++k) {
      if (ways[k] == kUnseen) continue;
      BoundedExchange& sum = later[id_[start + k] - first_id];
      if (sum.error < 0) continue;
      const double area = areas[k], error = errors[k];
      if (ways[k] != kNear) {
        sum.area += unit_ * area;
        sum.error += unit_ * (ways[k] == kFar ? area * error : area * kMostError + error);
        continue;
      }
      for (uint32_t side = 0; side < (two_sided_ ? 4u : 1u); ++side) {
        UnoccludedWork work;
        const HostUnoccluded::Found found =
            near_.find({frontSide(polygon_[a]) + side % 2, frontSide(polygon_[start + k]) + side / 2}, work);
        sum.area += unit_ * found.area;
        sum.error += unit_ * found.error;
      }
    }
  }
}

// Returns how polygon a is integrated with each of kLanes polygons from place `start` on (kUnseen, kFar, kCut, kNear).
//   Out: errors: bounds on the relative errors; for kCut, bounds on the error from the cut, unit-ball units squared
RowExchange::Flags RowExchange::classify(uint32_t a, size_t start, Floats& errors) const {
  // Returns the bound on the rule's relative error over a polygon's two coordinates, as errorOf in
  // shaders/unoccluded/classify.comp. The slope of the depth is at most the reach over the least depth.
  const auto errorOf = [this](Floats reach, Floats other_radius, Floats skew, Floats distance, Floats depth) {
    const Floats t = reach / greater(distance - reach - other_radius, reach), square = t * t,
                 slope = reach / greater(depth - reach, reach), product = slope * skew;
    const Floats stretch = (1 + t) * (1 + t), rest = bound_.tail * square,
                 series = bound_.even * square + bound_.odd * (slope + skew) * t + bound_.skew * product;
    // 1 / (1 - x / 3) is at most 1 + x / 2 for x <= 1.
    const Floats error = 2 * stretch * stretch * (1 + product / 2) * square * series * (1 + 2 * rest);
    return rest < 0.5f ? error : lanesOf(1);
  };
  const Floats none{}, x = load(middle_[0], start) - middle_[0][a], y = load(middle_[1], start) - middle_[1][a],
                       z = load(middle_[2], start) - middle_[2][a], distance = lengthOf(x, y, z);
  Floats depth_b = normal_[0][a] * x + normal_[1][a] * y + normal_[2][a] * z,
         depth_a = -(load(normal_[0], start) * x + load(normal_[1], start) * y + load(normal_[2], start) * z);
  if (two_sided_) {
    depth_b = greater(depth_b, -depth_b);
    depth_a = greater(depth_a, -depth_a);
  }
  const Floats radius_a = lanesOf(radius_[a]), radius_b = load(radius_, start),
               least_b = depth_b - radius_b - kRounding, least_a = depth_a - radius_a - kRounding;
  Flags is_one_plane;
  for (size_t k = 0; k < kLanes; ++k) is_one_plane[k] = plane_[start + k] >> 1 == plane_[a] >> 1 ? -1 : 0;
  const Flags is_behind = (depth_b < -radius_b - kRounding) | (depth_a < -radius_a - kRounding) |
                          (is_one_plane & (distance > radius_a + radius_b));
  if (is_behind[0] & is_behind[1] & is_behind[2] & is_behind[3]) return Flags{} + kUnseen;
  const Flags cuts_b = least_b <= 0, cuts_a = least_a <= 0, cuts = cuts_a | cuts_b;
  const Floats clear = greater(distance - radius_a - radius_b, lanesOf(1e-9f)), rounding = lanesOf(kRounding);
  const Floats error = errorOf(load(reach_, start), radius_a, load(skew_, start), distance, depth_b) +
                       errorOf(lanesOf(reach_[a]), radius_b, lanesOf(skew_[a]), distance, depth_a) +
                       4 * rounding / clear + (cuts_b ? none : rounding / greater(least_b, rounding)) +
                       (cuts_a ? none : rounding / greater(least_a, rounding));
  const Floats largest =
      kCutError / std::numbers::pi_v<float> * area_[a] * load(area_, start) / (clear * clear * clear * clear);
  const Floats of_cuts =
      largest * ((cuts_b ? radius_b * (depth_a + radius_a) : none) + (cuts_a ? radius_a * (depth_b + radius_b) : none));
  errors = cuts ? of_cuts : error;
  const Flags way = ((error > kMostError) | is_one_plane) ? Flags{} + kNear
                    : cuts                                ? Flags{} + (two_sided_ ? kNear : kCut)
                                                          : Flags{} + kFar;
  return is_behind ? Flags{} + kUnseen : way;
}

// Returns the exchange areas of polygon a with kLanes polygons from place `start` on by the product rule, in unit-ball
// units squared.
RowExchange::Floats RowExchange::integrate(uint32_t a, size_t start) const {
  const auto cosineOf = [this](Floats depth) { return greater(depth, two_sided_ ? -depth : Floats{}); };
  std::array<Floats, 4> over_b;
  for (size_t q = 0; q < 4; ++q)
    over_b[q] = load(weights_[q], start) * cosineOf(normal_[0][a] * (load(points_[q][0], start) - middle_[0][a]) +
                                                    normal_[1][a] * (load(points_[q][1], start) - middle_[1][a]) +
                                                    normal_[2][a] * (load(points_[q][2], start) - middle_[2][a]));
  Floats area{};
  for (size_t p = 0; p < 4; ++p) {
    Floats inner{};
    for (size_t q = 0; q < 4; ++q) {
      const Floats x = load(points_[q][0], start) - points_[p][0][a], y = load(points_[q][1], start) - points_[p][1][a],
                   z = load(points_[q][2], start) - points_[p][2][a];
      const Floats square = x * x + y * y + z * z;
      inner += over_b[q] / (square * square);
    }
    area += weights_[p][a] * inner *
            cosineOf(load(normal_[0], start) * (points_[p][0][a] - load(middle_[0], start)) +
                     load(normal_[1], start) * (points_[p][1][a] - load(middle_[1], start)) +
                     load(normal_[2], start) * (points_[p][2][a] - load(middle_[2], start)));
  }
  return area / std::numbers::pi_v<float>;
}

}  // namespace viewpeel

#include "engines/sweep.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <climits>
#include <cmath>

#include "engines/lattice.h"
#include "engines/shared.h"
#include "error.h"

namespace viewpeel {
namespace {

using device_data::kDepthBits, device_data::kScanlineCell;

constexpr std::array<const char*, 3> kPasses = {"project", "slice", "sweep"};

constexpr size_t kAhead = 8;  // spans whose surfaces are on their way from memory

double secondsNow() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// floor(x) of |x| < 2^31.
int32_t floorOf(double x) {
  const auto whole = static_cast<int32_t>(x);
  return whole - (double(whole) > x);
}

// The same bits as the shaders' (projection.glsl): the same operations in the same order.
double dotInOrder(double ax, double ay, double az, const glm::dvec3& b) { return ax * b.x + ay * b.y + az * b.z; }

int64_t divideUpward(int64_t value, int64_t by) { return value >= 0 ? (value + by - 1) / by : -(-value / by); }

}  // namespace

SweepScene::SweepScene(const Scene& scene, const Ids& ids) : two_sided(ids.two_sided), all_count(ids.roles.empty()), counts_environment(ids.counts_environment) {
  // An open-addressing table of the corners met.
  std::vector<uint32_t> places(std::bit_ceil(2 * scene.corners.size() + 1), UINT32_MAX);
  const auto placeOf = [&](const glm::dvec3& corner) {
    uint64_t hash = 0;
    for (const double c : {corner.x, corner.y, corner.z}) hash = (hash ^ std::bit_cast<uint64_t>(c)) * 0x9E3779B97F4A7C15u, hash ^= hash >> 32;
    for (size_t at = hash & (places.size() - 1);; at = (at + 1) & (places.size() - 1)) {
      uint32_t& place = places[at];
      if (place == UINT32_MAX) {
        place = static_cast<uint32_t>(x.size());
        x.push_back(corner.x);
        y.push_back(corner.y);
        z.push_back(corner.z);
      }
      if (x[place] == corner.x && y[place] == corner.y && z[place] == corner.z) return place;
    }
  };
  // Planes in the order in which polygons come to them: a pass over the polygons reads them one after the other.
  std::vector<uint32_t> number_of(scene.planes.size(), UINT32_MAX);
  const auto numberOf = [&](uint32_t plane_index) {
    uint32_t& number = number_of[plane_index];
    if (number != UINT32_MAX) return number;
    const Plane& plane = scene.planes[plane_index];
    number = static_cast<uint32_t>(offset.size());
    normal_x.push_back(plane.normal.x);
    normal_y.push_back(plane.normal.y);
    normal_z.push_back(plane.normal.z);
    offset.push_back(plane.offset);
    return number;
  };
  polygons.reserve(scene.polygons.size());
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    const viewpeel::Polygon& polygon = scene.polygons[k];
    Polygon own{{}, polygon.corner_count, numberOf(polygon.plane), ids.of_polygon[k], ids.rolesOf(k)};
    for (uint32_t c = 0; c < 4; ++c) own.corners[c] = placeOf(scene.corners[polygon.first_corner + std::min(c, polygon.corner_count - 1)]);
    polygons.push_back(own);
  }
}

Sweep::Sweep(const SweepScene& scene, const LatticeOptions& options)
    : scene_(scene),
      resolution_(options.resolution),
      window_(options.window),
      is_scanline_(options.sampling == Sampling::scanline),
      counts_blocked_(options.count_blocked),
      measures_(options.measure_work),
      fraction_bits_(chooseFractionBits(options.resolution, options.window)),
      column_bits_(is_scanline_ ? kScanlineBits : 0),
      reach_(windowReach(options.resolution, options.window)),
      snapped_x_(scene.x.size()),
      snapped_y_(scene.x.size()),
      height_(scene.x.size()),
      planes_(scene.offset.size()),
      rows_(2 * static_cast<size_t>(reach_)) {
  if (fraction_bits_ < column_bits_) throw Error(ErrorCode::bad_usage, "scanlines cannot be this fine; use --sampling lattice");
  for (const char* pass : kPasses) work_.pass_seconds.emplace_back(pass, 0);
}

uint64_t Sweep::memoryBytes() const {
  uint64_t bytes = scene_.x.size() * 16 + planes_.size() * sizeof(DepthPlane) + scene_.polygons.size() * sizeof(Surface) + layers_.capacity() * sizeof(Layer) + open_.capacity() * sizeof(Open);
  for (const std::vector<Span>& row : rows_) bytes += row.capacity() * sizeof(Span);
  return bytes;
}

void Sweep::count(const Direction& direction, PairTable& table) {
  const double start = measures_ ? secondsNow() : 0;
  project(direction);
  const double projected = measures_ ? secondsNow() : 0;
  slice(direction);
  const double sliced = measures_ ? secondsNow() : 0;
  for (size_t row = 0; row < rows_.size(); ++row) {
    if (rows_[row].empty()) continue;
    const int y = static_cast<int>(row) - reach_;
    if (scene_.all_count) counts_blocked_ ? sweepRow<true, true>(y, rows_[row], direction.weight, table) : sweepRow<true, false>(y, rows_[row], direction.weight, table);
    else counts_blocked_ ? sweepRow<false, true>(y, rows_[row], direction.weight, table) : sweepRow<false, false>(y, rows_[row], direction.weight, table);
  }
  if (!measures_) return;
  const double swept = secondsNow();
  work_.pass_seconds[0].second += projected - start;
  work_.pass_seconds[1].second += sliced - projected;
  work_.pass_seconds[2].second += swept - sliced;
}

void Sweep::project(const Direction& direction) {
  origin_ = latticeOrigin(direction, resolution_, window_);
  const double per_spacing = resolution_ * 0.5, fixed_one = double(1 << fraction_bits_);
  for (size_t k = 0; k < scene_.x.size(); ++k) {
    const double x = scene_.x[k], y = scene_.y[k], z = scene_.z[k];
    snapped_x_[k] = floorOf((dotInOrder(x, y, z, direction.x_axis) * per_spacing + origin_.x) * fixed_one + 0.5);
    snapped_y_[k] = floorOf((dotInOrder(x, y, z, direction.y_axis) * per_spacing + origin_.y) * fixed_one + 0.5);
    height_[k] = dotInOrder(x, y, z, direction.u);
  }
}

const Sweep::DepthPlane& Sweep::depthPlane(uint32_t plane_index, const Direction& direction) {
  DepthPlane& plane = planes_[plane_index];
  if (plane.turn == turn_) return plane;
  const double px = scene_.normal_x[plane_index], py = scene_.normal_y[plane_index], pz = scene_.normal_z[plane_index];
  const double per_spacing = resolution_ * 0.5, unit = double(1 << kDepthBits);
  const double nx = dotInOrder(px, py, pz, direction.x_axis), ny = dotInOrder(px, py, pz, direction.y_axis), nz = dotInOrder(px, py, pz, direction.u);
  const double dx = -nx / (nz * per_spacing) * unit, dy = -ny / (nz * per_spacing) * unit;
  const double d0 = (scene_.offset[plane_index] / nz + 1.0) * unit - dx * origin_.x - dy * origin_.y;
  const double bound = std::abs(d0) + (std::abs(dx) + std::abs(dy)) * double(std::max(resolution_, 32)) + 1.0;
  const int exponent = static_cast<int>(std::bit_cast<uint64_t>(bound) >> 52 & 0x7FF) - 1023;
  plane = {turn_, 0, 0, 0, 4.0 + 2.0 * std::min(1.0 / std::max(std::abs(nz), 1e-30), 1e6), 0, !(std::abs(nz) > 1e-12 && exponent < 60)};
  if (plane.is_edge_on) return plane;
  plane.shift = std::min(60 - exponent, 30);
  const double scale = double(1 << plane.shift);
  plane.at_origin = static_cast<int64_t>(std::floor(d0 * scale + 0.5));
  plane.per_column = static_cast<int64_t>(std::floor(dx * scale + 0.5));
  plane.per_row = static_cast<int64_t>(std::floor(dy * scale + 0.5));
  return plane;
}

// False where it covers nothing in the window.
bool Sweep::outlineOf(const SweepScene::Polygon& polygon, Outline& outline) const {
  // Many small polygons lie between two rows.
  std::array<int32_t, 4> snapped;
  for (size_t k = 0; k < 4; ++k) snapped[k] = snapped_y_[polygon.corners[k]];
  const auto [low_y, high_y] = std::minmax({snapped[0], snapped[1], snapped[2], snapped[3]});
  const auto upward = [](int64_t value, int bits) { return (value + (int64_t(1) << bits) - 1) >> bits; };
  const int64_t first_row = std::max<int64_t>(upward(low_y, fraction_bits_), -reach_), last_row = std::min<int64_t>(high_y >> fraction_bits_, reach_ - 1);
  if (first_row > last_row) return false;
  std::array<int64_t, 4> x, y;
  for (size_t k = 0; k < 4; ++k) {
    x[k] = snapped_x_[polygon.corners[k]];
    y[k] = snapped[k];
  }
  const int column_shift = fraction_bits_ - column_bits_;
  const int64_t first_column = upward(std::min({x[0], x[1], x[2], x[3]}), column_shift), last_column = std::max({x[0], x[1], x[2], x[3]}) >> column_shift;
  if (first_column > last_column) return false;
  int64_t twice_area = 0;
  for (size_t k = 1; k < 3; ++k) twice_area += (x[k] - x[0]) * (y[k + 1] - y[0]) - (y[k] - y[0]) * (x[k + 1] - x[0]);
  if (twice_area == 0) return false;
  outline.front_up = twice_area > 0;
  outline.first_row = static_cast<int32_t>(first_row);
  outline.last_row = static_cast<int32_t>(last_row);

  // Edges a X + b y 2^column_bits + c >= 0 with the top-left rule, as in geometry.glsl; all of these are below 2^53, so doubles hold them.
  const int64_t orientation = outline.front_up ? 1 : -1;
  outline.left_count = outline.right_count = 0;
  for (size_t k = 0; k < polygon.corner_count; ++k) {
    const size_t next = k + 1 < polygon.corner_count ? k + 1 : 0;
    const int64_t along_x = (x[next] - x[k]) * orientation, along_y = (y[next] - y[k]) * orientation;
    const int64_t a = -along_y, b = along_x;
    const bool owns_points = along_y > 0 || (along_y == 0 && along_x >= 0);
    const int64_t c = (-(a * x[k] + b * y[k]) - (owns_points ? 0 : 1)) >> column_shift, per_row = b * (int64_t(1) << column_bits_);
    if (a == 0) {
      if (b > 0) outline.first_row = static_cast<int32_t>(std::max<int64_t>(outline.first_row, divideUpward(-c, per_row)));
      if (b < 0) outline.last_row = static_cast<int32_t>(std::min<int64_t>(outline.last_row, -divideUpward(-c, -per_row)));
      continue;
    }
    const size_t place = a > 0 ? outline.left_count++ : 3u - outline.right_count++;
    outline.row_0[place] = double(a > 0 ? c : -c - 1);
    outline.per_row[place] = double(a > 0 ? per_row : -per_row);
    outline.inverse[place] = -1.0 / double(std::abs(a));
  }
  return outline.first_row <= outline.last_row;
}

// The columns [first, second) of a row that a polygon covers. A crossing is the least X with |a| X + v >= 0 (left edges; right edges: the first X beyond the polygon),
// v = row_0 + per_row y exact in doubles, so X = ceil(-v / |a|). Of crossings within the window, |X| <= 2^23, v inverse is off by less than 2^-28, and -v / |a| is whole or
// at least 2^-26 from whole numbers, since |a| < 2^26: less 2^-27 it rounds up to the same.
std::pair<int32_t, int32_t> Sweep::cut(const Outline& outline, int row) const {
  double low = -double(reach_ << column_bits_), high = -low;
  const auto crossing = [&](size_t k) { return (outline.row_0[k] + outline.per_row[k] * row) * outline.inverse[k] - 0x1p-27; };
  for (size_t k = 0; k < outline.left_count; ++k) low = std::max(low, crossing(k));
  for (size_t k = 4u - outline.right_count; k < 4; ++k) high = std::min(high, crossing(k));
  const auto ceilOf = [](double x) {
    const auto whole = static_cast<int32_t>(x);
    return whole + (double(whole) < x);
  };
  if (!(low < high)) return {0, 0};
  return {ceilOf(low), ceilOf(high)};
}

// Spans by row. Where only some polygons emit, of the others no more than what shares a column with those.
void Sweep::slice(const Direction& direction) {
  ++turn_;
  surfaces_.clear();
  for (std::vector<Span>& row : rows_) row.clear();
  if (scene_.all_count) {
    for (uint32_t k = 0; k < scene_.polygons.size(); ++k) slicePolygon<true>(k, direction);
    return;
  }
  emitting_.assign(rows_.size(), {INT_MAX, INT_MIN});
  for (const bool emits : {true, false})
    for (uint32_t k = 0; k < scene_.polygons.size(); ++k)
      if (((scene_.polygons[k].roles & kEmits) != 0) == emits) slicePolygon<false>(k, direction);
}

template <bool kAllCount>
void Sweep::slicePolygon(uint32_t polygon_index, const Direction& direction) {
  const SweepScene::Polygon& polygon = scene_.polygons[polygon_index];
  Outline outline;
  if (!outlineOf(polygon, outline)) return;
  const bool emits = polygon.roles & kEmits;
  bool is_entered = false;  // among the surfaces
  for (int32_t y = outline.first_row; y <= outline.last_row; ++y) {
    const size_t row = y + reach_;
    if (!kAllCount && !emits && emitting_[row].first > emitting_[row].second) continue;
    const auto [low, high] = cut(outline, y);
    if (low >= high) continue;
    if (!kAllCount && !emits && (low >= emitting_[row].second || high <= emitting_[row].first)) continue;
    if (!kAllCount && emits) emitting_[row] = {std::min(emitting_[row].first, low), std::max(emitting_[row].second, high)};
    if (!is_entered) surfaces_.push_back(surfaceOf(polygon_index, outline.front_up, direction));
    is_entered = true;
    rows_[row].push_back({low, high, static_cast<uint32_t>(surfaces_.size() - 1)});
  }
}

Sweep::Surface Sweep::surfaceOf(uint32_t polygon_index, bool front_up, const Direction& direction) {
  const SweepScene::Polygon& polygon = scene_.polygons[polygon_index];
  const DepthPlane& plane = depthPlane(polygon.plane, direction);
  double z_min = 2, z_max = -2;
  for (uint32_t corner : polygon.corners) {
    z_min = std::min(z_min, height_[corner]);
    z_max = std::max(z_max, height_[corner]);
  }
  const double unit = double(1 << kDepthBits);
  return {plane.is_edge_on ? static_cast<int64_t>((0.5 * (z_min + z_max) + 1.0) * unit) : plane.at_origin, plane.per_column, plane.per_row,
          static_cast<int32_t>(std::max((z_min + 1.0) * unit - plane.slack, 0.0)), static_cast<int32_t>(std::min((z_max + 1.0) * unit + plane.slack, 2.0 * unit)),
          plane.shift, polygon_index, polygon.id, polygon.roles, front_up};
}

Sweep::Layer Sweep::enter(const Span& span, int row) const {
  const Surface& surface = surfaces_[span.surface];
  const int64_t whole = surface.per_column >> column_bits_;
  return {surface.at_origin + surface.per_row * row, whole, surface.per_column - whole * (int64_t(1) << column_bits_),
          surface.depth_min, surface.depth_max, surface.shift, span.high, surface.polygon, surface.id, surface.roles,
          !surface.front_up, scene_.two_sided || surface.front_up, scene_.two_sided || !surface.front_up};
}

// The order along the line through a column: depth, of equal ones fronts that face +u first, then the polygon's number (Layer.key in shaders/shared.h).
uint64_t Sweep::keyAt(const Layer& layer, int32_t column) const {
  const int64_t depth = layer.depth + layer.whole * column + (layer.rest * column >> column_bits_);
  const auto clamped = static_cast<uint64_t>(std::clamp<int64_t>(depth >> layer.shift, layer.depth_min, layer.depth_max));
  return (2 * clamped + layer.front_down) << 32 | layer.polygon;
}

// By whole columns first, each with places of its own; within them few are left to put in order.
void Sweep::sortByLow(std::span<Span> spans) {
  const auto columns = 2 * static_cast<size_t>(reach_);
  if (spans.size() < columns / 4) return std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.low < b.low; });
  const auto columnOf = [&](const Span& span) {
    const int32_t column = (span.low >> column_bits_) + reach_;
    return static_cast<size_t>(column);
  };
  places_.assign(columns + 1, 0);
  for (const Span& span : spans) ++places_[columnOf(span) + 1];
  for (size_t k = 1; k <= columns; ++k) places_[k] += places_[k - 1];
  unsorted_.assign(spans.begin(), spans.end());
  for (const Span& span : unsorted_) spans[places_[columnOf(span)]++] = span;
  if (!is_scanline_) return;
  for (size_t k = 1; k < spans.size(); ++k) {
    const Span moved = spans[k];
    size_t place = k;
    for (; place > 0 && moved.low < spans[place - 1].low; --place) spans[place] = spans[place - 1];
    spans[place] = moved;
  }
}

// Goes from one end of a span to the next. Between them the order of the polygons does not change, but for rounding: it is decided in the middle of every sample,
// a lattice point or, with scanlines, what lies between two ends in a cell of kScanlineCell columns.
template <bool kAllCount, bool kBlocked>
void Sweep::sweepRow(int row, std::span<Span> spans, uint64_t weight, PairTable& table) {
  sortByLow(spans);
  if (layers_.size() < spans.size()) layers_.resize(spans.size());
  open_.clear();
  const int32_t cell_bits = column_bits_ + std::countr_zero(kScanlineCell);
  uint32_t emitters = 0;  // among those open
  int32_t column = 0, first_end = INT_MAX;
  uint64_t waiting = 0;  // columns whose gaps have not been added yet: those of open_
  const auto settle = [&] {
    if (waiting) addGaps<kAllCount, kBlocked>(waiting * weight, table);
    waiting = 0;
  };
  size_t next = 0, samples = 0, layers = 0;
  while (next < spans.size() || !open_.empty()) {
    if (open_.empty()) column = spans[next].low;
    if (next < spans.size() && spans[next].low <= column) {
      settle();
      for (; next < spans.size() && spans[next].low <= column; ++next) {
        __builtin_prefetch(&surfaces_[spans[std::min(next + kAhead, spans.size() - 1)].surface]);
        layers_[next] = enter(spans[next], row);
        open_.push_back({0, &layers_[next]});
        first_end = std::min(first_end, spans[next].high);
        if (!kAllCount && (layers_[next].roles & kEmits)) ++emitters;
      }
    }
    int32_t end = std::min(first_end, next < spans.size() ? spans[next].low : INT_MAX);
    if (kAllCount || emitters) {
      end = std::min(end, is_scanline_ ? ((column >> cell_bits) + 1) * (1 << cell_bits) : column + 1);
      const int32_t middle = (column + end - 1) >> 1;
      bool is_sorted = true;
      uint64_t before = 0;
      for (Open& open : open_) {
        open.key = keyAt(*open.layer, middle);
        is_sorted = is_sorted && before <= open.key;
        before = open.key;
      }
      if (!is_sorted) {
        settle();
        for (size_t k = 1; k < open_.size(); ++k) {
          const Open moved = open_[k];
          size_t place = k;
          for (; place > 0 && open_[place - 1].key > moved.key; --place) open_[place] = open_[place - 1];
          open_[place] = moved;
        }
      }
      waiting += static_cast<uint32_t>(end - column);
      ++samples;
      layers += open_.size();
    }
    column = end;
    if (column < first_end) continue;
    settle();
    first_end = INT_MAX;
    size_t kept = 0;
    for (const Open& open : open_) {
      if (open.layer->high <= column) {
        if (!kAllCount && (open.layer->roles & kEmits)) --emitters;
        continue;
      }
      first_end = std::min(first_end, open.layer->high);
      open_[kept++] = open;
    }
    open_.resize(kept);
  }
  work_.rows += 1;
  work_.spans += spans.size();
  work_.samples += samples;
  work_.tests += layers;
  work_.fragments += layers;
}

template <bool kAllCount, bool kBlocked>
void Sweep::addGaps(uint64_t weight, PairTable& table) {
  const auto areAskedFor = [](const Layer& a, const Layer& b) {
    return kAllCount || ((a.roles & kEmits) && (b.roles & kReceives)) || ((b.roles & kEmits) && (a.roles & kReceives));
  };
  const auto emits = [](const Layer& layer) { return kAllCount || (layer.roles & kEmits); };
  const Layer* lower = nullptr;
  uint64_t gaps = 0;
  for (size_t k = 0; k <= open_.size(); ++k) {
    const Layer* upper = k < open_.size() ? open_[k].layer : nullptr;
    const bool lower_sees = lower && lower->sees_up, upper_sees = upper && upper->sees_down;
    const auto add = [&](uint32_t i, uint32_t j) {
      table.add(i, j, weight);
      ++gaps;
    };
    if (lower_sees && upper_sees) {
      if (areAskedFor(*lower, *upper)) add(std::min(lower->id, upper->id), std::max(lower->id, upper->id));
    } else if (scene_.counts_environment && lower_sees && emits(*lower)) {
      add(lower->id, upper ? kLeak : kEnvironment);
    } else if (scene_.counts_environment && upper_sees && emits(*upper)) {
      add(upper->id, lower ? kLeak : kEnvironment);
    }
    if (kBlocked && lower_sees)
      for (size_t m = k + 1; m < open_.size(); ++m) {
        const Layer& farther = *open_[m].layer;
        if (farther.sees_down && areAskedFor(*lower, farther)) table.addBlocked(std::min(lower->id, farther.id), std::max(lower->id, farther.id), weight);
      }
    lower = upper;
  }
  work_.gaps += gaps;
}

}  // namespace viewpeel

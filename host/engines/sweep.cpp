#include "engines/sweep.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <climits>
#include <cmath>

#include "engines/lattice.h"
#include "engines/pair_products.h"
#include "engines/pair_table.h"
#include "engines/shared.h"
#include <viewpeel/error.h>
#include "facing.h"

namespace viewpeel {
namespace {

using device_data::kDepthBits, device_data::kScanlineCell;

constexpr std::array<const char*, 3> kPasses = {"project", "slice", "sweep"};

constexpr size_t kSpansAhead = 8;  // surfaces are fetched from memory this many spans ahead

double secondsNow() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Sweep::Sweep(const SweepScene& scene, const LatticeOptions& options)
    : scene_(scene),
      resolution_(options.resolution),
      window_(options.window),
      is_scanline_(options.sampling == Sampling::scanline),
      counts_blocked_(options.count_blocked),
      splits_environment_(options.split_environment),
      measures_(options.measure_work),
      fraction_bits_(chooseFractionBits(options.resolution, options.window)),
      column_bits_(is_scanline_ ? kScanlineBits : 0),
      reach_(windowReach(options.resolution, options.window)),
      outlines_(scene, fraction_bits_, column_bits_, reach_),
      planes_(scene.offset.size()),
      rows_(2 * static_cast<size_t>(reach_)) {
  if (fraction_bits_ < column_bits_)
    throw Error(ErrorCode::bad_usage, "scanlines cannot be this fine; use --sampling lattice");
  for (const char* pass : kPasses) work_.pass_seconds.emplace_back(pass, 0);
}

uint64_t Sweep::memoryBytes() const {
  uint64_t bytes = outlines_.memoryBytes() + planes_.size() * sizeof(DepthPlane) +
                   scene_.polygons.size() * sizeof(Surface) + layers_.capacity() * sizeof(Layer) +
                   open_.capacity() * sizeof(Open);
  for (const std::vector<Span>& row : rows_) bytes += row.capacity() * sizeof(Span);
  return bytes;
}

template <class Table>
void Sweep::count(const Direction& direction, Table& table) {
  const double start = measures_ ? secondsNow() : 0;
  origin_ = latticeOrigin(direction, resolution_, window_);
  outlines_.project(direction, origin_, resolution_ * 0.5);
  const double projected = measures_ ? secondsNow() : 0;
  scene_.all_count ? slice<true>(direction) : slice<false>(direction);
  const double sliced = measures_ ? secondsNow() : 0;
  for (size_t row = 0; row < rows_.size(); ++row) {
    if (rows_[row].empty()) continue;
    const int y = static_cast<int>(row) - reach_;
    if (scene_.all_count)
      counts_blocked_ ? sweepRow<true, true>(y, rows_[row], direction.weight, table)
                      : sweepRow<true, false>(y, rows_[row], direction.weight, table);
    else
      counts_blocked_ ? sweepRow<false, true>(y, rows_[row], direction.weight, table)
                      : sweepRow<false, false>(y, rows_[row], direction.weight, table);
  }
  if (!measures_) return;
  const double swept = secondsNow();
  work_.pass_seconds[0].second += projected - start;
  work_.pass_seconds[1].second += sliced - projected;
  work_.pass_seconds[2].second += swept - sliced;
}

const Sweep::DepthPlane& Sweep::depthPlane(uint32_t plane_index, const Direction& direction) {
  DepthPlane& plane = planes_[plane_index];
  if (plane.turn == turn_) return plane;
  const double px = scene_.normal_x[plane_index], py = scene_.normal_y[plane_index], pz = scene_.normal_z[plane_index];
  const double per_spacing = resolution_ * 0.5, unit = double(1 << kDepthBits);
  const double nx = dotInOrder(px, py, pz, direction.x_axis), ny = dotInOrder(px, py, pz, direction.y_axis),
               nz = dotInOrder(px, py, pz, direction.u);
  const double dx = -nx / (nz * per_spacing) * unit, dy = -ny / (nz * per_spacing) * unit;
  const double d0 = (scene_.offset[plane_index] / nz + 1.0) * unit - dx * origin_.x - dy * origin_.y;
  const double bound = std::abs(d0) + (std::abs(dx) + std::abs(dy)) * double(std::max(resolution_, 32)) + 1.0;
  const int exponent = static_cast<int>(std::bit_cast<uint64_t>(bound) >> 52 & 0x7FF) - 1023;
  plane = {turn_,
           0,
           0,
           0,
           4.0 + 2.0 * std::min(1.0 / std::max(std::abs(nz), 1e-30), 1e6),
           0,
           !(std::abs(nz) > 1e-12 && exponent < 60)};
  if (plane.is_edge_on) return plane;
  plane.shift = std::min(60 - exponent, 30);
  const double scale = double(1 << plane.shift);
  plane.at_origin = static_cast<int64_t>(std::floor(d0 * scale + 0.5));
  plane.per_column = static_cast<int64_t>(std::floor(dx * scale + 0.5));
  plane.per_row = static_cast<int64_t>(std::floor(dy * scale + 0.5));
  return plane;
}

// Finds the spans of all rows. Where only some polygons emit, emitters come first. Other polygons then get spans in a
// row only where they reach a column between the row's first and last column with an emitter.
template <bool kAllCount>
void Sweep::slice(const Direction& direction) {
  ++turn_;
  surfaces_.clear();
  for (std::vector<Span>& row : rows_) row.clear();
  if (!kAllCount) emitting_.assign(rows_.size(), {INT_MAX, INT_MIN});
  for (size_t first = 0; first < scene_.polygons.size(); first += Outlines::kBlock) {
    outlines_.find(first);
    uint32_t entered = UINT32_MAX;  // the outline whose polygon was added to surfaces_ last
    for (Outlines::Cuts cuts = outlines_.cut(); cuts.count; cuts = outlines_.cut())
      for (size_t k = 0; k < cuts.count; ++k) {
        const int32_t low = cuts.low[k], high = cuts.high[k];
        if (low >= high) continue;
        const size_t row = cuts.rows[k] + reach_;
        const uint32_t outline = cuts.outlines[k], place = outlines_.polygonOf(outline);
        if (!kAllCount) {
          auto& [emitting_low, emitting_high] = emitting_[row];
          if (scene_.polygons[place].roles & kEmits) {
            emitting_low = std::min(emitting_low, low);
            emitting_high = std::max(emitting_high, high);
          } else if (low >= emitting_high || high <= emitting_low) {
            continue;
          }
        }
        if (entered != outline) addSurface(place, outlines_.isFrontUp(outline), direction);
        entered = outline;
        rows_[row].push_back({low, high, static_cast<uint32_t>(surfaces_.size() - 1)});
      }
  }
}

// Adds a polygon's depth along the direction to surfaces_.
//   In: place: index in SweepScene::polygons
void Sweep::addSurface(uint32_t place, bool front_up, const Direction& direction) {
  const SweepScene::Polygon& polygon = scene_.polygons[place];
  const DepthPlane& plane = depthPlane(polygon.plane, direction);
  double z_min = 2, z_max = -2;
  for (const std::vector<uint32_t>& corners : scene_.corners) {
    z_min = std::min(z_min, outlines_.height(corners[place]));
    z_max = std::max(z_max, outlines_.height(corners[place]));
  }
  const double unit = double(1 << kDepthBits);
  surfaces_.emplace_back() = {
      plane.is_edge_on ? static_cast<int64_t>((0.5 * (z_min + z_max) + 1.0) * unit) : plane.at_origin,
      plane.per_column,
      plane.per_row,
      static_cast<int32_t>(std::max((z_min + 1.0) * unit - plane.slack, 0.0)),
      static_cast<int32_t>(std::min((z_max + 1.0) * unit + plane.slack, 2.0 * unit)),
      plane.shift,
      polygon.index,
      polygon.id,
      polygon.roles,
      front_up,
      static_cast<uint8_t>(placeAtTie(front_up, polygon.tie_rank))};
}

Sweep::Layer Sweep::enter(const Span& span, int row) const {
  const Surface& surface = surfaces_[span.surface];
  const int64_t whole = surface.per_column >> column_bits_;
  return {surface.at_origin + surface.per_row * row,
          whole,
          surface.per_column - whole * (int64_t(1) << column_bits_),
          surface.depth_min,
          surface.depth_max,
          surface.shift,
          span.high,
          surface.polygon,
          surface.id,
          surface.roles,
          surface.place_at_tie,
          scene_.two_sided || surface.front_up,
          scene_.two_sided || !surface.front_up};
}

// Returns a number that orders layers along the line through a column: by depth, then by place at ties, then by polygon
// index, as Layer in shaders/shared.h.
uint64_t Sweep::keyAt(const Layer& layer, int32_t column) const {
  const int64_t depth = layer.depth + layer.whole * column + (layer.rest * column >> column_bits_);
  const auto clamped =
      static_cast<uint64_t>(std::clamp<int64_t>(depth >> layer.shift, layer.depth_min, layer.depth_max));
  return (clamped << kTieBits | layer.place_at_tie) << 32 | layer.polygon;
}

// Sorts spans by `low`. Many spans are first sorted by whole lattice columns (a counting sort). Within a column few are
// left to put in order.
void Sweep::sortByLow(std::span<Span> spans) {
  const auto columns = 2 * static_cast<size_t>(reach_);
  if (spans.size() < columns / 4)
    return std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.low < b.low; });
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

// Counts one row. It goes from one end of a span to the next; between two ends the order of the polygons is constant,
// but for rounding. A sample is a lattice point or, with scanlines, the interval between two ends within a cell of
// kScanlineCell lattice columns. The order of layers on a sample is the order in its middle.
template <bool kAllCount, bool kBlocked, class Table>
void Sweep::sweepRow(int row, std::span<Span> spans, uint64_t weight, Table& table) {
  sortByLow(spans);
  if (layers_.size() < spans.size()) layers_.resize(spans.size());
  open_.clear();
  const int32_t cell_bits = column_bits_ + std::countr_zero(kScanlineCell);
  uint32_t emitters = 0;  // layers of open_ whose polygons emit
  int32_t column = 0, first_end = INT_MAX;
  uint64_t waiting = 0;  // columns over which open_ had its present order, and whose gaps have not been added yet
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
        __builtin_prefetch(&surfaces_[spans[std::min(next + kSpansAhead, spans.size() - 1)].surface]);
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

template <bool kAllCount, bool kBlocked, class Table>
void Sweep::addGaps(uint64_t weight, Table& table) {
  const auto areRequested = [](const Layer& a, const Layer& b) {
    return kAllCount || ((a.roles & kEmits) && (b.roles & kReceives)) || ((b.roles & kEmits) && (a.roles & kReceives));
  };
  const auto emits = [](const Layer& layer) { return kAllCount || (layer.roles & kEmits); };
  const bool counts_leak = !splits_environment_ || Table::kBehind != kLeak;
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
      if (areRequested(*lower, *upper)) add(std::min(lower->id, upper->id), std::max(lower->id, upper->id));
    } else if (scene_.counts_environment && lower_sees && emits(*lower)) {
      if (!upper) add(lower->id, kEnvironment);
      else if (counts_leak) add(lower->id, kLeak);
    } else if (scene_.counts_environment && upper_sees && emits(*upper)) {
      if (!lower) add(upper->id, splits_environment_ ? Table::kBehind : kEnvironment);
      else if (counts_leak) add(upper->id, kLeak);
    }
    if (kBlocked && lower_sees)
      for (size_t m = k + 1; m < open_.size(); ++m) {
        const Layer& farther = *open_[m].layer;
        if (farther.sees_down && areRequested(*lower, farther))
          table.addBlocked(std::min(lower->id, farther.id), std::max(lower->id, farther.id), weight);
      }
    lower = upper;
  }
  work_.gaps += gaps;
}

template void Sweep::count(const Direction& direction, PairTable& table);
template void Sweep::count(const Direction& direction, PairProducts& table);

}  // namespace viewpeel

#include "engines/exchange_products.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "engines/lattice.h"
#include "engines/sweep.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr int kFactorBits = 52;
constexpr size_t kMostProductsChunk = 16;  // directions that a thread takes at once

// Returns the power of two by which a column's factors become whole numbers below 2^kFactorBits.
int exponentOf(const std::vector<double>& factors, size_t columns, size_t column) {
  double largest = 0;
  for (size_t k = column; k < factors.size(); k += columns) largest = std::max(largest, std::abs(factors[k]));
  return largest > 0 ? kFactorBits - 1 - std::ilogb(largest) : 0;
}

}  // namespace

// A Worker serves one thread. Its products are of rows, or of rows that share the lines of polygons.
struct ExchangeProducts::Worker {
  Worker(const SweepScene& scene, const LatticeOptions& options) : sweep(scene, options) {}

  void start(const std::optional<PolygonShares>& shares, std::span<const int64_t> factors, size_t columns,
             bool counts_outside) {
    is_shared = shares.has_value();
    if (is_shared) shared.start(*shares, factors, columns, counts_outside);
    else products.start(factors, columns, counts_outside);
  }
  void count(const Direction& direction) {
    sweep.count(direction, is_shared ? shared.begin(direction.u) : products);
    if (is_shared) shared.end();
  }
  void settle() {
    if (!is_shared) products.settle();
  }
  WideInteger sum(size_t row, size_t column) const {
    return is_shared ? shared.sum(row, column) : products.sum(row, column);
  }
  // Adds what a row met outside of all pairs, in the unit of outsideBits().
  void addOutside(size_t row, std::array<WideInteger, 4>& to) const {
    const auto add = [&](const auto& of_row, uint64_t within) {
      to[0] += of_row.ahead, to[1] += of_row.behind, to[2] += of_row.leak, to[3] += within;
    };
    if (is_shared) add(shared.outside(row), 0);
    else add(products.outside(row), products.outside(row).within);
  }
  int outsideBits() const { return is_shared ? SharedProducts::kOutsideBits : 0; }

  Sweep sweep;
  bool is_shared = false;
  PairProducts products;
  SharedProducts shared;
};

namespace {

// Returns ids by which each polygon is a row of its own.
Ids idsOfPolygons(const Scene& scene, bool two_sided) {
  Ids ids;
  ids.two_sided = two_sided;
  ids.of_polygon.resize(scene.polygons.size());
  std::iota(ids.of_polygon.begin(), ids.of_polygon.end(), 0u);
  return ids;
}

}  // namespace

ExchangeProducts::ExchangeProducts(const Scene& scene, const Ids& ids, const LatticeOptions& options)
    : ExchangeProducts(scene, ids, std::nullopt, ids.count(), options) {}

ExchangeProducts::ExchangeProducts(const Scene& scene, PolygonShares shares, const LatticeOptions& options)
    : ExchangeProducts(scene, idsOfPolygons(scene, shares.two_sided), std::move(shares), shares.row_count, options) {}

ExchangeProducts::ExchangeProducts(const Scene& scene, const Ids& ids, std::optional<PolygonShares> shares,
                                   uint32_t row_count, const LatticeOptions& options)
    : shares_(std::move(shares)), scene_(scene, ids), options_(options), row_count_(row_count) {
  options_.split_environment = true;
  options_.count_blocked = false;
  const size_t threads = options.thread_count ? options.thread_count : threadCount();
  for (size_t k = 0; k < threads; ++k) workers_.push_back(std::make_unique<Worker>(scene_, options_));
}

ExchangeProducts::~ExchangeProducts() = default;

double ExchangeProducts::unitArea() const {
  return pointArea(options_.resolution) / (options_.sampling == Sampling::scanline ? double(1 << kScanlineBits) : 1.0);
}

uint64_t ExchangeProducts::memoryBytes() const {
  uint64_t bytes = 0;
  for (const auto& worker : workers_)
    bytes += worker->sweep.memoryBytes() + worker->products.sizeBytes() + worker->shared.sizeBytes();
  return bytes;
}

std::vector<double> ExchangeProducts::multiply(std::span<const Direction> directions,
                                               const std::vector<double>& factors, size_t columns,
                                               std::vector<Outside>* outside) {
  std::vector<int> exponents;
  for (size_t column = 0; column < columns; ++column) exponents.push_back(exponentOf(factors, columns, column));
  std::vector<int64_t> whole(factors.size());
  for (size_t k = 0; k < factors.size(); ++k) whole[k] = std::llround(std::ldexp(factors[k], exponents[k % columns]));
  directions_of_product_ = directions.size();
  const Sums sums = summing_ ? summing_(directions, whole, columns, outside != nullptr)
                             : sum(directions, whole, columns, outside != nullptr);
  std::vector<double> products(factors.size());
  for (size_t k = 0; k < products.size(); ++k)
    products[k] = std::ldexp(static_cast<double>(sums.products[k]), -exponents[k % columns]);
  for (size_t row = 0; outside && row < row_count_; ++row) {
    const auto counts = [&](size_t k) {
      return std::ldexp(static_cast<double>(sums.outside[row][k]), -workers_.front()->outsideBits());
    };
    Outside& to = (*outside)[row];
    to = {to.ahead + counts(0), to.behind + counts(1), to.leak + counts(2), to.within + counts(3)};
  }
  return products;
}

ExchangeProducts::Sums ExchangeProducts::sum(std::span<const Direction> directions, std::span<const int64_t> factors,
                                             size_t columns, bool counts_outside) {
  for (const auto& worker : workers_) worker->start(shares_, factors, columns, counts_outside);
  const size_t chunk = std::clamp<size_t>(directions.size() / (8 * workers_.size()), 1, kMostProductsChunk);
  // Progress is shown as if others that share the directions counted as fast as this rank.
  const auto onBatch = [&](uint64_t done) {
    options_.on_batch(directions_of_product_ ? done * directions_of_product_ / directions.size() : done);
  };
  shareOut(
      workers_.size(), directions.size(), chunk,
      [&](size_t worker, size_t k) {
        if (options_.stop) options_.stop();
        workers_[worker]->count(directions[k]);
      },
      options_.on_batch ? std::function<void(uint64_t)>(onBatch) : std::function<void(uint64_t)>());
  for (const auto& worker : workers_) worker->settle();
  Sums sums{std::vector<WideInteger>(row_count_ * columns), {}};
  if (counts_outside) sums.outside.resize(row_count_);
  for (const auto& worker : workers_)
    for (size_t row = 0; row < row_count_; ++row) {
      for (size_t column = 0; column < columns; ++column)
        sums.products[row * columns + column] += worker->sum(row, column);
      if (counts_outside) worker->addOutside(row, sums.outside[row]);
    }
  return sums;
}

void ExchangeProducts::Sums::add(const Sums& other) {
  for (size_t k = 0; k < products.size(); ++k) products[k] += other.products[k];
  for (size_t row = 0; row < outside.size(); ++row)
    for (size_t k = 0; k < outside[row].size(); ++k) outside[row][k] += other.outside[row][k];
}

}  // namespace viewpeel

#include "engines/exchange_products.h"

#include <algorithm>
#include <cmath>

#include "engines/lattice.h"
#include "engines/sweep.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr int kFactorBits = 52;
constexpr size_t kMostChunk = 16;  // directions that a thread takes at once

// Returns the power of two by which a column's factors become whole numbers below 2^kFactorBits.
int exponentOf(const std::vector<double>& factors, size_t columns, size_t column) {
  double largest = 0;
  for (size_t k = column; k < factors.size(); k += columns) largest = std::max(largest, std::abs(factors[k]));
  return largest > 0 ? kFactorBits - 1 - std::ilogb(largest) : 0;
}

}  // namespace

struct ExchangeProducts::Worker {
  Worker(const SweepScene& scene, const LatticeOptions& options) : sweep(scene, options) {}
  Sweep sweep;
  PairProducts products;
};

ExchangeProducts::ExchangeProducts(const Scene& scene, const Ids& ids, const LatticeOptions& options)
    : scene_(scene, ids), options_(options), row_count_(ids.count()) {
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
  for (const auto& worker : workers_) bytes += worker->sweep.memoryBytes() + worker->products.sizeBytes();
  return bytes;
}

std::vector<double> ExchangeProducts::multiply(std::span<const Direction> directions,
                                               const std::vector<double>& factors, size_t columns,
                                               std::vector<Outside>* outside) {
  std::vector<int> exponents;
  for (size_t column = 0; column < columns; ++column) exponents.push_back(exponentOf(factors, columns, column));
  std::vector<int64_t> whole(factors.size());
  for (size_t k = 0; k < factors.size(); ++k) whole[k] = std::llround(std::ldexp(factors[k], exponents[k % columns]));
  for (const auto& worker : workers_) worker->products.start(whole, columns, outside != nullptr);
  const size_t chunk = std::clamp<size_t>(directions.size() / (8 * workers_.size()), 1, kMostChunk);
  shareOut(
      workers_.size(), directions.size(), chunk,
      [&](size_t worker, size_t k) {
        if (options_.stop) options_.stop();
        workers_[worker]->sweep.count(directions[k], workers_[worker]->products);
      },
      options_.on_batch);
  for (const auto& worker : workers_) worker->products.settle();
  std::vector<double> products(factors.size());
  for (size_t row = 0; row < row_count_; ++row) {
    for (size_t column = 0; column < columns; ++column) {
      WideInteger sum = 0;
      for (const auto& worker : workers_) sum += worker->products.sum(row, column);
      products[row * columns + column] = std::ldexp(static_cast<double>(sum), -exponents[column]);
    }
    if (!outside) continue;
    for (const auto& worker : workers_) {
      const Outside& of_worker = worker->products.outside(row);
      (*outside)[row].ahead += of_worker.ahead;
      (*outside)[row].behind += of_worker.behind;
      (*outside)[row].leak += of_worker.leak;
      (*outside)[row].own += of_worker.own;
    }
  }
  return products;
}

}  // namespace viewpeel

// ExchangeProducts multiply the exchange of all pairs of a scene by vectors, on the processor's threads, and peel the
// scene again for each product. A matrix is never made.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include "engines/outlines.h"
#include "engines/pair_products.h"
#include "engines/shared_products.h"
#include <viewpeel/ids.h>

namespace viewpeel {

class Sweep;

class ExchangeProducts {
 public:
  //   In: scene, ids: the caller keeps them alive; options: resolution, sampling, thread_count, stop and on_batch count
  //   Throws: Error bad_usage where the resolution is out of range.
  ExchangeProducts(const Scene& scene, const Ids& ids, const LatticeOptions& options);
  //   In: shares: of each polygon of the scene, which share the lines of a polygon between two rows
  ExchangeProducts(const Scene& scene, PolygonShares shares, const LatticeOptions& options);
  ~ExchangeProducts();

  // An Outside is as PairProducts::Outside, in counts. With shares its numbers have fractions.
  struct Outside {
    double ahead = 0, behind = 0, leak = 0, within = 0;
  };

  // Returns y = C x for each column, C being the symmetric matrix of the counts of facing pairs, without its diagonal.
  // Where polygons have shares, C is the matrix of their weighted counts, and has its diagonal.
  //   In: directions; factors: double[rows][columns]; outside: where given, Outside[rows], to which counts are added
  //   Out: double[rows][columns], in counts; count x unitArea() is an area in the plane of projection
  //   Error: factors are rounded to 2^-52 of the largest of their column. Sums are exact, so that any number of threads
  //     gives the same bits. With shares, C is symmetric but for rounding. Tests:
  //     tests/unit/exchange_products_test.cpp.
  //   Throws: what stop and on_batch throw.
  //   Cost: a sweep for each direction; memory of 32 bytes x rows x columns for each thread.
  std::vector<double> multiply(std::span<const Direction> directions, const std::vector<double>& factors,
                               size_t columns, std::vector<Outside>* outside = nullptr);

  // Sums are products and counts of lines outside of pairs, as whole numbers.
  struct Sums {
    std::vector<WideInteger> products;  // [rows][columns]
    std::vector<std::array<WideInteger, 4>>
        outside;  // [rows]: ahead, behind, leak, within, in 2^-outsideBits(); or empty
    // Adds sums over other directions.
    void add(const Sums& other);
  };
  // Returns the sums over these directions, counted here.
  //   In: factors: int64_t[rows][columns], sizes below 2^52
  Sums sum(std::span<const Direction> directions, std::span<const int64_t> factors, size_t columns,
           bool counts_outside);
  // Sets what multiply() calls in place of sum(), for directions that are shared with others.
  using Summing = std::function<Sums(std::span<const Direction> directions, std::span<const int64_t> factors,
                                     size_t columns, bool counts_outside)>;
  void sumBy(Summing summing) { summing_ = std::move(summing); }

  // Returns the area that one count stands for, in unit-ball units squared.
  double unitArea() const;
  uint64_t memoryBytes() const;

 private:
  struct Worker;
  ExchangeProducts(const Scene& scene, const Ids& ids, std::optional<PolygonShares> shares, uint32_t row_count,
                   const LatticeOptions& options);

  std::optional<PolygonShares> shares_;
  SweepScene scene_;
  LatticeOptions options_;
  uint32_t row_count_;
  std::vector<std::unique_ptr<Worker>> workers_;
  Summing summing_;
  uint64_t directions_of_product_ = 0;  // in the present call of multiply()
};

}  // namespace viewpeel

// PairSums adds pieces of edges up to the areas of pairs.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include <gmpxx.h>

#include "reference/exact/ball.h"
#include "reference/exact/exact_pair_areas.h"
#include "reference/exact/layers.h"
#include "reference/exact/projection.h"

namespace viewpeel::reference {

// A Piece is a part of an edge, with what it adds to boundary integrals.
struct Piece {
  Ball twice_area;          // cross(from, to) in Vertex::rounded coordinates
  double from = 0, to = 0;  // parameters along the edge
  int sign = 1;             // -1 where the piece runs from `to` to `from`
  struct Exact {
    mpq_class twice_area, dx, dy;  // units of Projection::exponent
  };
  std::optional<Exact> exact;  // with Arithmetic::exact only

  Piece operator-() const;
};

// RegionSums computes the area of the regions of each pair a < b of polygons, from pieces of their boundary.
class RegionSums {
 public:
  struct Sum {
    uint32_t a, b;
    Ball twice_area;
    std::optional<Piece::Exact> exact;
    double perimeter = 0;
  };

  // Keeps a reference.
  explicit RegionSums(const ExactOptions& options) : options_(options) {}

  void add(uint32_t a, uint32_t b, const Piece& piece);
  void closeEdge(double length);
  // Returns the areas, sorted by (a, b), without zeros.
  std::vector<PairArea> list(const Projection& projection) const;
  void appendOpenPairs(std::vector<std::array<uint32_t, 2>>& open) const;
  const std::unordered_map<uint64_t, Sum>& sums() const { return sums_; }

 private:
  struct Step {
    double at;
    int change;  // pieces that run one way, minus pieces that run the other way
  };

  const ExactOptions& options_;
  std::unordered_map<uint64_t, Sum> sums_;
  std::unordered_map<uint64_t, std::vector<Step>> steps_;  // along the current edge
};

class PairSums {
 public:
  // Keeps references.
  PairSums(const Projection& projection, const ExactOptions& options);

  // Adds the piece to the pair of the gap between two consecutive outlines (facing.h).    In: lower, upper: the
  // outlines; kNoOutline where there is none
  void addGap(uint32_t lower, uint32_t upper, const Piece& piece);
  // Adds the piece to the blocked pair of two outlines that face each other with others between them.
  void addBlocked(uint32_t lower, uint32_t upper, const Piece& piece);

  // Ends an edge, on which all pieces since the last call lie. Its length in P(u) is `length`. Pieces that run both
  // ways cancel; the other pieces bound the regions.
  void closeEdge(double length);

  // Returns all areas.    Cost: O(pairs log pairs).
  ExactPairAreas finish() const;

 private:
  uint32_t classify(uint32_t lower, uint32_t upper) const;
  std::vector<uint32_t> findOpenPolygons() const;

  const Projection& projection_;
  const ExactOptions& options_;
  RegionSums gaps_, blocked_;
};

}  // namespace viewpeel::reference

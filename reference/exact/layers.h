// Layers orders the outlines that a point of a projected edge lies in.
#pragma once
#include <cstdint>
#include <vector>

#include "reference/exact/height_order.h"

namespace viewpeel::reference {

constexpr uint32_t kNoOutline = 0xFFFFFFFFu;

// A LayerChange says how the layers change at an edge of `outline`. On the inner side of the edge the layers `lower`,
// `outline` and `upper` follow each other. On the outer side `lower` and `upper` do.
struct LayerChange {
  uint32_t lower = kNoOutline, outline = kNoOutline, upper = kNoOutline;
  bool is_cyclic = false;  // rounding has made the pairwise order cyclic, and `lower` and `upper` mean nothing
  // These list all layers of each side, with kNoOutline before and after them. They are set where the order is cyclic,
  // or where the caller wants them.
  std::vector<uint32_t> inside, outside;

  bool operator==(const LayerChange&) const = default;
};

// Layers sorts outlines by the number of outlines below them. Wherever the pairwise order has no cycle, this is the
// same order. It depends only on the set of outlines. So the layers of one face of the arrangement look the same from
// all its edges, and the boundary of a pair's regions closes. This holds even in slivers of width 1e-16, where polygons
// that meet at an edge have no meaningful order.
class Layers {
 public:
  // The order must outlive this object.    In: lists_all: list all layers of every change
  Layers(HeightOrder& order, bool lists_all) : order_(order), lists_all_(lists_all) {}

  void assign(uint32_t outline);  // starts inside an edge of `outline`, which lies in no other outline
  // Inserts an outline.    Cost: O(layers).
  void insert(uint32_t outline);
  void erase(uint32_t outline);
  const LayerChange& change() const { return change_; }

 private:
  struct Layer {
    uint32_t outline;
    uint32_t below_count;
    bool is_below_outline;
  };
  void update();
  void findNeighbours();
  void listAll();

  HeightOrder& order_;
  bool lists_all_;
  std::vector<Layer> layers_;  // the edge's outline first
  std::vector<char> taken_;
  LayerChange change_;
};

}  // namespace viewpeel::reference

// Layers is the order of the outlines that a point of a projected edge lies in.
#pragma once
#include <cstdint>
#include <vector>

#include "reference/exact/height_order.h"

namespace viewpeel::reference {

constexpr uint32_t kNoOutline = 0xFFFFFFFFu;

// A LayerChange is the change at an edge of `outline`: layers `lower`, `outline`, `upper` follow each other on its
// inner side, `lower` and `upper` on the outer.
struct LayerChange {
  uint32_t lower = kNoOutline, outline = kNoOutline, upper = kNoOutline;
  bool is_cyclic = false;  // the pairwise order, by rounding: `lower` and `upper` say nothing
  // These hold all layers of both sides between two kNoOutline, where the order is cyclic or the caller wants them.
  std::vector<uint32_t> inside, outside;

  bool operator==(const LayerChange&) const = default;
};

// Layers sorts outlines by the number of others below them. This is the pairwise order wherever it has no cycle, and it
// depends on nothing but the set of outlines. So the layers of one face look the same from all its edges, and the
// boundary of a pair's regions closes. It does so even within slivers of width 1e-16 where polygons that meet at an
// edge have no meaningful order.
class Layers {
 public:
  // Keeps a reference. lists_all: all layers of every change.
  Layers(HeightOrder& order, bool lists_all) : order_(order), lists_all_(lists_all) {}

  void assign(uint32_t outline);  // the inner side of an edge of `outline`, and nothing else
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
  std::vector<Layer> layers_;  // own first
  std::vector<char> taken_;
  LayerChange change_;
};

}  // namespace viewpeel::reference

// A Sweep counts the facing pairs along a direction for engine `host`. A span is the part of a lattice row that a
// projected polygon covers. The sweep goes along each row and sorts the polygons between any two ends of spans by
// depth.
//   Source: the scan-line algorithms, as G. S. Watkins, A real time visible surface algorithm, 1970.
#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include "engines/outlines.h"
#include "engines/work.h"

namespace viewpeel {

// A Sweep serves one thread. It counts the same as the compute engine, to the last bit.
//   Cost: per direction, O(polygons + spans log (spans of a row) + samples x layers).
class Sweep {
 public:
  //   Throws: Error bad_usage where the resolution is out of range, or too fine for scanlines.
  Sweep(const SweepScene& scene, const LatticeOptions& options);

  // Adds to the table the gaps between consecutive layers on all samples of a direction, and blocked pairs where the
  // options ask for them.
  //   In: table: a PairTable, or PairProducts, which multiply where a PairTable counts
  template <class Table>
  void count(const Direction& direction, Table& table);

  // Returns the work done so far, without Work::directions and memory_bytes.
  const Work& work() const { return work_; }
  uint64_t memoryBytes() const;

 private:
  // A DepthPlane is the depth of a scene's plane over the lattice, as in ProjectedPolygon (shaders/shared.h), in the
  // direction number `turn`.
  struct DepthPlane {
    uint64_t turn = 0;
    int64_t at_origin, per_column, per_row;
    double slack;  // depth_min and depth_max of its polygons are this much wider than their corners' depths
    int shift;
    bool is_edge_on;  // the plane contains the direction; then each of its polygons gets a constant depth of its own
  };
  // A Surface is a polygon in the present direction, in one line of the processor's cache.
  struct alignas(64) Surface {
    int64_t at_origin, per_column, per_row;  // its depth before the shift, see DepthPlane
    int32_t depth_min, depth_max, shift;
    uint32_t polygon, id, roles;
    bool front_up;
    uint8_t place_at_tie;
  };
  struct Span {
    int32_t low, high;  // columns [low, high), in units of 2^-column_bits_ spacings
    uint32_t surface;   // index in surfaces_
  };
  // A Layer is a span that the sweep has reached in its row.
  struct Layer {
    // In column X the depth before the shift is depth + whole X + (rest X >> column_bits_).
    int64_t depth, whole, rest;
    int32_t depth_min, depth_max, shift, high;
    uint32_t polygon, id, roles;
    uint8_t place_at_tie;
    bool sees_up, sees_down;  // whether a front faces +u, and -u; both hold of two-sided polygons
  };
  // An Open is a layer over the present column.
  struct Open {
    uint64_t key;  // what keyAt returns
    const Layer* layer;
  };

  template <bool kAllCount>
  void slice(const Direction& direction);
  const DepthPlane& depthPlane(uint32_t plane_index, const Direction& direction);
  void addSurface(uint32_t place, bool front_up, const Direction& direction);
  void sortByLow(std::span<Span> spans);
  Layer enter(const Span& span, int row) const;
  uint64_t keyAt(const Layer& layer, int32_t column) const;
  template <bool kAllCount, bool kBlocked, class Table>
  void sweepRow(int row, std::span<Span> spans, uint64_t weight, Table& table);
  template <bool kAllCount, bool kBlocked, class Table>
  void addGaps(uint64_t weight, Table& table);

  const SweepScene& scene_;
  const int resolution_;
  const Window window_;
  const bool is_scanline_, counts_blocked_, splits_environment_, measures_;
  const int fraction_bits_, column_bits_, reach_;
  Work work_;

  Outlines outlines_;
  std::vector<DepthPlane> planes_;
  glm::dvec2 origin_{0};  // latticeOrigin of the present direction
  uint64_t turn_ = 0;     // number of the present direction, from 1
  std::vector<Surface> surfaces_;
  std::vector<std::vector<Span>> rows_;                // spans of row -reach_ first
  std::vector<std::pair<int32_t, int32_t>> emitting_;  // of each row: its emitters lie in columns [first, second)
  std::vector<uint32_t> places_;                       // for each column, where sortByLow puts the next span
  std::vector<Span> unsorted_;
  std::vector<Layer> layers_;
  std::vector<Open> open_;
};

}  // namespace viewpeel

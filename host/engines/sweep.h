// A Sweep counts one direction for engine `host`: lattice rows cut the projected scene into spans. It goes along each
// row and sorts the polygons between any two ends of spans by depth. The source are the scan-line algorithms: Watkins,
// "A real time visible surface algorithm" (1970).
#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include "engines/outlines.h"
#include "engines/pair_table.h"
#include "engines/work.h"

namespace viewpeel {

// A Sweep is of one thread. It counts as the compute engine does, to the last bit.
//   Cost: per direction, O(polygons + spans log (spans of a row) + samples x layers).
class Sweep {
 public:
  //   Throws: Error bad_usage where the resolution is out of range, or too fine for scanlines.
  Sweep(const SweepScene& scene, const LatticeOptions& options);

  // Adds all gaps between consecutive layers of a direction's lines, and blocked pairs where the options want them.
  void count(const Direction& direction, PairTable& table);

  const Work& work() const { return work_; }  // but for directions and memory
  uint64_t memoryBytes() const;

 private:
  // A DepthPlane is the depth over the lattice, as in ProjectedPolygon (shaders/shared.h), of the direction of that
  // turn.
  struct DepthPlane {
    uint64_t turn = 0;
    int64_t at_origin, per_column, per_row;
    double slack;
    int shift;
    bool is_edge_on;  // then every polygon has a depth of its own
  };
  // A row reads these data of a polygon that enters it, in one line of the processor's cache.
  struct alignas(64) Surface {
    int64_t at_origin, per_column, per_row;  // its depth
    int32_t depth_min, depth_max, shift;
    uint32_t polygon, id, roles;
    bool front_up;
    uint8_t place_at_tie;
  };
  struct Span {
    int32_t low, high;  // columns [low, high), in units of 2^-column_bits
    uint32_t surface;
  };
  // A Layer is a span that the row has entered.
  struct Layer {
    int64_t depth, whole, rest;  // depth in column X: depth + whole X + (rest X >> column_bits), before the shift
    int32_t depth_min, depth_max, shift, high;
    uint32_t polygon, id, roles;
    uint8_t place_at_tie;
    bool sees_up, sees_down;
  };
  struct Open {
    uint64_t key;
    const Layer* layer;
  };

  template <bool kAllCount>
  void slice(const Direction& direction);
  const DepthPlane& depthPlane(uint32_t plane_index, const Direction& direction);
  void addSurface(uint32_t place, bool front_up, const Direction& direction);
  void sortByLow(std::span<Span> spans);
  Layer enter(const Span& span, int row) const;
  uint64_t keyAt(const Layer& layer, int32_t column) const;
  template <bool kAllCount, bool kBlocked>
  void sweepRow(int row, std::span<Span> spans, uint64_t weight, PairTable& table);
  template <bool kAllCount, bool kBlocked>
  void addGaps(uint64_t weight, PairTable& table);

  const SweepScene& scene_;
  const int resolution_;
  const Window window_;
  const bool is_scanline_, counts_blocked_, measures_;
  const int fraction_bits_, column_bits_, reach_;
  Work work_;

  Outlines outlines_;
  std::vector<DepthPlane> planes_;
  glm::dvec2 origin_{0};  // of the lattice, in the direction at hand
  uint64_t turn_ = 0;     // directions so far
  std::vector<Surface> surfaces_;
  std::vector<std::vector<Span>> rows_;  // row -reach first
  std::vector<std::pair<int32_t, int32_t>>
      emitting_;                  // columns between the first and the last that emits, of every row
  std::vector<uint32_t> places_;  // of a row's spans, by their first column
  std::vector<Span> unsorted_;
  std::vector<Layer> layers_;
  std::vector<Open> open_;
};

}  // namespace viewpeel

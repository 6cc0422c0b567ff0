// Outlines finds the rows and columns of the lattice that the polygons of a scene cover along a direction, for engine
// `host`. It takes many polygons at once, by loops over arrays.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <viewpeel/engine.h>
#include "engines/vectorised.h"
#include <viewpeel/ids.h>

namespace viewpeel {

// A SweepScene holds the scene as sweeps read it: every corner and every plane once, however many polygons share it.
// Polygons that emit come first.
struct SweepScene {
  struct Polygon {
    uint32_t index;  // in the scene
    uint32_t plane, id, roles, tie_rank;
  };
  std::vector<double> x, y, z;                               // of corners, unit-ball units
  std::vector<double> normal_x, normal_y, normal_z, offset;  // of planes
  std::vector<Polygon> polygons;
  std::array<std::vector<uint32_t>, 4> corners;  // of polygons; a triangle's last twice
  bool two_sided, all_count, counts_environment;

  SweepScene(const Scene& scene, const Ids& ids);
};

class Outlines {
 public:
  static constexpr size_t kBlock = 256;  // polygons at once
  static constexpr size_t kCuts = 1024;  // rows of polygons at once

  // Each of Cuts is a polygon and a row that it may reach. It covers the columns [low, high) there, in units of
  // 2^-column_bits, or none where low >= high.
  struct Cuts {
    size_t count;
    std::span<const uint32_t> outlines;  // of this block
    std::span<const int32_t> rows, low, high;
  };

  //   In: reach: rows from -reach to reach - 1; fraction_bits: of snapped coordinates
  Outlines(const SweepScene& scene, int fraction_bits, int column_bits, int reach, Vectors vectors = widestVectors());

  // Snaps all corners.    In: origin: of the lattice, see latticeOrigin; per_spacing: spacings to a unit length
  void project(const Direction& direction, const glm::dvec2& origin, double per_spacing);

  // Finds the outlines of up to kBlock polygons from `first` on, without polygons that lie between two rows.
  void find(size_t first);
  // Cuts the next rows of the outlines; no more than there are. Of a polygon they follow one after the other.
  Cuts cut();

  // Returns the polygon of an outline of this block, and whether its front is up.
  uint32_t polygonOf(uint32_t outline) const { return static_cast<uint32_t>(first_ + reaching_[outline]); }
  bool isFrontUp(uint32_t outline) const { return front_up_[outline]; }

  double height(uint32_t corner) const { return height_[corner]; }  // along u
  uint64_t memoryBytes() const { return scene_.x.size() * 16; }

 private:
  static constexpr int32_t kFewRows = 4;  // of an outline

  template <class T>
  using OfBlock = std::array<T, kBlock>;

  std::array<const uint32_t*, 4> cornersOfBlock() const;
  void findRows(size_t count);
  void findEdges();

  const SweepScene& scene_;
  const int fraction_bits_, column_bits_, reach_;
  const Vectors vectors_;

  std::vector<int32_t> snapped_x_, snapped_y_;  // of corners
  std::vector<double> height_;

  size_t first_ = 0, outline_count_ = 0;
  OfBlock<int32_t> polygon_first_row_{}, polygon_last_row_{};  // of the block's polygons
  OfBlock<uint32_t> reaching_{};                               // polygons that may reach a row: one outline each
  OfBlock<int32_t> first_row_{}, last_row_{}, front_up_{};
  // These numbers belong to edge e of outline k, at e kBlock + k. The edge crosses row y at ceil((row_0 + per_row y)
  // inverse), see cut(). Left edges have the inverse -1 / |a|, right ones 1 / |a|, edges along rows 0.
  std::array<double, 4 * kBlock> row_0_{}, per_row_{}, inverse_{};

  size_t next_outline_ = 0;
  int32_t next_row_ = 0;  // of that outline, where some of its rows have been cut
  std::array<uint32_t, kCuts + kFewRows> cut_outlines_{};
  std::array<int32_t, kCuts + kFewRows> cut_rows_{}, cut_low_{}, cut_high_{};
};

}  // namespace viewpeel

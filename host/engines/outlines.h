// Outlines finds the rows and columns of the lattice that the polygons of a scene cover along a direction, for engine
// `host`. Its loops over arrays take many polygons at once in vector instructions.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <viewpeel/engine.h>
#include <viewpeel/ids.h>
#include "vectorised.h"

namespace viewpeel {

// A SweepScene is a copy of the scene as class Sweep reads it: every corner and every plane stands once, however many
// polygons share it. Polygons that emit come first.
struct SweepScene {
  struct Polygon {
    uint32_t index;  // index in Scene::polygons
    uint32_t plane, id, roles, tie_rank;
  };
  std::vector<double> x, y, z;                               // coordinates of each corner, unit-ball units
  std::vector<double> normal_x, normal_y, normal_z, offset;  // unit normal and offset of each plane
  std::vector<Polygon> polygons;
  std::array<std::vector<uint32_t>, 4> corners;  // corner k of each polygon; a triangle's last corner stands twice
  bool two_sided, all_count, counts_environment;

  SweepScene(const Scene& scene, const Ids& ids);
};

class Outlines {
 public:
  static constexpr size_t kBlock = 256;  // polygons whose outlines find() finds at once
  static constexpr size_t kCuts = 1024;  // most entries of Cuts

  // Entry k of Cuts is an outline of this block and a row that it may reach. The polygon covers the columns [low, high)
  // of the row, in units of 2^-column_bits spacings, or none where low >= high.
  struct Cuts {
    size_t count;
    std::span<const uint32_t> outlines;
    std::span<const int32_t> rows, low, high;
  };

  //   In: scene: the caller keeps it alive; reach: rows run from -reach to reach - 1; fraction_bits: binary digits
  //     after the point of snapped coordinates; column_bits: columns are in units of 2^-column_bits spacings
  Outlines(const SweepScene& scene, int fraction_bits, int column_bits, int reach, Vectors vectors = widestVectors());

  // Projects all corners along a direction and snaps them.
  //   In: origin: what latticeOrigin returns; per_spacing: spacings in a unit length
  void project(const Direction& direction, const glm::dvec2& origin, double per_spacing);

  // Finds the outlines of a block: kBlock polygons from `first` on, or as many as there are. Polygons that lie between
  // two rows get none.
  void find(size_t first);
  // Returns the next rows of the block's outlines; without entries where there are none left. Rows of one outline
  // follow each other.
  Cuts cut();

  // These return the index in SweepScene::polygons of an outline of this block, and whether the polygon's front faces
  // +u.
  uint32_t polygonOf(uint32_t outline) const { return static_cast<uint32_t>(first_ + reaching_[outline]); }
  bool isFrontUp(uint32_t outline) const { return front_up_[outline]; }

  // Returns a corner's coordinate along u, in unit-ball units.
  double height(uint32_t corner) const { return height_[corner]; }
  uint64_t memoryBytes() const { return scene_.x.size() * 16; }

 private:
  static constexpr int32_t kFewRows = 4;  // rows that cut() writes for every outline

  template <class T>
  using OfBlock = std::array<T, kBlock>;

  std::array<const uint32_t*, 4> cornersOfBlock() const;
  void findRows(size_t count);
  void findEdges();

  const SweepScene& scene_;
  const int fraction_bits_, column_bits_, reach_;
  const Vectors vectors_;

  std::vector<int32_t> snapped_x_, snapped_y_;  // snapped lattice coordinates of each corner
  std::vector<double> height_;

  size_t first_ = 0, outline_count_ = 0;
  OfBlock<int32_t> polygon_first_row_{}, polygon_last_row_{};  // rows that each polygon of the block may reach
  OfBlock<uint32_t> reaching_{};                               // number in the block of each outline's polygon
  OfBlock<int32_t> first_row_{}, last_row_{}, front_up_{};     // rows of each outline, and whether its front faces +u
  // Element e kBlock + k is of edge e of outline k. The edge crosses row y at ceil((row_0 + per_row y) inverse), see
  // cut(). The inverse is -1 / |a| for edges on the left, 1 / |a| on the right, and 0 for edges along rows.
  std::array<double, 4 * kBlock> row_0_{}, per_row_{}, inverse_{};

  size_t next_outline_ = 0;  // the outline with which the next call of cut() begins
  int32_t next_row_ = 0;     // the row of next_outline_ with which it begins, INT32_MIN for the first
  std::array<uint32_t, kCuts + kFewRows> cut_outlines_{};
  std::array<int32_t, kCuts + kFewRows> cut_rows_{}, cut_low_{}, cut_high_{};
};

}  // namespace viewpeel

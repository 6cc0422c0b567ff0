// Ids describes the rows of the matrix: which polygons each row has, its name and area, and which rows are requested.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// These two values can be the second id of a pair. kEnvironment is for lines that leave the scene, kLeak for lines that
// end on the back of a polygon.
constexpr uint32_t kEnvironment = 0xFFFFFFFEu;
constexpr uint32_t kLeak = 0xFFFFFFFFu;

// A row is a face of the file, or a surface: all faces of one name.
enum class By { polygon, surface };

// These bits are the roles of a polygon. A facing pair counts if one of its polygons emits and the other receives. The
// environment and the leak of a polygon count if it emits.
constexpr uint32_t kEmits = 1, kReceives = 2;

// Ids has an entry for each row of the matrix.
struct Ids {
  std::vector<uint32_t> of_polygon;  // id of each polygon of Scene::polygons
  std::vector<uint32_t> roles;       // roles of each polygon of Scene::polygons; empty where all have both roles
  bool counts_environment = true;    // whether environment and leak are counted
  std::vector<bool> requested;       // whether each id is a requested row; empty where all are
  std::vector<bool> only_blocks;     // whether each id only blocks, without a role; empty where none does
  bool splits_surfaces = false;      // roles differ within a surface, so sums by surface would mean nothing
  bool rows_sum_to_one = true;       // false where a question leaves out ids that a row can see
  std::vector<std::string> names;    // faceName, or the surface's name
  std::vector<double> areas;         // emitting area, input units squared: both sides of a two-sided polygon count
  std::vector<uint32_t> surface;     // Scene::surfaces index of each id
  bool two_sided = false;
  std::vector<EmptyRow> empty_rows;  // rows of the file that have no id, in ascending order; results list them, too

  uint32_t rolesOf(uint32_t polygon_index) const { return roles.empty() ? kEmits | kReceives : roles[polygon_index]; }
  bool onlyBlocks(uint32_t id) const { return id < only_blocks.size() && only_blocks[id]; }
  bool isRequested(uint32_t id) const { return requested.empty() || requested[id]; }
  // Returns the area of the pair's smaller id among the requested ones; infinite where neither is requested.
  double smallerArea(uint32_t i, uint32_t j) const {
    return std::min(isRequested(i) ? areas[i] : INFINITY, j < kEnvironment && isRequested(j) ? areas[j] : INFINITY);
  }
  uint32_t count() const { return static_cast<uint32_t>(names.size()); }
  // Returns the number of a polygon's sides that emit and receive.
  uint32_t sides() const { return two_sided ? 2 : 1; }
  // Returns the number of rows of results, with the empty rows.
  uint32_t rowCount() const { return count() + static_cast<uint32_t>(empty_rows.size()); }
  // Returns the row of each id, counted from 0: uint32_t[id], ascending.
  std::vector<uint32_t> rows() const;
};

// Returns the number of pairs of n different ids.
constexpr uint64_t pairCount(uint64_t n) { return n * (n - 1) / 2; }

// A Question says which form factors to compute. The default is all of them. A name is that of a surface ("desk") or of
// a face ("desk[3]").
struct Question {
  std::vector<std::string> from;      // compute only the rows of these names; empty: all rows
  std::vector<std::string> pair;      // empty, or two names: compute only the form factors between the two
  std::vector<std::string> blockers;  // these only block other polygons, and have no rows or columns

  bool isEverything() const { return from.empty() && pair.empty() && blockers.empty(); }
};

// Returns the polygons of a surface or face, by its name.
//   In: name: "desk" or "desk[3]"    Out: indices into Scene::polygons, ascending
//   Throws: Error bad_usage where nothing has this name.    Cost: O(polygons).
std::vector<uint32_t> findPolygons(const Scene& scene, const std::string& name);

// Restricts ids to a question: sets roles, counts_environment, requested, only_blocks, splits_surfaces and
// rows_sum_to_one.
//   In: ids: of this scene, as makeIds() returns them
//   Throws: Error bad_usage for an unknown name, and for a pair together with `from`. The same for a row or column that
//     is among the blockers, and for a part of a surface with By::surface.
//   Cost: O(polygons) for each name.
void restrictToQuestion(const Question& question, const Scene& scene, Ids& ids);

// Makes the rows of a scene's matrix.
//   In: by: whether a row is a face or a surface; two_sided: whether polygons emit and receive on both sides
//   Out: ids that have both roles, with areas in input units squared
//   Throws: nothing.
//   Cost: O(polygons).
Ids makeIds(const Scene& scene, By by, bool two_sided);

}  // namespace viewpeel

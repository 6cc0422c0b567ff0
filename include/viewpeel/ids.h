// Ids are the rows of the matrix: the polygons of each, its name and area, and the rows that a question wants.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// These two stand in the place of a second id: for lines of the first id that leave the scene, and that end on a back.
constexpr uint32_t kEnvironment = 0xFFFFFFFEu;
constexpr uint32_t kLeak = 0xFFFFFFFFu;

// A row is a polygon of the input (a face of the file), or all polygons of one name.
enum class By { polygon, surface };

// A facing pair counts where one of the two polygons emits and the other receives. The environment and leak of a
// polygon count where it emits.
constexpr uint32_t kEmits = 1, kReceives = 2;

// Ids has an entry for each row of the matrix.
struct Ids {
  std::vector<uint32_t> of_polygon;  // id of each Scene::polygons entry
  std::vector<uint32_t> roles;       // of each Scene::polygons entry; empty where every one has both
  bool counts_environment = true;    // environment and leak, too
  std::vector<bool> requested;       // rows of the question; empty where all are
  bool splits_surfaces = false;      // roles differ within a surface: sums by surface would mean nothing
  bool rows_sum_to_one = true;       // false where a question leaves out some of the ids that a row can see
  std::vector<std::string> names;    // faceName, or the surface's name
  std::vector<double> areas;         // emitting area, input units squared: both sides of a two-sided polygon count
  std::vector<uint32_t> surface;     // Scene::surfaces index of each id
  bool two_sided = false;
  std::vector<EmptyRow> empty_rows;  // of the file, by row, which no id stands for: results have them, too

  uint32_t rolesOf(uint32_t polygon_index) const { return roles.empty() ? kEmits | kReceives : roles[polygon_index]; }
  bool isRequested(uint32_t id) const { return requested.empty() || requested[id]; }
  // Returns the smaller area of a pair, among its requested rows; infinite where it has none.
  double smallerArea(uint32_t i, uint32_t j) const {
    return std::min(isRequested(i) ? areas[i] : INFINITY, j < kEnvironment && isRequested(j) ? areas[j] : INFINITY);
  }
  uint32_t count() const { return static_cast<uint32_t>(names.size()); }
  // Returns the number of rows of results, empty ones too.
  uint32_t rowCount() const { return count() + static_cast<uint32_t>(empty_rows.size()); }
  // Returns the row of each id, from 0, ascending.
  std::vector<uint32_t> rows() const;
};

// Returns the number of pairs of n different ids.
constexpr uint64_t pairCount(uint64_t n) { return n * (n - 1) / 2; }

// A Question says which form factors to compute, where not all of them. Names are of surfaces ("desk") or faces
// ("desk[3]").
struct Question {
  std::vector<std::string> from;      // only rows of these names; all where empty
  std::vector<std::string> pair;      // empty, or two: only the form factors between them
  std::vector<std::string> blockers;  // only block: no rows or columns

  bool isEverything() const { return from.empty() && pair.empty() && blockers.empty(); }
};

// Returns the polygons of the surface or face of this name.
//   In: name: "desk" or "desk[3]"    Out: indices into Scene::polygons, ascending
//   Throws: Error bad_usage where there is none.    Cost: O(polygons).
std::vector<uint32_t> findPolygons(const Scene& scene, const std::string& name);

// Restricts ids to a question: sets roles, counts_environment, requested, splits_surfaces and rows_sum_to_one.
//   In: ids of this scene, as makeIds gives them
//   Throws: Error bad_usage: unknown names, a pair beside --from, a row or column among the blockers, part of a surface
//     with By::surface.
//   Cost: O(polygons) a name.
void restrictToQuestion(const Question& question, const Scene& scene, Ids& ids);

// Makes the rows of a scene's matrix.
//   In: by: one row a face or a surface; two_sided: every polygon emits and receives on both sides
//   Out: every id with both roles, areas in input units squared
//   Throws: Error bad_input where a surface is called `environment` or `leak`, which the result uses itself.
//   Cost: O(polygons).
Ids makeIds(const Scene& scene, By by, bool two_sided);

}  // namespace viewpeel

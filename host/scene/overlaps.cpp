#include "scene/overlaps.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "scene/face_names.h"

namespace viewpeel {
namespace {

// Returns the corners of a face, without corners that repeat the corner before.
std::vector<glm::dvec3> cornersOf(const InputFace& face) {
  std::vector<glm::dvec3> corners;
  for (const glm::dvec3& corner : face.corners)
    if (corners.empty() || corner != corners.back()) corners.push_back(corner);
  while (corners.size() > 1 && corners.back() == corners.front()) corners.pop_back();
  return corners;
}

bool areSame(const InputFace& a, const InputFace& b, double rounding) {
  const std::vector<glm::dvec3> of_a = cornersOf(a), of_b = cornersOf(b);
  const size_t count = of_a.size();
  if (of_b.size() != count) return false;
  for (size_t first = 0; first < count; ++first) {
    bool is_same = true;
    for (size_t k = 0; k < count && is_same; ++k)
      is_same = glm::length(of_a[k] - of_b[(first + k) % count]) <= rounding;
    if (is_same) return true;
  }
  return false;
}

}  // namespace

std::vector<Duplicate> findDuplicates(const InputScene& input, const Scene& scene,
                                      const std::vector<AlikeOverlap>& alike, double rounding) {
  std::map<uint32_t, uint32_t> first_of;  // the first face that each duplicate repeats
  std::set<std::pair<uint32_t, uint32_t>> looked_at;
  for (const AlikeOverlap& overlap : alike) {
    const uint32_t rows[] = {scene.faces[scene.polygons[overlap.a].face].row,
                             scene.faces[scene.polygons[overlap.b].face].row};
    looked_at.insert({std::min(rows[0], rows[1]), std::max(rows[0], rows[1])});
  }
  for (const auto& [earlier, later] : looked_at)
    if (!first_of.count(later) && areSame(input.faces[earlier], input.faces[later], rounding))
      first_of[later] = earlier;
  std::vector<Duplicate> duplicates;
  for (auto [face, of] : first_of) {
    while (first_of.count(of)) of = first_of[of];
    duplicates.push_back({face, of});
  }
  return duplicates;
}

std::string describeOverlaps(const Scene& scene, const std::vector<AlikeOverlap>& alike) {
  if (alike.empty()) return "";
  double area = 0;
  std::map<std::pair<uint32_t, uint32_t>, double> area_of;  // overlap area of each pair of faces
  for (const AlikeOverlap& overlap : alike) {
    area += overlap.area;
    const uint32_t a = scene.polygons[overlap.a].face, b = scene.polygons[overlap.b].face;
    area_of[{std::min(a, b), std::max(a, b)}] += overlap.area;
  }
  const auto largest = std::max_element(area_of.begin(), area_of.end(),
                                        [](const auto& p, const auto& q) { return p.second < q.second; });
  const bool is_one = area_of.size() == 1;
  return fmt::format(
      "{}: {} of faces {} in one plane and {} the same way{}: {} and {}, {:.4g} of area{}; there a line counts for one "
      "of the two "
      "and ends on its back for the other (leak); cut them apart, or remove one",
      scene.file, is_one ? "1 pair" : fmt::format("{} pairs", area_of.size()), is_one ? "overlaps" : "overlap",
      is_one ? "faces" : "face", is_one ? "" : ", most of all", faceName(scene, largest->first.first),
      faceName(scene, largest->first.second), (is_one ? area : largest->second) * scene.scale * scene.scale,
      is_one ? "" : fmt::format(", {:.4g} in all", area * scene.scale * scene.scale));
}

}  // namespace viewpeel

#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace viewpeel {

// What counters are kept for: every input polygon (a face of the file), or every named surface as a whole.
enum class By { polygon, surface };

// "desk[3]", or "desk" where the surface has one face only.
std::string faceName(const Scene& scene, uint32_t face_index);

// What a polygon's facing pairs are counted for: a facing pair counts where one of the two emits and the other receives.
// The environment and leak of a polygon count where it emits.
constexpr uint32_t kEmits = 1, kReceives = 2;

// The rows of the matrix.
struct Ids {
  std::vector<uint32_t> of_polygon;  // id of each Scene::polygons entry
  std::vector<uint32_t> roles;       // of each Scene::polygons entry; empty where every one has both
  bool counts_environment = true;    // environment and leak, too
  std::vector<std::string> names;    // faceName, or the surface's name
  std::vector<double> areas;         // emitting area, input units squared: both sides of a two-sided polygon count
  std::vector<uint32_t> surface;     // Scene::surfaces index of each id
  bool two_sided = false;

  uint32_t rolesOf(uint32_t polygon_index) const { return roles.empty() ? kEmits | kReceives : roles[polygon_index]; }
  uint32_t count() const { return static_cast<uint32_t>(names.size()); }
};

//   Throws: Error bad_input where a surface is called `environment` or `leak`, which the result uses itself.
Ids makeIds(const Scene& scene, By by, bool two_sided);

}  // namespace viewpeel

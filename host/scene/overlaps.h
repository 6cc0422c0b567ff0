// Faces that overlap in one plane and look the same way: the same face twice in a file, or tiles laid over each other.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "scene/coincident.h"
#include <viewpeel/scene.h>

namespace viewpeel {

// A Duplicate is a face that repeats an earlier one, corner for corner.
struct Duplicate {
  uint32_t face, of;  // into InputScene::faces, of < face
};

// Finds the faces that overlap and have the very same corners in the same order, wherever they begin.
//   In: alike: of the scene that was built from the input; rounding: of coordinates, input units
//   Out: sorted by face, every face once, `of` never a duplicate itself
//   Cost: O(overlaps corners^2).
std::vector<Duplicate> findDuplicates(const InputScene& input, const Scene& scene,
                                      const std::vector<AlikeOverlap>& alike, double rounding);

// The warning about overlaps that are no duplicates; empty without any.
//   Cost: O(overlaps log overlaps).
std::string describeOverlaps(const Scene& scene, const std::vector<AlikeOverlap>& alike);

}  // namespace viewpeel

// These functions report faces that overlap in one plane and look the same way. Either the file has a face twice, or
// different faces lie over each other.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "scene/coincident.h"
#include <viewpeel/scene.h>

namespace viewpeel {

// A Duplicate is a face that repeats an earlier one, corner for corner.
struct Duplicate {
  uint32_t face, of;  // indices into InputScene::faces: `face` repeats `of`, and of < face
};

// Finds faces that overlap and have the same corners in the same order. The first corner may be a different one.
//   In: alike: the overlaps in the scene that buildScene() made of the input; rounding: of coordinates, input units
//   Out: sorted by face. Every face occurs once, and `of` is never a duplicate itself.
//   Cost: O(overlaps corners^2).
std::vector<Duplicate> findDuplicates(const InputScene& input, const Scene& scene,
                                      const std::vector<AlikeOverlap>& alike, double rounding);

// Returns a warning about overlaps that are not duplicates; empty where there are none.
//   Cost: O(overlaps log overlaps).
std::string describeOverlaps(const Scene& scene, const std::vector<AlikeOverlap>& alike);

}  // namespace viewpeel

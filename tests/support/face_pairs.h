// sceneOf() makes a scene of faces. FacePairs finds its pairs of patches and what lies between them.
#pragma once
#include <stdexcept>
#include <string>
#include <vector>

#include "pair_lines/find_pairs.h"
#include "pair_lines/uniform_lines.h"
#include "scenes/named_scenes.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel::test {

// Returns a scene of the faces "face0", "face1", ..., in this order.
inline Scene sceneOf(const std::vector<reference::test::Corners>& faces) {
  InputScene input{"faces", {}, {}};
  for (size_t k = 0; k < faces.size(); ++k) test_scenes::addFace(input, "face" + std::to_string(k), faces[k]);
  return buildScene(input);
}

struct FacePairs {
  Scene scene;
  PairFinder finder;
  PatchPairs pairs;

  explicit FacePairs(const std::vector<reference::test::Corners>& faces)
      : scene(sceneOf(faces)), finder(scene, makeIds(scene, By::polygon, false)), pairs(finder.find(1)) {}
  // Returns the pair of patches of two faces.    Throws: std::logic_error where the two are hidden from each other.
  const PatchPair& between(uint32_t i, uint32_t j) const {
    for (const PatchPair& pair : pairs.pairs)
      if (finder.patches()[pair.a].id == i && finder.patches()[pair.b].id == j) return pair;
    throw std::logic_error("the pair is hidden");
  }
  UniformLines lines(const PatchPair& pair) const {
    return {finder.patches()[pair.a], finder.patches()[pair.b], pair.exchange, finder.blockers(),
            std::span(pairs.between).subspan(pair.first_blocker, pair.blocker_count)};
  }
};

}  // namespace viewpeel::test

// makeCase() returns the scenes of the bench `coverage`, with the true form factors of their pairs.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include <viewpeel/form_factors.h>
#include <viewpeel/scene.h>

namespace viewpeel::bench {

using Pair = std::pair<uint32_t, uint32_t>;
using Truths = std::map<Pair, double>;  // F_ij by (i, j), i < j, of the pairs that are judged; j may be kEnvironment

struct Case {
  Scene scene;
  Truths truths;
  bool has_all_pairs = false;
};

// Returns the true form factors between surfaces, F_IJ = sum_ij A_i F_ij / A_I.
Truths sumBySurface(const Truths& truths, const Ids& ids, const Ids& surface_ids);

// Returns a case by its name. The truths of facing, edge, far, cube, blocked, parts and gap are closed forms or
// integrals. The truths of office, room and city are long runs.
Case makeCase(const std::string& name);

}  // namespace viewpeel::bench

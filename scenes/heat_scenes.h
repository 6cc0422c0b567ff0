// These scenes for heat have form factors in closed form, even though something blocks their pairs.
#pragma once
#include <vector>

#include <viewpeel/form_factors.h>

#include "reference/closed_forms/past_blocker.h"
#include "scenes/named_scenes.h"

namespace viewpeel::test_scenes {

// Returns two unit squares at distance 1, each in cuts x cuts parts, with a sheet of two faces between them, off their
// middle. Rows by polygon: parts of `low` and `high` in turn, then `sheet_down`, `sheet_up`.
inline InputScene squaresPastASheet(uint32_t cuts) {
  InputScene scene = squaresInParts(cuts, 1.0 / cuts, 1);
  const Corners up = squaresPastABlocker().faces[2].corners;
  addFace(scene, "sheet_down", {up.rbegin(), up.rend()});
  addFace(scene, "sheet_up", up);
  return scene;
}

// Returns the form factors of squaresPastASheet by polygon. Each pair of parts sees past the sheet; parts also see the
// sheet and the environment, which has the rest.
//   Error: 1e-7 each (kPastBlockerError), standard errors 0.
inline FormFactors exactPastASheet(const InputScene& scene, Ids ids) {
  const size_t parts = scene.faces.size() - 2;
  const auto& down = scene.faces[parts].corners;
  // a sheet far away, which blocks nothing
  const Corners nothing{{90, 90, 90}, {91, 90, 90}, {90, 91, 90}};
  std::vector<FormFactors::Entry> entries;
  std::vector<double> rest = ids.areas;
  const auto add = [&](size_t i, size_t j, const Corners& blocker) {
    const double factor =
        reference::formFactorPastBlocker(scene.faces[i].corners, scene.faces[j].corners, blocker).value;
    if (factor < 1e-12) return;  // such values are rounding
    const double exchange = ids.areas[i] * factor;
    entries.push_back({uint32_t(i), uint32_t(j), {exchange, 0}});
    rest[i] -= exchange, rest[j] -= exchange;
  };
  for (size_t i = 0; i < parts; ++i) {
    for (size_t j = i + 1; j < parts; ++j)
      if ((i + j) % 2) add(i, j, down);
    add(i, parts + i % 2, nothing);
  }
  for (uint32_t i = 0; i < ids.count(); ++i) entries.push_back({i, kEnvironment, {rest[i], 0}});
  std::ranges::sort(entries, {}, [](const FormFactors::Entry& entry) { return std::pair(entry.i, entry.j); });
  std::vector<Measured> rows(ids.count(), {1, 0});
  return {std::move(ids), std::move(entries), std::move(rows)};
}

}  // namespace viewpeel::test_scenes

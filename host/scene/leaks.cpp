#include "scene/leaks.h"

#include <algorithm>
#include <map>
#include <tuple>

#include <fmt/format.h>

#include "scene/face_names.h"
#include "scene/shells.h"
#include "scene/sight.h"

namespace viewpeel {
namespace {

constexpr uint64_t kMostLeakRays = 1 << 14, kEnough = 2000;  // most rays; fewer where this many have ended on backs
constexpr uint64_t kQuickRays = 512;
// This many rays around a point end on backs if the point is hidden. A point of which a tenth of the rays ends
// elsewhere is taken for hidden in 3 % of cases, 0.9^32.
constexpr uint32_t kAround = 32;
constexpr size_t kMostNamed = 5;

// A Tally sums the areas for which the starting points of rays stand, in Scene's unit.
struct Tally {
  double leaking = 0;  // of all rays that end on backs
  double hidden = 0;   // the part of `leaking` whose points are hidden
};

class LeakFinder {
 public:
  explicit LeakFinder(const Scene& scene)
      : scene_(scene),
        sight_(scene),
        shells_(findShells(scene)),
        shell_of_(shellsOfFaces(shells_, scene.faces.size())),
        is_flipped_(scene.faces.size(), false) {
    for (uint32_t face : findFlipped(scene, shells_, sight_)) is_flipped_[face] = true;
  }

  FrontRays follow(const std::vector<double>& weights) {
    FrontRays found;
    std::vector<double> sums;
    for (uint32_t k = 0; k < scene_.polygons.size(); ++k)
      sums.push_back((sums.empty() ? 0 : sums.back()) + (weights.empty() ? scene_.polygons[k].area : weights[k]));
    if (!(sums.back() > 0)) return found;
    std::map<std::tuple<uint32_t, uint32_t, LeakCause, uint32_t>, Tally> tallies;
    while (found.rays < kMostLeakRays && found.backs < kEnough) {
      const uint32_t polygon = pickBySums(sums, sight_.uniform() * sums.back());
      const glm::dvec3 point = sight_.pointOn(polygon);
      const Sight::End end = sight_.look(polygon, point, sight_.directionFrom(polygon, true));
      ++found.rays;
      found.escaped += end.polygon == Sight::kNothing;
      if (end.polygon == Sight::kNothing || end.is_front) continue;
      ++found.backs;
      const bool is_hidden = isHidden(polygon, point);
      const LeakCause cause = causeOf(polygon, end.polygon, is_hidden);
      Tally& tally = tallies[{surfaceOf(polygon), surfaceOf(end.polygon), cause,
                              surfaceOf(leavesCulprit(end.polygon, cause) ? polygon : end.polygon)}];
      const double density =
          (sums[polygon] - (polygon ? sums[polygon - 1] : 0)) / sums.back() / scene_.polygons[polygon].area;
      tally.leaking += 1 / density;
      if (is_hidden) tally.hidden += 1 / density;
    }
    double leaking = 0;
    for (const auto& [key, tally] : tallies) leaking += tally.leaking;
    for (const auto& [key, tally] : tallies) {
      const auto& [from, onto, cause, culprit] = key;
      found.leaks.push_back({from, onto, cause, culprit, tally.leaking / leaking,
                             tally.hidden / double(found.rays) * scene_.scale * scene_.scale});
    }
    std::stable_sort(found.leaks.begin(), found.leaks.end(),
                     [](const Leak& a, const Leak& b) { return a.share > b.share; });
    return found;
  }

 private:
  uint32_t surfaceOf(uint32_t polygon) const { return scene_.faces[scene_.polygons[polygon].face].surface; }

  bool isHidden(uint32_t polygon, const glm::dvec3& point) {
    for (uint32_t ray = 0; ray < kAround; ++ray) {
      const Sight::End end = sight_.look(polygon, point, sight_.directionFrom(polygon, true));
      if (end.polygon == Sight::kNothing || end.is_front) return false;
    }
    return true;
  }

  LeakCause causeOf(uint32_t from, uint32_t onto, bool is_hidden) const {
    const Polygon &of = scene_.polygons[from], &hit = scene_.polygons[onto];
    if (is_flipped_[hit.face] || is_flipped_[of.face]) return LeakCause::flipped;
    if (of.plane == hit.plane) return LeakCause::overlap;
    const bool is_closed = shells_[shell_of_[hit.face]].is_closed;
    if (is_hidden) return is_closed ? LeakCause::enclosed : LeakCause::no_bottom;
    return is_closed ? LeakCause::gap : LeakCause::one_sided;
  }

  // Returns whether the user should change the polygon that the lines leave, rather than the one that they end on.
  bool leavesCulprit(uint32_t onto, LeakCause cause) const {
    if (cause == LeakCause::flipped) return !is_flipped_[scene_.polygons[onto].face];
    return cause == LeakCause::overlap || cause == LeakCause::enclosed || cause == LeakCause::no_bottom;
  }

  const Scene& scene_;
  Sight sight_;
  std::vector<Shell> shells_;
  std::vector<uint32_t> shell_of_;  // shell of each face
  std::vector<bool> is_flipped_;    // whether each face has to be turned over
};

// A Group holds the leaks of one cause and culprit. All flipped surfaces are one group, because one option turns them
// all.
struct Group {
  LeakCause cause;
  double share = 0, hidden_area = 0;
  std::vector<uint32_t> culprits, others;  // surfaces, the largest leaks first
};

std::vector<Group> groupLeaks(const std::vector<Leak>& leaks) {
  std::vector<Group> groups;
  const auto add = [](std::vector<uint32_t>& surfaces, uint32_t surface) {
    if (std::find(surfaces.begin(), surfaces.end(), surface) == surfaces.end()) surfaces.push_back(surface);
  };
  for (const Leak& leak : leaks) {
    auto at = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
      return group.cause == leak.cause && (leak.cause == LeakCause::flipped || group.culprits.front() == leak.culprit);
    });
    if (at == groups.end()) at = groups.insert(at, Group{leak.cause, 0, 0, {}, {}});
    at->share += leak.share;
    at->hidden_area += leak.hidden_area;
    add(at->culprits, leak.culprit);
    add(at->others, leak.culprit == leak.from ? leak.onto : leak.from);
  }
  std::stable_sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) { return a.share > b.share; });
  return groups;
}

std::string listSurfaces(const Scene& scene, const std::vector<uint32_t>& surfaces) {
  std::string text;
  for (size_t k = 0; k < std::min(surfaces.size(), kMostNamed); ++k)
    text += fmt::format("{}{}", k ? ", " : "", scene.surfaces[surfaces[k]].name);
  return surfaces.size() > kMostNamed ? fmt::format("{} and {} more", text, surfaces.size() - kMostNamed) : text;
}

std::string describeGroup(const Scene& scene, const Group& group) {
  const std::string culprits = listSurfaces(scene, group.culprits), others = listSurfaces(scene, group.others);
  const bool is_one = group.culprits.size() == 1;
  const std::string area = fmt::format("about {:.3g} of the area of {}", group.hidden_area, culprits);
  switch (group.cause) {
    case LeakCause::flipped:
      return fmt::format("{} {} the wrong way, as {} {}; turn {} by --fix-normals or by --flip NAME", culprits,
                         is_one ? "looks" : "look", others, group.others.size() == 1 ? "shows" : "show",
                         is_one ? "it" : "them");
    case LeakCause::overlap:
      return fmt::format("{} lies in one plane with {}, facing alike; cut them apart, or remove one", culprits, others);
    case LeakCause::enclosed:
      return fmt::format("{} lies inside {}; cut it away there, so that form factors are of what is free", area,
                         others);
    case LeakCause::no_bottom:
      return fmt::format("{} lies under {}, open towards it; cut it away there, or give {} a bottom", area, others,
                         others);
    case LeakCause::one_sided:
      return fmt::format(
          "{} is a sheet with one side that is seen from both, from behind by {}; add its other side, back to back, or "
          "take --two-sided",
          culprits, others);
    case LeakCause::gap:
      break;
  }
  return fmt::format(
      "{} is seen from behind by {}: they pass through each other, or there is a gap between; cut faces where they "
      "meet, close gaps",
      culprits, others);
}

}  // namespace

FrontRays followFronts(const Scene& scene, const std::vector<double>& weights) {
  return LeakFinder(scene).follow(weights);
}

std::vector<std::string> describeLeaks(const Scene& scene, const std::vector<Leak>& leaks) {
  constexpr double kLeastNamed = 0.01;  // share of the leak from which on a group gets a line
  std::vector<std::string> lines;
  double rest = 0;
  for (const Group& group : groupLeaks(leaks)) {
    if (lines.size() >= kMostNamed || group.share < kLeastNamed) rest += group.share;
    else
      lines.push_back(
          fmt::format("{}: {:.0f} % of the leak: {}", scene.file, 100 * group.share, describeGroup(scene, group)));
  }
  if (rest >= kLeastNamed)
    lines.push_back(fmt::format("{}: {:.0f} % of the leak: between other surfaces", scene.file, 100 * rest));
  return lines;
}

std::string explainLargestLeak(const Scene& scene) {
  const std::vector<Group> groups = groupLeaks(followFronts(scene).leaks);
  if (groups.empty()) return {};
  return fmt::format("{:.0f} % of the leak: {}", 100 * groups[0].share, describeGroup(scene, groups[0]));
}

std::vector<std::string> warnOfBacks(const Scene& scene) {
  const FrontRays found = followFronts(scene);
  if (found.escaped == found.rays && scene.faces.size() > 1)
    return {
        fmt::format("{}: no front sees another front; turn a room whose normals look outward by --fix-normals, or "
                    "surfaces by --flip NAME",
                    scene.file)};
  if (found.backs == 0) return {};
  std::vector<std::string> lines = {
      fmt::format("{}: {:.2g} % of rays from fronts end on backs (leak)", scene.file, 100 * found.backShare())};
  for (std::string& line : describeLeaks(scene, found.leaks)) lines.push_back(std::move(line));
  return lines;
}

std::string describeClosedness(const Scene& scene) {
  const bool edges_closed = isClosed(scene);
  Sight sight(scene);
  std::vector<double> sums;
  for (const Polygon& polygon : scene.polygons) sums.push_back((sums.empty() ? 0 : sums.back()) + polygon.area);
  uint64_t backs = 0, escaped = 0;
  for (uint64_t ray = 0; ray < kQuickRays; ++ray) {
    const Sight::End end = sight.look(pickBySums(sums, sight.uniform() * sums.back()));
    escaped += end.polygon == Sight::kNothing;
    backs += end.polygon != Sight::kNothing && !end.is_front;
  }
  const std::string leaking =
      fmt::format("leaking: {:.2g} % of rays from fronts end on backs", 100 * double(backs) / double(kQuickRays));
  if (escaped > 0) return backs > 0 ? "open and " + leaking : "open";
  if (backs > 0) return "closed, but " + leaking;
  return edges_closed ? "closed" : "closed but for edges that meet no other";
}

}  // namespace viewpeel

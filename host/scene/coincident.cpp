#include "scene/coincident.h"

#include <algorithm>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "scene/stacking.h"
#include "scene/tie_ranks.h"

namespace viewpeel {
namespace {

using glm::dvec3;

// Engines certainly order polygons with a wider gap, in unit-ball units: it is some steps of depth, 2^-27 each.
constexpr double kResolvedGap = 5e-8;

std::set<uint32_t> findSurfaces(const Scene& scene, const std::vector<std::string>& names, const char* option) {
  std::set<uint32_t> found;
  for (const std::string& name : names) {
    const auto at =
        std::find_if(scene.surfaces.begin(), scene.surfaces.end(), [&](const Surface& s) { return s.name == name; });
    if (std::ranges::find(scene.empty_surfaces, name, &EmptyRow::name) != scene.empty_surfaces.end()) continue;
    if (at == scene.surfaces.end())
      throw Error(ErrorCode::bad_usage,
                  fmt::format("{}: {} has no surface '{}'; name one of its surfaces", option, scene.file, name));
    found.insert(static_cast<uint32_t>(at - scene.surfaces.begin()));
  }
  return found;
}

}  // namespace

Stacking::Stacking(Scene& scene, const SceneOptions& options, double rounding)
    : scene_(scene),
      rounding_(rounding),
      tree_(scene),
      sheets_(findSurfaces(scene, options.sheets, "--sheets")),
      solids_(findSurfaces(scene, options.solids, "--solids")) {
  for (uint32_t surface : sheets_)
    if (solids_.count(surface))
      throw Error(ErrorCode::bad_usage, fmt::format("surface '{}' cannot be of --sheets and of --solids; name it once",
                                                    scene.surfaces[surface].name));
  normals_.reserve(scene.polygons.size());
  for (const Polygon& polygon : scene.polygons) normals_.push_back(frontNormal(scene, polygon));
}

// Returns whether the gap between the two polygons is wide enough for engines to order them by depth.
bool Stacking::isResolved(const Overlap& overlap) const {
  if (scene_.polygons[overlap.a].plane == scene_.polygons[overlap.b].plane) return false;
  return overlap.side > 0 ? overlap.low > kResolvedGap : overlap.high < -kResolvedGap;
}

// Moves coincident polygons that engines could not order by depth into the plane of the largest of them.
void Stacking::joinPlanes() {
  std::map<uint32_t, uint32_t> parents;
  const auto rootOf = [&](uint32_t polygon) {
    while (parents.try_emplace(polygon, polygon).first->second != polygon) polygon = parents[polygon];
    return polygon;
  };
  for (const Overlap& overlap : overlaps_)
    if (overlap.side != 0 && scene_.polygons[overlap.a].plane != scene_.polygons[overlap.b].plane &&
        !isResolved(overlap)) {
      uint32_t larger = rootOf(overlap.a), smaller = rootOf(overlap.b);
      if (scene_.polygons[larger].area < scene_.polygons[smaller].area) std::swap(larger, smaller);
      parents[smaller] = larger;
    }
  if (parents.empty()) return;
  const auto hashOf = [](const dvec3& x) {
    return std::hash<double>()(x.x) ^ std::hash<double>()(x.y) * 31 ^ std::hash<double>()(x.z) * 1009;
  };
  std::unordered_multimap<size_t, uint32_t> corners_at;
  for (uint32_t k = 0; k < scene_.corners.size(); ++k) corners_at.emplace(hashOf(scene_.corners[k]), k);
  const auto move = [&](const dvec3& from, const dvec3& to) {
    std::vector<uint32_t> moved;
    for (auto [at, end] = corners_at.equal_range(hashOf(from)); at != end;) {
      if (scene_.corners[at->second] == from) {
        moved.push_back(at->second);
        at = corners_at.erase(at);
      } else {
        ++at;
      }
    }
    for (uint32_t k : moved) {
      scene_.corners[k] = to;
      corners_at.emplace(hashOf(to), k);
    }
  };
  for (const auto& [polygon, parent] : parents) {
    const uint32_t plane_index = scene_.polygons[rootOf(polygon)].plane;
    const Plane& plane = scene_.planes[plane_index];
    Polygon& p = scene_.polygons[polygon];
    if (p.plane == plane_index) continue;
    for (uint32_t k = 0; k < p.corner_count; ++k) {
      const dvec3 from = scene_.corners[p.first_corner + k];
      const double height = glm::dot(plane.normal, from) - plane.offset;
      if (height != 0) move(from, from - height * plane.normal);
    }
    p.plane = plane_index;
    p.front_along_plane_normal = glm::dot(plane.normal, normals_[polygon]) > 0;
  }
}

void Stacking::rankPolygons() {
  TieOrders orders;
  const auto areInOnePlane = [&](const Overlap& overlap) {
    return scene_.polygons[overlap.a].plane == scene_.polygons[overlap.b].plane;
  };
  for (const Overlap& overlap : overlaps_) {
    if (overlap.side == 0 || !areInOnePlane(overlap)) continue;
    const bool b_is_above = (overlap.side > 0) == scene_.polygons[overlap.a].front_along_plane_normal;
    orders.below.emplace_back(b_is_above ? overlap.a : overlap.b, b_is_above ? overlap.b : overlap.a);
  }
  for (uint32_t k : alike_)
    if (areInOnePlane(overlaps_[k])) orders.alike.emplace_back(overlaps_[k].a, overlaps_[k].b);
  in_doubt_ += rankCoincidentPolygons(scene_, std::move(orders));
  for (uint32_t k : alike_) {
    const Overlap& overlap = overlaps_[k];
    const bool has_order = areInOnePlane(overlap)
                               ? scene_.polygons[overlap.a].tie_rank != scene_.polygons[overlap.b].tie_rank
                               : overlap.low > kResolvedGap || overlap.high < -kResolvedGap;
    if (!has_order) ++scene_.coincidences.alike_unordered;
  }
}

void Stacking::report() {
  Coincidences& found = scene_.coincidences;
  for (const Overlap& overlap : overlaps_)
    if (overlap.is_opposite) ++(overlap.side > 0 ? found.contacts : found.sheets);
  found.in_doubt = in_doubt_;
  if (contradictions_ > 0)
    scene_.warnings.push_back(
        fmt::format("{}: {} of {} pairs of coincident polygons, {} first, have free space on one side and the inside "
                    "of a solid on the other; "
                    "turn flipped polygons, close solids, or name surfaces by --sheets or --solids",
                    scene_.file, contradictions_, found.sheets + found.contacts, first_contradiction_));
}

// Returns whether `other` lies between two polygons that look the same way: it looks the opposite way, faces one of
// them and turns its back to the other.
bool Stacking::isBetween(uint32_t other, const Overlap& alike) const {
  const Overlap *to_a = overlapOf(alike.a, other), *to_b = overlapOf(alike.b, other);
  return to_a && to_b && to_a->is_opposite && to_b->is_opposite && to_a->side * to_b->side < 0;
}

// Returns whether something lies between two polygons that look the same way. Where two sheets lie on each other, the
// back of the upper sheet lies between their upper sides.
bool Stacking::isSeparated(const Overlap& alike) const {
  const std::vector<dvec3>& c = alike.corners;
  const dvec3 middle = std::accumulate(c.begin(), c.end(), dvec3(0)) / double(c.size());
  for (uint32_t k : overlaps_of_.at(alike.a)) {
    const uint32_t other = overlaps_[k].a == alike.a ? overlaps_[k].b : overlaps_[k].a;
    if (overlaps_[k].is_opposite && isInside(other, middle) && isBetween(other, alike)) return true;
  }
  return false;
}

void Stacking::findAlike() {
  for (uint32_t k = 0; k < overlaps_.size(); ++k) {
    const Overlap& overlap = overlaps_[k];
    if (overlap.is_opposite) continue;
    if (widthOf(overlap.corners, overlap.area) < 2 * rounding_ || isSeparated(overlap)) continue;
    alike_.push_back(k);
  }
}

std::vector<AlikeOverlap> Stacking::listAlike() const {
  std::vector<AlikeOverlap> found;
  const double nearest = std::max(rounding_, kResolvedGap);
  for (uint32_t k : alike_) {
    const Overlap& overlap = overlaps_[k];
    if (std::max(overlap.high, -overlap.low) <= nearest) found.push_back({overlap.a, overlap.b, overlap.area});
  }
  return found;
}

void Stacking::order() {
  findOverlaps();
  place_of_.assign(overlaps_.size(), 0);
  for (uint32_t k = 0; k < overlaps_.size(); ++k) {
    if (!overlaps_[k].is_opposite) continue;
    place_of_[k] = static_cast<uint32_t>(places_.size());
    places_.push_back(placeOf(overlaps_[k]));
  }
  orderPairs();
  orderPlaces();
  findAlike();
  joinPlanes();
  rankPolygons();
  report();
}

std::vector<AlikeOverlap> orderCoincidentPolygons(Scene& scene, const SceneOptions& options, double rounding) {
  Stacking stacking(scene, options, rounding);
  stacking.order();
  return stacking.listAlike();
}

}  // namespace viewpeel

// The functions here find overlaps pair by pair, and choose the place from which the rays of an overlap start.
#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "scene/stacking.h"

namespace viewpeel {
namespace {

using glm::dvec3;

// A gap wider than this share of the overlap's width is no rounding. The two polygons bound a solid or a room.
constexpr double kThinGap = 0.01;
constexpr size_t kMostOverlaps = 2'000'000;
constexpr uint32_t kMostPlaces = 8;  // places tried in an overlap, to find one without a third polygon

double areaOf(const std::vector<dvec3>& corners) {
  dvec3 twice(0);
  for (size_t k = 1; k + 1 < corners.size(); ++k)
    twice += glm::cross(corners[k] - corners[0], corners[k + 1] - corners[0]);
  return glm::length(twice) / 2;
}

}  // namespace

std::vector<dvec3> Stacking::cornersOf(uint32_t polygon) const {
  const Polygon& p = scene_.polygons[polygon];
  const dvec3* corners = &scene_.corners[p.first_corner];
  return {corners, corners + p.corner_count};
}

// Returns the region that both polygons cover. The corners of b are moved along a's normal into a's plane, and then
// clipped by a's edges (I. Sutherland and G. Hodgman, Reentrant polygon clipping, 1974).
std::vector<dvec3> Stacking::commonPart(uint32_t a, uint32_t b) const {
  const std::vector<dvec3> frame = cornersOf(a);
  const dvec3& normal = normals_[a];
  std::vector<dvec3> points = cornersOf(b), clipped;
  for (dvec3& point : points) point -= normal * glm::dot(normal, point - frame[0]);
  for (size_t k = 0; k < frame.size() && !points.empty(); ++k) {
    const dvec3 inward = glm::cross(normal, frame[(k + 1) % frame.size()] - frame[k]);
    clipped.clear();
    for (size_t m = 0; m < points.size(); ++m) {
      const dvec3 &p = points[m], &q = points[(m + 1) % points.size()];
      const double at_p = glm::dot(inward, p - frame[k]), at_q = glm::dot(inward, q - frame[k]);
      if (at_p >= 0) clipped.push_back(p);
      if ((at_p >= 0) != (at_q >= 0)) clipped.push_back(p + (q - p) * (at_p / (at_p - at_q)));
    }
    points.swap(clipped);
  }
  return points;
}

bool Stacking::isInside(uint32_t polygon, const dvec3& point) const {
  const std::vector<dvec3> corners = cornersOf(polygon);
  for (size_t k = 0; k < corners.size(); ++k) {
    const dvec3 inward = glm::cross(normals_[polygon], corners[(k + 1) % corners.size()] - corners[k]);
    if (glm::dot(inward, point - corners[k]) < 0) return false;
  }
  return true;
}

// Finds the overlaps of all polygons. Pairs of pieces of one face are left out, because pieces tile their face. A face
// of thousands of corners would have millions of such pairs.
void Stacking::findOverlaps() {
  for (uint32_t a = 0; a < scene_.polygons.size(); ++a)
    tree_.forEachNear(a, kCoincidenceReach, [&](uint32_t b) {
      if (b > a && scene_.polygons[a].face != scene_.polygons[b].face &&
          std::abs(glm::dot(normals_[a], normals_[b])) > 0.99)
        findOverlap(a, b);
    });
}

void Stacking::findOverlap(uint32_t a, uint32_t b) {
  const dvec3& at_b = scene_.corners[scene_.polygons[b].first_corner];
  const double along = glm::dot(normals_[a], normals_[b]);
  Overlap overlap{a, b, along < 0, 0, INFINITY, -INFINITY, commonPart(a, b), 0};
  if (overlap.corners.size() < 3) return;
  for (const dvec3& corner : overlap.corners) {
    const double height = glm::dot(normals_[b], at_b - corner) / along;
    overlap.low = std::min(overlap.low, height);
    overlap.high = std::max(overlap.high, height);
  }
  if (std::max(overlap.high, -overlap.low) > kCoincidenceReach) return;
  // Neighbours that share an edge may overlap by a sliver, as wide as the rounding of their corners. It does not count.
  const std::vector<dvec3> of_a = cornersOf(a), of_b = cornersOf(b);
  const double least_width =
      std::min({2 * kCoincidenceReach, 1e-3 * widthOf(of_a, areaOf(of_a)), 1e-3 * widthOf(of_b, areaOf(of_b))});
  overlap.area = areaOf(overlap.corners);
  if (!(overlap.area > 0)) return;
  const double width = widthOf(overlap.corners, overlap.area);
  if (width < least_width || std::max(overlap.high, -overlap.low) > kThinGap * width) return;
  overlap.gap = (overlap.low + overlap.high) / 2;
  if (overlaps_.size() >= kMostOverlaps)
    throw Error(ErrorCode::limit, fmt::format("{}: more than {} pairs of polygons coincide; remove repeated faces",
                                              scene_.file, kMostOverlaps));
  forceOrder(overlap);
  overlaps_of_[a].push_back(static_cast<uint32_t>(overlaps_.size()));
  overlaps_of_[b].push_back(static_cast<uint32_t>(overlaps_.size()));
  overlaps_.push_back(std::move(overlap));
}

void Stacking::forceOrder(Overlap& overlap) const {
  const auto isOf = [&](const std::set<uint32_t>& surfaces) {
    return surfaces.count(scene_.faces[scene_.polygons[overlap.a].face].surface) ||
           surfaces.count(scene_.faces[scene_.polygons[overlap.b].face].surface);
  };
  if (!overlap.is_opposite || isOf(sheets_) == isOf(solids_)) return;
  overlap.side = isOf(solids_) ? 1 : -1;
  overlap.is_forced = true;
}

// Returns a point of the overlap: its middle for trial 0, then random points.
dvec3 Stacking::pointOf(const Overlap& overlap, uint32_t trial) {
  const std::vector<dvec3>& c = overlap.corners;
  if (trial == 0) return std::accumulate(c.begin(), c.end(), dvec3(0)) / double(c.size());
  double left = uniform() * overlap.area, u = uniform(), v = uniform();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  size_t k = 1;
  for (; k + 2 < c.size(); ++k) {
    left -= glm::length(glm::cross(c[k] - c[0], c[k + 1] - c[0])) / 2;
    if (left < 0) break;
  }
  return c[0] + u * (c[k] - c[0]) + v * (c[k + 1] - c[0]);
}

Place Stacking::placeOf(const Overlap& overlap) {
  Place best;
  for (uint32_t trial = 0; trial < kMostPlaces && best.polygons.size() != 2; ++trial) {
    Place place{pointOf(overlap, trial), normals_[overlap.a], {overlap.a, overlap.b}};
    for (uint32_t polygon : {overlap.a, overlap.b})
      for (uint32_t k : overlaps_of_[polygon]) {
        const uint32_t other = overlaps_[k].a == polygon ? overlaps_[k].b : overlaps_[k].a;
        if (other != overlap.a && other != overlap.b && isInside(other, place.point)) place.polygons.push_back(other);
      }
    std::sort(place.polygons.begin(), place.polygons.end());
    place.polygons.erase(std::unique(place.polygons.begin(), place.polygons.end()), place.polygons.end());
    if (best.polygons.empty() || place.polygons.size() < best.polygons.size()) best = std::move(place);
  }
  return best;
}

Overlap* Stacking::overlapOf(uint32_t a, uint32_t b) {
  for (uint32_t k : overlaps_of_[a])
    if (overlaps_[k].a == b || overlaps_[k].b == b) return &overlaps_[k];
  return nullptr;
}

}  // namespace viewpeel

#include "scene/coincident.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <unordered_map>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include <viewpeel/error.h>
#include "scene/perimeter.h"
#include "scene/polygon_tree.h"
#include "scene/tie_ranks.h"

namespace viewpeel {
namespace {

using glm::dvec2, glm::dvec3;

constexpr double kResolvedGap = 5e-8;  // engines order wider gaps for certain: some units of depth, 2^-27 each
constexpr double kThinGap = 0.01;      // of an overlap's width: a thicker gap is a solid or a room of its own
constexpr size_t kMostOverlaps = 2'000'000;
constexpr uint32_t kMostPlaces = 8;   // looked at in an overlap for one where no third polygon lies
constexpr uint32_t kRays = 8;         // to either side of a place
constexpr size_t kMostPermuted = 6;   // polygons of a place whose orders are all tried
constexpr size_t kMostInserted = 16;  // put in one by one

// An Overlap is two polygons of nearly one plane and the part that they have in common.
struct Overlap {
  uint32_t a, b;
  bool is_opposite;            // they look opposite ways
  double gap;                  // mean height of b over a's front
  double low, high;            // least and greatest such height
  std::vector<dvec3> corners;  // of the common part, in a's plane
  double area;
  // For opposite polygons it is 1 where they face each other, -1 where they are back to back, 0 while that is open.
  int side = 0;
  bool is_forced = false;
};

// Votes come from the rays to one side of a place.
struct Votes {
  double free = 0, solid = 0;
  int missed = 0, waiting = 0;
  double total() const { return free + solid; }
  double score() const { return free - solid; }
};

// A Place is a point of an overlap, and all polygons that coincide there.
struct Place {
  dvec3 point, normal;  // of the front of overlap's a
  std::vector<uint32_t> polygons;
};

double widthOf(const std::vector<dvec3>& corners, double area) { return 2 * area / perimeterOf(corners); }

double areaOf(const std::vector<dvec3>& corners) {
  dvec3 twice(0);
  for (size_t k = 1; k + 1 < corners.size(); ++k)
    twice += glm::cross(corners[k] - corners[0], corners[k + 1] - corners[0]);
  return glm::length(twice) / 2;
}

class Stacking {
 public:
  Stacking(Scene& scene, const SceneOptions& options, double rounding);
  void order();
  // Once they are ordered.
  std::vector<AlikeOverlap> listAlike() const;

 private:
  std::vector<dvec3> cornersOf(uint32_t polygon) const;
  std::vector<dvec3> commonPart(uint32_t a, uint32_t b) const;
  bool isInside(uint32_t polygon, const dvec3& point) const;
  void findOverlaps();
  void findOverlap(uint32_t a, uint32_t b);
  void forceOrder(Overlap& overlap) const;
  dvec3 pointOf(const Overlap& overlap, uint32_t trial);
  Place placeOf(const Overlap& overlap);
  Votes castRays(const Place& place, double side);
  std::optional<int> sideAt(const PolygonTree::Hit& hit) const;
  void follow(const std::vector<PolygonTree::Hit>& hits, Votes& votes) const;
  void orderPairs();
  bool orderPair(Overlap& overlap, bool takes_any);
  void decideByGap(Overlap& overlap) const;
  void orderPlaces();
  void orderPlace(const Place& place);
  double costOf(const Place& place, const std::vector<uint32_t>& order, const Votes& below, const Votes& above) const;
  std::vector<uint32_t> cheapestOrder(const Place& place, const Votes& below, const Votes& above) const;
  Overlap* overlapOf(uint32_t a, uint32_t b);
  const Overlap* overlapOf(uint32_t a, uint32_t b) const { return const_cast<Stacking*>(this)->overlapOf(a, b); }
  bool isResolved(const Overlap& overlap) const;
  void joinPlanes();
  void rankPolygons();
  void report();
  bool isBetween(uint32_t other, const Overlap& alike) const;
  bool isSeparated(const Overlap& alike) const;
  void findAlike();

  Scene& scene_;
  const double rounding_;       // gaps up to this are rounding of coordinates
  std::vector<dvec3> normals_;  // of fronts
  PolygonTree tree_;
  std::set<uint32_t> sheets_, solids_;  // surfaces
  std::vector<Overlap> overlaps_;
  std::unordered_map<uint32_t, std::vector<uint32_t>> overlaps_of_;  // of polygons
  std::vector<Place> places_;  // of overlaps, in their order; only of opposite ones
  std::vector<uint32_t> place_of_;
  std::vector<uint32_t> alike_;  // overlaps of different faces that look the same way, with nothing between
  std::mt19937_64 random_{1};
  uint64_t in_doubt_ = 0, contradictions_ = 0;
  std::string first_contradiction_;
  double uniform() { return double(random_() >> 11) * 0x1p-53; }
};

std::set<uint32_t> findSurfaces(const Scene& scene, const std::vector<std::string>& names, const char* option) {
  std::set<uint32_t> found;
  for (const std::string& name : names) {
    const auto at =
        std::find_if(scene.surfaces.begin(), scene.surfaces.end(), [&](const Surface& s) { return s.name == name; });
    if (at == scene.surfaces.end())
      throw Error(ErrorCode::bad_usage,
                  fmt::format("{}: {} has no surface '{}'; name one of its surfaces", option, scene.file, name));
    found.insert(static_cast<uint32_t>(at - scene.surfaces.begin()));
  }
  return found;
}

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

std::vector<dvec3> Stacking::cornersOf(uint32_t polygon) const {
  const Polygon& p = scene_.polygons[polygon];
  const dvec3* corners = &scene_.corners[p.first_corner];
  return {corners, corners + p.corner_count};
}

// Returns b's corners moved along a's normal into a's plane, clipped by a's edges (I. Sutherland and G. Hodgman,
// Reentrant polygon clipping, 1974).
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

void Stacking::findOverlaps() {
  for (uint32_t a = 0; a < scene_.polygons.size(); ++a)
    tree_.forEachNear(a, kCoincidenceReach, [&](uint32_t b) {
      if (b > a && std::abs(glm::dot(normals_[a], normals_[b])) > 0.99) findOverlap(a, b);
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
  // Neighbours that share an edge overlap by a sliver as wide as their corners' rounding.
  const std::vector<dvec3> of_a = cornersOf(a), of_b = cornersOf(b);
  const double least_width =
      std::min({2 * kCoincidenceReach, 1e-3 * widthOf(of_a, areaOf(of_a)), 1e-3 * widthOf(of_b, areaOf(of_b))});
  overlap.area = areaOf(overlap.corners);
  if (!(overlap.area > 0)) return;
  const double width = widthOf(overlap.corners, overlap.area);
  if (width < least_width || std::max(overlap.high, -overlap.low) > kThinGap * width) return;
  overlap.gap = (overlap.low + overlap.high) / 2;
  if (overlaps_.size() >= kMostOverlaps)
    throw Error(ErrorCode::limit,
                fmt::format("{}: more than {} pairs of polygons coincide; remove faces that are there many times",
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

// Returns the middle of the common part, then points at random.
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

// Casts the rays of one side and counts their votes.
//   In: side: 1 for rays ahead of the place's normal, -1 for rays behind
Votes Stacking::castRays(const Place& place, double side) {
  Votes votes;
  const dvec3 axis = side * place.normal;
  const dvec3 across = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const double turn = uniform();
  for (uint32_t k = 0; k < kRays; ++k) {
    // Each ray has one of kRays parts of a hemisphere without its rim, by the golden angle.
    const double height = 0.25 + 0.75 * (k + uniform()) / kRays,
                 angle = 2 * std::numbers::pi * (turn + k * std::numbers::phi);
    const double radius = std::sqrt(1 - height * height);
    const dvec3 direction =
        height * axis + radius * (std::cos(angle) * across + std::sin(angle) * glm::cross(axis, across));
    follow(tree_.cast(place.point, direction, 2 * kCoincidenceReach / height), votes);
  }
  return votes;
}

// Returns how the polygon that was hit and an opposite one that coincides with it there are ordered: nothing without
// such a one.
std::optional<int> Stacking::sideAt(const PolygonTree::Hit& hit) const {
  const auto at = overlaps_of_.find(hit.polygon);
  if (at == overlaps_of_.end()) return std::nullopt;
  for (uint32_t m : at->second) {
    const Overlap& overlap = overlaps_[m];
    if (overlap.is_opposite && isInside(overlap.a == hit.polygon ? overlap.b : overlap.a, hit.point))
      return overlap.side;
  }
  return std::nullopt;
}

// Counts fronts less backs along a ray. Where the count falls below 0 the ray has left a solid that its origin lies in.
// The first hit weighs most: farther off, open surfaces mislead.
void Stacking::follow(const std::vector<PolygonTree::Hit>& hits, Votes& votes) const {
  int count = 0;
  for (size_t k = 0, next = 0; k < hits.size(); k = next) {
    int fronts = 0, backs = 0, side = -1;
    for (; next < hits.size() && hits[next].distance <= hits[k].distance + 2 * kCoincidenceReach; ++next) {
      ++(hits[next].is_front ? fronts : backs);
      if (const auto its_side = sideAt(hits[next])) side = *its_side;
    }
    if (fronts > 0 && backs > 0 && side == 0 && k == 0) {
      ++votes.waiting;
      return;
    }
    const bool backs_first = side > 0;  // of touching solids the ray leaves one, then enters the other
    if (count + (backs_first ? 0 : fronts) - backs < 0) {
      votes.solid += k == 0 ? 1 : 0.5;
      return;
    }
    count += fronts - backs;
  }
  if (hits.empty()) ++votes.missed;
  else ++votes.free;
}

// Orders pairs that lie somewhere without a third polygon. Rays that end on coincident polygons decide more in the next
// round.
void Stacking::orderPairs() {
  std::vector<uint32_t> open;
  for (uint32_t k = 0; k < overlaps_.size(); ++k)
    if (overlaps_[k].is_opposite && overlaps_[k].side == 0 && places_[place_of_[k]].polygons.size() == 2)
      open.push_back(k);
  while (!open.empty()) {
    const size_t before = open.size();
    std::erase_if(open, [&](uint32_t k) { return orderPair(overlaps_[k], false); });
    if (open.size() < before || open.empty()) continue;
    // All wait for one another: the votes there are decide, or the first one's gap.
    std::erase_if(open, [&](uint32_t k) { return orderPair(overlaps_[k], true); });
    if (open.size() < before) continue;
    decideByGap(overlaps_[open.front()]);
    ++in_doubt_;
    open.erase(open.begin());
  }
}

void Stacking::decideByGap(Overlap& overlap) const { overlap.side = overlap.gap > rounding_ ? 1 : -1; }

// Returns false where rays have to wait for other pairs.    In: takes_any: one ray's word is enough
bool Stacking::orderPair(Overlap& overlap, bool takes_any) {
  const Place& place = places_[place_of_[static_cast<size_t>(&overlap - overlaps_.data())]];
  const Votes ahead = castRays(place, 1), behind = castRays(place, -1);
  const double score = ahead.score() + behind.score(), total = ahead.total() + behind.total();
  const int waiting = ahead.waiting + behind.waiting;
  const double least_score = takes_any || waiting == 0 ? 0.5 : 2;
  const bool is_clear = std::abs(score) >= least_score && 2 * std::abs(score) >= total;
  if (is_clear) {
    overlap.side = score > 0 ? -1 : 1;
    return true;
  }
  if (waiting > 0) return false;
  // Rays that all leave the scene have hit nothing: a sheet in space, unless its sides face each other across a gap.
  if (total > 0) ++in_doubt_;
  if (total > 0 && contradictions_++ == 0) {
    const Face& face = scene_.faces[scene_.polygons[overlap.a].face];
    first_contradiction_ = fmt::format("{}[{}]", scene_.surfaces[face.surface].name, face.number);
  }
  decideByGap(overlap);
  return true;
}

void Stacking::orderPlaces() {
  for (uint32_t k = 0; k < overlaps_.size(); ++k)
    if (overlaps_[k].is_opposite && overlaps_[k].side == 0) orderPlace(places_[place_of_[k]]);
}

// Returns how much an order of the polygons of a place along its normal contradicts. It may contradict the space on
// either side, the rule that free space and solids take turns, the order of pairs elsewhere, and gaps.
double Stacking::costOf(const Place& place, const std::vector<uint32_t>& order, const Votes& below,
                        const Votes& above) const {
  const auto looksUp = [&](uint32_t polygon) { return glm::dot(normals_[polygon], place.normal) > 0; };
  const auto against = [](const Votes& votes, bool is_free) {
    return (is_free ? votes.solid : votes.free) / double(kRays);
  };
  double cost = 4 * against(below, !looksUp(order.front())) + 4 * against(above, looksUp(order.back()));
  for (size_t k = 0; k + 1 < order.size(); ++k)
    if (looksUp(order[k]) == looksUp(order[k + 1])) cost += 3;  // as nested solids do
  for (size_t k = 0; k < order.size(); ++k)
    for (size_t m = k + 1; m < order.size(); ++m) {
      const uint32_t lower = order[k], upper = order[m];
      if (lower > upper) cost += 1e-4;
      const Overlap* overlap = overlapOf(lower, upper);
      if (!overlap) continue;
      const int upper_side = looksUp(lower) ? 1 : -1;  // where `upper` is, as seen from the front of `lower`
      if (overlap->side == -upper_side) cost += overlap->is_forced ? 100 : 3;
      if (overlap->side != 0) continue;
      const double height = overlap->a == lower || overlap->is_opposite ? overlap->gap : -overlap->gap;
      if (std::abs(height) > rounding_ && (height > 0) != (upper_side > 0)) cost += 0.25;
      // The same outline twice is two sides of one sheet rather than a contact.
      const bool is_same = overlap->is_opposite &&
                           overlap->area > 0.999 * std::max(scene_.polygons[lower].area, scene_.polygons[upper].area);
      if (is_same && upper_side > 0) cost += 2;
    }
  return cost;
}

// Returns the order of least cost. All orders are tried where they are few; else polygons are put in one by one, each
// where it costs least. Of very many, polygons that look down and up take turns.
std::vector<uint32_t> Stacking::cheapestOrder(const Place& place, const Votes& below, const Votes& above) const {
  std::vector<uint32_t> best;
  double best_cost = INFINITY;
  const auto look = [&](const std::vector<uint32_t>& order) {
    if (const double cost = costOf(place, order, below, above); cost < best_cost) {
      best_cost = cost;
      best = order;
    }
  };
  if (place.polygons.size() <= kMostPermuted) {
    std::vector<uint32_t> order = place.polygons;
    do look(order);
    while (std::next_permutation(order.begin(), order.end()));
    return best;
  }
  if (place.polygons.size() > kMostInserted) {
    std::array<std::vector<uint32_t>, 2> facing;  // down, up
    for (uint32_t polygon : place.polygons) facing[glm::dot(normals_[polygon], place.normal) > 0].push_back(polygon);
    for (size_t k = 0; k < place.polygons.size(); ++k)
      for (const auto& list : facing)
        if (k < list.size()) best.push_back(list[k]);
    return best;
  }
  std::vector<uint32_t> so_far;
  for (uint32_t polygon : place.polygons) {
    best_cost = INFINITY;
    for (size_t at = 0; at <= so_far.size(); ++at) {
      std::vector<uint32_t> order = so_far;
      order.insert(order.begin() + static_cast<ptrdiff_t>(at), polygon);
      look(order);
    }
    so_far = best;
  }
  return so_far;
}

void Stacking::orderPlace(const Place& place) {
  const std::vector<uint32_t> order = cheapestOrder(place, castRays(place, -1), castRays(place, 1));
  for (size_t k = 0; k < order.size(); ++k)
    for (size_t m = k + 1; m < order.size(); ++m) {
      Overlap* overlap = overlapOf(order[k], order[m]);
      // Of two that look the same way one hides the other: rankPolygons() says which.
      if (!overlap || !overlap->is_opposite || overlap->side != 0) continue;
      overlap->side = glm::dot(normals_[order[k]], place.normal) > 0 ? 1 : -1;
    }
}

// Returns whether the gap between the two keeps them in their order by itself.
bool Stacking::isResolved(const Overlap& overlap) const {
  if (scene_.polygons[overlap.a].plane == scene_.polygons[overlap.b].plane) return false;
  return overlap.side > 0 ? overlap.low > kResolvedGap : overlap.high < -kResolvedGap;
}

// Moves polygons whose gaps do not show their order into the plane of the largest of them.
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

// Returns whether an opposite polygon faces one of two that look alike and turns its back to the other one.
bool Stacking::isBetween(uint32_t other, const Overlap& alike) const {
  const Overlap *to_a = overlapOf(alike.a, other), *to_b = overlapOf(alike.b, other);
  return to_a && to_b && to_a->is_opposite && to_b->is_opposite && to_a->side * to_b->side < 0;
}

// As two sheets lie on each other: the upper one's back is between their upper sides.
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
    if (overlap.is_opposite || scene_.polygons[overlap.a].face == scene_.polygons[overlap.b].face) continue;
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

}  // namespace

std::vector<AlikeOverlap> orderCoincidentPolygons(Scene& scene, const SceneOptions& options, double rounding) {
  Stacking stacking(scene, options, rounding);
  stacking.order();
  return stacking.listAlike();
}

}  // namespace viewpeel

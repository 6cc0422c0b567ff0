// Rays from places decide the order of the polygons that coincide there. Pairs are ordered first, then larger stacks.
#include <algorithm>
#include <array>
#include <numbers>

#include <fmt/format.h>

#include "scene/stacking.h"

namespace viewpeel {
namespace {

using glm::dvec3;

constexpr uint32_t kSightRays = 8;    // rays to each side of a place
constexpr size_t kMostPermuted = 6;   // up to this number of polygons at a place, all their orders are tried
constexpr size_t kMostInserted = 16;  // up to this number, polygons are inserted one by one where they cost least

}  // namespace

// Casts rays to one side of a place, and counts their votes.
//   In: side: 1 for the side to which the place's normal points, -1 for the other side
Votes Stacking::castRays(const Place& place, double side) {
  Votes votes;
  const dvec3 axis = side * place.normal;
  const dvec3 across = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const double turn = uniform();
  for (uint32_t k = 0; k < kSightRays; ++k) {
    // The hemisphere without its rim is cut into kSightRays zones. Each ray gets a zone, and turns by the golden angle.
    const double height = 0.25 + 0.75 * (k + uniform()) / kSightRays,
                 angle = 2 * std::numbers::pi * (turn + k * std::numbers::phi);
    const double radius = std::sqrt(1 - height * height);
    const dvec3 direction =
        height * axis + radius * (std::cos(angle) * across + std::sin(angle) * glm::cross(axis, across));
    follow(tree_.cast(place.point, direction, 2 * kCoincidenceReach / height), votes);
  }
  return votes;
}

// Returns Overlap::side of the polygon that a ray hit and a polygon that coincides with it there and looks the opposite
// way; nullopt where there is none.
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

// Counts the fronts minus the backs along a ray. If the count falls below 0, the ray has left a solid that its origin
// lies in. The first hit has the largest weight, because open surfaces farther away mislead.
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
    const bool backs_first = side > 0;  // touching solids: the ray leaves one, then enters the other
    if (count + (backs_first ? 0 : fronts) - backs < 0) {
      votes.solid += k == 0 ? 1 : 0.5;
      return;
    }
    count += fronts - backs;
  }
  if (hits.empty()) ++votes.missed;
  else ++votes.free;
}

// Orders the pairs that have a place without a third polygon. A ray that ends on coincident polygons waits for a later
// round, in which these polygons are ordered.
void Stacking::orderPairs() {
  std::vector<uint32_t> open;
  for (uint32_t k = 0; k < overlaps_.size(); ++k)
    if (overlaps_[k].is_opposite && overlaps_[k].side == 0 && places_[place_of_[k]].polygons.size() == 2)
      open.push_back(k);
  while (!open.empty()) {
    const size_t before = open.size();
    std::erase_if(open, [&](uint32_t k) { return orderPair(overlaps_[k], false); });
    if (open.size() < before || open.empty()) continue;
    // All remaining pairs wait for one another. The votes so far decide some of them, or else the gap of the first
    // pair.
    std::erase_if(open, [&](uint32_t k) { return orderPair(overlaps_[k], true); });
    if (open.size() < before) continue;
    decideByGap(overlaps_[open.front()]);
    ++in_doubt_;
    open.erase(open.begin());
  }
}

void Stacking::decideByGap(Overlap& overlap) const { overlap.side = overlap.gap > rounding_ ? 1 : -1; }

// Orders a pair. Returns false where its rays wait for other pairs.    In: takes_any: a single vote is enough
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
  // Without a vote the pair is a sheet in free space, unless its polygons face each other across a gap.
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

// Returns how strongly observations contradict an order of a place's polygons along its normal. Observations are votes
// of the space on either side, the rule that free space and solids alternate, the order of pairs elsewhere, and gaps.
double Stacking::costOf(const Place& place, const std::vector<uint32_t>& order, const Votes& below,
                        const Votes& above) const {
  const auto looksUp = [&](uint32_t polygon) { return glm::dot(normals_[polygon], place.normal) > 0; };
  const auto against = [](const Votes& votes, bool is_free) {
    return (is_free ? votes.solid : votes.free) / double(kSightRays);
  };
  double cost = 4 * against(below, !looksUp(order.front())) + 4 * against(above, looksUp(order.back()));
  for (size_t k = 0; k + 1 < order.size(); ++k)
    if (looksUp(order[k]) == looksUp(order[k + 1])) cost += 3;  // only nested solids have two such polygons in a row
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
      // Two polygons of the same outline are more likely the two sides of a sheet than a contact.
      const bool is_same = overlap->is_opposite &&
                           overlap->area > 0.999 * std::max(scene_.polygons[lower].area, scene_.polygons[upper].area);
      if (is_same && upper_side > 0) cost += 2;
    }
  return cost;
}

// Returns the order of least cost. For few polygons all orders are tried. For more, polygons are inserted one by one
// where they cost least. For very many, polygons that look down and polygons that look up alternate.
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
      // Of two polygons that look the same way, rankPolygons() decides which one hides the other.
      if (!overlap || !overlap->is_opposite || overlap->side != 0) continue;
      overlap->side = glm::dot(normals_[order[k]], place.normal) > 0 ? 1 : -1;
    }
}

}  // namespace viewpeel

// Rays from places order the polygons that coincide there, first pairs, then stacks of more.
#include <algorithm>
#include <array>
#include <numbers>

#include <fmt/format.h>

#include "scene/stacking.h"

namespace viewpeel {
namespace {

using glm::dvec3;

constexpr uint32_t kRays = 8;         // to either side of a place
constexpr size_t kMostPermuted = 6;   // polygons of a place whose orders are all tried
constexpr size_t kMostInserted = 16;  // put in one by one

}  // namespace

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
    // All wait for one another. The votes so far decide, or else the first one's gap.
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
      // Where two look the same way, one hides the other: rankPolygons() says which.
      if (!overlap || !overlap->is_opposite || overlap->side != 0) continue;
      overlap->side = glm::dot(normals_[order[k]], place.normal) > 0 ? 1 : -1;
    }
}

}  // namespace viewpeel

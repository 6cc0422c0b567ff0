#include "scene/shells.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>

#include <glm/glm.hpp>

namespace viewpeel {
namespace {

using glm::dvec3;

constexpr size_t kMostOpenEdges = 4000;  // with fewer open edges, each is cut where the ends of others lie on it
constexpr uint64_t kMostRays = 1 << 18;
constexpr uint32_t kLeastHits = 4, kTurns = 4;
constexpr double kThickness = 1e-4;  // least thickness of a room: volume over area, unit-ball units
constexpr double kAlmost = 0.1;      // share of rays that other parts of a mesh may spoil

struct EdgeUse {
  uint32_t low, high;  // vertices
  uint32_t polygon;
  bool is_forward;  // runs from low to high
  auto key() const { return std::pair(low, high); }
};

// Sides are sets of joined faces, with the side to which each face's front looks (union-find, paths halved, by weight).
class Sides {
 public:
  explicit Sides(size_t count) : parents_(count), turned_(count, false) {
    std::iota(parents_.begin(), parents_.end(), 0u);
  }
  // Returns the face that represents the set, and whether `face` is turned against it.
  std::pair<uint32_t, bool> find(uint32_t face) {
    uint32_t root = face;
    bool turned = false;
    for (; parents_[root] != root; root = parents_[root]) turned ^= turned_[root];
    bool left = turned;
    while (parents_[face] != root && face != root) {
      const uint32_t next = parents_[face];
      const bool step = turned_[face];
      parents_[face] = root;
      turned_[face] = left;
      left ^= step;
      face = next;
    }
    return {root, turned};
  }
  // Joins two sets. Returns false where they are joined already, with the opposite turn.
  bool join(uint32_t a, uint32_t b, bool turned) {
    auto [root_a, turned_a] = find(a);
    auto [root_b, turned_b] = find(b);
    if (root_a == root_b) return (turned_a ^ turned_b) == turned;
    parents_[root_b] = root_a;
    turned_[root_b] = turned_a ^ turned_b ^ turned;
    return true;
  }

 private:
  std::vector<uint32_t> parents_;
  std::vector<bool> turned_;  // whether a face is turned against its parent
};

class ShellFinder {
 public:
  explicit ShellFinder(const Scene& scene)
      : scene_(scene), sides_(scene.faces.size()), is_twisted_(scene.faces.size(), false) {}
  std::vector<Shell> find();

 private:
  void nameVertices();
  void collectUses();
  void cutOpenEdges();
  template <class Use>
  void forEachEdge(Use use);
  uint32_t faceOf(const EdgeUse& use) const { return scene_.polygons[use.polygon].face; }
  uint32_t surfaceOf(const EdgeUse& use) const { return scene_.faces[faceOf(use)].surface; }
  void join(const EdgeUse& a, const EdgeUse& b) {
    if (!sides_.join(faceOf(a), faceOf(b), a.is_forward == b.is_forward)) is_twisted_[faceOf(a)] = true;
  }
  void joinMany(std::vector<EdgeUse> uses);
  double wedgeBetween(const EdgeUse& a, const EdgeUse& b) const;
  void findOpenings(std::vector<Shell>& shells, const std::vector<uint32_t>& shell_of);

  const Scene& scene_;
  Sides sides_;
  std::vector<bool> is_twisted_;
  std::vector<uint32_t> vertices_;  // by corner
  std::vector<dvec3> places_;       // by vertex
  std::vector<EdgeUse> uses_;       // sorted by edge, without edges between polygons of one face
};

void ShellFinder::nameVertices() {
  std::vector<uint32_t> order(scene_.corners.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto keyOf = [&](uint32_t k) {
    return std::tuple(scene_.corners[k].x, scene_.corners[k].y, scene_.corners[k].z);
  };
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return keyOf(a) < keyOf(b); });
  vertices_.resize(order.size());
  for (size_t k = 0; k < order.size(); ++k) {
    if (k == 0 || keyOf(order[k]) != keyOf(order[k - 1])) places_.push_back(scene_.corners[order[k]]);
    vertices_[order[k]] = static_cast<uint32_t>(places_.size() - 1);
  }
}

template <class Use>
void ShellFinder::forEachEdge(Use use) {
  std::sort(uses_.begin(), uses_.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tuple(a.low, a.high, a.polygon) < std::tuple(b.low, b.high, b.polygon);
  });
  for (size_t k = 0, next = 0; k < uses_.size(); k = next) {
    while (next < uses_.size() && uses_[next].key() == uses_[k].key()) ++next;
    use(&uses_[k], next - k);
  }
}

void ShellFinder::collectUses() {
  for (uint32_t polygon = 0; polygon < scene_.polygons.size(); ++polygon) {
    const Polygon& p = scene_.polygons[polygon];
    for (uint32_t k = 0; k < p.corner_count; ++k) {
      const uint32_t from = vertices_[p.first_corner + k], to = vertices_[p.first_corner + (k + 1) % p.corner_count];
      if (from != to) uses_.push_back({std::min(from, to), std::max(from, to), polygon, from < to});
    }
  }
  // Edges where the pieces of a split face meet are left out.
  std::vector<EdgeUse> kept;
  forEachEdge([&](const EdgeUse* first, size_t count) {
    for (size_t a = 0; a < count; ++a) {
      bool is_inner = false;
      for (size_t b = 0; b < count && !is_inner; ++b)
        is_inner = a != b && faceOf(first[a]) == faceOf(first[b]) && first[a].is_forward != first[b].is_forward;
      if (!is_inner) kept.push_back(first[a]);
    }
  });
  uses_ = std::move(kept);
}

void ShellFinder::cutOpenEdges() {
  std::vector<EdgeUse> open, kept;
  forEachEdge([&](const EdgeUse* first, size_t count) {
    if (count == 1) open.push_back(*first);
    else kept.insert(kept.end(), first, first + count);
  });
  if (open.empty() || open.size() > kMostOpenEdges) return;
  std::vector<uint32_t> ends;
  for (const EdgeUse& use : open) ends.insert(ends.end(), {use.low, use.high});
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  for (const EdgeUse& use : open) {
    const dvec3 &a = places_[use.low], along = places_[use.high] - a;
    std::vector<std::pair<double, uint32_t>> cuts = {{0, use.low}, {1, use.high}};
    for (uint32_t end : ends) {
      const double at = glm::dot(places_[end] - a, along) / glm::dot(along, along);
      if (at > 1e-12 && at < 1 - 1e-12 && glm::length(a + at * along - places_[end]) < 1e-12) cuts.push_back({at, end});
    }
    std::sort(cuts.begin(), cuts.end());
    for (size_t k = 0; k + 1 < cuts.size(); ++k) {
      const uint32_t from = cuts[k].second, to = cuts[k + 1].second;
      kept.push_back({std::min(from, to), std::max(from, to), use.polygon, use.is_forward == (from < to)});
    }
  }
  uses_ = std::move(kept);
}

// Returns the angle between two faces at an edge: of the free space in front of both, or of the solid behind both,
// whichever is smaller. Solid counts a little less, so that the faces of a box on a tiled floor join each other before
// they join tiles. It is infinite where the two faces cannot belong to one surface.
double ShellFinder::wedgeBetween(const EdgeUse& a, const EdgeUse& b) const {
  if (a.is_forward == b.is_forward) return INFINITY;
  const dvec3 axis = glm::normalize(places_[a.high] - places_[a.low]);
  const auto inwardOf = [&](const EdgeUse& use) {  // direction from the edge into the face
    const dvec3 normal = frontNormal(scene_, scene_.polygons[use.polygon]);
    return glm::cross(normal, use.is_forward ? axis : -axis);
  };
  const EdgeUse &forward = a.is_forward ? a : b, &backward = a.is_forward ? b : a;
  const dvec3 u = inwardOf(forward), v = inwardOf(backward);
  // The front of the face with the forward edge is on the side to which the axis turns the inward direction.
  double free = std::atan2(glm::dot(axis, glm::cross(u, v)), glm::dot(u, v));
  if (free < 0) free += 2 * std::numbers::pi;
  const double solid = 2 * std::numbers::pi - free;
  if (std::min(free, solid) < 1e-6) return INFINITY;  // the faces coincide
  return std::min(free, solid - 1e-3);
}

void ShellFinder::joinMany(std::vector<EdgeUse> uses) {
  std::map<uint32_t, std::vector<EdgeUse>> by_surface;
  for (const EdgeUse& use : uses) by_surface[surfaceOf(use)].push_back(use);
  uses.clear();
  for (const auto& [surface, surface_uses] : by_surface) {
    if (surface_uses.size() == 2) join(surface_uses[0], surface_uses[1]);
    else uses.insert(uses.end(), surface_uses.begin(), surface_uses.end());
  }
  while (uses.size() >= 2) {
    double least = INFINITY;
    std::pair<size_t, size_t> nearest;
    for (size_t a = 0; a < uses.size(); ++a)
      for (size_t b = a + 1; b < uses.size(); ++b)
        if (const double wedge = wedgeBetween(uses[a], uses[b]); wedge < least) {
          least = wedge;
          nearest = {a, b};
        }
    if (least == INFINITY) return;
    join(uses[nearest.first], uses[nearest.second]);
    uses.erase(uses.begin() + static_cast<ptrdiff_t>(nearest.second));
    uses.erase(uses.begin() + static_cast<ptrdiff_t>(nearest.first));
  }
}

// Finds the shells that are not closed, and those of them whose open edges lie on one side of the bounding box.
void ShellFinder::findOpenings(std::vector<Shell>& shells, const std::vector<uint32_t>& shell_of) {
  dvec3 low(INFINITY), high(-INFINITY);
  for (const dvec3& place : places_) low = glm::min(low, place), high = glm::max(high, place);
  const auto sidesOf = [&](const dvec3& place) {
    std::bitset<6> sides;
    for (int axis = 0; axis < 3; ++axis)
      sides[2 * axis] = place[axis] == low[axis], sides[2 * axis + 1] = place[axis] == high[axis];
    return sides;
  };
  std::vector<std::bitset<6>> with_all_openings(shells.size(), std::bitset<6>().set());
  forEachEdge([&](const EdgeUse* first, size_t count) {
    for (size_t a = 0; a < count; ++a) {
      const uint32_t shell = shell_of[faceOf(first[a])];
      int balance = 0;
      for (size_t b = 0; b < count; ++b)
        if (shell_of[faceOf(first[b])] == shell)
          balance += (first[b].is_forward != sides_.find(faceOf(first[b])).second) ? 1 : -1;
      if (balance == 0) continue;
      shells[shell].is_closed = false;
      shells[shell].outer_opening = places_[first->low];
      with_all_openings[shell] &= sidesOf(places_[first->low]) & sidesOf(places_[first->high]);
    }
  });
  for (size_t k = 0; k < shells.size(); ++k)
    if (with_all_openings[k].none()) shells[k].outer_opening.reset();
}

std::vector<Shell> ShellFinder::find() {
  constexpr size_t kMostAtAnEdge = 64;  // above this number not all pairs of edges are compared
  nameVertices();
  collectUses();
  cutOpenEdges();
  forEachEdge([&](const EdgeUse* first, size_t count) {
    if (count == 2) join(first[0], first[1]);
    else if (count > 2 && count <= kMostAtAnEdge) joinMany({first, first + count});
  });
  std::vector<double> areas(scene_.faces.size(), 0);
  for (const Polygon& polygon : scene_.polygons) areas[polygon.face] += polygon.area;
  std::map<uint32_t, uint32_t> shell_of_root;
  std::vector<Shell> shells;
  std::vector<uint32_t> shell_of(areas.size());
  std::vector<std::array<double, 2>> area_of_side;
  for (uint32_t face = 0; face < areas.size(); ++face) {
    const auto [root, turned] = sides_.find(face);
    const auto [at, is_new] = shell_of_root.try_emplace(root, uint32_t(shells.size()));
    if (is_new) {
      shells.push_back({});
      shells.back().is_closed = true;
      area_of_side.push_back({0, 0});
    }
    shell_of[face] = at->second;
    Shell& shell = shells[at->second];
    shell.faces.push_back(face);
    shell.is_against.push_back(turned);
    shell.is_twisted = shell.is_twisted || is_twisted_[face];
    area_of_side[at->second][turned] += areas[face];
  }
  findOpenings(shells, shell_of);
  for (size_t k = 0; k < shells.size(); ++k)
    if (area_of_side[k][1] > area_of_side[k][0]) shells[k].is_against.flip();
  return shells;
}

// Seen counts rays from a shell: `rays` from its fronts and as many from its backs. by_front counts rays from fronts
// that end on fronts of other shells, by_back such rays from backs. `anything` counts rays from fronts that end at all.
struct Seen {
  uint32_t rays = 0, by_front = 0, by_back = 0, anything = 0;
};

// Returns whether a closed scene encloses a volume, rather than being faces back to back.
bool holdsSpace(const Scene& scene) {
  double volume = 0, area = 0;
  for (const Polygon& polygon : scene.polygons) {
    volume += volumeBehind(scene, polygon, dvec3(0));
    area += polygon.area;
  }
  return std::abs(volume) > kThickness * area;
}

}  // namespace

std::vector<Shell> findShells(const Scene& scene) { return ShellFinder(scene).find(); }

std::vector<uint32_t> shellsOfFaces(const std::vector<Shell>& shells, size_t face_count) {
  std::vector<uint32_t> shell_of(face_count);
  for (uint32_t k = 0; k < shells.size(); ++k)
    for (const uint32_t face : shells[k].faces) shell_of[face] = k;
  return shell_of;
}

double volumeBehind(const Scene& scene, const Polygon& polygon, const dvec3& apex) {
  return polygon.area * glm::dot(frontNormal(scene, polygon), scene.corners[polygon.first_corner] - apex) / 3;
}

std::vector<uint32_t> findFlipped(const Scene& scene, const std::vector<Shell>& shells, Sight& sight) {
  std::vector<bool> turned(scene.faces.size(), false);
  const std::vector<uint32_t> shell_of = shellsOfFaces(shells, scene.faces.size());
  std::vector<std::vector<uint32_t>> polygons(shells.size());
  std::vector<std::vector<double>> sums(shells.size());
  for (const Shell& shell : shells)
    for (size_t m = 0; m < shell.faces.size(); ++m) turned[shell.faces[m]] = shell.is_against[m] && !shell.is_twisted;
  for (uint32_t polygon = 0; polygon < scene.polygons.size(); ++polygon) {
    const uint32_t k = shell_of[scene.polygons[polygon].face];
    polygons[k].push_back(polygon);
    sums[k].push_back((sums[k].empty() ? 0 : sums[k].back()) + scene.polygons[polygon].area);
  }
  const auto turnShell = [&](const Shell& shell) {
    for (uint32_t face : shell.faces) turned[face] = !turned[face];
  };
  const auto rays = static_cast<uint32_t>(std::clamp<uint64_t>(kMostRays / (2 * shells.size()), 8, 256));
  const auto lookFrom = [&](uint32_t k) {
    Seen seen{rays, 0, 0, 0};
    for (uint32_t ray = 0; ray < 2 * rays; ++ray) {
      const bool from_front = ray % 2 == 0;
      const uint32_t polygon = polygons[k][pickBySums(sums[k], sight.uniform() * sums[k].back())];
      const Sight::End end = sight.look(polygon, from_front != turned[scene.polygons[polygon].face]);
      if (end.polygon == Sight::kNothing) continue;
      const uint32_t face = scene.polygons[end.polygon].face;
      seen.anything += from_front;
      if (shell_of[face] != k && end.is_front != turned[face]) ++(from_front ? seen.by_front : seen.by_back);
    }
    return seen;
  };
  std::vector<bool> was_turned(shells.size(), false);
  bool sees_nothing = true;
  for (uint32_t turn = 0; turn < kTurns; ++turn) {
    std::vector<uint32_t> wrong;
    for (uint32_t k = 0; k < shells.size(); ++k) {
      const Seen seen = lookFrom(k);
      sees_nothing = sees_nothing && seen.anything == 0;
      const bool fronts_idle = seen.by_front <= kAlmost * (seen.by_front + seen.by_back);
      const bool backs_seen = seen.by_back >= (shells[k].is_closed ? kLeastHits : (1 - kAlmost) * seen.rays);
      if (fronts_idle && backs_seen && !was_turned[k]) wrong.push_back(k);
    }
    for (uint32_t k : wrong) {
      was_turned[k] = true;
      turnShell(shells[k]);
    }
    if (wrong.empty()) break;
    sees_nothing = false;
  }
  if (sees_nothing && shells.size() == 1 && shells[0].is_closed && holdsSpace(scene)) turnShell(shells[0]);
  std::vector<uint32_t> faces;
  for (uint32_t face = 0; face < turned.size(); ++face)
    if (turned[face]) faces.push_back(face);
  return faces;
}

}  // namespace viewpeel

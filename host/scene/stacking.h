// A Stacking orders the coincident polygons of a scene (coincident.h). It finds their overlaps (find_overlaps.cpp),
// orders polygons that look opposite ways by rays (order_overlaps.cpp), and gives every polygon its tie rank
// (coincident.cpp).
#pragma once
#include <cmath>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include <glm/glm.hpp>

#include "scene/coincident.h"
#include "scene/perimeter.h"
#include "scene/polygon_tree.h"

namespace viewpeel {

// An Overlap is a pair of polygons of nearly the same plane, with the region that both cover.
struct Overlap {
  uint32_t a, b;
  bool is_opposite;                 // the two look opposite ways
  double gap;                       // mean height of b over the front of a, unit-ball units
  double low, high;                 // least and greatest height of b over the front of a
  std::vector<glm::dvec3> corners;  // of the common region, in a's plane
  double area;                      // of the common region
  // For polygons that look opposite ways: 1 if they face each other, -1 if they are back to back, 0 while undecided.
  int side = 0;
  bool is_forced = false;  // the user's options decide `side`
};

// Votes counts what the rays to one side of a place found.
struct Votes {
  double free = 0, solid = 0;   // weight of rays that started in free space, and inside a solid
  int missed = 0, waiting = 0;  // rays that hit nothing, and rays that wait for coincident polygons to be ordered
  double total() const { return free + solid; }
  double score() const { return free - solid; }
};

// A Place is a point of an overlap, with all polygons that coincide there.
struct Place {
  glm::dvec3 point, normal;  // normal: of the front of the overlap's polygon a
  std::vector<uint32_t> polygons;
};

inline double widthOf(const std::vector<glm::dvec3>& corners, double area) { return 2 * area / perimeterOf(corners); }

class Stacking {
 public:
  Stacking(Scene& scene, const SceneOptions& options, double rounding);
  void order();
  // Returns the overlaps of polygons that look the same way. Call it after order().
  std::vector<AlikeOverlap> listAlike() const;

 private:
  std::vector<glm::dvec3> cornersOf(uint32_t polygon) const;
  std::vector<glm::dvec3> commonPart(uint32_t a, uint32_t b) const;
  bool isInside(uint32_t polygon, const glm::dvec3& point) const;
  void findOverlaps();
  void findOverlap(uint32_t a, uint32_t b);
  void forceOrder(Overlap& overlap) const;
  glm::dvec3 pointOf(const Overlap& overlap, uint32_t trial);
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
  const double rounding_;            // gaps up to this may come from rounding of coordinates
  std::vector<glm::dvec3> normals_;  // front normal of each polygon
  PolygonTree tree_;
  std::set<uint32_t> sheets_, solids_;  // surfaces that the user's options name
  std::vector<Overlap> overlaps_;
  std::unordered_map<uint32_t, std::vector<uint32_t>> overlaps_of_;  // indices into overlaps_ of each polygon
  std::vector<Place> places_;  // places of the overlaps of polygons that look opposite ways, in the order of overlaps_
  std::vector<uint32_t> place_of_;  // index into places_ of each overlap
  std::vector<uint32_t> alike_;     // overlaps of different faces that look the same way, with nothing between the two
  std::mt19937_64 random_{1};
  uint64_t in_doubt_ = 0, contradictions_ = 0;
  std::string first_contradiction_;
  double uniform() { return double(random_() >> 11) * 0x1p-53; }
};

}  // namespace viewpeel

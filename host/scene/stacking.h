// A Stacking puts the coincident polygons of a scene in their order (coincident.h): it finds overlaps
// (find_overlaps.cpp), orders opposite ones by rays (order_overlaps.cpp), and ranks polygons (coincident.cpp).
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

// An Overlap is two polygons of nearly one plane and the part that they have in common.
struct Overlap {
  uint32_t a, b;
  bool is_opposite;                 // they look opposite ways
  double gap;                       // mean height of b over a's front
  double low, high;                 // least and greatest such height
  std::vector<glm::dvec3> corners;  // of the common part, in a's plane
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
  glm::dvec3 point, normal;  // of the front of overlap's a
  std::vector<uint32_t> polygons;
};

inline double widthOf(const std::vector<glm::dvec3>& corners, double area) { return 2 * area / perimeterOf(corners); }

class Stacking {
 public:
  Stacking(Scene& scene, const SceneOptions& options, double rounding);
  void order();
  // Once they are ordered.
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
  const double rounding_;            // gaps up to this are rounding of coordinates
  std::vector<glm::dvec3> normals_;  // of fronts
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

}  // namespace viewpeel

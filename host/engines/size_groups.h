// Size groups give polygons of very different sizes the lattice spacings that they need.
#pragma once
#include <memory>
#include <vector>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>

namespace viewpeel {

constexpr double kEnough = 1 - 1e-9;  // this share of the needed resolution is enough, because the latter is rounded
constexpr int kGroupStep = 4;         // ratio of the resolutions of consecutive groups
constexpr size_t kMostWindows = 32;   // each window takes memory, compiles kernels and projects the whole scene

// A SizeGroup has polygons that are counted at one resolution, in a window around them. The group of the whole scene
// comes first, finer groups later. A facing pair of polygons of two groups is counted once, by the later group. So all
// of the smaller polygon is in the window, at the spacing that it needs.
struct SizeGroup {
  int resolution = 0;
  Window window;
  std::vector<uint32_t> polygons;  // indices in Scene::polygons
};

// Groups the polygons by the resolutions that they need, in steps of 4, and the polygons of one resolution by place.
//   In: needed[k]: the least resolution for Scene::polygons[k]; base: the resolution of the first group, which has all
//     polygons that need no more; finest: the largest resolution allowed
//   Out: groups whose resolutions are base x 4^m, at most `finest`. The window of the first group is the whole scene,
//     even where it has no polygons. A polygon too large for a window at the resolution that it needs gets the largest
//     resolution that its window allows. Where there would be more than 32 windows, `finest` is lowered until there are
//     not.
//   Cost: O(n log n) for n polygons.
std::vector<SizeGroup> groupBySize(const Scene& scene, const std::vector<double>& needed, int base,
                                   int finest = kMaxWindowResolution);

// Returns one group of all polygons.    Cost: O(n).
std::vector<SizeGroup> groupAsOne(const Scene& scene, int resolution);

// Returns how many windows these polygons get at a resolution. No polygon may be too large for a window of its own.
//   Cost: O(n log n).
size_t countWindows(const Scene& scene, std::vector<uint32_t> polygons, int resolution);

// Returns a window around polygons: the ball around their common box, a little larger because corners are rounded. It
// returns the unit ball, which holds the whole scene, where the window would not be smaller.
Window windowAround(const Scene& scene, const std::vector<uint32_t>& polygons);

// Returns half the diagonal of a polygon's box, in unit-ball units. A window can hold the polygon at a resolution where
// this radius x resolution <= kMostWindowPoints.
double boxRadius(const Scene& scene, uint32_t polygon_index);

// Makes an engine that counts every group at its own resolution. Its unitArea() belongs to the finest group.
//   In: groups: as groupBySize returns them; ids: without roles, that is, every polygon emits and receives
//   Throws: what make_engine throws; Error bad_usage where the ids have roles.
//   Cost: for every group and direction, the whole scene is projected and the group's window is counted.
std::unique_ptr<Engine> makeGroupedEngine(const EngineFactory& make_engine, const Scene& scene, const Ids& ids,
                                          const LatticeOptions& options, const std::vector<SizeGroup>& groups);

}  // namespace viewpeel

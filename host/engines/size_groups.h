// Size groups serve polygons of very different sizes: each is looked at with the lattice spacing that it needs.
#pragma once
#include <memory>
#include <vector>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>

namespace viewpeel {

constexpr double kEnough = 1 - 1e-9;  // of the resolution needed, which is rounded
constexpr int kGroupStep = 4;         // between the resolutions of groups
constexpr size_t kMostWindows = 32;   // each takes memory, compiles its kernels and projects the whole scene

// A SizeGroup has the polygons that are peeled at one resolution, in a window around them. Groups are in order, the
// whole scene's first. The later of two polygons' groups counts their facing pair, once. So all of the smaller polygon
// is in the window, at the spacing that it needs.
struct SizeGroup {
  int resolution = 0;
  Window window;
  std::vector<uint32_t> polygons;  // Scene::polygons
};

// Groups the polygons by the resolutions that they need, in steps of 4, and the polygons of a resolution by place.
//   In: needed[k]: the least resolution for Scene::polygons[k]; base: the first group's, which takes all polygons that
//     need no more; finest: the most any may get
//   Out: groups whose resolutions are base x 4^m, at most `finest`. The first holds the whole scene, even where it has
//     no polygons. A polygon too large for a window at the resolution it needs gets the finest that its window allows.
//     Where there would be more than 32 windows, all polygons get at most the finest resolution with fewer.
//   Cost: O(n log n).
std::vector<SizeGroup> groupBySize(const Scene& scene, const std::vector<double>& needed, int base,
                                   int finest = kMaxWindowResolution);

// Puts all polygons at one resolution.    Cost: O(n).
std::vector<SizeGroup> groupAsOne(const Scene& scene, int resolution);

// Returns how many windows polygons get at a resolution; no polygon may be too large for one.    Cost: O(n log n).
size_t countWindows(const Scene& scene, std::vector<uint32_t> polygons, int resolution);

// A ball around their box, a little larger, for corners are rounded; the whole scene's where that is no larger.
Window windowAround(const Scene& scene, const std::vector<uint32_t>& polygons);

// Returns half the diagonal of its box, unit-ball units: radius x resolution <= kMostWindowPoints where a window of
// that resolution can hold it.
double boxRadius(const Scene& scene, uint32_t polygon_index);

// Makes an engine that peels every group at its own resolution. unitArea() is the finest group's.
//   In: groups as from groupBySize; ids without roles, as of an empty question
//   Throws: as makeComputeEngine; Error bad_usage where the ids have roles.
//   Cost: for every group and direction the scene is projected and the group's window peeled.
std::unique_ptr<Engine> makeGroupedEngine(const EngineFactory& make_engine, const Scene& scene, const Ids& ids,
                                          const LatticeOptions& options, const std::vector<SizeGroup>& groups);

}  // namespace viewpeel

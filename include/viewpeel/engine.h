// An engine counts facing pairs along directions, whichever way it finds them.
//
// On a line through several polygons two of them face each other where the front of the nearer looks ahead and the
// front of the farther looks back. They count as a facing pair where they are consecutive, and as blocked where others
// lie between them. Facing and blocked lines together are all lines on which two fronts look at each other. Along one
// direction they are the common part of two projections, whatever else the scene holds.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <viewpeel/ids.h>

namespace viewpeel {

// A Direction is one projection: along u onto the plane of x_axis and y_axis, which carries the lattice.
struct Direction {
  glm::dvec3 x_axis, y_axis, u;  // orthonormal, right-handed
  glm::dvec2 offset;             // of the lattice, in spacings, each in [0, 1)
  uint32_t weight = 1;           // of all counts along it
};

// A PairCount holds an engine's counts of a pair of ids, summed over directions; area = count x Engine::unitArea().
struct PairCount {
  uint32_t i, j;   // i <= j
  uint64_t count;  // of lines on which they are consecutive and face each other
  // An engine that counts blocked pairs has here the lines on which they face each other with others between them.
  uint64_t blocked = 0;

  void add(const PairCount& other) {
    count += other.count;
    blocked += other.blocked;
  }
};

// PairCounts have every pair that lines hit, sorted by (i, j), at most once, and none with both counts 0.
using PairCounts = std::vector<PairCount>;

// Work counts the steps of an engine.
struct Work {
  uint64_t directions = 0;
  uint64_t lattice_points = 0;  // of the tiles, or with scanlines their rows, that hold anything
  uint64_t tiles = 0;           // in all windows
  uint64_t active_tiles = 0;    // of the compute engine with scanlines, parts of tiles
  uint64_t list_entries = 0;    // polygons in tiles
  uint64_t rows = 0;            // of tiles, that hold a span
  uint64_t spans = 0;           // polygons in rows
  uint64_t samples = 0;         // lattice points or intervals peeled
  uint64_t rounds = 0;          // over the samples of one subgroup
  uint64_t tests = 0;           // of a sample against a span
  uint64_t fragments = 0;       // samples that a span covers: layers
  uint64_t gaps = 0;            // between consecutive layers, counted ones: facing pairs, environment and leak
  uint64_t repeats = 0;         // batches done again because something had to grow
  uint64_t resumed = 0;         // dispatches that went on with unfinished tiles
  uint64_t memory_bytes = 0;    // on the device
  std::vector<std::pair<std::string, double>> pass_seconds;
};

struct LatticeOptions;  // only engines that count lattice points use them

// An engine is of one of these kinds.
enum class EngineKind {
  automatic,  // compute on a GPU or on the request's device, else host
  compute,    // depth peeling in compute shaders
  host,       // the same counts on the processor's threads
  graphics,   // depth peeling by the raster pipeline
  exact,      // exact areas, by an engine that the caller brings
};

// The estimator needs no more of an engine, whichever way it finds the facing pairs. Calls come one at a time, from any
// thread.
class Engine {
 public:
  virtual ~Engine() = default;

  // Sums the measures of all facing pairs, environment and leak over the directions, and of blocked pairs where the
  // engine was made to. Sums are integers, so the result is independent of how the engine groups its work.
  //   In: directions, any number    Out: counts; area in P(u) = count x unitArea()
  //   Throws: Error device, Error limit.
  virtual PairCounts count(std::span<const Direction> directions) = 0;

  // Counts every block_directions of the directions, in order, as count() counts each block.
  //   In: a multiple of block_directions    Throws: as count().
  virtual std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) {
    std::vector<PairCounts> blocks;
    for (size_t first = 0; first < directions.size(); first += block_directions)
      blocks.push_back(count(directions.subspan(first, block_directions)));
    return blocks;
  }

  // Returns the area of one count, unit-ball units squared.
  virtual double unitArea() const = 0;

  // Returns the work up to now where the engine was made to measure it; else nullptr.
  virtual const Work* work() const { return nullptr; }
  // Returns a few lines about how the engine has divided its work and how much memory it takes.
  virtual std::string describePlan() const { return {}; }
};

// An EngineFactory makes an engine that counts by these ids. Scene and ids outlive it.
//   In: ids: as from makeIds, with roles where a question restricts them
//   Throws: Error bad_usage, device, memory or limit where there can be none.
using EngineFactory =
    std::function<std::unique_ptr<Engine>(const Scene& scene, const Ids& ids, const LatticeOptions& options)>;

}  // namespace viewpeel

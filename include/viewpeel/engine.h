// An Engine counts facing pairs of polygons along directions. Every kind of engine has this interface.
//
// Take a line through several polygons. Two of them face each other if the front of the nearer one looks along the line
// and the front of the farther one looks back. If no polygon lies between the two, they are a facing pair, else a
// blocked pair. Facing and blocked lines together are all lines on which two fronts look at each other. Along one
// direction these lines are the overlap of the two projections, whatever else the scene holds.
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

// A Direction describes one parallel projection: along u, onto the plane of x_axis and y_axis, which carries the
// lattice.
struct Direction {
  glm::dvec3 x_axis, y_axis, u;  // orthonormal, right-handed
  glm::dvec2 offset;             // offset of the lattice, in spacings, each coordinate in [0, 1)
  uint32_t weight = 1;           // every count along this direction is multiplied by it
};

// A PairCount holds an engine's counts of a pair of ids, summed over directions; area = count x Engine::unitArea().
struct PairCount {
  uint32_t i, j;   // i <= j
  uint64_t count;  // lines on which they are a facing pair
  // Lines on which they are a blocked pair; 0 where the engine does not count blocked pairs.
  uint64_t blocked = 0;

  void add(const PairCount& other) {
    count += other.count;
    blocked += other.blocked;
  }
};

// PairCounts lists the pairs that lines hit, each once, sorted by (i, j). No entry has two counts of 0.
using PairCounts = std::vector<PairCount>;

// Work says how much an engine did.
struct Work {
  uint64_t directions = 0;
  uint64_t lattice_points = 0;  // lattice points in tiles that hold a polygon; with scanlines in rows that hold one
  uint64_t tiles = 0;           // tiles of all windows
  uint64_t active_tiles = 0;    // tiles that hold a polygon; with scanlines the compute engine counts parts of tiles
  uint64_t list_entries = 0;    // polygons in tiles, summed over tiles
  uint64_t rows = 0;            // lattice rows of tiles that a polygon covers in part
  uint64_t spans = 0;           // polygons in rows, summed over rows
  uint64_t samples = 0;         // lattice points or intervals that were peeled
  uint64_t rounds = 0;          // passes of a subgroup over its tile's polygons, which find some layers of its samples
  uint64_t tests = 0;           // tests of a sample against a span
  uint64_t fragments = 0;       // samples that a span covers: layers
  uint64_t gaps = 0;            // gaps between consecutive layers that were counted: facing pairs, environment and leak
  uint64_t repeats = 0;         // batches that were repeated because a buffer had to grow
  uint64_t resumed = 0;         // dispatches that continued unfinished tiles
  uint64_t memory_bytes = 0;    // memory of the device
  std::vector<std::pair<std::string, double>> pass_seconds;
};

struct LatticeOptions;  // options of engines that count lattice points or scanlines

// EngineKind lists the kinds of engine.
enum class EngineKind {
  automatic,  // compute on a GPU or on the request's device, else host
  compute,    // depth peeling in compute shaders
  host,       // the same counts on the processor's threads
  graphics,   // depth peeling by the raster pipeline
  exact,      // exact areas, by an engine that the caller brings
};

// The estimator uses an engine through this interface. It makes one call at a time, from any thread.
class Engine {
 public:
  virtual ~Engine() = default;

  // Counts all facing pairs, environment and leak along the directions, and blocked pairs where the engine was made to
  // count them. Counts are integers, so the result does not depend on how the engine groups its work.
  //   In: directions: any number    Out: the counts, summed over directions. count x unitArea() is an area in the plane
  //     of projection.
  //   Throws: Error device, Error limit.
  virtual PairCounts count(std::span<const Direction> directions) = 0;

  // Counts blocks of directions: the first block_directions of them, the next, and so on. Each block has the result of
  // count().
  //   In: directions: a multiple of block_directions    Throws: as count().
  virtual std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) {
    std::vector<PairCounts> blocks;
    for (size_t first = 0; first < directions.size(); first += block_directions)
      blocks.push_back(count(directions.subspan(first, block_directions)));
    return blocks;
  }

  // Returns the area that one count stands for, in unit-ball units squared.
  virtual double unitArea() const = 0;

  // Returns the work done so far, if the engine was made to measure it; else nullptr.
  virtual const Work* work() const { return nullptr; }
  // Returns a few lines about how the engine has divided its work and how much memory it takes.
  virtual std::string describePlan() const { return {}; }
};

// An EngineFactory makes an engine that counts by these ids. The scene and the ids must outlive the engine.
//   In: ids: as makeIds() returns them, perhaps restricted to a question
//   Throws: Error bad_usage, device, memory or limit where no engine can be made.
using EngineFactory =
    std::function<std::unique_ptr<Engine>(const Scene& scene, const Ids& ids, const LatticeOptions& options)>;

}  // namespace viewpeel

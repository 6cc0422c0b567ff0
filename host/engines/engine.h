// What the estimator needs of an engine, whichever way it finds the facing pairs.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "directions/direction.h"
#include "engines/work.h"
#include "sums/pair_count.h"

namespace viewpeel {

class Engine {
 public:
  virtual ~Engine() = default;

  // Sums the measures of all facing pairs, of blocked pairs where the engine was made to, environment and leak over the directions, in
  // integers: the result is independent of how the engine groups its work.
  //   In: directions, any number    Out: counts; area in P(u) = count x unitArea()
  //   Throws: Error device, Error limit.
  virtual PairCounts count(std::span<const Direction> directions) = 0;

  // The same of every block_directions of them, in order: what count() says of each.
  //   In: a multiple of block_directions    Throws: as count().
  virtual std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) {
    std::vector<PairCounts> blocks;
    for (size_t first = 0; first < directions.size(); first += block_directions) blocks.push_back(count(directions.subspan(first, block_directions)));
    return blocks;
  }

  // Area of one count, unit-ball units squared.
  virtual double unitArea() const = 0;

  // Work done so far, where the engine was asked to measure it; else nullptr.
  virtual const Work* work() const { return nullptr; }
  // How the engine has divided its work and what memory that takes, a few lines.
  virtual std::string describePlan() const { return {}; }
};

}  // namespace viewpeel

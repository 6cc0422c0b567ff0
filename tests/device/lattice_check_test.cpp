// `viewpeel check` accepts correct lattices, and finds planted faults.
#include "reference/exact/lattice_check.h"

#include <map>
#include <memory>

#include <gtest/gtest.h>

#include "tests/support/cpu_twin.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

namespace viewpeel::reference {
namespace {

namespace ts = test_scenes;

CheckOptions smallCheck(uint64_t seed = 1) {
  CheckOptions options;
  options.resolutions = {24, 48};
  options.directions = 4;
  options.lattices = 48;
  options.seed = seed;
  return options;
}

// Returns a function that counts with the compute engine, with one engine for each resolution.
CountLattice countOnDevice(const Scene& scene, const Ids& ids, Sampling sampling, bool blocked = false) {
  const auto engines = std::make_shared<std::map<int, std::unique_ptr<Engine>>>();
  return [&scene, &ids, sampling, blocked, engines](const Direction& direction, int resolution) {
    std::unique_ptr<Engine>& engine = (*engines)[resolution];
    if (!engine)
      engine = makeComputeEngine(
          testDevice(), scene, ids,
          {.resolution = resolution, .sampling = sampling, .count_blocked = blocked, .batch_directions = 1});
    return engine->count({&direction, 1});
  };
}

struct CheckedScene {
  Scene scene = buildScene(ts::roomWithTouchingBoxes());
  Ids ids = makeIds(scene, By::polygon, false);
  CheckReport check(const CountLattice& count, const CheckOptions& options = smallCheck()) const {
    return checkLattice(scene, ids, count, options);
  }
  CheckReport checkTwin(Fault fault) const {
    return check(
        [&](const Direction& d, int resolution) { return countPairsOnCpu(scene, ids, {d}, resolution, false, fault); });
  }
};

TEST(LatticeCheck, ScanlinesBehaveAsClaimed) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const Ids ids = makeIds(scene, By::polygon, false);
  CheckOptions options = smallCheck();
  options.variance = kScanlineVariance;
  options.counts_per_point = 1024;
  const CheckReport report = checkLattice(scene, ids, countOnDevice(scene, ids, Sampling::scanline), options);
  for (const CheckRow& row : report.rows)
    EXPECT_TRUE(row.unbiased && row.spread_as_predicted)
        << row.resolution << ": " << row.worst_pair << " deviates by " << row.largest_deviation << ", allowed "
        << row.allowed_deviation << "; spread " << row.spread_ratio;
  EXPECT_GT(report.rows[1].spread_regions, 10u);
  // Negative control: lattice points have nearly four times the variance of scanlines, and do not fit their prediction.
  options.counts_per_point = 1;
  EXPECT_FALSE(checkLattice(scene, ids, countOnDevice(scene, ids, Sampling::lattice), options).passes());
}

TEST(LatticeCheck, ComputeEngineBehavesAsClaimed) {
  for (const InputScene& input : {ts::roomWithTouchingBoxes(), ts::cubeInCube(0.4)}) {
    const Scene scene = buildScene(input);
    const Ids ids = makeIds(scene, By::polygon, false);
    CheckOptions options = smallCheck();
    options.lattices = 24;
    const CheckReport report = checkLattice(scene, ids, countOnDevice(scene, ids, Sampling::lattice), options);
    for (const CheckRow& row : report.rows)
      EXPECT_TRUE(row.unbiased && row.spread_as_predicted)
          << input.file << " at " << row.resolution << ": " << row.worst_pair << " deviates by "
          << row.largest_deviation << ", allowed " << row.allowed_deviation << "; spread " << row.spread_ratio;
    EXPECT_GT(report.rows[0].regions_tested, 20u);
  }
}

// Counts of blocked pairs have no bias and the stated variance. A blocked pair that is not counted is found.
TEST(LatticeCheck, BlockedPairsBehaveAsClaimed) {
  const CheckedScene checked;
  CheckOptions options = smallCheck();
  const uint64_t regions_of_facing_pairs =
      checked.check(countOnDevice(checked.scene, checked.ids, Sampling::lattice), options).rows[1].regions_tested;
  options.blocked = true;
  for (Sampling sampling : {Sampling::lattice, Sampling::scanline}) {
    const bool points = sampling == Sampling::lattice;
    options.variance = points ? kLatticeVariance : kScanlineVariance;
    options.counts_per_point = points ? 1 : 1024;
    const CheckReport report = checked.check(countOnDevice(checked.scene, checked.ids, sampling, true), options);
    for (const CheckRow& row : report.rows)
      EXPECT_TRUE(row.unbiased && row.spread_as_predicted)
          << row.resolution << ": " << row.worst_pair << " deviates by " << row.largest_deviation << ", allowed "
          << row.allowed_deviation << "; spread " << row.spread_ratio;
    EXPECT_GT(report.rows[1].regions_tested, regions_of_facing_pairs + 20);
    EXPECT_FALSE(checked.check(countOnDevice(checked.scene, checked.ids, sampling, false), options).passes());
  }
}

// A correct lattice passes for ten seeds. The false-alarm rate of each is 1e-4.
TEST(LatticeCheck, RightLatticePassesWhateverTheSeed) {
  const CheckedScene checked;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    CheckOptions options = smallCheck(seed);
    options.resolutions = {24};
    const auto count = [&](const Direction& d, int resolution) {
      return countPairsOnCpu(checked.scene, checked.ids, {d}, resolution);
    };
    const CheckReport report = checked.check(count, options);
    EXPECT_TRUE(report.passes()) << "seed " << seed << ": " << report.rows[0].worst_pair << " "
                                 << report.rows[0].largest_deviation << " spread " << report.rows[0].spread_ratio;
  }
}

TEST(LatticeCheck, CatchesALatticeWithoutRandomness) {
  const CheckedScene checked;
  Direction fixed;
  const auto count = [&](Direction d, int resolution) {
    if (d.u != fixed.u) fixed = d;
    return countPairsOnCpu(checked.scene, checked.ids, {fixed}, resolution);
  };
  EXPECT_FALSE(checked.check(count).passes());
}

// A random rotation alone is not enough: with a lattice point always at the centre the mean has a bias.
TEST(LatticeCheck, CatchesALatticeWithoutRandomOffset) {
  const CheckedScene checked;
  const auto count = [&](Direction d, int resolution) {
    d.offset = {0, 0};
    return countPairsOnCpu(checked.scene, checked.ids, {d}, resolution);
  };
  CheckOptions options = smallCheck();
  options.resolutions = {8};
  options.lattices = 256;
  options.directions = 12;
  EXPECT_FALSE(checked.check(count, options).passes());
}

TEST(LatticeCheck, CatchesALostLastLayer) {
  EXPECT_FALSE(CheckedScene().checkTwin(Fault::last_layer_dropped).passes());
}

TEST(LatticeCheck, CatchesSwappedDepths) { EXPECT_FALSE(CheckedScene().checkTwin(Fault::two_depths_swapped).passes()); }

}  // namespace
}  // namespace viewpeel::reference

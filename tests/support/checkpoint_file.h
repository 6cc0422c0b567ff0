// CheckpointFile is a test with a separate folder, sums of a room, and an engine that needs no device.
#pragma once
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "directions/sampler.h"
#include "io/checkpoint.h"
#include "scenes/named_scenes.h"

namespace viewpeel {

namespace fs = std::filesystem;
namespace ts = test_scenes;

inline const Settings kSettings = {{"version", "1"}, {"--seed", "7"}, {"--from", ""}};

inline Scene roomScene() { return buildScene(ts::roomWithTouchingBoxes()); }

inline std::string readFile(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

// Returns random counts for a third of all pairs, different for every replicate. They are so large that sums of squares
// exceed 64 bits.
inline PairCounts randomCounts(const Ids& ids, uint64_t replicate) {
  std::mt19937_64 random(replicate);
  PairCounts counts;
  for (uint32_t i = 0; i < ids.count(); ++i)
    for (uint32_t j = i; j < ids.count() + 2; ++j)
      if (random() % 3 == 0)
        counts.push_back({i,
                          j < ids.count()    ? j
                          : j == ids.count() ? kEnvironment
                                             : kLeak,
                          1 + random() % (1ull << 50)});
  return counts;
}

// RandomEngine returns randomCounts(). It recognises the replicate by its first direction.
class RandomEngine : public Engine {
 public:
  RandomEngine(const Ids& ids, uint64_t seed) : ids_(ids) {
    for (uint64_t k = 0; k < 100; ++k)
      first_directions_.push_back(sampleDirections(Sampler::fibonacci, 10, seed, k).front().u);
  }
  PairCounts count(std::span<const Direction> directions) override {
    if (on_count) on_count();
    const auto at = std::find(first_directions_.begin(), first_directions_.end(), directions.front().u);
    return randomCounts(ids_, static_cast<uint64_t>(at - first_directions_.begin()));
  }
  double unitArea() const override { return 1e-20; }
  std::function<void()> on_count;

 private:
  const Ids& ids_;
  std::vector<glm::dvec3> first_directions_;
};

class CheckpointFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("viewpeel_checkpoint_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path file(const std::string& name) const { return folder_ / name; }

  RunSums sumsOf(const std::vector<uint64_t>& replicates) const {
    RunSums sums = makeRunSums(scene_, ids_);
    sums.measure_area = 0.1;
    for (uint64_t replicate : replicates) sums.add(replicate, randomCounts(ids_, replicate), 10);
    return sums;
  }
  // Returns the bytes of the checkpoint file that the sums make.
  std::string bytesOf(const RunSums& sums) const {
    writeCheckpoint(kSettings, sums, file("bytes.h5"));
    return readFile(file("bytes.h5"));
  }

  fs::path folder_;
  const Scene scene_ = roomScene();
  const Ids ids_ = makeIds(scene_, By::polygon, false);
};

}  // namespace viewpeel

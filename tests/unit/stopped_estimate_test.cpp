// These tests stop estimates and go on with them. Their engine needs no device.
#include <cmath>
#include <numeric>
#include <optional>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "estimator/estimate.h"
#include "tests/support/checkpoint_file.h"

namespace viewpeel {
namespace {

// StoppedEstimate keeps the sums of the last call of on_sums, from which a stopped run is resumed.
class StoppedEstimate : public CheckpointFile {
 protected:
  EstimateOptions options_{.directions = 10, .replicates = 7, .seed = 3};
  RandomEngine engine_{ids_, 3};
  std::optional<RunSums> kept_;

  void SetUp() override {
    CheckpointFile::SetUp();
    options_.on_sums = [this](const RunSums& sums, bool last) {
      if (last) kept_ = sums;
    };
  }
  Estimate estimate() { return estimateFormFactors(engine_, scene_, ids_, options_); }
  std::string resultOf(const RunSums& sums) const {
    const Estimate e = makeEstimate(sums, 0.01);
    std::ostringstream text;
    text.precision(17);
    for (const auto& entry : e.form_factors.entries())
      text << entry.i << ' ' << entry.j << ' ' << entry.exchange_area.value << ' ' << entry.exchange_area.standard_error
           << '\n';
    text << e.largest_standard_error << ' ' << e.largest_relative_error << ' ' << e.directions;
    return text.str();
  }
};

TEST_F(StoppedEstimate, GoesOnToTheSameBits) {
  estimate();
  const RunSums whole = *kept_;
  EXPECT_EQ(whole.replicateCount(), 7u);
  for (uint64_t stop : {1, 2, 6, 7}) {
    uint64_t counted = 0;
    engine_.on_count = [&] {
      if (counted++ == stop) throw Interrupted{};
    };
    options_.resumed = nullptr;
    const Estimate stopped = estimate();
    EXPECT_EQ(stopped.interrupted, stop < 7);
    EXPECT_EQ(stopped.replicates, stop);
    writeCheckpoint(kSettings, *kept_, file("stopped.h5"));
    const RunSums resumed = readCheckpoint(file("stopped.h5")).sums;
    engine_.on_count = nullptr;
    options_.resumed = &resumed;
    EXPECT_FALSE(estimate().interrupted);
    EXPECT_EQ(bytesOf(*kept_), bytesOf(whole)) << "stopped after " << stop;
    EXPECT_EQ(resultOf(*kept_), resultOf(whole)) << "stopped after " << stop;
  }
}

// A resumed run ends after the same replicate as a run without a stop. It knows the errors of the earlier replicates
// before it counts new ones.
TEST_F(StoppedEstimate, StopsWhereOneRunWouldHave) {
  options_.replicates = 2;
  std::vector<double> errors;
  options_.tolerance = 1e-300;
  engine_.on_count = [n = 0]() mutable {
    if (n++ == 20) throw Interrupted{};
  };
  options_.on_replicate = [&](const EstimateProgress& progress) { errors.push_back(progress.largest_standard_error); };
  estimate();
  engine_.on_count = nullptr;
  options_.tolerance = errors[11];
  const uint64_t expected = estimate().replicates;
  EXPECT_LE(expected, 12u);
  EXPECT_GT(expected, 3u);
  for (uint64_t done = 2; done <= expected; ++done) {
    std::vector<uint64_t> replicates(done);
    std::iota(replicates.begin(), replicates.end(), 0);
    RunSums resumed = sumsOf(replicates);
    resumed.measure_area = kept_->measure_area;
    options_.resumed = &resumed;
    EXPECT_EQ(estimate().replicates, expected) << "after " << done;
  }
}

TEST_F(StoppedEstimate, ErrorsLoseNoReplicateEither) {
  engine_.on_count = [n = 0]() mutable {
    if (n++ == 3) throw Error(ErrorCode::device, "lost");
  };
  EXPECT_THROW(estimate(), Error);
  ASSERT_TRUE(kept_);
  EXPECT_EQ(kept_->replicates, (std::vector<ReplicateRange>{{0, 3}}));
  EXPECT_TRUE(kept_->isWhole());
}

TEST_F(StoppedEstimate, RangesOfReplicatesEqualOneRun) {
  estimate();
  const std::string whole = bytesOf(*kept_);
  options_.replicates = 3;
  estimate();
  RunSums sums = *kept_;
  options_.first_replicate = 3;
  options_.replicates = 4;
  estimate();
  EXPECT_EQ(kept_->replicates, (std::vector<ReplicateRange>{{3, 7}}));
  sums.add(*kept_);
  EXPECT_EQ(bytesOf(sums), whole);
}

// Only the time of this run counts towards the limit. Neither the limit nor the expected time of a replicate depends on
// earlier runs.
TEST_F(StoppedEstimate, TimeIsThatOfTheRunAtHand) {
  std::vector<uint64_t> replicates(90);
  std::iota(replicates.begin(), replicates.end(), 0);
  const RunSums resumed = sumsOf(replicates);
  options_.resumed = &resumed;
  options_.seconds = 0.05;
  engine_.on_count = [] { std::this_thread::sleep_for(std::chrono::milliseconds(60)); };
  EXPECT_EQ(estimate().replicates, 91u);  // its first replicate exceeds the limit
}

}  // namespace
}  // namespace viewpeel

#include "directions/replicates.h"
#include "directions/sampler.h"

#include <cmath>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

namespace viewpeel {
namespace {

constexpr Sampler kSamplers[] = {Sampler::iid, Sampler::fibonacci, Sampler::jittered, Sampler::sobol};

TEST(Directions, FramesAreOrthonormalAndRightHanded) {
  for (Sampler sampler : kSamplers)
    for (const Direction& d : sampleDirections(sampler, 1000, 3, 1)) {
      EXPECT_NEAR(glm::length(d.u), 1, 1e-15);
      EXPECT_NEAR(glm::length(d.x_axis), 1, 1e-15);
      EXPECT_NEAR(glm::dot(d.u, d.x_axis), 0, 1e-15);
      EXPECT_LT(glm::length(glm::cross(d.x_axis, d.y_axis) - d.u), 2e-15);
      EXPECT_TRUE(d.offset.x >= 0 && d.offset.x < 1 && d.offset.y >= 0 && d.offset.y < 1);
    }
}

// Directions lie along the axes, where spherical coordinates have poles, and beside them, where the choice of the axes
// changes.
TEST(Directions, FramesAtPolesAreOrthonormal) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0})
      for (const double beside : {0.0, 1e-300, 1e-16, 1e-8, 0.48, 0.49}) {
        glm::dvec3 u(0);
        u[axis] = sign;
        u[(axis + 1) % 3] = beside;
        for (const Direction& d : sampleLattices(u, 20, 3)) {
          EXPECT_NEAR(glm::length(d.u), 1, 1e-15);
          EXPECT_NEAR(glm::length(d.x_axis), 1, 1e-15);
          EXPECT_NEAR(glm::dot(d.u, d.x_axis), 0, 1e-15);
          EXPECT_LT(glm::length(glm::cross(d.x_axis, d.y_axis) - d.u), 2e-15);
        }
      }
}

TEST(Directions, AreAFunctionOfSeedAndReplicate) {
  const auto a = sampleDirections(Sampler::fibonacci, 10, 3, 1), b = sampleDirections(Sampler::fibonacci, 10, 3, 1);
  const auto c = sampleDirections(Sampler::fibonacci, 10, 3, 2), d = sampleDirections(Sampler::fibonacci, 10, 4, 1);
  EXPECT_EQ(a[5].u, b[5].u);
  EXPECT_NE(a[5].u, c[5].u);
  EXPECT_NE(a[5].u, d[5].u);
}

// MeanTest compares the mean of several functions over independent samples with the expectation, in standard errors.
// Tests allow 5 of them. For 2 x (9 + 9 + 4) functions of four samplers the false-alarm rate is 1e-4; seeds are fixed.
struct MeanTest {
  std::vector<double> sum, sum_of_squares;
  uint64_t samples = 0;
  void add(const std::vector<double>& values) {
    sum.resize(values.size());
    sum_of_squares.resize(values.size());
    for (size_t k = 0; k < values.size(); ++k) {
      sum[k] += values[k];
      sum_of_squares[k] += values[k] * values[k];
    }
    ++samples;
  }
  double deviation(size_t k, double expectation) const {  // in standard errors
    const double n = double(samples), mean = sum[k] / n;
    return std::abs(mean - expectation) / std::sqrt((sum_of_squares[k] / n - mean * mean) / n);
  }
};

// Returns monomials of a unit vector to degree 2, and one of degree 4. kMomentMeans are their means over the sphere.
std::vector<double> moments(const glm::dvec3& v) {
  return {v.x, v.y, v.z, v.x * v.y, v.y * v.z, v.z * v.x, v.x * v.x, v.y * v.y, v.x * v.x * v.z * v.z};
}
const std::vector<double> kMomentMeans = {0, 0, 0, 0, 0, 0, 1 / 3.0, 1 / 3.0, 1 / 15.0};

// Each direction of a set is uniform on the sphere, also the first and the last one. The axes of its lattice are
// uniform too; without random rotation they would lie on circles.
TEST(Directions, EveryDirectionIsUniform) {
  for (Sampler sampler : kSamplers)
    for (int which : {0, 6}) {
      MeanTest u, x, offset;
      for (uint64_t replicate = 0; replicate < 20000; ++replicate) {
        const Direction d = sampleDirections(sampler, 7, 12345, replicate)[which];
        u.add(moments(d.u));
        x.add(moments(d.x_axis));
        offset.add({d.offset.x, d.offset.y, d.offset.x * d.offset.x, d.offset.x * d.offset.y});
      }
      for (size_t k = 0; k < kMomentMeans.size(); ++k) {
        EXPECT_LT(u.deviation(k, kMomentMeans[k]), 5) << "moment " << k;
        EXPECT_LT(x.deviation(k, kMomentMeans[k]), 5) << "moment " << k;
      }
      for (const auto& [k, mean] : {std::pair(0, 0.5), std::pair(1, 0.5), std::pair(2, 1 / 3.0), std::pair(3, 0.25)})
        EXPECT_LT(offset.deviation(k, mean), 5) << "offset moment " << k;
    }
}

TEST(Directions, UniformityTestSeesABias) {
  MeanTest u;
  for (uint64_t replicate = 0; replicate < 20000; ++replicate) {
    glm::dvec3 v = sampleDirections(Sampler::iid, 1, 12345, replicate)[0].u;
    u.add(moments(glm::normalize(v + glm::dvec3(0, 0, 0.05))));
  }
  EXPECT_GT(u.deviation(2, kMomentMeans[2]), 5);
}

// The mean of a smooth function over one set is far nearer to its integral than over independent directions. One
// direction in each of n cells has an error of order 1 / n, against 1 / sqrt(n). Other sets have less.
TEST(Directions, SetsIntegrateSmoothFunctions) {
  const uint32_t count = 1000;
  const double independent =
      std::sqrt((1 / 3.0 - 0.25) / count);  // standard deviation of the mean of |z| over iid directions
  for (const auto& [sampler, gain] :
       {std::pair(Sampler::fibonacci, 20.0), std::pair(Sampler::jittered, 10.0), std::pair(Sampler::sobol, 10.0)}) {
    double squares = 0;
    for (uint64_t replicate = 0; replicate < 50; ++replicate) {
      double mean = 0;
      for (const Direction& d : sampleDirections(sampler, count, 8, replicate)) mean += std::abs(d.u.z) / count;
      squares += (mean - 0.5) * (mean - 0.5) / 50;
    }
    EXPECT_LT(std::sqrt(squares), independent / gain) << "sampler " << int(sampler);
  }
}

// Sets of any size have the requested number of directions. In the mean over replicates, their mean vector and second
// moments equal the sphere's.
TEST(Directions, SetsOfAnySizeAreUnbiased) {
  for (Sampler sampler : {Sampler::jittered, Sampler::sobol})
    for (uint32_t count : {1u, 2u, 3u, 5u, 17u, 100u}) {
      MeanTest means;
      for (uint64_t replicate = 0; replicate < 4000; ++replicate) {
        const auto directions = sampleDirections(sampler, count, 5, replicate);
        ASSERT_EQ(directions.size(), count);
        std::vector<double> sums(kMomentMeans.size(), 0.0);
        for (const Direction& d : directions) {
          const std::vector<double> values = moments(d.u);
          for (size_t k = 0; k < values.size(); ++k) sums[k] += values[k] / count;
        }
        means.add(sums);
      }
      for (size_t k = 0; k < kMomentMeans.size(); ++k)
        EXPECT_LT(means.deviation(k, kMomentMeans[k]), 5)
            << "sampler " << int(sampler) << ", " << count << " directions, moment " << k;
    }
}

// Pilots are independent of runs and of each other, since no two kinds share a replicate number.
TEST(Replicates, KindsHaveNoNumberInCommon) {
  for (size_t k = 0; k < kReplicateNumbers.size(); ++k) {
    EXPECT_LT(kReplicateNumbers[k].first, kReplicateNumbers[k].end);
    EXPECT_EQ(kReplicateNumbers[k].first, k > 0 ? kReplicateNumbers[k - 1].end : 0);
  }
  EXPECT_GT(kRunReplicates.end, uint64_t(1) << 39);  // largest --first-replicate
}

}  // namespace
}  // namespace viewpeel

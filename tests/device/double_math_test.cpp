// These tests compare the shaders' logarithm and arc tangent, in double precision, with long double.
#include <algorithm>
#include <cmath>
#include <random>

#include <glm/vec2.hpp>
#include <gtest/gtest.h>

#include "shaders/double_math.comp.h"
#include "tests/support/test_device.h"
#include "vulkan/commands.h"

namespace viewpeel {
namespace {

struct Args {
  uint64_t points, values;
  uint32_t count;
};

std::vector<glm::dvec2> evaluate(const std::vector<glm::dvec2>& points) {
  const Device& device = testDevice();
  Buffer in(device, points.size() * sizeof(glm::dvec2), MemoryUse::upload),
      out(device, in.sizeBytes(), MemoryUse::device), read(device, in.sizeBytes(), MemoryUse::readback);
  in.write(std::span<const glm::dvec2>(points));
  const Kernel kernel(device, double_math_comp, sizeof(Args));
  Commands commands(device);
  commands.begin();
  commands.dispatch(kernel, Args{in.address(), out.address(), static_cast<uint32_t>(points.size())},
                    static_cast<uint32_t>((points.size() + 63) / 64), 1);
  commands.barrier();
  commands.copy(out, read, in.sizeBytes());
  commands.submitAndWait();
  const auto values = read.mapped<glm::dvec2>();
  return {values.begin(), values.begin() + static_cast<std::ptrdiff_t>(points.size())};
}

double ulpOf(long double x) {
  int exponent = 0;
  std::frexp(double(x), &exponent);
  return std::ldexp(1.0, exponent - 53);
}

// double_math.glsl promises an error of 3 ulp; for logarithms nearer to 0 than 0.1 it promises 3 ulp of 0.1.
TEST(DoubleMath, ThreeUlpOfLogarithmAndAngle) {
  constexpr double kUlps = 3;
  std::mt19937_64 random(71);
  const auto uniform = [&random](double low, double high) {
    return low + (high - low) * (double(random() >> 11) * 0x1p-53);
  };
  std::vector<glm::dvec2> points{{1, 0},           {-1, 0},     {0, 1},       {1, 1},      {-1, 1}, {1e-290, 0},
                                 {1e-290, 1e-290}, {1, 1e-290}, {-1, 1e-290}, {1e-290, 1}, {2, 0.5}};
  for (int k = 0; k < 20'000; ++k) {
    points.push_back({uniform(0.5, 2), uniform(0, 2)});
    points.push_back({-uniform(0.5, 2), uniform(0, 2)});
    points.push_back({std::exp(uniform(-600, 600)), std::exp(uniform(-600, 600))});
    points.push_back({(k % 2 ? -1 : 1) * std::exp(uniform(-20, 3)), std::exp(uniform(-20, 3))});
  }
  const std::vector<glm::dvec2> values = evaluate(points);
  double worst_log = 0, worst_angle = 0;
  for (size_t k = 0; k < points.size(); ++k) {
    const long double log = points[k].x == 0 ? values[k].x : std::log(std::abs((long double)points[k].x));
    worst_log = std::max(worst_log, double(std::abs(values[k].x - log)) / ulpOf(std::max(std::abs(log), 0.1L)));
    const long double angle = std::atan2((long double)points[k].y, (long double)points[k].x);
    if (angle == 0) EXPECT_EQ(values[k].y, 0) << points[k].x << ", " << points[k].y;
    else if (angle > 1e-290L) worst_angle = std::max(worst_angle, double(std::abs(values[k].y - angle)) / ulpOf(angle));
  }
  EXPECT_LE(worst_log, kUlps);
  EXPECT_LE(worst_angle, kUlps);
  EXPECT_GT(worst_log, 0.4);  // negative control: the shader is not exact
}

}  // namespace
}  // namespace viewpeel

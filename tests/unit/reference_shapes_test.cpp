// Negative controls: isWithin() and isEstimateOf() refuse wrong values.
#include "tests/support/reference_shapes.h"

namespace viewpeel::reference::test {
namespace {

TEST(IsWithin, RefusesAWrongValue) {
  EXPECT_TRUE(isWithin(0.2, 0.2 + 0.9e-11, 1e-11));
  EXPECT_FALSE(isWithin(0.2, 0.2 + 1.1e-11, 1e-11));
  EXPECT_FALSE(isWithin(std::nan(""), 0.2, 1));
}

TEST(IsEstimateOf, RefusesAWrongValue) {
  EXPECT_TRUE(isEstimateOf(0.24, 0.01, 0.2));
  EXPECT_FALSE(isEstimateOf(0.25, 0.01, 0.2));
  EXPECT_FALSE(isEstimateOf(0.2, std::nan(""), 0.2));
}

TEST(BoxFaces, LookInwards) {
  for (const Corners& face : boxFaces({1, 2, 3})) {
    const glm::dvec3 normal = glm::cross(face[1] - face[0], face[2] - face[0]);
    EXPECT_GT(glm::dot(normal, glm::dvec3(0.5, 1, 1.5) - face[0]), 0);
  }
}

}  // namespace
}  // namespace viewpeel::reference::test

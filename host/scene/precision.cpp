#include "scene/precision.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/glm.hpp>

namespace viewpeel {
namespace {

constexpr double kCoarse = 16;      // steps of rounding in an edge that is long enough
constexpr double kFewEdges = 0.01;  // share of edges that may be shorter
constexpr double kUsedSteps = 0.1;  // least share of large coordinates on odd steps; below it the numbers are round

// Returns whether all coordinates are numbers in single precision, up to this share of themselves.
bool isSingle(const InputScene& input, double allowed) {
  for (const InputFace& face : input.faces)
    for (const glm::dvec3& corner : face.corners)
      for (int axis = 0; axis < 3; ++axis)
        if (std::abs(double(float(corner[axis])) - corner[axis]) > allowed * std::abs(corner[axis])) return false;
  return true;
}

double largestOf(const InputScene& input) {
  double largest = 0;
  for (const InputFace& face : input.faces)
    for (const glm::dvec3& corner : face.corners)
      for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(corner[axis]));
  return largest;
}

}  // namespace

double roundingOf(const InputScene& input) { return 4 * largestOf(input) * (isSingle(input, 0) ? 0x1p-24 : 0x1p-53); }

std::string describeCoarseSteps(const InputScene& input) {
  // Text writes a number in single precision with nine digits, and so moves it by at most this share of itself.
  constexpr double kNineDigits = 5e-9;
  const double largest = largestOf(input);
  if (largest == 0 || !isSingle(input, kNineDigits)) return "";
  const double step = std::ldexp(1.0, std::ilogb(largest) - 23);  // step between floats of this size
  uint64_t edges = 0, coarse = 0, large = 0, odd = 0;
  double shortest = INFINITY;
  for (const InputFace& face : input.faces)
    for (size_t k = 0; k < face.corners.size(); ++k) {
      const glm::dvec3 &a = face.corners[k], &b = face.corners[(k + 1) % face.corners.size()];
      for (int axis = 0; axis < 3; ++axis)
        if (std::abs(a[axis]) >= largest / 2) {
          ++large;
          odd += std::fmod(std::abs(double(float(a[axis]))) / step, 2) == 1;
        }
      const double length = glm::length(b - a);
      if (length == 0) continue;
      ++edges;
      coarse += length < kCoarse * step;
      shortest = std::min(shortest, length);
    }
  if (double(coarse) <= kFewEdges * double(edges) || double(odd) < kUsedSteps * double(large)) return "";
  return fmt::format(
      "{}: coordinates of up to {:.3g} in single precision come in steps of {:.2g}, and {} of {} edges are shorter "
      "than {:.0f} steps (the shortest is {:.3g}); "
      "move the scene to the origin before it is exported, or export it in double precision",
      input.file, largest, step, coarse, edges, kCoarse, shortest);
}

}  // namespace viewpeel

#include "unoccluded/line_rules.h"

namespace viewpeel {

std::vector<GaussPoint> unitPoints(int n) {
  std::vector<GaussPoint> points = gaussPoints(n);
  for (GaussPoint& point : points) point = {(1 + point.node) / 2, point.weight / 2};
  return points;
}

std::vector<GaussPoint> gradedPoints(int n) {
  std::vector<GaussPoint> points = unitPoints(n);
  for (auto& [t, weight] : points) {
    weight *= 30 * t * t * (1 - t) * (1 - t);
    t = t * t * t * (10 + t * (-15 + t * 6));
  }
  return points;
}

}  // namespace viewpeel

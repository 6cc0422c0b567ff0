#include "reference/closed_forms/discs.h"

#include <cmath>

#include <viewpeel/error.h>

namespace viewpeel::reference {

double coaxialDiscs(double radius_a, double radius_b, double distance) {
  for (double length : {radius_a, radius_b, distance})
    if (!(length > 0 && std::isfinite(length)))
      throw Error(ErrorCode::bad_input, "discs: radii and distance must be positive");
  const double s = radius_b / radius_a, z = distance / radius_a;
  const double x = 1 + s * s + z * z;
  return 2 * s * s / (x + std::sqrt(((1 - s) * (1 - s) + z * z) * (x + 2 * s)));
}

}  // namespace viewpeel::reference

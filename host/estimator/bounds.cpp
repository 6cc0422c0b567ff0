#include "estimator/bounds.h"

#include <algorithm>

namespace viewpeel {

double latticeRange(const ConvexSize& x, double h) { return 2 * x.area + x.perimeter * h + 2 * h * h; }

double scanlineRange(const ConvexSize& x, double h) { return 2 * x.area + 2 * h * x.diameter + 0x1p-9 * h * (x.diameter + h); }

double formFactorRange(double range_i, double range_j, double area_i) { return std::min(range_i, range_j) / area_i; }

}  // namespace viewpeel

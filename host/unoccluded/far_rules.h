// Far rules have the error bound of the product rules that integrate far pairs.
#pragma once
#include "unoccluded/shared.h"

namespace viewpeel {

// Returns the coefficients of the bound on the error of a product rule, docs/method.md, eq. (37), see
// unoccluded/classify.comp.
//   In: n: points along each coordinate.     Out: the bound, in single precision.
unoccluded_data::FarBound farBound(int n);

}  // namespace viewpeel

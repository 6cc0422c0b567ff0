// The error bound of the product rules that integrate far pairs.
#pragma once
#include "unoccluded/shared.h"

namespace viewpeel {

// What the bound on the error of a product rule is made of, see unoccluded_classify.comp.
//   In: n: points along each coordinate.     Out: the bound, in single precision.
unoccluded_data::FarBound farBound(int n);

}  // namespace viewpeel

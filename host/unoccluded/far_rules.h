// farBound returns an error bound of the product rules by which far pairs are integrated.
#pragma once
#include "unoccluded/shared.h"

namespace viewpeel {

// Returns the coefficients of the bound on the error of a product rule, docs/method.md, eq. (37). errorOf in
// shaders/unoccluded/classify.comp evaluates it.
//   In: n: points along each coordinate     Out: coefficients in single precision
unoccluded_data::FarBound farBound(int n);

}  // namespace viewpeel

// expectSameBits compares form factors that must not differ by a bit.
#pragma once
#include <gtest/gtest.h>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// Expects the same entries, with the same values and the same standard errors.
inline void expectSameBits(const FormFactors& one, const FormFactors& other) {
  ASSERT_EQ(one.entries().size(), other.entries().size());
  for (size_t k = 0; k < one.entries().size(); ++k) {
    const FormFactors::Entry &a = one.entries()[k], &b = other.entries()[k];
    ASSERT_TRUE(a.i == b.i && a.j == b.j) << k;
    EXPECT_EQ(a.exchange_area.value, b.exchange_area.value) << a.i << ", " << a.j;
    EXPECT_EQ(a.exchange_area.standard_error, b.exchange_area.standard_error) << a.i << ", " << a.j;
  }
}

}  // namespace viewpeel

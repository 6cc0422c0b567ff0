// randomFormFactors() has unequal areas and random values, so that swapped rows and transpositions change the matrix.
#pragma once
#include <random>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// Returns random form factors. Rows sum to at most 1, environment and leak included.
//   In: density: share of the pairs that are not 0; with_self: whether rows may see themselves
inline FormFactors randomFormFactors(const Ids& ids, uint32_t seed, double density = 1, bool with_self = true) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(0.05, 1);
  std::bernoulli_distribution is_there(density);
  const uint32_t n = ids.count();
  std::vector<FormFactors::Entry> entries;
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t j = i; j < n; ++j)
      if (is_there(engine) && (with_self || i != j))
        entries.push_back({i, j, {uniform(engine), 1e-3 * uniform(engine)}});
    for (const uint32_t j : {kEnvironment, kLeak}) entries.push_back({i, j, {uniform(engine), 1e-3 * uniform(engine)}});
  }
  const auto sumsOf = [&](const std::vector<FormFactors::Entry>& of) {
    std::vector<Measured> sums(n);
    for (const FormFactors::Entry& entry : of) {
      sums[entry.i].value += entry.exchange_area.value / ids.areas[entry.i];
      if (entry.j < kEnvironment && entry.j != entry.i)
        sums[entry.j].value += entry.exchange_area.value / ids.areas[entry.j];
    }
    for (Measured& sum : sums) sum.standard_error = 1e-3;
    return sums;
  };
  double largest = 0;
  for (const Measured& sum : sumsOf(entries)) largest = std::max(largest, sum.value);
  for (FormFactors::Entry& entry : entries) {
    entry.exchange_area.value /= largest;
    entry.exchange_area.standard_error /= largest;
  }
  std::vector<Measured> sums = sumsOf(entries);
  return {ids, std::move(entries), std::move(sums)};
}

}  // namespace viewpeel

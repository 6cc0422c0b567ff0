#include "estimator/find_guesses.h"

#include "sums/add_pairs.h"

namespace viewpeel {

std::vector<std::pair<uint32_t, uint32_t>> findGuesses(const RunSums& sums, const FormFactors& form_factors) {
  if (!sums.prior_sums || sums.prior_sums->by() != By::polygon) return {};
  const auto isAmong = [](const auto& pairs, auto& next, const FormFactors::Entry& entry) {
    while (next != pairs.end() && keyOf(*next) < keyOf(entry)) ++next;
    return next != pairs.end() && keyOf(*next) == keyOf(entry);
  };
  const auto& counted = sums.prior_sums->byFace().pairs();
  const std::vector<DirectedPair>& directed = sums.prior_sums->prior().directed;
  auto next_counted = counted.begin();
  auto next_directed = directed.begin();
  std::vector<std::pair<uint32_t, uint32_t>> guesses;
  for (const FormFactors::Entry& entry : form_factors.entries())
    if (entry.j < kEnvironment && entry.i != entry.j && !isAmong(counted, next_counted, entry) &&
        !isAmong(directed, next_directed, entry))
      guesses.emplace_back(entry.i, entry.j);
  return guesses;
}

}  // namespace viewpeel

#include "estimator/find_guesses.h"

#include "sums/pair_walk.h"

namespace viewpeel {

std::vector<std::pair<uint32_t, uint32_t>> findGuesses(const RunSums& sums, const FormFactors& form_factors) {
  if (!sums.prior_sums || sums.prior_sums->by() != By::polygon) return {};
  PairWalk counted(sums.prior_sums->byFace().pairs());
  PairWalk directed(sums.prior_sums->prior().directed);
  std::vector<std::pair<uint32_t, uint32_t>> guesses;
  for (const FormFactors::Entry& entry : form_factors.entries())
    if (entry.j < kEnvironment && entry.i != entry.j && !counted.find(entry) && !directed.find(entry))
      guesses.emplace_back(entry.i, entry.j);
  return guesses;
}

}  // namespace viewpeel

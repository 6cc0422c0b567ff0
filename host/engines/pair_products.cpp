#include "engines/pair_products.h"

namespace viewpeel {

void PairProducts::start(std::span<const int64_t> factors, size_t columns, bool counts_outside) {
  columns_ = columns;
  counts_outside_ = counts_outside;
  cells_.assign(factors.size(), {});
  for (size_t k = 0; k < factors.size(); ++k) cells_[k].factor = factors[k];
  if (counts_outside) outside_.assign(factors.size() / columns, {});
  coming_.fill({});
}

void PairProducts::settle() {
  for (Coming& pair : coming_) {
    multiply(pair);
    pair = {};
  }
}

}  // namespace viewpeel

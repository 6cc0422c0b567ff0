// forEachEntry() calls a function for each nonzero form factor, row by row, as writers of files need them.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// Calls use(i, j, F_ij) for every nonzero entry of the requested rows, both ways, row by row and by column within a
// row; environment and leak come last.
//   In: form_factors: n ids; use: takes uint32_t, uint32_t, Measured    Cost: O(nonzeros) work and memory.
template <class Use>
void forEachEntry(const FormFactors& form_factors, Use use) {
  std::vector<std::vector<FormFactors::Entry>> rows(form_factors.ids().count());
  for (const FormFactors::Entry& entry : form_factors.entries())
    if (entry.j < kEnvironment && entry.j != entry.i) rows[entry.j].push_back({entry.j, entry.i, entry.exchange_area});
  for (const FormFactors::Entry& entry : form_factors.entries()) rows[entry.i].push_back(entry);
  for (const auto& row : rows)
    for (const FormFactors::Entry& entry : row) {
      if (!form_factors.ids().isRequested(entry.i)) continue;
      const double area = form_factors.ids().areas[entry.i];
      use(entry.i, entry.j, Measured{entry.exchange_area.value / area, entry.exchange_area.standard_error / area});
    }
}

}  // namespace viewpeel

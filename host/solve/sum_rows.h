// These functions add up rows for all kinds of enclosures.
#pragma once
#include <cmath>
#include <vector>

#include <viewpeel/solve.h>

namespace viewpeel {

// Returns the rows of each surface.    In: surface_count: number of surfaces
inline std::vector<std::vector<uint32_t>> rowsOfSurfaces(const Ids& ids, size_t surface_count) {
  std::vector<std::vector<uint32_t>> rows(surface_count);
  for (uint32_t i = 0; i < ids.count(); ++i)
    if (ids.surface[i] < rows.size()) rows[ids.surface[i]].push_back(i);
  return rows;
}

// Sets balance_residual, the sum of all heat flows, which ought to be 0, and heat_flow_total, half the sum of their
// sizes. The heat flow to the environment counts with the opposite sign.
inline void balance(HeatSolution& found) {
  double flow = -found.to_environment.value;
  found.heat_flow_total = std::abs(found.to_environment.value) / 2;
  for (const HeatRow& row : found.rows) {
    flow += row.heat_flow.value;
    found.heat_flow_total += std::abs(row.heat_flow.value) / 2;
  }
  found.balance_residual = flow;
}

}  // namespace viewpeel

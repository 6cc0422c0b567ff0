#include "solve/closed_exchange.h"

#include <cmath>

#include <fmt/format.h>

#include <viewpeel/balance.h>
#include <viewpeel/error.h>
#include "scene/leaks.h"

namespace viewpeel {
namespace {

using Eigen::VectorXd;
using Entry = FormFactors::Entry;

constexpr double kRowRounding = 1e-12;  // allowed in a row sum that is 1 by construction

}  // namespace

void refuseLeak(double share, const std::string& row, const Scene* scene) {
  std::string cause = scene ? explainLargestLeak(*scene) : "";
  if (cause.empty())
    cause =
        "turn flipped faces over, cut faces where they overlap or meet, and close gaps; viewpeel compute names the "
        "cause";
  throw Error(ErrorCode::bad_input, fmt::format("{}{:.3g} % of all emitted radiation ends on backs, which have no "
                                                "material (most of it comes from '{}'): {}",
                                                scene ? scene->file + ": " : "", 100 * share, row, cause));
}

void requireNoLeak(const FormFactors& form_factors, const Scene* scene) {
  const Ids& ids = form_factors.ids();
  double leak = 0, largest = 0, area = 0;
  uint32_t row = 0;
  for (const double of_row : ids.areas) area += of_row;
  for (const Entry& entry : form_factors.entries()) {
    if (entry.j != kLeak) continue;
    leak += entry.exchange_area.value;
    if (entry.exchange_area.value > largest) largest = entry.exchange_area.value, row = entry.i;
  }
  if (leak > kGrazingShare * area) refuseLeak(leak / area, ids.names[row], scene);
}

ClosedExchange closeRows(const FormFactors& form_factors) {
  const Ids& ids = form_factors.ids();
  const uint32_t n = ids.count();
  if (!ids.requested.empty() || !ids.rows_sum_to_one || form_factors.rowSums().size() != n)
    throw Error(ErrorCode::bad_usage,
                "heat needs the form factors of all rows; compute them without --from, --pair and --blocker");
  requireNoLeak(form_factors, nullptr);

  ClosedExchange closed;
  closed.areas = Eigen::Map<const VectorXd>(ids.areas.data(), n);
  closed.environment = VectorXd::Zero(n);
  closed.environment_is_rest.assign(n, false);
  double environment = 0, variance = 0;
  for (const Entry& entry : form_factors.entries()) {
    if (entry.j != kEnvironment) continue;
    closed.environment[entry.i] = entry.exchange_area.value;
    environment += entry.exchange_area.value;
    variance += std::pow(entry.exchange_area.standard_error, 2);
    closed.environment_is_rest[entry.i] = std::abs(form_factors.rowSums()[entry.i].value - 1) < kRowRounding;
  }
  const double area = closed.areas.sum();
  closed.is_open = environment > kGrazingShare * area && environment > kErrorsOfOpenScene * std::sqrt(variance);
  if (!closed.is_open) {
    closed.environment.setZero();
    closed.environment_is_rest.assign(n, false);
  } else {
    closed.environment_share = environment / area;
  }

  VectorXd diagonal = closed.areas - closed.environment, measured = closed.environment;
  std::vector<Eigen::Triplet<double, uint32_t>> triplets;
  triplets.reserve(2 * form_factors.entries().size() + n);
  for (const Entry& entry : form_factors.entries()) {
    if (entry.j >= kEnvironment) continue;
    const double exchange = entry.exchange_area.value;
    measured[entry.i] += exchange;
    if (entry.i == entry.j) continue;
    measured[entry.j] += exchange;
    diagonal[entry.i] -= exchange;
    diagonal[entry.j] -= exchange;
    triplets.emplace_back(entry.i, entry.j, exchange);
    triplets.emplace_back(entry.j, entry.i, exchange);
  }
  for (uint32_t i = 0; i < n; ++i) {
    triplets.emplace_back(i, i, diagonal[i]);
    const double lack = 1 - measured[i] / closed.areas[i];
    if (std::abs(lack) > std::abs(closed.largest_lack)) closed.largest_lack = lack, closed.lacking_row = i;
  }
  closed.pairs.resize(n, n);
  closed.pairs.setFromTriplets(triplets.begin(), triplets.end());
  return closed;
}

}  // namespace viewpeel

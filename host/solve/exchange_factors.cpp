// This file computes Gebhart's factors and script-F by the symmetric form of irradiation.h.
//
// Let e, r = 1 - e and A be the diagonal matrices of emissivities, reflectivities and areas, and X the closed exchange
// areas. Factors S = A - r^(1/2) X r^(1/2) = L L^T give Y = L^-1 r^(1/2) X e. Then the conductors are R = e X e + Y^T
// Y, so R is symmetric to the last bit. Derivation: docs/solve.md, eq. (9).
#include <viewpeel/solve.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <fmt/format.h>

#include <viewpeel/balance.h>
#include <viewpeel/error.h>
#include "solve/directional_law.h"
#include "solve/irradiation.h"

namespace viewpeel {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr uint32_t kMostRows = 10'000;

struct Conductors {
  MatrixXd between;  // lower triangle
  VectorXd to_environment;
};

Conductors findConductors(const ClosedExchange& closed, const VectorXd& emissivity) {
  const Irradiation irradiation(closed, VectorXd::Ones(emissivity.size()) - emissivity);
  const Eigen::LLT<MatrixXd> factor((MatrixXd(irradiation.symmetric())));
  const MatrixXd absorbed = MatrixXd(closed.pairs) * emissivity.asDiagonal();
  const MatrixXd y = factor.matrixL().solve(irradiation.roots().asDiagonal() * absorbed);
  const VectorXd y_environment = factor.matrixL().solve(irradiation.roots().cwiseProduct(closed.environment));
  Conductors found{emissivity.asDiagonal() * absorbed,
                   emissivity.cwiseProduct(closed.environment) + y.transpose() * y_environment};
  found.between.selfadjointView<Eigen::Lower>().rankUpdate(y.transpose());
  return found;
}

// Returns the factors as form factors between rows of area A_i e_i. The environment is the last row, and as large as
// its exchange.
FormFactors asFormFactors(const ExchangeFactors& factors, const VectorXd& to_environment) {
  Ids ids;
  ids.names = factors.names;
  for (size_t i = 0; i < factors.names.size(); ++i) ids.areas.push_back(factors.areas[i] * factors.emissivities[i]);
  const auto environment = static_cast<uint32_t>(ids.names.size());
  if (to_environment.sum() > 0) {
    ids.names.emplace_back("environment");
    ids.areas.push_back(to_environment.sum());
  }
  std::vector<FormFactors::Entry> entries;
  entries.reserve(factors.entries.size());
  for (const ExchangeFactors::Entry& entry : factors.entries)
    entries.push_back({entry.i, std::min(entry.j, environment), {entry.conductor, 0}});
  return {std::move(ids), std::move(entries), {}};
}

// Leaves out factors that are below the cut from either row, and balances the others so that rows keep their sums. Each
// row keeps its largest factor.
void dropBelow(double cut, const VectorXd& to_environment, ExchangeFactors& factors) {
  const auto n = static_cast<uint32_t>(factors.names.size());
  std::vector<double> largest(n), lost(n);
  const auto emitted = [&](uint32_t i) { return factors.areas[i] * factors.emissivities[i]; };
  for (const ExchangeFactors::Entry& entry : factors.entries) {
    largest[entry.i] = std::max(largest[entry.i], entry.conductor);
    if (entry.j < n) largest[entry.j] = std::max(largest[entry.j], entry.conductor);
  }
  const auto isDropped = [&](const ExchangeFactors::Entry& entry) {
    const double both = entry.j < n ? std::min(emitted(entry.i), emitted(entry.j)) : emitted(entry.i);
    return entry.conductor < cut * both && entry.conductor < largest[entry.i] &&
           (entry.j >= n || entry.conductor < largest[entry.j]);
  };
  for (const ExchangeFactors::Entry& entry : factors.entries) {
    if (!isDropped(entry)) continue;
    ++factors.dropped;
    lost[entry.i] += entry.conductor;
    if (entry.j < n && entry.j != entry.i) lost[entry.j] += entry.conductor;
  }
  if (factors.dropped == 0) return;
  std::erase_if(factors.entries, isDropped);
  for (uint32_t i = 0; i < n; ++i)
    factors.largest_dropped_share = std::max(factors.largest_dropped_share, lost[i] / emitted(i));
  try {
    const BalancedFormFactors balanced = balanceRows(asFormFactors(factors, to_environment));
    for (size_t k = 0; k < factors.entries.size(); ++k)
      factors.entries[k].conductor = balanced.form_factors.entries()[k].exchange_area.value;
  } catch (const Error&) {
    throw Error(ErrorCode::bad_input,
                fmt::format("exchange factors below {} are {:.2g} of what some row emits, too much to leave out; "
                            "lower --drop-below",
                            cut, factors.largest_dropped_share));
  }
}

}  // namespace

ExchangeFactors findExchangeFactors(const FormFactors& form_factors, const Enclosure& enclosure, double drop_below) {
  requireDiffuse(enclosure);
  const Ids& ids = form_factors.ids();
  if (enclosure.materials.size() != ids.count())
    throw Error(ErrorCode::bad_usage,
                fmt::format("{} materials for {} rows; give one for each", enclosure.materials.size(), ids.count()));
  if (!enclosure.band_limits_um.empty())
    throw Error(ErrorCode::bad_usage,
                "exchange factors need one emissivity a row, not one for each band; leave out --exchange, or give "
                "grey materials");
  if (ids.count() > kMostRows)
    throw Error(ErrorCode::limit,
                fmt::format("exchange factors of {} rows, more than {}; take --by surface", ids.count(), kMostRows));
  const ClosedExchange closed = closeRows(form_factors);
  ExchangeFactors factors{{}, ids.names, ids.areas, {}};
  VectorXd emissivity(ids.count());
  for (uint32_t i = 0; i < ids.count(); ++i) {
    emissivity[i] = enclosure.materials[i].emissivity;
    if (!(emissivity[i] > 0 && emissivity[i] <= 1))
      throw Error(ErrorCode::bad_usage, fmt::format("'{}' has an emissivity of {}, not above 0 and up to 1; correct it",
                                                    ids.names[i], emissivity[i]));
    factors.emissivities.push_back(emissivity[i]);
  }
  const Conductors conductors = findConductors(closed, emissivity);
  for (uint32_t i = 0; i < ids.count(); ++i) {
    for (uint32_t j = i; j < ids.count(); ++j)
      if (const double conductor = conductors.between(j, i); conductor != 0)
        factors.entries.push_back({i, j, conductor});
    if (conductors.to_environment[i] != 0) factors.entries.push_back({i, kEnvironment, conductors.to_environment[i]});
  }
  dropBelow(drop_below, conductors.to_environment, factors);
  return factors;
}

}  // namespace viewpeel

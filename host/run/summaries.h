// Summaries describe a run: its plan, its visibilities, and the sums of its form factors.
#pragma once
#include <string>

#include <viewpeel/result.h>

#include "estimator/find_prior.h"
#include "run/setup.h"

namespace viewpeel {

// Describes the request before the plan, and with it.
PlanSummary summarise(const Setup& setup);
PlanSummary summarise(const Setup& setup, const Plan& plan);
PlanSummary summarise(const Setup& setup, const GuaranteePlan& plan);
PriorSummary summarise(const FoundPrior& found);

// Returns a time as people write it: "0.31 s", "14 minutes".
std::string inWords(double seconds);

// These functions refuse a guarantee that would take longer than the time limit.    Throws: Error bad_usage.
[[noreturn]] void refuseGuarantee(const GuaranteeFigures& plan, double time_limit_s);
[[noreturn]] void refuseGuarantee(const LineGuaranteeFigures& plan, double time_limit_s);

// Returns the share of radiation from the requested rows that goes to this column: kEnvironment or kLeak.
double shareOf(const FormFactors& form_factors, uint32_t column);

}  // namespace viewpeel

// Summaries describe a run: its plan, its visibilities, and the sums of its form factors.
#pragma once
#include <string>

#include <viewpeel/result.h>

#include "estimator/find_prior.h"
#include "run/setup.h"

namespace viewpeel {

// Summarises the request before the plan.
PlanSummary summarise(const Setup& setup);
PlanSummary summarise(const Setup& setup, const Plan& plan);
PlanSummary summarise(const Setup& setup, const GuaranteePlan& plan);
PriorSummary summarise(const FoundPrior& found);

// Returns a time for people: "0.31 s", "14 minutes".
std::string inWords(double seconds);

//   Throws: Error bad_usage: the guarantee takes longer than there is time.
[[noreturn]] void refuseGuarantee(const GuaranteeFigures& plan, double time_limit_s);
[[noreturn]] void refuseGuarantee(const LineGuaranteeFigures& plan, double time_limit_s);

// Returns the share of the emitting area of the requested rows whose lines end in this column: kEnvironment or kLeak.
double shareOf(const FormFactors& form_factors, uint32_t column);

}  // namespace viewpeel

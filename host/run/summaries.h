// What is said of a run: its plan, its visibilities, and what its form factors come to in all.
#pragma once
#include <string>

#include <viewpeel/result.h>

#include "estimator/find_prior.h"
#include "run/setup.h"

namespace viewpeel {

// Before the plan.
PlanSummary summarise(const Setup& setup);
PlanSummary summarise(const Setup& setup, const Plan& plan);
PlanSummary summarise(const Setup& setup, const GuaranteePlan& plan);
PriorSummary summarise(const FoundPrior& found);

// A time for people: "0.31 s", "14 minutes".
std::string inWords(double seconds);

//   Throws: Error bad_usage: the guarantee takes longer than there is time.
[[noreturn]] void refuseGuarantee(const GuaranteeFigures& plan, double time_limit_s);

// The share of the emitting area asked for whose lines end in that column: kEnvironment or kLeak.
double shareOf(const FormFactors& form_factors, uint32_t column);

}  // namespace viewpeel

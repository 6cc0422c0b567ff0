// This file decides whether a tolerance is promised, as a guarantee, or estimated (Request::promise).

#include <algorithm>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "estimator/promise_cost.h"
#include "run/rules.h"
#include "run/run_state.h"

namespace viewpeel {
namespace {

std::string reasonOfLeak(double share) {
  return fmt::format("about {:.3g} % of a row's radiation ends on backs of polygons",
                     100 * std::min(1.0, share));  // few lines may say more than all
}

}  // namespace

// Does without a promise that would be refused anyway, so that the plan does not take it into account.
//   In: leak: share of a row that is sure to end on backs
void FormFactorRun::State::refusePromiseOfLeak(double leak) {
  const std::optional<double> tolerance = setup.estimate().tolerance;
  if (no_promise.empty() && tolerance && leak > kGrazedPart * *tolerance) refusePromise(reasonOfLeak(leak));
}

// Continues without a promise; throws where the request insists on one.
void FormFactorRun::State::refusePromise(const std::string& why) {
  if (setup.request().promise.value_or(false))
    throw Error(ErrorCode::bad_usage,
                fmt::format("the tolerance cannot be promised: {}; leave out --promise on for an estimate", why));
  no_promise = why;
}

// Plans a promise.    In: line_pairs: from findLinePairs()    Out: false where form factors are to be estimated
bool FormFactorRun::State::planPromise() {
  const double tolerance = *setup.estimate().tolerance;
  const auto refuse = [&](const std::string& why) {
    takeBackPromise();
    refusePromise(why);
    return false;
  };
  const auto mayPlanFor = [&](bool is_open) {
    setup.promise(is_open);
    try {
      makeLineGuarantee();
    } catch (const Error& error) {
      return refuse(error.what());
    }
    const LineGuaranteeFigures& figures = line_guarantee->figures();
    return setup.request().promise || isWorthPromise(figures.cost, figures.estimate_cost) ||
           refuse(fmt::format("a promise would cost {:.2g} times as much, {} of CPU time in place of {}",
                              figures.cost / figures.estimate_cost, inWords(figures.cost),
                              inWords(figures.estimate_cost)));
  };
  if (!mayPlanFor(may_leave)) return false;
  const bool is_open = countOutside();
  if (is_open || may_leave) surveyLeaks({.epsilon = tolerance, .rows = true});
  if (leaked_share > kGrazedPart * tolerance) return refuse(reasonOfLeak(leaked_share));
  if (is_open && !may_leave && !mayPlanFor(true)) return false;
  line_guarantee->predictSeconds(finding_seconds);
  return true;
}

// Counts along common directions what leaves the scene or ends on backs, for a guarantee or a promise.
//   Out: whether anything leaves the scene; sets common_counts, without leak, and leaked_share where more leaks
bool FormFactorRun::State::countOutside() {
  if (!plan->engine) makeLineEngine();
  common_counts = countCommonDirections();
  bool is_open = false;
  std::vector<double> leaked(setup.faceIds().count(), 0);
  for (PairCounts& counts : *common_counts) {
    for (const PairCount& count : counts) {
      is_open |= count.j == kEnvironment;
      if (count.j == kLeak) leaked[count.i] += 2 * double(count.count) * commonCountArea();  // docs/method.md, eq. (7)
    }
    std::erase_if(counts, [](const PairCount& count) { return count.j == kLeak; });
  }
  for (size_t k = 0; k < leaked.size(); ++k)
    leaked_share = std::max(leaked_share,
                            leaked[k] / setup.faceIds().areas[k] / double(std::max<size_t>(common_counts->size(), 1)));
  return is_open;
}

void FormFactorRun::State::takeBackPromise() {
  setup.takeBackPromise();
  line_guarantee.reset(), common_counts.reset(), common_sums.reset();
}

// Continues with an estimate where the lines that were drawn show that the promise cannot be kept.
void FormFactorRun::State::breakPromise(const std::string& why) {
  takeBackPromise();
  is_promise_broken = true;
  no_promise = why;
  planEstimateLines();
  summary = summarise(setup, *plan);
  summary.no_promise = no_promise;
  begin();
}

}  // namespace viewpeel

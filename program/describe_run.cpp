#include "program/describe_run.h"

#include <fmt/format.h>

#include "program/summary.h"
#include "run/summaries.h"

namespace viewpeel::program {
namespace {

std::string describeLattices(const PlanSummary& plan) {
  if (plan.engine == EngineKind::exact) return "exact areas";
  std::string text = fmt::format("{} {} across", plan.sampling == Sampling::scanline ? "scanlines" : "lattice",
                                 plan.lattices[0].resolution);
  for (size_t g = 1; g < plan.lattices.size(); ++g)
    text += fmt::format(", {} in {} on {}", plan.lattices[g].resolution, counted(plan.lattices[g].windows, "window"),
                        counted(plan.lattices[g].polygons, "polygon"));
  return text;
}

std::string describeGuarantee(const Request& request, const PlanSummary& plan) {
  const GuaranteeFigures& g = *plan.guarantee;
  std::string text = fmt::format(
      "goal       a promise: every form factor within {} with probability {}: {} at once, a direction adds at most "
      "{:.2f}\n",
      g.epsilon, 1 - g.delta, counted(static_cast<uint64_t>(g.bounds), "bound"), g.largest_range);
  text += fmt::format("sampling   {} directions; {}; seed {}\n", plan.sampler, describeLattices(plan), request.seed);
  if (std::get<EpsilonDelta>(request.goal).statistic == Statistic::median)
    text += fmt::format("plan       median of {} of {}, {}\n", counted(g.runs, "run"),
                        counted(g.run_directions, "direction"), inWords(g.most_seconds));
  else
    text += fmt::format(
        "plan       {} of {} ({}) by Hoeffding's bound; by Bernstein's {} ({}) expected, {} ({}) at least; the same "
        "again:{} --block {}\n",
        counted(g.most_blocks, "block"), counted(g.block_directions, "direction"), inWords(g.most_seconds),
        counted(g.expected_blocks, "block"), inWords(g.expected_seconds), g.least_blocks, inWords(g.least_seconds),
        plan.engine == EngineKind::exact ? ""
        : request.amount.resolution      ? fmt::format(" --resolution {}", request.amount.resolution)
                                         : fmt::format(" --range {}", g.range),
        g.block_directions);
  if (plan.unoccluded)
    text += fmt::format("unoccluded form factors of {} pairs of polygons, visibilities of {} from a pilot\n",
                        plan.unoccluded_pairs, plan.pairs_with_visibility);
  return text;
}

constexpr const char* kAllExact = "no lines or directions: geometry gives every form factor";

// Returns the lines of the plan that say how many lines it takes.
std::string describeLines(const PlanSummary& plan, uint64_t seed) {
  const LineGuaranteeFigures& g = *plan.line_guarantee;
  if (g.drawn == 0 && g.bounded == 0)
    return fmt::format("plan       {}; planned in {}; seed {}\n",
                       plan.directions
                           ? fmt::format("no lines: geometry gives every form factor between rows; {} a replicate "
                                         "see what leaves the scene or ends on backs",
                                         counted(plan.directions, "direction"))
                           : kAllExact,
                       inWords(g.plan_seconds), seed);
  std::string text = fmt::format("plan       {:.2g} lines at most ({}), {:.2g} expected ({}); planned in {}; seed {}\n",
                                 g.most_lines, inWords(g.most_seconds), g.expected_lines, inWords(g.expected_seconds),
                                 inWords(g.plan_seconds), seed);
  if (g.drawn)
    text += fmt::format("           most of all for {} and {}: {:.2g}\n", g.neediest.first, g.neediest.second,
                        g.most_for_one);
  return text;
}

std::string describeLineGuarantee(const Request& request, const PlanSummary& plan) {
  const LineGuaranteeFigures& g = *plan.line_guarantee;
  const char* what =
      std::get<EpsilonDelta>(request.goal).rows ? "form factor, environment too," : "form factor between rows";
  std::string text = g.delta > 0 ? fmt::format("goal       a promise: every {} within {} with probability {}\n", what,
                                               g.epsilon, 1 - g.delta)
                                 : fmt::format(
                                       "goal       intervals that geometry alone proves, within {} where it "
                                       "does\n",
                                       g.epsilon);
  text += fmt::format(
      "pairs      {} nothing can block, so that they are exact; {} geometry alone bounds to {}; {} need lines\n",
      g.exact, g.bounded, g.epsilon, g.drawn);
  if (g.least_form_factor > 0)
    text += fmt::format("           pairs with unoccluded form factors below {:.3g} are within it without lines\n",
                        g.least_form_factor);
  return text + describeLines(plan, request.seed);
}

// Returns the errors and times that pilots predict; empty where options fix the plan.
std::string describeExpectation(const Request& request, const PlanSummary& plan) {
  if (!(plan.pilot_seconds > 0)) return "";
  const uint32_t replicates = request.amount.replicates;
  std::string text = fmt::format(
      "expected   {} {:.1e}{} after {} replicates, counted in {} (planned in {}); the same "
      "again: {}\n",
      std::holds_alternative<RootMeanSquare>(request.goal) ? "root mean square of all standard errors"
                                                           : "largest standard error",
      plan.standard_error, std::holds_alternative<Relative>(request.goal) ? " of its form factor" : "", replicates,
      inWords(plan.seconds), inWords(plan.pilot_seconds), optionsOf(plan));
  if (const auto& goal = plan.goal_beyond_request)
    text +=
        fmt::format("           {:.1e} takes about {:.3g} replicates, {}{}\n", goal->standard_error, goal->replicates,
                    inWords(goal->seconds),
                    request.time_limit_s && goal->seconds > *request.time_limit_s
                        ? fmt::format(": more than --seconds {} allow; the run ends short of it", *request.time_limit_s)
                        : "");
  if (const size_t rows = plan.barely_covered.size())
    text += fmt::format("           {} ({}{}) {} too small even for the finest lattice there is: {} may go unmet\n",
                        counted(rows, "row"), plan.barely_covered[0], rows > 1 ? ", ..." : "", rows > 1 ? "are" : "is",
                        rows > 1 ? "they" : "it");
  return text;
}

std::string describePairLines(const PairLinesSummary& lines, const PlanSummary& plan, uint64_t seed) {
  if (lines.least_form_factor >= 1)
    return fmt::format(
        "pairs      no lines of their own: rays take less time (planned in {})\n"
        "sampling   up to {} of each polygon a replicate, for all pairs, environment and leak; seed {}\n",
        inWords(lines.seconds), counted(plan.directions, "ray"), seed);
  std::string text =
      fmt::format("pairs      {} nothing can block, so that they are exact", counted(lines.clear, "pair"));
  if (lines.partial)
    text +=
        fmt::format("; {} may be blocked in part and get {} of their own, against {}", counted(lines.partial, "pair"),
                    counted(lines.lines, "line"), counted(lines.blockers, "blocker"));
  text += fmt::format(" (found in {})\n", inWords(lines.seconds));
  const bool counts_pairs = lines.least_form_factor > 0;
  const char* others = counts_pairs ? "the other pairs, " : "";
  if (counts_pairs)
    text += fmt::format("           all other pairs have form factors below {:.2g}, from the smaller polygon\n",
                        lines.least_form_factor);
  if (lines.has_rays)
    text += fmt::format("sampling   {}{} of each polygon a replicate, for {}environment and leak; ",
                        counts_pairs ? "up to " : "", counted(plan.directions, "ray"), others);
  else if (plan.directions)
    text += fmt::format("sampling   {} a replicate, {}, for {}environment and leak; {}; ",
                        counted(plan.directions, "direction"), plan.sampler, others, describeLattices(plan));
  else text += lines.partial ? "sampling   " : fmt::format("sampling   {}; ", kAllExact);
  return text + fmt::format("seed {}\n", seed);
}

}  // namespace

std::string describePlace(const FormFactorRun& run, const Scene& scene) {
  const DeviceDescription* device = run.device();
  return (device                                   ? describeDevice(*device)
          : run.plan().engine == EngineKind::exact ? "device     none: exact areas on the CPU\n"
                                                   : describeProcessor()) +
         describeScene(scene);
}

std::string describePlan(const FormFactorRun& run) {
  const Request& request = run.request();
  const PlanSummary& plan = run.plan();
  if (plan.guarantee) return describeGuarantee(request, plan);
  if (plan.line_guarantee) return describeLineGuarantee(request, plan);
  const auto* tolerance = std::get_if<Tolerance>(&request.goal);
  const auto* rms = std::get_if<RootMeanSquare>(&request.goal);
  const auto* seconds = std::get_if<Seconds>(&request.goal);
  const std::string goal =
      plan.no_promise.empty()
          ? ""
          : fmt::format("goal       an estimate{}, no promise: {}\n",
                        tolerance
                            ? fmt::format(", {} {}",
                                          plan.aims_at_largest_error ? "largest error about" : "standard errors up to",
                                          tolerance->standard_error)
                        : rms     ? fmt::format(", {} for the root mean square of all errors", rms->standard_error)
                        : seconds ? fmt::format(", as good as {} allow", inWords(seconds->seconds))
                                  : "",
                        plan.no_promise);
  if (plan.pair_lines) return goal + describePairLines(*plan.pair_lines, plan, request.seed);
  const std::string no_lines =
      plan.no_pair_lines.empty() ? "" : fmt::format("pairs      no lines of their own: {}\n", plan.no_pair_lines);
  return goal + no_lines +
         fmt::format("sampling   {} a replicate, {}; {}; seed {}\n", counted(plan.directions, "direction"),
                     plan.sampler, describeLattices(plan), request.seed) +
         describeExpectation(request, plan);
}

std::string describeAlternatives(const PlanSummary& plan) {
  const auto describe = [](const std::string& first, double for_one, double for_all, double by_median) {
    return fmt::format(
        "instead    {} by Pellegrini's Lemma 1 {:.3g} for one pair and {:.3g} for all; by his median of "
        "runs {:.3g}\n",
        first, for_one, for_all, by_median);
  };
  if (const auto& g = plan.guarantee)
    return describe(fmt::format("by Hoeffding's bound {} directions;", g->hoeffding), g->lemma_1, g->lemma_1_all,
                    double(g->runs) * double(g->run_directions));
  if (const auto& g = plan.line_guarantee; g && g->drawn + g->bounded > 0 && g->delta > 0)
    return describe("directions:", g->lemma_1, g->lemma_1_all, g->median_directions);
  return "";
}

std::string describePrior(const PriorSummary& prior) {
  std::string text =
      fmt::format("unoccluded form factors of {} of polygons in {}; {} of them never blocked in a pilot of {}{}\n",
                  counted(prior.pairs, "pair"), inWords(prior.unoccluded_seconds), prior.never_blocked,
                  inWords(prior.pilot_seconds),
                  prior.unreached ? fmt::format("; {} more are sampled without one", prior.unreached) : "");
  const uint64_t directed = prior.directed_pairs;
  if (directed)
    text += fmt::format(
        "directed   {} that the others hardly meet {} directions of {} own, {} a replicate in all (planned in {})\n",
        counted(directed, "pair"), directed == 1 ? "has" : "have", directed == 1 ? "its" : "their",
        prior.directed_directions, inWords(prior.directed_seconds));
  return text;
}

}  // namespace viewpeel::program

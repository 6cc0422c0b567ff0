// A result holds form factors with their errors, and says how they were found.
#pragma once
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <viewpeel/balance.h>
#include <viewpeel/engine.h>
#include <viewpeel/error.h>
#include <viewpeel/form_factors.h>
#include <viewpeel/sampling.h>

namespace viewpeel {

enum class GuaranteedBy { hoeffding, bernstein, median, chernoff };

// A Guarantee holds for all form factors at once, with probability 1 - delta.
struct Guarantee {
  double epsilon = 0, delta = 0;  // delta: 0 where geometry alone proves the bound
  double bound = 0;               // on errors of form factors between ids
  GuaranteedBy by = GuaranteedBy::hoeffding;
  double row_bound = 0;  // on errors of the environment; where `by` is not chernoff, `bound` holds for it, too
};

// An Estimate is computed from the sums of some replicates.
struct Estimate {
  FormFactors form_factors;
  FormFactors between_surfaces;  // the same counts summed by surface
  uint64_t replicates = 0;
  uint64_t directions = 0;  // of all replicates, without directions of directed pairs
  double largest_standard_error = 0;
  double largest_relative_error = 0;  // over form factors of at least relative_floor
  // An interrupted run may not have reached its goal. Standard errors are infinite with fewer than 2 replicates.
  bool interrupted = false;
  std::optional<Guarantee> guarantee;
  // No line hit these pairs of ids, though their unoccluded form factors are above 0. Each takes its visibility from
  // neighbouring pairs.
  uint64_t unmet_pairs = 0;
  double largest_unmet_error = 0;  // of their form factors from the smaller id
  // No line found these pairs facing, though their unoccluded form factors are above 0. Their form factors are 0, and
  // largest_standard_error includes their standard errors.
  uint64_t unseen_pairs = 0;
  double largest_unseen_error = 0;
  uint64_t directed_pairs = 0, directed_directions = 0;  // pairs with directions of their own, and these directions
  uint64_t line_pairs = 0, lines = 0;                    // pairs with lines between them, and these lines
  // With 95 % confidence this bounds each form factor, from the smaller id, of pairs that no line hit. It is infinite
  // where unoccluded form factors leave no such pair.
  double unmet_bound = INFINITY;
};

// A LatticeSummary counts the windows of one resolution.
struct LatticeSummary {
  int resolution = 0;   // lattice spacings across the scene's diameter
  size_t windows = 0;   // 1 for the first, which is the whole scene
  size_t polygons = 0;  // number of polygons in them
};

// GuaranteeFigures are the numbers of directions and blocks of a guarantee, and the bounds and range they rest on.
struct GuaranteeFigures {
  double epsilon = 0, delta = 0;
  double bounds = 0;         // m: number of bounds that have to hold at once
  double range = 0;          // lattices were planned to keep M below this limit
  double largest_range = 0;  // M: the most that a direction adds to a form factor
  uint64_t hoeffding = 0;    // directions after which Hoeffding's bound is epsilon
  uint32_t block_directions = 0;
  uint64_t least_blocks = 0;              // after fewer blocks Bernstein's bound is above epsilon
  uint64_t most_blocks = 0;               // Hoeffding's bound is epsilon after these blocks
  uint64_t expected_blocks = 0;           // an estimate, from a pilot
  double lemma_1 = 0, lemma_1_all = 0;    // directions by Pellegrini's Lemma 1: for one pair; for m bounds at once
  uint64_t runs = 0, run_directions = 0;  // of Statistic::median: runs, and directions of each
  double least_seconds = 0, expected_seconds = 0, most_seconds = 0;  // estimates
};

// LineGuaranteeFigures are the numbers of lines of a guarantee by pair lines.
struct LineGuaranteeFigures {
  double epsilon = 0, delta = 0;
  uint64_t exact = 0;    // entries that nothing can block
  uint64_t bounded = 0;  // entries whose geometry alone bounds the error to epsilon
  uint64_t drawn = 0;    // entries that need lines for such a bound
  double expected_lines = 0, most_lines = 0;
  double most_for_one = 0;                       // lines of the entry that needs most
  std::pair<std::string, std::string> neediest;  // that entry's ids by name; the second may be "leak"
  double lemma_1 = 0, lemma_1_all = 0;  // directions by Pellegrini's Lemma 1: for one pair, and for all entries
  double median_directions = 0;         // directions of Statistic::median, for all entries
  double plan_seconds = 0, expected_seconds = 0, most_seconds = 0;
  // Predicted costs of whole runs, from the program's start to the result: with this guarantee, and with an estimate of
  // the same largest error. Seconds of one thread, from numbers of pairs and lines alone: the same on every machine.
  double cost = 0, estimate_cost = 0;
  // Pairs with a smaller unoccluded form factor get no lines: common directions count them, and 0 is within epsilon of
  // their form factors.
  double least_form_factor = 0;
};

// A PairLinesSummary counts pairs of polygons with an unoccluded form factor above 0. Pairs that a single blocker hides
// are left out.
struct PairLinesSummary {
  uint64_t clear = 0;     // pairs that nothing can block: their form factors are the unoccluded ones
  uint64_t partial = 0;   // pairs that get lines
  uint64_t lines = 0;     // of these pairs, in all replicates of the request
  uint64_t blockers = 0;  // number of blockers, after joining neighbouring polygons
  double seconds = 0;     // spent on finding the pairs and planning their lines
  // Pairs with a smaller unoccluded form factor, from the smaller polygon, are counted by common directions or by rays.
  // With 1 all pairs are: between surfaces, where rays take less time than finding the pairs.
  double least_form_factor = 0;
  // Whether each polygon has rays of its own. They see what leaves the scene and what ends on backs, and count the
  // pairs below least_form_factor. PlanSummary::directions then is the largest number of rays of a polygon in a
  // replicate, and Estimate::directions that times the replicates. After the planned replicates only rows whose
  // environment or leak misses the goal have rays, unless the goal is an rms error, or rays count pairs between
  // surfaces.
  bool has_rays = false;
};

// A PlanSummary says what a run will do, and which error and time are expected.
struct PlanSummary {
  // A GoalCost says how much a goal would take.
  struct GoalCost {
    double standard_error;       // of the goal
    double replicates, seconds;  // predicted: errors fall with the root of the number of replicates
  };
  EngineKind engine = EngineKind::host;
  std::string device;  // name; "processor", or "none" for exact areas
  Sampling sampling = Sampling::lattice;
  std::string sampler;  // how directions are drawn, in words
  bool unoccluded = false;
  uint32_t directions = 0;               // of a replicate
  std::vector<LatticeSummary> lattices;  // the whole scene's first
  int finest = 0;                        // least resolution around the polygon that needs the finest; 0: no windows
  double seconds = 0;                    // of counting all replicates of the request, predicted; 0 without a plan
  double standard_error = 0;  // largest over all form factors, or of its form factor for a relative goal; predicted
  double pilot_seconds = 0;   // spent on pilots; 0 without a plan
  double plan_seconds = 0;    // spent on the whole plan; with pair lines it includes finding the pairs
  // Where the request's number of replicates misses the goal, this predicts what the goal takes.
  std::optional<GoalCost> goal_beyond_request;
  // These rows are so small that even the finest lattice may miss them.
  std::vector<std::string> barely_covered;
  std::optional<GuaranteeFigures> guarantee;
  std::optional<PairLinesSummary> pair_lines;
  std::optional<LineGuaranteeFigures> line_guarantee;
  // Whether the tolerance of an estimate is about the largest error, as with pair lines; else about standard errors.
  bool aims_at_largest_error = false;
  std::string no_promise;              // why the tolerance is estimated; empty where it is promised
  std::string no_pair_lines;           // of an estimate to a tolerance: why it has no pair lines; empty where it has
  uint64_t unoccluded_pairs = 0;       // of a guarantee: pairs with an unoccluded form factor
  uint64_t pairs_with_visibility = 0;  // of these pairs, with a visibility from a pilot
};

// Returns the program's options that give the same plan again: "--directions 64 --resolution 128 --unoccluded on".
//   In: plan: of an estimate, or of a promised tolerance ("--promise on")    Cost: O(1).
std::string optionsOf(const PlanSummary& plan);

// A PriorSummary says what pilots and unoccluded form factors found before the first replicate.
struct PriorSummary {
  uint64_t pairs = 0;          // of polygons, with unoccluded form factors
  uint64_t never_blocked = 0;  // number of these pairs that nothing blocked in the pilot
  // Pairs whose unoccluded form factors were not accurate enough; their form factors come from counts alone.
  uint64_t unreached = 0;
  uint64_t directed_pairs = 0,
           directed_directions = 0;  // directed pairs, and the directions that they have of their own in a replicate
  double pilot_seconds = 0, unoccluded_seconds = 0, directed_seconds = 0;
};

// A Closure says how far row sums are from 1, over the requested rows.
struct Closure {
  double largest_error = 0;
  double standard_error = 0;  // of the row sum with the largest error
  double rms_error = 0;
  std::string row;  // with the largest error
};

// Measures the closure of form factors.    Cost: O(rows).
Closure measureClosure(const FormFactors& form_factors);

// StandardErrors are taken over all nonzero form factors of the requested rows, in both directions of a pair.
struct StandardErrors {
  size_t count = 0;  // number of form factors
  double rms = 0;
  // Root mean square of the errors in sums (FormFactors::Entry) of all form factors between rows, the zero ones
  // included, as RootMeanSquare has it.
  double rms_with_zeros = 0;
  std::vector<std::pair<uint32_t, uint32_t>> worst;  // from, to; the largest first
};

// Measures standard errors.    In: worst: number of pairs to name    Cost: O(entries).
StandardErrors measureStandardErrors(const FormFactors& form_factors, size_t worst);

// A Result is all that one call finds.
struct Result : Estimate {
  // True if the goal was reached, false if time ran out or the run was stopped. Any run that was not stopped reaches a
  // goal in seconds; an exact amount is reached by its last replicate.
  bool goal_reached = false;
  Closure closure;                              // of form_factors
  double environment_share = 0;                 // share of the radiation from requested rows that leaves the scene
  double leak_share = 0;                        // share that ends on backs of polygons
  std::optional<BalancedFormFactors> balanced;  // with Request::balance
  std::optional<Error> balance_refusal;         // why `balanced` is missing
  // Each warning is one line. It names faces that look the wrong way, judged by their leaks unless the run was stopped,
  // or a promise that the run could not keep.
  std::vector<std::string> warnings;
  PlanSummary plan;
  std::string division;      // a few lines about the engine's work and memory
  std::optional<Work> work;  // with Request::measure_work, of engines that count theirs
  double seconds = 0;        // since the plan began
};

}  // namespace viewpeel

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
  double epsilon = 0, delta = 0;  // delta of the result: 0 where geometry alone proves it
  double bound = 0;               // on the error of form factors between ids
  GuaranteedBy by = GuaranteedBy::hoeffding;
  double row_bound = 0;  // on that of the environment's; `bound` holds for it, too, unless `by` is chernoff
};

// An Estimate is made of the sums of some replicates.
struct Estimate {
  FormFactors form_factors;
  FormFactors between_surfaces;  // the same counts summed by surface
  uint64_t replicates = 0;
  uint64_t directions = 0;  // in all, without directions of directed pairs
  double largest_standard_error = 0;
  double largest_relative_error = 0;  // over form factors of at least relative_floor
  // An interrupted run may not have reached its goal. Standard errors are infinite with fewer than 2 replicates.
  bool interrupted = false;
  std::optional<Guarantee> guarantee;
  // These pairs of ids can see each other by their unoccluded form factors, and no line hit them. Their visibilities
  // are their neighbours'.
  uint64_t unmet_pairs = 0;
  double largest_unmet_error = 0;  // standard error, from the smaller of the two
  // These pairs would see each other with nothing in between, but no line found them facing. Their form factors are 0,
  // and largest_standard_error takes in their standard errors.
  uint64_t unseen_pairs = 0;
  double largest_unseen_error = 0;
  uint64_t directed_pairs = 0, directed_directions = 0;  // pairs with directions of their own, and all these directions
  uint64_t line_pairs = 0, lines = 0;                    // pairs with lines between them alone, and all these lines
  // Each form factor of a pair without a line is below this bound, from the smaller of its pair, with 95 % confidence.
  // It is infinite where unoccluded form factors of all pairs leave no such pair.
  double unmet_bound = INFINITY;
};

// A LatticeSummary counts the windows of one resolution.
struct LatticeSummary {
  int resolution = 0;   // lattice spacings across the scene's diameter
  size_t windows = 0;   // 1 for the first, which is the whole scene
  size_t polygons = 0;  // that have it
};

// GuaranteeFigures are the numbers of directions and blocks of a guarantee, and the bounds and range they rest on.
struct GuaranteeFigures {
  double epsilon = 0, delta = 0;
  double bounds = 0;         // m: all of them have to hold at once
  double range = 0;          // the lattices were made for it
  double largest_range = 0;  // M: the most that a direction adds to a form factor
  uint64_t hoeffding = 0;    // directions
  uint32_t block_directions = 0;
  uint64_t least_blocks = 0;              // Bernstein's bound cannot be epsilon before these blocks
  uint64_t most_blocks = 0;               // Hoeffding's bound is epsilon after these blocks
  uint64_t expected_blocks = 0;           // an estimate, from a pilot
  double lemma_1 = 0, lemma_1_all = 0;    // directions of Pellegrini's Lemma 1: for one pair, and for m bounds at once
  uint64_t runs = 0, run_directions = 0;  // of the median
  double least_seconds = 0, expected_seconds = 0, most_seconds = 0;  // estimates
};

// LineGuaranteeFigures are the numbers of lines of a guarantee by pair lines.
struct LineGuaranteeFigures {
  double epsilon = 0, delta = 0;
  uint64_t exact = 0;    // entries that nothing can block
  uint64_t bounded = 0;  // entries that geometry bounds to epsilon
  uint64_t drawn = 0;    // entries that need lines for this
  double expected_lines = 0, most_lines = 0;
  double most_for_one = 0;                       // entry
  std::pair<std::string, std::string> neediest;  // the names of its ids; the second may be "leak"
  double lemma_1 = 0, lemma_1_all = 0;  // directions of Pellegrini's Lemma 1: for one pair, and for all entries
  double median_directions = 0;         // of the median of runs (section 5.3), for all entries
  double plan_seconds = 0, expected_seconds = 0, most_seconds = 0;
  // What this and an estimate of the same largest error cost, about: seconds of one thread, from numbers of pairs and
  // lines alone, so that they are the same on every machine.
  double cost = 0, estimate_cost = 0;
  // Pairs below this unoccluded form factor are left to common directions: they are within epsilon without lines.
  double least_form_factor = 0;
};

// A PairLinesSummary counts pairs of polygons that see each other with nothing in between, but for pairs that one
// blocker hides.
struct PairLinesSummary {
  uint64_t clear = 0;     // pairs that nothing can block: their form factors are the unoccluded ones
  uint64_t partial = 0;   // pairs that get lines
  uint64_t lines = 0;     // of these pairs, in all replicates of the request
  uint64_t blockers = 0;  // all polygons were joined to so many
  double seconds = 0;     // spent on finding the pairs and planning their lines
};

// A PlanSummary says what a run will do, and which error and time are expected.
struct PlanSummary {
  // A GoalCost says what the goal takes.
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
  int finest = 0;                        // resolution that the neediest polygon gets, at least
  double seconds = 0;                    // of counting all replicates of the request, predicted; 0 without a plan
  double standard_error = 0;  // largest over all form factors, or of its form factor for a relative goal; predicted
  double pilot_seconds = 0;   // spent on pilots; 0 without a plan
  // A goal that the request's number of replicates misses by the prediction takes so much.
  std::optional<GoalCost> goal_beyond_request;
  // These rows are so small that even the finest lattice may miss them.
  std::vector<std::string> barely_covered;
  std::optional<GuaranteeFigures> guarantee;
  std::optional<PairLinesSummary> pair_lines;
  std::optional<LineGuaranteeFigures> line_guarantee;
  std::string no_promise;              // why form factors are estimates; empty where they have a guarantee
  uint64_t unoccluded_pairs = 0;       // of a guarantee: pairs with an unoccluded form factor
  uint64_t pairs_with_visibility = 0;  // of these pairs, with a visibility from a pilot
};

// Returns the program's options that give the same plan again: "--directions 64 --resolution 128 --unoccluded on".
//   In: a plan of a result, of no guarantee but a promised tolerance ("--promise on")    Cost: O(1).
std::string optionsOf(const PlanSummary& plan);

// A PriorSummary says what pilots and unoccluded form factors found before the first replicate.
struct PriorSummary {
  uint64_t pairs = 0;          // of polygons, with unoccluded form factors
  uint64_t never_blocked = 0;  // of these pairs, in the pilot
  // These pairs are left to sampling alone, as their unoccluded form factors were not accurate enough.
  uint64_t unreached = 0;
  uint64_t directed_pairs = 0,
           directed_directions = 0;  // pairs with directions of their own, and directions of a replicate
  double pilot_seconds = 0, unoccluded_seconds = 0, directed_seconds = 0;
};

// A Closure says how far row sums are from 1, over the rows of the request.
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
  size_t count = 0;  // of form factors
  double rms = 0;
  std::vector<std::pair<uint32_t, uint32_t>> worst;  // from, to; the largest first
};

// Measures standard errors.    In: worst: how many pairs with large ones to name    Cost: O(entries).
StandardErrors measureStandardErrors(const FormFactors& form_factors, size_t worst);

// A Result holds all that one call finds.
struct Result : Estimate {
  // True if the goal was reached; false if time was up before, or the run was stopped. A goal in seconds is reached by
  // every run that was not stopped, an exact amount by its last replicate.
  bool goal_reached = false;
  Closure closure;               // of form_factors
  double environment_share = 0;  // of the radiation of the request's rows, the part that leaves the scene
  double leak_share = 0;         // and the part that ends on the backs of polygons
  std::optional<BalancedFormFactors> balanced;  // with Request::balance
  std::optional<Error> balance_refusal;         // why there are none
  // Each warning is one line: faces that look the wrong way, by their leaks (a run that was stopped has none), and a
  // promise of the plan that the run could not keep.
  std::vector<std::string> warnings;
  PlanSummary plan;
  std::string division;      // a few lines about the engine's work and memory
  std::optional<Work> work;  // with Request::measure_work, of engines that count theirs
  double seconds = 0;        // from the plan's beginning
};

}  // namespace viewpeel

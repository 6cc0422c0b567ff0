// What comes out: form factors with their errors, and how they were found.
#pragma once
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <viewpeel/balance.h>
#include <viewpeel/engine.h>
#include <viewpeel/error.h>
#include <viewpeel/form_factors.h>
#include <viewpeel/sampling.h>

namespace viewpeel {

enum class GuaranteedBy { hoeffding, bernstein, median };

// What holds of all form factors at once, with probability 1 - delta.
struct Guarantee {
  double epsilon = 0, delta = 0;
  double bound = 0;  // on the error, at most epsilon
  GuaranteedBy by = GuaranteedBy::hoeffding;
};

// What the sums of some replicates come to.
struct Estimate {
  FormFactors form_factors;
  FormFactors between_surfaces;  // the same counts summed by surface
  uint64_t replicates = 0;
  uint64_t directions = 0;  // in all, those of directed pairs not counted
  double largest_standard_error = 0;
  double largest_relative_error = 0;  // over form factors of at least relative_floor
  bool interrupted =
      false;  // goals may not be reached; standard errors are infinite where fewer than 2 replicates are done
  std::optional<Guarantee> guarantee;
  // Pairs of ids that can see each other by their unoccluded form factors and that no line met: their visibilities are
  // their neighbours'.
  uint64_t unmet_pairs = 0;
  double largest_unmet_error = 0;  // standard error, from the smaller of the two
  // Pairs that can see each other and were never seen: form factors of 0, whose standard errors count among the
  // largest.
  uint64_t unseen_pairs = 0;
  double largest_unseen_error = 0;
  uint64_t directed_pairs = 0, directed_directions = 0;  // pairs with directions of their own, and all of these
  uint64_t line_pairs = 0, lines = 0;                    // pairs with lines between them alone, and all of these
  // On each form factor that no line met, from the smaller of its pair, with 95 % confidence; infinite where closed
  // forms of all pairs leave none to be met.
  double unmet_bound = INFINITY;
};

// Windows of one resolution.
struct LatticeSummary {
  int resolution = 0;   // lattice spacings across the scene's diameter
  size_t windows = 0;   // 1 for the first, which is the whole scene
  size_t polygons = 0;  // that have it
};

// What a guarantee takes: numbers of directions and blocks, and what they rest on.
struct GuaranteeFigures {
  double epsilon = 0, delta = 0;
  double bounds = 0;         // m: how many have to hold at once
  double range = 0;          // that lattices were made for
  double largest_range = 0;  // M: the most that a direction adds to a form factor
  uint64_t hoeffding = 0;    // directions
  uint32_t block_directions = 0;
  uint64_t least_blocks = 0;              // before which Bernstein's bound cannot be epsilon
  uint64_t most_blocks = 0;               // that Hoeffding's asks for
  uint64_t expected_blocks = 0;           // an estimate, from a pilot
  double lemma_1 = 0, lemma_1_all = 0;    // directions of Pellegrini's Lemma 1: for one pair, and for m bounds at once
  uint64_t runs = 0, run_directions = 0;  // of the median
  double least_seconds = 0, expected_seconds = 0, most_seconds = 0;  // estimates
};

// Pairs of polygons that see each other with nothing in between, but for those that one blocker hides.
struct PairLinesSummary {
  uint64_t clear = 0;     // pairs that nothing can block: their form factors are the unoccluded ones
  uint64_t partial = 0;   // pairs that get lines
  uint64_t lines = 0;     // of these pairs, in the replicates asked for
  uint64_t blockers = 0;  // that all polygons were joined to
  double seconds = 0;     // spent on finding the pairs and planning their lines
};

// What a run will do, and what it expects.
struct PlanSummary {
  EngineKind engine = EngineKind::host;
  std::string device;  // name; "processor", or "none" for exact areas
  Sampling sampling = Sampling::lattice;
  std::string sampler;  // how directions are drawn, in words
  bool unoccluded = false;
  uint32_t directions = 0;               // of a replicate
  std::vector<LatticeSummary> lattices;  // the whole scene's first
  int finest = 0;                        // resolution that the neediest polygon gets, at least
  double seconds = 0;                    // of counting the replicates asked for, predicted; 0 where nothing was planned
  double standard_error = 0;  // largest over all form factors, or of its form factor for a relative goal; predicted
  double pilot_seconds = 0;   // spent on finding out; 0 where nothing was planned
  std::vector<std::string> barely_covered;  // rows so small that even the finest lattice may not meet them
  std::optional<GuaranteeFigures> guarantee;
  std::optional<PairLinesSummary> pair_lines;
  uint64_t unoccluded_pairs = 0;       // of a guarantee: pairs with an unoccluded form factor
  uint64_t pairs_with_visibility = 0;  // of these, with a visibility from a pilot
};

// The program's options that give the same plan again: "--directions 64 --resolution 128 --unoccluded on". Not of a
// guarantee.
//   In: a plan of a result    Cost: O(1).
std::string optionsOf(const PlanSummary& plan);

// What pilots and unoccluded form factors found before the first replicate.
struct PriorSummary {
  uint64_t pairs = 0;          // of polygons, with unoccluded form factors
  uint64_t never_blocked = 0;  // of these, in the pilot
  uint64_t unreached = 0;  // pairs left to sampling alone, as their unoccluded form factors were not accurate enough
  uint64_t directed_pairs = 0, directed_directions = 0;  // pairs with directions of their own, and these in a replicate
  double pilot_seconds = 0, unoccluded_seconds = 0, directed_seconds = 0;
};

// All that one call finds.
struct Result : Estimate {
  double environment_share = 0;                 // of all that the rows asked for emit, what leaves the scene
  double leak_share = 0;                        // and what ends on the backs of polygons
  std::optional<BalancedFormFactors> balanced;  // with Request::balance
  std::optional<Error> balance_refusal;         // why there are none
  std::vector<std::string>
      warnings;  // one line each: faces that look the wrong way, as leaks tell; not of a run that was stopped
  PlanSummary plan;
  std::string division;      // how the engine has divided its work and what memory that takes, a few lines
  std::optional<Work> work;  // with Request::measure_work, of engines that count theirs
  double seconds = 0;        // from the plan's beginning
};

}  // namespace viewpeel

#include <fmt/format.h>

#include "run/rules.h"
#include <viewpeel/error.h>
#include <viewpeel/balance.h>

namespace viewpeel {
namespace {

// Returns whether an engine may go with pair lines by default.
bool goesWithPairLines(EngineKind engine) {
  return engine == EngineKind::automatic || engine == EngineKind::host || engine == EngineKind::compute;
}

}  // namespace

bool mayUseUnoccluded(const Request& request) {
  const auto* guarantee = std::get_if<EpsilonDelta>(&request.goal);
  return request.engine != EngineKind::graphics && request.engine != EngineKind::exact &&
         request.question.isEverything() &&
         (!guarantee || (request.by == By::polygon && guarantee->statistic == Statistic::mean));
}

bool mayUsePairLines(const Request& request) {
  const auto* guarantee = std::get_if<EpsilonDelta>(&request.goal);
  const Amount amount = amountOf(request);
  // Parts of a run must have one plan, which measured times must not decide.
  const bool is_timed = std::holds_alternative<Seconds>(request.goal) && !amount.is_exact && !request.first_replicate;
  const bool has_goal =
      is_timed || std::holds_alternative<Tolerance>(request.goal) || std::holds_alternative<Relative>(request.goal) ||
      std::holds_alternative<RootMeanSquare>(request.goal) ||
      (guarantee && guarantee->statistic == Statistic::mean && !(guarantee->range > 0) && !guarantee->block_directions);
  return request.engine != EngineKind::exact && has_goal && !amount.directions;
}

std::string optionAgainstPairLines(const Request& request) {
  if (!request.pair_lines.value_or(true)) return "--pair-lines off";
  if (request.unoccluded) return "--unoccluded";
  if (request.sampling) return "--sampling";
  if (request.sampler) return "--sampler";
  const Amount amount = amountOf(request);
  if (amount.directions) return "--directions";
  if (amount.resolution) return "--resolution";
  const bool is_guarantee = std::holds_alternative<EpsilonDelta>(request.goal);
  const bool has_lines = is_guarantee ? request.engine != EngineKind::exact : goesWithPairLines(request.engine);
  return has_lines ? "" : "--engine";
}

std::string optionAgainstPromise(const Request& request) {
  const auto* tolerance = std::get_if<Tolerance>(&request.goal);
  if (std::holds_alternative<Seconds>(request.goal) || request.time_limit_s) return "--seconds";
  if (std::holds_alternative<Relative>(request.goal) || (tolerance && tolerance->relative)) return "--relative";
  if (std::holds_alternative<RootMeanSquare>(request.goal)) return "--rms";
  const Amount amount = amountOf(request), usual;
  if (amount.is_exact || request.first_replicate) return "--first-replicate or --part";
  if (amount.directions) return "--directions";
  if (amount.resolution) return "--resolution";
  if (amount.replicates != usual.replicates) return "--replicates";
  if (request.sampler) return "--sampler";
  if (request.sampling) return "--sampling";
  if (request.unoccluded) return "--unoccluded";
  if (request.pair_lines && !(*request.pair_lines && request.promise)) return "--pair-lines";
  if (!goesWithPairLines(request.engine)) return "--engine";
  return request.promise.value_or(true)
             ? ""
             : "--promise off, --replicates or --checkpoint";  // for the last two the program sets promise to false
}

void checkRequest(const Request& request) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorCode::bad_usage, message); };
  requireNumbers(request);
  const Amount amount = amountOf(request);
  if (amount.finest && amount.finest < amount.resolution)
    refuse(fmt::format(
        "--finest {} is coarser than --resolution {}, which all polygons get; give a finer one, or leave it out",
        amount.finest, amount.resolution));
  if (amount.finest && (!amount.directions || !amount.resolution))
    refuse("--finest needs --directions and --resolution");
  if (request.unoccluded.value_or(false) && !mayUseUnoccluded(request))
    refuse(
        "--unoccluded on needs the whole matrix and --engine compute or host; of a guarantee also --by polygon and "
        "--statistic mean");
  if (request.pair_lines.value_or(false)) {
    if (!mayUsePairLines(request))
      refuse(
          "--pair-lines on needs a goal by --tolerance, --relative, --rms, --seconds or --epsilon, and any engine but "
          "exact; leave out --directions, --statistic median, --range and --block, and give parts a tolerance");
    if (request.unoccluded.has_value())
      refuse("--pair-lines on always takes unoccluded form factors; leave out --unoccluded");
  }
  if (std::holds_alternative<RootMeanSquare>(request.goal) &&
      (request.by == By::surface || !request.question.isEverything()))
    refuse("--rms is over all polygons; leave out --by surface, --from, --pair and --blocker, or give a --tolerance");
  if (request.balance && !request.question.isEverything()) refuse(kBalanceNeedsEveryRow);
  if (request.promise) {
    if (std::holds_alternative<EpsilonDelta>(request.goal))
      refuse("--epsilon is a promise by itself; leave out --promise, or ask for an estimate by --tolerance");
    if (const std::string against = optionAgainstPromise(request); *request.promise && !against.empty())
      refuse(fmt::format("--promise on needs a goal by --tolerance alone; leave out {}", against));
  }
  if (request.engine == EngineKind::exact && !request.exact_engine)
    refuse("there is no exact engine in this library; set Request::exact_engine, or take another engine");
  const auto* guarantee = std::get_if<EpsilonDelta>(&request.goal);
  if (request.engine == EngineKind::exact && (amount.resolution || (guarantee && guarantee->range > 0)))
    refuse("--engine exact has no lattice; leave out --resolution and --range");
  if (!guarantee) return;
  if (!(guarantee->epsilon > 0 && guarantee->epsilon < 1 && guarantee->delta >= 0 && guarantee->delta < 1))
    refuse("--epsilon has to lie between 0 and 1, --delta from 0 to below 1");
  if (guarantee->delta == 0 && (!mayUsePairLines(request) || !request.pair_lines.value_or(true)))
    refuse(
        "--delta 0 needs a guarantee by pair lines; leave out --pair-lines off, --statistic, --range, --block and "
        "--engine exact");
  if (amount.directions || amount.finest || amount.is_exact || request.first_replicate)
    refuse(
        "a guarantee plans for itself: leave out --tolerance, --relative, --directions, --finest, --replicates, "
        "--part and --first-replicate");
  if (amount.resolution && guarantee->range > 0)
    refuse("--range chooses the --resolution of a guarantee; give one of the two");
  if (guarantee->statistic == Statistic::median && guarantee->block_directions)
    refuse("--statistic median has runs, not blocks; leave out --block");
}

}  // namespace viewpeel

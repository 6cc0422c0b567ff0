#include "program/request_options.h"

#include <charconv>

#include "program/warnings.h"
#include <viewpeel/error.h>
#include "reference/exact/exact_engine.h"
#include "scene/read_groups.h"

namespace viewpeel::program {
namespace {

std::string isPositive(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value)
             ? ""
             : text + " is not a number above 0";
}

void addGoalOptions(CLI::App* command, const std::shared_ptr<RequestOptions>& options) {
  const auto addGoal = [&](const std::string& name, std::optional<double>& goal, const std::string& text,
                           const std::string& type) {
    command
        ->add_option_function<double>(
            name, [&goal](const double& value) { goal = value; }, text)
        ->type_name(type)
        ->check(isPositive);
  };
  addGoal("--tolerance", options->tolerance,
          "For daily work: the largest error of all form factors is about this. Where they are sampled by directions "
          "alone, their largest standard error is at most this. 1e-3 unless another goal or --directions is given",
          "T");
  command
      ->add_option_function<std::string>(
          "--promise", [options](const std::string& word) { options->request.promise = word == "on"; },
          "Promise the --tolerance: every form factor within it with probability 0.99, and in an interval. By default "
          "a promise is made where the run costs at most twice an estimate, or half a second of CPU time")
      ->type_name("on|off")
      ->check(isOneOf("on|off"));
  addGoal("--relative", options->relative,
          "Go on until the largest standard error is at most this share of its form factor, over those above --floor",
          "R");
  command->add_option("--floor", options->request.relative_floor, "Least form factor that --relative looks at")
      ->type_name("F")
      ->check(isPositive)
      ->check([](const std::string& text) { return isNumber(text, 0, 1); })
      ->capture_default_str();
  addGoal("--rms", options->rms,
          "For sums of many form factors: the root mean square of the errors of all pairs is at most this, "
          "whatever the largest error",
          "R");
  addGoal("--seconds", options->seconds,
          "For limited time: errors as small as this time allows; with a goal: stop short of it when time is up. A run "
          "has 2 replicates at least",
          "S");
  addGoal(
      "--epsilon", options->epsilon,
      "For a bound to cite: every form factor between rows within E with probability 1 - D, each entry in an interval; "
      "see --delta and --rows",
      "E");
  EpsilonDelta& guarantee = options->guarantee;
  command
      ->add_option("--delta", guarantee.delta,
                   "Probability with which a guarantee may fail; 0: intervals that geometry alone proves")
      ->type_name("D")
      ->check([](const std::string& text) { return text == "0" ? std::string() : isPositive(text); })
      ->capture_default_str();
  command->add_flag("--rows", guarantee.rows, "Guarantee the environment of each row, too");
  command
      ->add_option("--range", guarantee.range,
                   "Of a guarantee: lattices so fine that a direction adds at most about this to a form factor; chosen")
      ->type_name("M")
      ->check(CLI::Range(2.001, 100.0).description(""));
  command->add_option("--block", guarantee.block_directions, "Of a guarantee: directions of a block; chosen")
      ->type_name("N")
      ->transform(isWholeNumberFrom(1, 1u << 16));
  addChoice(command, "--statistic", guarantee.statistic, {{"mean", Statistic::mean}, {"median", Statistic::median}},
            "Of a guarantee: the mean of jittered directions, or the median of runs of independent ones");
}

void addAmountOptions(CLI::App* command, Amount& amount) {
  command->add_option("--directions", amount.directions, "Directions per replicate, in place of a plan")
      ->type_name("N")
      ->transform(isWholeNumberFrom(1, 1u << 30));
  command
      ->add_option("--replicates", amount.replicates,
                   "Independent replicates, at least; their spread gives the standard errors")
      ->type_name("R")
      ->transform(isWholeNumberFrom(2, 1u << 30))
      ->capture_default_str();
  command
      ->add_option("--resolution", amount.resolution,
                   "Lattice spacings across the scene's diameter; planned, or 64 with --directions")
      ->type_name("PX")
      ->transform(isWholeNumberFrom(1, kMaxResolution));
  command
      ->add_option("--finest", amount.finest,
                   "With --directions and --resolution: spacings for the polygon that needs most of them, in windows; "
                   "the others get their share")
      ->type_name("PX")
      ->transform(isWholeNumberFrom(1, kMaxWindowResolution));
}

void addMethodOptions(CLI::App* command, const std::shared_ptr<RequestOptions>& options) {
  Request& request = options->request;
  startGroup(command, kMachine);
  addChoice(command, "--engine", request.engine,
            {{"auto", EngineKind::automatic},
             {"compute", EngineKind::compute},
             {"host", EngineKind::host},
             {"graphics", EngineKind::graphics},
             {"exact", EngineKind::exact}},
            "Depth peeling on a Vulkan device, in compute shaders or by its raster pipeline; the same counts on the "
            "processor's threads (host); or exact areas there. "
            "auto: compute on a GPU, or on the --device named, else host");
  startGroup(command, kMethod);
  addChoice<std::optional<Sampling>>(
      command, "--sampling", request.sampling,
      {{"auto", std::nullopt}, {"lattice", Sampling::lattice}, {"scanline", Sampling::scanline}},
      "Samples of a direction: lattice points, or lattice rows cut where polygons end. auto: the quicker ones for the "
      "engine and scene");
  addChoice<std::optional<Sampler>>(command, "--sampler", request.sampler, {kSamplerNames.begin(), kSamplerNames.end()},
                                    "Directions over the sphere: rotated Fibonacci sets, one in each of as many cells, "
                                    "scrambled Sobol' points, or independent. Without it --from and "
                                    "--pair draw better ones");
  command
      ->add_option_function<std::string>(
          "--unoccluded,--closed-forms",
          [options](const std::string& word) { options->request.unoccluded = word == "on"; },
          "Sample only the visibility of a pair, the share of its lines that nothing blocks, and integrate its "
          "unoccluded "
          "form factor; --closed-forms is its older name. By default planned runs do so where they can")
      ->type_name("on|off")
      ->check(isOneOf("on|off"));
  command
      ->add_option_function<std::string>(
          "--pair-lines", [options](const std::string& word) { options->request.pair_lines = word == "on"; },
          "Draw lines between the two polygons of each pair that something may block, as many as its error asks for, "
          "in "
          "place of directions for all pairs. By default planned runs do so where it is quicker")
      ->type_name("on|off")
      ->check(isOneOf("on|off"));
}

void addQuestionOptions(CLI::App* command, Request& request) {
  Question& question = request.question;
  addChoice(command, "--by", request.by, {{"polygon", By::polygon}, {"surface", By::surface}},
            "One row per polygon or per named surface");
  command->add_option("--from", question.from, "Only the rows of this surface or face")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command->add_option("--pair", question.pair, "Only the form factors between two surfaces or faces")
      ->type_name("A B")
      ->expected(0, 2);
  command->add_option("--blocker", question.blockers, "A surface or face that only blocks")
      ->type_name("NAME")
      ->allow_extra_args(false);
}

}  // namespace

std::shared_ptr<RequestOptions> addRequestOptions(CLI::App* command) {
  auto options = std::make_shared<RequestOptions>();
  Request& request = options->request;
  command->add_option("SCENE", options->scene, kSceneText)->required();
  startGroup(command, kHowExact);
  addGoalOptions(command, options);
  startGroup(command, kMethod);
  addAmountOptions(command, request.amount);
  startGroup(command, kWhat);
  addQuestionOptions(command, request);
  addSceneOptions(command, request.scene_options);
  addGroupsOption(command, options->groups);
  addMethodOptions(command, options);
  startGroup(command, kLongRuns);
  CLI::Option* first =
      command
          ->add_option("--first-replicate", request.first_replicate,
                       "Count exactly --replicates from this one on: a part of a run, for viewpeel merge")
          ->type_name("K")
          ->transform(isWholeNumberFrom(0, uint64_t(1) << 39))
          ->capture_default_str();
  command
      ->add_option("--part", options->part,
                   "Count part K of N of a run, exactly --replicates each, whatever the goal: for viewpeel merge")
      ->type_name("K/N")
      ->excludes(first);
  startGroup(command, kMethod);
  command->add_option("--seed", request.seed, "The same seed and plan give the same bits")
      ->type_name("K")
      ->check(isWholeNumber)
      ->capture_default_str();
  startGroup(command, kWhat);
  command->add_flag("--two-sided", request.two_sided, "Every polygon emits and receives on both sides");
  startGroup(command, kMachine);
  addThreadsOption(command);
  command->add_option("--device", request.device.selector, "Vulkan device: index, part of its name, cpu or gpu")
      ->type_name("DEVICE");
  command
      ->add_option("--batch", request.batch_directions,
                   "Directions peeled at once; 0 chooses. Never changes the result")
      ->type_name("N")
      ->capture_default_str();
  return options;
}

namespace {

// Sets the replicates of part K of N, so that parts follow one another without a gap.
void choosePart(const std::string& text, Request& request) {
  uint32_t part = 0, parts = 0;
  const char* const end = text.data() + text.size();
  const auto [slash, failure] = std::from_chars(text.data(), end, part);
  const bool has_slash = failure == std::errc() && slash != end && *slash == '/';
  const auto rest = has_slash ? std::from_chars(slash + 1, end, parts) : std::from_chars_result{};
  constexpr uint32_t kMostParts = 1'000'000;
  if (!has_slash || rest.ec != std::errc() || rest.ptr != end || part < 1 || part > parts || parts > kMostParts)
    throw Error(ErrorCode::bad_usage,
                fmt::format("--part: '{}' is not a part like 2/8, from 1/N to N/N with N up to {}", text, kMostParts));
  request.first_replicate = uint64_t(part - 1) * request.amount.replicates;
  request.amount.is_exact = true;
}

}  // namespace

Request requestOf(const CLI::App* command, const RequestOptions& options) {
  Request request = options.request;
  if (!options.part.empty()) choosePart(options.part, request);
  if (command->get_option("--first-replicate")->count()) request.amount.is_exact = true;
  const Amount& amount = request.amount;
  request.exact_engine = reference::exactEngines();
  for (const char* name : {"--delta", "--rows", "--statistic", "--range", "--block"})
    if (!options.epsilon && command->get_option(name)->count())
      throw Error(ErrorCode::bad_usage, fmt::format("{} belongs to a guarantee; give --epsilon, too", name));
  if (options.rms && (options.tolerance || options.relative || options.epsilon))
    throw Error(ErrorCode::bad_usage,
                "--rms is a goal of its own: leave out --tolerance, --relative and --epsilon, or leave it out");
  if (options.epsilon && (options.tolerance || options.relative || command->get_option("--replicates")->count()))
    throw Error(
        ErrorCode::bad_usage,
        "a guarantee plans for itself: leave out --tolerance, --relative, --directions, --finest, --replicates, "
        "--part and --first-replicate");
  request.time_limit_s = options.seconds;
  // A given number of replicates asks for an estimate, even where it is the default number.
  if (command->get_option("--replicates")->count() && !request.promise && !options.epsilon) request.promise = false;
  if (options.epsilon) {
    EpsilonDelta guarantee = options.guarantee;
    guarantee.epsilon = *options.epsilon;
    request.goal = guarantee;
  } else if (options.tolerance) {
    request.goal = Tolerance{*options.tolerance, options.relative};
  } else if (options.relative) {
    request.goal = Relative{*options.relative};
  } else if (options.rms) {
    request.goal = RootMeanSquare{*options.rms};
  } else if (options.seconds) {
    request.goal = Seconds{*options.seconds};
  } else if (amount.directions || request.engine == EngineKind::exact) {
    request.goal = FixedAmount{amount.directions ? amount.directions : FixedAmount{}.directions, amount.replicates,
                               amount.resolution, amount.finest};
  }
  checkRequest(request);
  return request;
}

Scene loadSceneOf(const std::vector<std::string>& files, const SceneOptions& options, const std::string& groups) {
  Scene scene = loadGroupedScene({files.begin(), files.end()}, groups, options);
  for (const std::string& warning : scene.warnings) warn(warning);
  return scene;
}

}  // namespace viewpeel::program

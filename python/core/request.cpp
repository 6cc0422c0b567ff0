// requestOf() makes a request of Python's keyword arguments.
#include "python/core/bindings.h"

#include <limits>
#include <type_traits>

#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel::python {
namespace {

// Says in words which values an argument of this type takes, for messages.
template <class T>
std::string expected() {
  if constexpr (std::is_same_v<T, bool>) return "True or False";
  else if constexpr (std::is_integral_v<T>)
    return fmt::format("a whole number from {} to {}", std::numeric_limits<T>::min(), std::numeric_limits<T>::max());
  else if constexpr (std::is_floating_point_v<T>) return "a number";
  else return "text, or a list of texts";
}

// Arguments set members of a request from keyword arguments that are present and not None.
class Arguments {
 public:
  explicit Arguments(const py::dict& arguments) : arguments_(arguments) {}

  template <class T>
  std::optional<T> find(const char* name) const {
    if (!arguments_.contains(name) || arguments_[name].is_none()) return std::nullopt;
    try {
      return arguments_[name].cast<T>();
    } catch (const py::cast_error&) {
      throw Error(ErrorCode::bad_usage,
                  fmt::format("{}: {} is not {}", name, std::string(py::repr(arguments_[name])), expected<T>()));
    }
  }
  template <class T>
  void set(const char* name, T& value) const {
    if (const std::optional<T> found = find<T>(name)) value = *found;
  }
  // Sets a value by one of a few words.
  template <class T, class Value>
  void choose(const char* name, Value& value, const std::vector<std::pair<const char*, T>>& choices) const {
    const std::optional<std::string> word = find<std::string>(name);
    if (!word) return;
    std::string words;
    for (const auto& [choice, meaning] : choices) {
      if (*word == choice) {
        value = meaning;
        return;
      }
      words += (words.empty() ? "" : ", ") + std::string(choice);
    }
    throw Error(ErrorCode::bad_usage, std::string(name) + ": '" + *word + "' is not one of " + words);
  }

 private:
  const py::dict& arguments_;
};

// Sets the goal as the program does: by the first of these arguments that is present.
void setGoal(const Arguments& arguments, Request& request) {
  const auto tolerance = arguments.find<double>("tolerance"), relative = arguments.find<double>("relative"),
             rms = arguments.find<double>("rms"), seconds = arguments.find<double>("seconds"),
             epsilon = arguments.find<double>("epsilon");
  request.time_limit_s = seconds;
  if (epsilon && (tolerance || relative))
    throw Error(ErrorCode::bad_usage, "a guarantee plans for itself: leave out tolerance and relative beside epsilon");
  if (rms && (tolerance || relative || epsilon))
    throw Error(ErrorCode::bad_usage, "rms is a goal of its own: leave out tolerance, relative and epsilon beside it");
  if (!epsilon && (arguments.find<double>("delta") || arguments.find<bool>("rows")))
    throw Error(ErrorCode::bad_usage, "delta and rows are of a guarantee; give its epsilon");
  if (epsilon) {
    EpsilonDelta guarantee{.epsilon = *epsilon};
    arguments.set("delta", guarantee.delta);
    arguments.set("rows", guarantee.rows);
    request.goal = guarantee;
  } else if (tolerance) {
    request.goal = Tolerance{*tolerance, relative};
  } else if (relative) {
    request.goal = Relative{*relative};
  } else if (rms) {
    request.goal = RootMeanSquare{*rms};
  } else if (seconds) {
    request.goal = Seconds{*seconds};
  } else if (request.amount.directions) {
    request.goal = FixedAmount{request.amount.directions, request.amount.replicates, request.amount.resolution,
                               request.amount.finest};
  }
}

}  // namespace

Request requestOf(const py::dict& given) {
  const Arguments arguments(given);
  Request request;
  arguments.choose<By>("by", request.by, {{"polygon", By::polygon}, {"surface", By::surface}});
  arguments.set("rows_of", request.question.from);
  arguments.set("pair", request.question.pair);
  arguments.set("blockers", request.question.blockers);
  arguments.set("two_sided", request.two_sided);
  arguments.set("directions", request.amount.directions);
  arguments.set("replicates", request.amount.replicates);
  arguments.set("resolution", request.amount.resolution);
  arguments.set("floor", request.relative_floor);
  setGoal(arguments, request);
  arguments.choose<Sampling>("sampling", request.sampling,
                             {{"lattice", Sampling::lattice}, {"scanline", Sampling::scanline}});
  arguments.choose<Sampler>("sampler", request.sampler, {kSamplerNames.begin(), kSamplerNames.end()});
  request.unoccluded = arguments.find<bool>("unoccluded");
  request.pair_lines = arguments.find<bool>("pair_lines");
  request.promise = arguments.find<bool>("promise");
  request.lines_for_all = arguments.find<bool>("lines_for_all").value_or(false);
  // A given number of replicates asks for an estimate, as in the program, even where it is the default number.
  const bool is_estimate = arguments.find<uint32_t>("replicates") && !request.promise;
  if (is_estimate && !std::holds_alternative<EpsilonDelta>(request.goal)) request.promise = false;
  arguments.choose<EngineKind>("engine", request.engine,
                               {{"auto", EngineKind::automatic},
                                {"compute", EngineKind::compute},
                                {"host", EngineKind::host},
                                {"graphics", EngineKind::graphics}});
  arguments.set("device", request.device.selector);
  arguments.set("threads", request.threads);
  arguments.set("seed", request.seed);
  arguments.set("balance", request.balance);
  checkRequest(request);
  return request;
}

}  // namespace viewpeel::python

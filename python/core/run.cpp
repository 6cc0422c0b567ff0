// Runs leave the interpreter's lock to other Python threads, while the calling thread waits, checks signals and shows
// progress.
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

#include "python/core/bindings.h"

#include <viewpeel/error.h>

namespace viewpeel::python {
namespace {

using namespace std::chrono_literals;
constexpr auto kBetweenTicks = 50ms;       // between two checks for signals
constexpr auto kBetweenCheckpoints = 30s;  // a killed run loses this time and a replicate at most

py::dict dictOf(const Progress& progress) {
  constexpr std::array kPhases = {"planning", "unoccluded", "counting"};  // in the order of Progress::Phase
  py::dict all;
  all["phase"] = kPhases.at(static_cast<size_t>(progress.phase));
  all["replicates"] = progress.replicates;
  all["largest_standard_error"] = progress.largest_standard_error;
  all["directions"] = progress.directions;
  all["directions_of_replicate"] = progress.directions_of_replicate;
  all["expected_blocks"] = progress.expected_blocks;
  all["most_blocks"] = progress.most_blocks;
  return all;
}

// A Watched is what the thread that computes and the thread that waits for it share.
struct Watched {
  std::atomic<bool> is_stopped = false;
  std::mutex mutex;  // protects the members below
  std::condition_variable ended;
  bool has_ended = false;
  Progress progress;
  std::exception_ptr failure;
};

// Calls Python's handlers of signals, and `tick`.    Out: the exception that either raised
std::optional<py::error_already_set> look(const Progress& progress, const py::object& tick) {
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!tick.is_none()) tick(dictOf(progress));
  } catch (py::error_already_set& error) {
    return std::move(error);
  }
  return std::nullopt;
}

// A Checkpoint writes the run's counts from time to time and at the end.
class Checkpoint {
 public:
  explicit Checkpoint(std::string file) : file_(std::move(file)) {}

  void keep(const FormFactorRun& run, bool is_last) {
    const auto now = std::chrono::steady_clock::now();
    if (file_.empty() || run.replicateCount() == 0 || (!is_last && now - written_ < kBetweenCheckpoints)) return;
    run.writeCheckpoint(file_);
    written_ = now;
  }

 private:
  std::string file_;
  std::chrono::steady_clock::time_point written_ = std::chrono::steady_clock::now();
};

// Counts until the run ends or the observer stops it.    Out: the result; null with fewer than 2 replicates
std::shared_ptr<HeldResult> count(const HeldScene& held, const Request& request, const std::string& checkpoint,
                                  bool resumes, const Observer& observer) {
  FormFactorRun run(*held.scene, request, observer);
  if (resumes) run.resumeFrom(checkpoint);
  if (!checkpoint.empty()) run.settings();  // refuses runs that a checkpoint cannot hold
  run.makePlan();
  Checkpoint kept(checkpoint);
  while (!run.isDone()) {
    run.step();
    if (!run.isDone()) kept.keep(run, false);
  }
  if (run.isInterrupted() && run.replicateCount() == 0) return nullptr;
  kept.keep(run, true);
  if (run.isInterrupted() && run.replicateCount() < 2) return nullptr;
  Result result = run.result();
  if (result.balance_refusal) throw *result.balance_refusal;
  auto parameters = parametersOf(run, result);
  return hold(held, std::move(result), std::move(parameters));
}

py::tuple compute(const HeldScene& held, const py::dict& arguments, const std::string& checkpoint, bool resumes,
                  const py::object& tick) {
  Request request = requestOf(arguments);
  request.scene_options = held.options;
  if (!checkpoint.empty() && !std::holds_alternative<EpsilonDelta>(request.goal)) {
    if (request.promise.value_or(false))
      throw Error(ErrorCode::bad_usage, "a checkpoint keeps no promise; leave out one of checkpoint and promise");
    request.promise = false, request.lines_for_all = true;
  }
  std::shared_ptr<HeldResult> result;
  const auto stop =
      runWatched([&](const Observer& observer) { result = count(held, request, checkpoint, resumes, observer); }, tick);
  return py::make_tuple(result, stop ? stop->value() : py::none());
}

}  // namespace

std::shared_ptr<HeldResult> hold(const HeldScene& held, Result result,
                                 std::vector<std::pair<std::string, std::string>> parameters) {
  std::optional<FormFactors> balanced;
  if (result.balanced) balanced = std::move(result.balanced->form_factors);
  return std::make_shared<HeldResult>(HeldResult{
      {std::move(result.form_factors), std::move(balanced), surfaceNames(*held.scene), std::move(parameters)},
      held.scene,
      {},
      std::move(result.warnings),
      result.seconds});
}

std::optional<py::error_already_set> runWatched(const std::function<void(const Observer&)>& work,
                                                const py::object& tick) {
  Watched watched;
  std::thread worker([&] {
    std::exception_ptr failure;
    try {
      work({.should_stop = [&] { return watched.is_stopped.load(std::memory_order_relaxed); },
            .on_progress =
                [&](const Progress& progress) {
                  const std::lock_guard lock(watched.mutex);
                  watched.progress = progress;
                }});
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(watched.mutex);
    watched.failure = failure;
    watched.has_ended = true;
    watched.ended.notify_one();
  });
  std::optional<py::error_already_set> stop;
  for (bool has_ended = false; !has_ended;) {
    Progress progress;
    {
      const py::gil_scoped_release released;
      std::unique_lock lock(watched.mutex);
      has_ended = watched.ended.wait_for(lock, kBetweenTicks, [&] { return watched.has_ended; });
      progress = watched.progress;
    }
    if (!has_ended && !stop) {
      stop = look(progress, tick);
      if (stop) watched.is_stopped = true;
    }
  }
  {
    const py::gil_scoped_release released;
    worker.join();
  }
  if (watched.failure) std::rethrow_exception(watched.failure);
  return stop;
}

void addRun(py::module_& module) {
  module.def("compute", &compute, py::arg("scene"), py::arg("arguments"), py::arg("checkpoint"), py::arg("resumes"),
             py::arg("tick"));
}

}  // namespace viewpeel::python

// The Python module uses the public headers alone. The structs of this header are the objects that Python holds.
#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>
#include <viewpeel/matrix_free.h>
#include <viewpeel/read.h>
#include <viewpeel/solve.h>
#include <viewpeel/sparse_rows.h>
#include <viewpeel/write.h>

namespace viewpeel::python {

namespace py = pybind11;

// A HeldScene is a scene and the options that made it. Results keep their scene alive.
struct HeldScene {
  std::shared_ptr<const Scene> scene;
  SceneOptions options;
};

// A HeldResult is a result that was computed or read from a file.
struct HeldResult {
  StoredResult stored;
  std::shared_ptr<const Scene> scene;        // null for a result from a file
  std::shared_ptr<const SparseRows> rows{};  // made at their first use
  std::vector<std::string> warnings{};
  double seconds = 0;
};

struct HeldHeat {
  HeatSolution solution;
  std::shared_ptr<HeldResult> form_factors;  // null where none were kept
};

// Makes the Python object of a run's result.
//   In: parameters: names and values, as a file of the result would store them
std::shared_ptr<HeldResult> hold(const HeldScene& held, Result result,
                                 std::vector<std::pair<std::string, std::string>> parameters);

// Makes a request of keyword arguments that are not None.    Throws: Error bad_usage for unknown words.
Request requestOf(const py::dict& arguments);

// Runs the work on another thread, without the interpreter's lock. Meanwhile it calls `tick` and Python's handlers of
// signals some 20 times a second.
//   In: work: gets an observer and has to obey its stop; tick: a Python function of a dict of Progress, or None
//     Out: the Python exception that stopped the work; nothing where the work ended by itself
//   Throws: what the work throws.
std::optional<py::error_already_set> runWatched(const std::function<void(const Observer&)>& work,
                                                const py::object& tick);

// Runs work that ends with an answer, or with an Error where it was stopped.
//   In: work: gets an observer and returns the answer; toPython: makes a Python object of the answer
//   Out: (the object, None), or (None, the exception with which Python stopped the work)
//   Throws: what the work throws unless it was stopped.
template <class Work, class ToPython>
py::tuple answerOf(const Work& work, const py::object& tick, const ToPython& toPython) {
  std::optional<std::invoke_result_t<const Work&, const Observer&>> answer;
  const auto stop = runWatched(
      [&](const Observer& observer) {
        try {
          answer = work(observer);
        } catch (const Error&) {
          if (!observer.should_stop()) throw;
        }
      },
      tick);
  if (stop || !answer) return py::make_tuple(py::none(), stop ? stop->value() : py::none());
  return py::make_tuple(toPython(std::move(*answer)), py::none());
}

// Makes an array over values that `owner` keeps alive, without a copy.
template <class T, class Owner>
py::array_t<T> viewOf(const std::vector<T>& values, std::shared_ptr<const Owner> owner) {
  using Kept = std::shared_ptr<const Owner>;
  py::capsule keeper(new Kept(std::move(owner)), [](void* kept) { delete static_cast<Kept*>(kept); });
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data(), keeper);
}

// Makes an array that owns the values, without a copy.
template <class T>
py::array_t<T> arrayOf(std::vector<T> values) {
  auto owner = std::make_shared<const std::vector<T>>(std::move(values));
  return viewOf(*owner, owner);
}

// Returns the values and the standard errors of measured numbers.
std::pair<std::vector<double>, std::vector<double>> split(const std::vector<Measured>& measured);

// Makes an array with a value for every row of the scene; 0 for empty rows.    In: of_ids: a value for each nonempty
// row, by id
py::array_t<double> overRows(const Ids& ids, const std::vector<double>& of_ids);

// Makes a column of a result.    In: of_ids: a value for each nonempty row, by id
//   Out: (values, standard errors), one each for every row of the scene; 0 for empty rows
py::tuple columnOf(const Ids& ids, const std::vector<Measured>& of_ids);

// Returns the name of each surface of a scene.
std::vector<std::string> surfaceNames(const Scene& scene);

void addScene(py::module_& module);
void addResult(py::module_& module);
void addRun(py::module_& module);
void addEnvironment(py::module_& module);
void addHeat(py::module_& module);

}  // namespace viewpeel::python

// This file lets Python measure the environment of rows, without form factors between rows.
#include "python/core/bindings.h"

#include <viewpeel/environment.h>
#include <viewpeel/error.h>

namespace viewpeel::python {
namespace {

// Returns a column of all rows from the values of the rows that are not empty.    Out: (form factors, standard errors)
py::tuple columnOf(const Ids& ids, const std::vector<Measured>& of_ids) {
  std::vector<double> values, errors;
  for (const Measured& measured : of_ids) values.push_back(measured.value), errors.push_back(measured.standard_error);
  return py::make_tuple(arrayOf(spreadOverRows(ids, values)), arrayOf(spreadOverRows(ids, errors)));
}

// Measures the environment of all rows.    In: tolerance: standard error; seconds: time limit or None
//   Out: (dict, None); (None, the exception) where Python stopped the run
py::tuple measure(const HeldScene& held, bool by_surface, bool two_sided, const std::array<double, 3>& up,
                  double tolerance, std::optional<double> seconds, uint64_t seed, uint32_t threads,
                  const py::object& tick) {
  const EnvironmentRequest request{.by = by_surface ? By::surface : By::polygon,
                                   .two_sided = two_sided,
                                   .up = {up[0], up[1], up[2]},
                                   .tolerance = tolerance,
                                   .seed = seed,
                                   .threads = threads,
                                   .time_limit_s = seconds};
  std::optional<EnvironmentParts> found;
  const auto stop = runWatched(
      [&](const Observer& observer) {
        try {
          found = measureEnvironment(*held.scene, request, observer);
        } catch (const Error&) {
          if (!observer.should_stop()) throw;
        }
      },
      tick);
  if (!found || stop) return py::make_tuple(py::none(), stop ? stop->value() : py::none());
  py::dict columns;
  columns["names"] = rowNames(found->ids);
  columns["areas"] = arrayOf(spreadOverRows(found->ids, found->ids.areas));
  columns["environment"] = columnOf(found->ids, found->all);
  columns["up"] = columnOf(found->ids, found->up);
  columns["down"] = columnOf(found->ids, found->down);
  columns["replicates"] = found->replicates;
  columns["directions"] = found->directions;
  columns["is_reached"] = found->is_reached;
  return py::make_tuple(columns, py::none());
}

}  // namespace

void addEnvironment(py::module_& module) {
  module.def("measure_environment", &measure, py::arg("scene"), py::arg("by_surface"), py::arg("two_sided"),
             py::arg("up"), py::arg("tolerance"), py::arg("seconds"), py::arg("seed"), py::arg("threads"),
             py::arg("tick"));
}

}  // namespace viewpeel::python

// This file lets Python measure the environment of rows, without form factors between rows.
#include "python/core/bindings.h"

#include <viewpeel/environment.h>

namespace viewpeel::python {
namespace {

py::dict columnsOf(const EnvironmentParts& found) {
  py::dict columns;
  columns["names"] = rowNames(found.ids);
  columns["areas"] = overRows(found.ids, found.ids.areas);
  columns["environment"] = columnOf(found.ids, found.all);
  columns["up"] = columnOf(found.ids, found.up);
  columns["down"] = columnOf(found.ids, found.down);
  columns["replicates"] = found.replicates;
  columns["directions"] = found.directions;
  columns["is_reached"] = found.is_reached;
  return columns;
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
  return answerOf([&](const Observer& observer) { return measureEnvironment(*held.scene, request, observer); }, tick,
                  columnsOf);
}

}  // namespace

void addEnvironment(py::module_& module) {
  module.def("measure_environment", &measure, py::arg("scene"), py::arg("by_surface"), py::arg("two_sided"),
             py::arg("up"), py::arg("tolerance"), py::arg("seconds"), py::arg("seed"), py::arg("threads"),
             py::arg("tick"));
}

}  // namespace viewpeel::python

// This file binds results: as arrays over the library's memory, and as files.
#include <limits>

#include "python/core/bindings.h"

namespace viewpeel::python {
namespace {

using Held = std::shared_ptr<HeldResult>;

std::shared_ptr<const SparseRows> rowsOf(HeldResult& held) {
  if (!held.rows) {
    const py::gil_scoped_release released;
    held.rows = std::make_shared<const SparseRows>(compressRows(held.stored.form_factors));
  }
  return held.rows;
}

// Returns the index of each row's first entry, for SciPy's csr_array. It has the integer type of the column indices, as
// SciPy wants, unless there are too many entries for this type.
py::array startsOf(const std::shared_ptr<const SparseRows>& rows) {
  if (rows->starts.back() > std::numeric_limits<int32_t>::max()) return viewOf(rows->starts, rows);
  return arrayOf(std::vector<int32_t>(rows->starts.begin(), rows->starts.end()));
}

// Returns a sparse matrix as scipy.sparse.csr_array takes it: (values, columns, starts).
py::tuple matrixOf(const py::array_t<double>& values, const std::shared_ptr<const SparseRows>& rows) {
  return py::make_tuple(values, viewOf(rows->columns, rows), startsOf(rows));
}

// Returns a sparse matrix, or None where the result has no values of this name.
py::object sparse(HeldResult& held, const std::string& name) {
  const std::shared_ptr<const SparseRows> rows = rowsOf(held);
  const std::vector<double>& values = name == "form_factors"      ? rows->form_factors
                                      : name == "standard_errors" ? rows->standard_errors
                                      : name == "lower"           ? rows->lower
                                                                  : rows->upper;
  if (values.size() != rows->columns.size()) return py::none();
  return matrixOf(viewOf(values, rows), rows);
}

// Returns exchange areas as a sparse matrix; A_i F_ij and A_j F_ji are the same number.
py::tuple exchangeAreas(HeldResult& held) {
  const std::shared_ptr<const SparseRows> rows = rowsOf(held);
  const FormFactors& form_factors = held.stored.form_factors;
  const std::vector<uint32_t> row_of_id = form_factors.ids().rows();
  std::vector<uint32_t> id_of_row(form_factors.ids().rowCount());
  for (uint32_t id = 0; id < row_of_id.size(); ++id) id_of_row[row_of_id[id]] = id;
  std::vector<double> areas;
  areas.reserve(rows->columns.size());
  for (size_t row = 0; row + 1 < rows->starts.size(); ++row)
    for (auto k = static_cast<size_t>(rows->starts[row]); k < static_cast<size_t>(rows->starts[row + 1]); ++k)
      areas.push_back(
          form_factors.exchangeArea(id_of_row[row], id_of_row[static_cast<size_t>(rows->columns[k])]).value);
  return matrixOf(arrayOf(std::move(areas)), rows);
}

py::object balanced(HeldResult& held) {
  if (!held.stored.balanced) return py::none();
  const auto rows = std::make_shared<const SparseRows>(compressRows(*held.stored.balanced));
  return matrixOf(viewOf(rows->form_factors, rows), rows);
}

// Returns the value of each id, by a function of the id; ids that were not requested get T{}.
template <class T, class ValueOf>
std::vector<T> ofRequested(const Ids& ids, const ValueOf& value_of) {
  std::vector<T> values;
  for (uint32_t id = 0; id < ids.count(); ++id) values.push_back(ids.isRequested(id) ? value_of(id) : T{});
  return values;
}

py::tuple columnTo(const HeldResult& held, uint32_t to) {
  const FormFactors& form_factors = held.stored.form_factors;
  return columnOf(form_factors.ids(), ofRequested<Measured>(form_factors.ids(), [&](uint32_t id) {
                    return form_factors.formFactor(id, to);
                  }));
}

// Returns the intervals of the form factors from all rows to id `to`, as two arrays (lower, upper). Returns None where
// the result has no intervals.
py::object boundsTo(const HeldResult& held, uint32_t to) {
  const FormFactors& form_factors = held.stored.form_factors;
  if (!form_factors.hasIntervals()) return py::none();
  std::vector<double> lower, upper;
  for (const Interval& interval :
       ofRequested<Interval>(form_factors.ids(), [&](uint32_t id) { return form_factors.interval(id, to); }))
    lower.push_back(interval.lower), upper.push_back(interval.upper);
  return py::make_tuple(overRows(form_factors.ids(), lower), overRows(form_factors.ids(), upper));
}

py::array_t<double> rowSums(const HeldResult& held) {
  const FormFactors& form_factors = held.stored.form_factors;
  return overRows(form_factors.ids(), split(form_factors.rowSums()).first);
}

py::object closure(const HeldResult& held) {
  if (!held.stored.form_factors.ids().rows_sum_to_one) return py::none();
  const Closure found = measureClosure(held.stored.form_factors);
  return py::make_tuple(found.largest_error, found.standard_error, found.rms_error, found.row);
}

void save(const HeldResult& held, const std::string& file, const std::vector<std::string>& shown) {
  OutputContent content{held.stored.form_factors};
  if (held.stored.balanced) content.balanced = &*held.stored.balanced;
  content.scene = held.scene.get();
  content.parameters = held.stored.parameters;
  content.shown = shown;
  const py::gil_scoped_release released;
  checkOutput(file, content.balanced != nullptr, content.scene != nullptr);
  writeFormFactors(content, file);
}

Held load(const std::string& file) {
  const py::gil_scoped_release released;
  return std::make_shared<HeldResult>(HeldResult{readResult(file), nullptr});
}

}  // namespace

std::pair<std::vector<double>, std::vector<double>> split(const std::vector<Measured>& measured) {
  std::vector<double> values, errors;
  for (const Measured& of : measured) values.push_back(of.value), errors.push_back(of.standard_error);
  return {std::move(values), std::move(errors)};
}

py::array_t<double> overRows(const Ids& ids, const std::vector<double>& of_ids) {
  return arrayOf(spreadOverRows(ids, of_ids));
}

py::tuple columnOf(const Ids& ids, const std::vector<Measured>& of_ids) {
  const auto [values, errors] = split(of_ids);
  return py::make_tuple(overRows(ids, values), overRows(ids, errors));
}

void addResult(py::module_& module) {
  py::class_<HeldResult, Held>(module, "Result")
      .def("sparse", &sparse, py::arg("name"))
      .def("exchange_areas", &exchangeAreas)
      .def("balanced", &balanced)
      .def("environment", [](const HeldResult& held) { return columnTo(held, kEnvironment); })
      .def("leak", [](const HeldResult& held) { return columnTo(held, kLeak); })
      .def("environment_bounds", [](const HeldResult& held) { return boundsTo(held, kEnvironment); })
      .def("leak_bounds", [](const HeldResult& held) { return boundsTo(held, kLeak); })
      .def("row_sums", &rowSums)
      .def("closure", &closure)
      .def("names", [](const HeldResult& held) { return rowNames(held.stored.form_factors.ids()); })
      .def("areas",
           [](const HeldResult& held) {
             const Ids& ids = held.stored.form_factors.ids();
             return overRows(ids, ids.areas);
           })
      .def_property_readonly("surface_names", [](const HeldResult& held) { return held.stored.surface_names; })
      .def_property_readonly("parameters", [](const HeldResult& held) { return held.stored.parameters; })
      .def_property_readonly("unlisted_bound",
                             [](const HeldResult& held) { return held.stored.form_factors.unlistedBound(); })
      .def_property_readonly("warnings", [](const HeldResult& held) { return held.warnings; })
      .def_property_readonly("seconds", [](const HeldResult& held) { return held.seconds; })
      .def("save", &save, py::arg("file"), py::arg("shown"));
  module.def("load", &load, py::arg("file"));
}

}  // namespace viewpeel::python

// Heat flows and temperatures, of a scene or of form factors that are there.
#include "python/core/bindings.h"

#include <viewpeel/error.h>

namespace viewpeel::python {
namespace {

// In: lines: (name, emissivity, temperature or None, heat flux or None)
MaterialTable tableOf(
    const std::vector<std::tuple<std::string, double, std::optional<double>, std::optional<double>>>& lines,
    std::optional<double> environment_K) {
  MaterialTable table{"materials", {}, environment_K};
  for (const auto& [name, emissivity, temperature, heat_flux] : lines)
    table.lines.push_back({name, {emissivity, temperature, heat_flux}});
  return table;
}

std::shared_ptr<HeldHeat> solve(const std::shared_ptr<HeldResult>& result, const MaterialTable& materials) {
  const py::gil_scoped_release released;
  const StoredResult& stored = result->stored;
  const Enclosure enclosure = assignMaterials(materials, stored.form_factors.ids(), stored.surface_names);
  return std::make_shared<HeldHeat>(HeldHeat{solveHeat(stored.form_factors, enclosure), result});
}

const std::vector<HeatRow>& rowsOf(const HeldHeat& heat, bool by_surface) {
  return by_surface ? heat.solution.surfaces : heat.solution.rows;
}

// Returns names, and a pair of arrays (values, standard errors) for each answer.
py::dict columnsOf(const HeldHeat& heat, bool by_surface) {
  const std::vector<HeatRow>& rows = rowsOf(heat, by_surface);
  py::dict columns;
  std::vector<std::string> names;
  std::vector<double> areas, emissivities;
  for (const HeatRow& row : rows)
    names.push_back(row.name), areas.push_back(row.area), emissivities.push_back(row.emissivity);
  columns["name"] = names;
  columns["area"] = arrayOf(std::move(areas));
  columns["emissivity"] = arrayOf(std::move(emissivities));
  for (const auto& [name, member] :
       {std::pair("temperature", &HeatRow::temperature), std::pair("radiosity", &HeatRow::radiosity),
        std::pair("irradiation", &HeatRow::irradiation), std::pair("heat_flux", &HeatRow::heat_flux),
        std::pair("heat_flow", &HeatRow::heat_flow)}) {
    std::vector<double> values, errors;
    for (const HeatRow& row : rows) {
      const Measured& of_row = row.*member;
      values.push_back(of_row.value), errors.push_back(of_row.standard_error);
    }
    columns[name] = py::make_tuple(arrayOf(std::move(values)), arrayOf(std::move(errors)));
  }
  return columns;
}

}  // namespace

void addHeat(py::module_& module) {
  py::class_<MaterialTable>(module, "Materials").def(py::init(&tableOf), py::arg("lines"), py::arg("environment"));
  module.def(
      "read_materials", [](const std::string& file) { return readMaterials(file); }, py::arg("file"));
  py::class_<HeldHeat, std::shared_ptr<HeldHeat>>(module, "Heat")
      .def("columns", &columnsOf, py::arg("by_surface"))
      .def_property_readonly("is_open", [](const HeldHeat& heat) { return heat.solution.is_open; })
      .def_property_readonly("to_environment",
                             [](const HeldHeat& heat) {
                               const Measured& flow = heat.solution.to_environment;
                               return py::make_tuple(flow.value, flow.standard_error);
                             })
      .def_property_readonly("balance_residual", [](const HeldHeat& heat) { return heat.solution.balance_residual; })
      .def_property_readonly("form_factors", [](const HeldHeat& heat) { return heat.form_factors; })
      .def(
          "save",
          [](const HeldHeat& heat, const std::string& file, bool by_surface) {
            checkHeatOutput(file);
            writeHeat(heat.solution, by_surface ? By::surface : By::polygon, std::filesystem::path(file));
          },
          py::arg("file"), py::arg("by_surface"));
  module.def("solve", &solve, py::arg("result"), py::arg("materials"));
}

}  // namespace viewpeel::python

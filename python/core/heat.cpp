// This file binds heat flows and temperatures, of a scene or of a result.
#include "python/core/bindings.h"

namespace viewpeel::python {
namespace {

using Line =
    std::tuple<std::string, std::vector<double>, std::optional<double>, std::optional<double>, std::optional<uint32_t>>;
using Law = std::tuple<double, std::vector<double>, std::vector<double>>;

// Makes materials.
//   In: lines: (name, emissivity of each band, temperature or None, heat flux or None, index of a law or None); bands:
//     limits in micrometres, none for grey rows; laws: (cosine power, angles in degrees, values)
MaterialTable tableOf(const std::vector<Line>& lines, std::optional<double> environment_K,
                      const std::vector<double>& bands, const std::vector<Law>& laws) {
  MaterialTable table{"materials", {}, environment_K};
  table.band_limits_um = bands;
  for (const auto& [name, emissivities, temperature, heat_flux, law] : lines) {
    Material material{emissivities.front(), temperature, heat_flux};
    if (!bands.empty()) material.band_emissivities = emissivities;
    material.directional = law;
    table.lines.push_back({name, material});
  }
  for (const auto& [power, angles, values] : laws) table.laws.push_back({power, angles, values});
  return table;
}

HeatTolerance toleranceOf(double tolerance, const std::string& unit) {
  return {tolerance, unit == "K"      ? HeatTolerance::Of::temperature
                     : unit == "W/m2" ? HeatTolerance::Of::heat_flux
                                      : HeatTolerance::Of::relative};
}

std::shared_ptr<HeldHeat> solve(const std::shared_ptr<HeldResult>& result, const MaterialTable& materials) {
  const py::gil_scoped_release released;
  const StoredResult& stored = result->stored;
  const Enclosure enclosure = assignMaterials(materials, stored.form_factors.ids(), stored.surface_names);
  return std::make_shared<HeldHeat>(HeldHeat{solveHeat(stored.form_factors, enclosure), result});
}

// Computes form factors until the answers' standard errors are below the tolerance.
//   In: unit: K, W/m2, or % of all heat
//   Out: ((answers, whether the tolerance was reached), None), or (None, the exception that stopped the run)
py::tuple solveTo(const HeldScene& held, const py::dict& arguments, const MaterialTable& materials, double tolerance,
                  const std::string& unit, const py::object& tick) {
  Request request = requestOf(arguments);
  request.scene_options = held.options;
  const HeatTolerance goal = toleranceOf(tolerance, unit);
  return answerOf(
      [&](const Observer& observer) { return solveScene(*held.scene, materials, request, goal, observer); }, tick,
      [&](SceneHeat found) {
        auto result = hold(held, std::move(found.form_factors),
                           {{"by", request.by == By::surface ? "surface" : "polygon"},
                            {"two-sided", request.two_sided ? "yes" : "no"},
                            {"seed", std::to_string(request.seed)},
                            {"tolerance", std::to_string(found.form_factor_tolerance)}});
        return py::make_tuple(std::make_shared<HeldHeat>(HeldHeat{std::move(found.heat), std::move(result)}),
                              found.is_reached);
      });
}

// Solves without form factors in memory.
//   In: tolerance: (value, unit) as of solveTo, or None    Out: as of solveTo
py::tuple solveWithoutMatrix(const HeldScene& held, const py::dict& arguments, const MaterialTable& materials,
                             const std::optional<std::pair<double, std::string>>& tolerance, const py::object& tick) {
  const Request words = requestOf(arguments);
  MatrixFreeRequest request{.by = words.by, .two_sided = words.two_sided};
  if (tolerance) request.tolerance = toleranceOf(tolerance->first, tolerance->second);
  request.seed = words.seed, request.threads = words.threads, request.time_limit_s = words.time_limit_s;
  return answerOf(
      [&](const Observer& observer) {
        MatrixFreeObserver watch{.should_stop = observer.should_stop, .on_progress = {}};
        watch.on_progress = [&](uint64_t product, uint64_t done, uint64_t all, double error) {
          Progress progress;
          progress.phase = Progress::Phase::counting;
          progress.replicates = product;
          progress.directions = done, progress.directions_of_replicate = all, progress.largest_standard_error = error;
          observer.on_progress(progress);
        };
        return solveMatrixFree(*held.scene, materials, request, watch);
      },
      tick,
      [](MatrixFreeHeat found) {
        return py::make_tuple(std::make_shared<HeldHeat>(HeldHeat{std::move(found.heat), nullptr}), found.is_reached);
      });
}

// Returns whether `viewpeel solve` would keep no form factors of this scene.
bool isMatrixFree(const HeldScene& held, const MaterialTable& materials, bool by_surface) {
  const size_t rows = by_surface ? held.scene->surfaces.size() : held.scene->faces.size();
  return !materials.laws.empty() || matrixBytes(rows) > kMostMatrixBytes;
}

const std::vector<HeatRow>& rowsOf(const HeldHeat& heat, bool by_surface) {
  return by_surface ? heat.solution.surfaces : heat.solution.rows;
}

// Returns names, and for each answer three arrays: values, standard errors and bounds. Bounds are None where form
// factors have no intervals.
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
  struct Answer {
    const char* name;
    Measured HeatRow::*measured;
    double HeatBounds::*bound;
  };
  for (const Answer& answer : {Answer{"temperature", &HeatRow::temperature, &HeatBounds::temperature},
                               Answer{"radiosity", &HeatRow::radiosity, &HeatBounds::radiosity},
                               Answer{"irradiation", &HeatRow::irradiation, &HeatBounds::irradiation},
                               Answer{"heat_flux", &HeatRow::heat_flux, &HeatBounds::heat_flux},
                               Answer{"heat_flow", &HeatRow::heat_flow, &HeatBounds::heat_flow}}) {
    std::vector<Measured> measured;
    std::vector<double> bounds;
    for (const HeatRow& row : rows) {
      measured.push_back(row.*answer.measured);
      if (row.bounds) bounds.push_back((*row.bounds).*answer.bound);
    }
    const bool has_bounds = !rows.empty() && bounds.size() == rows.size();
    auto [values, errors] = split(measured);
    columns[answer.name] = py::make_tuple(arrayOf(std::move(values)), arrayOf(std::move(errors)),
                                          has_bounds ? py::object(arrayOf(std::move(bounds))) : py::none());
  }
  return columns;
}

}  // namespace

void addHeat(py::module_& module) {
  py::class_<MaterialTable>(module, "Materials")
      .def(py::init(&tableOf), py::arg("lines"), py::arg("environment"), py::arg("bands"), py::arg("laws"))
      .def_property_readonly("is_directional", [](const MaterialTable& table) { return !table.laws.empty(); });
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
  module.def("solve_to", &solveTo, py::arg("scene"), py::arg("arguments"), py::arg("materials"), py::arg("tolerance"),
             py::arg("unit"), py::arg("tick"));
  module.def("solve_without_matrix", &solveWithoutMatrix, py::arg("scene"), py::arg("arguments"), py::arg("materials"),
             py::arg("tolerance"), py::arg("tick"));
  module.def("is_matrix_free", &isMatrixFree, py::arg("scene"), py::arg("materials"), py::arg("by_surface"));
}

}  // namespace viewpeel::python

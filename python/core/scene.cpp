// This file binds scenes, from files and from arrays.
#include "python/core/bindings.h"

#include <cmath>
#include <viewpeel/error.h>

namespace viewpeel::python {
namespace {

using Points = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Indices = py::array_t<int64_t, py::array::c_style | py::array::forcecast>;

HeldScene hold(Scene scene, SceneOptions options) {
  return {std::make_shared<const Scene>(std::move(scene)), std::move(options)};
}

[[noreturn]] void refuse(const std::string& message) { throw Error(ErrorCode::bad_input, message); }

// Makes a scene.    In: points: n x 3; corners: indices of points, polygon by polygon; starts: polygons + 1; surfaces:
// by polygon
InputScene inputOf(const Points& points, const Indices& corners, const Indices& starts, const Indices& surfaces,
                   std::vector<std::string> names, std::string title) {
  if (points.ndim() != 2 || points.shape(1) != 3) refuse("points: not an array of n x 3 coordinates");
  InputScene input{std::move(title), std::move(names), {}};
  const auto point = points.unchecked<2>();
  const auto corner = corners.unchecked<1>(), start = starts.unchecked<1>(), surface = surfaces.unchecked<1>();
  if (start.shape(0) != surface.shape(0) + 1) refuse("names: not one for each polygon");
  input.faces.resize(static_cast<size_t>(surface.shape(0)));
  for (py::ssize_t k = 0; k < surface.shape(0); ++k) {
    InputFace& face = input.faces[static_cast<size_t>(k)];
    if (start(k) < 0 || start(k + 1) < start(k) || start(k + 1) > corner.shape(0))
      refuse("polygons: corners are not where the starts say");
    if (surface(k) < 0 || static_cast<size_t>(surface(k)) >= input.surface_names.size())
      refuse("polygon " + std::to_string(k) + ": has no name");
    face.surface = static_cast<uint32_t>(surface(k));
    for (int64_t at = start(k); at < start(k + 1); ++at) {
      const int64_t index = corner(at);
      if (index < 0 || index >= point.shape(0))
        refuse("polygon " + std::to_string(k) + ": corner " + std::to_string(index) + " is not one of the " +
               std::to_string(point.shape(0)) + " points; indices count from 0");
      face.corners.emplace_back(point(index, 0), point(index, 1), point(index, 2));
    }
  }
  return input;
}

SceneOptions optionsOf(std::vector<std::string> sheets, std::vector<std::string> solids, std::vector<std::string> flip,
                       bool fix_normals, double unit_m, std::vector<std::string> zones = {}, bool outside = false,
                       double lod = INFINITY) {
  return {std::move(sheets), std::move(solids), std::move(flip), fix_normals, unit_m, std::move(zones), outside, lod};
}

}  // namespace

std::vector<std::string> surfaceNames(const Scene& scene) {
  std::vector<std::string> names;
  for (const Surface& surface : scene.surfaces) names.push_back(surface.name);
  return names;
}

void addScene(py::module_& module) {
  py::class_<HeldScene>(module, "Scene")
      .def_property_readonly("file", [](const HeldScene& held) { return held.scene->file; })
      .def_property_readonly("polygon_count", [](const HeldScene& held) { return held.scene->faces.size(); })
      .def_property_readonly("surface_names", [](const HeldScene& held) { return surfaceNames(*held.scene); })
      .def_property_readonly("warnings", [](const HeldScene& held) { return held.scene->warnings; });
  module.def(
      "load_scene",
      [](const std::vector<std::string>& files, std::vector<std::string> sheets, std::vector<std::string> solids,
         std::vector<std::string> flip, bool fix_normals, double unit_m, std::vector<std::string> zones, bool outside,
         double lod) {
        SceneOptions options = optionsOf(std::move(sheets), std::move(solids), std::move(flip), fix_normals, unit_m,
                                         std::move(zones), outside, lod);
        const py::gil_scoped_release released;
        return hold(loadScene({files.begin(), files.end()}, options), options);
      },
      py::arg("files"), py::arg("sheets"), py::arg("solids"), py::arg("flip"), py::arg("fix_normals"),
      py::arg("unit_m"), py::arg("zones"), py::arg("outside"), py::arg("lod"));
  module.def(
      "build_scene",
      [](const Points& points, const Indices& corners, const Indices& starts, const Indices& surfaces,
         std::vector<std::string> names, std::string title, std::vector<std::string> sheets,
         std::vector<std::string> solids, std::vector<std::string> flip, bool fix_normals, double unit_m) {
        SceneOptions options = optionsOf(std::move(sheets), std::move(solids), std::move(flip), fix_normals, unit_m);
        const InputScene input = inputOf(points, corners, starts, surfaces, std::move(names), std::move(title));
        const py::gil_scoped_release released;
        return hold(buildScene(input, options), options);
      },
      py::arg("points"), py::arg("corners"), py::arg("starts"), py::arg("surfaces"), py::arg("names"), py::arg("title"),
      py::arg("sheets"), py::arg("solids"), py::arg("flip"), py::arg("fix_normals"), py::arg("unit_m"));
}

}  // namespace viewpeel::python

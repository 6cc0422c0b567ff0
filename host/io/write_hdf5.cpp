// writeHdf5() writes a result that SciPy, AnnData and xarray all read. Compressed rows are in a group. The columns are
// also linked at the top, with dimension scales.
//   Sources: AnnData's on-disk format, csr_matrix 0.1.0; CF Conventions 1.8, section 8.2, compression by gathering.
#include <charconv>
#include <cmath>
#include <limits>

#include "io/guesses.h"
#include "io/hdf5_file.h"
#include "io/read_report.h"
#include "io/entry_rows.h"
#include "io/shown_rows.h"
#include <viewpeel/sparse_rows.h>
#include "io/writers.h"
#include "io/stored_rows.h"
#include "report/write_page.h"
#include <viewpeel/drop_below.h>
#include <viewpeel/environment.h>
#include <viewpeel/solve.h>

namespace viewpeel {
namespace {

// Adds a matrix with the columns and row starts of the form factors.
void addMatrix(Hdf5Output& out, const std::string& group, const SparseRows& rows, const std::vector<double>& values) {
  out.write(group + "/data", values);
  if (group == "form_factors") {
    out.write(group + "/indices", rows.columns);
    out.write(group + "/indptr", rows.starts);
  } else {
    out.link(group + "/indices", "form_factors/indices");
    out.link(group + "/indptr", "form_factors/indptr");
  }
  out.setAttribute(group, "encoding-type", std::string("csr_matrix"));
  out.setAttribute(group, "encoding-version", std::string("0.1.0"));
  out.setAttribute(group, "shape", std::vector<int64_t>(2, rows.rowCount()));
}

// Links the columns of the groups to the names that users of xarray see. Links take no room.
void addPairs(Hdf5Output& out, const SparseRows& rows, const OutputContent& content) {
  const bool with_balance = content.balanced != nullptr;
  std::vector<int64_t> places;
  std::vector<int32_t> from;
  for (int64_t i = 0; i < rows.rowCount(); ++i)
    for (int64_t k = rows.starts[i]; k < rows.starts[i + 1]; ++k) {
      places.push_back(i * rows.rowCount() + rows.columns[k]);
      from.push_back(static_cast<int32_t>(i));
    }
  out.write("pair", places);
  out.makeScale("pair");
  out.setAttribute("pair", "compress", std::string("from to"));
  out.write("from", from);
  out.link("to", "form_factors/indices");
  out.link("form_factor", "form_factors/data");
  out.link("standard_error", "standard_errors/data");
  std::vector<std::string> of_pairs = {"form_factor", "standard_error", "from", "to"};
  if (with_balance) {
    out.link("balanced_form_factor", "balanced_form_factors/data");
    of_pairs.push_back("balanced_form_factor");
  }
  if (!rows.lower.empty())
    for (const std::string name : {"lower", "upper"}) {
      out.link(name, name + "_bounds/data");
      of_pairs.push_back(name);
    }
  if (hasGuesses(content)) {
    std::vector<uint8_t> is_guess;
    EntryRows(content.form_factors).forEach([&](const RowEntry& entry) {
      if (entry.j < kEnvironment) is_guess.push_back(isGuess(content, entry.i, entry.j));
    });
    out.write("is_guess", is_guess);
    of_pairs.push_back("is_guess");
  }
  for (const std::string& column : of_pairs) out.useScale(column, "pair");
  for (const std::string& column : of_pairs)
    if (column != "from" && column != "to") out.setAttribute(column, "units", std::string("1"));
}

void addRows(Hdf5Output& out, const OutputContent& content) {
  const FormFactors& form_factors = content.form_factors;
  const Ids& ids = form_factors.ids();
  std::vector<int32_t> numbers(ids.rowCount());
  for (size_t row = 0; row < numbers.size(); ++row) numbers[row] = static_cast<int32_t>(row);
  out.write("row", numbers);
  out.makeScale("row");
  out.writeTexts("name", rowNames(ids));
  out.useScale("name", "row");
  std::vector<uint8_t> is_requested(ids.rowCount(), 0);
  const std::vector<uint32_t> rows = ids.rows();
  for (uint32_t id = 0; id < ids.count(); ++id) is_requested[rows[id]] = ids.isRequested(id);
  out.write("is_requested", is_requested);
  out.useScale("is_requested", "row");
  const auto addColumn = [&](const std::string& name, const std::string& unit, auto valueOf) {
    std::vector<double> values(ids.count());
    for (uint32_t id = 0; id < ids.count(); ++id) values[id] = valueOf(id);
    out.write(name, spreadOverRows(ids, values));
    out.useScale(name, "row");
    out.setAttribute(name, "units", unit);
  };
  addColumn("area", "length unit squared", [&](uint32_t id) { return ids.areas[id]; });
  for (const auto& [name, j] : {std::pair("environment", kEnvironment), std::pair("leak", kLeak)}) {
    if (j == kLeak && content.has_environment_alone) break;
    const uint32_t column = j;
    addColumn(name, "1", [&](uint32_t id) { return form_factors.formFactor(id, column).value; });
    addColumn(std::string(name) + "_standard_error", "1",
              [&](uint32_t id) { return form_factors.formFactor(id, column).standard_error; });
    if (!form_factors.hasIntervals()) continue;
    addColumn(std::string(name) + "_lower", "1", [&](uint32_t id) { return form_factors.interval(id, column).lower; });
    addColumn(std::string(name) + "_upper", "1", [&](uint32_t id) { return form_factors.interval(id, column).upper; });
  }
  if (content.dropped) {
    addColumn("dropped", "1", [&](uint32_t id) { return content.dropped->sums[id].value; });
    addColumn("dropped_standard_error", "1", [&](uint32_t id) { return content.dropped->sums[id].standard_error; });
    out.setAttribute("/", "drop_below", content.dropped->least);
  }
  if (content.parts)
    for (const auto& [name, part] :
         {std::pair("environment_up", &content.parts->up), std::pair("environment_down", &content.parts->down)}) {
      const std::vector<Measured>& of_ids = *part;
      addColumn(name, "1", [&](uint32_t id) { return of_ids[id].value; });
      addColumn(std::string(name) + "_standard_error", "1", [&](uint32_t id) { return of_ids[id].standard_error; });
      const std::vector<Interval>& intervals =
          part == &content.parts->up ? content.parts->up_intervals : content.parts->down_intervals;
      if (intervals.empty()) continue;
      addColumn(std::string(name) + "_lower", "1", [&](uint32_t id) { return intervals[id].lower; });
      addColumn(std::string(name) + "_upper", "1", [&](uint32_t id) { return intervals[id].upper; });
    }
  if (content.has_environment_alone) return;
  addColumn("row_sum", "1", [&](uint32_t id) { return form_factors.rowSums()[id].value; });
  addColumn("row_sum_standard_error", "1", [&](uint32_t id) { return form_factors.rowSums()[id].standard_error; });
}

// Adds the answers of `solve`, one for each row of the form factors.
void addHeat(Hdf5Output& out, const Ids& ids, const HeatSolution& heat) {
  const auto add = [&](const std::string& name, const std::string& unit, auto valueOf) {
    std::vector<double> values(ids.count());
    for (uint32_t id = 0; id < ids.count(); ++id) values[id] = valueOf(heat.rows[id]);
    out.write(name, spreadOverRows(ids, values));
    out.useScale(name, "row");
    out.setAttribute(name, "units", unit);
  };
  add("emissivity", "1", [](const HeatRow& row) { return row.emissivity; });
  struct Answer {
    const char *name, *unit;
    Measured HeatRow::*value;
    double HeatBounds::*bound;
  };
  for (const Answer& answer : {Answer{"temperature", "K", &HeatRow::temperature, &HeatBounds::temperature},
                               Answer{"radiosity", "W/m2", &HeatRow::radiosity, &HeatBounds::radiosity},
                               Answer{"irradiation", "W/m2", &HeatRow::irradiation, &HeatBounds::irradiation},
                               Answer{"heat_flux", "W/m2", &HeatRow::heat_flux, &HeatBounds::heat_flux},
                               Answer{"heat_flow", "W", &HeatRow::heat_flow, &HeatBounds::heat_flow}}) {
    const std::string name = answer.name;
    add(name, answer.unit, [&](const HeatRow& row) { return (row.*answer.value).value; });
    add(name + "_standard_error", answer.unit, [&](const HeatRow& row) { return (row.*answer.value).standard_error; });
    if (heat.rows.empty() || !heat.rows.front().bounds) continue;
    add(name + "_bound", answer.unit, [&](const HeatRow& row) { return (*row.bounds).*answer.bound; });
  }
}

// Adds the triangles and quadrilaterals that were computed, with corners in input units.
void addGeometry(Hdf5Output& out, const Scene& scene, const Ids& ids) {
  std::vector<double> coordinates[3];
  for (const glm::dvec3& corner : scene.corners)
    for (int axis = 0; axis < 3; ++axis) coordinates[axis].push_back(scene.centre[axis] + scene.scale * corner[axis]);
  const std::vector<uint32_t> rows = ids.rows(), id_of_polygon = idsOfPolygons(scene, ids);
  std::vector<int32_t> first, count, row, surface;
  std::vector<double> area;
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    const Polygon& polygon = scene.polygons[k];
    first.push_back(static_cast<int32_t>(polygon.first_corner));
    count.push_back(static_cast<int32_t>(polygon.corner_count));
    row.push_back(static_cast<int32_t>(rows[id_of_polygon[k]]));
    surface.push_back(static_cast<int32_t>(scene.faces[polygon.face].surface));
    area.push_back(polygon.area * scene.scale * scene.scale);
  }
  std::vector<std::string> surfaces;
  for (const Surface& of_scene : scene.surfaces) surfaces.push_back(of_scene.name);
  const auto addScale = [&](const std::string& name, size_t length) {
    std::vector<int32_t> numbers(length);
    for (size_t k = 0; k < length; ++k) numbers[k] = static_cast<int32_t>(k);
    out.write("geometry/" + name, numbers);
    out.makeScale("geometry/" + name);
  };
  addScale("corner", scene.corners.size());
  addScale("polygon", scene.polygons.size());
  addScale("surface", scene.surfaces.size());
  const auto add = [&](const std::string& name, const auto& values, const std::string& scale) {
    out.write("geometry/" + name, values);
    out.useScale("geometry/" + name, "geometry/" + scale);
  };
  for (int axis = 0; axis < 3; ++axis) add(std::string(1, static_cast<char>('x' + axis)), coordinates[axis], "corner");
  add("first_corner", first, "polygon");
  add("corner_count", count, "polygon");
  add("row_of_polygon", row, "polygon");
  add("surface_of_polygon", surface, "polygon");
  add("polygon_area", area, "polygon");
  out.writeTexts("geometry/surface_name", surfaces);
  out.useScale("geometry/surface_name", "geometry/surface");
}

// Adds a parameter of the run, as a number where it is one.
void addParameter(Hdf5Output& out, const std::string& name, const std::string& value) {
  const char* end = value.data() + value.size();
  int64_t whole = 0;
  double number = 0;
  if (const auto [at, failure] = std::from_chars(value.data(), end, whole); failure == std::errc() && at == end)
    out.setAttribute("/", name, whole);
  else if (const auto [at2, failure2] = std::from_chars(value.data(), end, number);
           failure2 == std::errc() && at2 == end)
    out.setAttribute("/", name, number);
  else out.setAttribute("/", name, value);
}

// Adds the largest distance of row sums from 1, and its root mean square.
void addClosure(Hdf5Output& out, const FormFactors& form_factors) {
  double largest = 0, squares = 0, count = 0;
  for (uint32_t id = 0; id < form_factors.ids().count(); ++id) {
    if (!form_factors.ids().isRequested(id)) continue;
    const double error = std::abs(form_factors.rowSums()[id].value - 1);
    largest = std::max(largest, error);
    squares += error * error;
    ++count;
  }
  out.setAttribute("/", "closure_largest", largest);
  out.setAttribute("/", "closure_rms", count > 0 ? std::sqrt(squares / count) : 0.0);
}

void addMatrices(Hdf5Output& file, const OutputContent& content) {
  const SparseRows rows = compressRows(content.form_factors);
  addMatrix(file, "form_factors", rows, rows.form_factors);
  addMatrix(file, "standard_errors", rows, rows.standard_errors);
  if (content.balanced) addMatrix(file, "balanced_form_factors", rows, compressRows(*content.balanced).form_factors);
  if (!rows.lower.empty()) {
    addMatrix(file, "lower_bounds", rows, rows.lower);
    addMatrix(file, "upper_bounds", rows, rows.upper);
  }
  addPairs(file, rows, content);
}

std::vector<char> makeHdf5(const OutputContent& content) {
  const FormFactors& form_factors = content.form_factors;
  Hdf5Output file;
  if (!content.has_environment_alone) addMatrices(file, content);
  addRows(file, content);
  if (content.heat) addHeat(file, form_factors.ids(), *content.heat);
  if (content.scene) addGeometry(file, *content.scene, form_factors.ids());
  file.setAttribute("/", "viewpeel_result_format", kResultFormat);
  if (content.has_environment_alone) file.setAttribute("/", "only", std::string("environment"));
  file.setAttribute("/", "row_order", std::string("faces of the scene file, or with by=surface its surfaces"));
  if (content.scene)
    file.setAttribute("/", "scene_file", std::filesystem::path(content.scene->file).filename().string());
  for (const auto& [name, value] : content.parameters) addParameter(file, name, value);
  if (form_factors.hasIntervals()) file.setAttribute("/", "unlisted_bound", form_factors.unlistedBound());
  if (form_factors.ids().rows_sum_to_one) addClosure(file, form_factors);
  return file.finish();
}

}  // namespace

void writeHdf5(const OutputContent& content, std::ostream& out) {
  const std::vector<char> bytes = makeHdf5(content);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void writeHtml(const OutputContent& content, const std::filesystem::path& file, std::ostream& out) {
  writePage(readReport(makeHdf5(content), file.string()), out);
}

}  // namespace viewpeel

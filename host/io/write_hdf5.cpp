// writeHdf5() writes a result that SciPy, AnnData and xarray all read. Compressed rows are in a group. The columns are
// also linked at the top, with dimension scales.
//   Sources: AnnData's on-disk format, csr_matrix 0.1.0; CF Conventions 1.8, section 8.2, compression by gathering.
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <optional>
#include <span>

#include <fmt/format.h>

#include "io/guesses.h"
#include "io/hdf5_frame.h"
#include "io/hdf5_output.h"
#include "io/read_report.h"
#include "io/entry_rows.h"
#include "io/shown_rows.h"
#include "io/writers.h"
#include <viewpeel/sparse_rows.h>
#include "io/stored_rows.h"
#include "report/write_page.h"
#include <viewpeel/drop_below.h>
#include <viewpeel/environment.h>
#include <viewpeel/error.h>
#include <viewpeel/solve.h>

namespace viewpeel {
namespace {

// RowColumns are the columns of entries, in the order of rows.
struct RowColumns {
  explicit RowColumns(const Ids& ids) : rows(ids.rows()), row_count(ids.rowCount()) {}

  static double formFactor(const RowEntry& entry) { return entry.form_factor.value; }
  static double standardError(const RowEntry& entry) { return entry.form_factor.standard_error; }
  uint32_t from(const RowEntry& entry) const { return rows[entry.i]; }
  uint32_t to(const RowEntry& entry) const { return rows[entry.j]; }
  int64_t pair(const RowEntry& entry) const { return from(entry) * row_count + to(entry); }

  std::vector<uint32_t> rows;  // of the file, by id
  int64_t row_count;
};

// Matrices are the form factors of a content, row by row, for as long as an Hdf5Output writes them. Large ones have no
// room in memory a second time, so that each column is read from the form factors when it is written.
class Matrices {
 public:
  explicit Matrices(const OutputContent& content)
      : content_(content), entries_(content.form_factors), columns_(content.form_factors.ids()) {
    starts_ = entries_->startsOfRows();
    if (content.balanced) balanced_.emplace(*content.balanced);
  }
  // Makes matrices whose entries others write.    In: starts: of rows among all entries, int64_t[rows + 1]
  Matrices(const OutputContent& content, std::vector<int64_t> starts)
      : content_(content), columns_(content.form_factors.ids()), starts_(std::move(starts)) {}

  void addTo(Hdf5Output& out) const {
    addMatrix(out, "form_factors", entries_, &RowColumns::formFactor);
    addMatrix(out, "standard_errors", entries_, &RowColumns::standardError);
    if (balanced_) addMatrix(out, "balanced_form_factors", balanced_, &RowColumns::formFactor);
    if (content_.form_factors.hasIntervals()) {
      addMatrix(out, "lower_bounds", entries_,
                [&](const RowEntry& entry) { return entries_->intervalOf(entry).lower; });
      addMatrix(out, "upper_bounds", entries_,
                [&](const RowEntry& entry) { return entries_->intervalOf(entry).upper; });
    }
    addPairs(out);
  }

 private:
  // Adds a column with a value for each entry between rows.    In: entries: none where others write them
  template <class T, class ValueOf>
  void addColumn(Hdf5Output& out, const std::string& name, const std::optional<EntryRows>& entries,
                 const ValueOf& valueOf) const {
    std::function<void(ByteSink&)> make;
    if (entries)
      make = [&entries, valueOf](ByteSink& sink) {
        makeColumn<T>(*entries, valueOf, [&](std::span<const char> bytes) { sink.put(bytes); });
      };
    out.writeLater<T>(name, static_cast<size_t>(starts_.back()), std::move(make));
  }

  // Adds a matrix with the columns and row starts of the form factors.
  template <class ValueOf>
  void addMatrix(Hdf5Output& out, const std::string& group, const std::optional<EntryRows>& entries,
                 const ValueOf& valueOf) const {
    addColumn<double>(out, group + "/data", entries, valueOf);
    if (group == "form_factors") {
      addColumn<int32_t>(out, group + "/indices", entries, [&](const RowEntry& entry) { return columns_.to(entry); });
      out.write(group + "/indptr", starts_);
    } else {
      out.link(group + "/indices", "form_factors/indices");
      out.link(group + "/indptr", "form_factors/indptr");
    }
    out.setAttribute(group, "encoding-type", std::string("csr_matrix"));
    out.setAttribute(group, "encoding-version", std::string("0.1.0"));
    out.setAttribute(group, "shape", std::vector<int64_t>(2, columns_.row_count));
  }

  // Links the columns of the groups to the names that users of xarray see. Links take no room.
  void addPairs(Hdf5Output& out) const {
    addColumn<int64_t>(out, "pair", entries_, [&](const RowEntry& entry) { return columns_.pair(entry); });
    out.makeScale("pair");
    out.setAttribute("pair", "compress", std::string("from to"));
    addColumn<int32_t>(out, "from", entries_, [&](const RowEntry& entry) { return columns_.from(entry); });
    out.link("to", "form_factors/indices");
    out.link("form_factor", "form_factors/data");
    out.link("standard_error", "standard_errors/data");
    std::vector<std::string> of_pairs = {"form_factor", "standard_error", "from", "to"};
    if (balanced_) {
      out.link("balanced_form_factor", "balanced_form_factors/data");
      of_pairs.push_back("balanced_form_factor");
    }
    if (content_.form_factors.hasIntervals())
      for (const std::string name : {"lower", "upper"}) {
        out.link(name, name + "_bounds/data");
        of_pairs.push_back(name);
      }
    if (hasGuesses(content_)) {
      addColumn<uint8_t>(out, "is_guess", entries_,
                         [&](const RowEntry& entry) { return isGuess(content_, entry.i, entry.j); });
      of_pairs.push_back("is_guess");
    }
    for (const std::string& column : of_pairs) out.useScale(column, "pair");
    for (const std::string& column : of_pairs)
      if (column != "from" && column != "to") out.setAttribute(column, "units", std::string("1"));
  }

  const OutputContent& content_;
  std::optional<EntryRows> entries_, balanced_;
  RowColumns columns_;
  std::vector<int64_t> starts_;
};

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

// Adds everything but the matrices.
void addRest(Hdf5Output& file, const OutputContent& content) {
  const FormFactors& form_factors = content.form_factors;
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
}

// Makes the file, and passes it to finish(Hdf5Output&).
void makeHdf5(const OutputContent& content, const std::function<void(Hdf5Output&)>& finish) {
  std::optional<Matrices> matrices;
  if (!content.has_environment_alone) matrices.emplace(content);
  Hdf5Output file;
  if (matrices) matrices->addTo(file);
  addRest(file, content);
  finish(file);
}

}  // namespace

void writeHdf5(const OutputContent& content, std::ostream& out) {
  makeHdf5(content, [&](Hdf5Output& made) { made.finish(out); });
}

std::map<std::string, uint64_t> writeHdf5Frame(const OutputContent& rows, const std::vector<int64_t>& starts,
                                               std::ostream& out) {
  const Matrices matrices(rows, starts);
  Hdf5Output frame;
  matrices.addTo(frame);
  addRest(frame, rows);
  return frame.finishFrame(out);
}

void writeHdf5Block(const FormFactors& block, const std::vector<int64_t>& starts,
                    const std::map<std::string, uint64_t>& places, const std::string& file) {
  const EntryRows entries(block);
  const RowColumns columns(block.ids());
  const auto first =
      static_cast<uint32_t>(std::ranges::find(block.ids().requested, true) - block.ids().requested.begin());
  if (first == block.ids().count()) return;
  errno = 0;
  std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
  const auto write = [&]<class T>(const char* name, T, const auto& valueOf) {
    out.seekp(static_cast<std::streamoff>(places.at(name) + sizeof(T) * starts[columns.rows[first]]));
    makeColumn<T>(entries, valueOf, [&](std::span<const char> bytes) {
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    });
  };
  if (starts.back() > 0) {
    write("form_factors/data", double(), &RowColumns::formFactor);
    write("form_factors/indices", int32_t(), [&](const RowEntry& entry) { return columns.to(entry); });
    write("standard_errors/data", double(), &RowColumns::standardError);
    write("pair", int64_t(), [&](const RowEntry& entry) { return columns.pair(entry); });
    write("from", int32_t(), [&](const RowEntry& entry) { return columns.from(entry); });
  }
  out.close();
  if (!out)
    throw Error(ErrorCode::output, fmt::format("{}: cannot write: {}; choose a place that all ranks can write to", file,
                                               std::strerror(errno ? errno : EIO)));
}

void writeHtml(const OutputContent& content, const std::filesystem::path& file, std::ostream& out) {
  makeHdf5(content, [&](Hdf5Output& made) { writePage(readReport(made.finish(), file.string()), out); });
}

}  // namespace viewpeel

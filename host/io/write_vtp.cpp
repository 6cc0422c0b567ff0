// writeVtp() writes VTK's XML PolyData. Arrays are raw bytes, little-endian, each after its length in 64 bits.
//   Source: Kitware, The VTK User's Guide, 11th edition, VTK file formats.
#include <cstring>
#include <functional>

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <viewpeel/drop_below.h>
#include <viewpeel/environment.h>
#include <viewpeel/solve.h>
#include "io/shown_rows.h"
#include "io/writers.h"

namespace viewpeel {
namespace {

std::string escapeXml(const std::string& text) {
  std::string escaped;
  for (char c : text) {
    if (c == '&') escaped += "&amp;";
    else if (c == '<') escaped += "&lt;";
    else if (c == '"') escaped += "&quot;";
    else if (static_cast<unsigned char>(c) < 32) escaped += '?';
    else escaped += c;
  }
  return escaped;
}

// Arrays collects declarations and bytes: all arrays are declared first, and their bytes follow in the same order.
class Arrays {
 public:
  template <class T>
  std::string add(const std::string& name, const char* type, std::vector<T> values, int components = 1) {
    const std::string line = fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type,
        escapeXml(name), components, offset_);
    std::string bytes(sizeof(uint64_t) + values.size() * sizeof(T), '\0');
    const uint64_t size = values.size() * sizeof(T);
    std::memcpy(bytes.data(), &size, sizeof size);
    if (size) std::memcpy(bytes.data() + sizeof size, values.data(), size);
    offset_ += bytes.size();
    blocks_.push_back(std::move(bytes));
    return line;
  }
  void write(std::ostream& out) const {
    for (const std::string& block : blocks_) out.write(block.data(), static_cast<std::streamsize>(block.size()));
  }

 private:
  std::vector<std::string> blocks_;
  uint64_t offset_ = 0;
};

// Declares an array of texts: the codes of their bytes, a 0 after each text.
std::string textArray(const std::string& name, uint32_t count,
                      const std::function<const std::string&(uint32_t)>& textOf) {
  std::string line = fmt::format("<DataArray type=\"String\" Name=\"{}\" format=\"ascii\">", name);
  for (uint32_t k = 0; k < count; ++k) {
    for (char c : textOf(k)) fmt::format_to(std::back_inserter(line), "{} ", static_cast<unsigned char>(c));
    line += "0\n";
  }
  return line + "</DataArray>\n";
}

const std::string kRowOrder =
    "faces of the scene file, from 0, or with by=surface its surfaces: the array 'row' has each polygon's";

// Returns the arrays of the polygons. Each polygon has the values of its row.
std::string cellData(const OutputContent& content, Arrays& arrays) {
  const FormFactors& f = content.form_factors;
  const Ids& ids = f.ids();
  const Scene& scene = *content.scene;
  const auto polygon_count = static_cast<uint32_t>(scene.polygons.size());
  const std::vector<uint32_t> id_of_polygon = idsOfPolygons(scene, ids);
  std::vector<double> largest(ids.count(), 0);
  for (const FormFactors::Entry& entry : f.entries()) {
    largest[entry.i] = std::max(largest[entry.i], entry.exchange_area.standard_error / ids.areas[entry.i]);
    if (entry.j < kEnvironment)
      largest[entry.j] = std::max(largest[entry.j], entry.exchange_area.standard_error / ids.areas[entry.j]);
  }
  const auto add = [&](const std::string& name, auto valueOf) {
    std::vector<double> values(polygon_count);
    for (uint32_t k = 0; k < polygon_count; ++k) values[k] = valueOf(id_of_polygon[k]);
    return arrays.add(name, "Float64", values);
  };
  std::vector<double> areas(polygon_count);
  for (uint32_t k = 0; k < polygon_count; ++k) areas[k] = scene.polygons[k].area * scene.scale * scene.scale;
  const std::vector<uint32_t> rows = ids.rows();
  std::vector<int32_t> row_of_polygon(polygon_count);
  for (uint32_t k = 0; k < polygon_count; ++k) row_of_polygon[k] = static_cast<int32_t>(rows[id_of_polygon[k]]);
  std::string text = arrays.add("area", "Float64", areas) + arrays.add("row", "Int32", row_of_polygon);
  if (!content.has_environment_alone && !content.has_heat_alone) {
    text += add("row_sum", [&](uint32_t id) { return f.rowSums()[id].value; });
    text += add("leak", [&](uint32_t id) { return f.formFactor(id, kLeak).value; });
  }
  if (!content.has_heat_alone) {
    text += add("environment", [&](uint32_t id) { return f.formFactor(id, kEnvironment).value; });
    text += add("standard_error", [&](uint32_t id) { return largest[id]; });
  }
  if (content.parts) {
    text += add("environment_up", [&](uint32_t id) { return content.parts->up[id].value; });
    text += add("environment_down", [&](uint32_t id) { return content.parts->down[id].value; });
  }
  if (content.heat) {
    const std::vector<HeatRow>& rows_of_heat = content.heat->rows;
    text += add("temperature", [&](uint32_t id) { return rows_of_heat[id].temperature.value; });
    text += add("radiosity", [&](uint32_t id) { return rows_of_heat[id].radiosity.value; });
    text += add("irradiation", [&](uint32_t id) { return rows_of_heat[id].irradiation.value; });
    text += add("heat_flux", [&](uint32_t id) { return rows_of_heat[id].heat_flux.value; });
  }
  if (content.dropped) text += add("dropped", [&](uint32_t id) { return content.dropped->sums[id].value; });
  for (const std::string& name : content.shown) {
    const std::vector<double> values = formFactorsFrom(f, shownIds(scene, ids, name));
    text += add("from " + name, [&](uint32_t id) { return values[id]; });
  }
  text += textArray("surface", polygon_count, [&](uint32_t k) -> const std::string& {
    return scene.surfaces[scene.faces[scene.polygons[k].face].surface].name;
  });
  return text + textArray("name", polygon_count,
                          [&](uint32_t k) -> const std::string& { return ids.names[id_of_polygon[k]]; });
}

}  // namespace

void writeVtp(const OutputContent& content, std::ostream& out) {
  const Scene& scene = *content.scene;
  Arrays arrays;
  const std::string cells = cellData(content, arrays);
  std::vector<double> points;
  for (const glm::dvec3& corner : scene.corners)
    for (int axis = 0; axis < 3; ++axis) points.push_back(scene.centre[axis] + scene.scale * corner[axis]);
  std::vector<int64_t> connectivity, ends;
  for (const Polygon& polygon : scene.polygons) {
    for (uint32_t k = 0; k < polygon.corner_count; ++k) connectivity.push_back(polygon.first_corner + k);
    ends.push_back(static_cast<int64_t>(connectivity.size()));
  }
  const std::string places = arrays.add("Points", "Float64", points, 3);
  const std::string corners = arrays.add("connectivity", "Int64", connectivity) + arrays.add("offsets", "Int64", ends);
  fmt::print(out,
             "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
             "header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n{}</FieldData>\n<Piece NumberOfPoints=\"{}\" "
             "NumberOfVerts=\"0\" "
             "NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n<CellData Scalars=\"{}\">\n{}"
             "</CellData>\n<Points>\n{}</Points>\n<Polys>\n{}</Polys>\n</Piece>\n</PolyData>\n"
             "<AppendedData encoding=\"raw\">\n_",
             textArray("row_order\" NumberOfTuples=\"1", 1, [](uint32_t) -> const std::string& { return kRowOrder; }),
             scene.corners.size(), scene.polygons.size(),
             content.has_environment_alone ? "environment"
             : content.has_heat_alone      ? "temperature"
                                           : "row_sum",
             cells, places, corners);
  arrays.write(out);
  out << "\n</AppendedData>\n</VTKFile>\n";
}

}  // namespace viewpeel

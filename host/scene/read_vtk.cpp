// These functions read VTK's XML files: polygons of .vtp, and faces of .vtu.
#include <cmath>
#include <map>

#include "scene/readers.h"
#include "scene/vtk_arrays.h"

namespace viewpeel {
namespace {

// The first of these cell arrays that exists names the surfaces.
constexpr const char* kSurfaceArrays[] = {"surface",     "Surface",       "group",         "name",     "Name",
                                          "PhysicalIds", "gmsh:physical", "CellEntityIds", "Material", "material"};
// Cells of these types are faces. In types of order 2 mid nodes follow the corners.
constexpr int64_t kTriangle = 5, kPolygon = 7, kQuad = 9, kTriangle2 = 22, kQuad2 = 23;

class VtkReader {
 public:
  VtkReader(const std::filesystem::path& file, const char* kind)
      : file_(file, kind), stem_(file.stem().string()), is_polydata_(kind == std::string("PolyData")) {
    scene_.file = file.string();
  }

  InputScene read() {
    for (const pugi::xml_node& piece : file_.grid().children("Piece")) readPiece(piece);
    if (passed_over_)
      scene_.warnings.push_back(
          fmt::format("{}: {} cells are no faces and are passed over; export the surface", scene_.file, passed_over_));
    return std::move(scene_);
  }

 private:
  pugi::xml_node find(const pugi::xml_node& parent, const char* name) const {
    for (const char* kind : {"DataArray", "Array"})
      if (const pugi::xml_node array = parent.find_child_by_attribute(kind, "Name", name)) return array;
    file_.refuse(fmt::format("there is no array '{}'; export the file again", name));
  }

  void readPiece(const pugi::xml_node& piece) {
    const std::vector<double> points = file_.numbers(piece.child("Points").child("DataArray"));
    // Cells are counted in the order of vertices, lines, polygons, strips.
    uint64_t first = 0;
    if (is_polydata_) {
      first = piece.attribute("NumberOfVerts").as_ullong() + piece.attribute("NumberOfLines").as_ullong();
      passed_over_ += first + piece.attribute("NumberOfStrips").as_ullong();
    }
    const pugi::xml_node cells = piece.child(is_polydata_ ? "Polys" : "Cells");
    if (!cells || cells.first_child().empty()) return;
    const std::vector<int64_t> corners = file_.integers(find(cells, "connectivity"));
    const std::vector<int64_t> ends = file_.integers(find(cells, "offsets"));
    const std::vector<int64_t> types =
        is_polydata_ ? std::vector<int64_t>(ends.size(), kPolygon) : file_.integers(find(cells, "types"));
    if (types.size() != ends.size()) file_.refuse("'types' and 'offsets' differ in length; export the file again");
    const std::vector<std::string> names = surfaceNames(piece.child("CellData"));
    int64_t start = 0;
    for (size_t k = 0; k < ends.size(); ++k) {
      if (ends[k] < start || ends[k] > static_cast<int64_t>(corners.size()))
        file_.refuse(fmt::format("cell {} ends out of range; export the file again", k));
      const std::vector<int64_t> nodes(corners.begin() + start, corners.begin() + ends[k]);
      start = ends[k];
      addCell(nodes, types[k], points, first + k < names.size() ? names[first + k] : stem_);
    }
  }

  void addCell(const std::vector<int64_t>& nodes, int64_t type, const std::vector<double>& points,
               const std::string& surface) {
    const bool is_second = type == kTriangle2 || type == kQuad2;
    if (!is_second && type != kTriangle && type != kPolygon && type != kQuad) {
      ++passed_over_;
      return;
    }
    const size_t corner_count = is_second ? nodes.size() / 2 : nodes.size();
    const auto [at, is_new] = surfaces_.try_emplace(surface, static_cast<uint32_t>(scene_.surface_names.size()));
    if (is_new) scene_.surface_names.push_back(surface);
    InputFace face{{}, at->second, 0};
    for (size_t k = 0; k < corner_count; ++k) {
      face.corners.push_back(point(points, nodes[k]));
      if (is_second) face.corners.push_back(point(points, nodes[corner_count + k]));
    }
    if (face.corners.size() < 3) file_.refuse("a face has fewer than three corners; export the file again");
    scene_.faces.push_back(std::move(face));
  }

  glm::dvec3 point(const std::vector<double>& points, int64_t node) const {
    if (node < 0 || node >= static_cast<int64_t>(points.size() / 3))
      file_.refuse(fmt::format("there is no point {}; export the file again", node));
    const double* p = &points[3 * static_cast<size_t>(node)];
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
      file_.refuse(fmt::format("point {} is not finite; correct it", node));
    return {p[0], p[1], p[2]};
  }

  std::vector<std::string> surfaceNames(const pugi::xml_node& cell_data) const {
    for (const char* name : kSurfaceArrays)
      for (const pugi::xml_node& array : cell_data.children()) {
        if (array.attribute("Name").as_string() != std::string(name)) continue;
        if (array.attribute("type").as_string() == std::string("String")) return file_.texts(array);
        std::vector<std::string> names;
        for (double value : file_.numbers(array)) names.push_back(fmt::format("{} {:g}", name, value));
        return names;
      }
    return {};
  }

  VtkFile file_;
  std::string stem_;
  bool is_polydata_;
  InputScene scene_;
  std::map<std::string, uint32_t> surfaces_;
  uint64_t passed_over_ = 0;
};

}  // namespace

InputScene readVtp(const std::filesystem::path& file) { return VtkReader(file, "PolyData").read(); }

InputScene readVtu(const std::filesystem::path& file) { return VtkReader(file, "UnstructuredGrid").read(); }

}  // namespace viewpeel

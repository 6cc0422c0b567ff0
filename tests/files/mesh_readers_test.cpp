// These tests read meshes that other programs have written: Gmsh, VTK, and viewpeel itself.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <glm/glm.hpp>
#include <gtest/gtest.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include <viewpeel/ids.h>
#include "scene/readers.h"
#include "tests/support/python.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

class Meshes : public TestFolder {
 protected:
  std::string refusal(const std::string& name, const std::string& text) const {
    const fs::path file = write(name, text);
    return withoutPlace(refusalOf([&] { loadScene(file); }), file.string().size());
  }
};

// The room is 1 x 2 x 3 m, in millimetres. It has a volume, so that the reader meets points, edges and tetrahedra and
// skips them.
constexpr const char* kRoom =
    "SetFactory(\"OpenCASCADE\");\nBox(1) = {0,0,0, 1000,2000,3000};\nMesh.MeshSizeMax = 900;\n"
    "Physical Surface(\"walls x\") = {1, 2};\nPhysical Surface(\"walls y\") = {3, 4};\nPhysical Surface(7) = {5, 6};\n"
    "Physical Volume(\"air\") = {1};\n";

TEST_F(Meshes, GmshWritesThemInEveryVersion) {
  write("room.geo", kRoom);
  std::map<std::string, std::vector<double>> areas;
  for (const char* format : {"msh22", "msh41"})
    for (const char* binary : {"", "-bin"})
      for (const int order : {1, 2}) {
        const std::string name = fmt::format("{}{}{}.msh", format, binary, order);
        ASSERT_EQ(std::system(fmt::format("cd '{}' && gmsh -3 -order {} room.geo -format {} {} -o {} >said 2>&1",
                                          folder_.string(), order, format, binary, name)
                                  .c_str()),
                  0);
        SceneOptions millimetres;
        millimetres.unit_m = 1e-3;
        const InputScene input = readMsh(folder_ / name);
        EXPECT_EQ(input.faces[0].corners.size(), order == 1 ? 3u : 6u) << name;
        const Scene scene = buildScene(input, millimetres);
        const Ids ids = makeIds(scene, By::surface, false);
        ASSERT_EQ(ids.names, (std::vector<std::string>{"walls x", "walls y", "physical 7"})) << name;
        // The files' text has 16 digits.
        EXPECT_NEAR(ids.areas[0], 12, 1e-11) << name;
        EXPECT_NEAR(ids.areas[1], 6, 1e-11) << name;
        EXPECT_NEAR(ids.areas[2], 4, 1e-11) << name;
        areas[fmt::format("{}", order)].push_back(double(input.faces.size()));
      }
  for (const auto& [order, counts] : areas)
    for (double count : counts) EXPECT_EQ(count, counts[0]) << order;
}

TEST_F(Meshes, GmshFilesThatAreNoneAreRefused) {
  const std::string head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n";
  const std::string face = "$Elements\n1\n1 2 2 0 5 1 2 3\n$EndElements\n";
  EXPECT_EQ(refusal("a.msh", head + face), "none");
  EXPECT_EQ(readMsh(folder_ / "a.msh").surface_names, std::vector<std::string>{"entity 5"});
  EXPECT_EQ(refusal("a.msh", "$Nodes\n0\n$EndNodes\n"),
            ":1: not a Gmsh mesh: $MeshFormat comes first; save it as .msh again");
  EXPECT_EQ(refusal("a.msh", "solid\n"), ":1: 'solid' begins no section of a Gmsh mesh");
  EXPECT_EQ(refusal("a.msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n"), ":2: version 4 is not read; save as 2.2 or 4.1");
  EXPECT_EQ(refusal("a.msh", head + "$Elements\n1\n1 2 2 0 5 1 2 9\n$EndElements\n"),
            ":12: there is no node 9; save the mesh again");
  EXPECT_EQ(refusal("a.msh", head + "$Elements\n1\n1 21 2 0 5 1 2 3 1 2 3 1 2 3 1\n$EndElements\n"),
            ":12: element type 21 is of order 3 or more; save the mesh with order 1 or 2");
  EXPECT_EQ(refusal("a.msh", head + "$Elements\n1\n1 2 2 0 x"),
            ":12: 'x' in the place of a tag is not a whole number; correct it");
  EXPECT_EQ(refusal("a.msh", head + "$Elements\n2\n1 2 2 0 5 1 2 3\n"),
            ":13: the file ends before an element; export it again");
  EXPECT_EQ(refusal("a.msh", head), ": no usable polygon; the file has no faces, check the export");
  EXPECT_EQ(refusal("a.msh", std::string("$MeshFormat\n4.1 1 8\n\0\0\0\1", 24)),
            ": the mesh is big-endian; save it as text");
}

// VTK's own writers write a line, a square and a triangle in every encoding. The line counts as a cell, too.
constexpr const char* kWriteVtk = R"(
import vtk
points = vtk.vtkPoints()
points.SetDataTypeToDouble()
for p in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (.5, 2, 1 / 3)):
    points.InsertNextPoint(*p)
names, groups = vtk.vtkStringArray(), vtk.vtkIntArray()
names.SetName('surface')
groups.SetName('group')
for name in ('edge', 'Tür', 'gable'):
    names.InsertNextValue(name)
    groups.InsertNextValue(len(name))
cells = ((0, 1), (0, 1, 2, 3), (3, 2, 4))
mesh = vtk.vtkPolyData()
mesh.SetPoints(points)
lines, polys = vtk.vtkCellArray(), vtk.vtkCellArray()
grid = vtk.vtkUnstructuredGrid()
grid.SetPoints(points)
for corners, kind in zip(cells, (vtk.VTK_LINE, vtk.VTK_QUAD, vtk.VTK_TRIANGLE)):
    ids = vtk.vtkIdList()
    for c in corners:
        ids.InsertNextId(c)
    grid.InsertNextCell(kind, ids)
    (lines if len(corners) == 2 else polys).InsertNextCell(ids)
mesh.SetLines(lines)
mesh.SetPolys(polys)
mesh.GetCellData().AddArray(names)
grid.GetCellData().AddArray(groups)
for data, writer, end in ((mesh, vtk.vtkXMLPolyDataWriter, 'vtp'), (grid, vtk.vtkXMLUnstructuredGridWriter, 'vtu')):
    for mode in ('Ascii', 'Binary', 'Appended'):
        for compressor in ('None', 'ZLib'):
            for header in (32, 64):
                for encodes in (0, 1):
                    w = writer()
                    w.SetInputData(data)
                    getattr(w, 'SetDataModeTo' + mode)()
                    getattr(w, 'SetCompressorTypeTo' + compressor)()
                    getattr(w, 'SetHeaderTypeToUInt%d' % header)()
                    w.SetEncodeAppendedData(encodes)
                    w.SetFileName('%s-%s-%d-%d.%s' % (mode, compressor, header, encodes, end))
                    w.Write()
)";

TEST_F(Meshes, VtkWritesThemInEveryEncoding) {
  const PythonResult written = runPython(folder_, kWriteVtk);
  ASSERT_EQ(written.status, 0) << written.output;
  int count = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const bool is_polydata = entry.path().extension() == ".vtp";
    if (!is_polydata && entry.path().extension() != ".vtu") continue;
    ++count;
    const InputScene input = is_polydata ? readVtp(entry.path()) : readVtu(entry.path());
    ASSERT_EQ(input.faces.size(), 2u) << entry.path();
    EXPECT_EQ(input.surface_names, is_polydata ? (std::vector<std::string>{"Tür", "gable"})
                                               : (std::vector<std::string>{"group 3", "group 5"}))
        << entry.path();
    const std::vector<glm::dvec3> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    EXPECT_EQ(input.faces[0].corners, square) << entry.path();
    ASSERT_EQ(input.faces[1].corners.size(), 3u);
    // Text has as many digits as a double.
    EXPECT_NEAR(input.faces[1].corners[2].z, 1 / 3.0, 1e-15) << entry.path();
    EXPECT_EQ(input.warnings.size(), 1u) << entry.path();  // about the line
  }
  EXPECT_EQ(count, 48);
}

// The .vtp of a result is read again as the same scene.
TEST_F(Meshes, AVtpOfResultsIsAScene) {
  const fs::path file = write("two.obj", "o a\nv 0 0 0\nv 3 0 0\nv 3 2 0\nv 0 2 0\nf 1 2 3 4\no b\nf 4 3 2\n");
  const std::string command = fmt::format("'{}' compute '{}' --quiet --directions 8 -o '{}'", VIEWPEEL_PROGRAM,
                                          file.string(), (folder_ / "two.vtp").string());
  ASSERT_EQ(std::system(command.c_str()), 0);
  const InputScene input = readVtp(folder_ / "two.vtp");
  EXPECT_EQ(input.surface_names, (std::vector<std::string>{"a", "b"}));
  ASSERT_EQ(input.faces.size(), 2u);
  EXPECT_LT(glm::distance(input.faces[0].corners[2], glm::dvec3(3, 2, 0)), 1e-15 * 4);
}

TEST_F(Meshes, VtkFilesThatAreNoneAreRefused) {
  const auto file = [](const std::string& arrays, const std::string& attributes = "") {
    return fmt::format(
        "<VTKFile type=\"PolyData\" {}><PolyData><Piece NumberOfPoints=\"3\"><Points><DataArray "
        "type=\"Float64\" format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Polys>{}</Polys>"
        "</Piece></PolyData></VTKFile>",
        attributes, arrays);
  };
  const auto array = [](const char* name, const std::string& text) {
    return fmt::format("<DataArray type=\"Int64\" Name=\"{}\" format=\"ascii\">{}</DataArray>", name, text);
  };
  EXPECT_EQ(refusal("a.vtp", file(array("connectivity", "0 1 2") + array("offsets", "3"))), "none");
  EXPECT_EQ(refusal("a.vtp", "<VTKFile>"), ": not XML at byte 8: Start-end tags mismatch; export it again");
  EXPECT_EQ(refusal("a.vtu", file("")), ": not a VTK file of UnstructuredGrid; export it again");
  EXPECT_EQ(refusal("a.vtp", file("", "byte_order=\"BigEndian\"")),
            ": the file is big-endian; export it little-endian");
  EXPECT_EQ(refusal("a.vtp", file("", "compressor=\"vtkLZ4DataCompressor\"")),
            ": compressed by vtkLZ4DataCompressor; export it with zlib or without compression");
  EXPECT_EQ(refusal("a.vtp", file(array("offsets", "3"))), ": there is no array 'connectivity'; export the file again");
  EXPECT_EQ(refusal("a.vtp", file(array("connectivity", "0 1 x") + array("offsets", "3"))),
            ": 'x' in array 'connectivity' is not a number; correct it");
  EXPECT_EQ(refusal("a.vtp", file(array("connectivity", "0 1 3") + array("offsets", "3"))),
            ": there is no point 3; export the file again");
  EXPECT_EQ(refusal("a.vtp", file(array("connectivity", "0 1 2") + array("offsets", "4"))),
            ": cell 0 ends out of range; export the file again");
  EXPECT_EQ(refusal("a.vtp", file(array("connectivity", "0 1 2") + "<DataArray type=\"Int64\" Name=\"offsets\" "
                                                                   "format=\"binary\">CAAAAAMA</DataArray>")),
            ": an array is cut off; export the file again");
}

// With a unit areas are in square metres. Corners, which have no unit, stay the same.
TEST_F(Meshes, UnitsScaleAreasAlone) {
  const fs::path file = write("two.obj", "o a\nv 0 0 0\nv 300 0 0\nv 300 200 0\nv 0 200 0\nf 1 2 3 4\n");
  SceneOptions millimetres;
  millimetres.unit_m = 1e-3;
  const Scene in_metres = loadScene(file, millimetres), plain = loadScene(file);
  EXPECT_NEAR(makeIds(in_metres, By::polygon, false).areas[0], 0.06, 1e-16);
  EXPECT_EQ(makeIds(plain, By::polygon, false).areas[0], 60000);
  EXPECT_EQ(in_metres.corners, plain.corners);
}

}  // namespace
}  // namespace viewpeel

// These tests read meshes of OpenFOAM v1912 in all its formats, and run its solver with viewpeel's view factors, on one
// rank and on two.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/glm.hpp>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include <viewpeel/write.h>
#include "scene/foam_case.h"
#include "scene/readers.h"
#include "tests/files/foam_case.h"
#include "tests/support/python.h"
#include "tests/support/random_form_factors.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

// v1912 computes sigma from rounded values of k, h and c (etc/controlDict).
constexpr const char* kRadiosity =
    "import re, numpy as np\n"
    "T = dict(zip('west east south north floor ceiling'.split(), (1000., 300., 400., 500., 600., 700.)))\n"
    "E = dict(zip('west east south north floor ceiling'.split(), (.9, .8, .7, .6, .5, .4)))\n"
    "sigma = np.pi**2 / 60 * 1.38065e-23**4 / ((6.62607e-34 / (2 * np.pi))**3 * 2.99792e8**2)\n"
    "def net_flux(F, walls):\n"  // the lack of a row sees 0 K
    "    t, e = np.array([T[w] for w in walls]), np.array([E[w] for w in walls])\n"
    "    J = np.linalg.solve(np.eye(len(F)) - (1 - e)[:, None] * F, e * sigma * t**4)\n"
    "    return J - F @ J\n"
    // found() returns qr of the fine faces of a wall, positive into it. A wall with one value has it once in the file.
    "def found(folder, wall, count):\n"
    "    text = open(folder + '/1/qr').read()\n"
    "    text = text[text.index('boundaryField'):]\n"
    "    block = text[re.search(r'\\n    %s\\n' % wall, text).start():]\n"
    "    m = re.search(r'\\bvalue\\s+(?:uniform\\s+(\\S+);|nonuniform List<scalar>\\s*\\d+\\s*\\(([^)]*)\\))', block)\n"
    "    return -np.array([float(m.group(1))] * count if m.group(1) else [float(x) for x in m.group(2).split()])\n"
    "def off(F):\n"
    "    q, worst = net_flux(F, [w for _, w, _ in rows]), 0\n"
    "    scale, at = abs(q).max(), {}\n"
    "    for k, (folder, wall, fine) in enumerate(rows):\n"
    "        values = found(folder, wall, 1 + max(f for g, w, ff in rows if (g, w) == (folder, wall) for f in ff))\n"
    "        worst = max(worst, abs(values[fine] - q[k]).max() / scale)\n"
    "    return worst\n";

class OpenFoam : public FoamCase {
 protected:
  // `rows` has folder, wall and the wall's fine faces of each coarse face, in OpenFOAM's order of coarse faces.
  std::string rowsOf(const std::string& form_factors) const {
    std::string rows = "rows = [";
    for (const FoamRank& rank : readFoamCase(folder_)) {
      const std::string of_rank = rank.folder.parent_path().filename().string();
      std::map<std::string, uint64_t> first;
      for (const auto& face : rank.coarse_faces) {
        std::string wall = face.name.substr(0, face.name.rfind('.'));
        wall = wall.substr(wall.find('/') + 1);
        const auto least = *std::min_element(face.of_mesh.begin(), face.of_mesh.end());
        if (!first.count(wall)) first[wall] = least;
        first[wall] = std::min(first[wall], least);
      }
      for (const auto& face : rank.coarse_faces) {
        std::string wall = face.name.substr(0, face.name.rfind('.'));
        wall = wall.substr(wall.find('/') + 1);
        std::vector<uint64_t> fine;
        for (uint64_t k : face.of_mesh) fine.push_back(k - first[wall]);
        rows += fmt::format("('{}', '{}', {}), ", of_rank.starts_with("processor") ? of_rank : ".", wall, fine);
      }
    }
    return rows + "]\nF = np.array(" + form_factors + ")\n";
  }
  void expectSolved(const std::string& form_factors) const {
    const PythonResult result =
        runPython(folder_, kRadiosity + rowsOf(form_factors) +
                               "assert off(F) < 1e-9, off(F)\n"
                               "order = np.arange(len(F))\norder[[0, -1]] = order[[-1, 0]]\n"
                               "assert off(F[order]) > 1e-3 and off(F[:, order]) > 1e-3 and off(F.T) > 1e-3\n"
                               "print('passed')\n");
    EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
  }
  std::string refusal() const {
    try {
      readFoam(folder_);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return std::string(error.what()).substr(folder_.string().size() + 1);
    }
    return "none";
  }
};

// Text, binary and gzip files give the same scene. All walls look into the room, and each coarse face is a surface.
TEST_F(OpenFoam, MeshesInEveryFormatAreOneScene) {
  std::vector<InputScene> scenes;
  // v1912 compresses text only.
  for (const auto& [format, compression] : {std::pair("ascii", "off"), {"ascii", "on"}, {"binary", "off"}}) {
    fs::remove_all(folder_);
    fs::copy(VIEWPEEL_TEST_FILES "/openfoam_room", folder_, fs::copy_options::recursive);
    replace("system/controlDict", "writeFormat ascii", std::string("writeFormat ") + format);
    replace("system/controlDict", "writeCompression off", std::string("writeCompression ") + compression);
    runFoam("blockMesh");
    runFoam("faceAgglomerate");
    EXPECT_EQ(fs::exists(folder_ / "constant/polyMesh/points.gz"), std::string(compression) == "on");
    scenes.push_back(readFoam(folder_));
  }
  ASSERT_EQ(scenes[0].surface_names.size(), 12u);
  EXPECT_EQ(scenes[0].surface_names[3], "east.1");
  EXPECT_TRUE(scenes[0].warnings.empty());
  for (const InputScene& scene : scenes) {
    EXPECT_EQ(scene.surface_names, scenes[0].surface_names);
    ASSERT_EQ(scene.faces.size(), 24u);
    for (size_t k = 0; k < 24; ++k) {
      EXPECT_EQ(scene.faces[k].surface, scenes[0].faces[k].surface);
      EXPECT_EQ(scene.faces[k].corners, scenes[0].faces[k].corners);  // multiples of 1/2 are exact in text
    }
  }
  const Scene scene = buildScene(scenes[0]);
  EXPECT_TRUE(isClosed(scene));
  for (const Polygon& polygon : scene.polygons)
    EXPECT_LT(glm::dot(frontNormal(scene, polygon), scene.corners[polygon.first_corner]), -0.1);
}

TEST_F(OpenFoam, SolverTakesAnyMatrix) {
  runFoam("blockMesh");
  runFoam("faceAgglomerate");
  const Scene scene = buildScene(readFoam(folder_));
  const FormFactors f = randomFormFactors(makeIds(scene, By::surface, false), 3);
  writeFormFactors(OutputContent{f}, folder_);
  runFoam("buoyantSimpleFoam");
  expectSolved(dense(f));
}

TEST_F(OpenFoam, SolverOnTwoRanksTakesAnyMatrix) {
  runFoam("blockMesh");
  runFoam("decomposePar");
  runFoam("faceAgglomerate", 2);
  const Scene scene = buildScene(readFoam(folder_));
  // The matrix is sparse, so that rows differ in length.
  const FormFactors f = randomFormFactors(makeIds(scene, By::surface, false), 4, 0.6);
  EXPECT_EQ(f.ids().names[0], "processor0/west.0");
  EXPECT_EQ(filesOf(folder_, false).size(), 12u);
  writeFormFactors(OutputContent{f}, folder_);
  runFoam("buoyantSimpleFoam", 2);
  expectSolved(dense(f));
}

// As a user does it, the program computes in the case's folder, and OpenFOAM solves.
TEST_F(OpenFoam, ProgramComputesWhatTheSolverReads) {
  runFoam("blockMesh");
  runFoam("faceAgglomerate");
  const std::string command = fmt::format("cd '{}' && '{}' compute . --by surface --quiet -o . -o room.npz >said 2>&1",
                                          folder_.string(), VIEWPEEL_PROGRAM);
  ASSERT_EQ(std::system(command.c_str()), 0);
  runFoam("buoyantSimpleFoam");
  const PythonResult result = runPython(folder_, kRadiosity + rowsOf("0") +
                                                     "import scipy.sparse\n"
                                                     "F = scipy.sparse.load_npz('room.npz').toarray()\n"
                                                     "assert abs(F.sum(axis=1) - 1).max() < 1e-6\n"
                                                     "assert off(F) < 1e-9, off(F)\nprint('passed')\n");
  EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
}

TEST_F(OpenFoam, OtherRowsAreRefused) {
  runFoam("blockMesh");
  runFoam("faceAgglomerate");
  const Scene scene = buildScene(readFoam(folder_));
  EXPECT_NO_THROW(checkRows(folder_, scene, makeIds(scene, By::surface, false)));
  try {
    checkRows(folder_, scene, makeIds(scene, By::polygon, false));
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).substr(folder_.string().size()),
              ": rows are to be its 12 coarse faces, and row 1 is 'west.0[1]' in place of 'west.0'; compute this case "
              "with --by surface");
  }
}

TEST_F(OpenFoam, ErrorsNameFileAndLine) {
  EXPECT_NE(refusal().find("is a directory without constant/polyMesh"), std::string::npos);
  runFoam("blockMesh");
  EXPECT_EQ(readFoam(folder_).surface_names.size(), 24u);  // every face is a coarse face
  runFoam("faceAgglomerate");
  const fs::path boundary = folder_ / "constant/polyMesh/boundary", agglom = folder_ / "constant/finalAgglom";
  const auto with = [&](const fs::path& file, const std::string& old, const std::string& text) {
    const fs::path kept = folder_ / "kept";
    fs::copy_file(file, kept, fs::copy_options::overwrite_existing);
    replace(fs::relative(file, folder_).string(), old, text);
    const std::string said = refusal();
    fs::copy_file(kept, file, fs::copy_options::overwrite_existing);
    return said;
  };
  EXPECT_EQ(with(agglom, "\n6\n", "\n5\n"),
            "constant/finalAgglom:26: ')' is missing at the end of the lists; write the file again");
  EXPECT_EQ(with(agglom, "4(0 0 1 1)", "3(0 0 1)"),
            "constant/finalAgglom: patch 'west' has 3 faces here, and 4 in the mesh; run faceAgglomerate again");
  EXPECT_EQ(with(agglom, "4(0 0 1 1)", "4(0 0 1 7)"),
            "constant/finalAgglom: patch 'west' has a coarse face 7 out of range; run faceAgglomerate again");
  EXPECT_EQ(with(agglom, "4(0 0 1 1)", "4(0 0 2 2)"),
            "constant/finalAgglom: coarse face 1 of patch 'west' has no face; run faceAgglomerate again");
  EXPECT_EQ(with(agglom, "4(0 0 1 1)", "4(0 0 1 x)"),
            "constant/finalAgglom:21: a list is not a whole number; write the file again");
  EXPECT_EQ(with(boundary, "startFace       12;", ""),
            "constant/polyMesh/boundary:26: patch 'west' has no nFaces or no startFace; write the file again");
  EXPECT_EQ(with(boundary, "startFace       12;", "startFace       34;"),
            "constant/polyMesh/faces: there is no face 36, which a patch has; make the mesh again");
  EXPECT_EQ(
      with(boundary, "FoamFile", "FoamFilm"),
      "constant/polyMesh/boundary:1: not a file of OpenFOAM: it does not begin with FoamFile { }; write it again");
  EXPECT_EQ(with(folder_ / "constant/polyMesh/points", "(0 0 0)", "(0 0 nan)"),
            "constant/polyMesh/points:21: a coordinate is not a finite number; correct it");
  fs::remove(folder_ / "constant/polyMesh/points");
  EXPECT_EQ(refusal(), "constant/polyMesh/points: no such file; make the mesh of the case");
}

}  // namespace
}  // namespace viewpeel

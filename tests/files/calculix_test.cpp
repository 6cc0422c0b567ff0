// These tests read CalculiX decks, and let ccx 2.20 solve six walls with the .vwf files that viewpeel writes.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/glm.hpp>
#include <gtest/gtest.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include <viewpeel/write.h>
#include "scene/ccx_deck.h"
#include "scene/readers.h"
#include "tests/support/python.h"
#include "tests/support/random_form_factors.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

// Six slabs surround a room of 1 x 2 x 3. Nodes 5 to 8 of each are its inner face, R2, and its outer nodes have given
// temperatures. Conduction and control parameters are such that the fluxes at the outer nodes are the net radiation of
// the walls.
constexpr double kTemperatures[6] = {1000, 300, 400, 500, 600, 700}, kEmissivities[6] = {.9, .8, .7, .6, .5, .4};
constexpr double kSinks[6] = {300, 350, 400, 450, 500, 550};

std::string slabs() {
  using Point = glm::dvec3;
  const struct {
    Point origin, u, v;
  } walls[6] = {{{0, 0, 0}, {0, 2, 0}, {0, 0, 3}}, {{1, 0, 0}, {0, 0, 3}, {0, 2, 0}},
                {{0, 0, 0}, {0, 0, 3}, {1, 0, 0}}, {{0, 2, 0}, {1, 0, 0}, {0, 0, 3}},
                {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}}, {{0, 0, 3}, {0, 2, 0}, {1, 0, 0}}};
  std::string nodes = "** a room\n*Node, nset=ALL\n", elements = "*ELEMENT, TYPE=C3D8, ELSET=EALL\n", sets;
  for (int k = 0; k < 6; ++k) {
    const Point w = glm::normalize(glm::cross(walls[k].u, walls[k].v));
    int number = 8 * k;
    for (const double depth : {-0.1, 0.0})
      for (const auto& [a, b] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
        const Point p = walls[k].origin + double(a) * walls[k].u + double(b) * walls[k].v + depth * w;
        nodes += fmt::format("{}, {}, {}, {}\n", ++number, p.x, p.y, p.z);
      }
    elements += fmt::format("{},", k + 1);
    for (int node = 1; node <= 8; ++node)
      elements += fmt::format("{}{}", 8 * k + node, node == 4 ? ",\n" : node < 8 ? "," : "\n");
    sets += fmt::format("*NSET, NSET=O{}, GENERATE\n{}, {}, 1\n*ELSET, ELSET=E{}\n{}\n", k + 1, 8 * k + 1, 8 * k + 4,
                        k + 1, k + 1);
  }
  return nodes + elements + sets;
}

std::string deck(const std::string& radiate) {
  std::string text = slabs() +
                     "*MATERIAL, NAME=M\n*CONDUCTIVITY\n1.E7\n*SOLID SECTION, ELSET=EALL, MATERIAL=M\n"
                     "*PHYSICAL CONSTANTS, ABSOLUTE ZERO=0., STEFAN BOLTZMANN=5.669E-8\n"
                     "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, 500.\n*STEP, INC=100\n*HEAT TRANSFER, STEADY STATE\n"
                     "1., 1.\n*VIEWFACTOR, READ, INPUT=job.vwf\n*CONTROLS, PARAMETERS=FIELD\n1.E-8, 1.E-8\n*BOUNDARY\n";
  for (int k = 0; k < 6; ++k) text += fmt::format("O{}, 11, 11, {}\n", k + 1, kTemperatures[k]);
  text += radiate;
  for (int k = 0; k < 6; ++k) text += fmt::format("*NODE PRINT, NSET=O{}, TOTALS=ONLY\nRFL\n", k + 1);
  return text + "*END STEP\n";
}

// The deck names elements 1 to 6 in descending order. Rows are by element all the same.
std::string radiating() {
  std::string lines = "*RADIATE\n";
  for (int k = 5; k >= 0; --k) lines += fmt::format("E{}, R2CR, {}, {}\n", k + 1, kSinks[k], kEmissivities[k]);
  return lines;
}

// The script compares the radiosity of grey walls with the powers that ccx found. `F` and `areas` must be set before
// it.
constexpr const char* kCompare =
    "import re, numpy as np\n"
    "T, eps, sink = np.array(T), np.array(eps), np.array(sink)\nsigma = 5.669e-8\n"
    "def power(F):\n"
    "    e, rho = 1 - F.sum(axis=1), 1 - eps\n"
    "    outside = e * sigma * sink**4\n"
    "    J = np.linalg.solve(np.eye(6) - rho[:, None] * F, eps * sigma * T**4 + rho * outside)\n"
    "    return areas * (J - F @ J - outside)\n"
    "text = open('job.dat').read()\n"
    "found = np.array([float(re.search(r'total heat generation for set O%d .*?\\n\\s*\\n\\s*(\\S+)' % (k + 1), "
    "text).group(1)) for k in range(6)])\n"
    "def off(F):\n"
    "    return abs(found - power(F)).max() / abs(power(F)).max()\n";

class CalculiX : public TestFolder {
 protected:
  void runCcx(bool succeeds = true) const {
    const int status = std::system(
        fmt::format("cd '{}' && OMP_NUM_THREADS=1 /usr/bin/ccx job >said 2>&1 </dev/null", folder_.string()).c_str());
    std::ostringstream said;
    said << std::ifstream(folder_ / "said").rdbuf();
    EXPECT_EQ(status == 0, succeeds) << said.str();
  }
  std::string refusal(const std::string& text) const {
    const fs::path file = write("bad.inp", text);
    return withoutPlace(refusalOf([&] { readCcxDeck(file); }), folder_.string().size() + 1);
  }
};

std::string givens() { return fmt::format("T, eps, sink = {}, {}, {}\n", kTemperatures, kEmissivities, kSinks); }

TEST_F(CalculiX, CcxSolvesSixWallsWithAnyMatrix) {
  const fs::path file = write("job.inp", deck(radiating()));
  const Scene scene = buildScene(readInp(file));
  const FormFactors f = randomFormFactors(makeIds(scene, By::polygon, false), 11, 1, false);
  ASSERT_EQ(f.ids().names, (std::vector<std::string>{"1.R2", "2.R2", "3.R2", "4.R2", "5.R2", "6.R2"}));
  writeFormFactors(OutputContent{f, nullptr, &scene}, folder_ / "job.vwf");
  runCcx();
  std::vector<std::vector<double>> dense(6, std::vector<double>(6));
  for (uint32_t i = 0; i < 6; ++i)
    for (uint32_t j = 0; j < 6; ++j) dense[i][j] = f.formFactor(i, j).value;
  const PythonResult result = runPython(
      folder_, givens() + kCompare + fmt::format("F, areas = np.array({}), np.array({})\n", dense, f.ids().areas) +
                   "assert off(F) < 1e-5, off(F)\n"
                   "order = [1, 0, 2, 3, 4, 5]\n"
                   "assert off(F[order]) > 1e-3 and off(F[:, order]) > 1e-3 and off(F.T) > 1e-3\n"
                   "print('passed')\n");
  EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
}

// As a user does it, the program computes and ccx solves. The test compares ccx with the radiosity of the form factors
// in the file. It also compares the error of these form factors with
// the tolerance, for walls of a box have closed forms.
TEST_F(CalculiX, ProgramComputesWhatCcxReads) {
  write("job.inp", deck(radiating()));
  const std::string command =
      fmt::format("cd '{}' && '{}' compute job.inp --tolerance 1e-3 --quiet -o job.vwf -o job.npz -o job.h5 >said 2>&1",
                  folder_.string(), VIEWPEEL_PROGRAM);
  ASSERT_EQ(std::system(command.c_str()), 0);
  runCcx();
  const PythonResult result = runPython(
      folder_, givens() + kCompare +
                   "import h5py, scipy.sparse\n"
                   "F = scipy.sparse.load_npz('job.npz').toarray()\nareas = h5py.File('job.h5')['area'][:]\n"
                   "assert off(F) < 1e-5, off(F)\nassert abs(F.sum(axis=1) - 1).max() < 1e-6\nprint('passed')\n");
  EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
}

// ccx compares the version in the file with its own. Older versions do not know this record.
TEST_F(CalculiX, OtherVersionsAreRefusedByCcx) {
  const Scene scene = buildScene(readInp(write("job.inp", deck(radiating()))));
  OutputContent content{randomFormFactors(makeIds(scene, By::polygon, false), 11, 1, false), nullptr, &scene};
  for (const char* version : {"2.19", "none"}) {
    content.ccx_version = version;
    writeFormFactors(content, folder_ / "job.vwf");
    runCcx(false);
  }
}

// The file has no pairs of different cavities. The lack of the rows of a closed cavity does not leave the cavity.
TEST_F(CalculiX, CavitiesAreKeptApart) {
  std::string lines = "*RADIATE, CAVITY=1\n";
  for (int k = 1; k <= 4; ++k) lines += fmt::format("{},R2CR,300.,.9\n", k);
  lines += "*RADIATE, CAVITY=2\n5,R2CR,-1.,.9\n6,R2CR,-1.,.9\n";
  const Scene scene = buildScene(readInp(write("job.inp", deck(lines))));
  const FormFactors f = randomFormFactors(makeIds(scene, By::polygon, false), 5);
  writeFormFactors(OutputContent{f, nullptr, &scene}, folder_ / "job.vwf");
  std::vector<std::vector<double>> dense(6, std::vector<double>(6));
  for (uint32_t i = 0; i < 6; ++i)
    for (uint32_t j = 0; j < 6; ++j) dense[i][j] = f.formFactor(i, j).value;
  const PythonResult result = runPython(
      folder_, fmt::format("import numpy as np, struct\nF = np.array({})\n", dense) +
                   "raw, at, records = open('job.vwf', 'rb').read(), 0, []\n"
                   "while at < len(raw):\n"
                   "    length, = struct.unpack_from('<i', raw, at)\n"
                   "    records.append(raw[at + 4:at + 4 + length])\n"
                   "    assert struct.unpack_from('<i', raw, at + 4 + length)[0] == length\n"
                   "    at += length + 8\n"
                   "assert records[0] == b'Version 2.20'.ljust(80)\n"
                   "diagonal, pairs, outside = [np.frombuffer(r) for r in records[1:]]\n"
                   "assert (diagonal == np.diag(F)).all()\n"
                   "places = [(r, c) for c in range(6) for r in range(c + 1, 6) if (r < 4) == (c < 4)]\n"
                   "assert len(pairs) == 2 * len(places) == 14\n"
                   "assert (pairs[:7] == [F[r, c] for r, c in places]).all()\n"
                   "assert (pairs[7:] == [F[c, r] for r, c in places]).all()\n"
                   "assert abs(outside[:4] - (1 - F[:4, :4].sum(axis=1))).max() < 1e-15 and (outside[4:] == 0).all()\n"
                   "print('passed')\n");
  EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
  runCcx();
}

// Rows of one element follow the deck's lines in reverse order, and a face that is given twice keeps its place.
TEST_F(CalculiX, RowsAndFacesAreInTheOrderOfCcx) {
  write("nodes.inc", "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1.D0\n6,1,0,1\n7,1,1,1\n8,0,1,1\n9,5,5,5\n");
  const CcxDeck deck =
      readCcxDeck(write("faces.inp",
                        "*Include, input=nodes.inc\n*ELEMENT, TYPE=C3D8R, ELSET=B\n7,1,2,3,4,5,6,\n7,8\n"
                        "*ELEMENT,TYPE=DC3D4\n3,1,2,3,5\n*ELEMENT,TYPE=C3D6\n5,1,2,4,5,6,8\n"
                        "*RADIATE\n7,R3CR,300,.9\n7,R1CR,300,.9\n*RADIATE,CAVITY=12\n7,R3CR,300,.5\n"
                        "5,R1CR,300,.9\n3,R4CR,-1,.9\n3,R1,300,.9\n"));
  std::string rows;
  for (const CcxFace& face : deck.faces) rows += fmt::format("{}.R{} ", face.element, face.face);
  EXPECT_EQ(rows, "3.R4 5.R1 7.R1 7.R3 ");
  EXPECT_EQ(deck.faces[3].cavity, 12);
  EXPECT_TRUE(deck.faces[0].is_closed);
  // All faces look outward from their solids.
  const std::vector<glm::dvec3> bottom = {{0, 1, 0}, {1, 1, 0}, {1, 0, 0}, {0, 0, 0}};
  EXPECT_EQ(deck.faces[2].corners, bottom);
  const std::vector<glm::dvec3> front = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}};
  EXPECT_EQ(deck.faces[3].corners, front);
}

TEST_F(CalculiX, QuadraticFacesHaveTheirMidNodes) {
  std::string text = "*NODE\n";
  const double corners[8][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}};
  for (int k = 0; k < 8; ++k) text += fmt::format("{},{}\n", k + 1, fmt::join(corners[k], ","));
  const int edges[12][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                            {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  for (int k = 0; k < 12; ++k) {
    text += fmt::format("{}", k + 9);
    for (int axis = 0; axis < 3; ++axis)
      text += fmt::format(",{}", (corners[edges[k][0]][axis] + corners[edges[k][1]][axis]) / 2);
    text += "\n";
  }
  text += "*ELEMENT,TYPE=C3D20R\n1,1,2,3,4,5,6,7,8,9,10,\n11,12,13,14,15,16,17,18,19,20\n*RADIATE\n";
  for (int face = 1; face <= 6; ++face) text += fmt::format("1,R{}CR,300.,.9\n", face);
  const InputScene input = readInp(write("quadratic.inp", text));
  ASSERT_EQ(input.faces.size(), 6u);
  EXPECT_TRUE(input.warnings.empty());
  for (const InputFace& face : input.faces) EXPECT_EQ(face.corners.size(), 8u);
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  for (double area : ids.areas) EXPECT_NEAR(area, 4, 1e-14);
  text.replace(text.find("\n9,1,"), 5, "\n9,1.5,");  // the node moves along its edge, so the face stays flat
  EXPECT_TRUE(readInp(write("flat.inp", text)).warnings.empty());
  text.replace(text.find("\n13,1,0,2"), 9, "\n13,1,-0.3,2");
  ASSERT_EQ(readInp(write("curved.inp", text)).warnings.size(), 1u);
}

TEST_F(CalculiX, ErrorsNameFileAndLine) {
  const std::string solid =
      "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4\n1,1,2,3,4\n*SURFACE,NAME=SKIN\n1,S2\n*RADIATE\n";
  EXPECT_EQ(refusal(solid + "1,R2CR,300.,.9\n"), "none");
  EXPECT_EQ(refusal(solid), "bad.inp: no face exchanges radiation; give lines like '1,R2CR,300.,0.9' below *RADIATE");
  EXPECT_EQ(
      refusal(solid + "SKIN,R2CR,300.,.9\n"),
      "bad.inp:11: 'SKIN' is a surface, which CalculiX does not take in *RADIATE; name elements or an element set");
  EXPECT_EQ(refusal(solid + "WALL,R2CR,300.,.9\n"), "bad.inp:11: element set 'WALL' is not known; define it");
  EXPECT_EQ(refusal(solid + "2,R2CR,300.,.9\n"), "bad.inp:11: there is no element 2; correct it");
  EXPECT_EQ(refusal(solid + "1,R5CR,300.,.9\n"),
            "bad.inp:11: element 1 has no face 5 of a solid; only C3D4 to C3D20 have faces here");
  EXPECT_EQ(refusal(solid + "1,RNCR,300.,.9\n"), "bad.inp:11: label 'RNCR' names no face of a solid; use R1CR to R6CR");
  EXPECT_EQ(refusal("*NODE\n1,0,0,x\n"), "bad.inp:2: 'X' is not a number; correct it");
  EXPECT_EQ(refusal("*ELEMENT,TYPE=C3D8\n1,2,3\n*NODE\n"),
            "bad.inp:2: element 1 has 2 nodes in place of 8; complete it");
  EXPECT_EQ(refusal("*ELSET,ELSET=A\nB\n"), "bad.inp:2: element set 'B' is not known here; define it before");
  write("loop.inc", "*INCLUDE,INPUT=loop.inc\n");
  EXPECT_EQ(refusal("*INCLUDE,INPUT=loop.inc\n"),
            "loop.inc:1: includes are nested too deeply; does a file include itself?");
  EXPECT_NE(refusal("*INCLUDE,INPUT=none.inc\n").find("bad.inp:1: the included file"), std::string::npos);
}

}  // namespace
}  // namespace viewpeel

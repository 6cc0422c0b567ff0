// These tests run `viewpeel solve` as users type it. They check its answers, the sources of its form factors, and its
// refusals in one line.
#include <algorithm>
#include <map>
#include <sstream>

#include "tests/support/program.h"
#include "tests/support/python.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

const std::string kOffice = VIEWPEEL_SCENES "/office.obj", kPlates = VIEWPEEL_SCENES "/plates.obj",
                  kCube = VIEWPEEL_SCENES "/cube.obj";
const std::string kHeader = "surface,emissivity,temperature,heat_flux\n";

class SolveProgram : public Program {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(file(name), std::ios::binary) << text;
    return file(name);
  }
  std::string officeMaterials() const {
    return write("office.csv", kHeader +
                                   "default,0.9,,adiabatic\nradiator,0.95,333.15,\nwall_*,0.92,292,\nfloor,0.9,293,\n"
                                   "ceiling,0.9,294,\nwindow_?,0.84,281,\nperson,0.97,,45\n");
  }
  static void expectRefusal(const Result& r, const std::string& part) {
    EXPECT_EQ(r.status, 2) << r.output;
    EXPECT_EQ(r.output.find("viewpeel: "), 0u) << r.output;
    EXPECT_NE(r.output.find(part), std::string::npos) << r.output << "does not say " << part;
    EXPECT_EQ(std::count(r.output.begin(), r.output.end(), '\n'), 1) << r.output;
  }
  // Returns the fields of each line after the first one, by the first field.
  static std::map<std::string, std::vector<std::string>> rowsOf(const std::string& text) {
    std::map<std::string, std::vector<std::string>> rows;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
      std::istringstream fields(line);
      std::string name, field;
      std::getline(fields, name, ',');
      while (std::getline(fields, field, ',')) rows[name].push_back(field);
    }
    return rows;
  }
};

TEST_F(SolveProgram, TheOfficeBySurfaceAndByPolygon) {
  for (const bool by_polygon : {false, true}) {
    const Result r = run("solve " + kOffice + " --materials " + officeMaterials() + " --form-factors 0.01 -o " +
                         file("a.csv") + (by_polygon ? " --by polygon" : ""));
    ASSERT_EQ(r.status, 0) << r.output;
    for (const char* part : {"576 polygons", "heat flows and temperatures", "radiator",
                             "balance    all heat flows add up", "errors     largest standard errors: temperature",
                             "closure", "work", by_polygon ? "replaced   " : "written    "})
      EXPECT_NE(r.output.find(part), std::string::npos) << part << r.output;
    const auto rows = rowsOf(readFile(file("a.csv")));
    ASSERT_EQ(rows.size(), by_polygon ? 577u : 19u);
    EXPECT_EQ(rows.at(by_polygon ? "polygon" : "surface").size(), 12u);
    const auto& person = rows.at(by_polygon ? "person[1]" : "person");
    EXPECT_EQ(person.at(8), "45");
    EXPECT_GT(std::stod(person.at(2)), 294);  // warmer than the room
    EXPECT_GT(std::stod(person.at(3)), 0);
    double flow = 0, size = 0;
    for (const auto& [name, fields] : rows) {
      if (name == "surface" || name == "polygon") continue;
      flow += std::stod(fields.at(10)), size += std::abs(std::stod(fields.at(10)));
    }
    EXPECT_LE(std::abs(flow), 1e-11 * size);
  }
}

// The checkpoint of `compute` gives `solve` the same form factors, and so the same bits.
TEST_F(SolveProgram, CheckpointsGiveTheSameAnswers) {
  const std::string materials = officeMaterials(), checkpoint = file("office.vpk");
  for (const std::string by : {"surface", "polygon"}) {
    const std::string of = " --by " + by + " --materials " + materials + " --quiet -o ";
    ASSERT_EQ(run("compute " + kOffice + " --tolerance 0.01 --quiet --by " + by + " --checkpoint " + checkpoint).status,
              0);
    ASSERT_EQ(run("solve " + kOffice + " --form-factors 0.01" + of + file("a.csv")).status, 0);
    ASSERT_EQ(run("solve --from-result " + checkpoint + of + file("b.csv")).status, 0);
    EXPECT_EQ(readFile(file("a.csv")), readFile(file("b.csv")));
    if (by == "surface")
      expectRefusal(run("solve --from-result " + checkpoint + " --by polygon --materials " + materials),
                    "its rows are surfaces; leave out --by polygon");
    else EXPECT_EQ(run("solve --from-result " + checkpoint + " --by surface --materials " + materials).status, 0);
    fs::remove(checkpoint);
  }
}

TEST_F(SolveProgram, TheToleranceIsOfTheAnswers) {
  const Result r =
      run("solve " + kOffice + " --materials " + officeMaterials() + " --tolerance 0.05K -o " + file("a.csv"));
  ASSERT_EQ(r.status, 0) << r.output;
  EXPECT_NE(r.output.find("K, 0.05 asked for; form factors to "), std::string::npos) << r.output;
  for (const auto& [name, fields] : rowsOf(readFile(file("a.csv")))) {
    if (name == "surface") continue;
    EXPECT_LE(std::stod(fields.at(3)), 0.05) << name;
  }
}

TEST_F(SolveProgram, ExchangeFactorsStandBesideTheAnswers) {
  const std::string command =
      "solve " + kOffice + " --materials " + officeMaterials() + " --form-factors 0.01 -o " + file("a.csv");
  const Result r = run(command + " --exchange gebhart");
  ASSERT_EQ(r.status, 0) << r.output;
  EXPECT_NE(r.output.find("written    " + file("a.exchange.csv")), std::string::npos) << r.output;
  std::map<std::string, double> sums;
  std::istringstream in(readFile(file("a.exchange.csv")));
  std::string line, from, to, factor;
  std::getline(in, line);
  EXPECT_EQ(line, "from,to,gebhart,conductor");
  while (std::getline(in, from, ',') && std::getline(in, to, ',') && std::getline(in, factor, ',') &&
         std::getline(in, line))
    sums[from] += std::stod(factor);
  EXPECT_EQ(sums.size(), 18u);
  for (const auto& [name, sum] : sums) EXPECT_NEAR(sum, 1, 1e-12) << name;
  const Result cut = run(command + " --exchange script-f --drop-below 0.001");
  EXPECT_EQ(cut.status, 0) << cut.output;
  EXPECT_NE(cut.output.find("below 0.001 were dropped"), std::string::npos) << cut.output;
  const std::string cube = "solve " + kCube + " --materials " + officeMaterials();
  expectRefusal(run(cube + " --exchange gebhart"), "give -o NAME.csv");
  expectRefusal(run(cube + " --drop-below 0.1"), "requires --exchange");
  expectRefusal(run(cube + " --exchange b -o " + file("b.csv")), "'b' is not one of gebhart|");
  expectRefusal(run(cube + " --exchange gebhart -o " + file("b.csv") + " -o " + file("b.exchange.csv")),
                "two outputs have this name");
  expectRefusal(run(cube + " -o " + file("b.csv") + " -o " + file("./b.csv")), "two outputs have this name");
}

TEST_F(SolveProgram, AGuaranteeBoundsTheAnswers) {
  const Result r = run("solve " + kPlates + " --epsilon 0.05 --delta 0.1 -o " + file("a.csv") + " --materials " +
                       write("m.csv", kHeader + "default,0.8,,50\nenvironment,,280,\n"));
  ASSERT_EQ(r.status, 0) << r.output;
  for (const char* part : {"bounds     largest: temperature", "guarantee  every form factor within", "probability"})
    EXPECT_NE(r.output.find(part), std::string::npos) << part << r.output;
  EXPECT_NE(readFile(file("a.csv")).find(",temperature,temperature_standard_error,temperature_bound,radiosity"),
            std::string::npos);
  expectRefusal(run("solve " + kPlates + " --materials m.csv --delta 0.1"), "requires --epsilon");
}

TEST_F(SolveProgram, AnOpenSceneHasAnEnvironment) {
  const std::string hot = write("hot.csv", kHeader + "default,0.8,350,\n"),
                    both = write("both.csv", kHeader + "default,0.8,350,\nenvironment,,280,\n");
  expectRefusal(run("solve " + kPlates + " --quiet --materials " + hot), "leaves the scene; give its surroundings");
  const Result r = run("solve " + kPlates + " --materials " + both + " -o " + file("a.csv"));
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_NE(r.output.find("W leave the scene"), std::string::npos) << r.output;
  EXPECT_NE(readFile(file("a.csv")).find("\nenvironment,,1,,,,,,,,,-"), std::string::npos);
  const Result closed = run("solve " + kCube + " --materials " + both);
  EXPECT_NE(closed.output.find("warning: " + both + ": no radiation leaves the scene"), std::string::npos)
      << closed.output;
}

TEST_F(SolveProgram, SkyAndGroundAreApart) {
  const std::string apart =
      write("apart.csv", kHeader + "default,0.8,,20\nenvironment:up,,250,\nenvironment:down,,290,\n");
  const Result r = run("solve " + kPlates + " --materials " + apart + " --up 0,1,1 -o " + file("a.csv"));
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_NE(r.output.find("environment 250 K above and 290 K below the horizon"), std::string::npos) << r.output;
  EXPECT_NE(r.output.find(" above the horizon, "), std::string::npos) << r.output;
  const std::string answers = readFile(file("a.csv"));
  EXPECT_NE(answers.find("\nenvironment:up,,1,"), std::string::npos) << answers;
  EXPECT_NE(answers.find("\nenvironment:down,,1,"), std::string::npos) << answers;
  expectRefusal(run("solve " + kPlates + " --materials " + apart + " --up 0,0,0"), "the direction has no length");
  expectRefusal(run("solve " + kPlates + " --quiet --epsilon 0.1 --materials " + apart),
                "no bounds with sky and ground");
  expectRefusal(run("solve " + kPlates + " --quiet --up 0,0,1 --materials " +
                    write("one.csv", kHeader + "default,0.8,,20\nenvironment,,280,\n")),
                "has neither environment:up nor environment:down");
}

TEST_F(SolveProgram, WithoutAMatrix) {
  const std::string solve = "solve " + kOffice + " --materials " + officeMaterials() + " --matrix-free on";
  const Result r = run(solve + " -o " + file("m.csv"));
  ASSERT_EQ(r.status, 0) << r.output;
  for (const char* part : {"no form factors are kept", "balance    all heat flows add up", "tolerance  standard errors",
                           "in 1 round", "sweeps", "written    "})
    EXPECT_NE(r.output.find(part), std::string::npos) << part << r.output;
  ASSERT_EQ(run("solve " + kOffice + " --materials " + officeMaterials() + " --quiet -o " + file("s.csv")).status, 0);
  // The radiator's heat flow, without a matrix and with one, agrees within 5 of the larger standard error.
  const auto found = rowsOf(readFile(file("m.csv"))).at("radiator"),
             stored = rowsOf(readFile(file("s.csv"))).at("radiator");
  const double error = std::stod(found.at(11));
  EXPECT_GT(error, std::stod(stored.at(11)));
  EXPECT_NEAR(std::stod(found.at(10)), std::stod(stored.at(10)), 5 * error);
  expectRefusal(run(solve + " --exchange gebhart -o " + file("m.csv")), "--exchange takes");
  expectRefusal(run(solve + " --epsilon 0.1"), "--epsilon takes");
  expectRefusal(run(solve + " --form-factors 0.1"), "--form-factors takes");
  expectRefusal(run(solve + " -o " + file("m.h5")), "m.h5 takes");
}

// A result gives the answers of a checkpoint of the same run. Files keep all bits; products with areas round them, and
// the equations are solved to 1e-11, so that answers agree to 1e-9 of the heat.
TEST_F(SolveProgram, TakesAResult) {
  ASSERT_EQ(run("compute " + kOffice + " --tolerance 1e-2 --quiet --checkpoint " + file("c.h5") + " -o " + file("r.h5"))
                .status,
            0);
  for (const std::string by : {"polygon", "surface"}) {
    const std::string of = " --materials " + officeMaterials() + " --by " + by + " --quiet -o ";
    ASSERT_EQ(run("solve --from-result " + file("c.h5") + of + file("c.csv")).status, 0);
    const Result r = run("solve --from-result " + file("r.h5") + of + file("r.csv"));
    ASSERT_EQ(r.status, 0) << r.output;
    auto found = rowsOf(readFile(file("r.csv"))), expected = rowsOf(readFile(file("c.csv")));
    ASSERT_EQ(found.size(), expected.size());
    ASSERT_EQ(expected.erase(by), 1u);  // the header
    double heat = 0, errors = 0;
    for (const auto& [name, row] : expected) heat = std::max(heat, std::abs(std::stod(row.at(10))));
    for (const auto& [name, row] : expected) {
      EXPECT_NEAR(std::stod(found.at(name).at(10)), std::stod(row.at(10)), 1e-9 * heat) << name;
      errors = std::max(errors, std::stod(found.at(name).at(11)));
    }
    EXPECT_GT(errors, 0);
  }
  const std::string of = " --materials " + officeMaterials();
  ASSERT_EQ(run("compute " + kOffice + " --by surface --tolerance 1e-2 --quiet -o " + file("s.h5")).status, 0);
  EXPECT_EQ(run("solve --from-result " + file("s.h5") + of).status, 0);
  expectRefusal(run("solve --from-result " + file("s.h5") + of + " --by polygon"), "its rows are surfaces");
  expectRefusal(run("solve --from-result " + file("s.h5") + " --from-result " + file("r.h5") + of),
                "results cannot be added up");
  expectRefusal(run("solve " + kCube + " --from-result " + file("s.h5") + of), "another number of rows");
  ASSERT_EQ(run("compute " + kOffice + " --from floor --by surface --directions 20 --quiet -o " + file("f.h5")).status,
            0);
  expectRefusal(run("solve --from-result " + file("f.h5") + of), "has some rows only");
  write("cut.h5", readFile(file("s.h5")).substr(0, 3000));
  expectRefusal(run("solve --from-result " + file("cut.h5") + of), "cut.h5: not a whole result or checkpoint");
}

// Without a matrix a .vtp has the answers of the .csv, and no form factors.
TEST_F(SolveProgram, WithoutAMatrixAnswersGoToParaView) {
  const std::string bands = write("bands.csv",
                                  "surface,emissivity:0-8,emissivity:8-inf,temperature,heat_flux\n"
                                  "default,0.4,0.9,290,\nradiator,0.3,0.95,,200\n");
  const Result r = run("solve " + kOffice + " --by polygon --materials " + bands +
                       " --matrix-free on --tolerance 2% -o " + file("m.csv") + " -o " + file("m.vtp"));
  ASSERT_EQ(r.status, 0) << r.output;
  const PythonResult judged = runPython(folder_, R"(
import csv, vtkmodules.vtkIOXML as xml
from vtkmodules.util.numpy_support import vtk_to_numpy
reader = xml.vtkXMLPolyDataReader()
reader.SetFileName('m.vtp')
reader.Update()
cells = reader.GetOutput().GetCellData()
rows = list(csv.DictReader(open('m.csv')))
assert len(rows) == 576
for name in ('temperature', 'radiosity', 'irradiation', 'heat_flux'):
    for row, value in zip(vtk_to_numpy(cells.GetArray('row')), vtk_to_numpy(cells.GetArray(name))):
        assert value == float(rows[row][name]), (name, row)
assert max(float(r['temperature']) for r in rows) > 300
assert cells.GetArray('row_sum') is None and cells.GetArray('environment') is None
)");
  EXPECT_EQ(judged.status, 0) << judged.output;
}

// Without a matrix, a speck that no line met has a heat flux of 0 +- 0. A warning says so.
TEST_F(SolveProgram, WithoutAMatrixAWarningNamesTheRowThatNoLineMet) {
  const std::string plate = "o plate\nv 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nf 1 2 3 4\n",
                    speck = "o speck\nv 5 5 1\nv 5 5.0001 1\nv 5.0001 5.0001 1\nv 5.0001 5 1\nf 5 6 7 8\n",
                    materials = write("m.csv", kHeader + "default,0.9,400,\nenvironment,,300,\n");
  for (const bool has_speck : {false, true}) {
    const std::string scene = write("s.obj", has_speck ? plate + speck : plate);
    const Result r = run("solve " + scene + " --materials " + materials + " --matrix-free on");
    ASSERT_EQ(r.status, 0) << r.output;
    EXPECT_EQ(r.output.find("warning: directions hardly met speck") != std::string::npos, has_speck) << r.output;
    EXPECT_EQ(r.output.find("warning") != std::string::npos, has_speck) << r.output;
  }
}

TEST_F(SolveProgram, DirectionalEmissivities) {
  const std::string header = "surface,emissivity,temperature,heat_flux,directional\n";
  write("metal.csv", "angle_degrees,relative_emissivity\n0,1\n40,1\n80,3\n90,0\n");
  const std::string materials = write("m.csv", header +
                                                   "lower,0.35,500,,cosine:3\nupper,0.15,300,,metal.csv\n"
                                                   "environment,,250,,\n"),
                    solve = "solve " + kPlates + " --materials " + materials;
  const Result r = run(solve + " -o " + file("a.csv"));
  ASSERT_EQ(r.status, 0) << r.output;
  for (const char* part : {"no form factors are kept", "2 directional laws", "balance    all heat flows"})
    EXPECT_NE(r.output.find(part), std::string::npos) << part << r.output;
  EXPECT_EQ(rowsOf(readFile(file("a.csv"))).at("lower").at(1), "0.35");
  const std::string of_diffuse = " takes form factors, which are of diffuse surfaces";
  expectRefusal(run(solve + " --matrix-free off"), "--matrix-free off" + of_diffuse);
  expectRefusal(run(solve + " --form-factors 0.1"), "--form-factors" + of_diffuse);
  expectRefusal(run(solve + " --epsilon 0.1"), "--epsilon" + of_diffuse);
  expectRefusal(run(solve + " -o " + file("a.h5")), "a.h5" + of_diffuse);
  expectRefusal(run(solve + " --exchange gebhart -o " + file("b.csv")), "--exchange" + of_diffuse);
  expectRefusal(run("solve --from-result " + file("none.vpk") + " --materials " + materials),
                "--from-result" + of_diffuse);
  const auto refuse = [&](const std::string& text, const std::string& part) {
    expectRefusal(run("solve " + kPlates + " --quiet --materials " + write("m.csv", text)), part);
  };
  refuse(header + "default,0.5,300,,cosine:3\n", "m.csv:2: a hemispherical emissivity of 0.5 would be 1.25");
  refuse(header + "default,0.5,300,,cosine:-1\n", "m.csv:2: a power of -1 is not a number from 0 on");
  refuse(header + "default,0.5,300,,cosine:x\n", "m.csv:2: 'x' is not a number");
  refuse(header + "default,0.5,300,,none.csv\n", "none.csv: cannot be read; write cosine:POWER");
  refuse(header + "default,0.5,300,,none.csv\x02\n", "none.csv?: cannot be read");  // the name is one line of text
  refuse(header + "default,0.5,300,,\nenvironment,,300,,cosine:1\n", "'environment' is black");
  refuse("surface,emissivity:0-3,emissivity:3-inf,temperature,heat_flux,directional\na,1,1,300,,\n",
         "'directional' beside columns of bands");
  refuse("surface,emissivity,temperature,heat_flux,directional,directional\na,1,300,,,\n", "'directional' twice");
}

// 20 degrees in place of 293.15 K are warned of. A hot surface among cold ones, or an environment of 3 K, is not.
TEST_F(SolveProgram, DegreesCelsiusAreNoticed) {
  const std::string warning = "m.csv: no temperature is above 40 K; temperatures are in kelvins";
  const auto solve = [&](const std::string& lines) {
    return run("solve " + kPlates + " -q --materials " + write("m.csv", kHeader + lines)).output;
  };
  EXPECT_NE(solve("lower,0.9,40,\nupper,0.9,20,\nenvironment,,5,\n").find(warning), std::string::npos);
  EXPECT_EQ(solve("lower,0.9,400,\nupper,0.9,20,\nenvironment,,5,\n"), "");
  EXPECT_EQ(solve("default,0.9,300,\nenvironment,,2.7,\n"), "");
  EXPECT_EQ(solve("default,0.9,,5\nenvironment,,0,\n"), "");
}

TEST_F(SolveProgram, MistakesAreRefusedInOneLine) {
  const auto refuse = [&](const std::string& lines, const std::string& part) {
    expectRefusal(
        run("solve " + kCube + " --quiet -o " + file("a.csv") + " --materials " + write("m.csv", kHeader + lines)),
        part);
    EXPECT_FALSE(fs::exists(file("a.csv")));
  };
  refuse("default,1.2,300,\n", "m.csv:2: an emissivity of 1.2 is not above 0 and up to 1");
  refuse("default,0.5,300,5\n", "m.csv:2: 'default' has both temperature and heat_flux");
  refuse("default,0.5,,\n", "m.csv:2: 'default' has neither temperature nor heat_flux");
  refuse("default,0.5,,adiabatic\n", "m.csv: no temperature is given to refer to");
  refuse("default,0.5,300,\nceilng,0.5,300,\n", "m.csv:3: no surface or face is called 'ceilng'; surfaces are");
  refuse("default,0.5,300,\nenvironment:up,,250,\n", "'environment:up' has a temperature and 'environment:down' none");
  // A face that looks the wrong way lets radiation out, and shows its back.
  std::string cube = readFile(kCube);
  cube.replace(cube.find("f 1 2 3 4"), 9, "f 4 3 2 1");
  expectRefusal(run("solve " + write("flipped.obj", cube) + " --quiet --materials " +
                    write("m.csv", kHeader + "default,0.5,300,\n")),
                "100 % of the leak: x0 looks the wrong way");
  const std::string materials = " --materials " + write("m.csv", kHeader + "default,0.5,300,\n");
  expectRefusal(run("solve " + kCube), "--materials is required");
  expectRefusal(run("solve" + materials), "solve needs a scene, or form factors by --from-result");
  expectRefusal(run("solve " + kCube + " --materials " + file("none.csv")), "none.csv: cannot be read");
  expectRefusal(run("solve " + kCube + materials + " -o " + file("a.txt")), "use a name that ends in .csv");
  expectRefusal(run("solve " + kCube + materials + " --tolerance 5C"), "'5C' is not a number above 0 with a unit");
  expectRefusal(run("solve " + kCube + materials + " --tolerance 1K --quiet"), "all temperatures are given");
  expectRefusal(run("solve " + kPlates + " --tolerance 1% --quiet --materials " +
                    write("f.csv", kHeader + "default,0.5,,30\nenvironment,,300,\n")),
                "all heat fluxes are given, so that none has an error; ask for a tolerance in K");
  expectRefusal(run("solve " + kCube + materials + " --tolerance 1K --form-factors 0.1"), "excludes");
  expectRefusal(run("solve --from-result " + file("none.vpk") + materials), "none.vpk");
  expectRefusal(run("solve --from-result " + kCube + materials + " --seed 3"), "excludes");
}

}  // namespace
}  // namespace viewpeel

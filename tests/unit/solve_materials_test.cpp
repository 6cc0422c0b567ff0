// These tests check the reader of material files, which row gets which material, refusals, and the file of answers.
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "io/csv.h"
#include "tests/support/enclosures.h"

namespace viewpeel {
namespace {

namespace te = test_enclosures;
const std::string kHeader = "surface,emissivity,temperature,heat_flux\n";

class SolveMaterials : public testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() / ("viewpeel_materials_" + std::to_string(::getpid()) + ".csv");
  }
  void TearDown() override { std::filesystem::remove(file_); }
  MaterialTable read(const std::string& text) const {
    std::ofstream(file_, std::ios::binary) << text;
    return readMaterials(file_);
  }
  // Returns the error message of reading `text`, without the file's name; empty where nothing is refused.
  std::string refusal(const std::string& text) const {
    try {
      read(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return std::string(error.what()).substr(file_.string().size());
    }
    return "";
  }
  std::filesystem::path file_;
};

TEST_F(SolveMaterials, LinesAreRead) {
  const MaterialTable table = read("\xEF\xBB\xBF" + kHeader +
                                   "# a comment, with commas\r\n\r\n \"Tür, \"\"süd\"\"\" , 0.8 , 293.15 ,\r\n"
                                   "heater,1,,250\nwall*,0.9,,adiabatic\nenvironment,,263,\ndefault,0.5,0,\n");
  ASSERT_EQ(table.lines.size(), 4u);
  EXPECT_EQ(table.lines[0].name, "Tür, \"süd\"");
  EXPECT_EQ(table.lines[0].material.emissivity, 0.8);
  EXPECT_EQ(table.lines[0].material.temperature, 293.15);
  EXPECT_EQ(table.lines[0].line, 4u);
  EXPECT_EQ(table.lines[1].material.heat_flux, 250);
  EXPECT_EQ(table.lines[2].material.heat_flux, 0);
  EXPECT_EQ(table.lines[3].material.temperature, 0);
  EXPECT_EQ(table.environment_temperature, 263);
  // Columns may stand in any order.
  const MaterialTable turned = read("heat_flux,temperature,surface,emissivity\n-3,,a,0.25");
  EXPECT_EQ(turned.lines[0].material.heat_flux, -3);
  EXPECT_EQ(turned.lines[0].material.emissivity, 0.25);
}

TEST_F(SolveMaterials, SkyAndGroundAreApart) {
  const auto partsOf = [&](const std::string& lines) { return read(kHeader + "a,1,300,\n" + lines).sky_and_ground; };
  EXPECT_FALSE(partsOf("environment,,280,\n"));
  const auto both = partsOf("environment:down,,290,\nenvironment:up,1,250,\n"),
             one = partsOf("environment:down,,290,\nenvironment,,260,\n");
  ASSERT_TRUE(both && one);
  EXPECT_EQ(both->up, 250);
  EXPECT_EQ(both->down, 290);
  EXPECT_EQ(one->up, 260);
  EXPECT_EQ(one->down, 290);
}

TEST_F(SolveMaterials, BandsAreRead) {
  const MaterialTable table = read(
      "emissivity:8-inf,surface,emissivity:0-2.5,temperature,emissivity:2.5-8,heat_flux\n0.9,a,0.1,300,0.5,\n"
      ",environment,1,280,,\n");
  EXPECT_EQ(table.band_limits_um, (std::vector<double>{2.5, 8}));
  EXPECT_EQ(table.lines[0].material.band_emissivities, (std::vector<double>{0.1, 0.5, 0.9}));
  EXPECT_EQ(table.environment_temperature, 280);
  // A single band holds all wavelengths, so rows are grey.
  const MaterialTable grey = read("surface,emissivity:0-inf,temperature,heat_flux\na,0.3,300,\n");
  EXPECT_TRUE(grey.band_limits_um.empty());
  EXPECT_EQ(grey.lines[0].material.emissivity, 0.3);
  EXPECT_TRUE(grey.lines[0].material.band_emissivities.empty());
}

TEST_F(SolveMaterials, FaultsAreNamedWithTheirLine) {
  const struct {
    std::string text, part;
  } cases[] = {
      {"", ": has no header"},
      {kHeader, ": has no materials"},
      {"surface,emissivity,temperature\n", ":1: the header needs the column 'heat_flux'"},
      {"surface,emissivity,temperature,heat_flux,colour\n", ":1: 'colour' is not a column"},
      {"surface,surface,emissivity,temperature,heat_flux\n", ":1: the header needs the column 'surface' once"},
      {kHeader + "a,0,300,\n", ":2: an emissivity of 0 is not above 0"},
      {kHeader + "a,1.01,300,\n", ":2: an emissivity of 1.01 is not above 0"},
      {kHeader + "a,nan,300,\n", ":2: 'nan' is not a finite number"},
      {kHeader + "a,,300,\n", ":2: '' is not a number"},
      {kHeader + "a,0.5,,\n", ":2: 'a' has neither temperature nor heat_flux"},
      {kHeader + "a,0.5,300,0\n", ":2: 'a' has both temperature and heat_flux"},
      {kHeader + "a,0.5,-1,\n", ":2: a temperature of -1 K is below 0"},
      {kHeader + "a,0.5,,warm\n", ":2: 'warm' is not a number"},
      {kHeader + "a,0.5,300\n", ":2: 3 fields, the header has 4"},
      {kHeader + "\"a,0.5,300,\n", ":2: a quote has no end"},
      {kHeader + ",0.5,300,\n", ":2: the surface has no name"},
      {kHeader + "a,0.5,300,\n\na,0.6,300,\n", ":4: 'a' has a material on line 2 already"},
      {kHeader + "environment,0.9,300,\n", ":2: 'environment' is black"},
      {kHeader + "environment,,,5\n", ":2: 'environment' is black"},
      {kHeader + "environment,,3,\nenvironment,,4,\n", ":3: 'environment' has a line already"},
      {"surface,emissivity:0-3,temperature,heat_flux\n", ":1: bands of emissivity do not follow"},
      {"surface,emissivity:1-inf,temperature,heat_flux\n", ":1: bands of emissivity do not follow"},
      {"surface,emissivity:0-inf,emissivity:3-inf,temperature,heat_flux\n", ":1: bands of emissivity do not follow"},
      {"surface,emissivity:0-4,emissivity:3-inf,temperature,heat_flux\n",
       ":1: bands of emissivity do not follow one another from 0 to inf, at 4 um"},
      {"surface,emissivity:5-3,temperature,heat_flux\n", ":1: the band 'emissivity:5-3' does not reach"},
      {"surface,emissivity:5,temperature,heat_flux\n", ":1: 'emissivity:5' names no band"},
      {"surface,emissivity,emissivity:0-inf,temperature,heat_flux\n",
       ":1: the header has the column "
       "'emissivity' beside"},
      {"surface,emissivity:0-3,emissivity:3-inf,temperature,heat_flux\na,0.5,0,300,\n",
       ":2: an emissivity of 0 is not above 0"},
      {kHeader + "environment:up,0.9,250,\n", ":2: 'environment:up' is black"},
      {kHeader + "a,1,300,\nenvironment:up,,250,\n",
       ": 'environment:up' has a temperature and "
       "'environment:down' none"},
      {kHeader + "environment:up,,2,\nenvironment:down,,3,\nenvironment,,4,\n",
       ": 'environment:up' and 'environment:down' leave nothing to 'environment'"}};
  for (const auto& c : cases) {
    const std::string message = refusal(c.text);
    EXPECT_EQ(message.find(c.part), 0u) << c.text << "\n" << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_THROW(readMaterials(file_.parent_path()), Error);
  EXPECT_THROW(readMaterials(file_.string() + ".none"), Error);
}

Ids idsOf(const std::vector<std::string>& names, const std::vector<uint32_t>& surface) {
  Ids ids;
  ids.names = names;
  ids.surface = surface;
  ids.areas.assign(names.size(), 1.0);
  return ids;
}

TEST_F(SolveMaterials, RowsFindTheirLines) {
  const Ids ids = idsOf({"wall_north", "wall_south[1]", "wall_south[2]", "w*", "floor"}, {0, 1, 1, 2, 3});
  const std::vector<std::string> names{"wall_north", "wall_south", "w*", "floor"};
  const MaterialTable table = read(kHeader +
                                   "default,0.1,1,\nwall_?????,0.2,1,\nwall_s*,0.3,1,\n*[2],0.4,1,\nwall_north,0.5,1,\n"
                                   "w*,0.6,1,\n");
  const Enclosure enclosure = assignMaterials(table, ids, names);
  std::vector<double> emissivities;
  for (const Material& material : enclosure.materials) emissivities.push_back(material.emissivity);
  // The surface named w* has a line with its exact name. As a wildcard that line also matches the walls, and is the
  // last that does.
  EXPECT_EQ(emissivities, (std::vector<double>{0.5, 0.6, 0.6, 0.6, 0.1}));
  const MaterialTable faces = read(kHeader + "*[2],0.4,1,\nwall_south,0.3,1,\nwall_south[1],0.2,1,\n*,0.1,1,\n");
  const Enclosure of_faces = assignMaterials(faces, ids, names);
  EXPECT_EQ(of_faces.materials[1].emissivity, 0.2);  // the line with the face's own name
  EXPECT_EQ(of_faces.materials[2].emissivity, 0.3);  // the line of its surface, which wins over wildcards
  EXPECT_EQ(of_faces.materials[4].emissivity, 0.1);
}

TEST_F(SolveMaterials, NamesThatDoNotFitAreRefused) {
  const Ids ids = idsOf({"a", "b"}, {0, 1});
  const auto assign = [&](const std::string& text) -> std::string {
    try {
      assignMaterials(read(kHeader + text), ids, {"a", "b"});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return std::string(error.what()).substr(file_.string().size());
    }
    return "";
  };
  EXPECT_EQ(assign("a,1,1,\nb,1,1,\n"), "");
  EXPECT_EQ(assign("a,1,1,\n").find(": 'b' has no material"), 0u);
  EXPECT_EQ(assign("*,1,1,\nc,1,1,\n").find(":3: no surface or face is called 'c'; surfaces are a, b"), 0u);
  EXPECT_EQ(assign("*,1,1,\nc*,1,1,\n").find(":3: no surface or face fits 'c*'"), 0u);
  EXPECT_NE(assign("*,1,1,\na[1],1,1,\n").find("--by polygon"), std::string::npos);
}

TEST_F(SolveMaterials, AnswersAreWritten) {
  HeatSolution solution;
  solution.rows.push_back({"a, b", 2, 0.5, {300, 0}, {1, 0.25}, {3, 0.5}, {-2, 0.125}, {-4, 0.25}});
  solution.surfaces = solution.rows;
  std::ostringstream closed, open;
  writeHeat(solution, By::polygon, closed);
  const std::string columns =
      ",area,emissivity,temperature,temperature_standard_error,radiosity,radiosity_standard_error,irradiation,"
      "irradiation_standard_error,heat_flux,heat_flux_standard_error,heat_flow,heat_flow_standard_error\n";
  const std::string line = "\"a, b\",2,0.5,300,0,1,0.25,3,0.5,-2,0.125,-4,0.25\n";
  EXPECT_EQ(closed.str(), "polygon" + columns + line);
  solution.is_open = true;
  solution.to_environment = {-4, 0.25};
  writeHeat(solution, By::surface, open);
  EXPECT_EQ(open.str(), "surface" + columns + line + "environment,,1,,,,,,,,,4,0.25\n");
}

}  // namespace
}  // namespace viewpeel

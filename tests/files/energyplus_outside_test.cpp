// These tests see an EnergyPlus building from outside, with sky and ground, and check the objects that describe this.
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>
#include <viewpeel/write.h>
#include "reference/closed_forms/rectangles.h"
#include "scene/sky_share.h"
#include "tests/support/python.h"
#include "tests/support/random_form_factors.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

// Returns a room of 4 x 3 x 2.5 m on the ground. It has an overhang of 4 x 1.5 m at the top of its south wall, and a
// board of 4 x 2.5 m, 3 m before its north wall. The east wall has a window; the west wall belongs to another house.
std::string house(const std::string& rules = "World") {
  const auto wall = [](const char* name, const char* boundary, const char* corners) {
    return fmt::format("BuildingSurface:Detailed,{},Wall,C,Z,,{},,,,0.5,4,{};\n", name, boundary, corners);
  };
  return "Version,23.1;\nBuilding,House,90;\nGlobalGeometryRules,UpperLeftCorner,Counterclockwise," + rules +
         ";\nZone,Z;\n" + wall("South", "Outdoors", "0,0,0, 4,0,0, 4,0,2.5, 0,0,2.5") +
         wall("East", "Outdoors", "4,0,0, 4,3,0, 4,3,2.5, 4,0,2.5") +
         wall("North", "Outdoors", "4,3,0, 0,3,0, 0,3,2.5, 4,3,2.5") +
         wall("West", "Adiabatic", "0,3,0, 0,0,0, 0,0,2.5, 0,3,2.5") +
         wall("Roof", "Outdoors", "0,0,2.5, 4,0,2.5, 4,3,2.5, 0,3,2.5") +
         wall("Floor", "Ground", "0,3,0, 4,3,0, 4,0,0, 0,0,0") +
         "FenestrationSurface:Detailed,Pane,Window,C,East,,0.5,,1,4,4,1,1,4,2,1,4,2,2,4,1,2;\n"
         "Shading:Zone:Detailed,Overhang,South,,4,0,0,2.5,0,-1.5,2.5,4,-1.5,2.5,4,0,2.5;\n"
         "Shading:Building:Detailed,Board,,4,0,6,0,4,6,0,4,6,2.5,0,6,2.5;\n";
}

// Both return form factors: from the south wall to the overhang, and from the north wall to the board.
double toOverhang() { return reference::perpendicularRectangles({0, 2.5}, {0, 4}, {0, 4}, {0, 1.5}); }
double toBoard() { return reference::parallelRectangles({0, 4}, {0, 2.5}, {0, 4}, {0, 2.5}, 3); }

class EnergyPlusOutside : public TestFolder {
 protected:
  Scene outside(const std::string& text) const {
    SceneOptions options;
    options.outside = true;
    return loadScene(write("house.idf", text), options);
  }
  static uint32_t idOf(const Ids& ids, const std::string& name) {
    return static_cast<uint32_t>(std::ranges::find(ids.names, name) - ids.names.begin());
  }
};

// The south wall sees the overhang only above the horizon. The north wall sees as much of the board above as below.
// Form factors may err by five times the goal of 1e-4, which is about their largest error.
TEST_F(EnergyPlusOutside, SkyAndGroundHaveClosedForms) {
  const Scene scene = outside(house());
  EXPECT_EQ(scene.blockers, (std::vector<std::string>{"West", "Floor"}));
  Request request;
  request.by = By::surface;
  request.goal = Tolerance{1e-4};
  const FormFactors f = computeFormFactors(scene, request).form_factors;
  const Ids& ids = f.ids();
  const uint32_t south = idOf(ids, "South"), north = idOf(ids, "North"), east = idOf(ids, "East");
  EXPECT_NEAR(ids.areas[idOf(ids, "Overhang")], 2 * 4 * 1.5, 1e-12);  // both sides
  EXPECT_NEAR(ids.areas[east], 3 * 2.5 - 1, 1e-12);
  const double overhang = toOverhang(), board = toBoard();
  EXPECT_NEAR(f.formFactor(south, idOf(ids, "Overhang")).value, overhang, 5e-4);
  EXPECT_NEAR(f.formFactor(north, idOf(ids, "Board")).value, board, 5e-4);
  EXPECT_NEAR(f.formFactor(idOf(ids, "Roof"), kEnvironment).value, 1, 1e-6);
  std::vector<std::vector<uint32_t>> polygons(3);
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    const std::string& name = scene.surfaces[scene.faces[scene.polygons[k].face].surface].name;
    for (uint32_t which = 0; which < 3; ++which)
      if (name == (which == 0 ? "South" : which == 1 ? "North" : "East")) polygons[which].push_back(k);
  }
  const std::vector<SkyShare> shares = divideEnvironment(scene, polygons, {1 - overhang, 1 - board, 1});
  const double sky[] = {0.5 - overhang, (1 - board) / 2, 0.5}, ground[] = {0.5, (1 - board) / 2, 0.5};
  for (int which = 0; which < 3; ++which) {
    // Rays within 0.6 degrees of the wall's plane are left out, which moves a share by 1e-4 (scene/sky_share.h).
    // Student's t of 7 degrees of freedom, for 8 sets of rays, exceeds 5 in size once in 600 cases.
    const double bound = 5 * shares[which].standard_error + 1e-4;
    EXPECT_NEAR(shares[which].sky, sky[which], bound) << which;
    EXPECT_NEAR(shares[which].ground, ground[which], bound) << which;
    EXPECT_LT(shares[which].standard_error, 1e-3) << which;
  }
  EXPECT_EQ(shares[0].standard_error, 0);  // nothing blocks below the horizon
  EXPECT_GT(shares[1].standard_error, 0);
  EXPECT_GT(std::abs(shares[0].sky - sky[1]), 0.05);
}

// This script checks EnergyPlus's schema: names, required members, and view factors from 0 to 1 with sums of at most 1.
constexpr const char* kRead = R"(
import json, re
def from_json():
    objects = json.load(open('out.epJSON'))
    assert set(objects) == {'SurfaceProperty:LocalEnvironment', 'SurfaceProperty:SurroundingSurfaces'}
    for name, o in objects['SurfaceProperty:LocalEnvironment'].items():
        assert set(o) == {'exterior_surface_name', 'surrounding_surfaces_object_name'}
        s = objects['SurfaceProperty:SurroundingSurfaces'][o['surrounding_surfaces_object_name']]
        assert set(s) == {'sky_view_factor', 'ground_view_factor', 'surfaces'} and s['surfaces']
        for v in s['surfaces']:
            assert set(v) == {'surrounding_surface_name', 'surrounding_surface_view_factor',
                              'surrounding_surface_temperature_schedule_name'}
        yield (o['exterior_surface_name'], s['sky_view_factor'], s['ground_view_factor'],
               {v['surrounding_surface_name']: v['surrounding_surface_view_factor'] for v in s['surfaces']})
def from_idf():
    text = re.sub('![^\n]*', '', open('out.idf').read())
    objects = [[x.strip() for x in o.split(',')] for o in text.split(';') if o.strip()]
    surroundings = {o[1]: o[2:] for o in objects if o[0] == 'SurfaceProperty:SurroundingSurfaces'}
    for o in objects:
        if o[0] == 'SurfaceProperty:LocalEnvironment':
            assert len(o) == 5 and o[3] == ''
            sky, sky_schedule, ground, ground_schedule, *others = surroundings[o[4]]
            assert sky_schedule == ground_schedule == '' and len(others) % 3 == 0 and len(others) >= 3
            assert all(others[2::3])
            yield o[2], float(sky), float(ground), dict(zip(others[::3], map(float, others[1::3])))
both = list(from_json()), list(from_idf())
assert both[0] == both[1]
for name, sky, ground, others in both[0]:
    total = sky + ground
    for value in others.values():
        assert 0 <= value <= 1
        total += value
    assert 0 <= sky <= 1 and 0 <= ground <= 1 and total <= 1, (name, total)
)";

TEST_F(EnergyPlusOutside, ObjectsHoldAnyMatrix) {
  const Scene scene = outside(house());
  const FormFactors random = randomFormFactors(makeIds(scene, By::surface, false), 9, 0.7);
  // The second matrix has row sums above 1, as sampling errors may cause.
  std::vector<FormFactors::Entry> larger = random.entries();
  for (FormFactors::Entry& entry : larger) entry.exchange_area.value *= 3;
  for (const FormFactors& f : {random, FormFactors(random.ids(), larger, random.rowSums())}) {
    std::map<std::string, std::map<std::string, double>> rows;
    for (uint32_t i = 0; i < f.ids().count(); ++i) {
      for (uint32_t j = 0; j < f.ids().count(); ++j)
        if (j != i && f.formFactor(i, j).value > 0) rows[f.ids().names[i]][f.ids().names[j]] = f.formFactor(i, j).value;
      rows[f.ids().names[i]]["environment"] = f.formFactor(i, kEnvironment).value;
    }
    for (const char* name : {"out.idf", "out.epJSON"}) {
      checkRows(folder_ / name, scene, f.ids());
      writeFormFactors(OutputContent{f, nullptr, &scene}, folder_ / name);
    }
    const PythonResult result = runPython(folder_, std::string(kRead) + fmt::format("F = {}\n", rows) + R"(
found = {name: (sky, ground, others) for name, sky, ground, others in both[0]}
assert set(found) == {'South', 'East', 'North', 'Roof', 'Pane'}
def off(F, of):
    worst = 0
    for name, (sky, ground, others) in found.items():
        row = F[of.get(name, name)]
        scale = 1 / max(1, sum(row.values()))
        if set(others) != set(row) - {'environment'}:
            return 1
        worst = max(worst, abs(sky + ground - scale * row['environment']))
        worst = max([worst] + [abs(v - scale * row[other]) for other, v in others.items()])
    return worst
assert off(F, {}) < 1e-14 and off(F, {'South': 'North', 'North': 'South'}) > 1e-3
print('passed')
)");
    EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
  }
}

// The program is used as a user does. The roof and the east wall see nothing, and EnergyPlus's default is right for
// them.
TEST_F(EnergyPlusOutside, ProgramWritesWhatWallsSee) {
  write("house.idf", house());
  const std::string command = fmt::format(
      "cd '{}' && '{}' compute house.idf --outside --by surface --quiet -o out.idf -o out.epJSON >said 2>&1",
      folder_.string(), VIEWPEEL_PROGRAM);
  ASSERT_EQ(std::system(command.c_str()), 0);
  const PythonResult result =
      runPython(folder_, std::string(kRead) + fmt::format("overhang, board = {}, {}\n", toOverhang(), toBoard()) +
                             R"(
found = {name: (sky, ground, others) for name, sky, ground, others in both[0]}
assert set(found) == {'South', 'North'}, found
sky, ground, others = found['South']
assert abs(sky - (0.5 - overhang)) < 3e-3 and abs(ground - 0.5) < 3e-3 and set(others) == {'Overhang'}, found
sky, ground, others = found['North']
assert abs(sky - (1 - board) / 2) < 3e-3 and abs(sky - ground) < 3e-3 and abs(others['Board'] - board) < 3e-3, found
print('passed')
)");
  EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
}

// With relative coordinates, a zone's shading moves with the zone, and the site's shading stays in world coordinates.
TEST_F(EnergyPlusOutside, ShadingsAreInTheirOwnCoordinates) {
  std::string text = house("Relative");
  text.replace(text.find("Zone,Z;"), 7, "Zone,Z,0,10,20,0;");
  text += "Shading:Site:Detailed,Tree,,3,1,0,0,2,0,0,2,0,1;\n";
  const Scene scene = outside(text);
  const auto first = [&](const std::string& name) {
    for (const Polygon& polygon : scene.polygons)
      if (scene.surfaces[scene.faces[polygon.face].surface].name == name)
        return scene.centre + scene.scale * scene.corners[polygon.first_corner];
    return glm::dvec3(NAN);
  };
  const auto near = [](const glm::dvec3& a, const glm::dvec3& b) { return glm::length(a - b) < 1e-12; };
  EXPECT_TRUE(near(first("Overhang"), {10, 20, 2.5}));
  EXPECT_TRUE(near(first("Board"), {0, 6, 0}));
  EXPECT_TRUE(near(first("Tree"), {0, 1, 0}));  // the building's north axis is 90 degrees: world east is north here
}

TEST_F(EnergyPlusOutside, WhatCannotBeIsRefused) {
  const auto refused = [&](const std::string& text) {
    const std::string said = refusalOf([&] { outside(text); });
    return withoutPlace(said, folder_.string().size() + 1);
  };
  EXPECT_EQ(
      refused(house() + "Shading:Overhang,O,Pane,0.1,90,0,0,1;\n"),
      "house.idf:14: shading:overhang is given by lengths, which is not read; give it as Shading:Site:Detailed or "
      "Shading:Zone:Detailed");
  EXPECT_EQ(refused("GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World;\nZone,Z;\n"
                    "BuildingSurface:Detailed,w,Wall,C,Z,Adiabatic,,,,,3,0,0,0,4,0,0,4,0,3;\n"),
            "house.idf: no surface has the outside boundary condition Outdoors; there is nothing outside");
  std::string text = house("Relative");
  text.replace(text.find("Overhang,South"), 14, "Overhang,Nobody");
  EXPECT_EQ(refused(text), "house.idf:12: shading surface 'Overhang' has no base surface 'Nobody'; correct it");
  SceneOptions options;
  options.outside = true;
  EXPECT_THROW(loadScene(fs::path(VIEWPEEL_SCENES) / "cube.obj", options), Error);
}

}  // namespace
}  // namespace viewpeel

// These tests compare heat that solveMatrixFree() finds with heat from the same counts in a matrix, with closed forms,
// and with heat from form factors.
#include <viewpeel/matrix_free.h>

#include <atomic>
#include <algorithm>

#include <gtest/gtest.h>

#include "directions/replicates.h"
#include "directions/sampler.h"
#include "engines/host_engine.h"
#include "scenes/generate.h"
#include "scenes/named_scenes.h"
#include "tests/support/enclosures.h"
#include "tests/support/reference_shapes.h"
#include "tests/support/thread_ranks.h"
#include <viewpeel/compute.h>
#include <viewpeel/ranks.h>

namespace viewpeel {
namespace {

using bench::city;

namespace te = test_enclosures;
namespace ts = test_scenes;
using Of = HeatTolerance::Of;
using reference::test::isWithin;

constexpr uint32_t kReplicates = 8;

MaterialTable tableOf(std::vector<MaterialTable::Line> lines, std::optional<double> environment = {}) {
  return {"materials", std::move(lines), environment};
}

// Some temperatures are given, some heat fluxes, and some rows are adiabatic.
const MaterialTable kCity = tableOf({{"default", te::hot(0.8, 300), 2},
                                     {"*1]", te::flux(0.9, 50), 3},
                                     {"*2]", te::flux(0.5, 0), 4},
                                     {"*3]", te::hot(1, 310), 5}},
                                    265);

std::vector<std::string> surfaceNames(const Scene& scene) {
  std::vector<std::string> names;
  for (const Surface& surface : scene.surfaces) names.push_back(surface.name);
  return names;
}

// Returns form factors from the counts of the same directions, as the host engine counts them.
FormFactors formFactorsOf(const Scene& scene, const MatrixFreeRequest& request, const MatrixFreeHeat& found) {
  Ids ids = makeIds(scene, request.by, request.two_sided);
  const auto engine = makeHostEngine(
      scene, ids, {.resolution = found.resolution, .sampling = chooseSampling(scene, ids, false), .thread_count = 2});
  std::vector<Direction> directions;
  for (uint32_t r = 0; r < kReplicates; ++r)
    for (Direction& direction :
         sampleDirections(Sampler::fibonacci, request.first_directions, request.seed, kProductReplicates.first + r)) {
      if (direction.u.z < 0) direction.u = -direction.u, direction.x_axis = -direction.x_axis;
      directions.push_back(direction);
    }
  const double of_count = 2 * engine->unitArea() * scene.scale * scene.scale / double(directions.size());
  std::vector<FormFactors::Entry> entries;
  std::vector<Measured> sums(ids.count());
  for (const PairCount& pair : engine->count(directions)) {
    const double exchange = double(pair.count) * of_count * (pair.i == pair.j ? 2 : 1);
    entries.push_back({pair.i, pair.j, {exchange, 0}});
    sums[pair.i].value += exchange / ids.areas[pair.i];
    if (pair.j < kEnvironment && pair.j != pair.i) sums[pair.j].value += exchange / ids.areas[pair.j];
  }
  return {std::move(ids), std::move(entries), std::move(sums)};
}

// Compares the answers of rows, and what leaves the scene.    In: most: the largest difference of powers, W/m2
void expectSame(const HeatSolution& found, const HeatSolution& stored, double most) {
  ASSERT_EQ(found.rows.size(), stored.rows.size());
  for (size_t k = 0; k < stored.rows.size(); ++k) {
    const HeatRow &a = found.rows[k], &b = stored.rows[k];
    EXPECT_TRUE(isWithin(a.irradiation.value, b.irradiation.value, most)) << a.name;
    EXPECT_TRUE(isWithin(a.radiosity.value, b.radiosity.value, most)) << a.name;
    EXPECT_TRUE(isWithin(a.heat_flux.value, b.heat_flux.value, most)) << a.name;
    EXPECT_TRUE(isWithin(te::power(a.temperature.value), te::power(b.temperature.value), 2 * most)) << a.name;
  }
  EXPECT_TRUE(isWithin(found.to_environment.value, stored.to_environment.value, 1e-8 * stored.heat_flow_total));
}

// Both solve the same equations, to 1e-12 of the right side. Rows that reflect all radiation make the condition number
// some hundreds, and sums of some hundred terms are rounded by 1e-14. So answers agree within 1e-8 of the emission at
// 310 K.
TEST(MatrixFree, EqualsTheSameCountsInAMatrix) {
  const Scene scene = buildScene(city(400));
  const MatrixFreeRequest request{.first_directions = 16, .residual = 1e-12, .seed = 3};
  const MatrixFreeHeat found = solveMatrixFree(scene, kCity, request);
  ASSERT_EQ(found.rounds, 1u);
  ASSERT_EQ(found.directions, 128u);
  const FormFactors f = formFactorsOf(scene, request, found);
  const HeatSolution stored = solveHeat(f, assignMaterials(kCity, f.ids(), surfaceNames(scene)));
  ASSERT_TRUE(stored.is_open && found.heat.is_open);
  const double power = te::power(310), kMost = 1e-8 * power;
  expectSame(found.heat, stored, kMost);
  EXPECT_TRUE(isWithin(found.heat.largest_lack, stored.largest_lack, 1e-12));
  EXPECT_LE(std::abs(found.heat.balance_residual), 1e-9 * stored.heat_flow_total);
  // Negative control: conjugate gradients that end at a residual of 1e-3 give other answers.
  MatrixFreeRequest rough = request;
  rough.residual = 1e-3;
  double largest = 0;
  const HeatSolution early = solveMatrixFree(scene, kCity, rough).heat;
  for (size_t k = 0; k < stored.rows.size(); ++k)
    largest = std::max(largest, std::abs(early.rows[k].irradiation.value - stored.rows[k].irradiation.value));
  EXPECT_GT(largest, kMost);
}

// Heat between a box and a box around it, both grey, agrees with Oppenheim's closed form within 5 of the stated
// standard errors. Computation and closed form have one radiosity for each surface. Student's t with 7 degrees of
// freedom exceeds 5 with a probability of 0.16 %; the seed is fixed.
TEST(MatrixFree, ConcentricBoxes) {
  const double side = 0.4;
  const Scene scene = buildScene(ts::cubeInCube(side));
  const double inner = 6 * side * side, outer = 6;
  const double truth = te::betweenTwo(inner, 0.8, 400, outer, 0.3, 300);
  const MaterialTable table = tableOf({{"inner", te::hot(0.8, 400), 2}, {"outer", te::hot(0.3, 300), 3}});
  const MatrixFreeHeat found = solveMatrixFree(scene, table, {.by = By::surface, .first_directions = 64});
  const double area =
      found.heat.surfaces[0].name == "inner" ? found.heat.surfaces[0].area : found.heat.surfaces[1].area;
  ASSERT_TRUE(isWithin(area, inner, 1e-9));
  EXPECT_FALSE(found.heat.is_open);
  for (const HeatRow& row : found.heat.surfaces) {
    const double sign = row.name == "inner" ? 1 : -1;
    EXPECT_TRUE(isWithin(row.heat_flow.value, sign * truth, 5 * row.heat_flow.standard_error)) << row.name;
    EXPECT_LT(row.heat_flow.standard_error, 0.01 * truth);
    EXPECT_GT(row.heat_flow.standard_error, 0);
  }
  // The same heat flow given in place of the inner temperature gives this temperature.
  const MaterialTable back = tableOf({{"inner", te::flux(0.8, truth / inner), 2}, {"outer", te::hot(0.3, 300), 3}});
  for (const HeatRow& row : solveMatrixFree(scene, back, {.by = By::surface, .first_directions = 64}).heat.surfaces)
    if (row.name == "inner") {
      EXPECT_TRUE(isWithin(row.temperature.value, 400, 5 * row.temperature.standard_error));
      EXPECT_GT(row.temperature.standard_error, 0);
    }
}

// At one temperature all heat fluxes are 0, whatever the emissivities and the errors of exchange. Powers are less the
// power at a reference temperature (HeatState::shift), here the only one. So the right side is 0, and 1e-9 allows for
// rounding.
TEST(MatrixFree, OneTemperatureMeansNoHeat) {
  const Scene scene = buildScene(city(300));
  const MaterialTable table =
      tableOf({{"default", te::hot(0.3, 300), 2}, {"*1]", te::hot(1e-3, 300), 3}, {"*2]", te::flux(0.5, 0), 4}}, 300);
  const MatrixFreeHeat found = solveMatrixFree(scene, table, {.first_directions = 16});
  for (const HeatRow& row : found.heat.rows) {
    EXPECT_TRUE(isWithin(row.heat_flux.value, 0, 1e-9 * te::power(300))) << row.name;
    EXPECT_TRUE(isWithin(row.temperature.value, 300, 1e-9 * 300)) << row.name;
  }
}

// Sky and ground at one temperature give the answers of one environment. At two temperatures the heat flows to both add
// up to the heat flow to the environment.
TEST(MatrixFree, SkyAndGround) {
  const Scene scene = buildScene(city(300));
  const MatrixFreeRequest request{.first_directions = 16, .residual = 1e-12};
  const HeatSolution one = solveMatrixFree(scene, kCity, request).heat;
  MaterialTable apart = kCity;
  apart.environment_temperature.reset();
  apart.sky_and_ground = SkyAndGround{265, 265};
  const HeatSolution same = solveMatrixFree(scene, apart, request).heat;
  for (size_t k = 0; k < one.rows.size(); ++k)
    EXPECT_TRUE(isWithin(same.rows[k].irradiation.value, one.rows[k].irradiation.value, 1e-10 * te::power(310)));
  apart.sky_and_ground = SkyAndGround{250, 290};
  const HeatSolution two = solveMatrixFree(scene, apart, request).heat;
  ASSERT_TRUE(two.to_up && two.to_down);
  EXPECT_TRUE(isWithin(two.to_up->value + two.to_down->value, two.to_environment.value, 1e-9 * two.heat_flow_total));
  EXPECT_GT(two.to_up->value, two.to_down->value);  // the city stands on the ground and looks up
  EXPECT_GT(two.to_up->standard_error, 0);
}

TEST(MatrixFree, TheSameBitsOnAnyNumberOfThreads) {
  const Scene scene = buildScene(city(300));
  const auto of = [&](uint32_t threads, uint64_t seed) {
    MatrixFreeRequest request{.first_directions = 8, .seed = seed, .threads = threads};
    return solveMatrixFree(scene, kCity, request).heat.rows;
  };
  const std::vector<HeatRow> alone = of(1, 1), three = of(3, 1), other = of(1, 2);
  size_t differing = 0;
  for (size_t k = 0; k < alone.size(); ++k) {
    EXPECT_EQ(alone[k].irradiation.value, three[k].irradiation.value);
    EXPECT_EQ(alone[k].irradiation.standard_error, three[k].irradiation.standard_error);
    differing += alone[k].irradiation.value != other[k].irradiation.value;
  }
  EXPECT_GT(differing, alone.size() / 2);
}

// The answers of 30 seeds are compared with the closed form. Student's t with 7 degrees of freedom passes 2.36 in 5 of
// 100 cases. Of 30 independent cases 8 or more would pass it with probability 9e-5; rows of one seed share directions.
TEST(MatrixFree, StandardErrorsHold) {
  const Scene scene = buildScene(ts::cubeInCube(0.4));
  const double inner = 6 * 0.4 * 0.4, truth = te::betweenTwo(inner, 0.8, 400, 6, 0.3, 300);
  const MaterialTable table = tableOf({{"inner", te::hot(0.8, 400), 2}, {"outer", te::hot(0.3, 300), 3}});
  int beyond = 0;
  double squares = 0;
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    const MatrixFreeHeat found =
        solveMatrixFree(scene, table, {.by = By::surface, .first_directions = 16, .seed = seed});
    for (const HeatRow& row : found.heat.surfaces)
      if (row.name == "inner") {
        const double off = (row.heat_flow.value - truth) / row.heat_flow.standard_error;
        beyond += std::abs(off) > 2.365;
        squares += off * off / 30;
      }
  }
  EXPECT_LT(beyond, 8);
  EXPECT_GT(squares, 0.3);  // errors are not overstated twofold; the mean square of Student's t is 7/5
}

// Some twenty lines meet each face of 27 small boxes in a room, and most of these faces see a lamp of which no line
// reached them. Their temperatures are compared with temperatures from form factors, whose errors are 1000 times as
// small. Student's t with 7 degrees of freedom passes 7 in 1 of 5000 cases; there are 162 faces, in each of two
// solutions. Without the error of one line more, 30 of 162 faces were off by more than 7 standard errors, the worst by
// 800.
TEST(MatrixFree, StandardErrorsHoldWhereFewLinesMeetARow) {
  InputScene input{"lamp and beads", {}, {}};
  ts::addBox(input, "wall", {0, 0, 0}, {10, 10, 10}, true);
  ts::addBox(input, "lamp", {4.5, 4.5, 9}, {5.5, 5.5, 9.8}, false);
  for (int k = 0; k < 27; ++k) {
    const glm::dvec3 at(0.5 + 4.3 * (k % 3), 0.7 + 4.1 * (k / 3 % 3), 0.6 + 3.7 * (k / 9));
    ts::addBox(input, "bead" + std::to_string(k), at, at + 0.2, false);
  }
  const Scene scene = buildScene(input);
  MaterialTable table =
      tableOf({{"wall", te::hot(0.9, 300), 2}, {"lamp", te::hot(0.9, 800), 3}, {"default", te::flux(0.8, 0), 4}});
  const FormFactors f = computeFormFactors(scene, {.goal = Tolerance{1e-4}}).form_factors;
  const HeatSolution truth = solveHeat(f, assignMaterials(table, f.ids(), surfaceNames(scene)));
  for (const bool has_bands : {false, true}) {
    if (has_bands) table.band_limits_um = {6};
    for (MaterialTable::Line& line : table.lines) line.material.band_emissivities.assign(2, line.material.emissivity);
    const HeatSolution found = solveMatrixFree(scene, table, {}).heat;
    double largest = 0;  // error of a temperature, K
    for (size_t k = 0; k < truth.rows.size(); ++k) {
      const Measured &a = found.rows[k].temperature, &b = truth.rows[k].temperature;
      EXPECT_LE(std::abs(a.value - b.value), 7 * std::hypot(a.standard_error, b.standard_error)) << found.rows[k].name;
      largest = std::max(largest, std::abs(a.value - b.value));
    }
    EXPECT_GT(largest, 10);  // lines did miss the lamp
  }
}

TEST(MatrixFree, DirectionsAreAddedUntilTheTolerance) {
  const Scene scene = buildScene(city(300));
  const MatrixFreeHeat found =
      solveMatrixFree(scene, kCity, {.tolerance = HeatTolerance{1.5, Of::temperature}, .first_directions = 8});
  EXPECT_TRUE(found.is_reached);
  EXPECT_GT(found.rounds, 1u);
  EXPECT_LE(largestHeatError(found.heat, Of::temperature), 1.5);
  // Where time is up after a round, its answers are kept; before the first there are none.
  MatrixFreeObserver observer;
  std::atomic<bool> has_answers = false;
  observer.on_progress = [&](uint64_t, uint64_t, uint64_t, double largest_error) {
    if (std::isfinite(largest_error)) has_answers = true;
  };
  observer.should_stop = [&] { return has_answers.load(); };
  const MatrixFreeHeat stopped = solveMatrixFree(
      scene, kCity, {.tolerance = HeatTolerance{1e-3, Of::temperature}, .first_directions = 8}, observer);
  EXPECT_TRUE(stopped.is_interrupted);
  EXPECT_FALSE(stopped.is_reached);
  EXPECT_EQ(stopped.heat.rows.size(), found.heat.rows.size());
  EXPECT_THROW(solveMatrixFree(scene, kCity, {.time_limit_s = 1e-9}), Error);
}

// Where all heat fluxes are given heat has no errors, so the default goal is of temperatures: 1 K. A first round of
// 8 directions leaves a larger error, and further rounds follow.
TEST(MatrixFree, TheDefaultGoalIsOfWhatIsUnknown) {
  const Scene scene = buildScene(city(300));
  const MatrixFreeHeat fluxes =
      solveMatrixFree(scene, tableOf({{"default", te::flux(0.5, 200), 2}}, 280), {.first_directions = 8});
  EXPECT_EQ(fluxes.tolerance.of, Of::temperature);
  EXPECT_GT(fluxes.rounds, 1u);
  EXPECT_LE(largestHeatError(fluxes.heat, Of::temperature), 1);
  EXPECT_EQ(largestHeatError(fluxes.heat, Of::relative), 0);
  const MatrixFreeHeat mixed = solveMatrixFree(scene, kCity, {.first_directions = 64});
  EXPECT_EQ(mixed.tolerance.of, Of::relative);
  EXPECT_LE(largestHeatError(mixed.heat, Of::relative), 0.01);
}

TEST(MatrixFree, RefusesWhatHasNoAnswer) {
  const auto refuses = [](const InputScene& input, const MaterialTable& table, const MatrixFreeRequest& request,
                          const std::string& part) {
    try {
      solveMatrixFree(buildScene(input), table, request);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      return;
    }
    ADD_FAILURE() << "nothing says " << part;
  };
  const InputScene boxes = ts::cubeInCube(0.4), squares = ts::parallelSquares();
  MaterialTable bands = tableOf({{"default", te::hot(0.5, 300), 2}, {"inner", te::flux(0.5, -5000), 3}});
  bands.band_limits_um = {3};
  for (MaterialTable::Line& line : bands.lines) line.material.band_emissivities = {0.2, 0.7};
  refuses(boxes, bands, {.by = By::surface}, "'inner' would have to emit -");
  refuses(boxes, tableOf({{"inner", te::hot(0.5, 300), 2}}), {}, "has no material");
  refuses(squares, tableOf({{"default", te::hot(0.5, 300), 2}}), {}, "'environment'");
  refuses(boxes, tableOf({{"default", te::hot(0.5, 300), 2}}), {.tolerance = HeatTolerance{1, Of::temperature}},
          "all temperatures are given");
  refuses(boxes, tableOf({{"default", te::hot(0.5, 300), 2}}), {.tolerance = HeatTolerance{0, Of::relative}},
          "not above 0");
  refuses(squares, tableOf({{"default", te::flux(0.5, 30), 2}}, 280), {.tolerance = HeatTolerance{0.01, Of::relative}},
          "all heat fluxes are given");
  InputScene inside_out = boxes;
  for (InputFace& face : inside_out.faces)
    if (inside_out.surface_names[face.surface] == "inner") std::ranges::reverse(face.corners);
  refuses(inside_out, tableOf({{"default", te::hot(0.5, 300), 2}}), {}, "ends on backs");
  // A second box within a box, beside the first, has heat fluxes alone.
  InputScene two = boxes;
  for (const std::string& name : boxes.surface_names) two.surface_names.push_back("other_" + name);
  for (InputFace face : boxes.faces) {
    for (glm::dvec3& corner : face.corners) corner.x += 3;
    face.surface += static_cast<uint32_t>(boxes.surface_names.size());
    two.faces.push_back(face);
  }
  const MaterialTable island = tableOf({{"default", te::hot(0.5, 300), 2}, {"other_*", te::flux(0.5, 0), 3}});
  refuses(two, island, {.by = By::surface}, "the temperature of ");
}

// Returns the city's materials with emissivities that depend on the wavelength.
MaterialTable bandsOfCity() {
  MaterialTable table = kCity;
  table.band_limits_um = {5, 12};
  for (MaterialTable::Line& line : table.lines) {
    const double e = line.material.emissivity;
    line.material.band_emissivities = {e, 0.3 * e, std::min(1.0, 1.1 * e)};
  }
  return table;
}

// Both solve the same equations, each by a Newton's method of its own: temperatures follow from irradiations here, and
// irradiations from temperatures there. The matrix keeps heat fluxes to 1e-12 of the largest emission, and a condition
// number of some hundreds and emissivities of 0.15 leave 1e-8 of the emission at 310 K, as above.
TEST(MatrixFree, BandsEqualTheSameCountsInAMatrix) {
  const Scene scene = buildScene(city(300));
  MaterialTable table = bandsOfCity();
  const MatrixFreeRequest request{.first_directions = 16, .residual = 1e-12, .seed = 3};
  const MatrixFreeHeat found = solveMatrixFree(scene, table, request);
  ASSERT_EQ(found.rounds, 1u);
  const FormFactors f = formFactorsOf(scene, request, found);
  const HeatSolution stored = solveHeat(f, assignMaterials(table, f.ids(), surfaceNames(scene)));
  const double power = te::power(310), kMost = 1e-8 * power;
  expectSame(found.heat, stored, kMost);
  EXPECT_LE(std::abs(found.heat.balance_residual), 1e-9 * stored.heat_flow_total);
  // Negative control: grey surfaces of the first band's emissivities have other temperatures.
  const HeatSolution grey = solveMatrixFree(scene, kCity, request).heat;
  double largest = 0;
  for (size_t k = 0; k < stored.rows.size(); ++k)
    largest = std::max(largest, std::abs(grey.rows[k].temperature.value - stored.rows[k].temperature.value));
  EXPECT_GT(largest, 1);
}

// Where all bands have the same emissivity, answers and standard errors are those of grey surfaces. Errors are carried
// by equations that are solved to 1e-3 in both, so that they agree within some times as much.
TEST(MatrixFree, AlikeBandsAreGrey) {
  const Scene scene = buildScene(city(300));
  MaterialTable table = kCity;
  table.environment_temperature.reset();
  table.sky_and_ground = SkyAndGround{250, 290};
  const MatrixFreeRequest request{.first_directions = 16, .residual = 1e-12};
  const HeatSolution grey = solveMatrixFree(scene, table, request).heat;
  table.band_limits_um = {5, 12};
  for (MaterialTable::Line& line : table.lines) line.material.band_emissivities.assign(3, line.material.emissivity);
  const HeatSolution bands = solveMatrixFree(scene, table, request).heat;
  const auto expectSame = [](const Measured& a, const Measured& b, double scale, const std::string& what) {
    EXPECT_TRUE(isWithin(a.value, b.value, 1e-8 * scale)) << what;
    EXPECT_TRUE(isWithin(a.standard_error, b.standard_error, 0.02 * b.standard_error + 1e-9 * scale)) << what;
  };
  for (size_t k = 0; k < grey.surfaces.size(); ++k) {
    const HeatRow &a = bands.surfaces[k], &b = grey.surfaces[k];
    expectSame(a.irradiation, b.irradiation, te::power(310), a.name);
    expectSame(a.radiosity, b.radiosity, te::power(310), a.name);
    expectSame(a.heat_flux, b.heat_flux, te::power(310), a.name);
    expectSame(a.temperature, b.temperature, 310, a.name);
  }
  expectSame(bands.to_environment, grey.to_environment, grey.heat_flow_total, "environment");
  expectSame(*bands.to_up, *grey.to_up, grey.heat_flow_total, "sky");
  expectSame(*bands.to_down, *grey.to_down, grey.heat_flow_total, "ground");
}

// The spread of 40 seeds' answers is compared with the standard errors that they state. A mean square of 40 values has
// a relative standard error of 0.22, and a mean of 40 stated variances, of 7 degrees of freedom each, has 0.085. So
// their ratio is within 0.24 of 1, and five times this far from 1 in about one of a million cases.
TEST(MatrixFree, StandardErrorsOfBandsHold) {
  const Scene scene = buildScene(ts::cubeInCube(0.4));
  MaterialTable table = tableOf({{"inner", te::flux(0.8, 900), 2}, {"outer", te::hot(0.3, 300), 3}});
  table.band_limits_um = {6};
  table.lines[0].material.band_emissivities = {0.9, 0.4};
  table.lines[1].material.band_emissivities = {0.2, 0.6};
  std::vector<double> values;
  double stated = 0, mean = 0, squares = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    const MatrixFreeHeat found = solveMatrixFree(
        scene, table,
        {.by = By::polygon, .tolerance = HeatTolerance{1e3, Of::temperature}, .first_directions = 16, .seed = seed});
    const Measured& warm = std::ranges::find(found.heat.surfaces, "inner", &HeatRow::name)->temperature;
    ASSERT_GT(warm.standard_error, 0);
    values.push_back(warm.value);
    mean += warm.value / 40;
    stated += warm.standard_error * warm.standard_error / 40;
  }
  for (const double value : values) squares += (value - mean) * (value - mean) / 39;
  EXPECT_LT(squares, 2.2 * stated);
  EXPECT_GT(squares, stated / 2.2);
}

TEST(MatrixFree, BandsOfOneTemperatureMeanNoHeat) {
  const Scene scene = buildScene(city(300));
  MaterialTable table = tableOf({{"default", te::hot(0.3, 300), 2}, {"*2]", te::flux(0.5, 0), 4}}, 300);
  table.band_limits_um = {8};
  for (MaterialTable::Line& line : table.lines) line.material.band_emissivities = {1e-3, 0.9};
  for (const HeatRow& row : solveMatrixFree(scene, table, {.first_directions = 16}).heat.rows) {
    EXPECT_TRUE(isWithin(row.heat_flux.value, 0, 1e-9 * te::power(300))) << row.name;
    EXPECT_TRUE(isWithin(row.temperature.value, 300, 1e-9 * 300)) << row.name;
  }
}

// Sums of products are whole numbers, so that ranks which share the directions give the bits of one. The materials are
// grey under sky and ground, with bands, and directional.
TEST(MatrixFree, RanksGiveTheBitsOfOne) {
  const Scene scene = buildScene(city(300));
  MaterialTable apart = kCity, directional = kCity;
  apart.environment_temperature.reset();
  apart.sky_and_ground = SkyAndGround{250, 290};
  directional.laws = {{.cosine_power = 2}, {.cosine_power = 0, .angles_deg = {0, 60, 90}, .values = {1, 1, 0.2}}};
  directional.lines[0].material = te::hot(0.4, 300);
  directional.lines[0].material.directional = 0;
  directional.lines[1].material.directional = 1;
  directional.lines[1].material.emissivity = 0.5;
  for (const MaterialTable& table : {apart, bandsOfCity(), directional}) {
    MatrixFreeRequest request{.first_directions = 8, .threads = 1};
    const HeatSolution alone = solveMatrixFree(scene, table, request).heat;
    for (const uint32_t size : {2u, 3u, 5u}) {
      HeatSolution shared;
      test::withRanks(
          size,
          [&](Ranks& ranks) {
            Request served;
            served.threads = 1;
            serveRanks(ranks, scene, served);
          },
          [&](Ranks& ranks) {
            request.ranks = &ranks;
            shared = solveMatrixFree(scene, table, request).heat;
          });
      ASSERT_EQ(shared.rows.size(), alone.rows.size());
      for (size_t k = 0; k < alone.rows.size(); ++k) {
        EXPECT_EQ(shared.rows[k].irradiation.value, alone.rows[k].irradiation.value);
        EXPECT_EQ(shared.rows[k].irradiation.standard_error, alone.rows[k].irradiation.standard_error);
        EXPECT_EQ(shared.rows[k].temperature.value, alone.rows[k].temperature.value);
      }
    }
  }
}

TEST(MatrixFree, AMatrixOfAllPairsIsPredicted) {
  EXPECT_LT(matrixBytes(10'000), kMostMatrixBytes);
  EXPECT_GT(matrixBytes(11'000), kMostMatrixBytes);
}

}  // namespace
}  // namespace viewpeel

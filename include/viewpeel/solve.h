// solveHeat() computes heat flows and temperatures of a grey, diffuse enclosure, open or closed, from form factors.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <viewpeel/compute.h>
#include <viewpeel/environment.h>
#include <viewpeel/form_factors.h>

namespace viewpeel {

constexpr double kStefanBoltzmann = 5.670374419e-8;  // W m^-2 K^-4; CODATA 2018, exact to these digits

// A Material is one row's emissivity, or emissivities by wavelength, and either its temperature or its net heat flux.
struct Material {
  double emissivity = 1;              // in (0, 1]; absorptivity is the same
  std::optional<double> temperature;  // K, at least 0
  std::optional<double> heat_flux;    // W/m2 by which the row emits more than it absorbs; 0: adiabatic
  // Emissivities by band of wavelengths replace `emissivity`; each is in (0, 1]. Grey rows have none.
  std::vector<double> band_emissivities{};
  std::optional<uint32_t> directional{};  // index of the law by which emissivity depends on the angle; unset: diffuse
};

// A DirectionalLaw says how emissivity depends on the angle from the normal: e(angle) = emissivity g(angle). The law
// gives the shape of g, which is scaled to the mean 1 over the hemisphere, weighted by the cosine. So
// Material::emissivity stays the hemispherical emissivity.
struct DirectionalLaw {
  double cosine_power = 0;  // g is proportional to cos^power; at least 0
  // Or g is proportional to a table, linear in the angle: angles ascend from 0 to 90 degrees, values are at least 0.
  // Used instead of the power unless empty.
  std::vector<double> angles_deg{}, values{};
};

// Sky and ground are the parts of the environment above and below the horizon. Both are black, each at one temperature.
struct SkyAndGround {
  double up = 0, down = 0;  // K
};

// A MaterialTable is a file of materials, as lines.
struct MaterialTable {
  struct Line {
    std::string name;  // of a surface or face, with wildcards, or `default`
    Material material;
    uint32_t line = 0;  // line number in the file; 0 without a file
  };

  std::string file;                               // for messages
  std::vector<Line> lines;                        // all lines but the environment's
  std::optional<double> environment_temperature;  // K; unset where sky and ground have temperatures
  std::optional<SkyAndGround> sky_and_ground{};
  std::vector<double> band_limits_um{};  // as in Enclosure
  std::vector<DirectionalLaw> laws{};    // that Material::directional is an index of
  glm::dvec3 up{0, 0, 1};                // upwards, orthogonal to the horizon; set by the caller
};

// An Enclosure has a material for each row of the form factors.
struct Enclosure {
  std::vector<Material> materials;
  std::optional<double> environment_temperature;  // K; needed where radiation leaves the scene
  std::vector<std::string> surface_names;         // that Ids::surface is an index of
  std::optional<SkyAndGround> sky_and_ground{};   // used instead of environment_temperature
  // Bands of wavelengths meet at these limits, in micrometres, ascending: the first band begins at 0, and the last has
  // no end. Empty where rows are grey.
  std::vector<double> band_limits_um{};
  std::optional<EnvironmentParts> environment_parts{};  // for the same rows; needed with sky_and_ground
  std::vector<DirectionalLaw> laws{};                   // that Material::directional is an index of
};

// Reads a .csv with the header `surface,emissivity,temperature,heat_flux`; columns may stand in any order.
//   In: file: a line for each name, with either a temperature in K, or a heat_flux in W/m2 or `adiabatic`. The line
//     `environment` has only a temperature. Lines `environment:up` and `environment:down` split it; where one is
//     missing, `environment` gives its temperature. With bands of wavelengths the header has a column for each band
//     instead of `emissivity`: `emissivity:0-2.5`, `emissivity:2.5-8`, `emissivity:8-inf`, in micrometres. A column
//     `directional` may say how emissivity depends on the angle: empty for diffuse rows, `cosine:POWER`, or the name of
//     a .csv with the header `angle_degrees,relative_emissivity`, beside the file. Empty lines and lines that begin
//     with # are skipped.
//   Out: the lines, in their order
//   Error: none: numbers as the file has them. Tests: tests/unit/solve_materials_test.cpp.
//   Throws: Error bad_input, naming file, line and remedy: an emissivity outside (0, 1], both or neither of temperature
//     and heat flux, a repeated name, one part of the environment without the other, or both besides the whole.
//   Cost: O(length of the file).
MaterialTable readMaterials(const std::filesystem::path& file);

// Finds each row's material: the line of its face ("desk[3]"), else of its surface ("desk"), else the last line whose
// wildcards match either (* any characters, ? one), else the line `default`.
//   In: ids: rows of the form factors; surface_names: different names, which Ids::surface is an index of
//   Out: a material for each id
//   Error: none. Tests: tests/unit/solve_materials_test.cpp.
//   Throws: Error bad_input, naming line and remedy, where a line names nothing in the scene or a face while rows are
//     surfaces, or where a row has no material.
//   Cost: O(rows x lines with wildcards).
Enclosure assignMaterials(const MaterialTable& table, const Ids& ids, const std::vector<std::string>& surface_names);

// HeatBounds bound the errors of answers, all at once, with the probability of the form factors' guarantee.
struct HeatBounds {
  double temperature = 0, radiosity = 0, irradiation = 0, heat_flux = 0, heat_flow = 0;
};

// A HeatRow has the answers of one row. Standard errors follow from the form factors' errors; values that materials
// give are exact.
struct HeatRow {
  std::string name;
  double area = 0;                     // emitting, input units squared
  double emissivity = 1;               // of a surface of several rows its mean over the area
  Measured temperature;                // K; of several rows the temperature at which they emit as much
  Measured radiosity;                  // W/m2 that leave the row
  Measured irradiation;                // W/m2 that arrive at the row
  Measured heat_flux;                  // W/m2, radiosity less irradiation
  Measured heat_flow;                  // heat flux times area: W if the input unit is the metre
  std::optional<HeatBounds> bounds{};  // where form factors have intervals
};

struct HeatSolution {
  std::vector<HeatRow> rows;      // of the form factors
  std::vector<HeatRow> surfaces;  // sums and means over the rows of each surface that has rows
  bool is_open = false;           // whether radiation leaves the scene
  Measured to_environment;        // heat flow out of the scene
  // Heat flows to sky and ground, if they have temperatures; they add up to to_environment.
  std::optional<Measured> to_up{}, to_down{};
  // balance_residual is the sum of all rows' heat flows less to_environment; heat_flow_total is half the sum of their
  // absolute values.
  double balance_residual = 0, heat_flow_total = 0;
  // Row `lacking_row` has the form factors whose sum, environment included, is farthest from 1.
  double largest_lack = 0;
  std::string lacking_row;
  uint32_t steps = 0;  // of conjugate gradients
};

// Solves the enclosure: docs/solve.md, eq. (1) to (6), and (11) to (13) with bands of wavelengths.
//   B_i = e_i s T_i^4 + (1 - e_i) H_i, or B_i = q_i + H_i where q_i is given; A_i H_i = sum_j x_ij B_j + x_ie s T_e^4.
//   B is radiosity, H irradiation, e emissivity, s the Stefan-Boltzmann constant, T temperature, q heat flux, x
//   exchange area; index e is the environment. A row whose form factors do not sum to 1 exchanges the difference with
//   itself. So exchange stays symmetric, energy
//     is conserved, and in a scene of one temperature all heat fluxes are 0 whatever the errors.
//   In: form_factors: of all rows; with intervals (GuaranteedBy::chernoff) there must be one for every pair that may
//     see each other; enclosure: with a material for each row, and with environment_parts where sky and ground have
//     temperatures. Errors of these parts are propagated to the answers, too.
//   Out: see HeatSolution; bounds where form factors have intervals, eq. (10). They hold for scenes without leak.
//   Error: of the equations 1e-11 of the largest |B - s T_0^4| for emissivities from 1e-3 on. T_0 is the temperature of
//     the environment, or the first given one. Standard errors are of first order, for independent pairs; above 1,000
//     rows they are themselves estimates with a relative standard error of 1/16. Tests: tests/unit/solve_heat_test.cpp,
//     solve_errors_test.cpp, solve_bounds_test.cpp.
//   Throws: Error bad_usage for form factors of some rows only, and for materials that do not match them. The same for
//     directional materials, which solveMatrixFree takes, and for intervals together with sky and ground or with bands.
//     Error bad_input where radiation ends on backs, leaves a scene without an environment, rows exchange with no given
//     temperature, or a heat flux would need a temperature below 0; limit where conjugate gradients do not converge.
//   Cost: some dozens of products with the sparse matrix. Standard errors take O(rows^3 + rows x pairs) up to 1,000
//     rows, above it 128 such solutions. Memory: 32 bytes a pair, and 8 rows^2 up to 1,000 rows.
//   Source: A. K. Oppenheim, Radiation analysis by the network method, Trans. ASME 78, 1956, 725-735.
HeatSolution solveHeat(const FormFactors& form_factors, const Enclosure& enclosure);

// A HeatTolerance is the largest standard error that answers may have.
struct HeatTolerance {
  enum class Of {
    temperature,  // K, over all temperatures that are not given
    heat_flux,    // W/m2, over all rows
    relative,     // of heat flows, over HeatSolution::heat_flow_total
  };
  double standard_error = 0;  // above 0
  Of of = Of::relative;
};

// Returns the largest standard error of the rows' answers, of the tolerance's quantity.    Cost: O(rows).
double largestHeatError(const HeatSolution& solution, HeatTolerance::Of of);

// A SceneHeat is the answers of a scene and the form factors from which they were computed.
struct SceneHeat {
  HeatSolution heat;
  Result form_factors;
  uint32_t runs = 1;                 // how often form factors were computed
  double form_factor_tolerance = 0;  // of the last run; 0 where the request has another goal
  bool is_reached = true;            // false where time ran out before the tolerance was reached
};

// Computes the form factors of a scene and solves the enclosure. If sky and ground have temperatures, it also measures
// form factors to both, to the same tolerance.
//   With a tolerance it computes form factors to 0.02, and again with smaller tolerances until the answers are as exact
//     as requested. Answers average over many form factors, which therefore may have larger errors.
//   In: request: its goal is used without a tolerance; its time limit is for all runs
//     together
//   Out: see SceneHeat
//   Error: as solveHeat. Tests: tests/unit/solve_scene_test.cpp.
//   Throws: as assignMaterials, before the computation; as computeFormFactors and solveHeat; Error limit where the
//     tolerance needs form factors below 2e-6, or the observer stops the run; Error bad_usage for a tolerance of
//     temperatures if all are given.
//   Cost: that of computeFormFactors and solveHeat; with a tolerance, about twice that of the last run.
SceneHeat solveScene(const Scene& scene, const MaterialTable& materials, Request request = {},
                     std::optional<HeatTolerance> tolerance = {}, const Observer& observer = {});

// ExchangeFactors store conductors R_ij, symmetric, in input units squared. Heat flows from row i to j, over all
// reflections, at the rate s R_ij (T_i^4 - T_j^4). R_ij = A_i e_i B_ij = A_i F*_ij, where Gebhart's factor B_ij is the
// share of the emission of i that j absorbs, and F* is Hottel's script-F.
struct ExchangeFactors {
  struct Entry {
    uint32_t i, j;  // i <= j; j may be kEnvironment
    double conductor;
  };
  std::vector<Entry> entries;        // nonzero, sorted by (i, j)
  std::vector<std::string> names;    // of rows
  std::vector<double> areas;         // input units squared
  std::vector<double> emissivities;  // of rows
  uint64_t dropped = 0;              // number of pairs left out
  double largest_dropped_share = 0;  // largest share of a row's emission that was left out, before balancing
};

// Computes the exchange factors of an enclosure: docs/solve.md, eq. (9).
//   B = (I - F R)^-1 F E, with diagonal matrices of emissivities E and reflectivities R = I - E; rows of B, environment
//   included, sum to 1
//   Pairs whose Gebhart factors are below drop_below in both directions are left out, except each row's largest. The
//     others are then balanced (balanceRows), so that R stays symmetric, rows still sum to A_i e_i, and energy is
//     conserved.
//   In: form_factors: of all rows; enclosure: only emissivities matter; drop_below: in [0, 1)
//   Out: see ExchangeFactors
//   Error: rounding, 1e-12 of A_i e_i. Tests: tests/unit/solve_exchange_test.cpp compares with solveHeat.
//   Throws: Error bad_usage and bad_input as solveHeat for form factors and emissivities; bad_input where rows cannot
//     be balanced after dropping; limit above 10,000 rows.
//   Cost: 2.3 n^3; memory 48 n^2 bytes.
//   Source: B. Gebhart, Surface temperature calculations in radiant surroundings of arbitrary complexity, Int. J. Heat
//     Mass Transfer 3, 1961, 341-346; H. C. Hottel & A. F. Sarofim, Radiative Transfer, McGraw-Hill 1967 (script-F).
ExchangeFactors findExchangeFactors(const FormFactors& form_factors, const Enclosure& enclosure, double drop_below = 0);

// Exchange factors can be written as tables, or as radiation conductors of thermal networks.
enum class ExchangeKind {
  gebhart,   // .csv: `from,to,gebhart,conductor`, both ways, row by row; `environment` stands in `to`
  script_f,  // .csv: `from,to,script_f,conductor`
  esatan,    // .d: `GR(1,2) = 0.0123;`
  sinda,     // .inp: `-1, 1, 2, 0.0123` of HEADER CONDUCTOR DATA
};
constexpr uint32_t kEnvironmentNode = 99'999;  // number of the environment's node; rows are nodes from 1 on

// Returns the ending of a file of this kind: ".exchange.csv" and so on.    Cost: O(1).
const char* exchangeExtension(ExchangeKind kind);

// Writes exchange factors. Conductors of a network are in input units squared, without the Stefan-Boltzmann constant,
// once for each pair of rows. A row's conductor to itself is left out, for no heat flows through it.
//   Error: none: numbers read back to the same bits. Tests: tests/unit/solve_exchange_test.cpp,
//     tests/files/conductors_test.cpp.
//   Throws: Error limit where a network has kEnvironmentNode rows or more. A failure to write is the state of `out`.
//   Cost: O(entries).
void writeExchange(const ExchangeFactors& factors, ExchangeKind kind, std::ostream& out);
// Writes exchange factors to a file, as writeHeat does. The file's extension must be that of exchangeExtension().
void writeExchange(const ExchangeFactors& factors, ExchangeKind kind, const std::filesystem::path& file);
// Refuses a file that writeExchange would refuse, as checkHeatOutput.
void checkExchangeOutput(const std::filesystem::path& file, ExchangeKind kind);

// Writes `surface,area,emissivity,temperature,radiosity,irradiation,heat_flux,heat_flow`. Each uncertain column is
// followed by its `_standard_error` and, if rows have bounds, by its `_bound`. With rows by polygon the first column is
// `polygon`.
//   In: by: whether to write HeatSolution::rows or surfaces
//   Out: 1 + rows lines. An open scene has a last line `environment` with the heat flow that leaves it, or two lines
//     `environment:up` and `environment:down` if sky and ground have temperatures.
//   Error: none: numbers read back to the same bits. Tests: tests/unit/solve_materials_test.cpp.
//   Throws: nothing; a failure to write is the state of `out`.    Cost: O(rows).
void writeHeat(const HeatSolution& solution, By by, std::ostream& out);

// Writes the answers to a file, which is never half written.
//   In: file: ends in .csv; its folder exists    Error: none. Tests: tests/program/solve_program_test.cpp.
//   Throws: Error bad_usage for another extension; Error output, naming file and the system's reason.    Cost: O(rows).
void writeHeat(const HeatSolution& solution, By by, const std::filesystem::path& file);
// Refuses a file that writeHeat would refuse. Callers use it before the computation.
//   Throws: Error bad_usage: an unknown extension, a file that cannot be written.
//   Cost: one file of a byte, written and removed.
void checkHeatOutput(const std::filesystem::path& file);

}  // namespace viewpeel

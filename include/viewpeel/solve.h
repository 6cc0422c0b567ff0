// Form factors and materials give heat flows and temperatures: the grey, diffuse enclosure, open or closed.
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
  std::optional<double> temperature;  // K, 0 at least
  std::optional<double> heat_flux;    // W/m2 by which the row emits more than it absorbs; 0: adiabatic
  // One for each band of wavelengths, each in (0, 1], in place of `emissivity`. Empty for grey rows.
  std::vector<double> band_emissivities{};
};

// Sky and ground are the parts of the environment above and below the horizon, black, each at one temperature.
struct SkyAndGround {
  double up = 0, down = 0;  // K
};

// A MaterialTable is a file of materials, line by line.
struct MaterialTable {
  struct Line {
    std::string name;  // of a surface or face, with wildcards, or `default`
    Material material;
    uint32_t line = 0;  // in the file; 0 where there is none
  };

  std::string file;                               // for messages
  std::vector<Line> lines;                        // all but that of the environment
  std::optional<double> environment_temperature;  // K; unset where sky and ground are apart
  std::optional<SkyAndGround> sky_and_ground{};
  std::vector<double> band_limits_um{};  // as in Enclosure
  glm::dvec3 up{0, 0, 1};                // the horizon is orthogonal to it; set by the caller, for no file has it
};

// An Enclosure has a material for each row of the form factors.
struct Enclosure {
  std::vector<Material> materials;
  std::optional<double> environment_temperature;  // K; needed where radiation leaves the scene
  std::vector<std::string> surface_names;         // of the indices in Ids::surface
  std::optional<SkyAndGround> sky_and_ground{};   // in place of the one temperature
  // Bands of wavelengths meet here, micrometres, ascending: the first begins at 0, and the last has no end. Empty where
  // rows are grey.
  std::vector<double> band_limits_um{};
  std::optional<EnvironmentParts> environment_parts{};  // of the same rows; needed where sky and ground are apart
};

// Reads a .csv with the header `surface,emissivity,temperature,heat_flux`; columns may stand in any order.
//   In: file: one line a name; temperature in K or heat_flux in W/m2 or `adiabatic`, the other one empty. The line
//     `environment` has a temperature alone, and so have `environment:up` and `environment:down`; one of these two
//     alone leaves the other part to `environment`. With bands of wavelengths the header has a column for each in place
//     of `emissivity`: `emissivity:0-2.5`, `emissivity:2.5-8`, `emissivity:8-inf`, in micrometres. Empty lines
//     and lines that begin with # are passed over.
//   Out: the lines, in their order
//   Error: none: numbers as the file has them. Tests: tests/unit/solve_materials_test.cpp.
//   Throws: Error bad_input, naming file, line and remedy: an emissivity outside (0, 1], both or neither of temperature
//     and heat flux, a name twice, one part of the environment without the other, or both beside the whole.
//   Cost: O(length of the file).
MaterialTable readMaterials(const std::filesystem::path& file);

// Finds each row's material. A row has the line of its face ("desk[3]"), else of its surface ("desk"). Else it has the
// last line with wildcards that fit either (* any characters, ? one), else that of `default`.
//   In: table; ids: rows of the form factors; surface_names: of the indices in Ids::surface, without repetition
//   Out: a material for each id
//   Error: none. Tests: tests/unit/solve_materials_test.cpp.
//   Throws: Error bad_input, naming line and remedy, where a line names nothing of the scene, or a face where rows are
//     surfaces, or a row has no material.
//   Cost: O(rows x lines with wildcards).
Enclosure assignMaterials(const MaterialTable& table, const Ids& ids, const std::vector<std::string>& surface_names);

// HeatBounds hold with the probability of a guarantee, all at once: the answer of the true form factors is within each.
struct HeatBounds {
  double temperature = 0, radiosity = 0, irradiation = 0, heat_flux = 0, heat_flow = 0;
};

// A HeatRow has the answers of one row. Standard errors are those that the form factors' errors cause; what materials
// give is exact.
struct HeatRow {
  std::string name;
  double area = 0;                     // emitting, input units squared
  double emissivity = 1;               // of a surface of several rows: its mean over the area
  Measured temperature;                // K; of several rows: that at which they would emit as much
  Measured radiosity;                  // W/m2 that leave
  Measured irradiation;                // W/m2 that arrive
  Measured heat_flux;                  // W/m2, radiosity less irradiation
  Measured heat_flow;                  // heat flux times area: W where the input unit is the metre
  std::optional<HeatBounds> bounds{};  // where form factors have intervals
};

struct HeatSolution {
  std::vector<HeatRow> rows;      // of the form factors
  std::vector<HeatRow> surfaces;  // sums and means over the rows of each surface; of surfaces that have rows
  bool is_open = false;           // radiation leaves the scene
  Measured to_environment;        // heat flow out of the scene
  // Of an open scene with sky and ground apart: the heat flows to each, which add up to to_environment.
  std::optional<Measured> to_up{}, to_down{};
  // The residual is the heat flow of all rows less that to the environment; the total half the sum of all sizes.
  double balance_residual = 0, heat_flow_total = 0;
  // Row `lacking_row` has form factors whose sum, environment included, is off 1 by the most.
  double largest_lack = 0;
  std::string lacking_row;
  uint32_t steps = 0;  // of conjugate gradients
};

// Solves the enclosure: docs/solve.md, eq. (1) to (6), and (11) to (13) with bands of wavelengths.
//   B_i = e_i s T_i^4 + (1 - e_i) H_i, or B_i = q_i + H_i where q_i is given;  A_i H_i = sum_j x_ij B_j + x_ie s T_e^4
//   What a row's form factors lack of 1, or exceed it by, is taken for radiation that returns to the row. So exchange
//     stays symmetric, energy is kept, and in a scene of one temperature all heat fluxes are 0, whatever the errors.
//   In: form factors of all rows; enclosure: a material for each, and the parts of the environment where sky and ground
//     are apart, whose errors are carried to the answers with those of the form factors. Intervals, if any (of
//     GuaranteedBy::chernoff), have to be of all pairs that may see each other.
//   Out: see HeatSolution; bounds where form factors have intervals, eq. (10). They hold for scenes without leak.
//   Error: of the equations, for emissivities from 1e-3 on: 1e-11 of the largest |B - s T_0^4|, T_0 being the
//     environment's temperature or the first given one. Standard errors: of first order, pairs taken for independent;
//     beyond 1,000 rows they have a standard error of 1/16 of themselves. Tests: tests/unit/solve_heat_test.cpp,
//     solve_errors_test.cpp, solve_bounds_test.cpp.
//   Throws: Error bad_usage for form factors of some rows only, or materials that do not go with them, or
//     intervals beside sky and ground apart or bands; bad_input where radiation ends on backs, leaves the scene without
//     an environment, rows have no temperature to refer to, or a heat flux would need a temperature below 0; limit
//     where conjugate gradients do not end.
//   Cost: some dozens of products with the sparse matrix, 128 times as many for standard errors beyond 1,000 rows; else
//     O(rows^3 + rows x pairs). Memory: 32 bytes a pair, and 8 rows^2 up to 1,000 rows.
//   Source: A. K. Oppenheim, Radiation analysis by the network method, Trans. ASME 78, 1956, 725-735.
HeatSolution solveHeat(const FormFactors& form_factors, const Enclosure& enclosure);

// A HeatTolerance is the largest standard error that answers may have.
struct HeatTolerance {
  enum class Of {
    temperature,  // K, over temperatures that are not given
    heat_flux,    // W/m2, over all rows
    relative,     // of heat flows, as a share of HeatSolution::heat_flow_total
  };
  double standard_error = 0;  // above 0
  Of of = Of::relative;
};

// Returns the largest standard error of the answers of rows, as the tolerance means it.    Cost: O(rows).
double largestHeatError(const HeatSolution& solution, HeatTolerance::Of of);

// The SceneHeat of a scene has the answers and the form factors that they come from.
struct SceneHeat {
  HeatSolution heat;
  Result form_factors;
  uint32_t runs = 1;                 // of form factors
  double form_factor_tolerance = 0;  // of the last run; 0 where the request has another goal
  bool is_reached = true;            // false where time was up before the tolerance
};

// Computes the form factors of a scene and solves the enclosure. Where sky and ground are apart, it measures the parts
// of the environment to the tolerance of the form factors.
//   With a tolerance form factors start at 0.02, and are computed again with a smaller tolerance until the answers have
//     theirs. Answers average over many form factors, whose errors may be larger.
//   In: request: rows, seed and the like; its goal counts where there is no tolerance; its time limit counts for all
//     runs together
//   Out: see SceneHeat
//   Error: as solveHeat. Tests: tests/unit/solve_scene_test.cpp.
//   Throws: as assignMaterials, before anything is computed; as computeFormFactors and solveHeat; Error limit where the
//     tolerance takes form factors below 2e-6, or the observer stops the run; Error bad_usage for a tolerance of
//     temperatures where all are given.
//   Cost: that of computeFormFactors and solveHeat; with a tolerance, about twice that of the last run.
SceneHeat solveScene(const Scene& scene, const MaterialTable& materials, Request request = {},
                     std::optional<HeatTolerance> tolerance = {}, const Observer& observer = {});

// The ExchangeFactors of an enclosure are kept as conductors, symmetric and in input units squared. What flows from row
// i to j by all paths is s R_ij (T_i^4 - T_j^4). R_ij = A_i e_i B_ij = A_i F*_ij: B are Gebhart's factors, the shares
// of what i emits that j absorbs, and F* Hottel's script-F.
struct ExchangeFactors {
  struct Entry {
    uint32_t i, j;  // i <= j; j may be kEnvironment
    double conductor;
  };
  std::vector<Entry> entries;        // nonzero, sorted by (i, j)
  std::vector<std::string> names;    // of rows
  std::vector<double> areas;         // input units squared
  std::vector<double> emissivities;  // of rows
  uint64_t dropped = 0;              // pairs below the cut
  double largest_dropped_share = 0;  // of what a row emits, before the rest took its place
};

// Computes the exchange factors of an enclosure: docs/solve.md, eq. (9).
//   B = (I - F R)^-1 F E, whose rows, environment included, sum to 1
//   Pairs whose Gebhart factors are below the cut both ways are left out, but for each row's largest. The others are
//     then balanced (balanceRows), so that R stays symmetric and rows sum to A_i e_i as before: energy is kept.
//   In: form factors of all rows; enclosure: emissivities count, temperatures do not; drop_below: in [0, 1)
//   Out: see ExchangeFactors
//   Error: rounding, 1e-12 of A_i e_i. Tests: tests/unit/solve_exchange_test.cpp compares with solveHeat.
//   Throws: Error bad_usage and bad_input as solveHeat for form factors and emissivities; bad_input for a cut that
//     leaves rows which cannot be balanced; limit above 10,000 rows.
//   Cost: 2.3 n^3; memory 48 n^2 bytes.
//   Source: B. Gebhart, Surface temperature calculations in radiant surroundings of arbitrary complexity, Int. J. Heat
//     Mass Transfer 3, 1961, 341-346; H. C. Hottel & A. F. Sarofim, Radiative Transfer, McGraw-Hill 1967 (script-F).
ExchangeFactors findExchangeFactors(const FormFactors& form_factors, const Enclosure& enclosure, double drop_below = 0);

// Exchange factors are written as tables, or as radiation conductors that thermal networks take.
enum class ExchangeKind {
  gebhart,   // .csv: `from,to,gebhart,conductor`, both ways, row by row; `environment` stands in `to`
  script_f,  // .csv: `from,to,script_f,conductor`
  esatan,    // .d: `GR(1,2) = 0.0123;`
  sinda,     // .inp: `-1, 1, 2, 0.0123` of HEADER CONDUCTOR DATA
};
constexpr uint32_t kEnvironmentNode = 99'999;  // of a network; rows are nodes from 1 on

// Returns the ending of a file of that kind: ".exchange.csv" and so on.    Cost: O(1).
const char* exchangeExtension(ExchangeKind kind);

// Writes exchange factors. Conductors of a network are in input units squared, without the Stefan-Boltzmann constant,
// each pair of rows once; a row's conductor to itself is left out, for no heat flows through it.
//   Error: none: numbers read back to the same bits. Tests: tests/unit/solve_exchange_test.cpp,
//     tests/files/conductors_test.cpp.
//   Throws: Error limit where a network has more rows than nodes below kEnvironmentNode; a failure is out's state.
//   Cost: O(entries).
void writeExchange(const ExchangeFactors& factors, ExchangeKind kind, std::ostream& out);
// Writes the same to a file, as writeHeat; its name ends as exchangeExtension's last dot says.
void writeExchange(const ExchangeFactors& factors, ExchangeKind kind, const std::filesystem::path& file);
// Refuses a file that writeExchange would refuse, as checkHeatOutput.
void checkExchangeOutput(const std::filesystem::path& file, ExchangeKind kind);

// Writes `surface,area,emissivity,temperature,radiosity,irradiation,heat_flux,heat_flow`, each uncertain column
// followed by its `_standard_error`, and where rows have bounds by its `_bound`; the first column is `polygon` for rows
// by polygon.
//   In: by: HeatSolution::rows, or surfaces
//   Out: 1 + rows lines; a last line `environment` for an open scene with its heat flow, which is what leaves it;
//     two lines, `environment:up` and `environment:down`, where sky and ground are apart
//   Error: none: numbers read back to the same bits. Tests: tests/unit/solve_materials_test.cpp.
//   Throws: nothing; a failure is out's state.    Cost: O(rows).
void writeHeat(const HeatSolution& solution, By by, std::ostream& out);

// Writes the same to a file, which is whole at any time, or untouched.
//   In: file: ends in .csv; its folder exists    Error: none. Tests: tests/program/solve_program_test.cpp.
//   Throws: Error bad_usage for another extension; Error output, naming file and the system's reason.    Cost: O(rows).
void writeHeat(const HeatSolution& solution, By by, const std::filesystem::path& file);
// Refuses a file that writeHeat would refuse, before anything is computed.
//   Throws: Error bad_usage: an unknown extension, a file that cannot be written.
//   Cost: one file of a byte, written and removed.
void checkHeatOutput(const std::filesystem::path& file);

}  // namespace viewpeel

// Form factors are written to files: as text, for NumPy, HDF5 and VTK.
#pragma once
#include <filesystem>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

struct HeatSolution;

// The .csv column of balanced form factors has this name. Version 0.1 had the older one, which `--closure` keeps until
// 0.3.
constexpr const char* kBalancedColumn = "balanced_form_factor";
constexpr const char* kOlderBalancedColumn = "closed_form_factor";

// Writes form factors comma-separated: header `from,to,form_factor,standard_error`, then one nonzero entry a line, both
// ways; `environment` and `leak` stand in `to`. Numbers have the shortest form that reads back to the same double.
// Names are quoted as in RFC 4180 where they must be.
// With intervals of a guarantee `lower` and `upper` are further columns.
//   In: form_factors: n rows; balanced: BalancedFormFactors::form_factors of the same, for a further column of the name
//     balanced_column; nullptr: no such column
//   Out: 1 + (1 to 2) x nonzeros lines; form factors and standard errors without unit
//   Error: none: numbers read back to the same bits. Tests: tests/unit/output_test.cpp.
//   Throws: nothing; a failure is out's state.
//   Cost: O(nonzeros).
void writeCsv(const FormFactors& form_factors, std::ostream& out, const FormFactors* balanced = nullptr,
              const char* balanced_column = kBalancedColumn);

// Writes form factors in Matrix Market's format, coordinate real general: entry (i, j) is F_ij, rows and columns
// counted from 1. Comment lines give every row's emitting area, environment share and name. Rows are in the order of
// the file, and its empty rows are among them.
//   In: form_factors: n rows; what: for the first comment line
//   Out: an n x n matrix, without environment and leak, which are in the comments
//   Error, Throws, Cost: as writeCsv.
//   Source: R. F. Boisvert, R. Pozo & K. A. Remington, The Matrix Market exchange formats, NISTIR 5935, 1996.
void writeMatrixMarket(const FormFactors& form_factors, std::ostream& out, const char* what = "form factors");

// An OutputContent is all that a file of results may hold. Form factors alone will do for .csv, .mtx and .npz.
struct OutputContent {
  const FormFactors& form_factors;
  const FormFactors* balanced = nullptr;  // BalancedFormFactors::form_factors of these
  const Scene* scene = nullptr;           // of these form factors: the geometry of .h5, and a must for .vtp
  // Each is a name and a value, in words: attributes of .h5, where numbers become numbers. FormFactorRun::settings()
  // has options, seed and version.
  std::vector<std::pair<std::string, std::string>> parameters{};
  // Each is a surface or face, whose form factors to all polygons are an array of .vtp: "from NAME".
  std::vector<std::string> shown{};
  // The result of solveHeat with these form factors gives columns of .h5, quantities of .html and arrays of .vtp.
  const HeatSolution* heat = nullptr;
  // A .vwf names the version of CalculiX that may read it; others refuse it. Versions that do not compare take "none".
  std::string ccx_version = "2.20";
  const char* balanced_column = kBalancedColumn;  // of .csv
};

// Writes a file by its extension: .csv, .mtx, .npz, .h5, .vtp, .html, .vwf, .idf, .epJSON, .fdf, .dat or .i, or the
// files of an OpenFOAM case into its folder (docs/formats.md). A file is whole at any time, or untouched: it is written
// under another name and renamed.
//   With balanced form factors .csv has a column more, and .h5 a group more. NAME.balanced.mtx and NAME.balanced.npz
//     beside NAME.mtx and NAME.npz have them; other programs' files have nothing else, and .vtp leaves
//     them out.
//   In: content: n rows; file: its folder exists    Out: the files of filesOf
//   Error: none: numbers are the same doubles. Tests: tests/unit/output_test.cpp, tests/files/output_files_test.cpp,
//     tests/files/calculix_test.cpp, tests/program/fault_test.cpp.
//   Throws: Error bad_usage for an unknown extension, .vtp without a scene, .html where the page was not built
//     (VIEWPEEL_BUILD_REPORT), an unknown name among those shown; Error limit for a .h5 that memory cannot
//     hold; Error output, naming file and the system's reason.
//   Cost: O(nonzeros + polygons); .h5, .html and .vtp are made in memory; .vwf has 8 n^2 bytes.
void writeFormFactors(const OutputContent& content, const std::filesystem::path& file);

// Writes form factors alone, as above.    In: balanced: nullptr where there are none
void writeFormFactors(const FormFactors& form_factors, const std::filesystem::path& file,
                      const FormFactors* balanced = nullptr);

// Returns the files that writeFormFactors writes: one, or two.    Throws: as writeFormFactors for the extension.
// Cost: O(1).
std::vector<std::filesystem::path> filesOf(const std::filesystem::path& file, bool with_balance);

// Refuses a file that writeFormFactors would refuse, before anything is computed.
//   In: has_scene: whether there will be a scene in the content
//   Throws: Error bad_usage: an unknown extension, a name that --balance takes, .vtp without a scene, .html without the
//     page, a file that cannot be written.
//   Cost: one file of a byte, written and removed.
void checkOutput(const std::filesystem::path& file, bool with_balance = false, bool has_scene = true);

// Refuses rows that the file's format cannot have, before anything is computed: OpenFOAM has a row for each coarse
// face, EnergyPlus one for each surface of a building, and MOOSE names without blanks.
//   In: scene, ids: of the form factors that are to be written
//   Throws: Error bad_usage, naming what is not as it has to be.    Cost: O(rows), and reading the case.
void checkRows(const std::filesystem::path& file, const Scene& scene, const Ids& ids);

// Refuses names that no array of .vtp can have.
//   In: ids: of the scene; names: as OutputContent::shown
//   Throws: Error bad_usage for an absent surface or face, or a part of a row.    Cost: O(polygons) a name.
void checkShown(const Scene& scene, const Ids& ids, const std::vector<std::string>& names);

}  // namespace viewpeel

// writeFormFactors() writes form factors to a file: as text, for NumPy, HDF5 and VTK, and for other programs.
#pragma once
#include <filesystem>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

struct DroppedSums;
struct EnvironmentParts;
struct HeatSolution;

// This is the .csv column of balanced form factors. Version 0.1 used the older name, which `--closure` keeps until 0.3.
constexpr const char* kBalancedColumn = "balanced_form_factor";
constexpr const char* kOlderBalancedColumn = "closed_form_factor";

// Writes form factors as comma-separated values. The header is `from,to,form_factor,standard_error`. Each further line
// is one nonzero entry, F_ij and F_ji on lines of their own. `environment` and `leak` appear under `to`. Numbers have
// the shortest form that reads back to the same double. Names are quoted as in RFC 4180 where they must be. With
// intervals of a guarantee there are two more columns, `lower` and `upper`.
//   In: form_factors: of n rows; balanced: BalancedFormFactors::form_factors of the same entries, which get a column of
//     the name balanced_column; nullptr: no such column
//   Out: 1 + (1 to 2) x nonzeros lines; form factors and standard errors without unit
//   Error: none: numbers read back to the same bits. Tests: tests/unit/output_test.cpp.
//   Throws: nothing; a failure to write is the state of `out`.
//   Cost: O(nonzeros).
void writeCsv(const FormFactors& form_factors, std::ostream& out, const FormFactors* balanced = nullptr,
              const char* balanced_column = kBalancedColumn);

// Writes form factors in the format of Matrix Market, coordinate real general: entry (i, j) is F_ij, and rows and
// columns are counted from 1. Comment lines give the emitting area, environment share and name of every row. Rows are
// in the order of the file, with its empty rows.
//   In: form_factors: of n rows; what: text of the first comment line
//   Out: an n x n matrix, without environment and leak
//   Error, Throws, Cost: as writeCsv.
//   Source: R. F. Boisvert, R. Pozo & K. A. Remington, The Matrix Market exchange formats, NISTIR 5935, 1996.
void writeMatrixMarket(const FormFactors& form_factors, std::ostream& out, const char* what = "form factors");

// An OutputContent holds what a file of results may contain. Most formats need only the form factors.
struct OutputContent {
  const FormFactors& form_factors;
  const FormFactors* balanced = nullptr;  // BalancedFormFactors::form_factors of the same entries
  const Scene* scene = nullptr;           // the scene: .h5 and .html store its geometry, and .vtp cannot do without
  // Each is a name and a value as text, and becomes an attribute of .h5. There, text that is a number becomes a number.
  // parametersOf() makes these from a run.
  std::vector<std::pair<std::string, std::string>> parameters{};
  // Each is the name of a surface or face. A .vtp gets an array "from NAME" of its form factors to all polygons.
  std::vector<std::string> shown{};
  // The result of solveHeat() with these form factors adds columns to .h5, quantities to .html and arrays to .vtp.
  const HeatSolution* heat = nullptr;
  // A .vwf names the version of CalculiX that may read it, and other versions refuse the file. "none" leaves the
  // version out, for old versions of CalculiX, which know no such record.
  std::string ccx_version = "2.20";
  const char* balanced_column = kBalancedColumn;  // column of .csv for `balanced`
  // Entries of these pairs (i, j), i < j, ascending, are guesses, and files mark them. May be nullptr.
  const std::vector<std::pair<uint32_t, uint32_t>>* guesses = nullptr;
  const DroppedSums* dropped = nullptr;  // what dropBelow() left out of the form factors
  // Where sky and ground are apart, .csv gets the entries `environment:up` and `environment:down`, .rows.csv, .h5,
  // .json and .vtp columns. May be nullptr.
  const EnvironmentParts* parts = nullptr;
  // The form factors come from environmentAlone(): files have no matrix, leak nor row sums. Formats are .csv,
  // .rows.csv, .h5, .json and .vtp.
  bool has_environment_alone = false;
  // The heat comes from solveMatrixFree(): form_factors has rows, but no entries. The format is .vtp.
  bool has_heat_alone = false;
};

// Writes a file by its extension: .csv, .mtx, .npz, .h5, .json, .vtp, .html, .vwf, .idf, .epJSON, .fdf, .dat or .i
// (docs/formats.md). Into the folder of an OpenFOAM case it writes the files of the case. The file is written under
// another name and then renamed, so no reader ever sees a part of it.
//   NAME.rows.csv has a line for each row: area, environment, leak, row sum and errors. NAME.errors.mtx and
//     NAME.errors.npz have the standard errors.
//   With balanced form factors a .csv has one more column, and a .h5 one more group. NAME.mtx and NAME.npz get a second
//     file, NAME.balanced.mtx or NAME.balanced.npz. Files for other programs have only the balanced form factors. A
//     .vtp leaves them out.
//   In: content: of n rows; file: a path whose folder exists    Out: the files that filesOf() names
//   Error: none: numbers are the same doubles. Tests: tests/unit/output_test.cpp, tests/files/output_files_test.cpp,
//     tests/files/calculix_test.cpp, tests/program/fault_test.cpp.
//   Throws: Error bad_usage for an unknown extension, for .vtp without a scene, and for .html where the page was not
//     built (VIEWPEEL_BUILD_REPORT). The same for the environment alone in a format that is all matrix, and for an
//     unknown name in content.shown; Error limit for a .h5 that does not fit into memory; Error output, naming the
//     file and the system's reason.
//   Cost: O(nonzeros + polygons). .html and .vtp are made in memory, and so is all of .h5 but its
//     matrices; .vwf has 8 n^2 bytes.
void writeFormFactors(const OutputContent& content, const std::filesystem::path& file);

// Writes the content of a file with this ending to a stream.
//   In: format: csv, rows.csv, mtx, errors.mtx, npz, errors.npz, h5, json or vtp
//   Throws: as above; a failure to write is the state of `out`.
void writeFormFactors(const OutputContent& content, std::ostream& out, const std::string& format);

// Writes form factors without any other content.    In: balanced: balanced form factors, or nullptr
void writeFormFactors(const FormFactors& form_factors, const std::filesystem::path& file,
                      const FormFactors* balanced = nullptr);

// Returns the one or two files that writeFormFactors() writes.    Throws: as writeFormFactors() for the extension.
// Cost: O(1).
std::vector<std::filesystem::path> filesOf(const std::filesystem::path& file, bool with_balance);

// Refuses a file that writeFormFactors() would refuse. Callers use it before anything is computed.
//   In: has_scene: whether the content will have a scene
//   Throws: Error bad_usage for an unknown extension, for a name that the balanced form factors take, and for a file
//     that cannot be written. The same for .vtp without a scene, and for .html where the page was not built.
//   Cost: a small file is written and removed.
void checkOutput(const std::filesystem::path& file, bool with_balance = false, bool has_scene = true);

// Refuses a file whose format cannot hold the environment alone (OutputContent::has_environment_alone).
//   Throws: Error bad_usage.    Cost: O(1).
void checkEnvironmentOutput(const std::filesystem::path& file);

// Refuses rows that the file's format cannot store. Callers use it before anything is computed. OpenFOAM needs a row
// for each coarse face, EnergyPlus one for each surface of a building, and MOOSE names without blanks.
//   In: scene, ids: of the form factors that will be written
//   Throws: Error bad_usage, naming the row or setting that does not fit.    Cost: O(rows), and reading the case.
void checkRows(const std::filesystem::path& file, const Scene& scene, const Ids& ids);

// Refuses names for OutputContent::shown that no row has.
//   In: ids: of the scene; names: as OutputContent::shown
//   Throws: Error bad_usage for an absent surface or face, or a part of a row.    Cost: O(polygons) for each name.
void checkShown(const Scene& scene, const Ids& ids, const std::vector<std::string>& names);

}  // namespace viewpeel

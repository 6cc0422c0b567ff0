// StoredRows hold the rows of the matrix of form factors, as a .h5 file of results has them (layout: write_hdf5.cpp).
// Readers refuse columns of different lengths, and values that are not numbers.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/hdf5_input.h"
#include "report/report_content.h"

namespace viewpeel {

constexpr int64_t kResultFormat = 1;  // attribute viewpeel_result_format of all files that are written and read

// StoredRows are names, areas and compressed rows. The entries of row i are from starts[i] to starts[i + 1] - 1.
struct StoredRows {
  std::vector<std::string> names;
  std::vector<double> areas;                                    // emitting areas, input units squared; 0: an empty row
  std::vector<int64_t> starts;                                  // rows + 1
  std::vector<int32_t> columns;                                 // of each entry; ascending within a row
  std::vector<std::pair<std::string, std::string>> attributes;  // of the file, as texts
  bool has_intervals = false;                                   // whether it has lower_bounds and upper_bounds

  size_t count() const { return names.size(); }
  size_t entryCount() const { return columns.size(); }
  // Returns an attribute of the file; empty where there is none.
  std::string attribute(const std::string& name) const;
};

// Opens a file, or bytes that messages call by this name.    Throws: Error bad_input, as Hdf5Input.
Hdf5Input openResult(const std::filesystem::path& file);
Hdf5Input openResult(const std::vector<char>& bytes, const std::string& name);

// Reads the rows.    Throws: Error bad_input where it is another file, or rows and columns do not make a matrix.
//   Cost: O(entries).
StoredRows readStoredRows(Hdf5Input& in);

// Reads a column of numbers, finite or infinite.    In: count: as Hdf5Input::read    Throws: Error bad_input.
std::vector<double> readNumbers(Hdf5Input& in, const std::string& name, std::optional<size_t> count = {});
// Reads a column of whole numbers from 0 to end - 1.
std::vector<int32_t> readIndices(Hdf5Input& in, const std::string& name, std::optional<size_t> count, size_t end);

// Reads the geometry; it is empty where the file has none.    In: row_count: number of rows that polygons may name
ReportGeometry readGeometry(Hdf5Input& in, size_t row_count);

}  // namespace viewpeel

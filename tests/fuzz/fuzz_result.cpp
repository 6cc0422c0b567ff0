// This target reads a .h5 of results whose columns may hold wrong values, with a right check sum.
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include <viewpeel/error.h>
#include <viewpeel/read.h>
#include <viewpeel/write.h>
#include "column_bytes.h"
#include "input_file.h"
#include "io/read_report.h"
#include "report/shrink_content.h"
#include "report/survey_content.h"

namespace viewpeel {
namespace {

using fuzz::writeColumn;
using Doubles = std::vector<double>;
using Numbers = std::vector<int32_t>;

void writeTexts(Hdf5Output& out, fuzz::Bytes& bytes, const std::string& name, const std::vector<std::string>& whole) {
  switch (bytes.take<uint8_t>() % 3) {
    case 0:
      return out.writeTexts(name, whole);
    case 1:
      return out.writeTexts(name, bytes.takeTexts());
    default:
      return writeColumn(out, bytes, name, whole);  // one length for all columns, which no result has
  }
}

template <class T>
void setAttribute(Hdf5Output& out, fuzz::Bytes& bytes, const std::string& name, const T& whole) {
  switch (bytes.take<uint8_t>() % 5) {
    case 0:
      return out.setAttribute("/", name, whole);
    case 1:
      return out.setAttribute("/", name, std::string(bytes.take<uint8_t>() % 16, bytes.take<char>()));
    case 2:
      return out.setAttribute("/", name, bytes.take<double>());
    case 3:
      return out.setAttribute("/", name, bytes.take<int64_t>());
    default:
      return;  // the column is missing
  }
}

// Writes matrices of three rows in compressed rows; the second row is empty.
void writeMatrices(Hdf5Output& out, fuzz::Bytes& bytes, bool has_intervals, bool is_balanced) {
  writeColumn(out, bytes, "form_factors/indptr", std::vector<int64_t>{0, 2, 2, 3});
  writeColumn(out, bytes, "form_factors/indices", Numbers{0, 2, 0});
  writeColumn(out, bytes, "form_factors/data", Doubles{0.1, 0.5, 0.25});
  writeColumn(out, bytes, "standard_errors/data", Doubles{0, 1e-3, 5e-4});
  if (has_intervals) writeColumn(out, bytes, "lower_bounds/data", Doubles{0.1, 0.4, 0.2});
  if (has_intervals) writeColumn(out, bytes, "upper_bounds/data", Doubles{0.1, 0.6, 0.3});
  if (is_balanced) writeColumn(out, bytes, "balanced_form_factors/data", Doubles{0.1, 0.9, 0.45});
}

void writeRows(Hdf5Output& out, fuzz::Bytes& bytes, bool has_intervals) {
  writeTexts(out, bytes, "name", {"desk[1]", "desk[2]", "wall"});
  writeColumn(out, bytes, "area", Doubles{1, 0, 2});
  writeColumn(out, bytes, "is_requested", std::vector<uint8_t>{1, 1, 1});
  std::vector<std::string> names = {"environment", "environment_standard_error", "leak",       "leak_standard_error",
                                    "row_sum",     "row_sum_standard_error",     "temperature"};
  if (has_intervals) names.insert(names.end(), {"environment_lower", "environment_upper", "leak_lower", "leak_upper"});
  for (const std::string& name : names) writeColumn(out, bytes, name, Doubles{0.3, 0, 0.7});
}

// Writes the geometry: the first face of the desk is a triangle, the wall a quadrilateral.
void writeGeometry(Hdf5Output& out, fuzz::Bytes& bytes) {
  for (const char* name : {"geometry/x", "geometry/y", "geometry/z"})
    writeColumn(out, bytes, name, Doubles{0, 1, 2, 3, 4, 5, 6});
  writeColumn(out, bytes, "geometry/polygon_area", Doubles{1, 2});
  writeColumn(out, bytes, "geometry/first_corner", Numbers{0, 3});
  writeColumn(out, bytes, "geometry/corner_count", Numbers{3, 4});
  writeColumn(out, bytes, "geometry/row_of_polygon", Numbers{0, 2});
  writeColumn(out, bytes, "geometry/surface_of_polygon", Numbers{0, 1});
  writeTexts(out, bytes, "geometry/surface_name", {"desk", "wall"});
}

std::vector<char> fileOf(const uint8_t* data, size_t count) {
  fuzz::Bytes bytes(data, count);
  Hdf5Output out;
  const uint8_t parts = bytes.take<uint8_t>();  // 0: all parts
  const bool has_intervals = !(parts & 1), is_balanced = !(parts & 2), has_geometry = !(parts & 4);
  writeMatrices(out, bytes, has_intervals, is_balanced);
  writeRows(out, bytes, has_intervals);
  if (has_geometry) writeGeometry(out, bytes);
  setAttribute(out, bytes, "viewpeel_result_format", int64_t{1});
  setAttribute(out, bytes, "unlisted_bound", 0.01);
  setAttribute(out, bytes, "two-sided", std::string("no"));
  setAttribute(out, bytes, "closure_largest", 0.0);
  return out.finish();
}

// Uses a result as programs do: writes it again, and makes a page of it.
void use(const std::filesystem::path& file) {
  const StoredResult stored = readResult(file);
  std::ostringstream text;
  writeCsv(stored.form_factors, text, stored.balanced ? &*stored.balanced : nullptr);
  writeMatrixMarket(stored.form_factors, text);
}
void usePage(const std::filesystem::path& file) {
  ReportContent content = readReport(file);
  surveyErrors(statedErrors(content));
  const std::vector<int64_t> largest = largestEntries(content.form_factors, 2);
  rowsOfEntries(content, largest);
  pictureOf(content, ranksByPlace(content), 4);
  if (!content.geometry.isEmpty()) addUpBySurface(content);
  leaveOutSmall(content, 4, 64);
}

template <class Use>
void requireRefusal(Use use_of, const std::filesystem::path& file) {
  try {
    use_of(file);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::bad_input) std::abort();
    fuzz::requireOneLine(error.what());
  }
}

}  // namespace
}  // namespace viewpeel

// Empty input must give a valid file. Otherwise all inputs would be refused, and the target would test nothing.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const viewpeel::fuzz::NamedFile file("whole_result");
  try {
    viewpeel::use(file.write(viewpeel::fileOf(nullptr, 0)));
    viewpeel::usePage(file.write(viewpeel::fileOf(nullptr, 0)));
    return 0;
  } catch (const viewpeel::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  std::abort();
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t count) {
  static const viewpeel::fuzz::NamedFile file("result");
  const std::filesystem::path& path = file.write(viewpeel::fileOf(data, count));
  viewpeel::requireRefusal(viewpeel::use, path);
  viewpeel::requireRefusal(viewpeel::usePage, path);
  return 0;
}

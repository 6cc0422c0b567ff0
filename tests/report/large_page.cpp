// This program writes large results: 20,000 polygons on a wavy field, 40 surfaces of 500, some hundred form factors a
// row.
//   viewpeel_large_page PAGE.html ROW.csv               4.2 million form factors, as many as pages are meant to have
//   viewpeel_large_page by-surface RESULT.h5 SUMS.csv   6.8 million, too many for a page, which shows surfaces instead
//   viewpeel_large_page by-size RESULT.h5 ROW.csv       as many, each row a surface of its own
// The values are invented, with A_i F_ij = A_j F_ji, for the page shows any values. The .csv has the entries of one
// row, or the form factors between surfaces, computed here by their definition, with intervals.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <map>
#include <string_view>

#include <fmt/ostream.h>

#include "io/hdf5_output.h"
#include "report/write_page.h"

namespace {

using viewpeel::ReportContent;

constexpr int kAcross = 100, kDown = 200, kRows = kAcross * kDown, kRowsOfSurface = 500;
constexpr int kShownRow = 12345;

// Returns a number in [0, 1) that is the same for (i, j) and (j, i).
double scatter(int i, int j) {
  const auto a = static_cast<uint64_t>(std::min(i, j)), b = static_cast<uint64_t>(std::max(i, j));
  const uint64_t mixed = (a * 0x9E3779B97F4A7C15u ^ b * 0xC2B2AE3D27D4EB4Fu) * 0x165667B19E3779F9u;
  return static_cast<double>(mixed >> 11) * 0x1p-53;
}

double areaOf(int row) { return 1 + 0.5 * scatter(row, 3 * row); }

// A Reach is the distance in rows up to which a row sees others, on either side.
struct Reach {
  int neighbours;
  bool is_dense;  // else at growing distances

  int distance(int neighbour) const {
    return is_dense || neighbour < 70 ? neighbour + 1 : 70 + (neighbour - 69) * (neighbour - 69) * 6;
  }
};

void addRow(ReportContent& content, int row, const Reach& reach, bool has_intervals) {
  const auto add = [&](int to) {
    if (to < 0 || to >= kRows) return;
    const double form_factor = 0.004 / (1 + 0.05 * std::abs(to - row)) * (0.2 + scatter(row, to)) / areaOf(row);
    content.to.push_back(to);
    content.form_factors.push_back(form_factor);
    content.standard_errors.push_back(form_factor * 1e-3 * scatter(row + kRows, to + kRows));
    if (!has_intervals) return;
    content.lower.push_back(form_factor * (1 - 0.01 * scatter(row, to)));
    content.upper.push_back(form_factor * 1.02);
  };
  for (int k = reach.neighbours - 1; k >= 0; --k) add(row - reach.distance(k));
  for (int k = 0; k < reach.neighbours; ++k) add(row + reach.distance(k));
  content.starts.push_back(static_cast<int64_t>(content.to.size()));
}

void addPolygon(ReportContent& content, int row, int rows_of_surface) {
  viewpeel::ReportGeometry& geometry = content.geometry;
  geometry.first_corner.push_back(static_cast<int32_t>(geometry.x.size()));
  geometry.corner_count.push_back(4);
  geometry.row_of_polygon.push_back(row);
  geometry.surface_of_polygon.push_back(row / rows_of_surface);
  geometry.polygon_area.push_back(areaOf(row));
  const int left = row % kAcross, near = row / kAcross;
  for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
    geometry.x.push_back(left + x);
    geometry.y.push_back(near + y);
    geometry.z.push_back(8 * std::sin(0.1 * (left + x)) * std::cos(0.07 * (near + y)));
  }
}

ReportContent makeContent(const Reach& reach, int rows_of_surface, bool has_intervals) {
  ReportContent content;
  content.starts.push_back(0);
  std::vector<double> environment;
  for (int row = 0; row < kRows; ++row) {
    content.names.push_back(fmt::format("field_{}[{}]", row / kRowsOfSurface, row % kRowsOfSurface + 1));
    content.areas.push_back(areaOf(row));
    addRow(content, row, reach, has_intervals);
    addPolygon(content, row, rows_of_surface);
    double sum = 0;
    for (int64_t k = content.starts[row]; k < content.starts[row + 1]; ++k) sum += content.form_factors[k];
    environment.push_back(1 - sum);
  }
  for (int surface = 0; surface < kRows / rows_of_surface; ++surface)
    content.geometry.surface_names.push_back(rows_of_surface == 1 ? content.names[surface]
                                                                  : fmt::format("field_{}", surface));
  content.columns.push_back({"environment", "1", environment});
  content.columns.push_back({"row_sum", "1", std::vector<double>(kRows, 1.0)});
  return content;
}

void writeResult(const ReportContent& content, const char* file) {
  viewpeel::Hdf5Output out;
  out.writeTexts("name", content.names);
  out.write("area", content.areas);
  for (const auto& column : content.columns) out.write(column.name, column.values);
  out.write("form_factors/data", content.form_factors);
  out.write("form_factors/indices", content.to);
  out.write("form_factors/indptr", content.starts);
  out.write("standard_errors/data", content.standard_errors);
  if (content.hasIntervals())
    out.write("lower_bounds/data", content.lower), out.write("upper_bounds/data", content.upper);
  const viewpeel::ReportGeometry& geometry = content.geometry;
  out.write("geometry/x", geometry.x), out.write("geometry/y", geometry.y), out.write("geometry/z", geometry.z);
  out.write("geometry/first_corner", geometry.first_corner), out.write("geometry/corner_count", geometry.corner_count);
  out.write("geometry/row_of_polygon", geometry.row_of_polygon);
  out.write("geometry/surface_of_polygon", geometry.surface_of_polygon);
  out.write("geometry/polygon_area", geometry.polygon_area);
  out.writeTexts("geometry/surface_name", geometry.surface_names);
  out.write("is_requested", std::vector<uint8_t>(content.names.size(), 1));
  out.setAttribute("/", "viewpeel_result_format", int64_t{1});  // as in write_hdf5.cpp
  out.setAttribute("/", "unlisted_bound", 0.0);
  const std::vector<char> bytes = out.finish();
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void writeRow(const ReportContent& content, const char* file) {
  std::ofstream out(file);
  for (int64_t k = content.starts[kShownRow]; k < content.starts[kShownRow + 1]; ++k)
    fmt::print(out, "{},{},{},{}\n", content.names[kShownRow], content.names[content.to[k]], content.form_factors[k],
               content.standard_errors[k]);
}

// Writes F_IJ = sum over i in I, j in J of A_i F_ij / A_I. Errors and bounds are summed in the same way.
void writeSums(const ReportContent& content, const char* file) {
  std::vector<double> areas(kRows / kRowsOfSurface, 0.0);
  for (int row = 0; row < kRows; ++row) areas[row / kRowsOfSurface] += content.areas[row];
  std::map<std::pair<int, int>, std::array<double, 4>> sums;
  for (int row = 0; row < kRows; ++row)
    for (int64_t k = content.starts[row]; k < content.starts[row + 1]; ++k) {
      auto& sum = sums[{row / kRowsOfSurface, content.to[k] / kRowsOfSurface}];
      sum[0] += content.areas[row] * content.form_factors[k];
      sum[1] += content.areas[row] * content.standard_errors[k];
      sum[2] += content.areas[row] * content.lower[k];
      sum[3] += content.areas[row] * content.upper[k];
    }
  std::ofstream out(file);
  for (const auto& [pair, sum] : sums) {
    fmt::print(out, "field_{},field_{}", pair.first, pair.second);
    for (double value : sum) fmt::print(out, ",{}", value / areas[pair.first]);
    fmt::print(out, "\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) return 2;
  if (argc == 3) {
    ReportContent content = makeContent({114, false}, kRowsOfSurface, false);
    writeRow(content, argv[2]);
    fmt::print("{} form factors of {} polygons\n", content.to.size(), kRows);
    std::ofstream page(argv[1], std::ios::binary);
    viewpeel::writePage(std::move(content), page);
    return page.flush() ? 0 : 1;
  }
  const bool by_surface = std::string_view(argv[1]) == "by-surface";
  const ReportContent content = makeContent({170, true}, by_surface ? kRowsOfSurface : 1, by_surface);
  writeResult(content, argv[2]);
  by_surface ? writeSums(content, argv[3]) : writeRow(content, argv[3]);
  fmt::print("{}\n", content.to.size());
  return 0;
}

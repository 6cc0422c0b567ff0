// Writes a page of 20,000 polygons and 4 million form factors, as large as pages are meant to be, and one row of it.
//   viewpeel_large_page PAGE.html ROW.csv
// The values are made up, for the page shows any. All areas are equal, so form factors are symmetric.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>

#include <fmt/ostream.h>

#include "report/write_page.h"

namespace {

using viewpeel::ReportContent;

constexpr int kAcross = 100, kDown = 200, kRows = kAcross * kDown;
constexpr int kNeighbours = 110;  // on either side of a row, at growing distances
constexpr int kShownRow = 12345;

// Returns a number in [0, 1) that is the same for (i, j) and (j, i).
double scatter(int i, int j) {
  const auto a = static_cast<uint64_t>(std::min(i, j)), b = static_cast<uint64_t>(std::max(i, j));
  const uint64_t mixed = (a * 0x9E3779B97F4A7C15u ^ b * 0xC2B2AE3D27D4EB4Fu) * 0x165667B19E3779F9u;
  return static_cast<double>(mixed >> 11) * 0x1p-53;
}

int distanceOf(int neighbour) { return neighbour < 60 ? neighbour + 1 : 60 + (neighbour - 59) * (neighbour - 59) * 6; }

void addRow(ReportContent& content, int row) {
  const auto add = [&](int to) {
    if (to < 0 || to >= kRows) return;
    const double form_factor = 0.004 / (1 + 0.05 * std::abs(to - row)) * (0.2 + scatter(row, to));
    content.to.push_back(to);
    content.form_factors.push_back(form_factor);
    content.standard_errors.push_back(form_factor * 1e-3 * scatter(row + kRows, to + kRows));
  };
  for (int k = kNeighbours - 1; k >= 0; --k) add(row - distanceOf(k));
  for (int k = 0; k < kNeighbours; ++k) add(row + distanceOf(k));
  content.starts.push_back(static_cast<int64_t>(content.to.size()));
}

void addPolygon(ReportContent& content, int row) {
  viewpeel::ReportGeometry& geometry = content.geometry;
  geometry.first_corner.push_back(static_cast<int32_t>(geometry.x.size()));
  geometry.corner_count.push_back(4);
  geometry.row_of_polygon.push_back(row);
  geometry.surface_of_polygon.push_back(row / 500);
  geometry.polygon_area.push_back(1);
  const int left = row % kAcross, near = row / kAcross;
  for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
    geometry.x.push_back(left + x);
    geometry.y.push_back(near + y);
    geometry.z.push_back(8 * std::sin(0.1 * (left + x)) * std::cos(0.07 * (near + y)));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  ReportContent content;
  content.starts.push_back(0);
  std::vector<double> sums;
  for (int row = 0; row < kRows; ++row) {
    content.names.push_back(fmt::format("field_{}[{}]", row / 500, row % 500 + 1));
    content.areas.push_back(1);
    addRow(content, row);
    addPolygon(content, row);
    double sum = 0;
    for (int64_t k = content.starts[row]; k < content.starts[row + 1]; ++k) sum += content.form_factors[k];
    sums.push_back(1 - sum);
  }
  for (int surface = 0; surface < kRows / 500; ++surface)
    content.geometry.surface_names.push_back(fmt::format("field_{}", surface));
  content.columns.push_back({"environment", "1", sums});
  content.columns.push_back({"row_sum", "1", std::vector<double>(kRows, 1.0)});

  std::ofstream row(argv[2]);
  for (int64_t k = content.starts[kShownRow]; k < content.starts[kShownRow + 1]; ++k)
    fmt::print(row, "{},{},{},{}\n", content.names[kShownRow], content.names[content.to[k]], content.form_factors[k],
               content.standard_errors[k]);
  fmt::print("{} form factors of {} polygons\n", content.to.size(), kRows);
  std::ofstream page(argv[1], std::ios::binary);
  viewpeel::writePage(std::move(content), page);
  return page.flush() && row.flush() ? 0 : 1;
}

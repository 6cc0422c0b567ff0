// A ReportContent is what a page of a result shows: the data of a .h5, with a value for each row in every column.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace viewpeel {

// A ReportColumn has a value for each row, for example its environment or its temperature.
struct ReportColumn {
  std::string name, unit;  // as in the .h5
  std::vector<double> values;
};

// The polygons of ReportGeometry are the triangles and quadrilaterals that were computed.
struct ReportGeometry {
  std::vector<double> x, y, z;                              // of corners, input units
  std::vector<int32_t> first_corner, corner_count;          // of polygons
  std::vector<int32_t> row_of_polygon, surface_of_polygon;  // indices into ReportContent::names and surface_names
  std::vector<double> polygon_area;                         // input units squared
  std::vector<std::string> surface_names;

  bool isEmpty() const { return first_corner.empty(); }
};

struct ReportContent {
  std::vector<std::string> names;  // of rows
  std::vector<double> areas;       // emitting, input units squared
  std::vector<ReportColumn> columns;
  // Rows are compressed: the entries of row i are from starts[i] to starts[i + 1] - 1, and `to` has their columns,
  // ascending.
  std::vector<int64_t> starts;
  std::vector<int32_t> to;
  std::vector<double> form_factors, standard_errors;
  std::vector<double> lower, upper;  // of a guarantee; else empty
  ReportGeometry geometry;           // empty where the file has none
  std::vector<std::pair<std::string, std::string>> parameters;
  // Each note is a sentence about something that the page does not show as the file has it.
  std::vector<std::string> notes;
  bool is_bounded = false;  // whether standard errors are upper bounds: sums over the rows of a surface

  int64_t rowCount() const { return static_cast<int64_t>(names.size()); }
  int64_t entryCount() const { return static_cast<int64_t>(to.size()); }
  bool hasIntervals() const { return !lower.empty(); }
};

}  // namespace viewpeel

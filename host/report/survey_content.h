// A survey of a result is what a page shows of all its form factors at once.
#pragma once
#include "report/report_content.h"

namespace viewpeel {

struct ReportSurvey {
  // Entries with an error above 0, by its logarithm to the base 10: bin k is from first + k step.
  double first = 0, step = 0.25;
  std::vector<double> error_bins;
  double without_error = 0;  // entries with an error of 0
  double largest_error = 0, rms_error = 0;
};

// Returns what is stated about the error of each entry: with intervals its error bound, the distance to the farther
// end, else its standard error.
//   Cost: O(entries).
std::vector<double> statedErrors(const ReportContent& content);

// In: errors: of all entries    Cost: O(entries).
ReportSurvey surveyErrors(const std::vector<double>& errors);

// Returns the indices of the entries that come first, by a value of each, the largest first.
//   Cost: O(entries).
std::vector<int64_t> largestEntries(const std::vector<double>& values, size_t count);

// Returns the row of each entry in a list.    Cost: O(entries listed x log rows).
std::vector<int32_t> rowsOfEntries(const ReportContent& content, const std::vector<int64_t>& entries);

// Returns an order of rows in which neighbours are near each other: along a Z curve through their middles.
//   Out: the rank of each row; that of rows without polygons is after all others
//   Source: G. M. Morton, A computer oriented geodetic data base, IBM 1966.    Cost: O(polygons + rows log rows).
std::vector<int32_t> ranksByPlace(const ReportContent& content);

// Returns a picture of the matrix, size x size, by row and column: each cell has the largest form factor in it.
//   In: ranks: place of each row in the picture    Cost: O(entries + size^2).
std::vector<float> pictureOf(const ReportContent& content, const std::vector<int32_t>& ranks, size_t size);

}  // namespace viewpeel

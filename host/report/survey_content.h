// A survey summarises the errors and form factors of a whole result for the page.
#pragma once
#include "report/report_content.h"

namespace viewpeel {

struct ReportSurvey {
  // The histogram counts entries with an error above 0 by the log10 of the error: bin k begins at first + k step.
  double first = 0, step = 0.25;
  std::vector<double> error_bins;
  double without_error = 0;  // number of entries with an error of 0
  double largest_error = 0, rms_error = 0;
};

// Returns the stated error of each entry: with intervals the distance from the value to the interval's farther end,
// else the standard error.
//   Cost: O(entries).
std::vector<double> statedErrors(const ReportContent& content);

// Summarises the errors of all entries.    Cost: O(entries).
ReportSurvey surveyErrors(const std::vector<double>& errors);

// Returns the indices of `count` entries with the largest values, the largest first.
//   Cost: O(entries).
std::vector<int64_t> largestEntries(const std::vector<double>& values, size_t count);

// Returns the row of each of these entries.    Cost: O(entries listed x log rows).
std::vector<int32_t> rowsOfEntries(const ReportContent& content, const std::vector<int64_t>& entries);

// Returns an order of rows in which near rows follow each other, along a Z curve through their middles.
//   Out: the rank of each row; rows without polygons come last
//   Source: G. M. Morton, A computer oriented geodetic data base, IBM 1966.    Cost: O(polygons + rows log rows).
std::vector<int32_t> ranksByPlace(const ReportContent& content);

// Returns a picture of the matrix, size x size pixels: each pixel is the largest form factor of its rows and columns.
//   In: ranks: place of each row in the picture    Cost: O(entries + size^2).
std::vector<float> pictureOf(const ReportContent& content, const std::vector<int32_t>& ranks, size_t size);

}  // namespace viewpeel

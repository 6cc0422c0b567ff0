// A page has a largest size. A result that is larger is shown by surface or without its smallest entries, with a note.
#pragma once
#include "report/report_content.h"

namespace viewpeel {

// Returns the most bytes that form factors and their errors take on a page, packed as base64.
//   In: width: bytes of a value, 4 or 8    Cost: O(entries).
size_t pageBytesOfEntries(const ReportContent& content, size_t width);

// Returns the bound of a guarantee on form factors without an entry; 0 where the result has no guarantee.
double unlistedBound(const ReportContent& content);

// Adds up rows by surface: F_IJ = sum over i in I, j in J of A_i F_ij / A_I.
//   In: content: with a geometry    Out: a row for each surface that has rows, and a note
//   Error: standard errors become sums of standard errors, which are upper bounds however the errors correlate.
//   Intervals are left out where pairs without an entry may have form factors above 0. Shares of rows become means over
//   the area. Temperatures are left out, for their means say little.
//   Cost: O(entries + surfaces^2).
ReportContent addUpBySurface(const ReportContent& content);

// Keeps as many of the largest form factors as fit, and notes the number of others and their largest sum in a row.
//   In: largest_bytes: as pageBytesOfEntries counts them    Cost: O(entries).
void leaveOutSmall(ReportContent& content, size_t width, size_t largest_bytes);

}  // namespace viewpeel

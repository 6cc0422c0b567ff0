// A page is one file of HTML that shows a result in a browser, without a network.
#pragma once
#include <ostream>

#include "report/report_content.h"

namespace viewpeel {

// Returns whether the page was built into the library (VIEWPEEL_BUILD_REPORT).
bool hasPage();

// Refuses a page where it was not built into the library.    Throws: Error bad_usage, naming the file.
void requirePage(const std::string& file);

// Writes a page of at most 60,000,000 bytes.
//   Form factors are doubles where they take up to 20,000,000 bytes, else floats (intervals rounded outwards). A result
//   that is still too large is shown by surface, or without its smallest form factors. Polygons beyond 30,000,000 bytes
//   are left out. Notes on the page say so.
//   In: content: n rows
//   Out: HTML; no text of the content is markup or script: all of it is packed as base64
//   Error: floats are within 6e-8 of their doubles, relatively. Tests: tests/report.
//   Throws: Error limit where names alone take too much.
//   Cost: O(entries) time and memory: the page is built in memory.
void writePage(ReportContent content, std::ostream& out);

}  // namespace viewpeel

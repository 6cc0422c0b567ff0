// These functions read and quote fields of comma-separated files, as in RFC 4180.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace viewpeel {

// Returns a name as a field of CSV, in quotes where it has commas, quotes or line breaks.
std::string quoteName(const std::string& name);

// Splits a line without line breaks into its fields. Blanks around a field without quotes are left out.
//   Out: false where a quote has no end, or text follows it
bool splitLine(std::string_view line, std::vector<std::string>& fields);

}  // namespace viewpeel

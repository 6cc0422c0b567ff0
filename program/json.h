// With --json a subcommand prints one JSON object on standard output, whatever happens; it is valid UTF-8.
#pragma once
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <viewpeel/write.h>

#include "program/outputs.h"

namespace viewpeel::program {

using Json = nlohmann::ordered_json;

// Begins the object: version, command, command_line and options.
Json startReport();

// Returns the files, each with whether it replaces another one.
Json jsonOf(const std::vector<PlannedFile>& files);
// Returns names and values in words as an object; numbers become numbers.
Json jsonOf(const std::vector<std::pair<std::string, std::string>>& settings);

// Ends the object with the warnings up to now, and prints it. A byte that is not UTF-8 becomes U+FFFD.
void printReport(Json report);
// The same, with rows and form factors at its end (docs/formats.md).
void printReport(Json report, const OutputContent& content);

}  // namespace viewpeel::program

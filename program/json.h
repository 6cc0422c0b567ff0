// With --json a subcommand always prints one JSON object on standard output, errors included, in valid UTF-8.
#pragma once
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <viewpeel/write.h>

#include "program/outputs.h"

namespace viewpeel::program {

using Json = nlohmann::ordered_json;

// Begins the object with version, command, command_line and options.
Json startReport();

// Returns the files as JSON, each with whether it replaces an existing file.
Json jsonOf(const std::vector<PlannedFile>& files);
// Returns names and values as an object. Texts that are numbers become numbers.
Json jsonOf(const std::vector<std::pair<std::string, std::string>>& settings);

// Adds the warnings so far and prints the object. A byte that is not UTF-8 becomes U+FFFD.
void printReport(Json report);
// Prints the object like the function above, with rows and form factors at its end (docs/formats.md).
void printReport(Json report, const OutputContent& content);

}  // namespace viewpeel::program

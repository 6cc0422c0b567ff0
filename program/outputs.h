// The options -o and --checkpoint name these files.
#pragma once
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <viewpeel/compute.h>
#include <viewpeel/write.h>

namespace viewpeel::program {

// Adds -o, --show and --ccx-version.
void addOutputOptions(CLI::App* command, std::vector<std::string>& outputs, std::vector<std::string>& shown,
                      std::string& ccx_version);

// That every file can be written, and none over another: before anything is computed.
//   In: checkpoint: empty where there is none; has_scene: of the content
//   Throws: Error bad_usage.
void checkOutputs(const std::vector<std::string>& outputs, const std::string& checkpoint, bool with_balance = false,
                  bool has_scene = true);

// A PlannedFile is to be written at the end of a run; at its start it may be there.
struct PlannedFile {
  std::string name;
  bool replaces;
};
// Looks which files are there before the run.
std::vector<PlannedFile> planFiles(const std::vector<std::string>& names);
// Says of each file that it is written, or replaced; a line each.
std::string describeWritten(const std::vector<PlannedFile>& files);

// Writes all of them, also where one fails.
//   Throws: the first error of all files.
void writeOutputs(const OutputContent& content, const std::vector<std::string>& outputs);

// Adds the command that made a result, and its goal: tolerance or epsilon.
void addOrigin(const Request& request, std::vector<std::pair<std::string, std::string>>& parameters);

}  // namespace viewpeel::program

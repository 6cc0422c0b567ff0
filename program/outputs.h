// The options -o and --checkpoint name these files.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <viewpeel/compute.h>
#include <viewpeel/drop_below.h>
#include <viewpeel/write.h>

namespace viewpeel::program {

// OutputOptions say where results go, and what of them.
struct OutputOptions {
  std::vector<std::string> files, shown;
  std::string ccx_version = "2.20";
  std::string format = "csv";  // on standard output
  bool to_stdout = false;      // -o -
  double drop_below = 0;
};

// Adds -o, --format, --show, --ccx-version and --drop-below.
void addOutputOptions(CLI::App* command, OutputOptions& options);
// Takes `-` out of the files, which stands for standard output.
//   Throws: Error bad_usage where it is named twice, or --format is given without it.
void settleOutputs(const CLI::App* command, OutputOptions& options);

// Refuses names of the same file, however they are written: "a.csv" and "./a.csv".    Throws: Error bad_usage.
void requireDistinct(const std::vector<std::filesystem::path>& files);

// Refuses files that cannot be written, and names of the same file, before anything is computed.
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

// Writes all of them, also where one fails, and at last to standard output.
//   In: may_ask: a person at the terminal may be asked for another place; remedy: as of writeSomewhere
//   Throws: the first error of all files.
void writeOutputs(const OutputContent& content, const OutputOptions& options, bool may_ask, const std::string& remedy);

// Describes what --drop-below left out: nothing where it was not given.
std::string describeDropped(const Ids& ids, const DroppedSums& dropped);

// Adds the command that made a result, and its goal: tolerance or epsilon.
void addOrigin(const Request& request, std::vector<std::pair<std::string, std::string>>& parameters);

}  // namespace viewpeel::program

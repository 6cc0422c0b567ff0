// The options -o and --checkpoint name the files of this header.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <viewpeel/compute.h>
#include <viewpeel/drop_below.h>
#include <viewpeel/write.h>

namespace viewpeel::program {

// OutputOptions say where results go, and which part of them.
struct OutputOptions {
  std::vector<std::string> files, shown;
  std::string ccx_version = "2.20";
  std::string format = "csv";  // of standard output
  bool to_stdout = false;      // for the option -o -
  double drop_below = 0;
};

// Adds -o, --format, --show, --ccx-version and --drop-below.
void addOutputOptions(CLI::App* command, OutputOptions& options);
// Removes `-`, which stands for standard output, from the files and sets to_stdout.
//   Throws: Error bad_usage where `-` occurs twice, or --format is given without it.
void settleOutputs(const CLI::App* command, OutputOptions& options);

// Refuses two names of one file, in any spelling: "a.csv" and "./a.csv".    Throws: Error bad_usage.
void requireDistinct(const std::vector<std::filesystem::path>& files);

// Refuses files that cannot be written, and two names of one file, before the computation.
//   In: checkpoint: empty where there is none; has_scene: whether the content will have the scene
//   Throws: Error bad_usage.
void checkOutputs(const std::vector<std::string>& outputs, const std::string& checkpoint, bool with_balance = false,
                  bool has_scene = true);

// A PlannedFile is a file that a run will write, and whether it existed before the run.
struct PlannedFile {
  std::string name;
  bool replaces;
};
// Finds out which files exist before the run.
std::vector<PlannedFile> planFiles(const std::vector<std::string>& names);
// Returns a line for each file: that it was written, or replaced.
std::string describeWritten(const std::vector<PlannedFile>& files);

// Writes all outputs, even where one fails, and standard output last.
//   In: may_ask: whether to ask on the terminal for another place; remedy: as in writeSomewhere
//   Throws: the first error of all files.
void writeOutputs(const OutputContent& content, const OutputOptions& options, bool may_ask, const std::string& remedy);

// Describes what --drop-below left out; empty without this option.
std::string describeDropped(const Ids& ids, const DroppedSums& dropped);
//   In: most: the largest sum that a row lost, and the name of this row
std::string describeDropped(double least, uint64_t pairs, double most, const std::string& row);

// Adds the command that made the result, and its goal: tolerance or epsilon.
void addOrigin(const Request& request, std::vector<std::pair<std::string, std::string>>& parameters);

}  // namespace viewpeel::program

// Commands `compute` and `plan` take the same options, so that a command line can be tried.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "program/checkpoint_keeper.h"
#include "program/outputs.h"

namespace viewpeel::program {

struct ComputeOptions {
  std::string scene, groups;
  Request request;
  OutputOptions output;
  std::vector<std::string> older_files;  // NAME.closed.mtx, of --closure
  std::vector<PlannedFile> files;        // all that are to be written, as they are before the run
  CheckpointOptions checkpoint;
  bool quiet = false, verbose = false, json = false;
  bool older_names = false;  // of what --balance writes

  bool talks() const { return !quiet && !json && !output.to_stdout; }
  bool keepsCheckpoint() const { return !checkpoint.file.empty(); }
  bool keepsResults() const { return !output.files.empty() || output.to_stdout; }
};

// Adds all options of `compute`.
//   Out: a function that settles the options once they are read    Throws (the function): Error bad_usage for options
//     that contradict each other.
std::function<std::shared_ptr<ComputeOptions>()> addComputeOptions(CLI::App* command);

// Makes sure that the outputs and the checkpoint can be written.    Throws: Error bad_usage.
void checkFiles(const ComputeOptions& options);
// Makes sure that the scene has what is to be shown, and rows that the formats of the outputs can have.
//   Throws: Error bad_usage.
void checkScene(const ComputeOptions& options, const Scene& scene);

}  // namespace viewpeel::program

// Commands `compute` and `plan` take the same options, so that the plan of a run can be seen first.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <glm/vec3.hpp>

#include "program/checkpoint_keeper.h"
#include "program/outputs.h"

namespace viewpeel::program {

struct ComputeOptions {
  std::vector<std::string> scene;  // its files
  std::string groups;
  Request request;
  OutputOptions output;
  std::vector<std::string> older_files;  // NAME.closed.mtx, which --closure writes beside NAME.mtx
  std::vector<PlannedFile> files;        // all files to be written, and whether each exists before the run
  CheckpointOptions checkpoint;
  bool quiet = false, verbose = false, json = false;
  bool older_names = false;  // whether --closure, the older name of --balance, is given
  bool only_environment = false;
  uint32_t row_blocks = 0;       // --row-blocks; 0: the matrix is in memory as a whole
  std::optional<glm::dvec3> up;  // --up, towards the sky; empty: the environment is not split into sky and ground

  bool talks() const { return !quiet && !json && !output.to_stdout; }
  bool keepsCheckpoint() const { return !checkpoint.file.empty(); }
  bool keepsResults() const { return !output.files.empty() || output.to_stdout; }
};

// Adds all options of `compute`.
//   Out: a function to call after parsing, which derives the request and the files and returns all options
//   Throws (the returned function): Error bad_usage for options that contradict each other.
std::function<std::shared_ptr<ComputeOptions>()> addComputeOptions(CLI::App* command);

// Refuses outputs and checkpoints that cannot be written.    Throws: Error bad_usage.
void checkFiles(const ComputeOptions& options);
// Refuses a scene without the surfaces of --show, or with rows that an output's format cannot hold.
//   Throws: Error bad_usage.
void checkScene(const ComputeOptions& options, const Scene& scene);
// Warns of backs that fronts see, before anything is counted, unless polygons emit on both sides.
void warnOfBacksOf(const ComputeOptions& options, const Scene& scene);

}  // namespace viewpeel::program

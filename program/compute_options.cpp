#include "program/compute_options.h"

#include <filesystem>

#include "program/only_environment.h"
#include "program/row_blocks.h"
#include "program/option_table.h"
#include "program/options.h"
#include "program/request_options.h"
#include "program/warnings.h"
#include "scene/leaks.h"
#include <viewpeel/error.h>

namespace viewpeel::program {
namespace {

// With --closure the balanced matrix is written once more, under the name that version 0.1 used.
std::vector<std::string> olderFilesOf(const std::vector<std::string>& outputs) {
  std::vector<std::string> files;
  for (const std::string& output : outputs)
    if (const std::filesystem::path file = output; file.extension() == ".mtx" && file.stem().extension() != ".errors")
      files.push_back(std::filesystem::path(file).replace_extension(".closed.mtx").string());
  return files;
}

std::vector<PlannedFile> plannedFiles(const ComputeOptions& options) {
  std::vector<std::string> names;
  for (const std::string& output : options.output.files)
    for (const std::filesystem::path& file : viewpeel::filesOf(output, options.request.balance))
      names.push_back(file.string());
  names.insert(names.end(), options.older_files.begin(), options.older_files.end());
  return planFiles(names);
}

// Turns a promise off, for checkpoints hold estimates only. All pairs get lines, so that the run can go on to a smaller
// tolerance.
void leaveOutPromise(Request& request) {
  if (request.promise.value_or(false))
    throw Error(ErrorCode::bad_usage, "--checkpoint keeps no promise; leave out one of --checkpoint and --promise on");
  if (!std::holds_alternative<EpsilonDelta>(request.goal)) request.promise = false, request.lines_for_all = true;
}

void requireAgreement(const ComputeOptions& options) {
  if (options.json && options.output.to_stdout)
    throw Error(ErrorCode::bad_usage, "--json and -o - both print on standard output; leave out one of them");
  if (options.output.drop_below > 0 && options.request.balance)
    throw Error(ErrorCode::bad_usage, "--balance adjusts all form factors; leave out --drop-below");
  if (options.up && !options.request.question.pair.empty())
    throw Error(ErrorCode::bad_usage, "--up is of the environment, which --pair leaves out; leave out one of them");
}

}  // namespace

std::function<std::shared_ptr<ComputeOptions>()> addComputeOptions(CLI::App* command) {
  const auto request_options = addRequestOptions(command);
  const auto options = std::make_shared<ComputeOptions>();
  startGroup(command, kWhat);
  addChoice(command, "--only", options->only_environment, {{"all", false}, {"environment", true}},
            "environment: of each row what leaves the scene, as sky view factors, and no form factors between rows; "
            "seconds in place of minutes");
  addUpOption(
      command, [options](const glm::dvec3& up) { options->up = up; },
      "Also the environment above and below the horizon, sky and ground apart: above is where this points; in .csv, "
      ".rows.csv, .h5, .json and .vtp");
  startGroup(command, kOutput);
  addOutputOptions(command, options->output);
  command->add_flag("--balance", request_options->request.balance,
                    "Closed scenes: also the nearest form factors whose rows sum to 1, beside those measured");
  command->add_flag("--closure", options->older_names,
                    "The older name of --balance, until 0.3: its .csv column has its older name, closed_form_factor, "
                    "and NAME.closed.mtx is written, too");
  startGroup(command, kLongRuns);
  command
      ->add_option(
          "--row-blocks", options->row_blocks,
          "For matrices beyond memory: keep this number of blocks of rows, one at a time in memory of each rank "
          "and others on disk, and write them into one .h5. Common directions count, to --tolerance, --relative or "
          "as many as --directions")
      ->type_name("N")
      ->transform(isWholeNumberFrom(1, 1'000'000));
  addCheckpointOptions(command, options->checkpoint);
  startGroup(command, kOutput);
  CLI::Option* quiet = command->add_flag("-q,--quiet", options->quiet, "Print nothing but errors and warnings");
  CLI::Option* verbose =
      command->add_flag("--verbose", options->verbose, "Print how work and memory are divided, too")->excludes(quiet);
  command->add_flag("--json", options->json, kJsonHelp)->excludes(quiet)->excludes(verbose);
  return [=] {
    options->scene = request_options->scene;
    options->groups = request_options->groups;
    options->request = requestOf(command, *request_options);
    if (options->keepsCheckpoint()) leaveOutPromise(options->request);
    options->request.balance |= options->older_names;
    options->request.measure_work = options->json;
    settleOutputs(command, options->output);
    if (options->older_names) options->older_files = olderFilesOf(options->output.files);
    requireAgreement(*options);
    if (options->only_environment) checkOnlyEnvironment(command, *options);
    if (options->row_blocks) checkRowBlocks(command, *options);
    options->files = plannedFiles(*options);
    return options;
  };
}

void checkFiles(const ComputeOptions& options) {
  std::vector<std::string> outputs = options.output.files;
  outputs.insert(outputs.end(), options.older_files.begin(), options.older_files.end());
  checkOutputs(outputs, options.checkpoint.file, options.request.balance);
  if (options.keepsCheckpoint() && !options.checkpoint.resume) requireNewCheckpoint(options.checkpoint.file);
}

void checkScene(const ComputeOptions& options, const Scene& scene) {
  const Ids ids = makeIds(scene, options.request.by, options.request.two_sided);
  checkShown(scene, ids, options.output.shown);
  for (const std::string& output : options.output.files) checkRows(output, scene, ids);
}

void warnOfBacksOf(const ComputeOptions& options, const Scene& scene) {
  if (options.request.two_sided) return;
  for (const std::string& line : warnOfBacks(scene)) warn(line);
}

}  // namespace viewpeel::program

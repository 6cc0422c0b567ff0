#include "program/outputs.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "program/command_line.h"
#include <viewpeel/error.h>
#include <viewpeel/write.h>

namespace viewpeel::program {

void checkOutputs(const std::vector<std::string>& outputs, const std::string& checkpoint, bool with_balance,
                  bool has_scene) {
  namespace fs = std::filesystem;
  std::set<fs::path> named;
  const auto name = [&](const fs::path& file) {
    std::error_code failure;  // a folder that cannot be looked into is refused below
    const fs::path place = fs::weakly_canonical(fs::absolute(file, failure), failure);
    if (!named.insert(place.empty() ? file : place).second)
      throw Error(ErrorCode::bad_usage, fmt::format("{}: is to be written twice; name every file once", file.string()));
  };
  for (const std::string& output : outputs)
    for (const fs::path& file : filesOf(output, with_balance)) name(file);
  if (!checkpoint.empty()) name(checkpoint);
  for (const std::string& output : outputs) checkOutput(output, with_balance, has_scene);
}

std::vector<PlannedFile> planFiles(const std::vector<std::string>& names) {
  std::vector<PlannedFile> files;
  std::error_code failure;
  for (const std::string& name : names) files.push_back({name, std::filesystem::exists(name, failure)});
  return files;
}

std::string describeWritten(const std::vector<PlannedFile>& files) {
  std::string text;
  for (const PlannedFile& file : files)
    text += fmt::format("{:<10} {}\n", file.replaces ? "replaced" : "written", file.name);
  return text;
}

void writeOutputs(const OutputContent& content, const std::vector<std::string>& outputs) {
  std::exception_ptr first_failure;
  for (const std::string& output : outputs) {
    try {
      writeFormFactors(content, output);
    } catch (const Error&) {
      if (!first_failure) first_failure = std::current_exception();
    }
  }
  if (first_failure) std::rethrow_exception(first_failure);
}

void addOrigin(const Request& request, std::vector<std::pair<std::string, std::string>>& parameters) {
  parameters.emplace_back("command", commandLine());
  const auto add = [&](const std::string& name, double value) {
    if (std::ranges::find(parameters, name, &std::pair<std::string, std::string>::first) == parameters.end())
      parameters.emplace_back(name, fmt::format("{}", value));
  };
  if (const auto* tolerance = std::get_if<Tolerance>(&request.goal)) add("tolerance", tolerance->standard_error);
  if (const auto* guarantee = std::get_if<EpsilonDelta>(&request.goal)) add("epsilon", guarantee->epsilon);
}

void addOutputOptions(CLI::App* command, std::vector<std::string>& outputs, std::vector<std::string>& shown,
                      std::string& ccx_version) {
  command
      ->add_option("-o,--output", outputs,
                   "Write the matrix: .csv, .mtx, .npz, .h5, .json or .vtp, a page: .html, or files of other programs: "
                   ".vwf, .idf, "
                   ".epJSON, .fdf, .dat, .i, or the folder of an OpenFOAM case")
      ->type_name("FILE")
      ->allow_extra_args(false);
  command
      ->add_option("--show", shown,
                   "In .vtp: the form factors from this surface or face to every polygon, as an array 'from NAME'")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command
      ->add_option("--ccx-version", ccx_version,
                   "In .vwf: the version of CalculiX that is to read it; none for those without a version record")
      ->type_name("V")
      ->capture_default_str();
}

}  // namespace viewpeel::program

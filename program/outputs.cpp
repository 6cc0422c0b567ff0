#include "program/outputs.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <set>

#include <fmt/format.h>

#include "program/command_line.h"
#include "program/options.h"
#include "program/rescue.h"
#include "program/summary.h"
#include <viewpeel/error.h>
#include <viewpeel/write.h>

namespace viewpeel::program {

void requireDistinct(const std::vector<std::filesystem::path>& files) {
  namespace fs = std::filesystem;
  std::set<fs::path> named;
  for (const fs::path& file : files) {
    std::error_code failure;  // not needed: checkOutputs() refuses folders that cannot be read
    const fs::path place = fs::weakly_canonical(fs::absolute(file, failure), failure);
    if (!named.insert(place.empty() ? file : place).second)
      throw Error(ErrorCode::bad_usage,
                  fmt::format("{}: two outputs have this name; name every file once", file.string()));
  }
}

void checkOutputs(const std::vector<std::string>& outputs, const std::string& checkpoint, bool with_balance,
                  bool has_scene) {
  std::vector<std::filesystem::path> files;
  for (const std::string& output : outputs)
    for (std::filesystem::path& file : filesOf(output, with_balance)) files.push_back(std::move(file));
  if (!checkpoint.empty()) files.emplace_back(checkpoint);
  requireDistinct(files);
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

void writeOutputs(const OutputContent& content, const OutputOptions& options, bool may_ask, const std::string& remedy) {
  std::exception_ptr first_failure;
  for (const std::string& output : options.files) {
    try {
      const std::string place = writeSomewhere(
          output, [&](const std::string& file) { writeFormFactors(content, file); }, may_ask, remedy);
      if (place != output) fmt::print(stderr, "viewpeel: written to {}\n", place);
    } catch (const Error&) {
      if (!first_failure) first_failure = std::current_exception();
    }
  }
  if (options.to_stdout) {
    writeFormFactors(content, std::cout, options.format);
    std::cout.flush();
  }
  if (first_failure) std::rethrow_exception(first_failure);
}

std::string describeDropped(double least, uint64_t pairs, double most, const std::string& row) {
  if (!pairs) return fmt::format("dropped    no pair is below {}\n", least);
  return fmt::format("dropped    {} below {}, {:.2g} of a row at most ({}); row sums and closure have them\n",
                     counted(pairs, "pair"), least, most, row);
}

std::string describeDropped(const Ids& ids, const DroppedSums& dropped) {
  uint32_t most = 0;
  for (uint32_t k = 0; k < ids.count(); ++k)
    if (ids.isRequested(k) && dropped.sums[k].value > dropped.sums[most].value) most = k;
  return describeDropped(dropped.least, dropped.pairs, dropped.sums[most].value, ids.names[most]);
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

void addOutputOptions(CLI::App* command, OutputOptions& options) {
  command
      ->add_option(
          "-o,--output", options.files,
          "Write the matrix: .csv, .mtx, .npz, .h5, .json or .vtp, its rows: .rows.csv, a page: .html, or files of "
          "other programs: .vwf, .idf, .epJSON, .fdf, .dat, .i, or the folder of an OpenFOAM case; - is standard "
          "output")
      ->type_name("FILE")
      ->allow_extra_args(false);
  addChoice<std::string>(command, "--format", options.format,
                         {{"csv", "csv"},
                          {"rows.csv", "rows.csv"},
                          {"mtx", "mtx"},
                          {"npz", "npz"},
                          {"h5", "h5"},
                          {"json", "json"},
                          {"vtp", "vtp"}},
                         "With -o -: what goes to standard output, in place of the summary");
  command
      ->add_option("--drop-below", options.drop_below,
                   "Leave pairs out of files whose form factors are below this both ways; .rows.csv, .h5 and .json say "
                   "what they add up to in each row")
      ->type_name("F")
      ->check([](const std::string& text) { return isNumber(text, 0, 0.999); });
  command
      ->add_option("--show", options.shown,
                   "In .vtp: the form factors from this surface or face to every polygon, as an array 'from NAME'")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command
      ->add_option("--ccx-version", options.ccx_version,
                   "In .vwf: the version of CalculiX that is to read it; none for those without a version record")
      ->type_name("V")
      ->capture_default_str();
}

void settleOutputs(const CLI::App* command, OutputOptions& options) {
  const auto count = std::erase(options.files, "-");
  if (count > 1) throw Error(ErrorCode::bad_usage, "-o - is given twice; standard output takes one result");
  options.to_stdout = count == 1;
  if (!options.to_stdout && command->get_option("--format")->count())
    throw Error(ErrorCode::bad_usage, "--format is for standard output; add -o -, or name a file by its ending");
}

}  // namespace viewpeel::program

#include <memory>

#include <fmt/format.h>

#include "program/commands.h"
#include "program/json.h"
#include "program/option_table.h"
#include "program/options.h"
#include "program/outputs.h"
#include "io/read_report.h"
#include "io/write_file.h"
#include "report/write_page.h"
#include <viewpeel/error.h>

namespace viewpeel::program {
namespace {

struct ReportCommand {
  std::string result, output;
  bool quiet = false, json = false;
};

int runReport(const ReportCommand& command) {
  requirePage(command.output);
  if (!command.output.ends_with(".html"))
    throw Error(ErrorCode::bad_usage, fmt::format("{}: a page needs a name that ends in .html", command.output));
  checkWritable(command.output);
  const std::vector<PlannedFile> files = planFiles({command.output});
  const ReportContent content = readReport(command.result);
  writeFile(command.output, [&](std::ostream& out) { writePage(content, out); });
  if (command.json) {
    Json report = startReport();
    report["files"] = jsonOf(files);
    printReport(std::move(report));
  } else if (!command.quiet) {
    fmt::print("{}", describeWritten(files));
  }
  return 0;
}

}  // namespace

void addReport(CLI::App& app, Run& chosen) {
  const auto options = std::make_shared<ReportCommand>();
  CLI::App* command = app.add_subcommand(
      "report",
      "Show a result: one page for a browser, which needs no network, with the scene, colours, tables and charts");
  command->add_option("RESULT", options->result, "File .h5 that compute, solve or merge wrote")->required();
  startGroup(command, kOutput);
  command->add_option("-o,--output", options->output, "Write the page: .html")->type_name("FILE")->required();
  CLI::Option* quiet = command->add_flag("-q,--quiet", options->quiet, "Print nothing but errors");
  command->add_flag("--json", options->json, kJsonHelp)->excludes(quiet);
  command->callback([options, &chosen] { chosen = [options] { return runReport(*options); }; });
}

}  // namespace viewpeel::program

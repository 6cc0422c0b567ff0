#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "program/command_line.h"
#include "program/commands.h"
#include "commit.h"
#include "program/help.h"
#include "program/json_error.h"
#include "program/mistakes.h"
#include "program/view3d.h"
#include "program/warnings.h"
#include <viewpeel/error.h>
#include "memory.h"

namespace {

using viewpeel::program::kBadUsage, viewpeel::program::kFailed;

int exitStatus(viewpeel::ErrorCode code) {
  return code == viewpeel::ErrorCode::bad_input || code == viewpeel::ErrorCode::bad_usage ? kBadUsage : kFailed;
}

// Prints an error on stderr, and with --json also on stdout. Returns the exit status.
int report(const std::string& message, int status, bool as_json) {
  viewpeel::program::complain(message);
  if (as_json) std::fputs(viewpeel::program::errorAsJson(message, status).c_str(), stdout);
  return status;
}

void parse(CLI::App& app, std::vector<std::string>& arguments) {
  viewpeel::program::addDefaultCommand(app, arguments);
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());  // CLI11 parses from the last element
  app.parse(reversed);
}

// Takes part in a job as a rank above 0, which prints nothing: rank 0 hears of errors when it asks for work.
int serve(CLI::App& app, std::vector<std::string>& arguments, viewpeel::program::Job& job) {
  viewpeel::program::leaveSignalsToRank0();
  viewpeel::program::silence();
  const auto fail = [&](viewpeel::ErrorCode code, const char* message) {
    viewpeel::serveRanks(*job.ranks, viewpeel::Error(code, message));
  };
  try {
    parse(app, arguments);
    if (job.serve) job.serve(*job.ranks);
    else fail(viewpeel::ErrorCode::bad_usage, "this command is of one rank");
  } catch (const viewpeel::Error& error) {
    fail(error.code(), error.what());
  } catch (const std::exception& error) {
    fail(viewpeel::ErrorCode::bad_usage, error.what());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const uint64_t memory = viewpeel::limitMemory();
  viewpeel::keepFreedMemory();
  viewpeel::program::keepCommandLine(argc, argv);
  CLI::App app(
      "viewpeel: form factors (view factors) of polygonal scenes with occlusion, for every pair at once, with a stated "
      "error",
      "viewpeel");
  app.set_version_flag("--version", "viewpeel " VIEWPEEL_VERSION VIEWPEEL_COMMIT);
  app.require_subcommand(1);
  viewpeel::program::Run chosen;
  viewpeel::program::Job job;
  viewpeel::program::addCompute(app, chosen, job);
  viewpeel::program::addSolve(app, chosen, job);
  viewpeel::program::addPlan(app, chosen);
  viewpeel::program::addCheck(app, chosen);
  viewpeel::program::addMerge(app, chosen);
  viewpeel::program::addReport(app, chosen);
  viewpeel::program::addDevices(app, chosen);
  viewpeel::program::addCompletion(app, chosen);
  viewpeel::program::setHelp(app);
  std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
  const bool as_json = std::ranges::find(arguments, "--json") != arguments.end();
  std::unique_ptr<viewpeel::Ranks> ranks;
  try {
    ranks = viewpeel::program::joinJob();
    job.ranks = ranks.get();
    if (job.isServer()) return serve(app, arguments, job);
    const bool is_view3d = viewpeel::program::isView3d(argv[0]);
    if (!is_view3d) {
      parse(app, arguments);
      viewpeel::program::keepOptions(app);
    }
    const int status = is_view3d ? viewpeel::program::runView3d(argc, argv) : chosen();
    errno = 0;
    if (std::fflush(stdout) != 0 || std::ferror(stdout))
      throw viewpeel::Error(viewpeel::ErrorCode::output,
                            fmt::format("standard output: cannot write: {}; send it to another place",
                                        std::strerror(errno ? errno : EIO)));
    return status;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version
    return report(viewpeel::program::describeMistake(app, arguments, error), kBadUsage, as_json);
  } catch (const viewpeel::Error& error) {
    // View3D has one status for all errors.
    if (viewpeel::program::isView3d(argv[0])) return report(error.what(), kFailed, false);
    return report(error.what(), exitStatus(error.code()), as_json);
  } catch (const std::bad_alloc&) {
    const std::string all = memory ? fmt::format(" ({:.3g} GB were there)", double(memory) * 1e-9) : "";
    return report(fmt::format("out of memory{}; try --by surface, for `compute` --row-blocks 10 -o NAME.h5, or a "
                              "smaller scene",
                              all),
                  kFailed, as_json);
  } catch (const std::exception& error) {
    return report(error.what(), kFailed, as_json);
  }
}

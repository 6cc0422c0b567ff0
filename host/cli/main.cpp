#include <exception>

#include <fmt/core.h>

#include "cli/commands.h"
#include "error.h"

namespace {

constexpr int kFailed = 1, kBadUsage = 2;

int exitStatus(viewpeel::ErrorCode code) {
  return code == viewpeel::ErrorCode::bad_input || code == viewpeel::ErrorCode::bad_usage ? kBadUsage : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("viewpeel: form factors (view factors) of polygonal scenes with occlusion, for every pair at once, with a stated error",
               "viewpeel");
  app.set_version_flag("--version", "viewpeel " VIEWPEEL_VERSION);
  app.require_subcommand(1);
  viewpeel::cli::Run chosen;
  viewpeel::cli::addCompute(app, chosen);
  viewpeel::cli::addPlan(app, chosen);
  viewpeel::cli::addCheck(app, chosen);
  viewpeel::cli::addMerge(app, chosen);
  viewpeel::cli::addDevices(app, chosen);
  try {
    app.parse(argc, argv);
    return chosen();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // help and version
    fmt::print(stderr, "viewpeel: {}; see 'viewpeel --help'\n", error.what());
    return kBadUsage;
  } catch (const viewpeel::Error& error) {
    fmt::print(stderr, "viewpeel: {}\n", error.what());
    return exitStatus(error.code());
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "viewpeel: out of memory; try --by surface or a smaller scene\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "viewpeel: {}\n", error.what());
  }
  return kFailed;
}

#include <fmt/format.h>

#include "program/commands.h"
#include "program/session.h"
#include "program/summary.h"

namespace viewpeel::program {
namespace {

// Everything but the run.
int runPlan(ProgramOptions options) {
  const Session session(options);
  session.describe();
  if (options.epsilon) {
    const GuaranteePlan plan = session.planGuarantee();
    fmt::print("{}{}", session.describe(plan), plan.engine->describePlan());
  } else {
    const Plan plan = session.plan();
    fmt::print("{}", session.describe(plan));
    if (!(plan.pilot_seconds > 0)) fmt::print("expected   {}\n", session.describeTime(plan));
    fmt::print("{}", plan.engine->describePlan());
  }
  if (session.device) checkValidation(*session.device);
  return 0;
}

}  // namespace

void addPlan(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand("plan", "Say what `compute` would do with the same options, how long it would take and in how much memory");
  const auto options = addOptions(command);
  command->callback([=, &chosen] {
    settle(command, *options);
    chosen = [options] { return runPlan(*options); };
  });
}

}  // namespace viewpeel::program

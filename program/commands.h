// The program has these subcommands, one file each. Each add function defines a subcommand and its options, and sets
// the function that runs it.
#pragma once
#include <functional>

#include <CLI/CLI.hpp>

#include "program/ranks/job.h"

namespace viewpeel::program {

// The exit status is 0 for success, one of the constants below, or 128 and the number of the signal that stopped a run.
constexpr int kFailed = 1, kBadUsage = 2, kGoalMissed = 3;

// Runs a subcommand and returns the exit status.
using Run = std::function<int()>;

// Sets `chosen` to the subcommand's Run if the command line names it. Subcommands that share their work in an MPI job
// set Job::serve, too; their Run uses Job::ranks.
void addCompute(CLI::App& app, Run& chosen, Job& job);
void addSolve(CLI::App& app, Run& chosen, Job& job);
void addPlan(CLI::App& app, Run& chosen);
void addCheck(CLI::App& app, Run& chosen);
void addDevices(CLI::App& app, Run& chosen);
void addMerge(CLI::App& app, Run& chosen);
void addReport(CLI::App& app, Run& chosen);
void addCompletion(CLI::App& app, Run& chosen);

}  // namespace viewpeel::program

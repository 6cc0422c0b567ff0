#include "program/row_blocks.h"

#include <algorithm>

#include <fmt/format.h>

#include <viewpeel/row_blocks.h>

#include "program/command_line.h"
#include "program/interrupts.h"
#include "program/progress_line.h"
#include "program/request_options.h"
#include "program/summary.h"
#include "program/warnings.h"
#include <viewpeel/error.h>
#include <viewpeel/ranks.h>

namespace viewpeel::program {
namespace {

int reportStop(uint64_t replicates) {
  complain(
      fmt::format("stopped by {}, {} done; nothing is written", interruptionName(), counted(replicates, "replicate")));
  return 128 + interruption();
}

std::string describe(const RowBlocksSummary& found, uint32_t block_count, double drop_below) {
  std::string text = fmt::format("sampling   {} directions a replicate; lattice {} across\n",
                                 found.directions / std::max<uint64_t>(found.replicates, 1), found.resolution);
  text += fmt::format("blocks     {} of rows, up to {} each\n", block_count,
                      counted(found.most_entries_of_block, "form factor"));
  text += fmt::format("errors     largest standard error of all form factors: {:.1e}; the file has {} of them\n",
                      found.largest_standard_error, found.entries);
  text += fmt::format("closure    row sums differ from 1 by at most {:.1e}, rms {:.1e}\n", found.closure.largest_error,
                      found.closure.rms_error);
  text += fmt::format("outside    {:.3g} % of all emitted radiation leaves the scene, {:.3g} % ends on backs (leak)\n",
                      100 * found.environment_share, 100 * found.leak_share);
  if (drop_below > 0)
    text += describeDropped(drop_below, found.dropped_pairs, found.most_dropped, found.most_dropped_row);
  return text + fmt::format("work       {}, {}, {:.2f} s\n", counted(found.replicates, "replicate"),
                            counted(found.directions, "direction"), found.seconds);
}

}  // namespace

void checkRowBlocks(const CLI::App* command, const ComputeOptions& options) {
  for (const char* name : {"--only", "--up", "--balance", "--closure", "--show", "--checkpoint", "--resume", "--json",
                           "--part", "--seconds", "--verbose"})
    if (command->get_option(name)->count())
      throw Error(ErrorCode::bad_usage,
                  fmt::format("{} takes the whole matrix at once; leave it out with --row-blocks", name));
  if (options.output.files.size() != 1 || options.output.to_stdout)
    throw Error(ErrorCode::bad_usage, "--row-blocks writes a .h5, block by block; give -o NAME.h5 and no other output");
}

int runRowBlocks(const ComputeOptions& options) {
  checkFiles(options);
  holdInterrupts([] { return reportStop(0); });
  ProgressLine progress(options.request, !options.quiet);
  progress.begin(fmt::format("reading {}", fmt::join(options.scene, ", ")));
  const Scene scene = loadSceneOf(options.scene, options.request.scene_options, options.groups);
  progress.clear();
  if (options.talks()) {
    fmt::print("{}{}", describeProcessor(), describeScene(scene));
    if (options.request.ranks)
      fmt::print("ranks      {} share the counting and the rows\n", options.request.ranks->size());
  }
  std::fflush(stdout);
  warnOfBacksOf(options, scene);
  RowBlocksRequest request{options.request, options.row_blocks, options.output.drop_below,
                           options.output.files.front()};
  addOrigin(options.request, request.parameters);
  const RowBlocksSummary found = computeRowBlocks(
      scene, request, {.should_stop = [] { return interruption() != 0; }, .on_progress = progress.listener()});
  progress.clear();
  endByItself();
  if (found.interrupted) return reportStop(found.replicates);
  if (options.talks())
    fmt::print("{}{}", describe(found, options.row_blocks, options.output.drop_below), describeWritten(options.files));
  return 0;
}

}  // namespace viewpeel::program

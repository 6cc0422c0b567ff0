// A program without MPI refuses to be started once for each rank, because every process would write the same files.
#include <fmt/format.h>

#include "program/ranks/job.h"
#include "program/ranks/launcher.h"
#include "program/warnings.h"
#include <viewpeel/error.h>

namespace viewpeel::program {

std::unique_ptr<Ranks> joinJob() {
  if (const long ranks = launchedRanks(); ranks > 1) {
    if (launchedRank() > 0) silence();
    throw Error(
        ErrorCode::bad_usage,
        fmt::format("started as {} ranks, but built without MPI; build with -DVIEWPEEL_MPI=ON, or start it once",
                    ranks));
  }
  return nullptr;
}

}  // namespace viewpeel::program

// An MPI job runs the program once for each rank: `mpirun -n 4 viewpeel compute SCENE`.
#pragma once
#include <functional>
#include <memory>

#include <viewpeel/ranks.h>

namespace viewpeel::program {

// This function does a command's work on a rank above 0: it reads the input and serves rank 0.
using Serve = std::function<void(Ranks& ranks)>;

// A Job is the program's part in an MPI job. Without one the program is alone, and MPI is not started.
struct Job {
  Ranks* ranks = nullptr;  // nullptr: the program is alone
  Serve serve;             // the command's work on ranks above 0; empty: rank 0 does it alone

  bool isServer() const { return ranks && ranks->rank() > 0; }
};

// Joins the job by which mpirun, mpiexec or srun has started this process.
//   Out: nullptr where no launcher has started this process, or where the job has one rank
//   Throws: Error bad_usage where the program is built without MPI.
std::unique_ptr<Ranks> joinJob();

// Leaves SIGINT, SIGTERM, SIGHUP and SIGUSR1 to rank 0, which tells the others to stop.
void leaveSignalsToRank0();

}  // namespace viewpeel::program

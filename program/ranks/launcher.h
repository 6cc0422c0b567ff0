// These functions read what a launcher of MPI jobs tells a process by environment variables.
#pragma once
#include <cstdlib>
#include <string>

namespace viewpeel::program {

// Returns the number of ranks of the job by which this process was started: 1 where it was started alone. Open MPI sets
// OMPI_COMM_WORLD_SIZE; MPICH and Slurm's pmi2 set PMI_SIZE; Slurm's pmix sets PMIX_RANK beside SLURM_NTASKS.
inline long launchedRanks() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", std::getenv("PMIX_RANK") ? "SLURM_NTASKS" : ""})
    if (const char* size = std::getenv(name)) return std::strtol(size, nullptr, 10);
  return 1;
}

// Returns the rank of this process, from 0, in the job by which it was started; 0 where it was started alone.
inline long launchedRank() {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK"})
    if (const char* rank = std::getenv(name)) return std::strtol(rank, nullptr, 10);
  return 0;
}

}  // namespace viewpeel::program

// `compute --row-blocks` writes matrices that no process could hold.
#pragma once
#include "program/compute_options.h"

namespace viewpeel::program {

// Refuses options that need the whole matrix in memory.    Throws: Error bad_usage.
void checkRowBlocks(const CLI::App* command, const ComputeOptions& options);

// Counts and writes blocks of rows, and prints a summary. Returns the exit status.
int runRowBlocks(const ComputeOptions& options);

}  // namespace viewpeel::program

// A checkpoint is a file with all counts of a run, from which another run can continue.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <viewpeel/compute.h>

#include "sums/run_sums.h"

namespace viewpeel {

class FileLock;

// Returns the value of a setting, or nothing where there is no setting of this name.
std::optional<std::string> findSetting(const Settings& settings, const std::string& name);

struct Checkpoint {
  Settings settings;
  // Its ids have names, areas, surfaces, requested rows and the flags of sums; of_polygon and roles are empty.
  RunSums sums;
};

// Writes HDF5: settings, ranges of replicates, and by id and by surface names, areas and all sums. Unoccluded form
// factors, visibilities and controls follow where a run has them. The same sums make the same bytes.
//   In: sums.isWhole(); lock: as writeFile
//   Error: none: integers and the bits of doubles.
//   Throws: Error output, Error limit where memory is short; `file` is then as it was before.
//   Cost: 40 bytes of disk for each nonzero pair, 44 and the longest name for each id; with unoccluded form factors 24
//     for each pair of the prior and 64 for each control; twice that number of bytes in memory.
void writeCheckpoint(const Settings& settings, const RunSums& sums, const std::filesystem::path& file,
                     FileLock* lock = nullptr);

// Reads a checkpoint.
//   Throws: Error bad_input where the file is no checkpoint, of another format, cut off or damaged (a check sum covers
//     all that it holds).
Checkpoint readCheckpoint(const std::filesystem::path& file);

// Compares the settings of two runs.
//   Throws: Error bad_usage, naming the first setting that differs, and `file`, which has the settings `found`.
void requireSameSettings(const Settings& expected, const Settings& found, const std::filesystem::path& file);

// Adds up checkpoints of one run, in any order of files, to the bits of one run over all their replicates. A file whose
// replicates are all in the sum so far adds nothing. A file that has all replicates of the sum replaces it.
//   In: files: one or more
//   Throws: as readCheckpoint; Error bad_usage where settings differ, or two files share some of their replicates.
//   Cost: O(nonzeros) for each file; memory for the sum and for one file.
Checkpoint mergeCheckpoints(const std::vector<std::filesystem::path>& files);

// Returns the ranges in words: "0 to 7, 16 to 23".
std::string describeReplicates(const std::vector<ReplicateRange>& replicates);

}  // namespace viewpeel

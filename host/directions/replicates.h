// Replicates of runs and of each kind of pilot have numbers of their own, so pilots use other random numbers than runs.
#pragma once
#include <array>
#include <cstdint>

namespace viewpeel {

// ReplicateNumbers are the numbers `first` to end - 1.
struct ReplicateNumbers {
  uint64_t first = 0, end = 0;
};

inline constexpr ReplicateNumbers kRunReplicates{0, (uint64_t(1) << 40) - 16};
// Trials compile kernels and measure times; their counts are not used.
inline constexpr ReplicateNumbers kTrialReplicates{kRunReplicates.end, uint64_t(1) << 40};
// Pilots of a plan, or of a guarantee; no run has both.
inline constexpr ReplicateNumbers kPlanReplicates{uint64_t(1) << 40, uint64_t(2) << 40};
// The second lattice of every direction of a plan's pilots.
inline constexpr ReplicateNumbers kPlanLatticeReplicates{uint64_t(2) << 40, uint64_t(3) << 40};
// Pilots that find the prior.
inline constexpr ReplicateNumbers kPriorReplicates{uint64_t(3) << 40, uint64_t(4) << 40};
// Pilots that choose directed pairs.
inline constexpr ReplicateNumbers kDirectedReplicates{uint64_t(4) << 40, uint64_t(5) << 40};
// Pilots that choose the numbers of pair lines.
inline constexpr ReplicateNumbers kLineReplicates{uint64_t(5) << 40, uint64_t(6) << 40};
// Directions that tell the parts of the environment.
inline constexpr ReplicateNumbers kEnvironmentReplicates{uint64_t(6) << 40, uint64_t(7) << 40};

// The list has all ranges in the order of their numbers. A test requires that none overlap.
inline constexpr std::array kReplicateNumbers = {kRunReplicates,         kTrialReplicates,      kPlanReplicates,
                                                 kPlanLatticeReplicates, kPriorReplicates,      kDirectedReplicates,
                                                 kLineReplicates,        kEnvironmentReplicates};

}  // namespace viewpeel

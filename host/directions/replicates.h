// Replicates of runs, and of each kind of pilot, have numbers from separate ranges, so that random numbers differ.
#pragma once
#include <array>
#include <cstdint>

namespace viewpeel {

// ReplicateNumbers are the numbers `first` to end - 1.
struct ReplicateNumbers {
  uint64_t first = 0, end = 0;
};

inline constexpr ReplicateNumbers kRunReplicates{0, (uint64_t(1) << 40) - 16};
// Numbers for trials, which compile kernels and measure times. Counts of trials are not used.
inline constexpr ReplicateNumbers kTrialReplicates{kRunReplicates.end, uint64_t(1) << 40};
// Numbers for pilots of a plan, or of a guarantee; no run has both.
inline constexpr ReplicateNumbers kPlanReplicates{uint64_t(1) << 40, uint64_t(2) << 40};
// Numbers for the second lattice of each direction in a plan's pilots.
inline constexpr ReplicateNumbers kPlanLatticeReplicates{uint64_t(2) << 40, uint64_t(3) << 40};
// Numbers for pilots that find the prior.
inline constexpr ReplicateNumbers kPriorReplicates{uint64_t(3) << 40, uint64_t(4) << 40};
// Numbers for pilots that choose directed pairs.
inline constexpr ReplicateNumbers kDirectedReplicates{uint64_t(4) << 40, uint64_t(5) << 40};
// Numbers for pilots that choose how many lines a pair gets.
inline constexpr ReplicateNumbers kLineReplicates{uint64_t(5) << 40, uint64_t(6) << 40};
// Numbers for directions that divide the environment into parts.
inline constexpr ReplicateNumbers kEnvironmentReplicates{uint64_t(6) << 40, uint64_t(7) << 40};
// Directions of products with vectors, which stand in for a matrix.
inline constexpr ReplicateNumbers kProductReplicates{uint64_t(7) << 40, uint64_t(8) << 40};

// This list has all ranges in order. A test checks that none overlap.
inline constexpr std::array kReplicateNumbers = {kRunReplicates,         kTrialReplicates,       kPlanReplicates,
                                                 kPlanLatticeReplicates, kPriorReplicates,       kDirectedReplicates,
                                                 kLineReplicates,        kEnvironmentReplicates, kProductReplicates};

}  // namespace viewpeel

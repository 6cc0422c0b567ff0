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
// Trials have these numbers. They compile kernels and measure times; their counts are not used.
inline constexpr ReplicateNumbers kTrialReplicates{kRunReplicates.end, uint64_t(1) << 40};
// Pilots of a plan, or of a guarantee, have these numbers; no run has both.
inline constexpr ReplicateNumbers kPlanReplicates{uint64_t(1) << 40, uint64_t(2) << 40};
// The second lattice of each direction in a plan's pilots is drawn with these numbers.
inline constexpr ReplicateNumbers kPlanLatticeReplicates{uint64_t(2) << 40, uint64_t(3) << 40};
// Pilots that find the prior have these numbers.
inline constexpr ReplicateNumbers kPriorReplicates{uint64_t(3) << 40, uint64_t(4) << 40};
// Pilots that choose directed pairs have these numbers.
inline constexpr ReplicateNumbers kDirectedReplicates{uint64_t(4) << 40, uint64_t(5) << 40};
// Pilots that choose how many lines a pair gets have these numbers.
inline constexpr ReplicateNumbers kLineReplicates{uint64_t(5) << 40, uint64_t(6) << 40};
// Directions that divide the environment into sky and ground have these numbers.
inline constexpr ReplicateNumbers kEnvironmentReplicates{uint64_t(6) << 40, uint64_t(7) << 40};
// Directions of products with vectors, which stand in for a matrix, have these numbers.
inline constexpr ReplicateNumbers kProductReplicates{uint64_t(7) << 40, uint64_t(8) << 40};
// Pilots that choose how many rays a polygon gets have these numbers.
inline constexpr ReplicateNumbers kRayReplicates{uint64_t(8) << 40, uint64_t(9) << 40};

// This list has all ranges in order. A test checks that none overlap.
inline constexpr std::array kReplicateNumbers = {
    kRunReplicates,      kTrialReplicates, kPlanReplicates,        kPlanLatticeReplicates, kPriorReplicates,
    kDirectedReplicates, kLineReplicates,  kEnvironmentReplicates, kProductReplicates,     kRayReplicates};

}  // namespace viewpeel

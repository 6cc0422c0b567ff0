// Replicates of runs and of pilots have different numbers, so the random numbers of pilots are none of the run's.
#pragma once
#include <array>
#include <cstdint>

namespace viewpeel {

struct ReplicateNumbers {
  uint64_t first = 0, end = 0;  // first to end - 1
};

// Guarantees and plans never go together, and share the numbers of their pilots.
inline constexpr ReplicateNumbers kRunReplicates{0, (uint64_t(1) << 40) - 16};
inline constexpr ReplicateNumbers kTrialReplicates{
    kRunReplicates.end, uint64_t(1) << 40};  // that compile kernels and take times; their counts are for nothing
inline constexpr ReplicateNumbers kPlanReplicates{uint64_t(1) << 40, uint64_t(2) << 40};
inline constexpr ReplicateNumbers kPlanLatticeReplicates{
    uint64_t(2) << 40, uint64_t(3) << 40};  // of the second lattice of every direction of a plan's pilots
inline constexpr ReplicateNumbers kPriorReplicates{uint64_t(3) << 40, uint64_t(4) << 40};
inline constexpr ReplicateNumbers kDirectedReplicates{uint64_t(4) << 40, uint64_t(5) << 40};
inline constexpr ReplicateNumbers kLineReplicates{uint64_t(5) << 40, uint64_t(6) << 40};

// The list has all of them, in order.
inline constexpr std::array kReplicateNumbers = {kRunReplicates,         kTrialReplicates, kPlanReplicates,
                                                 kPlanLatticeReplicates, kPriorReplicates, kDirectedReplicates,
                                                 kLineReplicates};

}  // namespace viewpeel

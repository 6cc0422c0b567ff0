// runVectorised compiles a loop over arrays several times: for AVX-512, for AVX2, and for any x86-64 processor, which
// has the 128-bit vectors of SSE2. At run time it takes the version for the widest vectors of the processor.
#pragma once

// This macro stands before a loop whose iterations do not depend on each other.
#if defined(__clang__)
#define VIEWPEEL_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define VIEWPEEL_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace viewpeel {

enum class Vectors { plain, avx2, avx512 };

// Returns the widest vectors that this processor has.
inline Vectors widestVectors() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw"))
    return Vectors::avx512;
  if (__builtin_cpu_supports("avx2")) return Vectors::avx2;
#endif
  return Vectors::plain;
}

#if defined(__x86_64__)
template <class Loops>
[[gnu::target("avx2")]] void runWithAvx2(const Loops& loops) {
  loops();
}

template <class Loops>
[[gnu::target("avx512vl,avx512dq,avx512bw")]] void runWithAvx512(const Loops& loops) {
  loops();
}
#endif

// Calls `loops`, compiled for the given vectors. `loops` and all functions that it calls have to be inlined, which
// [[gnu::always_inline]] makes sure of. All vectors give the same bits: without contraction (-ffp-contract=off) every
// operation is rounded by itself.
//   In: loops: callable without arguments
template <class Loops>
void runVectorised(Vectors vectors, const Loops& loops) {
#if defined(__x86_64__)
  if (vectors == Vectors::avx512) return runWithAvx512(loops);
  if (vectors == Vectors::avx2) return runWithAvx2(loops);
#endif
  loops();
}

}  // namespace viewpeel

// Compiles loops over arrays again for processors of the last ten years. Programs for any x86-64 are built for the
// vectors of 2003.
#pragma once

// The macro stands before a loop whose turns neither read nor write the results of others.
#if defined(__clang__)
#define VIEWPEEL_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define VIEWPEEL_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace viewpeel {

enum class Vectors { plain, avx2, avx512 };

// Returns the widest vectors of this processor.
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

// The argument `loops` is called without arguments; it and all that it calls must be inlined, which
// [[gnu::always_inline]] sees to. Results are the same bits with all vectors: without contraction every operation is
// rounded.
template <class Loops>
void runVectorised(Vectors vectors, const Loops& loops) {
#if defined(__x86_64__)
  if (vectors == Vectors::avx512) return runWithAvx512(loops);
  if (vectors == Vectors::avx2) return runWithAvx2(loops);
#endif
  loops();
}

}  // namespace viewpeel

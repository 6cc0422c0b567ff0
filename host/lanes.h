// Lanes hold a number for each of sixteen lines, or of eight blockers or points of a rule; few vector instructions act
// on all. Without contraction every lane rounds as a scalar would, so results are the same bits everywhere.
//
// Vulkan devices round sums, differences and products in single precision correctly, quotients and roots to 2.5 ulp or
// worse. Devices must draw the same lines as the processor, so lines are computed by sums, differences, products and
// comparisons alone (docs/method.md, section 13).
#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

#include "vectorised.h"

#define VIEWPEEL_INLINE [[gnu::always_inline]] inline

namespace viewpeel {

constexpr int kLineLanes = 16, kBlockerLanes = 8;

// Sanitizers check each piece of each operation, so that compilers take minutes over the small pieces of three kinds of
// processors. Under sanitizers there is one kind, with the largest pieces and the same bits.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define VIEWPEEL_LANES_OF_ONE_KIND
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define VIEWPEEL_LANES_OF_ONE_KIND
#endif
#endif

// Where this is defined, functions that are inlined into code for wide vectors name some of its instructions. Clang
// takes such names only in functions that are themselves compiled for wide vectors.
#if defined(__x86_64__) && !defined(__clang__) && !defined(VIEWPEEL_LANES_OF_ONE_KIND)
#define VIEWPEEL_NAMES_INSTRUCTIONS
#endif

#ifdef VIEWPEEL_NAMES_INSTRUCTIONS
// Returns a piece of more than 16 bytes that holds the first of these numbers in all lanes.
template <class Piece, class Few>
VIEWPEEL_INLINE Piece repeatFirst(const Few& numbers) {
  constexpr bool kIsDouble = sizeof(numbers[0]) == sizeof(double);
  if constexpr (sizeof(Piece) == 64 && kIsDouble) return __builtin_ia32_broadcastsd512(numbers, Piece{}, 0xff);
  else if constexpr (sizeof(Piece) == 64) return __builtin_ia32_broadcastss512(numbers, Piece{}, 0xffff);
  else if constexpr (kIsDouble) return __builtin_ia32_vbroadcastsd_pd256(numbers);
  else return __builtin_ia32_vbroadcastss_ps256(numbers);
}
#endif

// Returns a piece that holds x in all lanes. Where x is no constant, GCC takes two instructions for a shuffle. A list
// {x, x, ...} it lowers to single lanes (tree-vect-generic.cc) before the function is inlined into code for wide
// vectors.
template <class Piece, class Number>
VIEWPEEL_INLINE Piece broadcast(Number x) {
#ifdef VIEWPEEL_NAMES_INSTRUCTIONS
  if constexpr (std::is_floating_point_v<Number> && sizeof(Piece) > 16) {
    typedef Number Few __attribute__((vector_size(16)));
    if (!__builtin_constant_p(x)) return repeatFirst<Piece>(Few{x});
  }
#endif
  const Piece first{x};
  return [&]<int... k>(std::integer_sequence<int, k...>) __attribute__((always_inline)) {
    return __builtin_shufflevector(first, first, (0 * k)...);
  }
  (std::make_integer_sequence<int, int(sizeof(Piece) / sizeof(Number))>{});
}

// Lanes are kept in pieces as large as the processor's vectors. GCC splits comparisons of larger vectors into single
// lanes (tree-vect-generic.cc, expand_vector_condition).    Template: kBytes: of a piece
template <class Number, int kLanes, int kBytes>
struct LanesOf {
  static constexpr int kInPiece = kBytes / int(sizeof(Number)), kPieces = kLanes / kInPiece;
  static constexpr uint32_t kAllBits = (1u << kLanes) - 1;    // a bit for each lane
  typedef Number Piece __attribute__((vector_size(kBytes)));  // GCC takes no such attribute of an alias
  typedef Number StoredPiece __attribute__((vector_size(kBytes), aligned(sizeof(Number)), may_alias));
  static constexpr bool kIsDouble = sizeof(Number) == sizeof(double);
  using Floats = LanesOf<std::conditional_t<kIsDouble, double, float>, kLanes, kBytes>;      // of these numbers' size
  using Words = LanesOf<std::conditional_t<kIsDouble, uint64_t, uint32_t>, kLanes, kBytes>;  // of these numbers' size

  Piece of[kPieces] = {};

  LanesOf() = default;
  // Makes lanes that all hold x.
  VIEWPEEL_INLINE LanesOf(Number x) {
    const auto all = broadcast<Piece>(x);
    for (Piece& piece : of) piece = all;
  }
  // Makes lanes whose piece k is piece_of(k).
  template <class PieceOf>
  VIEWPEEL_INLINE static LanesOf make(const PieceOf& piece_of) {
    LanesOf lanes;
    [&]<int... k>(std::integer_sequence<int, k...>) __attribute__((always_inline)) {
      ((lanes.of[k] = piece_of(k)), ...);
    }
    (std::make_integer_sequence<int, kPieces>{});
    return lanes;
  }

  VIEWPEEL_INLINE Number operator[](int lane) const { return of[lane / kInPiece][lane % kInPiece]; }
  VIEWPEEL_INLINE void set(int lane, Number x) { of[lane / kInPiece][lane % kInPiece] = x; }

#define VIEWPEEL_OPERATOR(op)                                                              \
  VIEWPEEL_INLINE friend LanesOf operator op(const LanesOf& a, const LanesOf& b) {         \
    return make([&](int k) __attribute__((always_inline)) { return a.of[k] op b.of[k]; }); \
  }                                                                                        \
  VIEWPEEL_INLINE LanesOf& operator op##=(const LanesOf& b) { return *this = *this op b; }
  VIEWPEEL_OPERATOR(+)
  VIEWPEEL_OPERATOR(-)
  VIEWPEEL_OPERATOR(*)
  VIEWPEEL_OPERATOR(/)
  VIEWPEEL_OPERATOR(^)
  VIEWPEEL_OPERATOR(&)
  VIEWPEEL_OPERATOR(|)
#undef VIEWPEEL_OPERATOR
  VIEWPEEL_INLINE friend LanesOf operator-(const LanesOf& a) {
    return make([&](int k) __attribute__((always_inline)) { return -a.of[k]; });
  }
  VIEWPEEL_INLINE friend LanesOf operator<<(const LanesOf& a, int by) {
    return make([&](int k) __attribute__((always_inline)) { return a.of[k] << by; });
  }
  VIEWPEEL_INLINE friend LanesOf operator>>(const LanesOf& a, int by) {
    return make([&](int k) __attribute__((always_inline)) { return a.of[k] >> by; });
  }

  // Return x in lanes where a is below b, or at most b, and y in others.
  VIEWPEEL_INLINE friend LanesOf ifBelow(const LanesOf& a, const LanesOf& b, const LanesOf& x, const LanesOf& y) {
    return make([&](int k) __attribute__((always_inline)) { return a.of[k] < b.of[k] ? x.of[k] : y.of[k]; });
  }
  VIEWPEEL_INLINE friend LanesOf ifAtMost(const LanesOf& a, const LanesOf& b, const LanesOf& x, const LanesOf& y) {
    return make([&](int k) __attribute__((always_inline)) { return a.of[k] <= b.of[k] ? x.of[k] : y.of[k]; });
  }
  VIEWPEEL_INLINE friend LanesOf least(const LanesOf& a, const LanesOf& b) { return ifBelow(a, b, a, b); }
  VIEWPEEL_INLINE friend LanesOf greatest(const LanesOf& a, const LanesOf& b) { return ifBelow(b, a, a, b); }
};

VIEWPEEL_INLINE float ifBelow(float a, float b, float x, float y) { return a < b ? x : y; }
VIEWPEEL_INLINE double ifBelow(double a, double b, double x, double y) { return a < b ? x : y; }
VIEWPEEL_INLINE float least(float a, float b) { return a < b ? a : b; }
VIEWPEEL_INLINE float greatest(float a, float b) { return a > b ? a : b; }
VIEWPEEL_INLINE double least(double a, double b) { return a < b ? a : b; }
VIEWPEEL_INLINE double greatest(double a, double b) { return a > b ? a : b; }

// LaneTypes are the lanes of a processor whose vectors have this number of bytes.
template <int kBytes>
struct LaneTypes {
  using Floats = LanesOf<float, kLineLanes, kBytes>;
  using Words = LanesOf<uint32_t, kLineLanes, kBytes>;
  using Doubles = LanesOf<double, kBlockerLanes, kBytes>;
};

#if defined(__x86_64__) && !defined(VIEWPEEL_LANES_OF_ONE_KIND)
template <class Work>
[[gnu::target("avx2")]] void runInLanesOfAvx2(const Work& work) {
  work(LaneTypes<32>{});
}
template <class Work>
[[gnu::target("avx512vl,avx512dq,avx512bw")]] void runInLanesOfAvx512(const Work& work) {
  work(LaneTypes<64>{});
}
#endif
// Calls work(LaneTypes), compiled for these vectors.    In: work: an always_inline lambda
template <class Work>
void runInLanes([[maybe_unused]] Vectors vectors, const Work& work) {
#if defined(VIEWPEEL_LANES_OF_ONE_KIND)
  work(LaneTypes<64>{});
#else
#if defined(__x86_64__)
  if (vectors == Vectors::avx512) return runInLanesOfAvx512(work);
  if (vectors == Vectors::avx2) return runInLanesOfAvx2(work);
#endif
  work(LaneTypes<16>{});
#endif
}

// Reads numbers that stand one after another. memcpy would go through small copies on the stack, on which reading a
// whole piece waits.
template <class Lanes, class Number>
VIEWPEEL_INLINE Lanes load(const Number* from) {
  return Lanes::make([&](int k) __attribute__((always_inline)) {
    return typename Lanes::Piece(*reinterpret_cast<const typename Lanes::StoredPiece*>(from + k * Lanes::kInPiece));
  });
}

// Writes numbers one after another.
template <class Lanes, class Number>
VIEWPEEL_INLINE void store(const Lanes& lanes, Number* to) {
  for (int k = 0; k < Lanes::kPieces; ++k)
    *reinterpret_cast<typename Lanes::StoredPiece*>(to + k * Lanes::kInPiece) = lanes.of[k];
}

// Returns x where the condition is above 0, else 0.
template <class Floats>
VIEWPEEL_INLINE Floats keep(const Floats& condition, const Floats& x) {
  return ifBelow(Floats{}, condition, x, Floats{});
}
// Returns the numbers without their signs.
template <class Number>
VIEWPEEL_INLINE Number sizeOf(const Number& x) {
  return ifBelow(x, Number{}, -x, x);
}

// Returns a word with bit k set where lane k of a is at most lane k of b, of one piece.
template <class Piece>
VIEWPEEL_INLINE uint32_t bitsAtMostOfPiece(const Piece& a, const Piece& b) {
#ifdef VIEWPEEL_NAMES_INSTRUCTIONS
  constexpr bool kIsDouble = sizeof(a[0]) == sizeof(double);
  if constexpr (sizeof(Piece) == 64) {
    constexpr int kAtMost = 18, kThisRounding = 4;  // codes of the instruction
    if constexpr (kIsDouble) return __builtin_ia32_cmppd512_mask(a, b, kAtMost, 0xff, kThisRounding);
    else return __builtin_ia32_cmpps512_mask(a, b, kAtMost, 0xffff, kThisRounding);
  } else {
    const auto at_most = (Piece)(a <= b);
    if constexpr (sizeof(Piece) == 32 && kIsDouble) return static_cast<uint32_t>(__builtin_ia32_movmskpd256(at_most));
    else if constexpr (sizeof(Piece) == 32) return static_cast<uint32_t>(__builtin_ia32_movmskps256(at_most));
    else if constexpr (kIsDouble) return static_cast<uint32_t>(__builtin_ia32_movmskpd(at_most));
    else return static_cast<uint32_t>(__builtin_ia32_movmskps(at_most));
  }
#else
  constexpr int kLanes = int(sizeof(Piece) / sizeof(a[0]));
  uint32_t bits = 0;
  const auto at_most = a <= b;
  for (int k = 0; k < kLanes; ++k) bits |= (static_cast<uint32_t>(at_most[k]) & 1u) << k;
  return bits;
#endif
}
// The same of all lanes.
template <class Lanes>
VIEWPEEL_INLINE uint32_t bitsAtMost(const Lanes& a, const Lanes& b) {
  uint32_t bits = 0;
  for (int k = 0; k < Lanes::kPieces; ++k) bits |= bitsAtMostOfPiece(a.of[k], b.of[k]) << k * Lanes::kInPiece;
  return bits;
}
// Return whether a is at most b in all lanes or in any lane, or below b in any lane.
template <class Lanes>
VIEWPEEL_INLINE bool areAllAtMost(const Lanes& a, const Lanes& b) {
  return bitsAtMost(a, b) == Lanes::kAllBits;
}
template <class Lanes>
VIEWPEEL_INLINE bool isAnyAtMost(const Lanes& a, const Lanes& b) {
  return bitsAtMost(a, b) != 0;
}
template <class Lanes>
VIEWPEEL_INLINE bool isAnyBelow(const Lanes& a, const Lanes& b) {
  return !areAllAtMost(b, a);
}

// Returns the sum of all lanes. It adds lanes 8 apart first, then 4, 2 and 1, as the shaders do.
template <class Floats>
VIEWPEEL_INLINE float sumOf(const Floats& x) {
  float sums[kLineLanes];
  std::memcpy(sums, x.of, sizeof sums);
  for (int half = kLineLanes / 2; half > 0; half /= 2)
    for (int k = 0; k < half; ++k) sums[k] += sums[k + half];
  return sums[0];
}

// Returns the numbers of words below 2^31.
template <class Words>
VIEWPEEL_INLINE auto floatsOf(const Words& words) {
  using Floats = typename Words::Floats;
  using Integers = typename LanesOf<int32_t, kLineLanes, int(sizeof(typename Words::Piece))>::Piece;
  return Floats::make([&](int k) __attribute__((always_inline)) {
    return __builtin_convertvector((Integers)words.of[k], typename Floats::Piece);
  });
}
// Returns the whole parts of numbers from 0 to 2^31.
template <class Floats>
VIEWPEEL_INLINE Floats wholeOf(const Floats& x) {
  using Integers = typename LanesOf<int32_t, kLineLanes, int(sizeof(typename Floats::Piece))>::Piece;
  return Floats::make([&](int k) __attribute__((always_inline)) {
    return __builtin_convertvector(__builtin_convertvector(x.of[k], Integers), typename Floats::Piece);
  });
}

template <class Floats>
VIEWPEEL_INLINE typename Floats::Words bitsOf(const Floats& x) {
  using Words = typename Floats::Words;
  return Words::make([&](int k) __attribute__((always_inline)) { return (typename Words::Piece)x.of[k]; });
}
VIEWPEEL_INLINE uint32_t bitsOf(float x) { return std::bit_cast<uint32_t>(x); }
template <class Words>
VIEWPEEL_INLINE typename Words::Floats numberOf(const Words& bits) {
  using Floats = typename Words::Floats;
  return Floats::make([&](int k) __attribute__((always_inline)) { return (typename Floats::Piece)bits.of[k]; });
}
VIEWPEEL_INLINE float numberOf(uint32_t bits) { return std::bit_cast<float>(bits); }

// Returns x where the sign of y is plus, and -x where it is minus.
template <class Floats>
VIEWPEEL_INLINE Floats withSign(const Floats& x, const Floats& y) {
  return numberOf(bitsOf(x) ^ (bitsOf(y) & 0x80000000u));
}

// Returns 1 / x for x in [2^-125, 2^125], to 3e-7 of itself. The bits of x make a first guess, and each of Newton's
// steps squares its error.
template <class Numbers>
VIEWPEEL_INLINE Numbers reciprocal(const Numbers& x) {
  Numbers y = numberOf(0x7EF311C7u - bitsOf(x));  // relative error 0.13
  for (int step = 0; step < 3; ++step) y = y * (2.0f - x * y);
  return y;
}

// Returns x^-1/2 for x in [2^-100, 2^100], to 3e-7 of itself.    Source: as reciprocal
template <class Numbers>
VIEWPEEL_INLINE Numbers inverseRoot(const Numbers& x) {
  Numbers y = numberOf(0x5F3759DFu - (bitsOf(x) >> 1));  // relative error 0.035
  const Numbers half = 0.5f * x;
  for (int step = 0; step < 3; ++step) y = y * (1.5f - half * y * y);
  return y;
}

}  // namespace viewpeel

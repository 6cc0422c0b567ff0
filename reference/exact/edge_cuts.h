// EdgeCuts finds where a projected edge enters and leaves the other outlines.
#pragma once
#include <cstdint>
#include <vector>

#include <gmpxx.h>

#include "reference/exact/ball.h"
#include "reference/exact/projection.h"

namespace viewpeel::reference {

// A Cut is the point a + t (b - a) where an edge a -> b meets the line from vertex c to vertex d. If c = d, it is
// vertex c.
struct Cut {
  Ball t;
  uint32_t c = 0, d = 0;
};

// A Span is the part of an edge that an outline covers, within [0, 1].
struct Span {
  uint32_t outline = 0;
  // The side is 0 where the line passes through the inside of the outline. It is 1 or -1 where the line runs along an
  // edge with the inside to its left or right.
  int side = 0;
  Cut enter, leave;
};

// EdgeCuts computes the cuts of one edge a -> b between two different vertices.
class EdgeCuts {
 public:
  EdgeCuts(const Projection& projection, uint32_t a, uint32_t b) : projection_(projection), a_(a), b_(b) {}

  Cut begin() const { return {{0, 0}, a_, a_}; }
  Cut end() const { return {{1, 0}, b_, b_}; }

  // Appends the span of the outline, if it has one of positive length. Cost: O(vertices of the outline).
  void appendSpan(uint32_t outline, std::vector<Span>& spans) const;

  // Compares two cuts along the edge, exactly: negative if p lies before q, 0 if at the same place, positive if behind.
  int compare(const Cut& p, const Cut& q) const;
  mpq_class exactParameter(const Cut& cut) const;

 private:
  struct Fraction {
    mpz_class numerator, denominator;  // denominator > 0
  };
  Cut makeCut(uint32_t c, uint32_t d) const;
  Fraction exactFraction(const Cut& cut) const;

  const Projection& projection_;
  uint32_t a_, b_;
};

}  // namespace viewpeel::reference

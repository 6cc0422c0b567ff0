// The facing rules say what the gap between two consecutive layers of a line counts for: a pair of polygons, or the
// environment or leak of one polygon. Shaders, host engine and exact path all use this file; C++ includes it through
// host/facing.h.
//
// A line runs along +u. Each polygon that bounds a gap, the lower and the upper one, turns one of its sides to the gap.
// This side counts as `front` where it is the polygon's front or the polygon is two-sided, else as `back`. Where no
// polygon bounds the gap, it reaches out of the scene, and the side is `none`.

#ifdef __cplusplus
#define SHARED_FUNCTION inline
#else
#define SHARED_FUNCTION
#endif

const uint kSideNone = 0u;
const uint kSideFront = 1u;
const uint kSideBack = 2u;

const uint kGapNothing = 0u;           // the gap lies inside a solid, or outside of everything
const uint kGapFacingPair = 1u;        // the fronts of lower and upper face each other
const uint kGapLowerEnvironment = 2u;  // the front of lower sees the environment
const uint kGapUpperEnvironment = 3u;  // the front of upper sees the environment
const uint kGapLowerLeak = 4u;         // the front of lower sees the back of upper, which counts as leak of lower
const uint kGapUpperLeak = 5u;         // the front of upper sees the back of lower, which counts as leak of upper

// Coincident polygons have equal depths on every line. Their tie ranks order them: 0 to 7, along the normal of each
// polygon's own front (docs/method.md, section 3).
const uint kTieBits = 3u;

// Returns the place along +u, 0 to 7, of a polygon among polygons of equal depth; eq. (9).
//   In: front_up: the polygon's front faces +u
SHARED_FUNCTION uint placeAtTie(bool front_up, uint tie_rank) {
  return front_up ? tie_rank : (1u << kTieBits) - 1u - tie_rank;
}

// Returns the side that a polygon turns to the gap above it (above = true) or to the gap below it.
//   In: front_up: the polygon's front faces +u
SHARED_FUNCTION uint sideTowardsGap(bool front_up, bool two_sided, bool above) {
  return two_sided || front_up == above ? kSideFront : kSideBack;
}

// Returns kGap..., which says what a gap counts for.
//   In: the sides, by sideTowardsGap, of the polygons that bound the gap; kSideNone where there is no polygon
SHARED_FUNCTION uint classifyGap(uint lower_side, uint upper_side) {
  if (lower_side == kSideFront) {
    if (upper_side == kSideFront) return kGapFacingPair;
    return upper_side == kSideNone ? kGapLowerEnvironment : kGapLowerLeak;
  }
  if (upper_side == kSideFront) return lower_side == kSideNone ? kGapUpperEnvironment : kGapUpperLeak;
  return kGapNothing;
}

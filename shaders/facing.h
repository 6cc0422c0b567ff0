// The facing rules say what the gap between two consecutive layers of a line contributes, and to whom. They are written
// once for shaders, host and the exact path. GLSL includes them and, through host/facing.h, C++.
//
// A line runs along +u. A gap sees the upper side of the polygon that bounds it from below, and the lower side of the
// polygon that bounds it from above. A side is `front` where the polygon's front is turned to the gap, or the polygon
// is two-sided; `none` stands for no polygon: the gap reaches out of the scene.

#ifdef __cplusplus
#define SHARED_FUNCTION inline
#else
#define SHARED_FUNCTION
#endif

const uint kSideNone = 0u;
const uint kSideFront = 1u;
const uint kSideBack = 2u;

const uint kGapNothing = 0u;           // inside a solid, or outside of everything
const uint kGapFacingPair = 1u;        // lower and upper see each other
const uint kGapLowerEnvironment = 2u;  // lower sees the environment
const uint kGapUpperEnvironment = 3u;
const uint kGapLowerLeak = 4u;  // lower sees the back of upper: counted as its leak
const uint kGapUpperLeak = 5u;

// Polygons of one plane lie at one depth on every line, and tie ranks order them: places along their own fronts'
// normals.
const uint kTieBits = 3u;

// Returns the place among equal depths along +u, 0 to 7.
SHARED_FUNCTION uint placeAtTie(bool front_up, uint tie_rank) {
  return front_up ? tie_rank : (1u << kTieBits) - 1u - tie_rank;
}

// Returns the side that a polygon turns to the gap above it (above = true) or below it. front_up: its front faces +u.
SHARED_FUNCTION uint sideTowardsGap(bool front_up, bool two_sided, bool above) {
  return two_sided || front_up == above ? kSideFront : kSideBack;
}

SHARED_FUNCTION uint classifyGap(uint lower_side, uint upper_side) {
  if (lower_side == kSideFront) {
    if (upper_side == kSideFront) return kGapFacingPair;
    return upper_side == kSideNone ? kGapLowerEnvironment : kGapLowerLeak;
  }
  if (upper_side == kSideFront) return lower_side == kSideNone ? kGapUpperEnvironment : kGapUpperLeak;
  return kGapNothing;
}

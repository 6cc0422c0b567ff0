// The host and the shaders of pair lines share these structs and constants. C++ includes this file through
// host/pair_lines/shared.h. GLSL reads the structs in scalar layout, which is the layout of C++.

// A PatchData is a Patch (host/pair_lines/patches.h) as the shaders read it. Lengths are in unit-ball units.
struct PatchData {
  dvec3 corners[4];  // a triangle's last corner stands twice
  dvec3 normal;
  double offset;
  dvec3 edge_normals[4];
  double edge_offsets[4];
  dvec3 middle;
  dvec3 across;  // unit normal of the side from which the corners run counter-clockwise
  uint corner_count;
  uint padding;
};

const uint kMostObstacleEdges = 8u;

// A BlockerData is a Blocker (host/pair_lines/blockers.h) as the shaders read it.
struct BlockerData {
  dvec3 normal;
  double offset;
  dvec3 edge_normals[kMostObstacleEdges];
  double edge_offsets[kMostObstacleEdges];
  uint corner_count;
  uint padding;
};

// A LineTaskData is a task: a pair of patches between which lines are drawn.
struct LineTaskData {
  uint small, large;                    // indices of the smaller and the larger patch
  uint way;                             // kByPoints, kByAngles or kByContact
  float unit;                           // factor that gives the weights of lines a mean of 1
  uint scrambles[4];                    // seeds of the scrambling of Sobol' points, one a dimension
  uint first_obstacle, obstacle_count;  // the task's range in DrawLinesArgs::obstacles
};

// A LinePortionData is a portion: blocks `first` to end - 1 of a task, at most 16. A block is 16 lines.
struct LinePortionData {
  uint task, first, end;
};

// A PlacedData says that a blocker may stand in the way of a task's lines.
struct PlacedData {
  uint task, blocker;
  uint place;  // kBetween, kOverFirst or kOverSecond, where the first patch is the smaller one
};

// A LineEndData is a LineEnd<float> (host/pair_lines/line_ends.h), which explains its members.
struct LineEndData {
  vec3 corner, side_a, side_b, twist;
  vec3 density;
  vec3 normal;
  float offset;
  uint is_folded, edge_count;
  vec4 edges[4];
};

const uint kWarpBins = 8u;

// A LinePairData holds a task's two patches as ends of lines, about the middle of the smaller patch. The other members
// are for kByAngles alone (LineDrawer in host/pair_lines/draw_lines.h).
struct LinePairData {
  LineEndData first, second;
  vec3 axes[2];    // two axes of the second patch's plane, unit length
  vec2 ranges[2];  // least and greatest coordinate along each axis of the part of the second patch before the first
  // Starts and scales of the bins of the two warps of points of the first patch: bins of s, then bins of t.
  float starts[2 * kWarpBins], scales[2 * kWarpBins];
};

// An ObstacleData is an Obstacle<float> (host/pair_lines/line_ends.h): a blocker about the middle of the smaller patch.
struct ObstacleData {
  uint place, edge_count;          // see PlacedData
  vec4 plane;                      // unit normal, and minus its offset
  vec4 edges[kMostObstacleEdges];  // normals within the plane, outwards, and minus their offsets
};

// LinePortionSums are sums over the lines of a portion: weights of lines that nothing blocks, all weights, and squares
// of all weights.
struct LinePortionSums {
  float facing, all, squares;
};

struct PrepareArgs {
  uint64_t tasks;    // LineTaskData[task_count]
  uint64_t patches;  // PatchData[]
  uint64_t pairs;    // LinePairData[task_count]
  uint task_count;
};

struct PlaceArgs {
  uint64_t placed;     // PlacedData[placed_count]
  uint64_t tasks;      // LineTaskData[]
  uint64_t patches;    // PatchData[]
  uint64_t blockers;   // BlockerData[]
  uint64_t obstacles;  // ObstacleData[placed_count]
  uint placed_count;
};

struct DrawLinesArgs {
  uint64_t portions;   // LinePortionData[portion_count]
  uint64_t tasks;      // LineTaskData[]
  uint64_t pairs;      // LinePairData[task_count]
  uint64_t obstacles;  // ObstacleData[]
  uint64_t sobol;      // uint[4][32]: direction numbers of Sobol' points in four dimensions, for points in Gray's order
  uint64_t sums;       // LinePortionSums[portion_count]
  uint portion_count;
};

const uint kPairLinesGroup = 64u;
const uint kBlockLanes = 16u;                       // lines of a block, each drawn by one invocation
const uint kPortionBlocks = 16u;                    // blocks that are added up in single precision
const uint kTeams = kPairLinesGroup / kBlockLanes;  // portions that a workgroup draws at once
const uint kTileObstacles = 8u;                     // obstacles of a task that shared memory holds at once

// The enumerators of LineWay (host/pair_lines/draw_lines.h) and BlockerPlace (line_ends.h) have these values.
const uint kByPoints = 0u, kByAngles = 1u, kByContact = 2u;
const uint kBetween = 0u, kOverFirst = 1u, kOverSecond = 2u;

// Nine digits determine a number in single precision, so C++ and GLSL read the same constants.
const float kLeast = 9.09494702e-13f;        // 2^-40: lengths below it count as 0
const float kLeastSquare = 7.88860905e-31f;  // 2^-100: squares are raised to it before they divide
const float kFarAway = 1.09951163e+12f;      // 2^40: greater than any length
const float kMostWeight = 1.12589991e+15f;   // 2^50: weights are cut to it, so that sums of squares stay finite
const float kDigit = 5.96046448e-08f;        // 2^-24: random numbers in [0, 1) are multiples of it
// Planes count as parallel where the square of the sine of their angle is below this number.
const float kParallelSquare = 9.99999996e-13f;
// A warp spreads this share of the points evenly over its bins, and the rest in proportion to their form factors.
const float kEvenShare = 0.150000006f, kUnevenShare = 0.850000024f;
const float kEighthTurn = 0.785398185f, kQuarterTurn = 1.57079637f, kHalfTurn = 3.14159274f;  // radians
const float kInverseTurn = 0.159154937f;                                                      // 1 / (2 pi)
const float kLargeTangent = 2.41421366f, kMiddleTangent = 0.414213568f;  // tangents of 3 pi / 8 and pi / 8
// The polynomials of the tangent and the arc tangent have these coefficients of x^3, x^5 and so on.
const float kTangent3 = 0.333333343f, kTangent5 = 0.13333334f, kTangent7 = 0.0539682545f, kTangent9 = 0.0218694881f,
            kTangent11 = 0.00886323582f, kTangent13 = 0.00359212793f;
const float kArcTangent3 = -0.333329499f, kArcTangent5 = 0.199777111f, kArcTangent7 = -0.138776854f,
            kArcTangent9 = 0.0805374458f;
// First guesses of 1 / x and x^-1/2 are made of these and the bits of x.
const uint kReciprocalBits = 0x7EF311C7u, kInverseRootBits = 0x5F3759DFu;

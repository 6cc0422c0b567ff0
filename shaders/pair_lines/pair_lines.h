// Host and shaders share these structs and constants of pair lines, which are written once; C++ includes this through
// host/pair_lines/shared.h. GLSL reads the structs in scalar layout, which is C++'s own.

// A PatchData is a Patch (host/pair_lines/patches.h).
struct PatchData {
  dvec3 corners[4];  // a triangle's last twice
  dvec3 normal;
  double offset;
  dvec3 edge_normals[4];
  double edge_offsets[4];
  dvec3 middle;
  dvec3 across;  // of the corners' own order, unit length
  uint corner_count;
  uint padding;
};

const uint kMostObstacleEdges = 8u;

// A BlockerData is a Blocker (host/pair_lines/blockers.h).
struct BlockerData {
  dvec3 normal;
  double offset;
  dvec3 edge_normals[kMostObstacleEdges];
  double edge_offsets[kMostObstacleEdges];
  uint corner_count;
  uint padding;
};

// A LineTaskData is a pair of patches that lines are to be drawn between.
struct LineTaskData {
  uint small, large;  // patches
  uint way;           // LineWay
  float unit;         // of weights
  uint scrambles[4];
  uint first_obstacle, obstacle_count;
};

// A LinePortionData is up to 16 blocks of 16 lines of a task, which are added up in single precision.
struct LinePortionData {
  uint task, first, end;
};

// A PlacedData is a blocker of a task.
struct PlacedData {
  uint task, blocker;
  uint place;  // BlockerPlace, as seen from the smaller patch
};

// A LineEndData is a LineEnd<float> (host/pair_lines/line_ends.h).
struct LineEndData {
  vec3 corner, side_a, side_b, twist;
  vec3 density;
  vec3 normal;
  float offset;
  uint is_folded, edge_count;
  vec4 edges[4];
};

const uint kWarpBins = 8u;

// A LinePairData is what lines of a task need, but for obstacles (LineDrawer).
struct LinePairData {
  LineEndData first, second;
  vec3 axes[2];
  vec2 ranges[2];
  float starts[2 * kWarpBins], scales[2 * kWarpBins];
};

// An ObstacleData is an Obstacle<float> (host/pair_lines/line_ends.h).
struct ObstacleData {
  uint place, edge_count;
  vec4 plane;
  vec4 edges[kMostObstacleEdges];
};

// LinePortionSums are sums of weights over a portion: of lines that nothing blocks, and of all; and of all squares.
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
  uint64_t pairs;      // LinePairData[], by task
  uint64_t obstacles;  // ObstacleData[]
  uint64_t sobol;      // uint[4][32]: direction numbers in Gray's order
  uint64_t sums;       // LinePortionSums[portion_count]
  uint portion_count;
};

const uint kPairLinesGroup = 64u;
const uint kBlockLanes = 16u;     // lines of a block
const uint kPortionBlocks = 16u;  // of a task, added up in single precision
const uint kTeams = kPairLinesGroup / kBlockLanes;
const uint kTileObstacles = 8u;  // of a task, in shared memory at once

// LineWay and BlockerPlace have these values.
const uint kByPoints = 0u, kByAngles = 1u, kByContact = 2u;
const uint kBetween = 0u, kOverFirst = 1u, kOverSecond = 2u;

// Constants have nine digits, which are those of one number of single precision, however they are read.
const float kLeast = 9.09494702e-13f;        // 2^-40: heights and the like that are below count as 0
const float kLeastSquare = 7.88860905e-31f;  // 2^-100
const float kFarAway = 1.09951163e+12f;      // 2^40
const float kMostWeight = 1.12589991e+15f;   // 2^50: sums of squares stay finite
const float kDigit = 5.96046448e-08f;        // 2^-24: of random numbers
const float kParallelSquare = 9.99999996e-13f;
const float kEvenShare = 0.150000006f, kUnevenShare = 0.850000024f;  // of points that are spread by a warp
const float kEighthTurn = 0.785398185f, kQuarterTurn = 1.57079637f, kHalfTurn = 3.14159274f;
const float kInverseTurn = 0.159154937f;
const float kLargeTangent = 2.41421366f, kMiddleTangent = 0.414213568f;
// Of x^3, x^5, ... of the tangent, and of the arc tangent.
const float kTangent3 = 0.333333343f, kTangent5 = 0.13333334f, kTangent7 = 0.0539682545f, kTangent9 = 0.0218694881f,
            kTangent11 = 0.00886323582f, kTangent13 = 0.00359212793f;
const float kArcTangent3 = -0.333329499f, kArcTangent5 = 0.199777111f, kArcTangent7 = -0.138776854f,
            kArcTangent9 = 0.0805374458f;
const uint kReciprocalBits = 0x7EF311C7u, kInverseRootBits = 0x5F3759DFu;

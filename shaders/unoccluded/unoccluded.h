// The host and the shaders of unoccluded form factors share these structs and constants. C++ includes this file through
// host/unoccluded/shared.h.

// A ShapeData is a polygon as a bilinear image of the square of coordinates u and v from -1 to 1. A triangle's last
// corner stands twice. Lengths are in unit-ball units.
struct ShapeData {
  dvec3 corners[4];  // images of the square's corners (-1, -1), (1, -1), (1, 1), (-1, 1)
  dvec3 normal;      // unit normal of the front
  double density;    // area per du dv is density + density_u u + density_v v
  double density_u;
  double density_v;
  double reach;   // half of the longest line along which only u, or only v, changes
  double radius;  // greatest distance of a corner from the mean of the corners
  double skew;    // greatest |slope| / value of the density at the middle of such a line, 0 to 1: 0 for a parallelogram
  double tilt;    // how much rounding of the corners may tilt the plane: depth per distance
  double area;
  uint plane;     // twice the index of the scene's plane, plus 1 where the front looks against its normal
  uint tie_rank;  // tie rank of the front, see placeAtTie
};

const uint kLastTieRank = 7u;

const uint kShapeTexels = 12u;  // a ShapeData is this many texels of 16 bytes

// A SidePairData is a pair of sides. Side 2k is the front of polygon k, side 2k + 1 its back.
struct SidePairData {
  uint i, j;
};

const double kFrontRounding = 8.881784197001252e-16;  // 2^-50: a point nearer to a plane than this lies in it

// Product Gauss rules have kFewestFarPoints to kMostFarPoints points along each of the four coordinates.
const uint kFewestFarPoints = 2u;
const uint kFarRules = 5u;
const uint kMostFarPoints = kFewestFarPoints + kFarRules - 1u;

// A FarBound holds the coefficients of docs/method.md, eq. (37), the bound on a product rule's error; see errorOf in
// classify.comp.
struct FarBound {
  float even, odd, skew, tail;
};

const float kFarError = 9e-7f;  // largest relative error of a product rule; rounding has the rest up to 1e-6

const uint kUnoccludedGroupSize = 64u;

// A WorkList is the head of a list: one kernel appends entries, and the next one takes them, one an invocation.
struct WorkList {
  uint groups_x, groups_y, groups_z;  // workgroups of the next kernel, as an indirect dispatch reads them
  uint count;                         // entries
};

const uint kWorkListBytes = 16u;

const uint kLineRules = 4u;  // three plain Gauss rules and a graded one, see host/unoccluded/line_rules.h
const uint kGradedRule = kLineRules - 1u;

// There is a list of pairs for each product rule, and a last one of pairs that are integrated along their contours.
const uint kNearList = kFarRules;
const uint kPairLists = kFarRules + 1u;

struct UnoccludedStatus {
  WorkList pairs[kPairLists];
  WorkList lines[kLineRules];
  uint again;      // number of pairs whose line integrals need more points
  uint unreached;  // number of pairs that did not reach their accuracy with the most points
};

// The part of a polygon in front of a plane has at most five edges. A pair has a line integral over every pair of an
// edge of one polygon's part and an edge of the other's.
const uint kMostEdges = 5u;
const uint kEdgePairs = kMostEdges * kMostEdges;

struct EdgeData {
  dvec3 start, along;  // start in coordinates about the middle of the pair's first polygon; along is 0 for no edge
};

struct LineValue {
  double value;
  double error;  // bound on the error of `value`
};

struct UnreachedData {
  double error;  // bound on the error of the exchange area, unit-ball units squared
  uint pair;
  uint padding;
};

struct ClassifyArgs {
  uint64_t pairs;  // SidePairData[pair_count]
  uint64_t lists;  // uint[kPairLists][pair_count]
  uint64_t work;   // WorkList[kPairLists]
  FarBound bounds[kFarRules];
  uint pair_count;
};

struct FarArgs {
  uint64_t pairs;
  uint64_t areas;                  // double[pair_count]: exchange areas, unit-ball units squared
  uint64_t list;                   // uint[work.count]
  uint64_t work;                   // WorkList
  double nodes[kMostFarPoints];    // nodes of the Gauss rule on [-1, 1]
  double weights[kMostFarPoints];  // their sum is 2
};

struct EdgesArgs {
  uint64_t pairs;
  uint64_t near;        // uint[near_count]: indices of the pairs that are integrated along their contours
  uint64_t edges;       // EdgeData[near_count][2 kMostEdges]: edges of the first polygon, then of the second
  uint64_t values;      // LineValue[near_count][kEdgePairs]
  uint64_t lists;       // uint[kLineRules][near_count kEdgePairs]: for each rule, places in `values`
  uint64_t work;        // WorkList[kLineRules]
  double graded_error;  // error of the graded rule for edges p and q, in units of |p . q|
  uint near_count;
  uint plain_points[3];  // points of the three plain rules
};

struct LineArgs {
  uint64_t edges;
  uint64_t list;
  uint64_t values;
  uint64_t work;  // WorkList
  // The rule's points begin at this texel. A point is a node in [0, 1] and its weight; the weights add up to 1.
  uint first_point;
  uint point_count;
};

struct SumArgs {
  uint64_t pairs;
  uint64_t near;
  uint64_t values;
  uint64_t areas;
  uint64_t again;      // uint[]: indices of pairs that need more points
  uint64_t unreached;  // UnreachedData[]
  uint64_t status;
  uint near_count;
  uint is_last;  // 1 where no further round has more points
};

// Host and shaders share these structs of unoccluded form factors, which are written once; C++ includes this through
// host/unoccluded/shared.h.

// A ShapeData is a polygon as a bilinear image of the square -1..1 x -1..1; a triangle's last corner stands twice.
struct ShapeData {
  dvec3 corners[4];  // of (-1,-1), (1,-1), (1,1), (-1,1); unit-ball units
  dvec3 normal;      // of the front, unit length
  double density;    // area per du dv = density + density_u u + density_v v
  double density_u;
  double density_v;
  double reach;   // largest distance from the middle of a line of constant v (or u) to its ends
  double radius;  // of the corners about their mean
  double skew;    // largest |slope| / value, at the middle of such a line, of the density along it; 0..1
  double tilt;    // how far rounded corners may tilt the plane: depth per distance
  double area;
  uint plane;     // twice the scene's plane, and one where the front looks against its normal
  uint tie_rank;  // of the front, see placeAtTie
};

const uint kLastTieRank = 7u;

const uint kShapeTexels = 12u;  // of 16 bytes

// Side 2k is the front of polygon k, side 2k + 1 its back.
struct SidePairData {
  uint i, j;
};

const double kFrontRounding = 8.881784197001252e-16;  // 2^-50: a depth within this of a plane lies in it

// Product Gauss rules have these numbers of points along each of the four coordinates.
const uint kFewestFarPoints = 2u;
const uint kFarRules = 5u;
const uint kMostFarPoints = kFewestFarPoints + kFarRules - 1u;

// FarBound holds the coefficients of the bound on a product rule's error, see classify.comp.
struct FarBound {
  float even, odd, skew, tail;
};

const float kFarError = 9e-7f;  // bound on a product rule's relative error; the rest up to 1e-6 is for rounding

// A kernel appends to this list, and the next one works it off, one invocation an entry.
const uint kUnoccludedGroupSize = 64u;

struct WorkList {
  uint groups_x, groups_y, groups_z;  // as an indirect dispatch reads it
  uint count;
};

const uint kWorkListBytes = 16u;

const uint kLineRules = 4u;  // the last is graded, see host/unoccluded/line_rules.h

// Lists of pairs: one for each product rule, then those integrated along their contours.
const uint kNearList = kFarRules;
const uint kPairLists = kFarRules + 1u;

struct UnoccludedStatus {
  WorkList pairs[kPairLists];
  WorkList lines[kLineRules];
  uint again;      // pairs whose line integrals need more points
  uint unreached;  // pairs
};

// The part of a polygon in front of a plane has at most five edges; a pair's line integrals are those over all pairs of
// edges.
const uint kMostEdges = 5u;
const uint kEdgePairs = kMostEdges * kMostEdges;

struct EdgeData {
  dvec3 start, along;  // from the middle of the pair's first polygon; of length 0 where there is no such edge
};

struct LineValue {
  double value;
  double error;  // bound
};

struct UnreachedData {
  double error;  // of the exchange area
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
  uint64_t areas;                  // double[]
  uint64_t list;                   // uint[work.count]
  uint64_t work;                   // WorkList
  double nodes[kMostFarPoints];    // on -1..1
  double weights[kMostFarPoints];  // sum 2
};

struct EdgesArgs {
  uint64_t pairs;
  uint64_t near;        // uint[near_count]
  uint64_t edges;       // EdgeData[near_count][2 kMostEdges]: of the first polygon, then of the second
  uint64_t values;      // LineValue[near_count][kEdgePairs]
  uint64_t lists;       // uint[kLineRules][near_count kEdgePairs], into values
  uint64_t work;        // WorkList[kLineRules]
  double graded_error;  // of the graded rule, per |p| |q|
  uint near_count;
  uint plain_points[3];  // of the other rules
};

struct LineArgs {
  uint64_t edges;
  uint64_t list;
  uint64_t values;
  uint64_t work;     // WorkList
  uint first_point;  // of the rule, among the points read as texels: nodes on 0..1, each with its weight; sum 1
  uint point_count;
};

struct SumArgs {
  uint64_t pairs;
  uint64_t near;
  uint64_t values;
  uint64_t areas;
  uint64_t again;      // uint[]
  uint64_t unreached;  // UnreachedData[]
  uint64_t status;
  uint near_count;
  uint is_last;  // 1 where there is no rule with more points
};

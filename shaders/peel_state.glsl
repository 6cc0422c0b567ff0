// This part of peel.glsl declares its variants, its textures, and what an invocation keeps of its samples and its work.

layout(local_size_x_id = 0) in;                         // the subgroup size, 8 to 64
layout(constant_id = 1) const int kLayersKept = 4;      // layers of a sample that fit registers
layout(constant_id = 2) const bool kScanlines = false;  // samples are intervals, not lattice points
layout(constant_id = 3) const bool kSparse = false;     // counters are in a hash table
layout(constant_id = 4) const bool kAllCount = true;    // every polygon emits and receives
layout(constant_id = 5) const bool kAggregates = true;  // neighbouring lanes with the same pair are added at once
layout(constant_id = 6) const bool kMeasuresWork = false;
layout(constant_id = 7) const int kSteps = 8;               // samples of an invocation: 1, 2, 4 or 8
layout(constant_id = 8) const bool kIdsAreIndices = false;  // a polygon's id is its index
layout(constant_id = 9) const uint kTileWidth = 8u;         // lattice columns
// Lists are sorted by the polygons' nearest depths in the tile; never with scanlines.
layout(constant_id = 10) const bool kSorted = false;
layout(constant_id = 11) const bool kTwoSided = false;
layout(constant_id = 12) const bool kCountsBlocked = false;
// Small polygons are fragments at lattice points (see enter.comp), beside the polygons listed for tiles.
layout(constant_id = 13) const bool kFragments = false;
layout(constant_id = 14) const uint kTileRows = 8u;
layout(constant_id = 15) const int kColumnBits = 0;                // columns are in units of 2^-kColumnBits spacings
layout(constant_id = 16) const int kCutBits = 0;                   // see makeEdge
layout(binding = 5) uniform usamplerBuffer fragment_texels;        // uint64_t[], see ProjectArgs::fragments
layout(binding = 6) uniform usamplerBuffer fragment_count_texels;  // uint[], fragments of each lattice point
layout(push_constant, scalar) uniform Args { PeelArgs pushed; };
PeelArgs args;

const int kMostSteps = 8;
// A layer of a sample is one number, Layer::key << 32 | Layer::polygon, so the order of these numbers is the order
// along the line. kNoLayer stands for no layer.
const uint64_t kNoLayer = ~0ul;
const uint kBackMark = 0x80000000u;  // see addGaps
// With scanlines, the rows that a workgroup takes are laid end to end. A position in them is row * kRowWidth + column,
// with columns in units of 2^-kColumnBits spacings from the tile's first column.
const uint kRowWidth = kTileWidth << kColumnBits;  // 2^15
const uint kPositionBits = 17u;
const uint kPositions = 1u << kPositionBits;
const uint kNoColumns = ~0u;      // what spanOf returns where the polygon covers nothing of a row
const int kEndless = 0x7FFFFFFF;  // greater than any value of endKey

// With scanlines, `spans` has the spans of the rows: a polygon's index, and its columns as in spanOf. `ends` has the
// ends of all spans in order. `window` has the spans in the order in which they begin; the part of it that reaches the
// present samples moves on with them.
shared uvec2 spans[kScanlines ? kMostSpans : 1];
shared uint ends[kScanlines ? 2 * kMostSpans : 1];
shared uint window[kScanlines ? kMostSpans : 1];

// These variables hold what an invocation knows of each of its samples while it goes through the tile's polygons.
uint64_t nearest[kMostSteps][kLayersKept];  // the nearest layers of this round, in order
uint64_t last[kMostSteps];                  // the last layer that has been added, 0 at first
bool open[kMostSteps];                      // whether the sample may have further layers
uint end_count;                             // number of entries of `ends`, with scanlines
uint fresh;                                 // bit k is set in the first round of sample k, which counts it as work
uint64_t lost[kMostSteps];                  // the nearest layer of this round for which there was no room
// The farthest layers of each sample whose polygons emit, or receive.
uint64_t farthest_emitter[kMostSteps], farthest_receiver[kMostSteps];
uint block;  // DirectionData::block of the tile's direction

// A Place says where an invocation's first sample lies. With lattice points each further sample lies rowsPerStep() rows
// on.
struct Place {
  int column, row;  // its column and row in the tile; with scanlines columns are in units of 2^-kColumnBits spacings
  uint position;    // with scanlines: position of the sample's middle
  uint weight;      // what a gap on this sample adds to a counter
};
Place sample_at;

// A Tally counts work, see BatchStatus. The last three members count this invocation's work, the others the subgroup's.
struct Tally {
  uint rounds, tested;  // tested: polygons that the samples were tested against, in all rounds
  uint samples, fragments, gaps;
};
Tally tally;

// Returns the distance in rows of consecutive samples of an invocation.
int rowsPerStep() { return kScanlines ? 1 : int(gl_WorkGroupSize.x / kTileWidth); }

// Calls `take` for every sample of an invocation with a literal number, so that all array indices are constants.
#define EVERY_STEP(take)   \
  take(0);                 \
  if (kSteps > 1) take(1); \
  if (kSteps > 2) {        \
    take(2);               \
    take(3);               \
  }                        \
  if (kSteps > 4) {        \
    take(4);               \
    take(5);               \
    take(6);               \
    take(7);               \
  }

// A Passing is the polygon against which an invocation tests its samples, with its values at the present sample.
struct Passing {
  ivec4 edges, edges_per_step;  // with lattice points: values of its edges, and their change to the next sample
  bool covered;                 // with scanlines: whether it covers the sample
  int64_t z, z_per_step;        // its depth before the shift, and the change to the next sample
  int z_shift, z_min, z_max;    // see ProjectedPolygon
  uint64_t rest;                // lower bits of its layer, below the depth: place at ties << 32 | Layer::polygon
  uint roles;
};

// A Tile is the ActiveTile that the workgroup peels.
struct Tile {
  uint list_start, list_length, direction, weight;
  ivec2 corner;  // its least lattice column and row
  uint rows;     // rows that the workgroup takes
  uint first_point, most_fragments;
  bool is_sorted;  // whether its list is sorted
};

// These functions return the first position of a span and the position after its last, see spanOf.
uint firstOf(uint columns) { return columns & kPositions - 1u; }
uint endOf(uint columns) { return firstOf(columns) + (columns >> kPositionBits) + 1u; }

// Part of peel.glsl: it declares variants, textures, and the samples and work that an invocation keeps.

layout(local_size_x_id = 0) in;  // the subgroup size, 8 to 64
layout(constant_id = 1) const int kLayersKept = 4;
layout(constant_id = 2) const bool kScanlines = false;
layout(constant_id = 3) const bool kSparse = false;     // counters in a hash table
layout(constant_id = 4) const bool kAllCount = true;    // every polygon emits and receives
layout(constant_id = 5) const bool kAggregates = true;  // adds runs of equal contributions at once
layout(constant_id = 6) const bool kMeasuresWork = false;
layout(constant_id = 7) const int kSteps = 8;               // samples of an invocation: 1, 2, 4 or 8
layout(constant_id = 8) const bool kIdsAreIndices = false;  // of polygons
layout(constant_id = 9) const uint kTileWidth = 8u;         // lattice points
layout(constant_id = 10) const
    bool kSorted = false;  // lists are in the order of their polygons' nearest depths in the tile, not with scanlines
layout(constant_id = 11) const bool kTwoSided = false;
layout(constant_id = 12) const bool kCountsBlocked = false;
layout(constant_id = 13) const
    bool kFragments = false;  // lattice points also have layers of fragments, beside the tile's polygons
layout(constant_id = 14) const uint kTileRows = 8u;
layout(constant_id = 15) const int kColumnBits = 0;                // of an edge's column coordinate: with scanlines
layout(constant_id = 16) const int kCutBits = 0;                   // see makeEdge
layout(binding = 5) uniform usamplerBuffer fragment_texels;        // uint64_t
layout(binding = 6) uniform usamplerBuffer fragment_count_texels;  // uint
layout(push_constant, scalar) uniform Args { PeelArgs pushed; };
PeelArgs args;

const int kMostSteps = 8;
const uint64_t kNoLayer = ~0ul;  // a layer is key << 32 | polygon, see Layer, so that layers are ordered as numbers
const uint kBackMark = 0x80000000u;
// With scanlines, the rows of a tile lie side by side: a position in them is row * kRowWidth + column, in units of
// 2^-column_bits from the tile's first.
const uint kRowWidth = kTileWidth << kColumnBits;  // 2^15
const uint kPositionBits = 17u;
const uint kPositions = 1u << kPositionBits;
const uint kNoColumns = ~0u;      // a span that holds no sample
const int kEndless = 0x7FFFFFFF;  // beyond the key of any end

// With scanlines, these arrays hold the spans of the rows: polygon, and columns as in spanOf; their ends in order; and
// the spans in order of where they begin. A window of the last holds the spans that reach the present samples, and
// moves on with them.
shared uvec2 spans[kScanlines ? kMostSpans : 1];
shared uint ends[kScanlines ? 2 * kMostSpans : 1];
shared uint window[kScanlines ? kMostSpans : 1];

// The samples of an invocation while it goes through the tile's polygons.
uint64_t nearest[kMostSteps][kLayersKept];
uint64_t last[kMostSteps];  // the farthest layer of the rounds before
bool open[kMostSteps];      // whether the line may meet more layers
uint end_count;             // with scanlines
uint fresh;                 // samples, a bit each, whose layers have not been counted yet
uint64_t lost[kMostSteps];  // the nearest layer that found no room
uint64_t farthest_emitter[kMostSteps], farthest_receiver[kMostSteps];
uint block;  // whose counters the tile adds to

// Where the invocation's first sample is; with lattice points the others follow rowsPerStep() apart.
struct Place {
  int column, row;  // of the tile: lattice columns, with scanlines units of 2^-column_bits; rows
  uint position;    // with scanlines: its middle
  uint weight;
};
Place sample_at;

// A Tally is the work done, of the subgroup or, from `samples` on, of the invocation.
struct Tally {
  uint rounds, tested;  // tested: polygons, of every round
  uint samples, fragments, gaps;
};
Tally tally;

int rowsPerStep() { return kScanlines ? 1 : int(gl_WorkGroupSize.x / kTileWidth); }

// Names every sample of an invocation by a literal number, so that all indices become constants.
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

// A Passing is one polygon on its way past the samples.
struct Passing {
  ivec4 edges, edges_per_step;  // without scanlines
  bool covered;                 // with scanlines
  int64_t z, z_per_step;
  int z_shift, z_min, z_max;
  uint64_t rest;  // of the layer: the polygon, its facing, its place at ties
  uint roles;
};

struct Tile {
  uint list_start, list_length, direction, weight;
  ivec2 corner;  // of the lattice: the least column and row
  uint rows;     // with scanlines
  uint first_point, most_fragments;
  bool is_sorted;  // its list
};

// Return the ends of a span: see spanOf.
uint firstOf(uint columns) { return columns & kPositions - 1u; }
uint endOf(uint columns) { return firstOf(columns) + (columns >> kPositionBits) + 1u; }

// Host and shaders share these structs, which are written once. GLSL reads them in scalar layout, which is C++'s own.
// Included by C++ through host/engines/shared.h. A word "lattice point" is an integer pair; lattice coordinates are x /
// h + offset.

struct DirectionData {
  dvec3 x_axis;
  dvec3 y_axis;
  dvec3 u;
  dvec2 offset;  // lattice spacings
  uint weight;   // of every sample
  uint block;    // that it is counted with
};

struct PolygonData {
  uint first_corner;
  uint corner_count;
  uint id;        // of its counters, and its roles
  uint tie_rank;  // see placeAtTie
  dvec3 plane_normal;
  double plane_offset;
};

struct CornerData {
  dvec3 at;
  double padding;
};

// SnappedCorners are the corners of a polygon in one direction, snapped to fixed point, counter-clockwise as seen from
// +u; a triangle's last twice. Two texels, and a ProjectedPolygon is three: software devices fetch texels several times
// faster than they load words.
struct SnappedCorners {
  ivec2 at[4];
};

// A ProjectedPolygon is a polygon in one direction. Its depth at a lattice point p, in units of 2^-kDepthBits above -1,
// is
//   clamp((depth_0 + depth_x p.x + depth_y p.y) >> depth_shift, depth_min, depth_max).
struct ProjectedPolygon {
  ivec2 box_min;  // lattice points it can cover, between columns too; box_min.x > box_max.x where it covers none
  ivec2 box_max;
  int64_t depth_0;
  int64_t depth_x_packed;  // depth_x << 6 | depth_shift << 1 | front_up: 1 where its front faces +u
  int64_t depth_y;
  int depth_min;
  uint depth_max_packed;  // depth_max | place at ties << kTieShift
};

// The graphics engine draws this Outline of a polygon.
struct Outline {
  vec2 strip[4];  // in lattice coordinates, a triangle strip around all lattice points it can cover; one point where it
                  // covers none
  uint64_t blocks;  // of its cell that it can cover points of, see blockAlong
};

const int kDepthBits = 27;   // of a unit length; the unit ball spans 2^28 depths
const uint kTieShift = 29u;  // depths reach 2^28
const int kSnapBits = 25;    // of a snapped coordinate

// A Layer is the nearest polygon of a lattice point that peeling has not passed yet. Ordered by (key, polygon).
struct Layer {
  uint key;      // depth << kTieBits | place at ties
  uint polygon;  // (index + 1) << 1, and one where the front faces -u; 0 where the line has left the scene
};

const uint kKeyPastEverything = 0xFFFFFFFFu;

// The device writes LayerCommands for layer k+1 when layer k has any polygon.
struct LayerCommands {
  uint draw_vertex_count, draw_instance_count, draw_first_vertex, draw_first_instance;
  uint group_count_x, group_count_y, group_count_z;
  uint padding;
};

struct ProjectArgs {
  uint64_t snapped_corners;  // SnappedCorners[direction_count][polygon_count]
  uint64_t projected;        // ProjectedPolygon[direction_count][polygon_count]
  uint64_t outlines;         // Outline[direction_count][polygon_count], or 0 where nobody draws them
  uint polygon_count;
  uint direction_count;
  int resolution;     // lattice spacings across the unit ball's diameter
  int fraction_bits;  // of a snapped coordinate
  int column_bits;    // of an edge's column coordinate
  uint cell_size;     // see DrawArgs
  int window;         // lattice points from the origin to its left and lower border; beyond it nothing is looked at
  // The compute engine alone has the following.
  // uint[direction_count * polygon_count]: places in projected of the polygons for the passes over tiles
  uint64_t listed;
  uint64_t status;     // BatchStatus
  uint64_t fragments;  // uint64_t[fragment_capacity][point_count]: layers, key << 32 | polygon, as in Layer; points are
                       // first of tile 0, then of tile 1, ...
  uint64_t fragment_counts;  // uint[point_count]
  uint fragment_capacity;
  uint point_count;
  uint few_points;  // in the box of a polygon that enters itself
  uint tiles_wide, tiles_high;
};

// Directions lie side by side in one image, cells_per_row cells of cell_size^2 pixels a row; a cell's centre pixel is
// lattice point (0, 0).
struct DrawArgs {
  uint64_t polygons;
  uint64_t snapped_corners;
  uint64_t projected;
  uint64_t outlines;
  uint64_t previous;  // Layer[image_height][image_width]
  uint64_t alive;     // uint[direction_count][2]: the blocks of the cell in which the previous layer had a polygon
  uint polygon_count;
  uint cell_size;
  uint cells_per_row;
  uint image_width;
  uint image_height;
  int fraction_bits;
};

struct AccumulateArgs {
  uint64_t polygons;
  uint64_t lower;          // Layer[image_height][image_width], layer k-1
  uint64_t upper;          // layer k
  uint64_t counters;       // uint64_t, see counterIndex, two of each where blocked pairs are counted
  uint64_t status;         // BatchStatus
  uint64_t next_alive;     // uint[direction_count][2], alive for layer k+1
  uint64_t next_commands;  // LayerCommands
  uint id_count;
  uint cell_size;
  uint cells_per_row;
  uint image_width;
  uint direction_count;
  uint two_sided;
  uint instance_count;
  uint group_count;
  uint layer;       // k
  uint64_t layers;  // uint64_t[]: addresses of layers 0, 1, ..., where blocked pairs are counted, else 0
};

const uint kGroupsPerRow = 32768u;  // of a dispatch over tiles
const uint kMostSpans = 1024u;      // of a row of a tile, with scanlines
const uint kScanlineCell = 32u;     // lattice columns: a scanline is cut at their multiples, too
const uint kMostRowsAtOnce = 4u;
const uint kFewSpans = 128u;  // the fastest of 32 to 512 on lavapipe

// Returns how many rows of a tile peel takes at once with scanlines: several where its polygons have few spans in
// them, which would leave invocations idle.
SHARED_FUNCTION uint rowsAtOnce(uint list_length, uint tile_rows) {
  uint rows = list_length * 4u <= kFewSpans ? 4u : list_length * 2u <= kFewSpans ? 2u : 1u;
  return rows < tile_rows ? rows : tile_rows;
}

// Software devices end a shader's loops after 65,535 iterations in all (llvmpipe's LP_MAX_TGSI_LOOP_ITERATIONS). An
// invocation of bin stays below this number.
const uint kMostTilesPerInvocation = 4096u;
const uint kMostTileRows = 8u;
const uint kMostTileWidth = 8u;  // with lattice points: an edge changes by less than 2^30 within a tile

// Roles say where a polygon's facing pairs count. A facing pair counts where one of the two emits and the other
// receives.
const uint kEmits = 1u;
const uint kReceives = 2u;
const uint kRolesShift = 30u;  // in the word that holds a polygon's id
const uint kIdMask = 0x3FFFFFFFu;
SHARED_FUNCTION bool exchange(uint roles, uint others_roles) {
  return ((roles & kEmits) != 0u && (others_roles & kReceives) != 0u) ||
         ((others_roles & kEmits) != 0u && (roles & kReceives) != 0u);
}

// These bits say why a batch failed. After the first nothing has been counted.
const uint kListsOverflowed = 0x80000000u;
const uint kListsUncountable = 0x40000000u;
const uint kTooManySpans = 1u;  // in a row, for its ends to be put in order
const uint kCountersOverflowed = 2u;
const uint kLoopCut = 4u;         // the device ended a loop before its time
const uint kOtherSubgroups = 8u;  // a workgroup was not one subgroup; nothing has been counted

struct Groups {
  uint x, y, z;
};

// A BatchStatus has figures of the passes of a batch, for the passes after them and for the host.
struct BatchStatus {
  Groups project_groups, bin_groups;  // over the listed polygons
  uint listed;
  uint most_fragments;  // of a lattice point
  Groups peel_groups;   // over active tiles
  uint active_tiles;    // with kListsOverflowed where lists or fragments overflowed, kListsUncountable where the lists'
                        // length did
  uint list_length;     // of all tiles together
  uint unfinished;      // tiles
  uint overflows;       // kTooManySpans and so on
  uint pairs;           // that entered the hash table
  uint rounds;          // over the samples of a subgroup
  Groups meet_groups;   // over meetings, and parts of their farther polygons
  uint meetings;
  uint padding;
  // These count the work done, where it is measured.
  uint64_t rows;
  uint64_t spans;
  uint64_t samples;
  uint64_t tests;      // of a sample against a polygon of its tile
  uint64_t fragments;  // samples covered by a polygon: layers
  uint64_t gaps;       // between consecutive layers, the counted ones
};

// A tile is tile_width lattice columns by tile_rows lattice rows; a direction's tiles form a square grid around the
// lattice's origin.
struct BinArgs {
  uint64_t tile_roles;  // uint[direction_count][tiles_high][tiles_wide]: which roles its polygons have, where only some
                        // tiles count
  // uvec2[direction_count][tiles_high]: of a row's tiles with emitters, tiles_wide - the first column, and the last +
  // 1; or 0.
  uint64_t emitter_spans;
  uint64_t tile_counts;   // the same: of polygons
  uint64_t tile_starts;   // the same: where the tile's list begins
  uint64_t lists;         // uint[list_capacity]: polygons; ListEntry[list_capacity] where they are to be sorted
  uint64_t active_tiles;  // ActiveTile[tile_count]; with scanlines tile_rows times as many
  uint64_t directions;    // DirectionData[]
  uint64_t status;        // BatchStatus
  uint64_t listed;        // see ProjectArgs
  uint64_t fragment_counts;
  uint fragment_capacity;
  uint polygon_count;
  uint tiles_wide, tiles_high;
  uint tile_count;
  uint list_capacity;
  uint rows_per_invocation;  // of tiles
  uint needed_roles;         // of an active tile
};

// bin.comp has these modes.
const uint kBinEmitters = 0u;
const uint kBinReceivers = 1u;
const uint kBinCount = 2u;
const uint kBinScatter = 3u;

// An ActiveTile is a tile that holds anything or, with scanlines, the rows of it that peel takes at once, which share
// its list.
struct ActiveTile {
  uint list_start;
  uint list_length;
  uint direction;
  uint weight;      // of its samples
  int column, row;  // of the lattice, its least
  uint is_sorted;   // its list
  uint block;
  uint first_point;     // see ProjectArgs::fragments
  uint most_fragments;  // of its lattice points
  uint padding[2];
};

// A ListEntry is an entry of a list that is to be sorted.
struct ListEntry {
  uint polygon;
  uint nearest_depth;  // in the tile
};

const uint kMostSorted = 2048u;  // entries of a list

struct SortArgs {
  uint64_t sorted_lists;  // uint[list_capacity]
  uint64_t active_tiles;
  uint64_t status;
};

// Where blocked pairs are counted: the samples of a tile that a polygon covers, and how its depth ranges over the tile.
struct Cover {
  uint64_t samples;        // bit row * tile_width + column
  uint nearest, farthest;  // keys, see Layer
};

// A Meeting lists polygons of a tile that may face others of it: a few that may be the nearer, all that may be the
// farther. They are places in the lists of covers.
struct Meeting {
  uint tile;  // its place among the active ones
  uint nearer, nearer_end;
  uint farther, farther_end;
};

const uint kMostFarther = 256u;  // that one invocation of meet goes through

struct MeetArgs {
  // Cover[list_capacity] has the covers of each tile where its list is. Polygons with fronts that face +u come first,
  // the others last.
  uint64_t covers;
  uint64_t cover_polygons;  // uint[list_capacity]: whose they are
  uint64_t meetings;        // Meeting[]
  uint64_t status;
  uint64_t counters;
  uint polygon_count;
  uint id_count;
  uint counter_mask;
  uint64_t block_bytes;
};

// An UnfinishedTile is a tile, or the rows of it that were taken at once, whose layers one invocation could not get
// through.
struct UnfinishedTile {
  uint tile;
  uint first_sample;
  uint first_meeting;  // of spans that may be the nearer: the first whose meetings have not been counted
};

struct PeelArgs {
  uint64_t tiles;       // UnfinishedTile[], where it works off unfinished tiles
  uint64_t reached;     // uint64_t[]: the layers that the lines of those tiles have reached; ~0 where they are finished
  uint64_t unfinished;  // UnfinishedTile[]: tiles that this dispatch does not finish
  uint64_t reached_next;
  uint64_t status;
  uint64_t counters;
  uint polygon_count;
  uint id_count;
  uint counter_mask;  // of a hash table: places - 1
  uint counts_environment;
  uint most_blocks;      // of polygons that one invocation goes through
  uint point_count;      // see ProjectArgs
  uint resumes;          // how many unfinished tiles it works off; 0 where it begins
  uint64_t block_bytes;  // of the dense counters of one block, which follow each other
};

// A cell has 8 x 8 blocks, one bit each. Where the previous layer has no polygon, nothing is behind it, and polygons
// that can cover points of no other blocks are not drawn.
SHARED_FUNCTION uint blockAlong(uint in_cell, uint cell_size) { return in_cell * 8u / cell_size; }

// Returns the place of dense counters of ids i <= j: the rows of an upper triangle. Each row is followed by its
// environment (column id_count) and its leak (column id_count + 1).
SHARED_FUNCTION uint64_t counterIndex(uint i, uint column, uint id_count) {
  uint64_t row = uint64_t(i);
  return row * uint64_t(id_count + 2u) - row * (row + uint64_t(1u)) / uint64_t(2u) + uint64_t(column);
}

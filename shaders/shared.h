// The host and the shaders of the engines share these structs, constants and rules. C++ includes this file through
// host/engines/shared.h. GLSL reads the structs in scalar layout, which is the layout of C++.
// Lattice coordinates are x / h + offset, with x along an axis of the direction, in unit-ball units, and h the spacing.
// A lattice point has integer lattice coordinates.

// A DirectionData is a direction u with its lattice, which lies in the plane of x_axis and y_axis.
struct DirectionData {
  dvec3 x_axis;
  dvec3 y_axis;
  dvec3 u;
  dvec2 offset;  // offset of the lattice, in spacings
  uint weight;   // what one sample of this direction adds to a counter
  uint block;    // number of the block of directions to whose counters this direction adds
};

struct PolygonData {
  uint first_corner;
  uint corner_count;
  uint id;        // the polygon's id | its roles << kRolesShift
  uint tie_rank;  // see placeAtTie
  dvec3 plane_normal;
  double plane_offset;
};

struct CornerData {
  dvec3 at;  // unit-ball units
  double padding;
};

// SnappedCorners are the corners of a polygon in one direction, in lattice coordinates snapped to fixed point. They run
// counter-clockwise as seen from +u; a triangle's last corner stands twice. Passes read SnappedCorners as two texels
// and a ProjectedPolygon as three, for software devices fetch texels several times faster than they load words.
struct SnappedCorners {
  ivec2 at[4];
};

// A ProjectedPolygon is a polygon in one direction. Its depth at a lattice point p, in units of 2^-kDepthBits above -1,
// is
//   clamp((depth_0 + depth_x p.x + depth_y p.y) >> depth_shift, depth_min, depth_max).
struct ProjectedPolygon {
  // All lattice points that the polygon can cover lie in this box, borders included. With scanlines a lattice point
  // stands for the columns from it to the next point.
  ivec2 box_min;
  ivec2 box_max;
  int64_t depth_0;
  int64_t depth_x_packed;  // depth_x << 6 | depth_shift << 1 | front_up: 1 where its front faces +u
  int64_t depth_y;
  int depth_min;
  uint depth_max_packed;  // depth_max | place at ties << kTieShift
};

// An Outline is what the graphics engine draws of a polygon.
struct Outline {
  // Corners of a triangle strip around all lattice points that the polygon can cover, in lattice coordinates. All four
  // are the same point where the polygon covers no lattice point.
  vec2 strip[4];
  uint64_t blocks;  // a bit for each of the 8 x 8 blocks of its cell in which it can cover points, see blockAlong
};

const int kDepthBits = 27;   // a unit length is 2^27 depths, so the unit ball spans 2^28 depths
const uint kTieShift = 29u;  // depths reach 2^28, so the bits from this one on are free
const int kSnapBits = 25;    // snapped coordinates are below 2^25 in size

// A Layer is the nearest polygon on the line through a lattice point that peeling has not passed yet. Layers are
// ordered by (key, polygon).
struct Layer {
  uint key;      // depth << kTieBits | place at ties
  uint polygon;  // (index + 1) << 1, plus 1 where the front faces -u; 0 where the line has left the scene
};

const uint kKeyPastEverything = 0xFFFFFFFFu;

// LayerCommands are the arguments of the indirect draw and dispatch for layer k+1 (graphics engine). The device fills
// them in when layer k has any polygon.
struct LayerCommands {
  uint draw_vertex_count, draw_instance_count, draw_first_vertex, draw_first_instance;
  uint group_count_x, group_count_y, group_count_z;
  uint padding;
};

struct ProjectArgs {
  uint64_t snapped_corners;  // SnappedCorners[direction_count][polygon_count]
  uint64_t projected;        // ProjectedPolygon[direction_count][polygon_count]
  uint64_t outlines;         // Outline[direction_count][polygon_count]; 0 for the compute engine, which draws none
  uint polygon_count;
  uint direction_count;
  int resolution;     // lattice spacings across the unit ball's diameter
  int fraction_bits;  // binary digits after the point of a snapped coordinate
  int column_bits;    // an edge's column coordinate is in units of 2^-column_bits spacings
  uint cell_size;     // see DrawArgs
  int window;         // the window reaches from lattice point -window to window - 1 in x and y
  // The compute engine alone sets the members from here on.

  // uint[direction_count * polygon_count]: places in `projected` of the polygons that go on to the passes over tiles.
  uint64_t listed;
  uint64_t status;  // BatchStatus
  // uint64_t[fragment_capacity][point_count]: a Layer as key << 32 | polygon. The lattice points of tile 0 come first,
  // then the points of tile 1, and so on.
  uint64_t fragments;
  uint64_t fragment_counts;  // uint[point_count]
  uint fragment_capacity;    // most fragments of a lattice point
  uint point_count;          // lattice points of all tiles
  uint few_points;           // a polygon whose box holds at most this many lattice points becomes fragments
  uint tiles_wide, tiles_high;
};

// The graphics engine draws many directions into one image. Each direction has a cell of cell_size^2 pixels, and the
// image has cells_per_row cells in a row. A cell's centre pixel is lattice point (0, 0).
struct DrawArgs {
  uint64_t polygons;
  uint64_t snapped_corners;
  uint64_t projected;
  uint64_t outlines;
  uint64_t previous;  // Layer[image_height][image_width]
  uint64_t alive;     // uint[direction_count][2]: a bit for each block of the cell in which the previous layer had a
                      // polygon, see blockAlong
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
  uint64_t upper;          // the same of layer k
  uint64_t counters;       // uint64_t[], see counterIndex; two for each pair where blocked pairs are counted
  uint64_t status;         // BatchStatus
  uint64_t next_alive;     // uint[direction_count][2]: DrawArgs::alive of layer k+1
  uint64_t next_commands;  // LayerCommands of layer k+1
  uint id_count;
  uint cell_size;
  uint cells_per_row;
  uint image_width;
  uint direction_count;
  uint two_sided;
  uint instance_count;
  uint group_count;
  uint layer;       // the number k of the upper layer
  uint64_t layers;  // uint64_t[]: addresses of layers 0, 1, ..., where blocked pairs are counted, else 0
};

const uint kGroupsPerRow = 32768u;  // a dispatch over tiles has at most this many workgroups along x
const uint kMostSpans = 1024u;      // spans of the rows that peel takes at once, with scanlines
const uint kScanlineCell = 32u;     // with scanlines, samples also end at every multiple of this many lattice columns
const uint kMostRowsAtOnce = 4u;
const uint kFewSpans = 128u;  // see rowsAtOnce; the fastest of 32 to 512, measured on lavapipe

// Returns how many rows of a tile one workgroup of peel takes at once with scanlines. It takes several rows where the
// tile's list is short: one row would then have fewer spans than there are invocations.
SHARED_FUNCTION uint rowsAtOnce(uint list_length, uint tile_rows) {
  uint rows = list_length * 4u <= kFewSpans ? 4u : list_length * 2u <= kFewSpans ? 2u : 1u;
  return rows < tile_rows ? rows : tile_rows;
}

// Software devices end a shader's loops after 65,535 iterations in all (llvmpipe's LP_MAX_TGSI_LOOP_ITERATIONS). One
// invocation of bin therefore visits at most this many tiles.
const uint kMostTilesPerInvocation = 4096u;
const uint kMostTileRows = 8u;
const uint kMostTileWidth = 8u;  // with lattice points; an edge's value then changes by less than 2^30 within a tile

// A polygon's roles say which of its pairs are counted. A pair of polygons counts where one of the two emits and the
// other receives.
const uint kEmits = 1u;
const uint kReceives = 2u;
const uint kRolesShift = 30u;  // the word that holds a polygon's id has its roles from this bit on
const uint kIdMask = 0x3FFFFFFFu;
SHARED_FUNCTION bool exchange(uint roles, uint others_roles) {
  return ((roles & kEmits) != 0u && (others_roles & kReceives) != 0u) ||
         ((others_roles & kEmits) != 0u && (roles & kReceives) != 0u);
}

// These bits say why a batch failed. The first two stand in BatchStatus::active_tiles, the others in overflows.
const uint kListsOverflowed = 0x80000000u;   // lists or fragments needed more room; nothing has been counted
const uint kListsUncountable = 0x40000000u;  // the lists' length is 2^32 or more; nothing has been counted
const uint kTooManySpans = 1u;               // rows taken at once have more than kMostSpans spans
const uint kCountersOverflowed = 2u;         // the hash table had no place for a pair
const uint kLoopCut = 4u;                    // the device ended a loop before its condition was false
const uint kOtherSubgroups = 8u;             // a workgroup was not one subgroup; nothing has been counted

struct Groups {
  uint x, y, z;
};

// A BatchStatus holds figures that the passes of a batch leave to later passes and to the host.
struct BatchStatus {
  Groups project_groups, bin_groups;  // dispatches over the listed polygons
  uint listed;                        // number of listed polygons
  uint most_fragments;                // most fragments of one lattice point, where they are more than fragment_capacity
  Groups peel_groups;                 // dispatch over the active tiles
  uint active_tiles;                  // number of active tiles, | kListsOverflowed or kListsUncountable
  uint list_length;                   // polygons in the lists of all tiles
  uint unfinished;                    // number of unfinished tiles, see UnfinishedTile
  uint overflows;                     // kTooManySpans, kCountersOverflowed, kLoopCut, kOtherSubgroups
  uint pairs;                         // number of pairs that the batch has added to the hash table
  uint rounds;                        // how often subgroups went through the lists of their tiles
  Groups meet_groups;  // dispatch of meet: x, y over meetings, z over portions of kMostFarther farther polygons
  uint meetings;       // number of meetings
  uint padding;
  // The members from here on count work; they stay 0 where no work is measured.
  uint64_t rows;
  uint64_t spans;
  uint64_t samples;
  uint64_t tests;      // tests of one sample against one polygon of its tile
  uint64_t fragments;  // layers of all samples
  uint64_t gaps;       // gaps that were added to a counter
};

// A tile is tile_width lattice columns by tile_rows lattice rows. A direction's tiles form a grid around the lattice's
// origin.
struct BinArgs {
  // uint[direction_count][tiles_high][tiles_wide]: the bitwise or of the roles of all polygons over a tile; only where
  // some polygons lack a role.
  uint64_t tile_roles;
  // uvec2[direction_count][tiles_high]: where a row of tiles has emitters from column `first` to column `last`, it is
  // (tiles_wide - first, last + 1), else (0, 0); so atomicMax keeps both.
  uint64_t emitter_spans;
  uint64_t tile_counts;   // uint[direction_count][tiles_high][tiles_wide]: polygons over the tile
  uint64_t tile_starts;   // uint[direction_count][tiles_high][tiles_wide]: where the tile's list begins in `lists`
  uint64_t lists;         // uint[list_capacity]: polygon indices; ListEntry[list_capacity] where sort follows
  uint64_t active_tiles;  // ActiveTile[tile_count]; with scanlines ActiveTile[tile_count * tile_rows]
  uint64_t directions;    // DirectionData[]
  uint64_t status;        // BatchStatus
  uint64_t listed;        // see ProjectArgs
  uint64_t fragment_counts;
  uint fragment_capacity;
  uint polygon_count;
  uint tiles_wide, tiles_high;
  uint tile_count;
  uint list_capacity;
  uint rows_per_invocation;  // rows of tiles that one invocation visits
  uint needed_roles;         // a tile is peeled only where its polygons have all these roles
};

// bin.comp runs in these modes, in this order.
const uint kBinEmitters = 0u;
const uint kBinReceivers = 1u;
const uint kBinCount = 2u;
const uint kBinScatter = 3u;

// An ActiveTile is a tile with at least one polygon or fragment. With scanlines it is the rows of such a tile that peel
// takes at once, and all parts of one tile have the same list.
struct ActiveTile {
  uint list_start;
  uint list_length;
  uint direction;
  uint weight;          // DirectionData::weight
  int column, row;      // the least lattice column and row of the tile
  uint is_sorted;       // 1 where the list is in the order of depth, see sort.comp
  uint block;           // DirectionData::block
  uint first_point;     // where the tile's lattice points begin in ProjectArgs::fragments
  uint most_fragments;  // most fragments of one of its lattice points
  uint padding[2];
};

// A ListEntry is an entry of a list that sort will put in order.
struct ListEntry {
  uint polygon;
  uint nearest_depth;  // the least depth of the polygon's plane over the tile
};

const uint kMostSorted = 2048u;  // longer lists are left unsorted

struct SortArgs {
  uint64_t sorted_lists;  // uint[list_capacity]
  uint64_t active_tiles;
  uint64_t status;
};

// A Cover says which lattice points of a tile a polygon covers, and between which keys it lies over the tile. Covers
// are made where blocked pairs are counted.
struct Cover {
  uint64_t samples;        // bit row * tile_width + column is set where the polygon covers that point of the tile
  uint nearest, farthest;  // the least and the greatest Layer::key of the polygon's plane over the tile
};

// A Meeting is a task of the pass meet. It compares some polygons of a tile, as the nearer one of a pair, with all
// polygons that may be the farther one. Their covers have the places [nearer, nearer_end) and [farther, farther_end).
struct Meeting {
  uint tile;  // index in the list of active tiles
  uint nearer, nearer_end;
  uint farther, farther_end;
};

const uint kMostFarther = 256u;  // farther polygons that one invocation of meet goes through

struct MeetArgs {
  // Cover[list_capacity]: a tile's covers stand where its list does. Polygons whose fronts face +u stand from the
  // beginning of that range, the others from its end.
  uint64_t covers;
  uint64_t cover_polygons;  // uint[list_capacity]: index of each cover's polygon
  uint64_t meetings;        // Meeting[]
  uint64_t status;
  uint64_t counters;
  uint polygon_count;
  uint id_count;
  uint counter_mask;
  uint64_t block_bytes;
};

// An UnfinishedTile is an active tile whose workgroup left a part to another dispatch of peel, because its invocations
// had gone through PeelArgs::most_blocks blocks of polygons.
struct UnfinishedTile {
  uint tile;           // index in the list of active tiles
  uint first_sample;   // samples before it are finished
  uint first_meeting;  // with scanlines: meetings of the spans before it have been counted, see meetSpans
};

struct PeelArgs {
  uint64_t tiles;  // UnfinishedTile[resumes]: tiles that this dispatch resumes
  // uint64_t[]: for each sample that the workgroups of these tiles had begun, the last layer that has been added; ~0
  // where no layers are left.
  uint64_t reached;
  uint64_t unfinished;    // UnfinishedTile[]: tiles that this dispatch leaves unfinished
  uint64_t reached_next;  // `reached` of the tiles that this dispatch leaves unfinished
  uint64_t status;
  uint64_t counters;
  uint polygon_count;
  uint id_count;
  uint counter_mask;        // places of the hash table - 1
  uint counts_environment;  // whether lines that leave the scene or end on backs are counted
  uint most_blocks;         // one invocation goes through this many blocks of polygons, of a subgroup's size each
  uint point_count;         // see ProjectArgs
  uint resumes;             // number of unfinished tiles that this dispatch resumes; 0 where it takes all active tiles
  uint64_t block_bytes;     // size of the dense counters of one block of directions; the next block's follow
};

// A cell of the image is divided into 8 x 8 blocks, and this function returns the block of a pixel along x or y. In a
// block where the previous layer has no polygon no further layer has one. So a polygon that can cover points in no
// other blocks is not drawn.
SHARED_FUNCTION uint blockAlong(uint in_cell, uint cell_size) { return in_cell * 8u / cell_size; }

// Returns the index of the dense counter of ids i <= column. Dense counters are the rows of an upper triangle, one
// after the other. Row i ends with the environment of i (column id_count) and its leak (column id_count + 1).
SHARED_FUNCTION uint64_t counterIndex(uint i, uint column, uint id_count) {
  uint64_t row = uint64_t(i);
  return row * uint64_t(id_count + 2u) - row * (row + uint64_t(1u)) / uint64_t(2u) + uint64_t(column);
}

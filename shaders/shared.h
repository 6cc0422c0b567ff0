// Structs that host and shaders share, written once. GLSL reads them in scalar layout, which is C++'s own. Included by C++
// through host/engines/shared.h. A word "lattice point" is an integer pair; lattice coordinates are x / h + offset.

struct DirectionData {
  dvec3 x_axis;
  dvec3 y_axis;
  dvec3 u;
  dvec2 offset;  // lattice spacings
};

struct PolygonData {
  uint first_corner;
  uint corner_count;
  uint id;  // of its counters
  uint padding;
  dvec3 plane_normal;
  double plane_offset;
};

// An edge over the lattice: a p.x + b p.y + c >= 0 where point p lies on the polygon's side of it.
struct Edge {
  int a, b;
  int64_t c;
};

// A polygon in one direction. Depth at a lattice point p is
//   clamp((depth_0 + depth_x p.x + depth_y p.y) >> depth_shift, depth_min, depth_max), in units of 2^-kDepthBits above -1.
struct ProjectedPolygon {
  vec2 outline[4];  // in lattice coordinates, a triangle strip around all lattice points it can cover; one point where it covers none
  uint64_t blocks;  // of its cell that it can cover points of, see blockAlong
  ivec2 box_min;    // lattice points it can cover; box_min.x > box_max.x where it covers none
  ivec2 box_max;
  int64_t depth_0;
  int64_t depth_x;
  int64_t depth_y;
  int depth_shift;
  int depth_min;
  int depth_max;
  uint front_up;      // 1 where its front faces +u
};

const int kDepthBits = 27;  // of a unit length; the unit ball spans 2^28 depths
const int kSnapBits = 25;   // of a snapped coordinate: what an edge changes by within a tile stays below 2^30

// The nearest polygon of a lattice point that peeling has not passed yet. Ordered by (key, polygon): key is twice the depth,
// plus one where the front faces -u, so that at equal depths fronts that face +u come first.
struct Layer {
  uint key;
  uint polygon;  // index + 1; 0 where the line has left the scene
};

const uint kKeyPastEverything = 0xFFFFFFFFu;

// Written by the device for layer k+1 when layer k has any polygon.
struct LayerCommands {
  uint draw_vertex_count, draw_instance_count, draw_first_vertex, draw_first_instance;
  uint group_count_x, group_count_y, group_count_z;
  uint padding;
};

struct ProjectArgs {
  uint64_t directions;  // DirectionData[direction_count]
  uint64_t polygons;    // PolygonData[polygon_count]
  uint64_t corners;     // dvec3[corner_count]
  uint64_t edges;       // Edge[direction_count][corner_count], edge k from corner k to the next of its polygon
  uint64_t projected;   // ProjectedPolygon[direction_count][polygon_count]
  uint polygon_count;
  uint corner_count;
  uint direction_count;
  int resolution;       // lattice spacings across the unit ball's diameter
  int fraction_bits;    // of a snapped coordinate
  uint cell_size;       // see PeelArgs
};

// Directions lie side by side in one image, cells_per_row cells of cell_size^2 pixels a row; a cell's centre pixel is
// lattice point (0, 0).
struct PeelArgs {
  uint64_t polygons;
  uint64_t edges;
  uint64_t projected;
  uint64_t previous;       // Layer[image_height][image_width]
  uint64_t alive;          // uint[direction_count][2]: the blocks of the cell in which the previous layer had a polygon
  uint polygon_count;
  uint corner_count;
  uint cell_size;
  uint cells_per_row;
  uint image_width;
  uint image_height;
};

struct AccumulateArgs {
  uint64_t polygons;
  uint64_t lower;          // Layer[image_height][image_width], layer k-1
  uint64_t upper;          // layer k
  uint64_t counters;       // uint, see counterIndex
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
};

const int kTileSize = 8;            // lattice points a side, of the compute engine's tiles
const uint kGroupsPerRow = 32768u;  // of a dispatch over tiles

// Software devices end a shader's loops after 65,535 iterations in all (llvmpipe's LP_MAX_TGSI_LOOP_ITERATIONS). An invocation of bin stays below that;
// peel, whose loops follow the scene, notices and says so.
const uint kMostTilesPerInvocation = 4096u;
const uint kMostEdgesTested = 8u;

// What binning and peeling found, for the host.
struct BinStatus {
  uint active_tiles;
  uint truncated;    // 1 where the device ended a loop of peel before its time
  uint list_length;  // of all tiles together
};

struct BinArgs {
  uint64_t polygons;
  uint64_t edges;
  uint64_t projected;
  uint64_t tile_counts;   // uint[direction_count][tiles_per_side][tiles_per_side]
  uint64_t tile_starts;   // the same: where the tile's list begins
  uint64_t lists;         // uint[list_capacity]: polygons
  uint64_t active_tiles;  // uint[tile_count][2]: tile, length of its list
  uint64_t status;        // BinStatus
  uint polygon_count;
  uint corner_count;
  uint tiles_per_side;
  uint tile_count;
  uint list_capacity;
  uint scatter;              // 0 counts, 1 fills the lists
  uint rows_per_invocation;  // of tiles
};

struct PeelTilesArgs {
  uint64_t polygons;
  uint64_t edges;
  uint64_t projected;
  uint64_t tile_starts;
  uint64_t lists;
  uint64_t active_tiles;
  uint64_t status;
  uint64_t counters;
  uint polygon_count;
  uint corner_count;
  uint tiles_per_side;
  uint active_tile_count;
  uint id_count;
  uint two_sided;
};

// A cell has 8 x 8 blocks, one bit each: where the previous layer has no polygon, nothing is behind it, and polygons that can cover points of
// no other blocks are not drawn.
SHARED_FUNCTION uint blockAlong(uint in_cell, uint cell_size) { return in_cell * 8u / cell_size; }

// Counters of ids i <= j as the rows of an upper triangle, each row followed by the row's environment (column id_count)
// and leak (column id_count + 1).
SHARED_FUNCTION uint64_t counterIndex(uint i, uint column, uint id_count) {
  uint64_t row = uint64_t(i);
  return row * uint64_t(id_count + 2u) - row * (row + uint64_t(1u)) / uint64_t(2u) + uint64_t(column);
}

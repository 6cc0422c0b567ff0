// In this part of peel.glsl a workgroup finds its tile and loads samples of it. It leaves the rest of a tile to another
// dispatch where the tile has too many polygons for one.

// Appends the rest of the tile to the unfinished tiles. Returns where the layers that this invocation's samples have
// reached go in args.reached_next.
//   In: place: the tile's index in the list of active tiles; first_sample, first_meeting: see UnfinishedTile
uint leaveTile(uint place, uint first_sample, uint first_meeting, uint lane) {
  uint index = 0u;
  if (lane == 0u) {
    index = atomicAdd(Status(args.status).at.unfinished, 1u);
    UnfinishedTile rest;
    rest.tile = place;
    rest.first_sample = first_sample;
    rest.first_meeting = first_meeting;
    UnfinishedTiles(args.unfinished).at[index] = rest;
  }
  return (subgroupShuffle(index, 0u) * gl_WorkGroupSize.x + lane) * uint(kSteps);
}

// Leaves the samples from number `first` on to another dispatch, with the layers that the present samples have reached.
void leaveForLater(uint place, uint first, uint first_meeting, uint lane) {
  uint reached_at = leaveTile(place, first, first_meeting, lane);
  [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
    if (k < kSteps) Longs(args.reached_next).at[reached_at + uint(k)] = open[k] ? last[k] : kNoLayer;
    open[k] = false;
  }
}

// Finds the workgroup's tile. Returns false where there is none.
//   Out: place: the tile's index in the list of active tiles; first, first_meeting: see UnfinishedTile, 0 in a new
//     tile; resume: 0 in a new tile, else 1 + the index in args.reached where its layers begin
bool findTile(uint lanes, out uint place, out uint first, out uint first_meeting, out uint resume) {
  uint group = gl_WorkGroupID.y * kGroupsPerRow + gl_WorkGroupID.x;
  bool found;
  place = group;
  first = first_meeting = resume = 0u;
  if (args.resumes == 0u) {
    uint active_tiles = Status(args.status).at.active_tiles;
    found = place < active_tiles && active_tiles < kListsOverflowed;
  } else {
    found = group < args.resumes;
    if (found) {
      UnfinishedTile rest = UnfinishedTiles(args.tiles).at[group];
      resume = group * lanes * uint(kSteps) + 1u;
      place = rest.tile;
      first = rest.first_sample;
      first_meeting = rest.first_meeting;
    }
  }
  return found;
}

Tile fetchTile(uint place) {
  uvec4 texel = texelFetch(tile_texels, int(kTileTexels * place)),
        corner = texelFetch(tile_texels, int(kTileTexels * place + 1u));
  uvec2 fragments_at = kFragments ? texelFetch(tile_texels, int(kTileTexels * place + 2u)).xy : uvec2(0);
  block = corner.w;
  return Tile(texel.x, texel.y, texel.z, texel.w, ivec2(corner.xy),
              kScanlines ? rowsAtOnce(texel.y, kTileRows) : kTileRows, fragments_at.x, fragments_at.y,
              kSorted && corner.z != 0u);
}

// Loads the samples from number `first` on, one for every lane and step. With scanlines it moves list_begin and
// list_end, so that they bound the spans of `window` that reach these samples.
void loadSamples(Tile tile, uint first, uint sample_count, uint resume, uint lane, inout uint list_begin,
                 inout uint list_end, inout bool cut) {
  const uint lanes = gl_WorkGroupSize.x;
  [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
    open[k] = k < kSteps && first + lane < sample_count && sample_at.row + k * rowsPerStep() < int(kTileRows);
    last[k] = resume == 0u || k >= kSteps ? 0ul : Longs(args.reached).at[resume - 1u + lane * uint(kSteps) + uint(k)];
    open[k] = open[k] && last[k] != kNoLayer;
    fresh = (k == 0 ? 0u : fresh) | (open[k] && last[k] == 0ul ? 1u << k : 0u);
  }
  sample_at.weight = tile.weight;
  if (kScanlines) {
    uint at = min(first + lane, sample_count - 1u), begin = ends[at], end = ends[at + 1u];
    uint from = positionOf(begin), to = positionOf(end);
    sample_at.position = (from + to - 1u) >> 1;  // the middle, for polygons that meet at an end have one depth there
    sample_at.column = int(sample_at.position % kRowWidth);
    sample_at.weight *= to - from;
    if (from / kRowWidth != (to - 1u) / kRowWidth) fresh = 0u;  // between two rows: not counted as a sample
    list_begin = dropEnded(list_begin, list_end, positionOf(subgroupShuffle(begin, 0u)), lane, cut);
    list_end = begunBefore(subgroupShuffle(end, lanes - 1u));
  }
}

void clearLayers() {
  [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
    [[unroll]] for (int m = 0; m < kLayersKept; ++m) nearest[k][m] = kNoLayer;
    lost[k] = kNoLayer;
    farthest_emitter[k] = farthest_receiver[k] = 0ul;
  }
}

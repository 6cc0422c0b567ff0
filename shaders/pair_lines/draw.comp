#version 460
#extension GL_GOOGLE_include_directive : require
// A team of 16 invocations draws one portion of a pair's lines: each invocation draws one line of every block. A
// workgroup has four teams.
//   In: LinePortionData portions[portion_count], LineTaskData tasks[], LinePairData pairs[], ObstacleData obstacles[]
//   Out: LinePortionSums sums[portion_count], the same bits as LineDrawer's (host/pair_lines/draw_lines.cpp)
#include "pair_lines.glsl"

layout(local_size_x = kPairLinesGroup) in;
layout(push_constant, scalar) uniform Push { DrawLinesArgs pushed; };

shared uint sobol[4 * 32];
shared LinePairData pairs[kTeams];
shared ObstacleData obstacles[kTeams][kTileObstacles];
shared uint most_obstacles;  // the largest obstacle_count of the workgroup's tasks
shared float sums[kPairLinesGroup];

// Each load from a buffer is a separate function, because glslang crashes where a `precise` result is computed from a
// load directly.
LineTaskData loadTask(uint64_t tasks, uint index) { return Tasks(tasks).at[index]; }
LineEndData loadFirst(uint64_t from, uint index) { return Pairs(from).at[index].first; }
LineEndData loadSecond(uint64_t from, uint index) { return Pairs(from).at[index].second; }
vec3 loadAxis(uint64_t from, uint index, uint axis) { return Pairs(from).at[index].axes[axis]; }
vec2 loadRange(uint64_t from, uint index, uint axis) { return Pairs(from).at[index].ranges[axis]; }
float loadStart(uint64_t from, uint index, uint bin) { return Pairs(from).at[index].starts[bin]; }
float loadScale(uint64_t from, uint index, uint bin) { return Pairs(from).at[index].scales[bin]; }
ObstacleData loadObstacle(uint64_t from, uint index) { return Obstacles(from).at[index]; }

// A Line goes from p to q = p + d. Where `open` is not above 0, the line starts or ends on a back or misses the second
// patch, and weighs nothing.
struct Line {
  vec3 p, q, d;
  float weight, open;
};

// Returns one coordinate of a scrambled Sobol' point, in [0, 1) (Burley 2020).
float scrambled(uint digits, uint seed) {
  uint x = digits ^ (digits * 0x3d20adeau);
  x += seed;
  x *= seed >> 16 | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  precise float number = float(bitfieldReverse(x) >> 8) * kDigit;
  return number;
}

precise float beyond(vec4 edges[4], uint count, vec3 at) {
  precise float most = dotInOrder(edges[0].xyz, at) + edges[0].w;
  [[unroll]] for (uint e = 1u; e < 4u; ++e) {
    precise float over = dotInOrder(edges[e].xyz, at) + edges[e].w;
    most = e < count ? greatest(most, over) : most;
  }
  return most;
}

Line drawPoints(uint team, vec4 u) {
  Line line;
  float density_p, density_q;
  line.p = pointOn(pairs[team].first, u.x, u.y, density_p);
  line.q = pointOn(pairs[team].second, u.z, u.w, density_q);
  precise vec3 d = line.q - line.p;
  line.d = d;
  precise float leaving = dotInOrder(pairs[team].first.normal, d), arriving = -dotInOrder(pairs[team].second.normal, d);
  float inverse = reciprocal(greatest(dotInOrder(d, d), kLeastSquare));
  line.open = least(leaving, arriving);
  precise float weight = (leaving * inverse) * (arriving * inverse) * (density_p * density_q);
  line.weight = weight;
  return line;
}

void warp(uint team, uint axis, inout float u, inout float stretch) {
  uint first = axis * kWarpBins;
  precise float warped = u * pairs[team].scales[first];
  float scale = pairs[team].scales[first];
  for (uint bin = 1u; bin < kWarpBins; ++bin) {
    precise float moved = float(bin) * 0.125 + (u - pairs[team].starts[first + bin]) * pairs[team].scales[first + bin];
    bool is_reached = u >= pairs[team].starts[first + bin];
    warped = is_reached ? moved : warped;
    scale = is_reached ? pairs[team].scales[first + bin] : scale;
  }
  u = warped;
  precise float stretched = stretch * scale;
  stretch = stretched;
}

Line drawAngles(uint team, vec4 u) {
  Line line;
  float at[2] = {u.x, u.y}, stretch = 1.0, density_p;
  for (uint axis = 0u; axis < 2u; ++axis) warp(team, axis, at[axis], stretch);
  vec3 p = pointOn(pairs[team].first, at[0], at[1], density_p);
  precise float over = dotInOrder(pairs[team].second.normal, p) - pairs[team].second.offset,
                height = greatest(over, kLeast);
  float aside[2], turn[2];
  [[unroll]] for (uint axis = 0u; axis < 2u; ++axis) {
    float foot = dotInOrder(pairs[team].axes[axis], p);
    precise float to_low = pairs[team].ranges[axis].x - foot, to_high = pairs[team].ranges[axis].y - foot;
    precise float low = arcTangent(to_low, height), high = arcTangent(to_high, height);
    precise float turned = high - low, angle = low + u[2u + axis] * turned;
    precise float moved = height * tangent(angle);
    turn[axis] = turned, aside[axis] = moved;
  }
  precise vec3 d = aside[0] * pairs[team].axes[0] + aside[1] * pairs[team].axes[1] - height * pairs[team].second.normal;
  precise vec3 q = p + d;
  line.p = p, line.q = q, line.d = d;
  float leaving = dotInOrder(pairs[team].first.normal, d), inverse = reciprocal(dotInOrder(d, d));
  precise float reached = over - kLeast;
  line.open = least(least(reached, leaving), -beyond(pairs[team].second.edges, pairs[team].second.edge_count, q));
  precise float spread = density_p * stretch * (leaving * reciprocal(height));
  [[unroll]] for (uint axis = 0u; axis < 2u; ++axis) spread =
      spread * (turn[axis] * ((height * height + aside[axis] * aside[axis]) * inverse));
  line.weight = spread;
  return line;
}

Line drawContact(uint team, vec4 u) {
  Line line;
  line.p = line.q = pointOn(pairs[team].first, u.x, u.y, line.weight);
  line.d = vec3(0);
  line.open = -beyond(pairs[team].second.edges, pairs[team].second.edge_count, line.p);
  return line;
}

// Returns a number that is at most 0 where obstacle k blocks the line, and above 0 elsewhere (docs/method.md, section
// 13).
float passing(uint team, uint k, Line line) {
  uint place = obstacles[team][k].place;
  precise vec3 x;
  precise float most, size = 1.0;
  if (place == kBetween) {
    vec4 plane = obstacles[team][k].plane;
    precise float at_p = dotInOrder(plane.xyz, line.p) + plane.w;
    float slope = dotInOrder(plane.xyz, line.d), t = slope < 0.0 ? at_p : -at_p;
    size = slope < 0.0 ? -slope : slope;
    x = size * line.p + t * line.d;
    precise float before_q = t + kLeastSquare - size;
    most = greatest(-t, before_q);
  } else {
    x = place == kOverFirst ? line.p : line.q;
    most = -kFarAway;
  }
  for (uint e = 0u; e < obstacles[team][k].edge_count; ++e) {
    vec4 edge = obstacles[team][k].edges[e];
    precise float over = dotInOrder(edge.xyz, x) + edge.w * size;
    most = greatest(most, over);
  }
  return most;
}

// Returns direction number `bit` of the four dimensions.
uvec4 sobolOf(uint bit) { return uvec4(sobol[bit], sobol[32u + bit], sobol[64u + bit], sobol[96u + bit]); }

// Returns the sum over a team's lanes, in lane 0. It adds lanes 8 apart first, then 4, 2 and 1, as the host does.
float sumOfTeam(float mine) {
  uint at = gl_LocalInvocationIndex, lane = at % kBlockLanes;
  barrier();
  sums[at] = mine;
  for (uint half_lanes = kBlockLanes / 2u; half_lanes > 0u; half_lanes /= 2u) {
    barrier();
    if (lane < half_lanes) {
      precise float both = sums[at] + sums[at + half_lanes];
      sums[at] = both;
    }
  }
  return sums[at];
}

void loadShared(DrawLinesArgs args, uint team, uint lane, uint task, uint obstacle_count) {
  if (gl_LocalInvocationIndex == 0u) most_obstacles = 0u;
  for (uint k = gl_LocalInvocationIndex; k < 4u * 32u; k += kPairLinesGroup) sobol[k] = Sobol(args.sobol).at[k];
  if (lane == 0u) pairs[team].first = loadFirst(args.pairs, task);
  else if (lane == 1u) pairs[team].second = loadSecond(args.pairs, task);
  else if (lane < 4u) {
    uint axis = lane - 2u;
    pairs[team].axes[axis] = loadAxis(args.pairs, task, axis);
    pairs[team].ranges[axis] = loadRange(args.pairs, task, axis);
  }
  pairs[team].starts[lane] = loadStart(args.pairs, task, lane);
  pairs[team].scales[lane] = loadScale(args.pairs, task, lane);
  barrier();
  if (lane == 0u) atomicMax(most_obstacles, obstacle_count);
  barrier();
}

void main() {
  DrawLinesArgs args = pushed;
  uint team = gl_LocalInvocationIndex / kBlockLanes, lane = gl_LocalInvocationIndex % kBlockLanes;
  uint index = gl_WorkGroupID.x * kTeams + team;
  bool is_portion = index < args.portion_count;
  LinePortionData portion = LinePortionData(0u, 0u, 0u);
  if (is_portion) portion = Portions(args.portions).at[index];
  LineTaskData task = loadTask(args.tasks, portion.task);
  uint obstacle_count = is_portion ? task.obstacle_count : 0u;
  loadShared(args, team, lane, portion.task, obstacle_count);

  uvec4 first_digits = uvec4(0);
  [[unroll]] for (uint k = 0u; k < 4u; ++k) if ((lane >> k & 1u) != 0u) first_digits ^= sobolOf(k);
  for (uint gray = portion.first ^ portion.first >> 1, k = 4u; gray != 0u; gray >>= 1, ++k)
    if ((gray & 1u) != 0u) first_digits ^= sobolOf(k);

  // Obstacles are tested kTileObstacles at a time, and lines are drawn again each time. Few tasks have more obstacles.
  uint blocked = 0u;  // bit k is set where this lane's line of the portion's block k is blocked
  precise float facing = 0.0, weights = 0.0, squares = 0.0;
  uint tile_count = max(1u, (most_obstacles + kTileObstacles - 1u) / kTileObstacles);
  for (uint tile = 0u; tile < tile_count; ++tile) {
    uint first = min(tile * kTileObstacles, obstacle_count), count = min(kTileObstacles, obstacle_count - first);
    barrier();
    if (lane < count) obstacles[team][lane] = loadObstacle(args.obstacles, task.first_obstacle + first + lane);
    barrier();
    bool is_last = tile + 1u == tile_count;
    uvec4 digits = first_digits;
    for (uint block = portion.first; block < portion.end; ++block) {
      vec4 u = vec4(scrambled(digits.x, task.scrambles[0]), scrambled(digits.y, task.scrambles[1]),
                    scrambled(digits.z, task.scrambles[2]), scrambled(digits.w, task.scrambles[3]));
      digits ^= sobolOf(4u + uint(findLSB(block + 1u)));
      Line line;
      if (task.way == kByPoints) line = drawPoints(team, u);
      else if (task.way == kByAngles) line = drawAngles(team, u);
      else line = drawContact(team, u);
      uint bit = 1u << block - portion.first;
      for (uint k = 0u; k < count && (blocked & bit) == 0u; ++k)
        if (passing(team, k, line) <= 0.0) blocked |= bit;
      if (!is_last) continue;
      precise float weight = least(task.unit * line.weight, kMostWeight);
      weight = line.open > 0.0 ? weight : 0.0;
      weights = weights + weight;
      squares = squares + weight * weight;
      facing = facing + ((blocked & bit) != 0u ? 0.0 : weight);
    }
  }
  float of_facing = sumOfTeam(facing), of_all = sumOfTeam(weights), of_squares = sumOfTeam(squares);
  if (is_portion && lane == 0u) Sums(args.sums).at[index] = LinePortionSums(of_facing, of_all, of_squares);
}

// Votes and sums over the invocations of a workgroup that is one subgroup go by shuffles. Software devices make loops
// over invocations of the built-in ones, and unroll only loops that count up by one.
const uint kDoublings = 6u;  // to 64 invocations

bool anyOf(bool value) {
  uint any = value ? 1u : 0u;
  [[unroll]] for (uint k = 0u; k < kDoublings; ++k) if (1u << k < gl_WorkGroupSize.x) any |=
      subgroupShuffle(any, gl_SubgroupInvocationID ^ 1u << k);
  return any != 0u;
}

// Returns the sum over this invocation and those before it; `all`: over all.
uint sumSoFar(uint value, out uint all) {
  uint lane = gl_SubgroupInvocationID;
  [[unroll]] for (uint k = 0u; k < kDoublings; ++k) if (1u << k < gl_WorkGroupSize.x) {
    uint before = subgroupShuffle(value, lane - min(lane, 1u << k));
    value += lane >= 1u << k ? before : 0u;
  }
  all = subgroupShuffle(value, gl_WorkGroupSize.x - 1u);
  return value;
}

// Returns the least of this invocation and the later ones.
uint leastFrom(uint value) {
  uint lane = gl_SubgroupInvocationID;
  [[unroll]] for (uint k = 0u; k < kDoublings; ++k) if (1u << k < gl_WorkGroupSize.x) value =
      min(value, subgroupShuffle(value, min(lane + (1u << k), gl_WorkGroupSize.x - 1u)));
  return value;
}

// Votes and sums over the invocations of a workgroup that is one subgroup are made of shuffles here. Software devices
// compile the built-in ones (subgroupAny, subgroupAdd) to loops over invocations. They unroll only loops that count up
// by one.
const uint kDoublings = 6u;  // steps that reach all of up to 64 invocations, each twice as far as the one before

// Returns whether the value is true in any invocation.
bool anyOf(bool value) {
  uint any = value ? 1u : 0u;
  [[unroll]] for (uint k = 0u; k < kDoublings; ++k) if (1u << k < gl_WorkGroupSize.x) any |=
      subgroupShuffle(any, gl_SubgroupInvocationID ^ 1u << k);
  return any != 0u;
}

// Returns the sum of the values of this invocation and of all invocations before it.
//   Out: all: the sum of the values of all invocations of the workgroup
uint sumSoFar(uint value, out uint all) {
  uint lane = gl_SubgroupInvocationID;
  [[unroll]] for (uint k = 0u; k < kDoublings; ++k) if (1u << k < gl_WorkGroupSize.x) {
    uint before = subgroupShuffle(value, lane - min(lane, 1u << k));
    value += lane >= 1u << k ? before : 0u;
  }
  all = subgroupShuffle(value, gl_WorkGroupSize.x - 1u);
  return value;
}

// Returns the least value of this invocation and all invocations after it.
uint leastFrom(uint value) {
  uint lane = gl_SubgroupInvocationID;
  [[unroll]] for (uint k = 0u; k < kDoublings; ++k) if (1u << k < gl_WorkGroupSize.x) value =
      min(value, subgroupShuffle(value, min(lane + (1u << k), gl_WorkGroupSize.x - 1u)));
  return value;
}

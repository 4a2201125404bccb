// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Sums over a workgroup, always in the same order.
shared vec4 reduce_scratch[LOCAL_SIZE_X * LOCAL_SIZE_Y];

// Every invocation of the workgroup must call it; all get the sum.
vec4 SumOfGroup(vec4 value) {
  uint i = gl_LocalInvocationIndex;
  reduce_scratch[i] = value;
  barrier();
  for (uint half_count = LOCAL_SIZE_X * LOCAL_SIZE_Y / 2; half_count > 0u; half_count /= 2u) {
    if (i < half_count) {
      reduce_scratch[i] += reduce_scratch[i + half_count];
    }
    barrier();
  }
  vec4 sum = reduce_scratch[0];
  barrier();
  return sum;
}

uint GroupIndex() {
  return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
}

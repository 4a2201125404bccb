// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// A vector with one component set, without dynamic indexing, which would place the vector in
// memory.
vec4 AtComponent(int i, float value) {
  return vec4(equal(ivec4(i), ivec4(0, 1, 2, 3))) * value;
}

// The stored luminances of all signals at a pixel; 0 outside the image.
vec4 LuminancesAt(texture2DArray light, ivec2 p) {
  vec4 luminance = vec4(0.0f);
  for (int s = 0; Inside(p) && s < SignalCount(); ++s) {
    luminance += AtComponent(s, texelFetch(light, ivec3(p, s), 0).x);
  }
  return luminance;
}

// Sums over a workgroup, always in the same order.
shared vec4 reduce_scratch[LOCAL_SIZE_X * LOCAL_SIZE_Y];

// The sum over the workgroup, for all its invocations, which all must call this.
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

// The sum of the partials of all workgroups of an earlier pass. which: 0 the first of each
// workgroup, 1 the second. Several loads are in flight together, since a single workgroup waits for
// all of them.
vec4 SumOfPartials(uint groups, uint which) {
  const uint kThreads = LOCAL_SIZE_X * LOCAL_SIZE_Y;
  const uint kLoads = 8u;
  vec4 sum = vec4(0.0f);
  for (uint first = gl_LocalInvocationIndex; first < groups; first += kLoads * kThreads) {
    vec4 loaded[kLoads];
    [[unroll]] for (uint i = 0u; i < kLoads; ++i) {
      uint group = first + i * kThreads;
      loaded[i] = group < groups ? partials[2u * group + which] : vec4(0.0f);
    }
    [[unroll]] for (uint i = 0u; i < kLoads; ++i) {
      sum += loaded[i];
    }
  }
  return SumOfGroup(sum);
}

uint GroupIndex() {
  return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
}

// Stores the sum of the workgroup's luminances of new samples, for update_compression, if there is
// no history yet. Every invocation of the workgroup must call this.
void MeasureNewLight(vec4 luminance) {
  if (with_compressed != 0 && has_history == 0) {
    luminance = SumOfGroup(luminance);
    if (gl_LocalInvocationIndex == 0u) {
      partials[2u * GroupIndex()] = luminance;
    }
  }
}

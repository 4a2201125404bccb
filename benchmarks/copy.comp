// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Copies a buffer, 16 bytes per invocation, to measure the memory bandwidth of shaders. Driver
// copies may use a slower copy engine.
layout(local_size_x = 128) in;
layout(set = 0, binding = 0, std430) readonly buffer From {
  uvec4 from[];
};
layout(set = 0, binding = 1, std430) writeonly buffer To {
  uvec4 to[];
};
layout(push_constant) uniform Push {
  uint count;
};

void main() {
  uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  uint i = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
  if (i < count) {
    to[i] = from[i];
  }
}

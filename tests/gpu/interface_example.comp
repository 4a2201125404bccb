// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_EXT_samplerless_texture_functions : require

// Resources of every kind that the filter's shaders have, for the reader of interfaces.
layout(local_size_x = 16, local_size_y = 4) in;
layout(constant_id = 0) const bool kSquared = true;
layout(constant_id = 3) const int kColumns = 5;
layout(constant_id = 4) const float kScale = 1.5f;

struct Inner {
  float low;
  float high;
  int count;
  uint mask;
};
layout(set = 0, binding = 0) uniform texture2D source;
layout(set = 0, binding = 1) uniform utexture2DArray ids;
layout(set = 0, binding = 2, rg32ui) writeonly uniform uimage2D ids_out;
layout(set = 0, binding = 3, r16f) uniform image2DArray both;
layout(set = 0, binding = 4, std140) uniform Parameters {
  int width;
  Inner inner;
  float last;
};
layout(set = 1, binding = 0, std430) readonly buffer OnlyRead {
  vec2 pairs[3];
  float rest[];
};
layout(set = 1, binding = 1, std430) writeonly buffer OnlyWritten {
  uvec4 written[];
};
layout(set = 1, binding = 2, std430) buffer Counted {
  uint counter;
};
layout(set = 1, binding = 3) uniform texture2D passed;
layout(set = 1, binding = 7) uniform texture2D never_used;
layout(push_constant) uniform Push {
  float offset;
  int level;
};

shared vec4 tile[4 * (kColumns + 2)];
shared uint flag;

vec4 NeverCalled(ivec2 p) {
  return texelFetch(never_used, p, 0);
}

float FirstOf(texture2D image, ivec2 p) {
  return texelFetch(image, p, 0).x;
}

void Write(ivec2 p, float value) {
  written[p.x] = uvec4(uint(value));
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID);
  tile[p.x % 4] = texelFetch(source, p, 0) * kScale;
  flag = texelFetch(ids, ivec3(p, level), 0).x;
  barrier();
  float value =
      tile[p.y % 4].x + inner.high + pairs[1].y + rest[width] + offset + FirstOf(passed, p);
  value = kSquared ? value * value : value;
  Write(p, value);
  atomicAdd(counter, flag);
  imageStore(ids_out, p, uvec4(flag));
  imageStore(both, ivec3(p, 0), imageLoad(both, ivec3(p, 1)) + value);
}

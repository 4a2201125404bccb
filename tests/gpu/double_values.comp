// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_EXT_samplerless_texture_functions : require

// Twice the values of an image, times a constant, plus the push constant.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint kFactor = 1;
layout(set = 0, binding = 0) uniform texture2DArray source;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2DArray result;
layout(push_constant) uniform Push {
  float offset;
};

void main() {
  ivec3 p = ivec3(gl_GlobalInvocationID);
  ivec3 size = imageSize(result);
  if (p.x < size.x && p.y < size.y) {
    vec4 value = texelFetch(source, p, 0);
    imageStore(result, p, 2.0 * float(kFactor) * value + offset);
  }
}

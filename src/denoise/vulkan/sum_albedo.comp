// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// sum_albedo: see stages/sum_albedo.h. Writes the range of each single block; antialias extends it
// to 3x3 blocks and tests IsBesideImage, for which the fourth channels have logarithms of the
// virtual images' depths.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/new_light.glsl"
#include "denoise/stages/sum_albedo_shared.h"

layout(set = 1, binding = 0, LIGHT_FORMAT) writeonly uniform image2D sum_out;
layout(set = 1, binding = 1, LIGHT_FORMAT) writeonly uniform image2DArray range_out;  // low, high

// A workgroup covers whole blocks.
shared vec4 tile[LOCAL_SIZE_Y][LOCAL_SIZE_X];

vec3 Usable(vec3 albedo) {
  return max(vec3(IsFinite(albedo.x) ? albedo.x : 0.0f, IsFinite(albedo.y) ? albedo.y : 0.0f,
                  IsFinite(albedo.z) ? albedo.z : 0.0f),
             vec3(0.0f));
}

// Logarithm of the depth of a pixel's virtual image.
float PlaceOfImage(ivec2 p) {
  float depth = antialias.image_albedo != 0 ? texelFetch(specular_albedo_image, p, 0).w : 0.0f;
  return depth > 0.0f ? clamp(log2(depth), -kFarthestImage, kFarthestImage) : kNoImage;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  // Pixels outside the image repeat its edge, which is in their block.
  ivec2 q = ClampToPicture(p);
  vec3 sum = vec3(0.0f);
  for (int i = 0; i < 3; ++i) {
    if ((own_albedos >> i & 1) != 0) {
      sum += Usable(LoadAlbedo(i, q));
    }
  }
  vec4 stored = Stored(vec4(ClampLight(sum), PlaceOfImage(q)));
  ivec2 local = ivec2(gl_LocalInvocationID.xy);
  tile[local.y][local.x] = stored;
  if (Inside(p)) {
    imageStore(sum_out, p, stored);
  }
  barrier();
  if (!Inside(p) || local.x % kAlbedoBlock != 0 || local.y % kAlbedoBlock != 0) {
    return;
  }
  vec4 low = stored;
  vec4 high = stored;
  for (int y = 0; y < kAlbedoBlock; ++y) {
    for (int x = 0; x < kAlbedoBlock; ++x) {
      low = min(low, tile[local.y + y][local.x + x]);
      high = max(high, tile[local.y + y][local.x + x]);
    }
  }
  ivec2 block = p / kAlbedoBlock;
  imageStore(range_out, ivec3(block, 0), low);
  imageStore(range_out, ivec3(block, 1), high);
}

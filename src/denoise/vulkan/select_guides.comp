// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// select_guides: see stages/select_guides.h. For a frame on the device.
#include "denoise/vulkan/layer_images.glsl"
#include "denoise/picture_motion_shared.h"
#include "denoise/stages/select_guides_shared.h"

layout(set = 0, binding = 0) uniform texture2D surface_depth;
layout(set = 0, binding = 1) uniform texture2D surface_normal;
layout(set = 0, binding = 2) uniform texture2D surface_motion;
layout(set = 0, binding = 3) uniform utexture2D surface_id;
layout(set = 0, binding = 4) uniform texture2D surface_roughness;
layout(set = 0, binding = 5) uniform texture2D surface_previous_normal;
layout(set = 0, binding = 6) uniform texture2D diffuse_albedo;
layout(set = 0, binding = 7) uniform texture2D layer_albedo;  // divisor of the layer
layout(set = 0, binding = 8) uniform texture2D other_albedo;  // divisor of the other layer
layout(set = 0, binding = 9) uniform texture2D image_depth;
layout(set = 0, binding = 10) uniform texture2D image_normal;
layout(set = 0, binding = 11) uniform texture2D image_motion;
layout(set = 0, binding = 12) uniform utexture2D image_id;
layout(set = 0, binding = 13) uniform texture2D image_albedo;
layout(set = 0, binding = 14, r32f) writeonly uniform image2D depth_out;
layout(set = 0, binding = 15, rgba32f) writeonly uniform image2D normal_out;
layout(set = 0, binding = 16, rg32f) writeonly uniform image2D motion_out;
layout(set = 0, binding = 17, r32ui) writeonly uniform uimage2D id_out;
layout(set = 0, binding = 18, r32f) writeonly uniform image2D roughness_out;
// Fourth channel: ShownImage of picture_motion_shared.h.
layout(set = 0, binding = 19, rgba32f) writeonly uniform image2D albedo_out;
layout(set = 0, binding = 20, rgba32f) writeonly uniform image2D previous_normal_out;

layout(push_constant) uniform Push {
  float virtual_roughness;  // as in SelectGuidesParameters
  float image_side;
  float virtual_motion_roughness;
  int has_other_albedo;     // 0: it is black
  int has_previous_normal;  // 0: previous_normal_out must not be written
  int has_id;               // 0: ids are 0
  int has_image_albedo;     // 0: it is white
  int width;
  int height;
};

vec3 SelectedNormal(bool image, ivec2 p) {
  vec3 own = texelFetch(surface_normal, p, 0).xyz;
  vec3 seen = texelFetch(image_normal, p, 0).xyz;
  vec3 normal = image && IsNormalLength2(dot(seen, seen)) ? seen : own;
  return image ? image_side * normal : normal;
}

vec3 SelectedAlbedo(bool image, ivec2 p) {
  vec3 own = texelFetch(layer_albedo, p, 0).xyz;
  vec3 seen = has_image_albedo != 0 ? texelFetch(image_albedo, p, 0).xyz : vec3(1.0f);
  return image ? own * vec3(SeenAlbedo(seen.x), SeenAlbedo(seen.y), SeenAlbedo(seen.z)) : own;
}

bool ShowsLittleElseAt(ivec2 p, float own_depth, float depth) {
  vec3 diffuse = texelFetch(diffuse_albedo, p, 0).xyz;
  vec3 layer = texelFetch(layer_albedo, p, 0).xyz;
  vec3 other = has_other_albedo != 0 ? texelFetch(other_albedo, p, 0).xyz : vec3(0.0f);
  return ShowsLittleElse(own_depth, depth, Luminance709(diffuse.x, diffuse.y, diffuse.z),
                         Luminance709(layer.x, layer.y, layer.z),
                         Luminance709(other.x, other.y, other.z));
}

bool IsInside(ivec2 p, ivec2 size) {
  return p.x >= 0 && p.y >= 0 && p.x < size.x && p.y < size.y;
}

uint SurfaceId(ivec2 p) {
  return has_id != 0 ? texelFetch(surface_id, p, 0).x : 0u;
}

vec4 SumImageMotions(ivec2 p, vec3 normal, uint id, ivec2 size) {
  vec4 sums = vec4(0.0f);
  for (int v = -kReflectorStep; v <= kReflectorStep; v += kReflectorStep) {
    for (int u = -kReflectorStep; u <= kReflectorStep; u += kReflectorStep) {
      ivec2 q = p + ivec2(u, v);
      if (IsInside(q, size) && texelFetch(image_depth, q, 0).x > 0.0f &&
          IsSameReflector(normal, id, texelFetch(surface_normal, q, 0).xyz, SurfaceId(q))) {
        sums = AddImageMotion(
            sums, texelFetch(image_motion, q, 0).xy - texelFetch(surface_motion, q, 0).xy);
      }
    }
  }
  return sums;
}

// See image_motion.h.
vec2 ImageMotionOnSurface(ivec2 p, float depth, ivec2 size) {
  vec3 normal = texelFetch(surface_normal, p, 0).xyz;
  uint id = SurfaceId(p);
  vec4 sums = SumImageMotions(p, normal, id, size);
  vec2 offset = MeanImageMotion(sums);
  ivec2 q = p + ivec2(floor(offset + 0.5f));
  bool same = AreMotionsAlike(sums) && IsInside(q, size);
  q = clamp(q, ivec2(0), size - 1);
  same = same && IsSameReflector(normal, id, texelFetch(surface_normal, q, 0).xyz, SurfaceId(q)) &&
         IsAtSameDepth(depth, texelFetch(surface_depth, q, 0).x, offset);
  return same ? offset : vec2(0.0f);
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = ivec2(width, height);
  if (p.x >= size.x || p.y >= size.y) {
    return;
  }
  float own_depth = texelFetch(surface_depth, p, 0).x;
  float seen_depth = texelFetch(image_depth, p, 0).x;
  float roughness = texelFetch(surface_roughness, p, 0).x;
  bool image = ShowsImage(own_depth, seen_depth, roughness, virtual_roughness);
  float depth = image ? ImageDepth(seen_depth) : own_depth;
  bool has_light = !HasNoLight(texelFetch(layer_albedo, p, 0).xyz);
  vec2 motion = (image ? texelFetch(image_motion, p, 0) : texelFetch(surface_motion, p, 0)).xy;
  if (MayMoveWithImage(own_depth, seen_depth, roughness, virtual_roughness,
                       virtual_motion_roughness)) {
    motion += ImageMotionOnSurface(p, own_depth, size);
  }
  uint id = 0u;
  if (has_id != 0) {
    id = image ? texelFetch(image_id, p, 0).x : texelFetch(surface_id, p, 0).x;
  }
  float shown = ShownImage(depth, ShowsLittleElseAt(p, own_depth, depth));
  imageStore(depth_out, p, vec4(has_light ? depth : kNoSurface));
  imageStore(normal_out, p, vec4(SelectedNormal(image, p), 0.0f));
  imageStore(motion_out, p, vec4(motion, 0.0f, 0.0f));
  imageStore(id_out, p, uvec4(id));
  imageStore(roughness_out, p, vec4(image ? kRoughnessOfImage : roughness));
  imageStore(albedo_out, p, vec4(SelectedAlbedo(image, p), shown));
  if (has_previous_normal != 0) {
    vec3 before = texelFetch(surface_previous_normal, p, 0).xyz;
    imageStore(previous_normal_out, p, vec4(image ? vec3(0.0f) : before, 0.0f));
  }
}

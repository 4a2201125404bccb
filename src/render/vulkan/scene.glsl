// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The scene, in descriptor set 0 of all tracer shaders.
#include "core/shared.h"
#include "core/colour_shared.h"
#include "render/shared.h"
#include "render/geometry_shared.h"
#include "render/lens_shape_shared.h"
#include "render/vulkan/scene_shared.h"

layout(std430, set = 0, binding = 0) readonly buffer Nodes {
  BvhNode nodes[];
};
layout(std430, set = 0, binding = 1) readonly buffer Triangles {
  BvhTriangle triangles[];
};
layout(std430, set = 0, binding = 2) readonly buffer Placements {
  Placement placements[];
};
layout(std430, set = 0, binding = 3) readonly buffer Instances {
  GpuInstance instances[];
};
layout(std430, set = 0, binding = 4) readonly buffer Materials {
  GpuMaterial materials[];
};
layout(std430, set = 0, binding = 5) readonly buffer Textures {
  GpuTexture textures[];
};
layout(std430, set = 0, binding = 6) readonly buffer Texels {
  uint texels[];
};
// The arrays of all meshes.
layout(std430, set = 0, binding = 7) readonly buffer Words {
  uint words[];
};
layout(std430, set = 0, binding = 8) readonly buffer Energies {
  float energies[];
};
// The atlas of sampled textures (texture_atlas.h), in linear and in sRGB format.
layout(set = 0, binding = 9) uniform sampler2DArray plain_textures;
layout(set = 0, binding = 10) uniform sampler2DArray srgb_textures;

vec2 Vec2At(uint first) {
  return uintBitsToFloat(uvec2(words[first], words[first + 1u]));
}
vec3 Vec3At(uint first) {
  return uintBitsToFloat(uvec3(words[first], words[first + 1u], words[first + 2u]));
}
float FloatAt(uint place) {
  return uintBitsToFloat(words[place]);
}
GpuTextureRef TextureRefAt(uint first) {
  return GpuTextureRef(Vec3At(first), int(words[first + 3u]), Vec3At(first + 4u),
                       int(words[first + 7u]));
}
vec4 Vec4At(uint first) {
  return uintBitsToFloat(
      uvec4(words[first], words[first + 1u], words[first + 2u], words[first + 3u]));
}

uvec3 CornersOf(GpuInstance instance, uint primitive) {
  uint first = instance.indices + 3u * primitive;
  return uvec3(words[first], words[first + 1u], words[first + 2u]);
}

vec3 Weights(GpuHit hit) {
  return vec3(1.0f - hit.u - hit.v, hit.u, hit.v);
}

// Transforms a point by the matrix with rows x, y and z.
vec3 TransformPoint(vec4 x, vec4 y, vec4 z, vec3 p) {
  return vec3(dot(x.xyz, p) + x.w, dot(y.xyz, p) + y.w, dot(z.xyz, p) + z.w);
}
vec3 TransformVector(vec4 x, vec4 y, vec4 z, vec3 v) {
  return vec3(dot(x.xyz, v), dot(y.xyz, v), dot(z.xyz, v));
}

// -1 if the instance's transform mirrors, otherwise 1.
float Orientation(GpuInstance instance) {
  return instance.orientation;
}

struct WorldTriangle {
  vec3 p0, p1, p2;
};

WorldTriangle TriangleOf(GpuInstance instance, uint primitive) {
  uvec3 corner = CornersOf(instance, primitive);
  WorldTriangle t;
  t.p0 = TransformPoint(instance.world_x, instance.world_y, instance.world_z,
                        Vec3At(instance.positions + 3u * corner.x));
  t.p1 = TransformPoint(instance.world_x, instance.world_y, instance.world_z,
                        Vec3At(instance.positions + 3u * corner.y));
  t.p2 = TransformPoint(instance.world_x, instance.world_y, instance.world_z,
                        Vec3At(instance.positions + 3u * corner.z));
  return t;
}

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The layout of a scene in storage buffers, shared by C++ and GLSL (layout std430, where a vec3 and
// the scalar behind it share 16 bytes).
#ifndef STILLRAY_RENDER_VULKAN_SCENE_SHARED_H
#define STILLRAY_RENDER_VULKAN_SCENE_SHARED_H

#ifdef __cplusplus
#include <cstddef>

#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Four children with boxes on a grid of 8 bits per axis: 64 bytes, one cache line of every GPU,
// read as four vectors. A child's box spans origin + low * scale to origin + high * scale, and
// contains the subtree, also in float arithmetic as written; scale is a power of two per axis,
// stored as the exponent byte of a float (x lowest). Byte i of low_x is child i's.
struct BvhNode {
  vec3 origin;
  uint exponents;
  uvec4 children;
  uint low_x, low_y, low_z;
  uint high_x, high_y, high_z;
  uint unused_0, unused_1;
};

// A child is 0 (none, since the root is never a child), the index of a node, or a leaf: this bit,
// then 3 bits with the number of items minus one, then the index of the first item.
const uint kLeafBit = 0x80000000u;
const uint kLeafFirstMask = 0x0fffffffu;
const int kLeafCountShift = 28;
const int kMostLeafItems = 4;

// Entries of the traversal stack, one per ancestor node, for the top level and for both levels
// together; the builder limits the depth of trees accordingly.
const int kTopStack = 15;
const int kBottomStack = 32;
const int kStackSize = kTopStack + kBottomStack;

// A triangle in the space of its placement. `instance` is valid only for placements in world space.
struct BvhTriangle {
  vec3 p0;
  uint instance;
  vec3 p1;
  uint primitive;
  vec3 p2;
  uint see_through;  // 1: shadow rays evaluate its transmittance
};

// A placed bottom level: rows of the world-to-object matrix. instance == kNoInstance: the bottom
// level of all static instances, in world space.
struct Placement {
  vec4 to_object_x, to_object_y, to_object_z;
  uint root;
  uint instance;
  uint first_triangle;  // index of the bottom level's first triangle
  uint opaque_triangles;
};
const uint kNoInstance = 0xffffffffu;

// An instance of the scene: rows of its object-to-world matrix in this and the previous frame, and
// the offsets of its mesh's arrays in the words; kNoArray: none. Deforming instances have their own
// vertices; current and previous offsets are equal unless the shape has changed since the previous
// frame.
struct GpuInstance {
  vec4 world_x, world_y, world_z;
  vec4 previous_x, previous_y, previous_z;
  uint material;
  uint indices;    // 3 words per triangle
  uint positions;  // 3 words per vertex
  uint normals;    // 3
  uint tangents;   // 4
  uint uv_0;       // 2
  uint uv_1;       // 2
  uint colours;    // 4
  uint previous_positions;
  uint previous_normals;
  float orientation;  // -1 if the transform mirrors
  uint unused_0;
};
const uint kNoArray = 0xffffffffu;

// Whether the mesh has deformed since the previous frame.
SHARED_FN bool HasChangedShape(SHARED_IN(GpuInstance) instance) {
  return instance.previous_positions != instance.positions;
}

// TextureRef with the rows of its transform; texture -1: none.
struct GpuTextureRef {
  vec3 u_row;
  int texture;
  vec3 v_row;
  int uv_set;
};

struct GpuMaterial {
  vec4 base_colour;
  vec3 emission;
  float metallic;
  float roughness;
  float normal_scale;
  float alpha_cutoff;
  float transmission;
  vec3 attenuation_colour;
  float attenuation_distance;
  vec3 multiscatter_colour;
  float scatter_anisotropy;
  float ior;
  uint alpha_mode;  // kAlpha...
  uint double_sided;
  uint solid;
  uint glass_tables;  // offset of the five energy tables, if the material may be rough glass
  uint layers;        // offset of its GpuLayers in the words; kNoArray if it has none
  uint unused_0, unused_1;
  GpuTextureRef base_colour_texture;
  GpuTextureRef metallic_roughness_texture;
  GpuTextureRef normal_texture;
  GpuTextureRef emissive_texture;
  GpuTextureRef transmission_texture;
};

// The layers of a material (SurfaceLayers), stored in the words since few materials have any.
struct GpuLayers {
  vec3 specular_colour;
  float specular;
  float coat;
  float coat_roughness;
  float coat_normal_scale;
  float sheen_roughness;
  vec3 sheen_colour;
  float through;
  vec3 through_colour;
  float anisotropy;
  GpuTextureRef specular_texture;
  GpuTextureRef specular_colour_texture;
  GpuTextureRef coat_texture;
  GpuTextureRef coat_roughness_texture;
  GpuTextureRef coat_normal_texture;
  GpuTextureRef sheen_colour_texture;
  GpuTextureRef sheen_roughness_texture;
  GpuTextureRef through_texture;
  GpuTextureRef through_colour_texture;
  GpuTextureRef anisotropy_texture;
  vec2 anisotropy_turn;  // cosine and sine of the anisotropy rotation
  float film;            // 0: none
  float film_ior;
  GpuTextureRef film_texture;
  GpuTextureRef film_thickness_texture;
  vec2 film_thickness;  // minimum and maximum
};
// Offsets of members in words.
const uint kLayersSpecular = 3u;
const uint kLayersCoat = 4u;
const uint kLayersCoatRoughness = 5u;
const uint kLayersCoatNormalScale = 6u;
const uint kLayersSheenRoughness = 7u;
const uint kLayersSheenColour = 8u;
const uint kLayersThrough = 11u;
const uint kLayersThroughColour = 12u;
const uint kLayersAnisotropy = 15u;
const uint kLayersSpecularTexture = 16u;
const uint kLayersSpecularColourTexture = 24u;
const uint kLayersCoatTexture = 32u;
const uint kLayersCoatRoughnessTexture = 40u;
const uint kLayersCoatNormalTexture = 48u;
const uint kLayersSheenColourTexture = 56u;
const uint kLayersSheenRoughnessTexture = 64u;
const uint kLayersThroughTexture = 72u;
const uint kLayersThroughColourTexture = 80u;
const uint kLayersAnisotropyTexture = 88u;
const uint kLayersAnisotropyTurn = 96u;
const uint kLayersFilm = 98u;
const uint kLayersFilmIor = 99u;
const uint kLayersFilmTexture = 100u;
const uint kLayersFilmThicknessTexture = 108u;
const uint kLayersFilmThickness = 116u;

// Values of AlphaMode.
const uint kAlphaOpaque = 0u;
const uint kAlphaMask = 1u;
const uint kAlphaBlend = 2u;

struct GpuTexture {
  uint first;  // index of the first texel, RGBA from the lowest byte; for sampled textures the
               // position in the atlas: x in the lower, y in the upper 16 bits
  int width;
  int height;
  uint lookup;  // wrap_u, wrap_v in 2 bits each, then 1: nearest; layer of the atlas << kAtlasLayer
};
const int kAtlasLayer = 8;

// The texel array starts with the 256 values of the sRGB curve. If textures are sampled, the
// reciprocals of the atlas's width and height follow instead of texels.
const uint kSrgbTableSize = 256u;

// Energy tables of rough lobes: scale, offset, sheen (zeros if unused), scale and offset of
// anisotropic lobes (absent if unused), then the tables of each glass in the order of GlassEnergy.
const uint kEnergyTableWords = 1024u;
const uint kAnisotropicTables = 3u * kEnergyTableWords;
const uint kGlassTables = 5u;

// Device version of CameraView.
struct GpuView {
  vec3 position;
  float half_width;
  vec3 right;
  float half_height;
  vec3 up;
  float width;
  vec3 forward;
  float height;
  vec2 shift;
  float lens_radius;
  float inverse_focus;
};

struct GpuRay {
  vec3 origin;
  float end;       // hits beyond this distance are ignored
  vec3 direction;  // unit length
  uint unused_0;
};

// A hit at the point (1 - u - v) v0 + u v1 + v v2 of the triangle; without a hit, t is `end`.
struct GpuHit {
  float t;
  float u;
  float v;
  uint instance;  // kNoInstance without a hit
  uint primitive;
};

STILLRAY_RENDER_END

#ifdef __cplusplus
namespace stillray::render {
static_assert(sizeof(BvhNode) == 64);
static_assert(sizeof(BvhTriangle) == 48);
static_assert(sizeof(Placement) == 64);
static_assert(sizeof(GpuInstance) == 144);
static_assert(sizeof(GpuTextureRef) == 32);
static_assert(sizeof(GpuMaterial) == 272);
static_assert(offsetof(GpuLayers, specular) == 4 * kLayersSpecular);
static_assert(offsetof(GpuLayers, coat) == 4 * kLayersCoat);
static_assert(offsetof(GpuLayers, coat_roughness) == 4 * kLayersCoatRoughness);
static_assert(offsetof(GpuLayers, coat_normal_scale) == 4 * kLayersCoatNormalScale);
static_assert(offsetof(GpuLayers, coat_texture) == 4 * kLayersCoatTexture);
static_assert(offsetof(GpuLayers, coat_roughness_texture) == 4 * kLayersCoatRoughnessTexture);
static_assert(offsetof(GpuLayers, coat_normal_texture) == 4 * kLayersCoatNormalTexture);
static_assert(offsetof(GpuLayers, sheen_roughness) == 4 * kLayersSheenRoughness);
static_assert(offsetof(GpuLayers, sheen_colour) == 4 * kLayersSheenColour);
static_assert(offsetof(GpuLayers, sheen_colour_texture) == 4 * kLayersSheenColourTexture);
static_assert(offsetof(GpuLayers, sheen_roughness_texture) == 4 * kLayersSheenRoughnessTexture);
static_assert(offsetof(GpuLayers, through) == 4 * kLayersThrough);
static_assert(offsetof(GpuLayers, through_colour) == 4 * kLayersThroughColour);
static_assert(offsetof(GpuLayers, through_texture) == 4 * kLayersThroughTexture);
static_assert(offsetof(GpuLayers, through_colour_texture) == 4 * kLayersThroughColourTexture);
static_assert(offsetof(GpuLayers, anisotropy) == 4 * kLayersAnisotropy);
static_assert(offsetof(GpuLayers, anisotropy_texture) == 4 * kLayersAnisotropyTexture);
static_assert(offsetof(GpuLayers, anisotropy_turn) == 4 * kLayersAnisotropyTurn);
static_assert(offsetof(GpuLayers, film) == 4 * kLayersFilm);
static_assert(offsetof(GpuLayers, film_ior) == 4 * kLayersFilmIor);
static_assert(offsetof(GpuLayers, film_texture) == 4 * kLayersFilmTexture);
static_assert(offsetof(GpuLayers, film_thickness_texture) == 4 * kLayersFilmThicknessTexture);
static_assert(offsetof(GpuLayers, film_thickness) == 4 * kLayersFilmThickness);
static_assert(offsetof(GpuLayers, specular_texture) == 4 * kLayersSpecularTexture);
static_assert(offsetof(GpuLayers, specular_colour_texture) == 4 * kLayersSpecularColourTexture);
static_assert(sizeof(GpuTexture) == 16);
static_assert(sizeof(GpuView) == 80);
static_assert(sizeof(GpuRay) == 32);
static_assert(sizeof(GpuHit) == 20);
}  // namespace stillray::render
#endif

#endif  // STILLRAY_RENDER_VULKAN_SCENE_SHARED_H

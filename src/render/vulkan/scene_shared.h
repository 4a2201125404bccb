// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The layout of a scene in storage buffers: the same structures in C++ and in GLSL (layout std430,
// where a vec3 and the scalar behind it share 16 bytes).
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

// A child is 0 (none: roots are no children), the index of a node, or a leaf: this bit, then in 3
// bits the number of items minus one, then the index of the first one.
const uint kLeafBit = 0x80000000u;
const uint kLeafFirstMask = 0x0fffffffu;
const int kLeafCountShift = 28;
const int kMostLeafItems = 4;

// Entries of the traversal stack, one for each node above, of the top level and of a bottom level
// together; the builder limits trees to it.
const int kTopStack = 15;
const int kBottomStack = 32;
const int kStackSize = kTopStack + kBottomStack;

// In the space of its placement. `instance` is only valid where that is the world.
struct BvhTriangle {
  vec3 p0;
  uint instance;
  vec3 p1;
  uint primitive;
  vec3 p2;
  uint see_through;  // 1: shadow rays evaluate its transmittance
};

// A bottom level in the world. Rows of the matrix to its space; instance == kNoInstance: all static
// instances, in world space.
struct Placement {
  vec4 to_object_x, to_object_y, to_object_z;
  uint root;
  uint instance;
  uint first_triangle;  // of the bottom level
  uint opaque_triangles;
};
const uint kNoInstance = 0xffffffffu;

// An instance of the scene: rows of its matrix to the world, now and one frame ago, and the offsets
// of its mesh's arrays in the words; kNoArray: none. Instances that deform have vertices of their
// own; the offsets of the previous ones are the same unless the shape has changed since.
struct GpuInstance {
  vec4 world_x, world_y, world_z;
  vec4 previous_x, previous_y, previous_z;
  uint material;
  uint indices;    // 3 per triangle
  uint positions;  // 3 words per vertex
  uint normals;    // 3
  uint tangents;   // 4
  uint uv_0;       // 2
  uint uv_1;       // 2
  uint colours;    // 4
  uint previous_positions;
  uint previous_normals;
  float orientation;  // -1 if it is mirrored
  uint unused_0;
};
const uint kNoArray = 0xffffffffu;

// Whether the mesh's vertices have moved since the previous frame.
SHARED_FN bool HasChangedShape(SHARED_IN(GpuInstance) instance) {
  return instance.previous_positions != instance.positions;
}

// TextureRef: rows of its transform; texture -1: none.
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
  uint glass_tables;  // offset of its five tables, if it may be rough glass
  uint layers;        // offset of its GpuLayers in the words, if it has any; else kNoArray
  uint unused_0, unused_1;
  GpuTextureRef base_colour_texture;
  GpuTextureRef metallic_roughness_texture;
  GpuTextureRef normal_texture;
  GpuTextureRef emissive_texture;
  GpuTextureRef transmission_texture;
};

// What a material has beyond that: words, since few materials have it.
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
  vec2 anisotropy_turn;  // cosine and sine of its rotation
  float film;            // 0: none
  float film_ior;
  GpuTextureRef film_texture;
  GpuTextureRef film_thickness_texture;
  vec2 film_thickness;  // minimum and maximum
};
// Offsets in words.
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
  uint first;  // texel, RGBA from the lowest byte; of a sampled one its place in the atlas: x, then
               // y in the upper 16 bits
  int width;
  int height;
  uint lookup;  // wrap_u, wrap_v in 2 bits each, then 1: nearest; layer of the atlas << kAtlasLayer
};
const int kAtlasLayer = 8;

// The texels start with the 256 values of the sRGB curve. If textures are sampled, the reciprocals
// of the atlas's width and height follow, and no texels.
const uint kSrgbTableSize = 256u;

// Energy tables of rough lobes: scale, offset, sheen (zeros if there is none), scale and offset of
// anisotropic lobes (absent if there are none), then those of each glass in the order of
// GlassEnergy.
const uint kEnergyTableWords = 1024u;
const uint kAnisotropicTables = 3u * kEnergyTableWords;
const uint kGlassTables = 5u;

// CameraView.
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
  float end;       // hits beyond it are ignored
  vec3 direction;  // unit length
  uint unused_0;
};

// The point is (1 - u - v) v0 + u v1 + v v2 of the triangle; t is `end` without a hit.
struct GpuHit {
  float t;
  float u;
  float v;
  uint instance;  // or kNoInstance
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

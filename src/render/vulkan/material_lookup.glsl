// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Materials and textures at a hit, with the steps of the CPU version (SceneState, SampleTexture,
// SheetTransmittance). Needs scene.glsl.
#include "render/energy_shared.h"
#include "render/geometry_shared.h"
#include "render/ggx_shared.h"
#include "render/film_shared.h"
#include "render/sheen_shared.h"
#include "render/bsdf_shared.h"
#include "render/layers_shared.h"
#include "render/make_bsdf_shared.h"
#include "render/texture_shared.h"
#include "render/footprint_shared.h"

// 0: no material of the scene has layers, and their code is eliminated.
layout(constant_id = 0) const uint kWithLayers = 1u;
// 1: textures are sampled by the device's texture units.
layout(constant_id = 1) const uint kSampledTextures = 0u;

vec4 TexelAt(GpuTexture source, int x, int y, bool srgb) {
  uint texel = texels[source.first + uint(y) * uint(source.width) + uint(x)];
  uvec4 bytes = uvec4(texel, texel >> 8, texel >> 16, texel >> 24) & 255u;
  vec4 value = vec4(bytes) / 255.0f;
  if (srgb) {
    value.rgb = uintBitsToFloat(uvec3(texels[bytes.x], texels[bytes.y], texels[bytes.z]));
  }
  return value;
}

// A single filtered fetch from the atlas, instead of four texels and their sRGB decoding.
vec4 SampleAtlas(GpuTexture source, vec2 place, bool srgb) {
  vec2 first = vec2(float(source.first & 0xffffu), float(source.first >> 16));
  vec2 scale = uintBitsToFloat(uvec2(texels[kSrgbTableSize], texels[kSrgbTableSize + 1u]));
  vec3 at = vec3((first + place) * scale, float(source.lookup >> kAtlasLayer));
  return srgb ? textureLod(srgb_textures, at, 0.0f) : textureLod(plain_textures, at, 0.0f);
}

vec4 SampleTexture(GpuTexture source, vec2 uv, bool srgb) {
  float x = SafeCoordinate(uv.x * float(source.width));
  float y = SafeCoordinate(uv.y * float(source.height));
  int wrap_u = int(source.lookup & 3u);
  int wrap_v = int(source.lookup >> 2 & 3u);
  bool nearest = (source.lookup >> 4 & 1u) != 0u;
  if (kSampledTextures != 0u) {
    vec2 place = vec2(WrapCoordinate(x, float(source.width), wrap_u),
                      WrapCoordinate(y, float(source.height), wrap_v));
    if (nearest) {
      place = vec2(float(WrapTexel(FloorToInt(x), source.width, wrap_u)) + 0.5f,
                   float(WrapTexel(FloorToInt(y), source.height, wrap_v)) + 0.5f);
    }
    return SampleAtlas(source, place, srgb);
  }
  if (nearest) {
    return TexelAt(source, WrapTexel(FloorToInt(x), source.width, wrap_u),
                   WrapTexel(FloorToInt(y), source.height, wrap_v), srgb);
  }
  int left = FloorToInt(x - 0.5f);
  int top = FloorToInt(y - 0.5f);
  float fx = x - 0.5f - float(left);
  float fy = y - 0.5f - float(top);
  int x0 = WrapTexel(left, source.width, wrap_u);
  int x1 = WrapTexel(left + 1, source.width, wrap_u);
  int y0 = WrapTexel(top, source.height, wrap_v);
  int y1 = WrapTexel(top + 1, source.height, wrap_v);
  vec4 upper = TexelAt(source, x0, y0, srgb) * (1.0f - fx) + TexelAt(source, x1, y0, srgb) * fx;
  vec4 lower = TexelAt(source, x0, y1, srgb) * (1.0f - fx) + TexelAt(source, x1, y1, srgb) * fx;
  return upper * (1.0f - fy) + lower * fy;
}

// Texture value at the hit; 1 without a texture.
vec4 TextureValue(GpuTextureRef ref, GpuInstance instance, GpuHit hit, bool srgb) {
  if (ref.texture < 0) {
    return vec4(1.0f);
  }
  uint array = ref.uv_set == 0 ? instance.uv_0 : instance.uv_1;
  vec3 uv = vec3(0.0f, 0.0f, 1.0f);
  if (array != kNoArray) {
    uvec3 corner = CornersOf(instance, hit.primitive);
    vec3 weight = Weights(hit);
    uv.xy = Vec2At(array + 2u * corner.x) * weight.x + Vec2At(array + 2u * corner.y) * weight.y +
            Vec2At(array + 2u * corner.z) * weight.z;
  }
  return SampleTexture(textures[ref.texture], vec2(dot(ref.u_row, uv), dot(ref.v_row, uv)), srgb);
}

vec4 BaseColour(GpuMaterial material, GpuInstance instance, GpuHit hit) {
  vec4 colour =
      material.base_colour * TextureValue(material.base_colour_texture, instance, hit, true);
  if (instance.colours != kNoArray) {
    uvec3 corner = CornersOf(instance, hit.primitive);
    vec3 weight = Weights(hit);
    colour *= Vec4At(instance.colours + 4u * corner.x) * weight.x +
              Vec4At(instance.colours + 4u * corner.y) * weight.y +
              Vec4At(instance.colours + 4u * corner.z) * weight.z;
  }
  return clamp(colour, 0.0f, 1.0f);
}

// 0: transparent, 1: opaque.
float OpacityOf(GpuMaterial material, float alpha) {
  if (material.alpha_mode == kAlphaOpaque) {
    return 1.0f;
  }
  if (material.alpha_mode == kAlphaMask) {
    return alpha >= material.alpha_cutoff ? 1.0f : 0.0f;
  }
  return alpha;
}

bool Emits(GpuMaterial material) {
  return MaxComponent(material.emission) > 0.0f;
}

// Radiance emitted by the front of the surface, independent of direction.
vec3 EmissionOf(GpuMaterial material, GpuInstance instance, GpuHit hit) {
  return material.emission * TextureValue(material.emissive_texture, instance, hit, true).rgb;
}

float ClampToUnit(float x) {
  return x > 0.0f ? min(x, 1.0f) : 0.0f;
}

float TransmissionOf(GpuMaterial material, GpuInstance instance, GpuHit hit) {
  if (material.transmission <= 0.0f) {
    return 0.0f;
  }
  return ClampToUnit(material.transmission *
                     TextureValue(material.transmission_texture, instance, hit, false).x);
}

float LookUpEnergy(uint table, EnergyPlace at) {
  uint first = table + uint(at.first);
  uint below = first + uint(kEnergyTableSize);
  float low = energies[first] + (energies[first + 1u] - energies[first]) * at.x;
  float high = energies[below] + (energies[below + 1u] - energies[below]) * at.x;
  return low + (high - low) * at.y;
}

SchlickShare ShareOfSpecular(float cosine, float alpha) {
  SchlickShare share;
  if (alpha <= 0.0f) {
    share.offset = SchlickWeight(cosine);
    share.scale = 1.0f - share.offset;
    return share;
  }
  EnergyPlace at = FindEnergy(cosine, sqrt(alpha));
  share.scale = LookUpEnergy(0u, at);
  share.offset = LookUpEnergy(kEnergyTableWords, at);
  return share;
}

// Directional albedo of an anisotropic lobe. w: direction to the viewer, x along the tangent.
SchlickShare ShareOfAnisotropic(vec3 w, vec2 alphas) {
  AnisotropicPlace place = FindAnisotropicEnergy(w, alphas);
  SchlickShare share = SchlickShare(0.0f, 0.0f);
  for (int corner = 0; corner < 16; ++corner) {
    uint entry = kAnisotropicTables + uint(AnisotropicEntry(place, corner));
    float weight = AnisotropicWeight(place, corner);
    share.scale += weight * energies[entry];
    share.offset += weight * energies[entry + uint(kAnisotropicEntries)];
  }
  return share;
}

SurfaceLayers LayersAt(uint record, GpuInstance instance, GpuHit hit) {
  SurfaceLayers layers = NoLayers();
  layers.specular = ClampToUnit(
      FloatAt(record + kLayersSpecular) *
      TextureValue(TextureRefAt(record + kLayersSpecularTexture), instance, hit, false).a);
  layers.specular_colour =
      Vec3At(record) *
      TextureValue(TextureRefAt(record + kLayersSpecularColourTexture), instance, hit, true).rgb;
  float coat = FloatAt(record + kLayersCoat);
  if (coat > 0.0f) {
    layers.coat = ClampToUnit(
        coat * TextureValue(TextureRefAt(record + kLayersCoatTexture), instance, hit, false).r);
    float roughness =
        FloatAt(record + kLayersCoatRoughness) *
        TextureValue(TextureRefAt(record + kLayersCoatRoughnessTexture), instance, hit, false).g;
    layers.coat_alpha = AlphaOfRoughness(ClampToUnit(roughness));
  }
  layers.sheen_colour = Vec3At(record + kLayersSheenColour);
  if (layers.sheen_colour != vec3(0.0f)) {
    layers.sheen_colour *=
        TextureValue(TextureRefAt(record + kLayersSheenColourTexture), instance, hit, true).rgb;
    layers.sheen_roughness = ClampToUnit(
        FloatAt(record + kLayersSheenRoughness) *
        TextureValue(TextureRefAt(record + kLayersSheenRoughnessTexture), instance, hit, false).a);
  }
  layers.through = FloatAt(record + kLayersThrough);
  if (layers.through > 0.0f) {
    layers.through = ClampToUnit(
        layers.through *
        TextureValue(TextureRefAt(record + kLayersThroughTexture), instance, hit, false).a);
    layers.through_colour =
        Vec3At(record + kLayersThroughColour) *
        TextureValue(TextureRefAt(record + kLayersThroughColourTexture), instance, hit, true).rgb;
  }
  layers.anisotropy = FloatAt(record + kLayersAnisotropy);
  if (layers.anisotropy > 0.0f) {
    layers.anisotropy = ClampToUnit(
        layers.anisotropy *
        TextureValue(TextureRefAt(record + kLayersAnisotropyTexture), instance, hit, false).b);
  }
  layers.film = FloatAt(record + kLayersFilm);
  if (layers.film > 0.0f) {
    layers.film = ClampToUnit(
        layers.film *
        TextureValue(TextureRefAt(record + kLayersFilmTexture), instance, hit, false).r);
    layers.film_ior = FloatAt(record + kLayersFilmIor);
    vec2 thickness = Vec2At(record + kLayersFilmThickness);
    layers.film_thickness = mix(
        thickness.x, thickness.y,
        TextureValue(TextureRefAt(record + kLayersFilmThicknessTexture), instance, hit, false).g);
    layers.film = layers.film_thickness > 0.0f ? layers.film : 0.0f;
  }
  return layers;
}

// \param cosine, coat_cosine  cosines of wo with the normals of surface and clear coat
LayerShares SharesOf(SurfaceLayers layers, float cosine, float coat_cosine) {
  LayerShares shares;
  shares.sheen = 0.0f;
  if (layers.sheen_colour != vec3(0.0f)) {
    shares.sheen = LookUpEnergy(2u * kEnergyTableWords,
                                FindEnergy(cosine, RowOfSheen(layers.sheen_roughness)));
  }
  shares.coat = SchlickShare(1.0f, 0.0f);
  if (layers.coat > 0.0f) {
    shares.coat = ShareOfSpecular(min(coat_cosine, 1.0f), layers.coat_alpha);
  }
  return shares;
}

// CoverTransmittance of a smooth thin sheet for shadow rays: with the geometric normal and without
// regularisation.
float SheetCover(SurfaceLayers layers, float cosine) {
  return CoverTransmittance(layers, SharesOf(layers, cosine, cosine));
}

// Transmittance of a smooth thin sheet for an undeflected ray at `cosine` with its geometric
// normal; 0 for all other materials.
vec3 SheetTransmittance(GpuMaterial material, GpuInstance instance, GpuHit hit, vec3 base_colour,
                        float cosine) {
  float transmission = material.solid != 0u ? 0.0f : TransmissionOf(material, instance, hit);
  if (transmission <= 0.0f) {
    return vec3(0.0f);
  }
  vec4 mr = TextureValue(material.metallic_roughness_texture, instance, hit, false);
  if (AlphaOfRoughness(ClampToUnit(material.roughness * mr.y)) > 0.0f) {
    return vec3(0.0f);
  }
  cosine = min(abs(cosine), 1.0f);
  float share = (1.0f - ClampToUnit(material.metallic * mr.z)) * transmission;
  if (kWithLayers != 0u && material.layers != kNoArray) {
    SurfaceLayers layers = LayersAt(material.layers, instance, hit);
    share *= 1.0f - SheetReflectance(layers, cosine, material.ior);
    share *= SheetCover(layers, cosine);
  } else {
    share *= 1.0f - FresnelThinSheet(cosine, material.ior);
  }
  return base_colour * share;
}

// Transmittance of a see-through surface for a shadow ray.
vec3 ShadowTransmittance(GpuHit hit, vec3 direction) {
  GpuInstance instance = instances[hit.instance];
  GpuMaterial material = materials[instance.material];
  vec4 colour = BaseColour(material, instance, hit);
  float opacity = OpacityOf(material, colour.a);
  vec3 through = vec3(1.0f - opacity);
  if (opacity > 0.0f && material.transmission > 0.0f && material.solid == 0u) {
    WorldTriangle t = TriangleOf(instance, hit.primitive);
    vec3 normal = SafeNormalize(cross(t.p1 - t.p0, t.p2 - t.p0), direction);
    through +=
        opacity * SheetTransmittance(material, instance, hit, colour.rgb, dot(normal, direction));
  }
  return through;
}

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The surface at a hit and its BSDF, with the steps of the CPU version (MakeSurface,
// BsdfTables::Make). Needs scene.glsl and material_lookup.glsl.
#include "render/shading_point_shared.h"

struct Surface {
  ShadingPoint at;
  vec3 base_colour;
  float metallic;
  float roughness;
  float transmission;
  bool layered;
  SurfaceLayers layers;
};

// Transforms a normal to world space, unnormalised, by the cofactor matrix, which exists for any
// matrix.
vec3 TransformNormal(GpuInstance instance, vec3 n) {
  vec3 x = instance.world_x.xyz;
  vec3 y = instance.world_y.xyz;
  vec3 z = instance.world_z.xyz;
  return vec3(dot(cross(y, z), n), dot(cross(z, x), n), dot(cross(x, y), n));
}

// The tangent along increasing u for meshes without tangents; w: handedness.
vec4 TangentFromUv(GpuInstance instance, uvec3 corner, WorldTriangle t, uint array) {
  if (array == kNoArray) {
    return vec4(0.0f);
  }
  vec2 d1 = Vec2At(array + 2u * corner.y) - Vec2At(array + 2u * corner.x);
  vec2 d2 = Vec2At(array + 2u * corner.z) - Vec2At(array + 2u * corner.x);
  float area = d1.x * d2.y - d1.y * d2.x;
  if (area == 0.0f) {
    return vec4(0.0f);
  }
  // glTF's v axis points down: an unmirrored texture has area < 0.
  return vec4(((t.p1 - t.p0) * d2.y - (t.p2 - t.p0) * d1.y) / area, area < 0.0f ? 1.0f : -1.0f);
}

struct TangentFrame {
  vec3 tangent;    // zero if there is none
  vec3 bitangent;  // both of unit length
};

// Tangents perpendicular to a normal. uv_set: texture coordinates for meshes without tangents.
TangentFrame TangentsAt(GpuInstance instance, GpuHit hit, WorldTriangle t, int uv_set,
                        vec3 normal) {
  uvec3 corner = CornersOf(instance, hit.primitive);
  vec4 tangent;
  if (instance.tangents == kNoArray) {
    tangent = TangentFromUv(instance, corner, t, uv_set == 0 ? instance.uv_0 : instance.uv_1);
  } else {
    vec3 weight = Weights(hit);
    tangent = Vec4At(instance.tangents + 4u * corner.x) * weight.x +
              Vec4At(instance.tangents + 4u * corner.y) * weight.y +
              Vec4At(instance.tangents + 4u * corner.z) * weight.z;
    tangent.xyz =
        TransformVector(instance.world_x, instance.world_y, instance.world_z, tangent.xyz);
  }
  vec3 along = SafeNormalize(tangent.xyz - normal * dot(normal, tangent.xyz), vec3(0.0f));
  float handedness = (tangent.w < 0.0f ? -1.0f : 1.0f) * Orientation(instance);
  return TangentFrame(along, cross(normal, along) * handedness);
}

vec3 ApplyNormalMap(GpuTextureRef ref, float scale, GpuInstance instance, GpuHit hit,
                    WorldTriangle t, vec3 normal) {
  if (ref.texture < 0) {
    return normal;
  }
  TangentFrame frame = TangentsAt(instance, hit, t, ref.uv_set, normal);
  if (frame.tangent == vec3(0.0f)) {
    return normal;
  }
  vec3 m = TextureValue(ref, instance, hit, false).xyz * 2.0f - vec3(1.0f);
  m.xy *= scale;
  return SafeNormalize(frame.tangent * m.x + frame.bitangent * m.y + normal * m.z, normal);
}

// Sets the anisotropic lobe; isotropic where the tangent or the texture's direction is undefined.
void SetAnisotropy(uint record, GpuInstance instance, GpuHit hit, WorldTriangle t, vec3 normal,
                   LocalFrame frame, inout SurfaceLayers layers) {
  GpuTextureRef ref = TextureRefAt(record + kLayersAnisotropyTexture);
  TangentFrame tangents = TangentsAt(instance, hit, t, ref.uv_set, normal);
  vec2 direction = Vec2At(record + kLayersAnisotropyTurn);
  if (ref.texture >= 0) {
    vec2 d = TextureValue(ref, instance, hit, false).xy * 2.0f - vec2(1.0f);
    direction = vec2(direction.x * d.x - direction.y * d.y, direction.y * d.x + direction.x * d.y);
  }
  vec3 local = ToLocal(frame, tangents.tangent * direction.x + tangents.bitangent * direction.y);
  vec3 tangent = SafeNormalize(vec3(local.xy, 0.0f), vec3(0.0f));
  layers.tangent = tangent.xy;
  if (tangent == vec3(0.0f)) {
    layers.anisotropy = 0.0f;
  }
}

vec3 InterpolatedNormal(GpuInstance instance, GpuHit hit, vec3 outward) {
  uvec3 corner = CornersOf(instance, hit.primitive);
  vec3 weight = Weights(hit);
  vec3 local = Vec3At(instance.normals + 3u * corner.x) * weight.x +
               Vec3At(instance.normals + 3u * corner.y) * weight.y +
               Vec3At(instance.normals + 3u * corner.z) * weight.z;
  // The cofactors of a mirroring matrix are negated.
  vec3 normal = SafeNormalize(TransformNormal(instance, local) * Orientation(instance), outward);
  return dot(normal, outward) < 0.0f ? -normal : normal;
}

vec3 FaceViewer(vec3 n, vec3 wo) {
  float cosine = dot(n, wo);
  return cosine >= kMinViewCosine ? n : normalize(n + wo * (2.0f * kMinViewCosine - cosine));
}

void SetNormals(GpuMaterial material, GpuInstance instance, GpuHit hit, inout ShadingPoint at,
                inout SurfaceLayers layers) {
  WorldTriangle t = TriangleOf(instance, hit.primitive);
  vec3 weight = Weights(hit);
  at.position = t.p0 * weight.x + t.p1 * weight.y + t.p2 * weight.z;
  vec3 outward = SafeNormalize(cross(t.p1 - t.p0, t.p2 - t.p0), at.wo) * Orientation(instance);
  float side = dot(outward, at.wo) >= 0.0f ? 1.0f : -1.0f;
  at.front = side > 0.0f ? 1 : 0;
  at.geometric = outward * side;
  vec3 normal = InterpolatedNormal(instance, hit, outward);
  vec3 even = normal;
  normal = ApplyNormalMap(material.normal_texture, material.normal_scale, instance, hit, t, normal);
  at.frame = MakeLocalFrame(FaceViewer(normal * side, at.wo));
  at.local_wo = ToLocal(at.frame, at.wo);
  at.local_wo.z = max(at.local_wo.z, kMinViewCosine);
  if (kWithLayers != 0u && layers.coat > 0.0f) {
    GpuTextureRef ref = TextureRefAt(material.layers + kLayersCoatNormalTexture);
    if (material.normal_texture.texture >= 0 || ref.texture >= 0) {
      float scale = FloatAt(material.layers + kLayersCoatNormalScale);
      vec3 coat = ApplyNormalMap(ref, scale, instance, hit, t, even);
      layers.coat_normal = ToLocal(at.frame, FaceViewer(coat * side, at.wo));
    }
  }
  if (kWithLayers != 0u && layers.anisotropy > 0.0f) {
    SetAnisotropy(material.layers, instance, hit, t, even, at.frame, layers);
  }
}

Surface MakeSurface(GpuMaterial material, GpuInstance instance, GpuHit hit, vec3 base_colour,
                    vec3 direction) {
  Surface surface;
  surface.at.wo = -direction;
  surface.at.solid = int(material.solid);
  surface.at.attenuation_colour = material.attenuation_colour;
  surface.at.attenuation_distance = material.attenuation_distance;
  surface.at.multiscatter_colour = material.multiscatter_colour;
  surface.at.scatter_anisotropy = material.scatter_anisotropy;
  surface.layers = NoLayers();
  surface.layered = kWithLayers != 0u && material.layers != kNoArray;
  if (surface.layered) {
    surface.layers = LayersAt(material.layers, instance, hit);
  }
  SetNormals(material, instance, hit, surface.at, surface.layers);
  surface.base_colour = base_colour;
  vec4 mr = TextureValue(material.metallic_roughness_texture, instance, hit, false);
  surface.metallic = ClampToUnit(material.metallic * mr.z);
  surface.roughness = ClampToUnit(material.roughness * mr.y);
  surface.transmission = TransmissionOf(material, instance, hit);
  if (surface.layered && surface.at.solid != 0 && surface.at.front == 0) {
    RemoveCovers(surface.layers);
  }
  return surface;
}

GlassShare ShareOfGlass(GpuMaterial material, Surface surface, float alpha) {
  float cosine = surface.at.local_wo.z;
  GlassShare share;
  share.total = 1.0f;
  if (alpha <= 0.0f) {
    float eta = surface.at.front != 0 ? material.ior : 1.0f / material.ior;
    share.reflected =
        material.solid == 0u
            ? FresnelThinSheet(min(dot(surface.at.wo, surface.at.geometric), 1.0f), material.ior)
            : FresnelDielectric(min(cosine, 1.0f), eta);
    return share;
  }
  EnergyPlace at = FindEnergy(cosine, sqrt(alpha));
  if (material.solid == 0u) {
    SchlickShare all = ShareOfSpecular(cosine, alpha);
    share.reflected = LookUpEnergy(material.glass_tables + 4u * kEnergyTableWords, at);
    share.total = all.scale + all.offset;
    return share;
  }
  uint first = material.glass_tables + (surface.at.front != 0 ? 0u : 2u) * kEnergyTableWords;
  share.reflected = LookUpEnergy(first, at);
  share.total = LookUpEnergy(first + kEnergyTableWords, at);
  return share;
}

// \param min_alpha  minimum GGX alpha of path-space regularisation
Bsdf MakeSurfaceBsdf(GpuMaterial material, Surface surface, float min_alpha,
                     out SpecularAlbedo specular_albedo) {
  BsdfInput inputs;
  inputs.base_colour = surface.base_colour;
  inputs.metallic = surface.metallic;
  inputs.transmission = surface.transmission;
  inputs.own_alpha = AlphaOfRoughness(surface.roughness);
  inputs.alpha = max(inputs.own_alpha, min_alpha);
  inputs.ior = material.ior;
  inputs.solid = surface.at.solid;
  inputs.front = surface.at.front;
  vec2 alphas = vec2(inputs.alpha);
  SchlickShare share;
  if (kWithLayers != 0u && surface.layers.anisotropy > 0.0f) {
    alphas = SpecularAlphas(inputs, surface.layers);
  }
  if (kWithLayers != 0u && alphas.x > alphas.y) {
    share = ShareOfAnisotropic(ToTangent(surface.layers.tangent, surface.at.local_wo), alphas);
  } else {
    share = ShareOfSpecular(surface.at.local_wo.z, alphas.y);
  }
  GlassShare of_glass = GlassShare(0.0f, 0.0f);
  if (GlassWeight(inputs) > 0.0f) {
    of_glass = ShareOfGlass(material, surface, GlassAlpha(inputs));
  }
  Bsdf bsdf = MakeBsdf(inputs, surface.layers, share, of_glass);
  if (kWithLayers != 0u && surface.layers.film > 0.0f) {
    bool smooth_sheet = surface.at.solid == 0 && bsdf.glass_alpha <= 0.0f;
    float cosine = smooth_sheet ? dot(surface.at.wo, surface.at.geometric) : surface.at.local_wo.z;
    AddFilm(bsdf, inputs, surface.layers, surface.at.local_wo, alphas, share, min(cosine, 1.0f),
            of_glass);
  }
  if (kWithLayers != 0u && surface.layered) {
    SurfaceLayers layers = surface.layers;
    layers.coat_alpha = max(layers.coat_alpha, min_alpha);
    float cosine = max(dot(surface.at.local_wo, layers.coat_normal), kLeastCoatCosine);
    LayerShares shares = SharesOf(layers, surface.at.local_wo.z, cosine);
    bool smooth_sheet = surface.at.solid == 0 && inputs.own_alpha <= 0.0f;
    float glass_covered = smooth_sheet
                              ? SheetCover(surface.layers, dot(surface.at.wo, surface.at.geometric))
                              : CoverTransmittance(layers, shares);
    AddLayers(bsdf, layers, alphas, shares, share, glass_covered);
  }
  specular_albedo = MakeSpecularAlbedo(bsdf, share, of_glass);
  return bsdf;
}

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/surface.h"

#include <algorithm>

namespace stillray::render {
namespace {

float ClampToUnit(float x) {
  return x > 0.0f ? min(x, 1.0f) : 0.0f;  // maps NaN to 0
}

struct Corners {
  uint32_t i0, i1, i2;
};

Corners CornersOf(const Mesh& mesh, const Hit& hit) {
  const uint32_t* corner = mesh.indices.data() + 3 * static_cast<size_t>(hit.primitive);
  return {corner[0], corner[1], corner[2]};
}

template <typename T>
T Blend(const T* values, Corners c, const Hit& hit) {
  return values[c.i0] * (1.0f - hit.u - hit.v) + values[c.i1] * hit.u + values[c.i2] * hit.v;
}

/// The tangent along increasing u from the triangle's texture coordinates, for meshes without
/// tangents.
vec4 TangentFromUv(const PlacedInstance& instance, const Hit& hit, const Triangle& triangle,
                   int uv_set) {
  const std::vector<vec2>& uv = instance.mesh->uv[uv_set];
  if (uv.empty()) {
    return vec4(0.0f);
  }
  const Corners c = CornersOf(*instance.mesh, hit);
  const vec2 d1 = uv[c.i1] - uv[c.i0];
  const vec2 d2 = uv[c.i2] - uv[c.i0];
  const float area = d1.x * d2.y - d1.y * d2.x;
  if (area == 0.0f) {
    return vec4(0.0f);
  }
  const vec3 tangent =
      ((triangle.p1 - triangle.p0) * d2.y - (triangle.p2 - triangle.p0) * d1.y) / area;
  // glTF's v axis points down: an unmirrored texture has area < 0.
  return vec4(tangent, area < 0.0f ? 1.0f : -1.0f);
}

struct TangentFrame {
  vec3 tangent;    // zero if there is none
  vec3 bitangent;  // both of unit length
};

/// Tangents perpendicular to a normal.
/// \param uv_set  texture coordinates for meshes without tangents
TangentFrame TangentsAt(const PlacedInstance& instance, const Hit& hit, const Triangle& triangle,
                        int uv_set, vec3 normal) {
  vec4 tangent;
  if (instance.vertices.tangents == nullptr) {
    tangent = TangentFromUv(instance, hit, triangle, uv_set);
  } else {
    tangent = Blend(instance.vertices.tangents, CornersOf(*instance.mesh, hit), hit);
    tangent = vec4(mat3(instance.world) * vec3(tangent), tangent.w);
  }
  const vec3 across = vec3(tangent) - normal * dot(normal, vec3(tangent));
  const vec3 t = SafeNormalize(across, vec3(0.0f));
  const float handedness = (tangent.w < 0.0f ? -1.0f : 1.0f) * instance.orientation;
  return {t, cross(normal, t) * handedness};
}

vec3 ApplyNormalMap(const SceneState& state, const PlacedInstance& instance, const Hit& hit,
                    const Triangle& triangle, const TextureRef& map, float scale, vec3 normal) {
  if (map.texture < 0) {
    return normal;
  }
  const auto [t, b] = TangentsAt(instance, hit, triangle, map.uv_set, normal);
  if (t == vec3(0.0f)) {
    return normal;
  }
  vec3 m = vec3(state.TextureValue(map, hit, false)) * 2.0f - vec3(1.0f);
  m.x *= scale;
  m.y *= scale;
  return SafeNormalize(t * m.x + b * m.y + normal * m.z, normal);
}

/// The direction of the material's anisotropy in the basis of tangent and bitangent.
vec2 AnisotropyDirection(const SceneState& state, const Material& material, const Hit& hit) {
  const float c = std::cos(material.anisotropy_rotation);
  const float s = std::sin(material.anisotropy_rotation);
  if (material.anisotropy_texture.texture < 0) {
    return {c, s};
  }
  const vec2 d = vec2(state.TextureValue(material.anisotropy_texture, hit, false)) * 2.0f - 1.0f;
  return {c * d.x - s * d.y, s * d.x + c * d.y};
}

/// Sets the anisotropic lobe; isotropic where the tangent or the texture's direction is undefined.
void SetAnisotropy(const SceneState& state, const Hit& hit, const Triangle& triangle, vec3 normal,
                   Surface* surface) {
  const PlacedInstance& instance = state.instance(hit.instance);
  const Material& material = *instance.material;
  const auto [t, b] =
      TangentsAt(instance, hit, triangle, material.anisotropy_texture.uv_set, normal);
  const vec2 direction = AnisotropyDirection(state, material, hit);
  const vec3 local = ToLocal(surface->frame, t * direction.x + b * direction.y);
  const vec3 tangent = SafeNormalize(vec3(local.x, local.y, 0.0f), vec3(0.0f));
  surface->layers.tangent = vec2(tangent);
  if (tangent == vec3(0.0f)) {
    surface->layers.anisotropy = 0.0f;
  }
}

/// Bends n towards wo until their angle is slightly less than 90 degrees.
vec3 FaceViewer(vec3 n, vec3 wo) {
  const float cosine = dot(n, wo);
  if (cosine >= kMinViewCosine) {
    return n;
  }
  // Twice the minimum, as a margin for rounding.
  return normalize(n + wo * (2.0f * kMinViewCosine - cosine));
}

void SetNormals(const SceneState& state, const Hit& hit, Surface* surface) {
  const PlacedInstance& instance = state.instance(hit.instance);
  const Triangle triangle = state.TriangleOf(instance, hit.primitive);
  surface->position =
      triangle.p0 * (1.0f - hit.u - hit.v) + triangle.p1 * hit.u + triangle.p2 * hit.v;
  const vec3 outward =
      SafeNormalize(cross(triangle.p1 - triangle.p0, triangle.p2 - triangle.p0), surface->wo) *
      instance.orientation;
  const float side = dot(outward, surface->wo) >= 0.0f ? 1.0f : -1.0f;
  surface->front = side > 0.0f ? 1 : 0;
  surface->geometric = outward * side;

  const vec3 interpolated = instance.normal_matrix *
                            Blend(instance.vertices.normals, CornersOf(*instance.mesh, hit), hit);
  vec3 normal = SafeNormalize(interpolated, outward);
  // Normals that disagree with the winding are flipped.
  normal = dot(normal, outward) < 0.0f ? -normal : normal;
  const vec3 even = normal;
  const Material& material = *instance.material;
  normal = ApplyNormalMap(state, instance, hit, triangle, material.normal_texture,
                          material.normal_scale, normal);
  surface->frame = MakeLocalFrame(FaceViewer(normal * side, surface->wo));
  surface->local_wo = ToLocal(surface->frame, surface->wo);
  surface->local_wo.z = max(surface->local_wo.z, kMinViewCosine);
  const bool apart =
      material.normal_texture.texture >= 0 || material.clearcoat_normal_texture.texture >= 0;
  if (surface->layers.coat > 0.0f && apart) {
    const vec3 coat =
        ApplyNormalMap(state, instance, hit, triangle, material.clearcoat_normal_texture,
                       material.clearcoat_normal_scale, even);
    surface->layers.coat_normal = ToLocal(surface->frame, FaceViewer(coat * side, surface->wo));
  }
  if (surface->layers.anisotropy > 0.0f) {
    SetAnisotropy(state, hit, triangle, even, surface);
  }
}

float TransmissionOf(const SceneState& state, const Hit& hit) {
  const Material& material = *state.instance(hit.instance).material;
  if (material.transmission <= 0.0f) {
    return 0.0f;
  }
  return ClampToUnit(material.transmission *
                     state.TextureValue(material.transmission_texture, hit, false).x);
}

/// Sets the thin film; a film of thickness 0 is omitted.
void SetFilm(const SceneState& state, const Hit& hit, SurfaceLayers* layers) {
  const Material& material = *state.instance(hit.instance).material;
  const vec4 strength = state.TextureValue(material.iridescence_texture, hit, false);
  layers->film = ClampToUnit(layers->film * strength.x);
  const vec4 thickness = state.TextureValue(material.iridescence_thickness_texture, hit, false);
  layers->film_thickness =
      mix(material.iridescence_thickness_min, material.iridescence_thickness_max, thickness.y);
  if (!(layers->film_thickness > 0.0f)) {
    layers->film = 0.0f;
  }
}

SurfaceLayers LayersAt(const SceneState& state, const Hit& hit) {
  const Material& material = *state.instance(hit.instance).material;
  SurfaceLayers layers = LayersOf(material);
  layers.specular =
      ClampToUnit(layers.specular * state.TextureValue(material.specular_texture, hit, false).w);
  layers.specular_colour *= vec3(state.TextureValue(material.specular_color_texture, hit, true));
  if (material.clearcoat > 0.0f) {
    layers.coat =
        ClampToUnit(layers.coat * state.TextureValue(material.clearcoat_texture, hit, false).x);
    const float roughness = material.clearcoat_roughness *
                            state.TextureValue(material.clearcoat_roughness_texture, hit, false).y;
    layers.coat_alpha = AlphaOfRoughness(ClampToUnit(roughness));
  }
  if (HasSheen(material)) {
    layers.sheen_colour *= vec3(state.TextureValue(material.sheen_color_texture, hit, true));
    layers.sheen_roughness =
        ClampToUnit(layers.sheen_roughness *
                    state.TextureValue(material.sheen_roughness_texture, hit, false).w);
  }
  if (material.diffuse_transmission > 0.0f) {
    layers.through = ClampToUnit(
        layers.through * state.TextureValue(material.diffuse_transmission_texture, hit, false).w);
    layers.through_colour *=
        vec3(state.TextureValue(material.diffuse_transmission_color_texture, hit, true));
  }
  if (material.anisotropy > 0.0f) {
    layers.anisotropy = ClampToUnit(layers.anisotropy *
                                    state.TextureValue(material.anisotropy_texture, hit, false).z);
  }
  if (HasFilm(material)) {
    SetFilm(state, hit, &layers);
  }
  return layers;
}

SchlickShare ShareOfSpecular(float cosine, float alpha) {
  if (alpha <= 0.0f) {
    const float s = SchlickWeight(cosine);
    return {1.0f - s, s};
  }
  const SpecularEnergy& tables = SpecularEnergyTables();
  const EnergyTable::Place at = EnergyTable::Find(cosine, std::sqrt(alpha));
  return {tables.scale.Lookup(at), tables.offset.Lookup(at)};
}

/// Directional albedo of the specular lobe; \param alphas SpecularAlphas
SchlickShare ShareOfSpecular(const Surface& surface, vec2 alphas) {
  if (alphas.x > alphas.y) {
    return AnisotropicEnergyTables().Lookup(ToTangent(surface.layers.tangent, surface.local_wo),
                                            alphas);
  }
  return ShareOfSpecular(surface.local_wo.z, alphas.y);
}

/// \param cosine, coat_cosine  cosines of wo with the normals of surface and clear coat
LayerShares SharesOf(const SurfaceLayers& layers, float cosine, float coat_cosine) {
  LayerShares shares = {{1.0f, 0.0f}, 0.0f};
  if (layers.sheen_colour != vec3(0.0f)) {
    shares.sheen = SheenEnergyTable().albedo.Lookup(
        EnergyTable::Find(cosine, RowOfSheen(layers.sheen_roughness)));
  }
  if (layers.coat > 0.0f) {
    shares.coat = ShareOfSpecular(min(coat_cosine, 1.0f), layers.coat_alpha);
  }
  return shares;
}

/// CoverTransmittance of a smooth thin sheet for shadow rays: with the geometric normal and without
/// regularisation.
float SheetCover(const SurfaceLayers& layers, float cosine) {
  return CoverTransmittance(layers, SharesOf(layers, cosine, cosine));
}

}  // namespace

SurfaceLayers LayersOf(const Material& material) {
  SurfaceLayers layers = NoLayers();
  layers.specular = material.specular;
  layers.specular_colour = material.specular_color;
  layers.coat = material.clearcoat;
  layers.coat_alpha = AlphaOfRoughness(material.clearcoat_roughness);
  layers.sheen_colour = material.sheen_color;
  layers.sheen_roughness = material.sheen_roughness;
  layers.through = material.diffuse_transmission;
  layers.through_colour = material.diffuse_transmission_color;
  layers.anisotropy = material.anisotropy;
  layers.tangent = {std::cos(material.anisotropy_rotation), std::sin(material.anisotropy_rotation)};
  layers.film = HasFilm(material) ? material.iridescence : 0.0f;
  layers.film_ior = material.iridescence_ior;
  layers.film_thickness = material.iridescence_thickness_max;
  return layers;
}

Surface MakeSurface(const SceneState& state, const Hit& hit, vec3 base_colour, vec3 direction) {
  const PlacedInstance& instance = state.instance(hit.instance);
  const Material& material = *instance.material;
  Surface surface;
  surface.wo = -direction;
  surface.material = &material;
  surface.solid = material.solid ? 1 : 0;
  surface.attenuation_colour = material.attenuation_color;
  surface.attenuation_distance = material.attenuation_distance;
  surface.multiscatter_colour = material.multiscatter_color;
  surface.scatter_anisotropy = material.scatter_anisotropy;
  if (instance.layered) {
    surface.layers = LayersAt(state, hit);
  }
  SetNormals(state, hit, &surface);
  surface.base_colour = base_colour;
  const vec4 mr = state.TextureValue(material.metallic_roughness_texture, hit, false);
  surface.metallic = ClampToUnit(material.metallic * mr.z);
  surface.roughness = ClampToUnit(material.roughness * mr.y);
  surface.transmission = TransmissionOf(state, hit);
  surface.layered = instance.layered;
  if (surface.layered && surface.solid != 0 && surface.front == 0) {
    RemoveCovers(surface.layers);
  }
  return surface;
}

vec3 SheetTransmittance(const SceneState& state, const Hit& hit, float cosine) {
  const Material& material = *state.instance(hit.instance).material;
  const float transmission = material.solid ? 0.0f : TransmissionOf(state, hit);
  if (transmission <= 0.0f) {
    return vec3(0.0f);
  }
  const vec4 mr = state.TextureValue(material.metallic_roughness_texture, hit, false);
  if (AlphaOfRoughness(ClampToUnit(material.roughness * mr.y)) > 0.0f) {
    return vec3(0.0f);
  }
  cosine = min(std::abs(cosine), 1.0f);
  float share = (1.0f - ClampToUnit(material.metallic * mr.z)) * transmission;
  if (!state.instance(hit.instance).layered) {
    share *= 1.0f - FresnelThinSheet(cosine, material.ior);
  } else {
    const SurfaceLayers layers = LayersAt(state, hit);
    share *= 1.0f - SheetReflectance(layers, cosine, material.ior);
    share *= SheetCover(layers, cosine);
  }
  return vec3(state.BaseColour(hit)) * share;
}

BsdfTables::BsdfTables(const Scene& scene, bool regularise) {
  SpecularEnergyTables();
  for (const Material& material : scene.materials) {
    if (HasSheen(material)) {
      SheenEnergyTable();
    }
    if (material.anisotropy > 0.0f) {
      AnisotropicEnergyTables();
    }
    const bool rough = regularise || AlphaOfRoughness(ClampToUnit(material.roughness)) > 0.0f;
    if (material.transmission > 0.0f && rough && !glass_.count(material.ior)) {
      glass_[material.ior] = std::make_unique<GlassEnergy>(MakeGlassEnergy(material.ior));
    }
  }
}

GlassShare BsdfTables::ShareOfGlass(const Surface& surface, float alpha) const {
  const Material& material = *surface.material;
  const float cosine = surface.local_wo.z;
  if (alpha <= 0.0f) {
    if (!material.solid) {
      return {FresnelThinSheet(min(dot(surface.wo, surface.geometric), 1.0f), material.ior), 1.0f};
    }
    const float eta = surface.front != 0 ? material.ior : 1.0f / material.ior;
    return {FresnelDielectric(min(cosine, 1.0f), eta), 1.0f};
  }
  const GlassEnergy& tables = *glass_.at(material.ior);
  const EnergyTable::Place at = EnergyTable::Find(cosine, std::sqrt(alpha));
  if (!material.solid) {
    const SchlickShare all = ShareOfSpecular(cosine, alpha);
    return {tables.sheet_reflected.Lookup(at), all.scale + all.offset};
  }
  if (surface.front != 0) {
    return {tables.enter_reflected.Lookup(at), tables.enter_total.Lookup(at)};
  }
  return {tables.leave_reflected.Lookup(at), tables.leave_total.Lookup(at)};
}

Bsdf BsdfTables::Make(const Surface& surface, float min_alpha,
                      SpecularAlbedo* specular_albedo) const {
  const Material& material = *surface.material;
  BsdfInput input;
  input.base_colour = surface.base_colour;
  input.metallic = surface.metallic;
  input.transmission = surface.transmission;
  input.own_alpha = AlphaOfRoughness(surface.roughness);
  input.alpha = max(input.own_alpha, min_alpha);
  input.ior = material.ior;
  input.solid = material.solid ? 1 : 0;
  input.front = surface.front;
  const vec2 alphas = SpecularAlphas(input, surface.layers);
  const SchlickShare share = ShareOfSpecular(surface, alphas);
  GlassShare of_glass =
      GlassWeight(input) > 0.0f ? ShareOfGlass(surface, GlassAlpha(input)) : GlassShare{0.0f, 0.0f};
  Bsdf bsdf = MakeBsdf(input, surface.layers, share, of_glass);
  if (surface.layers.film > 0.0f) {
    const bool smooth_sheet = surface.solid == 0 && bsdf.glass_alpha <= 0.0f;
    const float cosine = smooth_sheet ? dot(surface.wo, surface.geometric) : surface.local_wo.z;
    AddFilm(bsdf, input, surface.layers, surface.local_wo, alphas, share, min(cosine, 1.0f),
            of_glass);
  }
  if (surface.layered) {
    SurfaceLayers layers = surface.layers;
    layers.coat_alpha = max(layers.coat_alpha, min_alpha);
    const float cosine = max(dot(surface.local_wo, layers.coat_normal), kLeastCoatCosine);
    const LayerShares shares = SharesOf(layers, surface.local_wo.z, cosine);
    const bool smooth_sheet = surface.solid == 0 && input.own_alpha <= 0.0f;
    const float glass_covered = smooth_sheet
                                    ? SheetCover(surface.layers, dot(surface.wo, surface.geometric))
                                    : CoverTransmittance(layers, shares);
    AddLayers(bsdf, layers, alphas, shares, share, glass_covered);
  }
  if (specular_albedo != nullptr) {
    *specular_albedo = MakeSpecularAlbedo(bsdf, share, of_glass);
  }
  return bsdf;
}

size_t BsdfTables::memory_bytes() const {
  return sizeof(SpecularEnergy) + glass_.size() * sizeof(GlassEnergy);
}

}  // namespace stillray::render

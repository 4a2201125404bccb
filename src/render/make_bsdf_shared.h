// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Converts glTF 2.0 material parameters to the lobes of a Bsdf, given the directional albedos of
// its rough lobes.
#ifndef STILLRAY_RENDER_MAKE_BSDF_SHARED_H
#define STILLRAY_RENDER_MAKE_BSDF_SHARED_H

#ifdef __cplusplus
#include "render/bsdf_shared.h"
#include "render/layers_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Directional albedos of the glass lobe before energy compensation.
struct GlassShare {
  float reflected;
  float total;
};

// Directional albedos of the layers.
struct LayerShares {
  SchlickShare coat;
  float sheen;  // directional albedo of white sheen; above 1 near the horizon if smooth
};

// Material parameters at one surface point, viewed from one side.
struct BsdfInput {
  vec3 base_colour;
  float metallic;
  float transmission;
  float own_alpha;  // GGX alpha of the material's roughness
  float alpha;      // GGX alpha after path-space regularisation; at least own_alpha
  float ior;
  int solid;  // 1: boundary of a solid; 0: an infinitely thin sheet
  int front;  // 1: viewed from the front
};

// Reflectance at normal incidence of a dielectric.
SHARED_FN float DielectricF0(float ior) {
  float r = (ior - 1.0f) / (ior + 1.0f);
  return r * r;
}

// The weight of the glass lobes.
SHARED_FN float GlassWeight(SHARED_IN(BsdfInput) surface) {
  return (1.0f - surface.metallic) * surface.transmission;
}

// Smooth thin sheets stay smooth: shadow rays pass them undeflected.
SHARED_FN float GlassAlpha(SHARED_IN(BsdfInput) surface) {
  return surface.solid == 0 && surface.own_alpha <= 0.0f ? 0.0f : surface.alpha;
}

// Directional albedo of the specular lobe (dielectric boundary and metal).
SHARED_FN vec3 ReflectedShare(SHARED_IN(Bsdf) bsdf, SHARED_IN(SchlickShare) share) {
  vec3 reflected = bsdf.specular_f0 * share.scale + vec3(bsdf.specular_f90 * share.offset);
  if (HasFilm(bsdf)) {
    reflected = mix(reflected, bsdf.film_mean * (share.scale + share.offset), bsdf.film);
  }
  return bsdf.specular_scale * reflected;
}

// Directional albedos of all specular lobes together.
struct SpecularAlbedo {
  vec3 reflected;
  vec3 transmitted;
};

SHARED_FN SpecularAlbedo MakeSpecularAlbedo(SHARED_IN(Bsdf) bsdf, SHARED_IN(SchlickShare) share,
                                            SHARED_IN(GlassShare) of_glass) {
  SpecularAlbedo albedo;
  albedo.reflected = ReflectedShare(bsdf, share);
  albedo.transmitted = vec3(0.0f);
  if (bsdf.glass_weight > 0.0f) {
    float weight = bsdf.glass_weight * bsdf.glass_compensation;
    vec3 colour = HasFilm(bsdf) ? bsdf.film_sheet : vec3(1.0f);
    albedo.reflected += colour * (of_glass.reflected * weight);
    albedo.transmitted = bsdf.tint * ((of_glass.total - of_glass.reflected) * weight);
  }
  if (bsdf.layered != 0) {
    albedo.reflected += vec3(bsdf.coat_albedo);
  }
  return albedo;
}

SHARED_FN vec3 SumOf(SHARED_IN(SpecularAlbedo) albedo) {
  return albedo.reflected + albedo.transmitted;
}

// Albedo of all lobes whose light counts as diffuse.
SHARED_FN vec3 DiffuseAlbedo(SHARED_IN(Bsdf) bsdf) {
  return bsdf.layered != 0 ? bsdf.diffuse + bsdf.through + bsdf.sheen_albedo : bsdf.diffuse;
}

// Whether the clear coat has the largest share of the specular lobes.
SHARED_FN bool IsMainlyCoat(SHARED_IN(Bsdf) bsdf) {
  return bsdf.layered != 0 && bsdf.pick_coat > bsdf.pick_specular + bsdf.pick_glass;
}

// Perceptual roughness of the dominant specular lobe.
// \param roughness  roughness of the surface below the layers
SHARED_FN float GuideRoughness(SHARED_IN(Bsdf) bsdf, float roughness) {
  if (IsMainlyCoat(bsdf)) {
    return sqrt(bsdf.coat_alpha);
  }
  return IsAnisotropic(bsdf) ? sqrt(SpecularMeanAlpha(bsdf)) : roughness;
}

// Energy compensation of the clear coat.
SHARED_FN float CoatCompensation(SHARED_IN(SchlickShare) coat) {
  return 1.0f + kCoatF0 * (1.0f / (coat.scale + coat.offset) - 1.0f);
}

// Transmittance of the covering layers (coat and sheen) for the lobes below them.
SHARED_FN float CoverTransmittance(SHARED_IN(SurfaceLayers) layers, SHARED_IN(LayerShares) shares) {
  float coat = layers.coat * CoatCompensation(shares.coat) *
               (kCoatF0 * shares.coat.scale + shares.coat.offset);
  float sheen = MaxComponent(layers.sheen_colour) * min(shares.sheen, 1.0f);
  return max(1.0f - coat, 0.0f) * (1.0f - sheen);
}

// GGX alphas of the specular lobe, x along the tangent, y across it.
SHARED_FN vec2 SpecularAlphas(SHARED_IN(BsdfInput) surface, SHARED_IN(SurfaceLayers) layers) {
  float least = surface.alpha > surface.own_alpha ? surface.alpha : 0.0f;  // set by regularisation
  return AnisotropicAlpha(surface.own_alpha, layers.anisotropy, least);
}

// Number of visible normals over which a film's reflectance is averaged: the error of the mean is
// below 0.015 (BsdfTest), with half of them 0.025.
const int kFilmNormals = 16;

// A visible microfacet normal: its cosine with wo, and the shadowing term of its reflected
// direction as weight.
struct VisibleNormal {
  float cosine;
  float weight;
};
SHARED_FN VisibleNormal VisibleNormalOf(vec3 wo, vec2 alphas, int i) {
  float u = fract(0.5f + 0.61803399f * float(i));
  vec3 h = SampleGgxVisibleOf2(wo, alphas, u, (float(i) + 0.5f) / float(kFilmNormals));
  VisibleNormal normal;
  normal.cosine = dot(wo, h);
  vec3 wi = 2.0f * normal.cosine * h - wo;
  float above = 1.0f + GgxLambdaOf2(wo, alphas);
  normal.weight = wi.z > 0.0f ? above / (above + GgxLambdaOf2(wi, alphas)) : 0.0f;
  return normal;
}

// Means of a film's reflectance over the specular lobe.
struct FilmMeans {
  vec3 metal;
  vec3 boundary;
};
SHARED_FN FilmMeans MeansOfFilm(SHARED_IN(Bsdf) bsdf, vec3 wo, vec2 alphas) {
  FilmMeans means;
  means.metal = vec3(0.0f);
  means.boundary = vec3(0.0f);
  int count = alphas.x > 0.0f ? kFilmNormals : 1;
  float weight = 0.0f;
  for (int i = 0; i < count; ++i) {
    VisibleNormal normal;
    normal.cosine = wo.z;
    normal.weight = 1.0f;
    if (count > 1) {
      normal = VisibleNormalOf(wo, alphas, i);
    }
    FilmView view = ViewFilm(min(normal.cosine, 1.0f), bsdf.film_ior, bsdf.film_thickness);
    means.metal += normal.weight * FilmReflectance(view, bsdf.tint);
    means.boundary += normal.weight * FilmReflectance(view, bsdf.film_f0);
    weight += normal.weight;
  }
  float scale = weight > 0.0f ? 1.0f / weight : 0.0f;
  means.metal *= scale;
  means.boundary *= scale;
  return means;
}

// Replaces the Fresnel term of glass. `of_glass`: [in] without the film, [out] with it.
// \param all     directional albedo of the lobe with a Fresnel term of 1
// \param cosine  dot(wo, normal) with the normal for which `of_glass` was computed
SHARED_FN void AddFilmToGlass(SHARED_INOUT(Bsdf) bsdf, vec3 wo, float all, float cosine,
                              SHARED_INOUT(GlassShare) of_glass) {
  vec3 sum = vec3(0.0f);
  float most = 0.0f;
  float weight = 0.0f;
  int count = bsdf.glass_alpha > 0.0f ? kFilmNormals : 1;
  for (int i = 0; i < count; ++i) {
    VisibleNormal normal;
    normal.cosine = cosine;
    normal.weight = 1.0f;
    if (count > 1) {
      normal = VisibleNormalOf(wo, vec2(bsdf.glass_alpha), i);
    }
    GlassFresnel fresnel = FresnelOfGlass(bsdf, normal.cosine);
    sum += normal.weight * fresnel.share * fresnel.colour;
    most += normal.weight * fresnel.share;
    weight += normal.weight;
  }
  bsdf.film_sheet = sum / max(most, 1e-6f);
  // Transmittance of the lobe with a Fresnel transmittance of 1.
  float transmits =
      (of_glass.total - of_glass.reflected) / max(1.0f - of_glass.reflected / all, 0.1f);
  float reflects = weight > 0.0f ? most / weight : 1.0f;
  of_glass.reflected = reflects * all;
  of_glass.total = of_glass.reflected + (1.0f - reflects) * transmits;
  bsdf.glass_compensation = 1.0f / max(of_glass.total, 0.1f);
  bsdf.sheet_reflectance = of_glass.reflected;
}

// Reflectance of a smooth thin sheet.
SHARED_FN float SheetReflectance(SHARED_IN(SurfaceLayers) layers, float cosine, float ior) {
  if (layers.film <= 0.0f) {
    return FresnelThinSheet(cosine, ior);
  }
  Bsdf bsdf;
  bsdf.layered = 1;
  bsdf.film = layers.film;
  bsdf.film_ior = layers.film_ior;
  bsdf.film_thickness = layers.film_thickness;
  bsdf.thin = 1;
  bsdf.eta = ior;
  return FresnelOfGlass(bsdf, cosine).share;
}

// Adds a thin film to a Bsdf, before AddLayers.
// \param alphas        SpecularAlphas
// \param share         directional albedo of the specular lobe
// \param glass_cosine  dot(wo, normal) with the normal for which `of_glass` was computed
// \param of_glass      [in] without the film, [out] with it; used only if GlassWeight is above 0
SHARED_FN void AddFilm(SHARED_INOUT(Bsdf) bsdf, SHARED_IN(BsdfInput) surface,
                       SHARED_IN(SurfaceLayers) layers, vec3 wo, vec2 alphas,
                       SHARED_IN(SchlickShare) share, float glass_cosine,
                       SHARED_INOUT(GlassShare) of_glass) {
  float base = (1.0f - surface.metallic) * (1.0f - surface.transmission);
  float ior_f0 = DielectricF0(surface.ior);
  bsdf.layered = 1;
  bsdf.film = layers.film;
  bsdf.film_ior = layers.film_ior;
  bsdf.film_thickness = layers.film_thickness;
  bsdf.film_metal = surface.metallic;
  bsdf.film_boundary = base;
  bsdf.film_f0 = min(layers.specular_colour * ior_f0, vec3(1.0f)) * layers.specular;
  vec3 local = alphas.x > alphas.y ? ToTangent(layers.tangent, wo) : wo;
  FilmMeans means = MeansOfFilm(bsdf, local, alphas);
  bsdf.film_mean = means.metal * bsdf.film_metal + means.boundary * bsdf.film_boundary;

  // Computed like the lobes in MakeBsdf, with the film's mean reflectance in place of f0 and f90.
  float all = share.scale + share.offset;
  float loss = 1.0f / all - 1.0f;
  float plain_f0 = MaxComponent(bsdf.film_f0);
  float plain_f90 = min(50.0f * ior_f0, 1.0f) * layers.specular;
  float of_film = MaxComponent(means.boundary);
  float reflected =
      mix(plain_f0 * share.scale + plain_f90 * share.offset, of_film * all, bsdf.film);
  reflected *= 1.0f + mix(plain_f0, of_film, bsdf.film) * loss;
  bsdf.diffuse_share = base * max(1.0f - reflected, 0.0f);
  bsdf.diffuse = surface.base_colour * bsdf.diffuse_share;
  float weight = surface.metallic + base;
  if (weight > 0.0f) {
    bsdf.specular_scale =
        vec3(1.0f) + mix(bsdf.specular_f0, bsdf.film_mean, bsdf.film) * (loss / weight);
  }
  bsdf.film_sheet = vec3(1.0f);
  if (bsdf.glass_weight > 0.0f) {
    AddFilmToGlass(bsdf, wo, bsdf.glass_alpha > 0.0f ? all : 1.0f, glass_cosine, of_glass);
  }
}

// Adds the layers to a Bsdf.
// \param alphas         SpecularAlphas
// \param share          directional albedo of the specular lobe
// \param glass_covered  CoverTransmittance above glass
SHARED_FN void AddLayers(SHARED_INOUT(Bsdf) bsdf, SHARED_IN(SurfaceLayers) layers, vec2 alphas,
                         SHARED_IN(LayerShares) shares, SHARED_IN(SchlickShare) share,
                         float glass_covered) {
  bsdf.layered = 1;
  bsdf.tangent = layers.tangent;
  bsdf.specular_alpha = alphas.y;
  bsdf.tangent_alpha = alphas.x > alphas.y ? alphas.x : 0.0f;
  bsdf.coat_normal = layers.coat_normal;
  bsdf.coat_alpha = layers.coat_alpha;
  bsdf.coat_scale = layers.coat * CoatCompensation(shares.coat);
  bsdf.coat_albedo = bsdf.coat_scale * (kCoatF0 * shares.coat.scale + shares.coat.offset);
  // A sheen albedo above 1 is scaled to 1.
  bsdf.sheen = layers.sheen_colour * (max(1.0f - bsdf.coat_albedo, 0.0f) / max(shares.sheen, 1.0f));
  bsdf.sheen_albedo = bsdf.sheen * shares.sheen;
  bsdf.sheen_alpha = SheenAlpha(layers.sheen_roughness);
  float covered = CoverTransmittance(layers, shares);
  bsdf.through = layers.through_colour * (bsdf.diffuse_share * layers.through * covered);
  bsdf.diffuse *= (1.0f - layers.through) * covered;
  bsdf.specular_scale *= covered;
  bsdf.glass_weight *= glass_covered;

  float specular = MaxComponent(ReflectedShare(bsdf, share));
  float diffuse = MaxComponent(bsdf.diffuse);
  float through = MaxComponent(bsdf.through);
  float sheen = MaxComponent(bsdf.sheen_albedo);
  float sum = diffuse + specular + bsdf.glass_weight + through + sheen + bsdf.coat_albedo;
  float scale = sum > 0.0f ? 1.0f / sum : 0.0f;
  bsdf.pick_diffuse = diffuse * scale;
  bsdf.pick_specular = specular * scale;
  bsdf.pick_glass = bsdf.glass_weight * scale;
  bsdf.pick_through = through * scale;
  bsdf.pick_sheen = sheen * scale;
  bsdf.pick_coat = bsdf.coat_albedo * scale;
}

// `of_glass` is used only if GlassWeight is above 0.
SHARED_FN Bsdf MakeBsdf(SHARED_IN(BsdfInput) surface, SHARED_IN(SurfaceLayers) layers,
                        SHARED_IN(SchlickShare) share, SHARED_IN(GlassShare) of_glass) {
  float metal = surface.metallic;
  float glass = GlassWeight(surface);
  float base = (1.0f - metal) * (1.0f - surface.transmission);

  Bsdf bsdf;
  bsdf.layered = 0;
  bsdf.film = 0.0f;
  float ior_f0 = DielectricF0(surface.ior);
  vec3 boundary_f0 = min(layers.specular_colour * ior_f0, vec3(1.0f)) * layers.specular;
  // A boundary with almost no reflectance has none at grazing incidence either.
  float boundary_f90 = min(50.0f * ior_f0, 1.0f) * layers.specular;
  float loss = 1.0f / (share.scale + share.offset) - 1.0f;
  // The largest component, so that a coloured boundary does not tint the light below it.
  float most_f0 = MaxComponent(boundary_f0);
  float reflected = (1.0f + most_f0 * loss) * (most_f0 * share.scale + boundary_f90 * share.offset);
  bsdf.diffuse_share = base * max(1.0f - reflected, 0.0f);
  bsdf.diffuse = surface.base_colour * bsdf.diffuse_share;

  // The dielectric boundary and metal share one lobe: Schlick's formula is linear in f0 and f90.
  float weight = metal + base;
  bsdf.specular_f0 = surface.base_colour * metal + boundary_f0 * base;
  bsdf.specular_f90 = metal + boundary_f90 * base;
  bsdf.specular_scale =
      weight > 0.0f ? vec3(1.0f) + bsdf.specular_f0 * (loss / weight) : vec3(1.0f);
  bsdf.specular_alpha = surface.alpha;

  bsdf.thin = surface.solid != 0 ? 0 : 1;
  bsdf.eta = bsdf.thin != 0 || surface.front != 0 ? surface.ior : 1.0f / surface.ior;
  bsdf.glass_alpha = GlassAlpha(surface);
  bsdf.glass_weight = glass;
  bsdf.glass_compensation = 1.0f;
  bsdf.tint = surface.base_colour;
  bsdf.sheet_reflectance = 0.0f;
  if (glass > 0.0f) {
    bsdf.glass_compensation = 1.0f / max(of_glass.total, 0.1f);
    bsdf.sheet_reflectance = of_glass.reflected;
  }

  float specular = MaxComponent(ReflectedShare(bsdf, share));
  float diffuse = MaxComponent(bsdf.diffuse);
  float sum = diffuse + specular + glass;
  bsdf.pick_diffuse = sum > 0.0f ? diffuse / sum : 0.0f;
  bsdf.pick_specular = sum > 0.0f ? specular / sum : 0.0f;
  bsdf.pick_glass = sum > 0.0f ? glass / sum : 0.0f;
  return bsdf;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_MAKE_BSDF_SHARED_H

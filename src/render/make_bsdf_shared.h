// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Converts glTF 2.0 material parameters to the lobes of a Bsdf, given the reflectances of its rough
// lobes.
#ifndef STILLRAY_RENDER_MAKE_BSDF_SHARED_H
#define STILLRAY_RENDER_MAKE_BSDF_SHARED_H

#ifdef __cplusplus
#include "render/bsdf_shared.h"
#include "render/layers_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// The same for glass, before energy compensation.
struct GlassShare {
  float reflected;
  float total;
};

// Directional albedos of the layers.
struct LayerShares {
  SchlickShare coat;
  float sheen;  // white; above 1 near the horizon if it is smooth
};

// A surface at one point, from one side.
struct BsdfInput {
  vec3 base_colour;
  float metallic;
  float transmission;
  float own_alpha;  // of GGX, from the material's roughness
  float alpha;      // with regularisation; at least own_alpha
  float ior;
  int solid;  // 1: boundary of a solid; 0: an infinitely thin sheet
  int front;  // 1: seen from its front
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

// The fraction of uniform white light that the boundary and the metal reflect to the viewer.
SHARED_FN vec3 ReflectedShare(SHARED_IN(Bsdf) bsdf, SHARED_IN(SchlickShare) share) {
  vec3 reflected = bsdf.specular_f0 * share.scale + vec3(bsdf.specular_f90 * share.offset);
  if (HasFilm(bsdf)) {
    reflected = mix(reflected, bsdf.film_mean * (share.scale + share.offset), bsdf.film);
  }
  return bsdf.specular_scale * reflected;
}

// The fractions of uniform white light that all specular lobes together send to the viewer.
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

// Of all lobes whose light counts as diffuse.
SHARED_FN vec3 DiffuseAlbedo(SHARED_IN(Bsdf) bsdf) {
  return bsdf.layered != 0 ? bsdf.diffuse + bsdf.through + bsdf.sheen_albedo : bsdf.diffuse;
}

// Whether most of the specular light comes from the clear coat.
SHARED_FN bool IsMainlyCoat(SHARED_IN(Bsdf) bsdf) {
  return bsdf.layered != 0 && bsdf.pick_coat > bsdf.pick_specular + bsdf.pick_glass;
}

// Perceptual roughness of the reflection that most of the specular light comes from.
// \param roughness  of the surface below the layers
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

// The fraction of light that the covering layers leave to what is below them.
SHARED_FN float CoverTransmittance(SHARED_IN(SurfaceLayers) layers, SHARED_IN(LayerShares) shares) {
  float coat = layers.coat * CoatCompensation(shares.coat) *
               (kCoatF0 * shares.coat.scale + shares.coat.offset);
  float sheen = MaxComponent(layers.sheen_colour) * min(shares.sheen, 1.0f);
  return max(1.0f - coat, 0.0f) * (1.0f - sheen);
}

// GGX alphas of the specular lobe along the tangent and across.
SHARED_FN vec2 SpecularAlphas(SHARED_IN(BsdfInput) surface, SHARED_IN(SurfaceLayers) layers) {
  float least = surface.alpha > surface.own_alpha ? surface.alpha : 0.0f;  // regularisation's
  return AnisotropicAlpha(surface.own_alpha, layers.anisotropy, least);
}

// Visible normals over which a film is averaged: the mean reflectance is off by less than 0.015, as
// BsdfTest has it, with half of them by 0.025.
const int kFilmNormals = 16;

// A microfacet normal that the viewer sees, and the part of the light from its direction of
// reflection that is not shadowed.
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

// Means of a film's reflectance over the lobes.
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

// Replaces the Fresnel term of glass. `of_glass`: without a film, then with it.
// \param all     the share of light that the lobe would reflect if it reflected everything
// \param cosine  of the viewer's direction with the normal by which `of_glass` was found
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
  // The share that would be transmitted if everything were.
  float transmits =
      (of_glass.total - of_glass.reflected) / max(1.0f - of_glass.reflected / all, 0.1f);
  float reflects = weight > 0.0f ? most / weight : 1.0f;
  of_glass.reflected = reflects * all;
  of_glass.total = of_glass.reflected + (1.0f - reflects) * transmits;
  bsdf.glass_compensation = 1.0f / max(of_glass.total, 0.1f);
  bsdf.sheet_reflectance = of_glass.reflected;
}

// The share of light that a smooth thin sheet reflects.
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
// \param share         of the specular lobe
// \param glass_cosine  of the viewer's direction with the normal by which `of_glass` was found
// \param of_glass      without a film, then with it; used only if GlassWeight is above 0
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

  // As MakeBsdf does without a film, with the mean in place of f0 and f90.
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
// \param share          of the specular lobe
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
  // Sheen that would reflect more than there is, is scaled to reflect everything.
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
  // The largest component, so that light below a coloured boundary stays without colour.
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

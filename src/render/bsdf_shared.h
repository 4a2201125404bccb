// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The BSDF: glTF 2.0 metallic-roughness with transmission, as
//   diffuse    Lambert, scaled by the transmittance of the dielectric boundary above it
//   specular   GGX reflection, Schlick Fresnel between f0 and f90 (boundary and metal in one lobe)
//   through    Lambertian transmission: diffuse light that leaves on the far side
//   sheen      sheen of cloth, layered above the lobes listed so far
//   coat       GGX reflection of a clear coat, above all others
//   glass      GGX reflection and refraction, exact Fresnel (Walter et al. 2007), or a thin sheet
// A thin film may replace the Fresnel terms of the specular lobe and of glass.
// The rough lobes are scaled to compensate the energy loss of single scattering (Turquin 2019,
// "Practical multiple scattering compensation for microfacet models"): a white surface reflects all
// light. Lobes below a layer are scaled by one minus the directional albedo of the layer, so that
// layers conserve energy. Directions are local, z along the shading normal; wo.z > 0 always.
//
// Paths carry "basic radiance", L / n^2, which refraction preserves: a path that enters a solid and
// leaves it again carries the same radiance as with both n^2 factors.
#ifndef STILLRAY_RENDER_BSDF_SHARED_H
#define STILLRAY_RENDER_BSDF_SHARED_H

#ifdef __cplusplus
#include "render/film_shared.h"
#include "render/geometry_shared.h"
#include "render/ggx_shared.h"
#include "render/sheen_shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct Bsdf {
  vec3 diffuse;              // reflectance of the diffuse lobe, below the boundary
  float diffuse_share;       // share of the diffuse lobe without its colour
  vec3 specular_f0;          // reflectance at normal incidence
  vec3 specular_scale;       // weight of the specular lobe times its energy compensation
  vec3 tint;                 // transmission colour
  float specular_f90;        // reflectance at grazing incidence
  float specular_alpha;      // 0 = ideally smooth
  float glass_weight;        // of reflection and transmission together
  float glass_compensation;  // energy compensation
  float glass_alpha;         // 0 = ideally smooth
  // relative refractive index, far side over near side; refractive index of the sheet if thin
  float eta;
  float sheet_reflectance;  // reflectance of a smooth thin sheet, with the geometric normal
  int thin;                 // 1: transmission is undeflected
  float pick_diffuse;       // selection probabilities of the lobes; sum 1, or 0 if black
  float pick_specular;
  float pick_glass;
  int layered;  // 1: the members below are set too
  vec3 coat_normal;
  float coat_scale;   // weight of the clear coat times its energy compensation
  float coat_alpha;   // 0 = ideally smooth
  float coat_albedo;  // its directional albedo
  float pick_coat;
  vec3 sheen;         // factor of EvaluateSheen
  vec3 sheen_albedo;  // its directional albedo
  float sheen_alpha;
  float pick_sheen;
  vec3 through;  // transmittance of the diffuse lobe
  float pick_through;
  vec2 tangent;         // local direction along which an anisotropic specular lobe is stretched
  float tangent_alpha;  // GGX alpha along it, `specular_alpha` is that across it; 0 = isotropic
  float film;           // weight of the thin film; above 0: the members below are set too
  float film_ior;
  float film_thickness;  // nm
  float film_metal;      // weights of the film's reflectance over metal with F0 `tint`
  float film_boundary;   // and over the dielectric boundary
  vec3 film_f0;          // F0 of the dielectric boundary
  vec3 film_mean;        // mean of the film's weighted reflectance over the specular lobe
  vec3 film_sheet;       // colour of light reflected by glass, its largest component is 1
};

// Reflectance of the clear coat at normal incidence: ior 1.5.
const float kCoatF0 = 0.04f;
// The smallest cosine of a direction with the clear coat's normal.
const float kLeastCoatCosine = 1e-3f;

// BSDF times |cos| per lobe, and the solid angle density (PDF) of SampleBsdf, both without ideally
// smooth lobes.
struct BsdfValue {
  vec3 diffuse;
  vec3 specular;
  float density;
};

// Subsets of the lobes that are sampled and evaluated separately: a random choice between
// reflection and transmission by glass would add noise to both.
const int kAllLobes = 0;
const int kLobesWithoutReflection = 1;  // all but the reflection of glass
const int kReflectionOfGlass = 2;

const int kScatterNone = 0;      // no valid sample: the path ends
const int kScatterRough = 1;     // finite density
const int kScatterMirror = 2;    // ideal reflection
const int kScatterRefract = 3;   // ideal refraction
const int kScatterStraight = 4;  // straight through a smooth thin sheet

struct BsdfSample {
  vec3 wi;
  vec3 diffuse;   // f cos / density
  vec3 specular;  // f cos / density; share / probability for ideally smooth lobes
  float density;  // PDF of all rough lobes; 0 for ideally smooth lobes
  int kind;
};

// A GGX lobe without its Fresnel term: BRDF times |cos|, the PDF of sampling visible normals, and
// Schlick's weight.
struct GgxValue {
  float value;
  float density;
  float schlick;
};

// GgxDensity(h) / (4 cos) over 1 + Lambda(wo) + Lambda(wi), and over 1 + Lambda(wo), for the half
// vector h of two directions above the surface. With m = wo + wi not normalised and T(w) =
// sqrt(w.z^2 + alpha^2 (1 - w.z^2)), so that 1 + 2 Lambda(w) = T(w) / w.z, this takes few
// divisions; the cosine of wo and h is |m| / 2.
SHARED_FN GgxValue EvaluateGgx(float alpha, vec3 wo, vec3 wi) {
  float alpha2 = alpha * alpha;
  vec3 m = wo + wi;
  float across2 = m.x * m.x + m.y * m.y;
  float length2 = across2 + m.z * m.z;
  float e = (across2 + alpha2 * m.z * m.z) / length2;
  float to = sqrt(wo.z * wo.z + alpha2 * (wo.x * wo.x + wo.y * wo.y));
  float ti = sqrt(wi.z * wi.z + alpha2 * (wi.x * wi.x + wi.y * wi.y));
  float d = alpha2 * (0.5f * kInvPi) / (e * e);
  GgxValue lobe;
  lobe.value = d * wi.z / (to * wi.z + ti * wo.z);
  lobe.density = d / (wo.z + to);
  lobe.schlick = SchlickWeight(0.5f * sqrt(length2));
  return lobe;
}

// EvaluateGgx for an anisotropic lobe: alpha.x along x, alpha.y along y.
SHARED_FN GgxValue EvaluateGgxOf2(vec2 alpha, vec3 wo, vec3 wi) {
  float alpha2 = alpha.x * alpha.y;
  vec3 m = wo + wi;
  float ratio = alpha.y / alpha.x;
  float across2 = m.x * m.x * ratio + m.y * m.y / ratio;
  float length2 = dot(m, m);
  float e = (across2 + alpha2 * m.z * m.z) / length2;
  vec3 o = vec3(alpha.x * wo.x, alpha.y * wo.y, wo.z);
  vec3 i = vec3(alpha.x * wi.x, alpha.y * wi.y, wi.z);
  float to = length(o);
  float ti = length(i);
  float d = alpha2 * (0.5f * kInvPi) / (e * e);
  GgxValue lobe;
  lobe.value = d * wi.z / (to * wi.z + ti * wo.z);
  lobe.density = d / (wo.z + to);
  lobe.schlick = SchlickWeight(0.5f * sqrt(length2));
  return lobe;
}

SHARED_FN bool IsAnisotropic(SHARED_IN(Bsdf) bsdf) {
  return bsdf.layered != 0 && bsdf.tangent_alpha > 0.0f;
}

// Rotates a direction about the normal so that the tangent becomes the x axis, and back.
SHARED_FN vec3 ToTangent(vec2 tangent, vec3 w) {
  return vec3(w.x * tangent.x + w.y * tangent.y, w.y * tangent.x - w.x * tangent.y, w.z);
}
SHARED_FN vec3 FromTangent(vec2 tangent, vec3 w) {
  return vec3(w.x * tangent.x - w.y * tangent.y, w.y * tangent.x + w.x * tangent.y, w.z);
}

SHARED_FN GgxValue EvaluateSpecularLobe(SHARED_IN(Bsdf) bsdf, vec3 wo, vec3 wi) {
  if (IsAnisotropic(bsdf)) {
    return EvaluateGgxOf2(vec2(bsdf.tangent_alpha, bsdf.specular_alpha),
                          ToTangent(bsdf.tangent, wo), ToTangent(bsdf.tangent, wi));
  }
  return EvaluateGgx(bsdf.specular_alpha, wo, wi);
}

// Samples a visible microfacet normal of the specular lobe.
SHARED_FN vec3 SampleSpecularNormal(SHARED_IN(Bsdf) bsdf, vec3 wo, float u0, float u1) {
  if (IsAnisotropic(bsdf)) {
    return FromTangent(bsdf.tangent,
                       SampleGgxVisibleOf2(ToTangent(bsdf.tangent, wo),
                                           vec2(bsdf.tangent_alpha, bsdf.specular_alpha), u0, u1));
  }
  return SampleGgxVisible(wo, bsdf.specular_alpha, u0, u1);
}

// Alpha of the isotropic lobe with the same peak as the specular lobe.
SHARED_FN float SpecularMeanAlpha(SHARED_IN(Bsdf) bsdf) {
  return IsAnisotropic(bsdf) ? sqrt(bsdf.tangent_alpha * bsdf.specular_alpha) : bsdf.specular_alpha;
}

SHARED_FN bool HasFilm(SHARED_IN(Bsdf) bsdf) {
  return bsdf.layered != 0 && bsdf.film > 0.0f;
}

// Reflectance of a film over the metal and the dielectric boundary together.
SHARED_FN vec3 SpecularFilm(SHARED_IN(Bsdf) bsdf, float cosine) {
  FilmView view = ViewFilm(min(cosine, 1.0f), bsdf.film_ior, bsdf.film_thickness);
  vec3 reflectance = vec3(0.0f);
  if (bsdf.film_metal > 0.0f) {
    reflectance += FilmReflectance(view, bsdf.tint) * bsdf.film_metal;
  }
  if (bsdf.film_boundary > 0.0f) {
    reflectance += FilmReflectance(view, bsdf.film_f0) * bsdf.film_boundary;
  }
  return reflectance;
}

// Fresnel term of the specular lobe.
// \param cosine  dot(wo, microfacet normal); \param schlick  Schlick's weight of that cosine
SHARED_FN vec3 SpecularFresnel(SHARED_IN(Bsdf) bsdf, float cosine, float schlick) {
  vec3 fresnel = bsdf.specular_f0 * (1.0f - schlick) + vec3(bsdf.specular_f90 * schlick);
  return HasFilm(bsdf) ? mix(fresnel, SpecularFilm(bsdf, cosine), bsdf.film) : fresnel;
}

// Fresnel term of glass: the reflectance is share * colour, where the largest component of `colour`
// is 1. The transmittance is 1 - share in all channels, so that objects behind a film do not take
// the complementary colour.
struct GlassFresnel {
  float share;
  vec3 colour;
};

// Reflectance of glass below a film: equal from both sides along the same refracted ray.
SHARED_FN vec3 GlassFilm(SHARED_IN(Bsdf) bsdf, float cosine, float plain) {
  float c = min(cosine, 1.0f);
  float inside = 1.0f - (1.0f - c * c) / (bsdf.eta * bsdf.eta);
  if (bsdf.eta < 1.0f) {
    if (inside <= 0.0f) {
      return vec3(1.0f);
    }
    c = sqrt(inside);
  }
  float r = (bsdf.eta - 1.0f) / (bsdf.eta + 1.0f);
  FilmView view = ViewFilm(c, bsdf.film_ior, bsdf.film_thickness);
  return mix(vec3(plain), FilmReflectance(view, vec3(r * r)), bsdf.film);
}

SHARED_FN GlassFresnel FresnelOfGlass(SHARED_IN(Bsdf) bsdf, float cosine) {
  GlassFresnel fresnel;
  fresnel.colour = vec3(1.0f);
  if (HasFilm(bsdf)) {
    vec3 r = GlassFilm(bsdf, cosine, FresnelDielectric(cosine, bsdf.eta));
    r = bsdf.thin != 0 ? 2.0f * r / (vec3(1.0f) + r) : r;
    fresnel.share = MaxComponent(r);
    fresnel.colour = r / max(fresnel.share, 1e-6f);
  } else {
    fresnel.share =
        bsdf.thin != 0 ? FresnelThinSheet(cosine, bsdf.eta) : FresnelDielectric(cosine, bsdf.eta);
  }
  return fresnel;
}

SHARED_FN BsdfValue EvaluateSpecular(SHARED_IN(Bsdf) bsdf, vec3 wo, vec3 wi) {
  GgxValue lobe = EvaluateSpecularLobe(bsdf, wo, wi);
  vec3 fresnel = SpecularFresnel(bsdf, 0.5f * length(wo + wi), lobe.schlick);
  BsdfValue value;
  value.diffuse = vec3(0.0f);
  value.specular = bsdf.specular_scale * fresnel * lobe.value;
  value.density = lobe.density;
  return value;
}

// Schlick Fresnel term of the clear coat.
SHARED_FN float CoatFresnel(float schlick) {
  return kCoatF0 + (1.0f - kCoatF0) * schlick;
}

// Transforms w from the local frame to the frame of the clear coat.
SHARED_FN vec3 ToCoat(SHARED_IN(LocalFrame) coat, vec3 w) {
  vec3 local = ToLocal(coat, w);
  return vec3(local.x, local.y, max(local.z, kLeastCoatCosine));
}

// Adds the values of those layer lobes that are not ideally smooth. wi.z must not be 0.
SHARED_FN void AddLayerValues(SHARED_IN(Bsdf) bsdf, vec3 wo, vec3 wi,
                              SHARED_INOUT(BsdfValue) value) {
  if (wi.z <= 0.0f) {
    value.diffuse += bsdf.through * (-wi.z * kInvPi);
    value.density += bsdf.pick_through * (-wi.z * kInvPi);
    return;
  }
  if (bsdf.pick_sheen > 0.0f) {
    value.diffuse += bsdf.sheen * EvaluateSheen(wo, wi, bsdf.sheen_alpha);
    value.density += bsdf.pick_sheen * (0.5f * kInvPi);
  }
  if (bsdf.pick_coat > 0.0f && bsdf.coat_alpha > 0.0f && dot(wi, bsdf.coat_normal) > 0.0f) {
    LocalFrame frame = MakeLocalFrame(bsdf.coat_normal);
    GgxValue lobe = EvaluateGgx(bsdf.coat_alpha, ToCoat(frame, wo), ToLocal(frame, wi));
    value.specular += vec3(bsdf.coat_scale * CoatFresnel(lobe.schlick) * lobe.value);
    value.density += bsdf.pick_coat * lobe.density;
  }
}

// The rough glass lobe.
struct GlassValue {
  vec3 value;
  float density;  // PDF given that the sample is on this side
  float share;    // reflectance or transmittance, depending on the side
};

// Rough thin sheet: the transmission lobe is the reflection lobe mirrored at the surface.
SHARED_FN GlassValue EvaluateSheet(SHARED_IN(Bsdf) bsdf, vec3 wo, vec3 wi) {
  vec3 up = vec3(wi.x, wi.y, abs(wi.z));
  vec3 h = normalize(wo + up);
  float lambda_o = GgxLambda(wo, bsdf.glass_alpha);
  float lambda_i = GgxLambda(up, bsdf.glass_alpha);
  float d = GgxDensity(h, bsdf.glass_alpha) / (4.0f * wo.z);
  GlassFresnel fresnel = FresnelOfGlass(bsdf, dot(wo, h));
  vec3 colour = wi.z > 0.0f ? fresnel.colour : bsdf.tint;
  float scale = bsdf.glass_weight * bsdf.glass_compensation;
  GlassValue glass;
  glass.share = wi.z > 0.0f ? fresnel.share : 1.0f - fresnel.share;
  glass.value = colour * (scale * glass.share * d / (1.0f + lambda_o + lambda_i));
  glass.density = d / (1.0f + lambda_o);
  return glass;
}

// Rough boundary of a solid: Walter et al. 2007, eq. 20 and 21, G height-correlated for both sides.
SHARED_FN GlassValue EvaluateBoundary(SHARED_IN(Bsdf) bsdf, vec3 wo, vec3 wi) {
  GlassValue glass;
  glass.value = vec3(0.0f);
  glass.density = 0.0f;
  glass.share = 0.0f;
  vec3 h = wi.z > 0.0f ? normalize(wo + wi) : normalize(wo + bsdf.eta * wi);
  h = h.z < 0.0f ? -h : h;
  float cos_o = dot(wo, h);
  float cos_i = dot(wi, h);
  if (cos_o <= 0.0f || cos_i * wi.z <= 0.0f) {
    return glass;
  }
  float lambda_o = GgxLambda(wo, bsdf.glass_alpha);
  float lambda_i = GgxLambda(wi, bsdf.glass_alpha);
  GlassFresnel fresnel = FresnelOfGlass(bsdf, cos_o);
  float jacobian;  // d(solid angle of h) / d(solid angle of wi)
  vec3 colour = fresnel.colour;
  if (wi.z > 0.0f) {
    glass.share = fresnel.share;
    jacobian = 1.0f / (4.0f * cos_o);
  } else {
    float denominator = cos_o + bsdf.eta * cos_i;
    glass.share = 1.0f - fresnel.share;
    jacobian = bsdf.eta * bsdf.eta * abs(cos_i) / max(denominator * denominator, 1e-12f);
    colour = bsdf.tint;
  }
  float d = GgxDensity(h, bsdf.glass_alpha) * cos_o * jacobian / wo.z;
  float scale = bsdf.glass_weight * bsdf.glass_compensation;
  glass.value = colour * (scale * glass.share * d / (1.0f + lambda_o + lambda_i));
  glass.density = d / (1.0f + lambda_o);
  return glass;
}

// Selection probability of the glass lobe within this subset of the lobes.
SHARED_FN float PickGlass(SHARED_IN(Bsdf) bsdf, int part) {
  return part == kReflectionOfGlass ? 1.0f : bsdf.pick_glass;
}

// Whether a sample of the glass lobe is a reflection.
SHARED_FN bool Reflects(float u, float share, int part) {
  return part == kAllLobes ? u < share : part == kReflectionOfGlass;
}

// Adds the rough glass lobe to the values of this subset of the lobes.
SHARED_FN void AddGlassValue(SHARED_IN(Bsdf) bsdf, vec3 wo, vec3 wi, int part,
                             SHARED_INOUT(BsdfValue) value) {
  if (part != kAllLobes && (wi.z > 0.0f) != (part == kReflectionOfGlass)) {
    return;
  }
  GlassValue glass;
  if (bsdf.thin != 0) {
    glass = EvaluateSheet(bsdf, wo, wi);
  } else {
    glass = EvaluateBoundary(bsdf, wo, wi);
  }
  value.specular += glass.value;
  value.density += PickGlass(bsdf, part) * glass.density * (part == kAllLobes ? glass.share : 1.0f);
}

// \param part  kAllLobes, ...
SHARED_FN BsdfValue EvaluateBsdf(SHARED_IN(Bsdf) bsdf, vec3 wo, vec3 wi, int part) {
  BsdfValue value;
  value.diffuse = vec3(0.0f);
  value.specular = vec3(0.0f);
  value.density = 0.0f;
  bool others = part != kReflectionOfGlass;
  if (others && wi.z > 0.0f) {
    value.diffuse = bsdf.diffuse * (wi.z * kInvPi);
    value.density = bsdf.pick_diffuse * wi.z * kInvPi;
    if (bsdf.pick_specular > 0.0f && bsdf.specular_alpha > 0.0f) {
      BsdfValue specular = EvaluateSpecular(bsdf, wo, wi);
      value.specular += specular.specular;
      value.density += bsdf.pick_specular * specular.density;
    }
  }
  if (wi.z != 0.0f && bsdf.pick_glass > 0.0f && bsdf.glass_alpha > 0.0f) {
    AddGlassValue(bsdf, wo, wi, part, value);
  }
  if (others && bsdf.layered != 0) {
    AddLayerValues(bsdf, wo, wi, value);
  }
  return value;
}

// Samples a direction with density proportional to its cosine with z. u in [0,1)^2.
SHARED_FN vec3 SampleCosine(float u0, float u1) {
  float r = sqrt(u0);
  vec2 turn = CosSinOfTurn(u1);
  return vec3(r * turn.x, r * turn.y, sqrt(max(1.0f - u0, 1e-12f)));
}

// Samples the ideally smooth glass lobe. `u` selects reflection or transmission.
SHARED_FN BsdfSample SampleSmoothGlass(SHARED_IN(Bsdf) bsdf, vec3 wo, float u, int part) {
  BsdfSample result;
  result.diffuse = vec3(0.0f);
  result.density = 0.0f;
  float share = bsdf.glass_weight / PickGlass(bsdf, part);
  GlassFresnel fresnel;
  if (bsdf.thin != 0) {
    fresnel.share = bsdf.sheet_reflectance;
    fresnel.colour = HasFilm(bsdf) ? bsdf.film_sheet : vec3(1.0f);
  } else {
    fresnel = FresnelOfGlass(bsdf, wo.z);
  }
  if (Reflects(u, fresnel.share, part)) {
    share *= part == kAllLobes ? 1.0f : fresnel.share;
    result.wi = vec3(-wo.x, -wo.y, wo.z);
    result.specular = share * fresnel.colour;
    result.kind = kScatterMirror;
  } else {
    share *= part == kAllLobes ? 1.0f : 1.0f - fresnel.share;
    result.wi = bsdf.thin != 0 ? -wo : RefractAbout(wo, vec3(0.0f, 0.0f, 1.0f), bsdf.eta);
    result.specular = share * bsdf.tint;
    result.kind = bsdf.thin != 0 ? kScatterStraight : kScatterRefract;
  }
  result.kind = share > 0.0f ? result.kind : kScatterNone;
  return result;
}

// Direction scattered by the rough glass lobe at the microfacet normal h; z of either sign. Zero if
// the scattered direction is on the wrong side of the surface: energy compensation accounts for
// that loss.
SHARED_FN vec3 SampleRoughGlass(SHARED_IN(Bsdf) bsdf, vec3 wo, vec3 h, float u, int part) {
  float cos_o = dot(wo, h);
  vec3 reflected = 2.0f * cos_o * h - wo;
  bool reflects = Reflects(u, FresnelOfGlass(bsdf, cos_o).share, part);
  if (bsdf.thin != 0) {
    float side = reflects ? 1.0f : -1.0f;
    return reflected.z > 0.0f ? vec3(reflected.x, reflected.y, side * reflected.z) : vec3(0.0f);
  }
  if (reflects) {
    return reflected.z > 0.0f ? reflected : vec3(0.0f);
  }
  // A subset without reflection samples transmission even under total internal reflection.
  bool total = 1.0f - cos_o * cos_o >= bsdf.eta * bsdf.eta;
  vec3 refracted = RefractAbout(wo, h, bsdf.eta);
  return refracted.z < 0.0f && !total ? refracted : vec3(0.0f);
}

// Samples the ideally smooth specular lobe.
SHARED_FN BsdfSample SampleMirror(SHARED_IN(Bsdf) bsdf, vec3 wo) {
  BsdfSample result;
  vec3 fresnel = SpecularFresnel(bsdf, wo.z, SchlickWeight(wo.z));
  result.wi = vec3(-wo.x, -wo.y, wo.z);
  result.diffuse = vec3(0.0f);
  result.specular = fresnel * bsdf.specular_scale / bsdf.pick_specular;
  result.density = 0.0f;
  result.kind = kScatterMirror;
  return result;
}

// Samples the ideally smooth clear coat.
SHARED_FN BsdfSample SampleSmoothCoat(SHARED_IN(Bsdf) bsdf, vec3 wo) {
  BsdfSample result;
  float cosine = dot(wo, bsdf.coat_normal);
  result.wi = 2.0f * cosine * bsdf.coat_normal - wo;
  result.diffuse = vec3(0.0f);
  result.specular = vec3(CoatFresnel(SchlickWeight(cosine)) * bsdf.coat_scale / bsdf.pick_coat);
  result.density = 0.0f;
  result.kind = result.wi.z > 0.0f ? kScatterMirror : kScatterNone;
  return result;
}

// Samples the hemisphere uniformly; sufficient for sheen, whose lobe is broad and bounded.
SHARED_FN vec3 SampleHemisphere(float u0, float u1) {
  float z = max(1.0f - u0, 1e-6f);
  vec2 turn = CosSinOfTurn(u1);
  float r = sqrt(max(1.0f - z * z, 0.0f));
  return vec3(r * turn.x, r * turn.y, z);
}

// Samples the rough clear coat; zero if the direction is below the surface.
SHARED_FN vec3 SampleRoughCoat(SHARED_IN(Bsdf) bsdf, vec3 wo, vec4 u) {
  LocalFrame frame = MakeLocalFrame(bsdf.coat_normal);
  vec3 local = ToCoat(frame, wo);
  vec3 h = SampleGgxVisible(local, bsdf.coat_alpha, u.x, u.y);
  vec3 in_coat = 2.0f * dot(local, h) * h - local;
  vec3 wi = ToWorld(frame, in_coat);
  return min(in_coat.z, wi.z) > 0.0f ? wi : vec3(0.0f);
}

// Samples a direction from the layer lobes that are not ideally smooth; zero if sampling fails.
// \param past  u.z minus the selection probabilities of the other lobes
SHARED_FN vec3 SampleLayers(SHARED_IN(Bsdf) bsdf, vec3 wo, vec4 u, float past) {
  if (bsdf.pick_coat > 0.0f && past >= bsdf.pick_through + bsdf.pick_sheen) {
    return SampleRoughCoat(bsdf, wo, u);
  }
  if (bsdf.pick_sheen > 0.0f && past >= bsdf.pick_through) {
    return SampleHemisphere(u.x, u.y);
  }
  return bsdf.pick_through > 0.0f ? -SampleCosine(u.x, u.y) : vec3(0.0f);
}

// Samples the BSDF. (u.x, u.y) select the direction, u.z the lobe, u.w reflection or transmission.
// \param part  kAllLobes, ...
SHARED_FN BsdfSample SampleBsdf(SHARED_IN(Bsdf) bsdf, vec3 wo, vec4 u, int part) {
  BsdfSample result;
  result.wi = vec3(0.0f);
  result.diffuse = vec3(0.0f);
  result.specular = vec3(0.0f);
  result.density = 0.0f;
  result.kind = kScatterNone;
  float past = u.z - (bsdf.pick_diffuse + bsdf.pick_specular + bsdf.pick_glass);
  bool glass = part == kReflectionOfGlass;
  if (!glass && bsdf.layered != 0 && past >= 0.0f) {
    if (bsdf.pick_coat > 0.0f && bsdf.coat_alpha <= 0.0f &&
        past >= bsdf.pick_through + bsdf.pick_sheen) {
      return SampleSmoothCoat(bsdf, wo);
    }
    result.wi = SampleLayers(bsdf, wo, u, past);
  } else if (!glass && u.z < bsdf.pick_diffuse) {
    result.wi = SampleCosine(u.x, u.y);
  } else if (!glass && (u.z < bsdf.pick_diffuse + bsdf.pick_specular || bsdf.pick_glass <= 0.0f)) {
    if (bsdf.pick_specular <= 0.0f) {
      return result;
    }
    if (bsdf.specular_alpha <= 0.0f) {
      return SampleMirror(bsdf, wo);
    }
    vec3 h = SampleSpecularNormal(bsdf, wo, u.x, u.y);
    result.wi = 2.0f * dot(wo, h) * h - wo;
    result.wi.z = max(result.wi.z, 0.0f);
  } else {
    if (bsdf.glass_alpha <= 0.0f) {
      return SampleSmoothGlass(bsdf, wo, u.w, part);
    }
    vec3 h = SampleGgxVisible(wo, bsdf.glass_alpha, u.x, u.y);
    result.wi = SampleRoughGlass(bsdf, wo, h, u.w, part);
  }
  if (result.wi.z == 0.0f) {
    return result;
  }
  BsdfValue value = EvaluateBsdf(bsdf, wo, result.wi, part);
  if (value.density <= 0.0f) {
    return result;
  }
  result.diffuse = value.diffuse / value.density;
  result.specular = value.specular / value.density;
  result.density = value.density;
  result.kind = kScatterRough;
  return result;
}

// MIS weight of one of two strategies: the power heuristic of Veach (1997), beta 2.
SHARED_FN float MisWeight(float density, float other_density) {
  float ratio = other_density / density;
  return 1.0f / (1.0f + ratio * ratio);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_BSDF_SHARED_H

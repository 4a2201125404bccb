// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The GGX microfacet distribution (Walter et al. 2007; anisotropic: Burley 2012) with the
// height-correlated Smith shadowing of Heitz (2014), and Fresnel terms. Directions are in the local
// frame of the surface: z along the shading normal, pointing away from the surface; x and y along
// the two alphas of an anisotropic surface.
#ifndef STILLRAY_RENDER_GGX_SHARED_H
#define STILLRAY_RENDER_GGX_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Largest GGX alpha that is treated as ideally smooth: a float cannot resolve narrower lobes, and
// no pixel differs from that of a mirror.
const float kSmoothAlpha = 1e-3f;

// GGX alpha of a perceptual roughness.
SHARED_FN float AlphaOfRoughness(float roughness) {
  float alpha = roughness * roughness;
  return alpha <= kSmoothAlpha ? 0.0f : alpha;
}

// Distribution of microfacet normals D(h). sin^2 is computed from x and y: 1 - z^2 suffers
// cancellation for narrow lobes.
SHARED_FN float GgxDensity(vec3 h, float alpha) {
  float alpha2 = alpha * alpha;
  float d = h.x * h.x + h.y * h.y + alpha2 * h.z * h.z;
  return alpha2 / (kPi * d * d);
}

// Smith's Lambda: 1 / (1 + Lambda) of the microfacets are visible from direction w.
SHARED_FN float GgxLambda(vec3 w, float alpha) {
  float tan2 = (w.x * w.x + w.y * w.y) / max(w.z * w.z, 1e-20f);
  return 0.5f * (sqrt(1.0f + alpha * alpha * tan2) - 1.0f);
}

// Samples a microfacet normal visible from wo, with PDF GgxVisibleDensity. u in [0,1)^2. Dupuy and
// Benyoub (2023), "Sampling Visible GGX Normals with Spherical Caps".
SHARED_FN vec3 SampleGgxVisible(vec3 wo, float alpha, float u0, float u1) {
  vec3 w = normalize(vec3(alpha * wo.x, alpha * wo.y, wo.z));
  vec2 turn = CosSinOfTurn(u0);
  float z = (1.0f - u1) * (1.0f + w.z) - w.z;
  float sin_theta = sqrt(clamp(1.0f - z * z, 0.0f, 1.0f));
  vec3 h = vec3(sin_theta * turn.x, sin_theta * turn.y, z) + w;
  return normalize(vec3(alpha * h.x, alpha * h.y, max(h.z, 1e-7f)));
}

// GgxLambda for an anisotropic surface: alpha.x along x, alpha.y along y.
SHARED_FN float GgxLambdaOf2(vec3 w, vec2 alpha) {
  float x = alpha.x * w.x;
  float y = alpha.y * w.y;
  float stretched2 = (x * x + y * y) / max(w.z * w.z, 1e-20f);
  return 0.5f * (sqrt(1.0f + stretched2) - 1.0f);
}
SHARED_FN vec3 SampleGgxVisibleOf2(vec3 wo, vec2 alpha, float u0, float u1) {
  vec3 w = normalize(vec3(alpha.x * wo.x, alpha.y * wo.y, wo.z));
  vec2 turn = CosSinOfTurn(u0);
  float z = (1.0f - u1) * (1.0f + w.z) - w.z;
  float sin_theta = sqrt(clamp(1.0f - z * z, 0.0f, 1.0f));
  vec3 h = vec3(sin_theta * turn.x, sin_theta * turn.y, z) + w;
  return normalize(vec3(alpha.x * h.x, alpha.y * h.y, max(h.z, 1e-7f)));
}

// Alphas along the tangent and across of KHR_materials_anisotropy.
// \param alpha  alpha of the isotropic surface; 0 = ideally smooth
// \param least  minimum of both alphas
// \return two equal alphas if the lobe is as narrow as that of an ideally smooth surface
SHARED_FN vec2 AnisotropicAlpha(float alpha, float strength, float least) {
  float along = mix(alpha, 1.0f, strength * strength);
  if (along <= kSmoothAlpha) {
    return vec2(max(alpha, least));
  }
  return max(vec2(along, alpha), vec2(max(least, kSmoothAlpha)));
}

// PDF of SampleGgxVisible per solid angle at h; wo . h > 0.
SHARED_FN float GgxVisibleDensity(vec3 wo, vec3 h, float alpha) {
  return GgxDensity(h, alpha) * max(dot(wo, h), 0.0f) /
         ((1.0f + GgxLambda(wo, alpha)) * max(wo.z, 1e-7f));
}

// Schlick's weight (1 - cos)^5.
SHARED_FN float SchlickWeight(float cos_theta) {
  float m = clamp(1.0f - cos_theta, 0.0f, 1.0f);
  float m2 = m * m;
  return m2 * m2 * m;
}

// Fresnel reflectance of a smooth dielectric boundary for unpolarised light; 1 under total internal
// reflection. eta = transmitted over incident refractive index, incident on the side of cos_theta
// >= 0.
SHARED_FN float FresnelDielectric(float cos_theta, float eta) {
  float sin2_t = (1.0f - cos_theta * cos_theta) / (eta * eta);
  if (sin2_t >= 1.0f) {
    return 1.0f;
  }
  float cos_t = sqrt(1.0f - sin2_t);
  float parallel = (eta * cos_theta - cos_t) / (eta * cos_theta + cos_t);
  float perpendicular = (cos_theta - eta * cos_t) / (cos_theta + eta * cos_t);
  return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

// Reflectance of a thin plane-parallel sheet: the sum over all interreflections of its two faces, R
// + T R T + T R^3 T + ... = 2 R / (1 + R).
SHARED_FN float FresnelThinSheet(float cos_theta, float ior) {
  float r = FresnelDielectric(cos_theta, ior);
  return 2.0f * r / (1.0f + r);
}

// Refraction of w, on the side of the normal h; undefined under total internal reflection.
SHARED_FN vec3 RefractAbout(vec3 w, vec3 h, float eta) {
  float cos_i = dot(w, h);
  float sin2_t = (1.0f - cos_i * cos_i) / (eta * eta);
  float cos_t = sqrt(max(1.0f - sin2_t, 0.0f));
  return normalize(h * (cos_i / eta - cos_t) - w / eta);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_GGX_SHARED_H

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Reflectance of a base below a thin dielectric film (Belcour and Barla 2017, "A Practical
// Extension to Microfacet Theory for the Modeling of Varying Iridescence"), as
// KHR_materials_iridescence simplifies it: unpolarised, in colours instead of wavelengths.
// Departures from the extension's text: the outer face has the exact Fresnel reflectance, and
// interference is scaled to be colourless at thickness 0, so that a film with the refractive index
// of air, or without thickness, has the reflectance of the base; and the reflectance of each colour
// channel is at most 1.
#ifndef STILLRAY_RENDER_FILM_SHARED_H
#define STILLRAY_RENDER_FILM_SHARED_H

#ifdef __cplusplus
#include "render/ggx_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// The terms of a film's reflectance at one viewing angle that do not depend on the base below.
struct FilmView {
  float ior;
  float outer;     // reflectance of the outer face
  float cosine;    // cosine of the refracted ray inside the film
  vec3 spread[2];  // FilmSpread of one and of two passes through the film
};

// Interference term per colour channel for the optical path difference `path` in nm: the mean of
// cos(2 pi path / wavelength) over linear sRGB's colour matching functions, which are the Gaussians
// of the paper's supplemental code. 1 at 0.
SHARED_FN vec3 FilmSpread(float path) {
  float phase = 2.0f * kPi * 1e-9f * path;
  float phase2 = phase * phase;
  // The amplitudes sum to CIE X, Y, Z of a constant spectrum of 1; X has two lobes.
  float x = 0.846590f * cos(1.6810e6f * phase) * exp(-4.3278e9f * phase2) +
            0.153868f * cos(2.2399e6f * phase) * exp(-4.5282e9f * phase2);
  float y = 1.000222f * cos(1.7953e6f * phase) * exp(-9.3046e9f * phase2);
  float z = 1.001122f * cos(2.2084e6f * phase) * exp(-6.6121e9f * phase2);
  vec3 rgb = vec3(3.2404542f * x - 1.5371385f * y - 0.4985314f * z,
                  -0.9692660f * x + 1.8760108f * y + 0.0415560f * z,
                  0.0556434f * x - 0.2040259f * y + 1.0572252f * z);
  // White point of the constant spectrum, which differs from sRGB's.
  const vec3 kWhite = vec3(1.205369f, 0.948319f, 0.910010f);
  return rgb / kWhite;
}

// \param cosine     dot(wo, microfacet normal), in air
// \param ior        refractive index of the film, at least 1
// \param thickness  nm
SHARED_FN FilmView ViewFilm(float cosine, float ior, float thickness) {
  FilmView film;
  film.ior = ior;
  film.outer = FresnelDielectric(cosine, ior);
  film.cosine = sqrt(max(1.0f - (1.0f - cosine * cosine) / (ior * ior), 0.0f));
  float path = 2.0f * ior * thickness * film.cosine;
  film.spread[0] = FilmSpread(path);
  film.spread[1] = FilmSpread(2.0f * path);
  return film;
}

// One colour channel of FilmReflectance: the series over m internal reflections, m <= 2.
// \param f0  reflectance of the base in air at normal incidence
SHARED_FN float FilmChannel(SHARED_IN(FilmView) film, float f0, float once, float twice) {
  float root = sqrt(clamp(f0, 0.0f, 0.9999f));  // no refractive index has f0 = 1
  float ior = (1.0f + root) / (1.0f - root);
  float r = (ior - film.ior) / (ior + film.ior);
  float inner_f0 = r * r;
  // Media of equal refractive index have no boundary at grazing incidence either.
  float s = SchlickWeight(film.cosine);
  float inner = inner_f0 * (1.0f - s) + min(50.0f * inner_f0, 1.0f) * s;
  float through = 1.0f - film.outer;
  float around = film.outer * inner;  // attenuation per round trip in the film
  float below = through * through * inner / max(1.0f - around, 1e-6f);
  // Reflection by the denser medium shifts the phase by pi.
  float amplitude = (r > 0.0f ? -1.0f : 1.0f) * sqrt(around);
  float order = 2.0f * (below - through) * amplitude;
  return clamp(film.outer + below + order * (once + amplitude * twice), 0.0f, 1.0f);
}

SHARED_FN vec3 FilmReflectance(SHARED_IN(FilmView) film, vec3 f0) {
  return vec3(FilmChannel(film, f0.x, film.spread[0].x, film.spread[1].x),
              FilmChannel(film, f0.y, film.spread[0].y, film.spread[1].y),
              FilmChannel(film, f0.z, film.spread[0].z, film.spread[1].z));
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_FILM_SHARED_H

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The albedo that divides a frame's radiance if all of it is one signal.
#pragma once

#include "stillray/image.h"

namespace stillray::io {

/// Reflectance of a dielectric at normal incidence (refractive index 1.5).
inline constexpr float kDielectricReflectance = 0.04f;

/// Adds `weight` times `more` to `albedo`; planes of one size.
/// \param more  may be empty
void AddAlbedo(const Image3& more, float weight, Image3* albedo);

/// Sets the albedo to 1 where it belongs to another surface than the normal. Cycles traces mirrors
/// and glass to the first rough surface and writes the albedo and normal of that surface as
/// Denoising Albedo and Denoising Normal: at one sample per pixel both are random there. Elsewhere
/// the denoising normal is the normal in camera space, one linear map for the whole image. The map
/// is fitted robustly (iteratively reweighted least squares); radiance of outliers is not divided.
/// \param normal         as stored; zero where there is no surface
/// \param albedo_normal  as stored, of the surface that `albedo` belongs to
/// \param albedo         [in,out] planes of the same size
/// \return number of changed pixels
int64_t RejectRandomAlbedo(const Image3& normal, const Image3& albedo_normal, Image3* albedo);

}  // namespace stillray::io

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The albedo of all reflection together, which light that is one signal is divided by.
#pragma once

#include "stillray/image.h"

namespace stillray::io {

/// What a dielectric reflects at normal incidence (refractive index 1.5).
inline constexpr float kDielectricReflectance = 0.04f;

/// Adds `weight` times `more` to `albedo`; planes of one size.
/// \param more  may be empty
void AddAlbedo(const Image3& more, float weight, Image3* albedo);

/// Cycles follows mirrors and glass to the first rough surface and writes that one's albedo and
/// normal as Denoising Albedo and Denoising Normal: at one sample per pixel either is a matter of
/// chance there. Where no mirror was followed the denoising normal is the normal itself in the
/// camera's axes, one linear map for the whole picture. The map is fitted here without regard to
/// what it does not describe (iteratively reweighted least squares), and the albedo of pixels that
/// it does not describe becomes 1: their light is not divided.
/// \param normal         as stored; zero where there is no surface
/// \param albedo_normal  as stored, of the surface that `albedo` describes
/// \param albedo         [in,out] planes of the same size
/// \return number of the pixels that were changed
int64_t RejectRandomAlbedo(const Image3& normal, const Image3& albedo_normal, Image3* albedo);

}  // namespace stillray::io

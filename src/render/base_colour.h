// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Base colours whose textures are averaged over the pixel in which they are visible: the rays of a
/// frame all pass through one point of their pixels, so that textures with details below a pixel
/// would change from frame to frame.
#pragma once

#include "render/trace_context.h"

namespace stillray::render {

/// Whether frames with these settings have mean base colours (RenderSettings::filter_textures).
bool FiltersTextures(const RenderSettings& settings, const Scene& scene);

/// \param point  image position of the pixel's ray
PixelRays RaysBeside(const CameraView& view, vec2 point);

/// Whether BaseColourOf averages at this hit.
bool HasMeanColour(const TraceContext& context, const Hit& hit);

/// The base colour at the hit of a pixel's ray, or of its continuation along a specular chain:
/// averaged over the part of the triangle that the pixel covers if HasMeanColour, else that of the
/// hit point.
/// \param rays   the rays beside it, continued likewise; not used unless HasMeanColour
/// \param point  image position of the pixel's ray
vec3 BaseColourOf(const TraceContext& context, const Hit& hit, const PixelRays& rays, vec2 point);

}  // namespace stillray::render

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// select_guides: the guides of a layer of reflected or refracted light. Pixels whose surface is
/// smooth and shows a virtual image get the guides of the image, all other pixels those of the
/// surface. Pixels of moderately rough surfaces get the mean motion of the virtual images around
/// them (image_motion.h), if these motions agree. Source: none. PSVGF section 7 leaves open how
/// reflections are reprojected; the virtual image in a planar mirror lies on the pixel's ray, at a
/// distance equal to the path length. Pixels whose albedo is black in the layer have no radiance
/// there and are treated as having no surface: later stages skip them, and do not use them as dark
/// neighbours. No state; for the motion of rough surfaces, 3x3 pixels three apart are read, and the
/// pixel at the end of the motion. Reads 76, writes 40 bytes per pixel.
#pragma once

#include <type_traits>

#include "denoise/stages/select_guides_shared.h"
#include "stillray/frame.h"

namespace stillray {

struct SelectGuidesInput {
  const Guides* surface;
  const VirtualGuides* image;
  const Image1* roughness;  ///< empty: all surfaces are smooth
  const Image3* albedo;     ///< of the surface, the divisor of the signal; may be empty
  const Image3* previous_normal = nullptr;  ///< of the surface; nullptr or empty: not given
};

/// Allocates the planes that SelectGuides writes, if necessary, and empties all others.
inline void MakeSelectedPlanes(const SelectGuidesInput& in, Guides* out, Image3* albedo) {
  const int width = in.surface->depth.width();
  const int height = in.surface->depth.height();
  const auto make = [&](bool wanted, auto* plane) {
    using Planes = std::remove_pointer_t<decltype(plane)>;
    if (!wanted) {
      *plane = Planes();
    } else if (plane->width() != width || plane->height() != height) {
      *plane = Planes(width, height);
    }
  };
  make(true, &out->depth);
  make(true, &out->normal);
  make(!in.surface->motion.empty(), &out->motion);
  make(!in.surface->id.empty(), &out->id);
  make(true, &out->roughness);
  make(in.previous_normal != nullptr && !in.previous_normal->empty(), &out->previous_normal);
  make(!in.albedo->empty() || !in.image->albedo.empty(), albedo);
}

/// \param out     depth, normal and roughness are written; motion, id and previous normal too if
///     the surface has them. The roughness of pixels with virtual guides is kRoughnessOfImage, that
///     of others the surface's, or 1 if unknown; the previous normal of virtual images is 0
///     (unknown).
/// \param albedo  `in.albedo` times the albedo of the reflected or refracted surface; empty if both
///     are
namespace reference {
void SelectGuides(const SelectGuidesInput& in, const SelectGuidesParameters& parameters,
                  Guides* out, Image3* albedo);
}  // namespace reference
namespace cpu {
void SelectGuides(const SelectGuidesInput& in, const SelectGuidesParameters& parameters,
                  Guides* out, Image3* albedo);
}  // namespace cpu

}  // namespace stillray

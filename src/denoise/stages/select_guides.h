// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// select_guides: the guides of a layer of reflected or refracted light. Pixels whose surface is
/// smooth and shows a virtual image have the guides of the image, all others those of the surface.
/// Of these, pixels of moderately rough surfaces have the mean motion of the images around them
/// (image_motion.h), as far as those move alike.
/// Source: none. PSVGF section 7 leaves open how reflections are reprojected; the image of a
/// planar mirror lies on the pixel's ray, as far away as the path is long. Pixels whose albedo is
/// black in the layer have no light there, and so no surface: neighbours do not take them for dark
/// ones, and later stages skip them. No state; for the motion of rough surfaces 3x3 pixels three
/// apart are read, and the pixel that it leads to. Reads 76, writes 40 bytes per pixel.
#pragma once

#include <type_traits>

#include "denoise/stages/select_guides_shared.h"
#include "stillray/frame.h"

namespace stillray {

struct SelectGuidesInput {
  const Guides* surface;
  const VirtualGuides* image;
  const Image1* roughness;  ///< empty: all surfaces are smooth
  const Image3* albedo;     ///< of the surface, that divides the light; may be empty
  const Image3* previous_normal = nullptr;  ///< of the surface; nullptr or empty: not given
};

/// Allocates the planes that SelectGuides writes, if necessary; others become empty.
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

/// \param out     depth, normal and roughness are written; motion and id too if the surface has
///     them, and so is its previous normal. The roughness of pixels with virtual guides is
///     kRoughnessOfImage, that of others the surface's, or 1 if that is not known; the previous
///     normal of images is 0, not known.
/// \param albedo  `in.albedo` times the albedo of what is seen; empty if both are
namespace reference {
void SelectGuides(const SelectGuidesInput& in, const SelectGuidesParameters& parameters,
                  Guides* out, Image3* albedo);
}  // namespace reference
namespace cpu {
void SelectGuides(const SelectGuidesInput& in, const SelectGuidesParameters& parameters,
                  Guides* out, Image3* albedo);
}  // namespace cpu

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The motion that temporal antialiasing follows.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Replaces the motion of pixels whose light is almost all that of a virtual image by the motion of
/// the image: there edges and textures are those of what is seen.
/// \param surface   of the frame
/// \param selected  of the layer (see select_guides)
/// \param albedo    of the surface, that divides the layer's light; empty: white
/// \param other     of the surface, that divides the light of the other kind of image; empty: black
/// \param motion    [in,out] of the surface; unchanged if it is empty
void FollowImages(const Guides& surface, const Guides& selected, const Image3& albedo,
                  const Image3& other, Image2* motion);

}  // namespace stillray

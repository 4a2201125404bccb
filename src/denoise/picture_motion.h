// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What temporal antialiasing reads where the picture is that of a virtual image.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// The pixels whose light is almost all that of a virtual image.
/// \param surface   of the frame
/// \param selected  of the layer (see select_guides)
/// \param albedo    of the surface, that divides the layer's light; empty: white
/// \param other     of the surface, that divides the light of the other kind of image; empty: black
/// \param images    [out] depth of the image; 0: the pixel shows none, or more. Resized if needed.
///     Without motion all are 0.
void FindImages(const Guides& surface, const Guides& selected, const Image3& albedo,
                const Image3& other, Image1* images);

/// Replaces the motion of pixels that show an image by that of the image: there edges and textures
/// are those of what is seen. Beside the edge of an image that is nearer it is the motion of that
/// one. Pixels near silhouettes of the surface, and those whose image has no motion, keep theirs.
/// \param images        of FindImages
/// \param surface       of the frame
/// \param image_motion  of the layer
/// \param motion        [in,out] of the surface; unchanged if it is empty
void FollowImages(const Image1& images, const Guides& surface, const Image2& image_motion,
                  Image2* motion);

/// Replaces the number of samples in the light of pixels that show an image by that of the image's
/// light, which begins anew where the image was out of sight.
/// \param images        of FindImages
/// \param image_length  of the layer
/// \param length        [in,out] of the surface
void TakeLengths(const Image1& images, const Image1& image_length, Image1* length);

}  // namespace stillray

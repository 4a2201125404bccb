// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Motion of what mirrors, glass and convex surfaces show.
#pragma once

#include <cstdint>

#include "io/camera_fit.h"
#include "stillray/frame.h"
#include "stillray/image.h"

namespace stillray::io {

/// How an image moves.
enum class ImageKind : uint8_t {
  kNone,       ///< the pixel shows none
  kPlanar,     ///< in a planar mirror or pane: as the camera does at the image's depth
  kReflected,  ///< in a curved mirror: by the law of reflection (ReflectedMotion)
  kConvex,     ///< behind a convex surface: along with it, plus what the camera adds (ImageMotion)
  kSurface,    ///< through curved glass: with the glass
};

/// Why a file has no virtual guides, or why their motion is unknown.
enum class NoSeenGuides : uint8_t {
  kNone,      ///< it has some, or no mirror
  kLens,      ///< the depth of what is seen fits no camera
  kNormal,    ///< its normals are not those of the frame in other axes, or all are parallel
  kMotion,    ///< the motion is not that of a camera before a mostly static scene
  kOnePlane,  ///< all that stands still lies in one plane, so that motion at other depths is
              ///< unknown
  kFocal,     ///< the angle of view is unknown, by which hit distances become depths
};

/// What the motion of a frame's images depends on, beside the frame.
struct FrameImages {
  Plane<uint8_t> reflection;  ///< ImageKind of each pixel of Frame::reflection; empty: unknown
  Plane<uint8_t> refraction;  ///< likewise of Frame::refraction
  Lens lens;                  ///< of the depths of kReflected
  bool has_reflection_motion = false;          ///< the file gives that of Frame::reflection
  NoSeenGuides missing = NoSeenGuides::kNone;  ///< why images or their motion are missing
};

/// The motion of the camera, or why it is unknown.
NoSeenGuides WhyUnknown(CameraFits* fits);

/// Sets the motion of images.
/// \param kinds   ImageKind of each pixel of `images`; of kNone the motion is left alone
/// \param lens    FrameImages::lens
/// \param fits    to `guides`
/// \param guides  of the surfaces, with their motion
/// \param images  needs depth; its motion is of the same size
void SetImageMotion(const Plane<uint8_t>& kinds, const Lens& lens, const CameraMotion& camera,
                    CameraFits* fits, const Guides& guides, VirtualGuides* images);

/// Marks the motion of all images as unknown (UnknownMotion).
void ForgetImageMotion(VirtualGuides* images);

}  // namespace stillray::io

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Motion of virtual images in mirrors, glass and convex surfaces.
#pragma once

#include <cstdint>

#include "io/camera_fit.h"
#include "stillray/frame.h"
#include "stillray/image.h"

namespace stillray::io {

/// The kind of motion of a virtual image.
enum class ImageKind : uint8_t {
  kNone,       ///< the pixel has no virtual image
  kPlanar,     ///< in a planar mirror or pane: the camera's motion at the image's depth
  kReflected,  ///< in a curved mirror: by the law of reflection (ReflectedMotion)
  kConvex,     ///< behind a convex surface: the surface's motion plus the camera's (ImageMotion)
  kSurface,    ///< through curved glass: the motion of the glass
};

/// Why a file has no virtual guides, or why their motion is unknown.
enum class NoSeenGuides : uint8_t {
  kNone,    ///< it has virtual guides, or no mirror
  kLens,    ///< the kSeen depth fits no camera
  kNormal,  ///< the kSeen normals do not match the frame's normals in any axes, or all are parallel
  kMotion,  ///< the motion does not fit a camera in a mostly static scene
  kOnePlane,  ///< all static surfaces lie in one plane, so that motion at other depths is unknown
  kFocal,     ///< the angle of view is unknown, which converts hit distances to depth
};

/// The data besides the frame that determine the motion of its virtual images.
struct FrameImages {
  Plane<uint8_t> reflection;  ///< ImageKind of each pixel of Frame::reflection; empty: unknown
  Plane<uint8_t> refraction;  ///< ImageKind of each pixel of Frame::refraction; empty: unknown
  Lens lens;                  ///< of the depths of kReflected
  bool has_reflection_motion = false;          ///< the file has the motion of Frame::reflection
  NoSeenGuides missing = NoSeenGuides::kNone;  ///< why virtual images or their motion are missing
};

/// The motion of the camera, or why it is unknown.
NoSeenGuides WhyUnknown(CameraFits* fits);

/// Sets the motion of virtual images.
/// \param kinds   ImageKind of each pixel of `images`; for kNone the motion is unchanged
/// \param lens    FrameImages::lens
/// \param fits    to `guides`
/// \param guides  of the surfaces, with their motion
/// \param images  needs depth; its motion is of the same size
void SetImageMotion(const Plane<uint8_t>& kinds, const Lens& lens, const CameraMotion& camera,
                    CameraFits* fits, const Guides& guides, VirtualGuides* images);

/// Marks the motion of all images as unknown (UnknownMotion).
void ForgetImageMotion(VirtualGuides* images);

}  // namespace stillray::io

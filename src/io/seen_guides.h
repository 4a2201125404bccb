// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides (frame.h) from layers that follow mirrors and glass to the first rough surface:
/// Cycles' Denoising Data.
#pragma once

#include "io/camera_fit.h"
#include "stillray/frame.h"

namespace stillray::io {

/// Layers of what is seen, as stored.
struct SeenLayers {
  Image1 depth;   ///< length of the path from the camera; 0 where it ends in the sky
  Image3 normal;  ///< in camera space, where the surface is (not mirrored)
  Image3 albedo;  ///< all lobes together, times the throughput of the path
};

/// Why a file has no virtual guides.
enum class NoSeenGuides : uint8_t {
  kNone,    ///< it has some, or no mirror
  kLens,    ///< the depth of what is seen fits no camera
  kNormal,  ///< its normals are not those of the frame in other axes, or all are parallel
  kMotion,  ///< the motion is not that of a camera before a mostly static scene
};

/// Sets frame->reflection and frame->refraction, if the frame has specular or transmitted light:
/// each mirror or pane has the guides of what is seen in it, reflected or through it, whichever is
/// brighter by its albedos. Images in planar surfaces move as the camera does at their depth, those
/// in curved mirrors by the law of reflection (ReflectedMotion), and what curved glass shows moves
/// with the glass. Surfaces in which neighbours mostly see something else are rough: their layers
/// are those of random directions. Albedo above 1 is that of a lamp.
/// \param fits   to the frame's guides
/// \param frame  needs depth, normal, motion and the albedos; its light distinguishes lobes and
/// lamps
NoSeenGuides SetSeenGuides(const SeenLayers& seen, CameraFits* fits, Frame* frame);

/// What SetSeenGuides would return.
/// \param seen    depth and normal
/// \param guides  depth, normal and motion
NoSeenGuides CheckSeenGuides(const SeenLayers& seen, const Guides& guides);

}  // namespace stillray::io

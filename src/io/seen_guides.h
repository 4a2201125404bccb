// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides (frame.h) from layers that follow mirrors and glass to the first rough surface:
/// Cycles' Denoising Data.
#pragma once

#include <optional>

#include "io/camera_fit.h"
#include "io/image_motion.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray::io {

/// Layers of what is seen, as stored.
struct SeenLayers {
  Image1 depth;   ///< length of the path from the camera; 0 where it ends in the sky
  Image3 normal;  ///< in camera space, where the surface is (not mirrored)
  Image3 albedo;  ///< all lobes together, times the throughput of the path
};

/// Sets frame->reflection and frame->refraction, if the frame has specular or transmitted light,
/// but for their motion (MoveSeenGuides): each mirror or pane has the guides of what is seen in it,
/// reflected or through it, whichever is brighter by its albedos. Surfaces in which neighbours
/// mostly see something else are rough: their layers are those of random directions. Albedo above 1
/// is that of a lamp.
/// \param frame   needs depth, normal, motion and the albedos; its light distinguishes lobes
///     and lamps
/// \param images  [out] all members; `missing` is kNone, kLens or kNormal
void SetSeenGuides(const SeenLayers& seen, Frame* frame, FrameImages* images);

/// Sets the motion of these images: in planar surfaces that of the camera at their depth, in curved
/// mirrors by the law of reflection (ReflectedMotion), and that of the glass where curved glass
/// shows them. If the camera's motion is unknown, the frame has no images, and `missing` says why.
/// \param fits  to the frame's guides
void MoveSeenGuides(CameraFits* fits, Frame* frame, FrameImages* images);

/// The map from the axes of normals of what is seen to those of the frame.
/// \param own   the frame's normals where nothing else is seen; zero elsewhere
/// \param seen  as stored
/// \return nothing if most of both differ by more than their axes, or all are parallel
std::optional<mat3> FitToWorld(const Image3& own, const Image3& seen);

/// Why SetSeenGuides and MoveSeenGuides would set nothing.
/// \param seen          depth and normal
/// \param guides        depth, normal and motion
/// \param has_camera    whether the camera's motion is known by its matrices
NoSeenGuides CheckSeenGuides(const SeenLayers& seen, const Guides& guides, bool has_camera);

}  // namespace stillray::io

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides (frame.h) from layers of the first rough surface after mirrors and glass (the
/// seen surface): Cycles' Denoising Data.
#pragma once

#include <optional>

#include "io/camera_fit.h"
#include "io/image_motion.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray::io {

/// Layers of the seen surface, as stored.
struct SeenLayers {
  Image1 depth;   ///< length of the path from the camera; 0 where it ends in the sky
  Image3 normal;  ///< in camera space, of the actual surface (not mirrored)
  Image3 albedo;  ///< sum of all lobes, times path throughput
};

/// Sets frame->reflection and frame->refraction, if the frame has specular or transmitted signals,
/// except for their motion (MoveSeenGuides): each mirror or pane gets the guides of the reflected
/// or of the transmitted surface, whichever has the larger albedo. Surfaces on which neighbouring
/// pixels mostly disagree are rough: their layers belong to random directions. An albedo above 1
/// belongs to a lamp.
/// \param frame   needs depth, normal, motion and the albedos; lobes and lamps are distinguished by
///     its radiance
/// \param images  [out] all members; `missing` is kNone, kLens or kNormal
void SetSeenGuides(const SeenLayers& seen, Frame* frame, FrameImages* images);

/// Sets the motion of these virtual images: in planar surfaces the camera's at the image's depth,
/// in curved mirrors by the law of reflection (ReflectedMotion), behind curved glass the motion of
/// the glass. If the camera's motion is unknown, the virtual guides are removed, and `missing` is
/// set to the reason.
/// \param fits  to the frame's guides
void MoveSeenGuides(CameraFits* fits, Frame* frame, FrameImages* images);

/// The map from the axes of the seen normals to the axes of the frame's normals.
/// \param own   the frame's normals at pixels without virtual images; zero elsewhere
/// \param seen  as stored
/// \return nothing if no map fits most normals, or if all are parallel
std::optional<mat3> FitToWorld(const Image3& own, const Image3& seen);

/// The reason why SetSeenGuides and MoveSeenGuides would set no virtual guides.
/// \param seen          depth and normal
/// \param guides        depth, normal and motion
/// \param has_camera    whether the camera's motion is known by its matrices
NoSeenGuides CheckSeenGuides(const SeenLayers& seen, const Guides& guides, bool has_camera);

}  // namespace stillray::io

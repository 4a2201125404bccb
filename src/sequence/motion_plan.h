// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The source of each frame's motion vectors: its file, the cameras, or estimation from the guides.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "io/image_motion.h"
#include "motion/camera_file.h"
#include "stillray/aov.h"
#include "stillray/sequence.h"

namespace stillray {

/// The sources that may be used for a sequence.
struct MotionPlan {
  bool from_file = false;     ///< a motion layer, unless it is zero although guides move
  bool from_cameras = false;  ///< from `cameras`, else from the files' attributes
  bool estimates = false;
  bool needs_camera = false;  ///< a frame without camera is an error
  std::optional<motion::CameraFile> cameras;
  /// One line for the user on the source of motion, if it is not a motion layer; else empty.
  std::string note;

  bool has_motion() const { return from_file || from_cameras || estimates; }
  /// Whether motion missing in the files is derived.
  bool derives() const { return estimates || from_cameras; }
};

/// \param first  the first file of the sequence
/// \return kInvalidArgument (options that contradict each other or the files; cameras of another
///     size), kNotFound (no camera of a frame), errors of ReadCameraFile
Result<MotionPlan> PlanMotion(const SequenceOptions& options, const AovLayout& layout,
                              const ExrImage& first);

/// The camera of a frame, if motion may be computed from it.
/// \return kBadData if the plan needs one and the file has none
Result<std::optional<CameraMatrices>> CameraOfFrame(const MotionPlan& plan,
                                                    const SequenceFile& file,
                                                    const ExrImage& image);

enum class MotionKind : uint8_t { kNone, kFile, kCamera, kEstimate };
/// "file", "camera", "estimate"; empty for kNone.
const char* MotionKindName(MotionKind kind);

/// The origin of the motion of one frame.
struct MotionOrigin {
  MotionKind kind = MotionKind::kNone;
  double estimated = 0;  ///< fraction of the surfaces; see FrameReport
  double unknown = 0;
};

/// The frame to which motion points.
struct FrameBefore {
  const Frame& frame;
  const std::optional<CameraMatrices>& camera;
};

/// The frame whose motion is completed.
struct FrameNow {
  Frame* frame;  ///< as read; its motion does not include the jitter of the previous frame
  const std::optional<CameraMatrices>& camera;
  const Image1& loss_in_motion;  ///< as ImportFrameWith returns it
};

/// Completes the motion of a frame's surfaces, and Frame::confidence if the motion is not from the
/// file. Depends only on these two frames.
MotionOrigin CompleteMotion(const FrameBefore& before, const MotionPlan& plan,
                            const AovLayout& layout, const FrameNow& now);

/// Sets the motion of virtual images that is missing in the file: from the cameras, or else from
/// the camera fitted to the frame's motion. If neither is known, motion is unknown (points outside
/// the image).
/// \param before, now  the cameras of both frames, if known
/// \param images       their kinds; `missing` is set to the reason of unknown motion. Without
///     kinds, images belong to planar surfaces where the roughness is 0, else to convex surfaces
void MoveImages(const AovLayout& layout, const std::optional<CameraMatrices>& before,
                const std::optional<CameraMatrices>& now, io::FrameImages* images, Frame* frame);

/// Adds the jitter of the other frame to motion that was converted without it.
void AddNeighbourJitter(const MotionConvention& convention, const Frame& neighbour, Image2* motion);

/// Whether motion is zero everywhere.
bool IsStill(const Image2& motion);

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Where the motion of each frame of a sequence comes from: its file, the cameras, or the guides.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "io/image_motion.h"
#include "motion/camera_file.h"
#include "stillray/aov.h"
#include "stillray/sequence.h"

namespace stillray {

/// What may be used for a sequence.
struct MotionPlan {
  bool from_file = false;     ///< a layer, where it is not zero although guides move
  bool from_cameras = false;  ///< of `cameras`, else of the files' attributes
  bool estimates = false;
  bool needs_camera = false;  ///< a frame without camera is an error
  std::optional<motion::CameraFile> cameras;
  /// One line for the user: the origin of motion that is not from a layer; else empty.
  std::string note;

  bool has_motion() const { return from_file || from_cameras || estimates; }
  /// Whether motion that the files lack is derived.
  bool derives() const { return estimates || from_cameras; }
};

/// \param first  the first file of the sequence
/// \return kInvalidArgument (options that contradict each other or the files; cameras of another
///     size), kNotFound (no camera of a frame), errors of ReadCameraFile
Result<MotionPlan> PlanMotion(const SequenceOptions& options, const AovLayout& layout,
                              const ExrImage& first);

/// The camera of a frame, if motion may come from it.
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

/// The frame to which motion leads.
struct FrameBefore {
  const Frame& frame;
  const std::optional<CameraMatrices>& camera;
};

/// The frame whose motion is completed.
struct FrameNow {
  Frame* frame;  ///< as read; its motion lacks the jitter of the previous frame
  const std::optional<CameraMatrices>& camera;
  const Image1& loss_in_motion;  ///< as ImportFrameWith returns it
};

/// Completes the motion of a frame's surfaces; with motion that is not the file's also
/// Frame::confidence. Depends on the two frames alone.
MotionOrigin CompleteMotion(const FrameBefore& before, const MotionPlan& plan,
                            const AovLayout& layout, const FrameNow& now);

/// Sets the motion of virtual images that the file does not give: by that of the cameras, or else
/// of the camera that the frame's motion reveals. Where neither is known, motion leads out of the
/// picture.
/// \param before, now  the cameras of both frames, if they are known
/// \param images       their kinds; `missing` is set to why motion is unknown. Without kinds images
///     are those of planar surfaces, where the roughness is 0, and of convex ones
void MoveImages(const AovLayout& layout, const std::optional<CameraMatrices>& before,
                const std::optional<CameraMatrices>& now, io::FrameImages* images, Frame* frame);

/// Motion that includes jitter is converted without the neighbour's jitter; adds it.
void AddNeighbourJitter(const MotionConvention& convention, const Frame& neighbour, Image2* motion);

/// Whether motion is zero everywhere.
bool IsStill(const Image2& motion);

}  // namespace stillray

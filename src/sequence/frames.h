// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of a sequence as read from EXR files, and the links between consecutive frames. The
/// forward and the backward pass use the same tests, so that both find the same cuts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/image_motion.h"
#include "sequence/motion_cache.h"
#include "sequence/motion_plan.h"
#include "stillray/aov.h"
#include "stillray/sequence.h"

namespace stillray {

/// A file's bytes, which are needed again for writing, and its decoded content.
struct LoadedFile {
  std::string bytes;
  ExrExtent extent;
  ExrImage image;
  StoredPixels stored;  ///< if requested
};

/// \param to_write  also keep the pixels as stored
/// \return kNotFound, kBadData, kOutOfMemory (above the memory limit), ... naming the file
Result<LoadedFile> LoadFile(const std::string& path, const SequenceOptions& options, bool to_write);

struct SequenceFrame {
  std::string bytes;    ///< of the file
  StoredPixels stored;  ///< of the file
  /// The frame's motion does not include the jitter of the previous frame before LinkToPrevious().
  Frame frame;
  /// Motion towards the next frame, without the jitter of that frame; empty if the file has none.
  Image2 next_motion;
  Image1 loss_in_motion;                 ///< as ImportFrameWith returns it
  std::optional<CameraMatrices> camera;  ///< if motion may be derived from it
  double focal_pixels = 0;               ///< SequenceHooks::effects
  /// The origin of the frame's motion; set by LinkToPrevious().
  MotionOrigin origin;
  /// The virtual images of the frame. LinkToPrevious() sets their motion, with `moves_images`.
  io::FrameImages images;
  bool moves_images = false;
  std::vector<LightPart> parts;  ///< of the radiance; with SequenceOptions::passes
  Image1 alpha;                  ///< with SequenceOptions::denoise_alpha
};

/// Parameters for reading the files of a sequence.
struct SequenceView {
  const SequenceOptions& options;
  const AovLayout& layout;
  const MotionPlan& motion;
  MotionCache* cache = nullptr;  ///< optional
};

/// \param to_write  else `bytes`, `stored` and `parts` stay empty
Result<SequenceFrame> LoadFrame(const SequenceFile& file, const SequenceView& view, bool to_write);

/// Frees the data that consecutive frames do not need: bytes and signals.
void KeepGuidesOnly(SequenceFrame* frame);

enum class Link {
  kContinues,
  kGap,      ///< frame numbers are missing in between: motion points to a missing frame
  kResized,  ///< the frames have different sizes
  kCut,      ///< the frames show different scenes
};

/// Completes the motion of `now`, and returns whether `before` is the frame to which the motion
/// points. Depends only on these two frames.
Link LinkToPrevious(const SequenceFrame& before, const SequenceView& view, SequenceFrame* now);

/// Fraction of the surface pixels marked by the output "disocclusion"; 0 without surfaces, or
/// without that output.
double PartWithoutHistory(const DenoisedFrame& out, const Frame& frame);

/// Motion of `now` towards `next`, whose motion is already complete: from the file or the cameras
/// if the motion of `next` has that origin, else the inverse of the motion of `next`.
Image2 MotionToNext(const SequenceFrame& now, const SequenceFrame& next, const AovLayout& layout);

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of a sequence as read from EXR files, and the links between neighbours. The forward and
/// the backward pass use the same tests, so that both find the same cuts.
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

/// A file's bytes, which are needed again for writing, and its content.
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
  /// Its motion lacks the jitter of the previous frame until LinkToPrevious() has run.
  Frame frame;
  /// Towards the next frame, lacking that frame's jitter likewise; empty if the file has none.
  Image2 next_motion;
  Image1 loss_in_motion;                 ///< as ImportFrameWith returns it
  std::optional<CameraMatrices> camera;  ///< if motion may be derived from it
  double focal_pixels = 0;               ///< SequenceHooks::effects
  /// Of its motion; set by LinkToPrevious().
  MotionOrigin origin;
  /// Of what surfaces show. LinkToPrevious() sets the motion of images with `moves_images`.
  io::FrameImages images;
  bool moves_images = false;
  std::vector<LightPart> parts;  ///< of the light; with SequenceOptions::passes
  Image1 alpha;                  ///< with SequenceOptions::denoise_alpha
};

/// How the files of a sequence are read.
struct SequenceView {
  const SequenceOptions& options;
  const AovLayout& layout;
  const MotionPlan& motion;
  MotionCache* cache = nullptr;  ///< optional
};

/// \param to_write  else `bytes`, `stored` and `parts` stay empty
Result<SequenceFrame> LoadFrame(const SequenceFile& file, const SequenceView& view, bool to_write);

/// Frees the data that neighbours do not need: bytes and light.
void KeepGuidesOnly(SequenceFrame* frame);

enum class Link {
  kContinues,
  kGap,      ///< numbers are missing between the two: motion leads to a missing frame
  kResized,  ///< the pictures have different sizes
  kCut,      ///< the pictures show different scenes
};

/// Completes the motion of `now`, and returns whether `before` is the frame to which it points.
/// Depends on the two frames alone.
Link LinkToPrevious(const SequenceFrame& before, const SequenceView& view, SequenceFrame* now);

/// Fraction of the pixels with a surface that the output "disocclusion" marks; 0 without any
/// surface, or without that output.
double PartWithoutHistory(const DenoisedFrame& out, const Frame& frame);

/// Motion of `now` towards `next`, whose own motion is complete: from its file or the cameras if
/// the next frame's motion is from there, else derived from the next frame's motion.
Image2 MotionToNext(const SequenceFrame& now, const SequenceFrame& next, const AovLayout& layout);

}  // namespace stillray

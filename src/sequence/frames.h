// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of a sequence as they are read from EXR files, and the links between neighbours. The pass
/// that goes forward and the one that goes backward use the same tests, so that both find the same
/// cuts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stillray/aov.h"
#include "stillray/sequence.h"

namespace stillray {

/// A file's bytes and what they hold: the bytes are needed again to write it.
struct LoadedFile {
  std::string bytes;
  ExrExtent extent;
  ExrImage image;
  StoredPixels stored;  ///< where it was asked for
};

/// \param to_write  whether the pixels as they are stored are kept besides
/// \return kNotFound, kBadData, kOutOfMemory (above the memory limit), ... naming the file
Result<LoadedFile> LoadFile(const std::string& path, const SequenceOptions& options, bool to_write);

struct SequenceFrame {
  std::string bytes;    ///< of the file
  StoredPixels stored;  ///< of the file
  /// Its motion misses the jitter of the frame before until LinkToPrevious() has run.
  Frame frame;
  /// Towards the next frame, lacking the next frame's jitter likewise; empty where not told.
  Image2 next_motion;
  std::optional<CameraMatrices> camera;  ///< where motion comes from it
  std::vector<LightPart> parts;          ///< of the light; with SequenceOptions::passes
};

/// \param to_write  else `bytes`, `stored` and `parts` stay empty
Result<SequenceFrame> LoadFrame(const SequenceFile& file, const SequenceOptions& options,
                                const AovLayout& layout, bool to_write);

/// Frees what a neighbour is not asked for: bytes and light.
void KeepGuidesOnly(SequenceFrame* frame);

enum class Link {
  kContinues,
  kGap,      ///< numbers are missing between the two: motion leads to a frame that is not there
  kResized,  ///< the pictures have different sizes
  kCut,      ///< the pictures show different things
};

/// Completes the motion of `now`, and tells whether `before` is the frame it points to. Depends on
/// the two frames alone.
Link LinkToPrevious(const SequenceFrame& before, const AovLayout& layout, SequenceFrame* now);

/// Part of the pixels with a surface that the output "disocclusion" marks; 0 where there is no
/// surface at all, or no such output.
double PartWithoutHistory(const DenoisedFrame& out, const Frame& frame);

/// Whether motion is zero everywhere.
bool IsStill(const Image2& motion);

/// Motion of `now` towards `next`, whose own motion is complete: as its file tells it, else found
/// from the next frame's motion.
Image2 MotionToNext(const SequenceFrame& now, const SequenceFrame& next, const AovLayout& layout);

}  // namespace stillray

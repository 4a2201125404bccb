// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoised frames on their way to the disk.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "common/background.h"
#include "denoise/denoise_inputs.h"
#include "denoise/denoise_preview.h"
#include "stillray/aov.h"

namespace stillray {

/// A file's bytes and what is to be put there.
struct FrameToWrite {
  SequenceFile names;
  std::string bytes;    ///< of names.input
  StoredPixels stored;  ///< likewise
  Image3 colour;
  std::vector<NewLayer> layers;
};

struct WrittenFrame {
  Status status;
  int64_t bytes = 0;  ///< of the file
  double milliseconds = 0;
  std::chrono::steady_clock::time_point end;
};

/// Writes one frame while the caller works on the next. A frame is there, whole, when Finish() has
/// said so, and not before.
class FrameWriter {
 public:
  /// \param preview  gets every frame that is on disk; may be nullptr
  /// \param beside  whether frames are written on a thread of their own, else in Finish()
  FrameWriter(const AovLayout& layout, Preview* preview, bool beside)
      : layout_(layout), preview_(preview), beside_(beside) {}

  /// Only when no frame is under way.
  void Start(FrameToWrite frame);
  bool under_way() const { return writing_.under_way(); }
  /// Whether Finish() returns at once.
  bool ready() const { return writing_.ready(); }
  /// Waits until the frame is on disk, or what is wrong is known.
  WrittenFrame Finish() { return writing_.Take(); }

 private:
  const AovLayout& layout_;
  Preview* preview_;
  bool beside_;
  Background<WrittenFrame> writing_;
};

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoised frames on their way to the disk.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "background.h"
#include "denoise_inputs.h"
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
  double milliseconds = 0;
  std::chrono::steady_clock::time_point end;
};

/// Writes one frame while the caller works on the next. A frame is there, whole, when Finish() has
/// said so, and not before.
class FrameWriter {
 public:
  /// \param beside  whether frames are written on a thread of their own, else in Finish()
  FrameWriter(const AovLayout& layout, bool beside) : layout_(layout), beside_(beside) {}

  /// Only when no frame is under way.
  void Start(FrameToWrite frame);
  bool under_way() const { return writing_.under_way(); }
  /// Whether Finish() returns at once.
  bool ready() const { return writing_.ready(); }
  /// Waits until the frame is on disk, or what is wrong is known.
  WrittenFrame Finish() { return writing_.Take(); }

 private:
  const AovLayout& layout_;
  bool beside_;
  Background<WrittenFrame> writing_;
};

}  // namespace stillray

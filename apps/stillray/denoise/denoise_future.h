// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// --window both for files: reads the frames that FutureBlocks accumulates backward. How many
/// futures are held at once follows from the memory limit.
#pragma once

#include <functional>

#include "denoise/denoise_frames.h"
#include "denoise/future_blocks.h"

namespace stillray {

class FuturePass {
 public:
  /// Called before every frame that is played backward; an error stops.
  using Step = std::function<Status(const SequenceFile& file)>;

  /// \param held   frames whose future is held at once, 1..kFutureBlock
  /// \param ahead  whether a file is read while the one before it is accumulated
  FuturePass(const DenoiseOptions& options, const AovLayout& layout, Denoiser backward, size_t held,
             bool ahead, Step step);

  /// The light of the future of options.files[at]. `at` rises from call to call.
  Status Take(size_t at, FutureLight* future);

  size_t memory_bytes() const { return blocks_.memory_bytes(); }
  DeviceMemory device_memory() const { return blocks_.backward().device_memory(); }

 private:
  Status PlayBackward(const FutureRange& range);

  const DenoiseOptions& options_;
  const AovLayout& layout_;
  FutureBlocks blocks_;
  bool told_fall_back_ = false;
  bool ahead_;
  Step step_;
};

}  // namespace stillray

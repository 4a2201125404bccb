// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Window::kBoth for files: reads the frames that FutureBlocks accumulates backward. The memory
/// limit determines how many futures are held at once.
#pragma once

#include <functional>
#include <string>

#include "denoise/future_blocks.h"
#include "sequence/frames.h"

namespace stillray {

class FuturePass {
 public:
  /// Called before every frame of the backward pass; an error stops it.
  using Step = std::function<Status(const SequenceFile& file)>;

  /// \param held   frames whose future is held at once, 1..kFutureBlock
  /// \param ahead  read a file while the previous one is accumulated
  FuturePass(const SequenceView& view, Denoiser backward, size_t held, bool ahead, Step step);

  /// The light of the future of options.files[at]. `at` increases from call to call.
  Status Take(size_t at, FutureLight* future);

  /// Why frames are accumulated on the CPU instead; see Denoiser::remark().
  const std::string& remark() const { return blocks_.backward().remark(); }
  size_t memory_bytes() const { return blocks_.memory_bytes(); }
  DeviceMemory device_memory() const { return blocks_.backward().device_memory(); }

 private:
  Status PlayBackward(const FutureRange& range);

  SequenceView view_;
  FutureBlocks blocks_;
  bool ahead_;
  Step step_;
};

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Window::kBoth for files: reads the frames that FutureBlocks accumulates backward. The memory
/// limit determines the number of futures held at once.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "denoise/future_blocks.h"
#include "sequence/frames.h"

namespace stillray {

class FuturePass {
 public:
  /// Called before every frame of the backward pass; an error stops it.
  using Step = std::function<Status(const SequenceFile& file)>;

  /// \param held   number of frames whose future is held at once, 1..kFutureBlock
  /// \param ahead  read a file while the previous one is accumulated
  FuturePass(const SequenceView& view, Denoiser backward, size_t held, bool ahead, Step step);

  /// Also accumulates alpha, as AlphaFilter does, starting at the last frame that is not opaque.
  /// \param backward  with SettingsOfAlpha
  void AddAlpha(Denoiser backward);

  /// The accumulated radiance of the frames after options.files[at]. `at` increases from call to
  /// call.
  /// \param alpha  [out] accumulated alpha of later frames; empty without AddAlpha, or if all later
  ///     frames are opaque
  Status Take(size_t at, FutureLight* future, FutureLight* alpha);

  /// Why frames are accumulated on the CPU instead; see Denoiser::remark().
  const std::string& remark() const { return blocks_.backward().remark(); }
  size_t memory_bytes() const;
  DeviceMemory device_memory() const;

 private:
  Status PlayBackward(const FutureRange& range);
  Status AccumulateAlpha(size_t at, const SequenceFrame& frame, bool continues);

  SequenceView view_;
  FutureBlocks blocks_;
  std::optional<FutureBlocks> alpha_;
  bool alpha_continues_ = false;  ///< the last frame's alpha was accumulated
  bool ahead_;
  Step step_;
};

}  // namespace stillray

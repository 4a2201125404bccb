// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The schedule of denoising with past and future frames, with memory that does not grow with the
/// length of the sequence.
///
/// The sequence is divided into blocks of kFutureBlock frames, counted from its first. The futures
/// of a block are accumulated backward from kLookAhead frames past the block's end, so that each
/// future contains at least that many later frames; more distant ones would have little weight
/// (0.9^16 with an alpha of 0.1). The result depends on this rule only. Where fewer futures than a
/// whole block are held at once, the later frames are accumulated again for every part of the
/// block, with bit-identical results.
///
/// The caller provides the frames (from memory or files):
///
///     if (!blocks.Holds(at)) {
///       const FutureRange range = blocks.Begin(at, frames);
///       for (size_t i = range.look_end; i-- > range.begin;) {
///         blocks.Accumulate(i, <frame i with motion towards frame i + 1>, <same shot as i + 1>);
///       }
///     }
///     denoiser.Denoise(<frame at>, blocks.At(at), &out);
#pragma once

#include <cstddef>
#include <vector>

#include "stillray/two_way.hpp"

namespace stillray {

/// One backward pass: frames look_end - 1, ..., begin are accumulated.
struct FutureRange {
  size_t begin = 0;     ///< first frame whose future is held
  size_t end = 0;       ///< end of the range (exclusive)
  size_t look_end = 0;  ///< end of the accumulated frames (exclusive)
};

/// Number of frames needed before the future of frame `at` can be accumulated, unless the sequence
/// ends earlier.
constexpr size_t FramesNeeded(size_t at) {
  return (at / kFutureBlock + 1) * kFutureBlock + kLookAhead;
}

/// \param frames  of the whole sequence, or FramesNeeded(at) at least
/// \param held    futures held at once, 1..kFutureBlock
FutureRange FutureRangeFrom(size_t at, size_t frames, size_t held);

/// Number of frames that are accumulated backward in total, for all frames of a sequence from
/// `first` on.
size_t CountBackwardFrames(size_t first, size_t frames, size_t held);

class FutureBlocks {
 public:
  /// \param backward  runs the backward passes; its history is used by this object only
  /// \param held      futures held at once, 1..kFutureBlock; does not affect results
  explicit FutureBlocks(Denoiser backward, size_t held = kFutureBlock);

  /// Whether the future of frame `at` is held.
  bool Holds(size_t at) const;
  /// Starts the backward pass for frame `at` and frees the held futures. Arguments as for
  /// FutureRangeFrom.
  FutureRange Begin(size_t at, size_t frames);
  /// Accumulates the next frame of the pass; `at` goes down from look_end - 1 to begin.
  /// \param frame      guides.motion leads to frame at + 1
  /// \param continues  whether frame at + 1 was accumulated and shows the same shot; else the
  ///                   history restarts here, and motion is not used
  /// \return errors of Denoiser::Accumulate; after an error the pass must begin again
  Status Accumulate(size_t at, const Frame& frame, bool continues);
  /// Replaces Accumulate for a frame that cannot be accumulated: the history ends here, and the
  /// frame's future stays empty. The next accumulated frame starts a new history.
  void Skip(size_t at);
  /// The future of a frame that is held; may be moved from.
  FutureLight& At(size_t at);
  /// Frees all futures; the backward pass of another sequence begins.
  void Clear();

  const Denoiser& backward() const { return backward_; }
  size_t held() const { return held_; }
  size_t memory_bytes() const;  ///< history, working memory and futures

 private:
  Denoiser backward_;
  size_t held_;
  FutureRange range_;                 ///< of the last pass
  size_t next_ = 0;                   ///< one past the next frame to be accumulated
  std::vector<FutureLight> futures_;  ///< of range_.begin ... range_.end - 1
};

}  // namespace stillray

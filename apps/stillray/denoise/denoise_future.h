// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// --window both: what later frames know of a frame's light, with memory that does not grow with
/// the sequence.
///
/// The sequence falls into blocks of kFutureBlock frames, counted from its first. The frames of a
/// block get what is left when the sequence is played backward from kLookAhead frames past the
/// block's end: every frame sees at least that many later ones, of which the last few hardly count
/// any more (an alpha of 0.1 leaves 0.9^16 of them). This rule alone decides the result. How much
/// of a block is held at once follows from the memory limit: where it is less than a whole block,
/// the frames behind are played again for every part.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "denoise/denoise_frames.h"

namespace stillray {

inline constexpr size_t kLookAhead = 16;

class FuturePass {
 public:
  /// Called before every frame that is played backward; an error stops.
  using Step = std::function<Status(const SequenceFile& file)>;

  /// \param held   frames whose future is held at once, 1..kFutureBlock
  /// \param ahead  whether a file is read while the one before it is accumulated
  FuturePass(const DenoiseOptions& options, const AovLayout& layout, Denoiser backward, size_t held,
             bool ahead, Step step);

  /// The light of the future of options.files[at]. Frames are asked for in rising order; what is
  /// behind is forgotten.
  Status Take(size_t at, FutureLight* future);

  /// Frames played backward for all files from `first` on, when that is the first to be asked for.
  static size_t CountSteps(size_t first, size_t files, size_t held);

  size_t memory_bytes() const;         ///< held now
  DeviceMemory device_memory() const;  ///< of that what lies on a device

 private:
  struct Range {
    size_t begin = 0;     ///< first frame whose future is kept
    size_t end = 0;       ///< behind the last
    size_t look_end = 0;  ///< behind the last frame that is looked at
  };
  static Range RangeFrom(size_t at, size_t files, size_t held);
  Status Play(const Range& range);

  const DenoiseOptions& options_;
  const AovLayout& layout_;
  Denoiser backward_;
  bool told_fall_back_ = false;
  size_t held_;
  bool ahead_;
  Step step_;
  Range range_;                       ///< what `futures_` holds
  std::vector<FutureLight> futures_;  ///< of range_.begin ..., empty once taken
};

}  // namespace stillray

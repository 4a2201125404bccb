// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Files of a sequence, each read while the frame before it is worked on.
#pragma once

#include <cstddef>
#include <vector>

#include "sequence/background.h"
#include "sequence/frames.h"

namespace stillray {

/// A frame or why there is none, and how long its file took.
struct ReadFrame {
  Result<SequenceFrame> frame;
  double milliseconds = 0;
};

/// Holds one frame at most besides the one that was handed out. Bits do not depend on `ahead`.
class FrameReader {
 public:
  /// \param order     files to be read, by their index in options.files
  /// \param to_write  see LoadFrame()
  /// \param ahead     whether the next file is read while the caller works
  FrameReader(const SequenceOptions& options, const AovLayout& layout, std::vector<size_t> order,
              bool to_write, bool ahead);

  /// The next of the files; not to be called more often than there are. Errors come in the turn of
  /// their file; nothing is read behind one.
  ReadFrame Next();

 private:
  ReadFrame Load(size_t file) const;

  const SequenceOptions& options_;
  const AovLayout& layout_;
  std::vector<size_t> order_;
  bool to_write_;
  bool ahead_;
  size_t taken_ = 0;
  Background<ReadFrame> reading_;  ///< last, so that its work ends before what it reads goes
};

}  // namespace stillray

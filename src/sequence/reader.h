// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Reads the files of a sequence, each while the previous frame is processed.
#pragma once

#include <cstddef>
#include <vector>

#include "sequence/background.h"
#include "sequence/frames.h"

namespace stillray {

/// A frame or an error, and the time for reading its file.
struct ReadFrame {
  Result<SequenceFrame> frame;
  double milliseconds = 0;
};

/// Holds at most one frame besides the returned one. Results do not depend on `ahead`.
class FrameReader {
 public:
  /// \param order     files to read, by their index in options.files
  /// \param to_write  see LoadFrame()
  /// \param ahead     read the next file while the caller works
  FrameReader(const SequenceView& view, std::vector<size_t> order, bool to_write, bool ahead);

  /// The next file; call it at most once per file. An error is returned by the call for its file;
  /// no later file is read.
  ReadFrame Next();

 private:
  ReadFrame Load(size_t file) const;

  SequenceView view_;
  std::vector<size_t> order_;
  bool to_write_;
  bool ahead_;
  size_t taken_ = 0;
  Background<ReadFrame> reading_;  ///< last, so that its task ends before its data is freed
};

}  // namespace stillray

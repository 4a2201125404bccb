// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What `stillray compare` measures: one pair of pictures, or the frames that two sequences share.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "stillray/image.h"
#include "stillray/quality.h"
#include "stillray/status.h"

namespace stillray {

/// The files of one comparison.
struct FramePair {
  std::optional<int64_t> number;  ///< none: not a frame of a sequence
  std::string test;
  std::string reference;
};

/// First and last frame number, both included.
struct FrameRange {
  int64_t first = 0;
  int64_t last = 0;
};

/// "8" or "8-24"; numbers may be negative.
/// \return kInvalidArgument
Result<FrameRange> ParseFrameRange(const std::string& text);

/// Two pictures make one pair; two patterns ("name.####.exr") the frames on disk that both have.
/// \return kInvalidArgument (one of them alone is a pattern; a range without patterns), kNotFound
///         (no frame in both, telling how many each has)
Result<std::vector<FramePair>> FindFramePairs(const std::string& test, const std::string& reference,
                                              const std::optional<FrameRange>& range);

/// One compared pair and its numbers.
struct ComparedFrame {
  FramePair files;
  Image3 test;
  Image3 reference;
  bool display = false;
  ImageMetrics metrics;
  /// None: the frame before was not compared. NaN: no pixel's history is visible.
  std::optional<double> temporal_error;
};

/// Compares pairs one after the other and keeps the last one for the temporal error.
class FrameComparer {
 public:
  /// Reads and compares one pair. The reference that is returned holds until the next call.
  /// \return what reading returns; kInvalidArgument (sizes or kinds that differ, naming the files)
  Result<const ComparedFrame*> Compare(const FramePair& files);

  /// What the temporal error went without so far, one line each.
  std::vector<std::string> Notes() const;

 private:
  /// A frame and the layers of its test picture that say where its pixels were before.
  struct Loaded {
    ComparedFrame frame;
    Image2 motion;
    Image1 depth;
  };

  Status Load(const FramePair& files, Loaded* loaded) const;
  Status MeasureTemporalError(Loaded* loaded);

  Loaded current_;
  bool has_current_ = false;
  bool motion_missing_ = false;
  bool depth_missing_ = false;
};

}  // namespace stillray

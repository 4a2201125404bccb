// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Finds and compares the images of `stillray compare`: one pair, or the common frames of two
/// sequences.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stillray/image.h"
#include "stillray/quality.h"
#include "stillray/status.h"

namespace stillray {

/// The files of one comparison.
struct FramePair {
  std::optional<int64_t> number;  ///< frame number; unset: not a frame of a sequence
  std::string test;
  std::string reference;
};

/// First and last frame number, inclusive.
struct FrameRange {
  int64_t first = 0;
  int64_t last = 0;
};

/// "8" or "8-24"; numbers may be negative.
/// \return kInvalidArgument
Result<FrameRange> ParseFrameRange(const std::string& text);

/// Returns one pair for two images; for two patterns ("name.####.exr") the frames that exist on
/// disk in both sequences.
/// \return kInvalidArgument (only one of them is a pattern; a range without patterns), kNotFound
///     (no common frame; the message has both counts)
Result<std::vector<FramePair>> FindFramePairs(const std::string& test, const std::string& reference,
                                              const std::optional<FrameRange>& range);

/// One compared pair and its values.
struct ComparedFrame {
  FramePair files;
  Image3 test;
  Image3 reference;
  bool display = false;
  ImageMetrics metrics;
  /// Unset: the previous frame was not compared. NaN: no pixel was visible in the previous frame.
  std::optional<double> temporal_error;
  std::optional<LightChange> light_change;  ///< unset: the previous frame was not compared
  std::vector<ObjectErrors> objects;        ///< only if a layer of object ids is given
};

/// The layer of object ids, by which errors are grouped.
struct ObjectSource {
  std::string layer;  ///< layer name for ReadPictureFile; empty: none
  /// Image or sequence pattern with the layer; empty: the reference images, or else the test
  /// images.
  std::string files;
};

/// Compares pairs in sequence and keeps the previous pair for metrics over consecutive frames.
class FrameComparer {
 public:
  explicit FrameComparer(ObjectSource objects) : objects_(std::move(objects)) {}

  /// Reads and compares one pair. The returned reference is valid until the next call.
  /// \return errors of reading; kInvalidArgument (sizes or kinds that differ, naming the files)
  Result<const ComparedFrame*> Compare(const FramePair& files);

  /// Missing inputs of the metrics over consecutive frames, one line each.
  std::vector<std::string> Notes() const;

 private:
  /// A frame and the layers of its test image for reprojection.
  struct Loaded {
    ComparedFrame frame;
    Image2 motion;
    Image1 depth;
    Image1 objects;
  };

  Status Load(const FramePair& files, Loaded* loaded) const;
  Status MeasureChange(Loaded* loaded);
  Status LoadObjects(Loaded* loaded) const;
  Status MeasureObjects(Loaded* loaded) const;

  ObjectSource objects_;
  Loaded current_;
  bool has_current_ = false;
  bool motion_missing_ = false;
  bool depth_missing_ = false;
};

}  // namespace stillray

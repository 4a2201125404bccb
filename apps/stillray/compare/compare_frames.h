// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Finds and compares the pictures of `stillray compare`: one pair, or the common frames of two
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
  std::optional<int64_t> number;  ///< none: not a frame of a sequence
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

/// Two pictures make one pair; two patterns ("name.####.exr") the frames on disk that both have.
/// \return kInvalidArgument (one of them alone is a pattern; a range without patterns), kNotFound
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
  /// None: the previous frame was not compared. NaN: no pixel's history is visible.
  std::optional<double> temporal_error;
  std::optional<LightChange> light_change;  ///< none likewise
  std::vector<ObjectErrors> objects;        ///< if a layer of them was requested
};

/// The numbers of objects, which errors are listed by.
struct ObjectSource {
  std::string layer;  ///< as ReadPictureFile; empty: none
  /// A picture, or the frames of a sequence, that has the layer; empty: the references, or else the
  /// tests.
  std::string files;
};

/// Compares pairs in sequence and keeps the last one for the measures over consecutive frames.
class FrameComparer {
 public:
  explicit FrameComparer(ObjectSource objects) : objects_(std::move(objects)) {}

  /// Reads and compares one pair. The returned reference is valid until the next call.
  /// \return errors of reading; kInvalidArgument (sizes or kinds that differ, naming the files)
  Result<const ComparedFrame*> Compare(const FramePair& files);

  /// Inputs that the measures over consecutive frames lacked so far, one line each.
  std::vector<std::string> Notes() const;

 private:
  /// A frame and the layers of its test picture for reprojection.
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

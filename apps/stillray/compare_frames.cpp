// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "compare_frames.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "stillray/io.h"

namespace stillray {

namespace {

// The largest file that is read whole.
constexpr size_t kMaxFileBytes = size_t{4} << 30;

/// A picture as its file says it.
struct Picture {
  Image3 colour;
  bool linear = false;
  Image2 motion;  ///< empty if the file has no motion.X and motion.Y
  Image1 depth;   ///< empty if the file has no depth.Z
};

Image1 TakeLayer(const ExrImage& exr, const char* name) {
  const Channel* channel = exr.Find(name);
  return channel != nullptr ? channel->values : Image1();
}

Result<Picture> DecodeExrPicture(const std::string& bytes, const std::string& path) {
  const Result<ExrImage> exr =
      DecodeExr(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(), path);
  if (!exr.ok()) {
    return exr.status();
  }
  Result<Image3> colour = ExrColour(*exr, path);
  if (!colour.ok()) {
    return colour.status();
  }
  Picture picture;
  picture.colour = std::move(*colour);
  picture.linear = true;
  picture.depth = TakeLayer(*exr, "depth.Z");
  Image1 motion_x = TakeLayer(*exr, "motion.X");
  Image1 motion_y = TakeLayer(*exr, "motion.Y");
  if (!motion_x.empty() && !motion_y.empty()) {
    picture.motion[0] = std::move(motion_x);
    picture.motion[1] = std::move(motion_y);
  }
  return picture;
}

Result<Picture> ReadPicture(const std::string& path) {
  constexpr std::array<char, 4> kExrMagic = {0x76, 0x2f, 0x31, 0x01};
  const Result<std::string> bytes = ReadWholeFile(path, kMaxFileBytes);
  if (!bytes.ok()) {
    return bytes.status();
  }
  if (bytes->size() >= kExrMagic.size() &&
      std::equal(kExrMagic.begin(), kExrMagic.end(), bytes->begin())) {
    return DecodeExrPicture(*bytes, path);
  }
  Picture picture;
  Result<Image3> colour = DecodeImage(reinterpret_cast<const uint8_t*>(bytes->data()),
                                      bytes->size(), path, &picture.linear);
  if (!colour.ok()) {
    return colour.status();
  }
  picture.colour = std::move(*colour);
  return picture;
}

Status CheckSameSize(const Image3& a, const std::string& a_path, const Image3& b,
                     const std::string& b_path) {
  if (a.width() == b.width() && a.height() == b.height()) {
    return Status::Ok();
  }
  return Status::InvalidArgument(fmt::format("{}: {}x{} pixels, but {} has {}x{}", a_path,
                                             a.width(), a.height(), b_path, b.width(), b.height()));
}

const char* KindName(bool linear) {
  return linear ? "linear radiance" : "display values";
}

/// A name with marks that is itself a file is that file.
bool IsSequence(const std::string& path) {
  std::error_code ignored;
  return IsFramePattern(path) && !std::filesystem::exists(path, ignored);
}

std::vector<int64_t> FindFramesInRange(const std::string& pattern,
                                       const std::optional<FrameRange>& range) {
  std::vector<int64_t> frames = FindFrames(pattern);
  std::erase_if(frames, [&range](int64_t frame) {
    return range && (frame < range->first || frame > range->last);
  });
  return frames;
}

std::string CountFrames(size_t count) {
  return fmt::format("{} frame{}", count, count == 1 ? "" : "s");
}

}  // namespace

Result<FrameRange> ParseFrameRange(const std::string& text) {
  const Status error = Status::InvalidArgument(
      fmt::format("--frames {}: expected a frame or a range, such as 8 or 8-24", text));
  FrameRange range;
  const char* const end = text.data() + text.size();
  auto [rest, code] = std::from_chars(text.data(), end, range.first);
  if (code != std::errc()) {
    return error;
  }
  range.last = range.first;
  if (rest != end) {
    if (*rest != '-') {
      return error;
    }
    const auto [last_end, last_code] = std::from_chars(rest + 1, end, range.last);
    if (last_code != std::errc() || last_end != end) {
      return error;
    }
  }
  if (range.last < range.first) {
    return Status::InvalidArgument(
        fmt::format("--frames {}: the first frame lies after the last one", text));
  }
  return range;
}

Result<std::vector<FramePair>> FindFramePairs(const std::string& test, const std::string& reference,
                                              const std::optional<FrameRange>& range) {
  const bool is_sequence = IsSequence(test);
  if (is_sequence != IsSequence(reference)) {
    return Status::InvalidArgument(
        fmt::format("{} is a sequence, {} is one picture: compare like with like",
                    is_sequence ? test : reference, is_sequence ? reference : test));
  }
  if (!is_sequence) {
    if (range) {
      return Status::InvalidArgument(
          fmt::format("--frames is for sequences (NAME.####.exr), but {} is one picture", test));
    }
    return std::vector<FramePair>{{std::nullopt, test, reference}};
  }
  const std::vector<int64_t> test_frames = FindFramesInRange(test, range);
  const std::vector<int64_t> reference_frames = FindFramesInRange(reference, range);
  std::vector<int64_t> frames;
  std::set_intersection(test_frames.begin(), test_frames.end(), reference_frames.begin(),
                        reference_frames.end(), std::back_inserter(frames));
  if (frames.empty()) {
    return Status::NotFound(fmt::format(
        "no frame is in both sequences{}: {} has {}, {} has {}",
        range ? fmt::format(" between {} and {}", range->first, range->last) : "", test,
        CountFrames(test_frames.size()), reference, CountFrames(reference_frames.size())));
  }
  std::vector<FramePair> pairs;
  for (const int64_t frame : frames) {
    pairs.push_back({frame, FrameFileName(test, frame), FrameFileName(reference, frame)});
  }
  return pairs;
}

Status FrameComparer::Load(const FramePair& files, Loaded* loaded) const {
  Result<Picture> test = ReadPicture(files.test);
  if (!test.ok()) {
    return test.status();
  }
  Result<Picture> reference = ReadPicture(files.reference);
  if (!reference.ok()) {
    return reference.status();
  }
  if (test->linear != reference->linear) {
    return Status::InvalidArgument(
        fmt::format("{} holds {}, but {} holds {}: they cannot be compared", files.test,
                    KindName(test->linear), files.reference, KindName(reference->linear)));
  }
  STILLRAY_RETURN_IF_ERROR(
      CheckSameSize(test->colour, files.test, reference->colour, files.reference));
  loaded->frame.files = files;
  loaded->frame.test = std::move(test->colour);
  loaded->frame.reference = std::move(reference->colour);
  loaded->frame.display = !test->linear;
  loaded->motion = std::move(test->motion);
  loaded->depth = std::move(test->depth);
  return Status::Ok();
}

Status FrameComparer::MeasureTemporalError(Loaded* loaded) {
  ComparedFrame& frame = loaded->frame;
  const ComparedFrame& previous = current_.frame;
  if (!has_current_ || !frame.files.number || !previous.files.number ||
      *frame.files.number != *previous.files.number + 1) {
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(
      CheckSameSize(frame.test, frame.files.test, previous.test, previous.files.test));
  motion_missing_ = motion_missing_ || loaded->motion.empty();
  depth_missing_ = depth_missing_ || loaded->depth.empty() || current_.depth.empty();
  const Result<double> error =
      TemporalError(frame.test, previous.test, frame.reference, previous.reference, loaded->motion,
                    loaded->depth, current_.depth, frame.display);
  if (!error.ok()) {
    return error.status();
  }
  frame.temporal_error = *error;
  return Status::Ok();
}

Result<const ComparedFrame*> FrameComparer::Compare(const FramePair& files) {
  Loaded loaded;
  STILLRAY_RETURN_IF_ERROR(Load(files, &loaded));
  ComparedFrame& frame = loaded.frame;
  if (has_current_ && frame.display != current_.frame.display) {
    return Status::InvalidArgument(fmt::format(
        "{} holds {}, but {} holds {}: they are no sequence", files.test, KindName(!frame.display),
        current_.frame.files.test, KindName(!current_.frame.display)));
  }
  const Result<ImageMetrics> metrics = CompareImages(frame.test, frame.reference, frame.display);
  if (!metrics.ok()) {
    return Status(metrics.status().code(),
                  fmt::format("{}: {}", files.test, metrics.status().message()));
  }
  frame.metrics = *metrics;
  STILLRAY_RETURN_IF_ERROR(MeasureTemporalError(&loaded));
  current_ = std::move(loaded);
  has_current_ = true;
  return static_cast<const ComparedFrame*>(&current_.frame);
}

std::vector<std::string> FrameComparer::Notes() const {
  std::vector<std::string> notes;
  if (motion_missing_) {
    notes.push_back(
        "temporal error: test frames without layers motion.X and motion.Y count as if nothing "
        "moved");
  }
  if (depth_missing_) {
    notes.push_back(
        "temporal error: test frames without a layer depth.Z count as if no history was hidden");
  }
  return notes;
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "compare/compare_frames.h"

#include <charconv>
#include <filesystem>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "core/status_prefix.h"
#include "io/sequence.h"
#include "quality/picture_file.h"

namespace stillray {

namespace {

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

/// Whether a path is a sequence: a folder, or a name with placeholders or wildcards that is not an
/// existing file.
bool IsSequence(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored) ||
         (IsSequenceName(path) && !std::filesystem::exists(path, ignored));
}

/// Paths by frame number.
Result<std::map<int64_t, std::string>> FindFramesInRange(const std::string& name,
                                                         const std::optional<FrameRange>& range) {
  Result<std::vector<FrameFile>> files = FindFrameFiles(name, kPictureEndings);
  if (!files.ok()) {
    return files.status();
  }
  std::map<int64_t, std::string> frames;
  for (FrameFile& file : files.value()) {
    if (!range || (file.frame >= range->first && file.frame <= range->last)) {
      frames.emplace(file.frame, std::move(file.path));
    }
  }
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
  const Result<std::map<int64_t, std::string>> tests = FindFramesInRange(test, range);
  STILLRAY_RETURN_IF_ERROR(tests.status());
  const Result<std::map<int64_t, std::string>> references = FindFramesInRange(reference, range);
  STILLRAY_RETURN_IF_ERROR(references.status());
  std::vector<FramePair> pairs;
  for (const auto& [frame, path] : *tests) {
    if (const auto same = references->find(frame); same != references->end()) {
      pairs.push_back({frame, path, same->second});
    }
  }
  if (pairs.empty()) {
    return Status::NotFound(
        fmt::format("no frame is in both sequences{}: {} has {}, {} has {}",
                    range ? fmt::format(" between {} and {}", range->first, range->last) : "", test,
                    CountFrames(tests->size()), reference, CountFrames(references->size())));
  }
  return pairs;
}

Status FrameComparer::Load(const FramePair& files, Loaded* loaded) const {
  Result<PictureFile> test = ReadPictureFile(files.test, objects_.layer);
  if (!test.ok()) {
    return test.status();
  }
  Result<PictureFile> reference = ReadPictureFile(files.reference, objects_.layer);
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
  loaded->objects = std::move(reference->objects.empty() ? test->objects : reference->objects);
  return Status::Ok();
}

Status FrameComparer::MeasureChange(Loaded* loaded) {
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
  const auto measure = [&](const auto& function) {
    return function(frame.test, previous.test, frame.reference, previous.reference, loaded->motion,
                    loaded->depth, current_.depth, frame.display);
  };
  const Result<double> error = measure(TemporalError);
  STILLRAY_RETURN_IF_ERROR(error.status());
  const Result<LightChange> change = measure(MeasureLightChange);
  STILLRAY_RETURN_IF_ERROR(change.status());
  frame.temporal_error = *error;
  frame.light_change = *change;
  return Status::Ok();
}

/// Reads the object ids, unless they were read with the images.
Status FrameComparer::LoadObjects(Loaded* loaded) const {
  const FramePair& files = loaded->frame.files;
  const char* wanted = objects_.layer == kAnyObjects ? "a layer id.X or IndexOB.X" : "this layer";
  if (objects_.files.empty()) {
    return loaded->objects.empty() ? Status::NotFound(fmt::format(
                                         "--objects {}: neither {} nor {} has {}; --objects-of "
                                         "names files that have",
                                         objects_.layer, files.reference, files.test, wanted))
                                   : Status::Ok();
  }
  const std::string path =
      files.number ? FrameFileName(objects_.files, *files.number) : objects_.files;
  Result<PictureFile> file = ReadPictureFile(path, objects_.layer);
  STILLRAY_RETURN_IF_ERROR(file.status());
  if (file->objects.empty()) {
    return Status::NotFound(
        fmt::format("--objects {}: {} does not have {}", objects_.layer, path, wanted));
  }
  loaded->objects = std::move(file->objects);
  return Status::Ok();
}

Status FrameComparer::MeasureObjects(Loaded* loaded) const {
  if (objects_.layer.empty()) {
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(LoadObjects(loaded));
  ComparedFrame& frame = loaded->frame;
  Result<std::vector<ObjectErrors>> errors =
      CompareObjects(frame.test, frame.reference, frame.display, loaded->objects);
  STILLRAY_RETURN_IF_ERROR(errors.status());
  frame.objects = std::move(*errors);
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
    return PrefixStatus(files.test, metrics.status());
  }
  frame.metrics = *metrics;
  STILLRAY_RETURN_IF_ERROR(MeasureChange(&loaded));
  STILLRAY_RETURN_IF_ERROR(MeasureObjects(&loaded));
  current_ = std::move(loaded);
  has_current_ = true;
  return static_cast<const ComparedFrame*>(&current_.frame);
}

std::vector<std::string> FrameComparer::Notes() const {
  std::vector<std::string> notes;
  if (motion_missing_) {
    notes.push_back(
        "temporal error, light change: test frames without layers motion.X and motion.Y count as "
        "if nothing moved");
  }
  if (depth_missing_) {
    notes.push_back(
        "temporal error, light change: test frames without a layer depth.Z count as if no history "
        "was hidden");
  }
  return notes;
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/denoise_preview.h"

#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "common/output_folder.h"
#include "common/run_summary.h"
#include "core/lower_case.h"
#include "io/sequence.h"
#include "sequence/list_sequence.h"

namespace stillray {
namespace {

namespace fs = std::filesystem;

enum class Kind { kVideo, kPictures, kFolder };

Kind KindOf(const std::string& target) {
  return IsFolderName(target)               ? Kind::kFolder
         : LowerExtension(target) == ".mp4" ? Kind::kVideo
                                            : Kind::kPictures;
}

/// The denoised radiance in a file of an earlier run.
Result<Image3> ReadDenoised(const std::string& path, const AovLayout& layout) {
  const Result<ExrImage> image = ReadExr(path);
  if (!image.ok()) {
    return image.status();
  }
  const AovSource* source = layout.Find(Aov::kResult);
  source = source == nullptr ? layout.Find(Aov::kColour) : source;
  if (source == nullptr) {
    Result<Image3> added = ExrLayer(*image, "denoised.");
    return added.ok() ? std::move(added) : ExrColour(*image, path);
  }
  Image3 colour;
  for (size_t c = 0; c < 3; ++c) {
    const Channel* channel = image->Find(source->channels[c]);
    if (channel == nullptr) {
      return Status::NotFound(fmt::format("{}: has no channel {}", path, source->channels[c]));
    }
    colour[static_cast<int>(c)] = channel->values;
  }
  return colour;
}

}  // namespace

Status CheckPreview(const DenoiseOptions& options) {
  const std::string& target = options.text.preview;
  if (target.empty() || KindOf(target) != Kind::kPictures) {
    return Status::Ok();
  }
  const bool several = options.sequence.files.size() > 1;
  if (LowerExtension(target) != ".png" || (several && !IsSequenceName(target))) {
    return Status::InvalidArgument(
        fmt::format("--preview is '{}', expected a video such as preview.mp4, pictures such as "
                    "preview/####.png, or a folder",
                    target));
  }
  return Status::Ok();
}

Preview::Preview(const DenoiseOptions& options, const Settings& display)
    : options_(options),
      display_(display),
      target_(AsFramePattern(options.text.preview)),
      wants_video_(KindOf(options.text.preview) == Kind::kVideo),
      folder_(KindOf(options.text.preview) == Kind::kFolder) {}

std::string Preview::PictureName(const SequenceFile& file) const {
  return folder_ ? (fs::path(target_) / fs::path(file.input).stem()).string() + ".png"
                 : FrameFileName(target_, file.frame);
}

Status Preview::Open(const ExrExtent& extent, const AovLayout& layout, size_t finished) {
  STILLRAY_RETURN_IF_ERROR(
      MakeOutputFolder(folder_ ? target_ : fs::path(target_).parent_path().string()));
  if (!wants_video_) {
    return Status::Ok();
  }
  width_ = static_cast<int>(extent.width);
  height_ = static_cast<int>(extent.height);
  Result<std::unique_ptr<VideoWriter>> video =
      VideoWriter::Create(target_, width_, height_, options_.text.fps);
  if (!video.ok()) {
    return Status(video.status().code(), "--preview: " + video.status().message());
  }
  video_ = std::move(video.value());
  for (size_t i = 0; i < finished; ++i) {
    const SequenceFile& file = options_.sequence.files[i];
    const Result<Image3> colour = ReadDenoised(file.output, layout);
    if (!colour.ok()) {
      return colour.status();
    }
    STILLRAY_RETURN_IF_ERROR(Write(file, *colour));
  }
  return Status::Ok();
}

Status Preview::Write(const SequenceFile& file, const Image3& colour) {
  Rgb8Image picture;
  picture.width = colour.width();
  picture.height = colour.height();
  picture.pixels =
      ToDisplay(colour, display_.exposure, display_.tonemap, display_.dither, file.frame);
  if (!wants_video_) {
    const std::string path = PictureName(file);
    STILLRAY_RETURN_IF_ERROR(WritePng(path, picture));
    bytes_ += FileBytes(path);
    return Status::Ok();
  }
  if (picture.width != width_ || picture.height != height_) {
    ++other_size_;
    return Status::Ok();
  }
  return video_->Write(picture);
}

Status Preview::Finish() {
  if (!wants_video_) {
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(video_->Finish());
  bytes_ = FileBytes(target_);
  return Status::Ok();
}

std::string Preview::Summary() const {
  std::string text =
      fmt::format("preview: {}{} ({})", target_, folder_ && !target_.ends_with('/') ? "/" : "",
                  FormatBytes(bytes_));
  if (other_size_ > 0) {
    text += fmt::format("; {} frames of another size than {} x {} are not in it", other_size_,
                        width_, height_);
  }
  return text;
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/cameras.h"
#include "denoise/shot_cuts.h"
#include "io/aov_importer.h"
#include "sequence/memory.h"

namespace stillray {
namespace {

constexpr size_t kMaxFileBytes = size_t{4} << 30;

/// \param layout  with alpha, whose channels ImportFrame has found
Result<Image1> AlphaOf(const ExrImage& image, const AovLayout& layout, const std::string& file) {
  const Channel& channel = *image.Find(layout.Find(Aov::kAlpha)->channels[0]);
  if (channel.type == PixelType::kUint32) {
    return Status::InvalidArgument(fmt::format(
        "--alpha denoise: {} of {} has integers, expected halves or floats", channel.name, file));
  }
  return channel.values;
}

bool SameSize(const Frame& a, const Frame& b) {
  return a.width == b.width && a.height == b.height;
}

}  // namespace

Result<LoadedFile> LoadFile(const std::string& path, const SequenceOptions& options,
                            bool to_write) {
  LoadedFile file;
  Result<std::string> bytes = ReadWholeFile(path, kMaxFileBytes);
  if (!bytes.ok()) {
    return bytes.status();
  }
  file.bytes = std::move(bytes.value());
  const auto* data = reinterpret_cast<const uint8_t*>(file.bytes.data());
  const Result<ExrExtent> extent = MeasureExr(data, file.bytes.size(), path);
  if (!extent.ok()) {
    return extent.status();
  }
  file.extent = *extent;
  STILLRAY_RETURN_IF_ERROR(CheckMemory(file.extent, options, path));
  Result<ExrImage> image =
      DecodeExr(data, file.bytes.size(), path, to_write ? &file.stored : nullptr);
  if (!image.ok()) {
    return image.status();
  }
  file.image = std::move(image.value());
  return file;
}

Result<SequenceFrame> LoadFrame(const SequenceFile& file, const SequenceView& view, bool to_write) {
  const SequenceOptions& options = view.options;
  const AovLayout& layout = view.layout;
  Result<LoadedFile> loaded = LoadFile(file.input, options, to_write);
  if (!loaded.ok()) {
    return loaded.status();
  }
  SequenceFrame result;
  Result<std::optional<CameraMatrices>> camera = CameraOfFrame(view.motion, file, loaded->image);
  STILLRAY_RETURN_IF_ERROR(camera.status());
  result.camera = *camera;
  result.moves_images =
      result.camera && HasPerspective(*result.camera, loaded->image.width, loaded->image.height);
  io::ImportExtras extras;
  extras.parts = to_write && options.passes ? &result.parts : nullptr;
  extras.moves_images = result.moves_images;
  extras.images = &result.images;
  extras.camera = result.camera ? &*result.camera : nullptr;
  extras.loss_in_motion = &result.loss_in_motion;
  Result<Frame> frame = io::ImportFrameWith(loaded->image, layout, {0, 0}, file.input, extras);
  if (!frame.ok()) {
    return frame.status();
  }
  result.frame = std::move(frame.value());
  result.frame.index = file.frame;
  result.next_motion =
      ImportNextMotion(loaded->image, layout, {result.frame.jitter_x, result.frame.jitter_y, 0, 0});
  if (const auto any = result.camera ? result.camera : CameraOf(loaded->image)) {
    result.focal_pixels = FocalPixels(*any, result.frame.width, result.frame.height);
  }
  if (result.camera && result.frame.focal_pixels == 0) {
    result.frame.focal_pixels = static_cast<float>(
        CentredFocalPixels(*result.camera, result.frame.width, result.frame.height));
  }
  if (to_write) {
    result.bytes = std::move(loaded->bytes);
    result.stored = std::move(loaded->stored);
  }
  if (options.denoise_alpha) {
    Result<Image1> alpha = AlphaOf(loaded->image, layout, file.input);
    STILLRAY_RETURN_IF_ERROR(alpha.status());
    result.alpha = std::move(alpha.value());
  }
  return result;
}

void KeepGuidesOnly(SequenceFrame* frame) {
  frame->bytes = std::string();
  frame->stored = StoredPixels();
  frame->parts.clear();
  frame->alpha = Image1();
  frame->frame.signals.clear();
  frame->frame.emission = Image3();
  frame->frame.background = Image3();
  frame->next_motion = Image2();
  frame->images = io::FrameImages();
}

Link LinkToPrevious(const SequenceFrame& before, const SequenceView& view, SequenceFrame* now) {
  if (now->frame.index != before.frame.index + 1) {
    return Link::kGap;
  }
  if (!SameSize(before.frame, now->frame)) {
    return Link::kResized;
  }
  if (view.cache == nullptr || !view.cache->Restore(&now->frame, &now->origin)) {
    now->origin = CompleteMotion({before.frame, before.camera}, view.motion, view.layout,
                                 {&now->frame, now->camera, now->loss_in_motion});
    if (view.cache != nullptr) {
      view.cache->Keep(now->frame, now->origin);
    }
  }
  const MotionKind kind = now->origin.kind;
  if (now->moves_images || kind == MotionKind::kCamera || kind == MotionKind::kEstimate) {
    MoveImages(view.layout, before.camera, now->camera, &now->images, &now->frame);
  }
  if (view.layout.Find(Aov::kSpecularMotion) != nullptr && !now->frame.reflection.empty()) {
    AddNeighbourJitter(view.layout.specular_motion, before.frame, &now->frame.reflection.motion);
  }
  if (now->frame.guides.motion.empty()) {
    return Link::kCut;
  }
  return IsCut(FindAgain(now->frame, before.frame.guides)) ? Link::kCut : Link::kContinues;
}

double PartWithoutHistory(const DenoisedFrame& out, const Frame& frame) {
  const auto mask = std::find_if(out.images.begin(), out.images.end(),
                                 [](const NamedImage& i) { return i.name == "disocclusion"; });
  if (mask == out.images.end()) {
    return 0;
  }
  int64_t surfaces = 0;
  int64_t marked = 0;
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      if (std::isfinite(frame.guides.depth(x, y))) {
        ++surfaces;
        marked += mask->channels[0](x, y) > 0.5f;
      }
    }
  }
  return surfaces == 0 ? 0 : static_cast<double>(marked) / static_cast<double>(surfaces);
}

Image2 MotionToNext(const SequenceFrame& now, const SequenceFrame& next, const AovLayout& layout) {
  if (next.origin.kind == MotionKind::kCamera) {
    return MotionFromCameras(now.frame.guides.depth, *now.camera, *next.camera);
  }
  if (next.origin.kind == MotionKind::kEstimate || now.next_motion.empty()) {
    return ReverseMotion(next.frame.guides.motion, next.frame.guides.depth);
  }
  Image2 motion = now.next_motion;
  AddNeighbourJitter(layout.Find(Aov::kNextMotion) != nullptr ? layout.next_motion : layout.motion,
                     next.frame, &motion);
  return motion;
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/report_measure.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include "core/colour.h"
#include "quality/heat_map.h"
#include "quality/picture_file.h"
#include "stillray/io.h"

namespace stillray::report {
namespace {

/// Maximum size of a PNG file.
constexpr size_t kMaxPngBytes = size_t{1} << 30;

/// Estimated sizes of images encoded here, used to choose the number of frames before any frame is
/// read: noisy images and error maps hardly compress.
constexpr double kHeatMapBytesPerPixel = 0.7;
constexpr double kPictureBytesPerPixel = 2.5;

/// The needed data of one view of the current frame.
struct LoadedView {
  std::array<Image3, kSourceCount> image;  ///< empty where not read
  Image2 motion;                           ///< of the EXR file; empty if it has none
  Image1 depth;                            ///< of the EXR file; empty if it has none
  ShownView shown;
};

/// The data of the previous frame for the metrics over consecutive frames.
struct PreviousFrame {
  int64_t number = 0;
  std::array<LoadedView, kViewCount> views;
};

struct Needs {
  bool linear = false;
  bool display = false;
  bool shown = false;
};

bool CanMeasure(const FrameFiles& frame, int view, Source source) {
  const PictureFiles& test = frame[static_cast<size_t>(view)];
  const PictureFiles& reference = frame[kReference];
  return source == kLinear ? !test.exr.empty() && !reference.exr.empty()
                           : !test.png.empty() && !reference.png.empty();
}

bool CanMeasureAny(const FrameFiles& frame, Source source) {
  return CanMeasure(frame, kNoisy, source) || CanMeasure(frame, kTemporal, source) ||
         CanMeasure(frame, kDenoised, source);
}

/// Whether some view has only display values in common with the reference.
bool NeedsDisplay(const SequenceFiles& files) {
  return std::any_of(files.begin(), files.end(), [](const auto& entry) {
    for (int view = 0; view < kTestViewCount; ++view) {
      if (!CanMeasure(entry.second, view, kLinear) && CanMeasure(entry.second, view, kDisplay)) {
        return true;
      }
    }
    return false;
  });
}

/// Exposure, clip, sRGB.
Result<Rgb8Image> DevelopClipped(const Image3& radiance, double exposure) {
  const float scale = static_cast<float>(std::exp2(exposure));
  Rgb8Image picture{radiance.width(), radiance.height(), {}};
  picture.pixels.reserve(3 * static_cast<size_t>(radiance.width()) *
                         static_cast<size_t>(radiance.height()));
  for (int y = 0; y < radiance.height(); ++y) {
    for (int x = 0; x < radiance.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        const float value = radiance[c](x, y) * scale;
        // Written so that NaN becomes black.
        const float clipped = value > 0.0f ? std::min(value, 1.0f) : 0.0f;
        picture.pixels.push_back(static_cast<uint8_t>(std::lround(255.0f * SrgbEncode(clipped))));
      }
    }
  }
  return picture;
}

Result<std::string> DevelopPng(const Image3& radiance, const RenderLog& log,
                               const ReportOptions& options) {
  const Result<Rgb8Image> picture = options.develop
                                        ? options.develop(radiance, log.tonemap, log.exposure)
                                        : DevelopClipped(radiance, log.exposure);
  if (!picture.ok()) {
    return picture.status();
  }
  return EncodePng(*picture);
}

/// All images must have the size of the first image read.
class SizeCheck {
 public:
  explicit SizeCheck(const RenderLog& log) : log_(log) {}

  Status Add(const Image3& image, const std::string& path) {
    if (first_path_.empty()) {
      first_path_ = path;
      width_ = image.width();
      height_ = image.height();
      if (log_.width.value_or(width_) != width_ || log_.height.value_or(height_) != height_) {
        return Status::BadData(fmt::format("{}: {}x{} pixels, but render.json says {}x{}", path,
                                           width_, height_, log_.width.value_or(width_),
                                           log_.height.value_or(height_)));
      }
    }
    if (image.width() != width_ || image.height() != height_) {
      return Status::BadData(fmt::format("{}: {}x{} pixels, but {} has {}x{}", path, image.width(),
                                         image.height(), first_path_, width_, height_));
    }
    return Status::Ok();
  }

  int width() const { return width_; }
  int height() const { return height_; }

 private:
  const RenderLog& log_;
  std::string first_path_;
  int width_ = 0;
  int height_ = 0;
};

Status LoadView(const PictureFiles& files, const Needs& needs, const RenderLog& log,
                const ReportOptions& options, LoadedView* view) {
  const bool show_png = needs.shown && !files.png.empty();
  const bool show_exr = needs.shown && files.png.empty() && !files.exr.empty();
  // An image of the page is decoded even if it is not compared, so that no damaged file gets into
  // the page.
  if (needs.display || show_png) {
    Result<Image3> image = ReadImage(files.png);
    if (!image.ok()) {
      return image.status();
    }
    view->image[kDisplay] = std::move(*image);
  }
  if (needs.linear || show_exr) {
    Result<PictureFile> picture = ReadPictureFile(files.exr);
    if (!picture.ok()) {
      return picture.status();
    }
    view->image[kLinear] = std::move(picture->colour);
    view->motion = std::move(picture->motion);
    view->depth = std::move(picture->depth);
  }
  if (show_png || show_exr) {
    Result<std::string> png = show_png ? ReadWholeFile(files.png, kMaxPngBytes)
                                       : DevelopPng(view->image[kLinear], log, options);
    if (!png.ok()) {
      return png.status();
    }
    view->shown.png = std::move(*png);
    view->shown.made_from_exr = show_exr;
  }
  return Status::Ok();
}

Status MakeMaps(const LoadedView& reference, Source source, LoadedView* view) {
  constexpr std::array<ErrorMap, kMapCount> kKinds = {ErrorMap::kFlip,
                                                      ErrorMap::kRelativeSquaredError};
  constexpr std::array<HeatScale, kMapCount> kScales = {kFlipScale, kRelativeSquaredErrorScale};
  for (size_t kind = 0; kind < kMapCount; ++kind) {
    const Result<Image1> errors = MakeErrorMap(view->image[source], reference.image[source],
                                               source == kDisplay, kKinds[kind]);
    if (!errors.ok()) {
      return errors.status();
    }
    Result<std::string> png = EncodeHeatMap(*errors, kScales[kind]);
    if (!png.ok()) {
      return png.status();
    }
    view->shown.maps[kind] = std::move(*png);
  }
  view->shown.map_source = source;
  return Status::Ok();
}

/// Runs body(0) .. body(count - 1) in parallel; of several failures the one with the lowest index
/// is returned.
template <typename Body>
Status InParallel(int count, const Body& body) {
  std::vector<Status> results(static_cast<size_t>(count));
  tbb::parallel_for(0, count, [&](int i) { results[static_cast<size_t>(i)] = body(i); });
  for (const Status& result : results) {
    STILLRAY_RETURN_IF_ERROR(result);
  }
  return Status::Ok();
}

/// Processes the frames in sequence, so that only the images of two frames and the bytes of the
/// page's images are in memory.
class Measurer {
 public:
  Measurer(const SequenceFiles& files, const RenderLog& log, const ReportOptions& options)
      : files_(files),
        log_(log),
        options_(options),
        needs_display_(NeedsDisplay(files)),
        sizes_(log) {}

  Result<Measurements> Run() {
    STILLRAY_RETURN_IF_ERROR(ReadFirstSize());
    const std::vector<int> shown = ChooseShown();
    result_.thinned_for_size = static_cast<int>(shown.size()) <
                               std::min(options_.max_frames, static_cast<int>(files_.size()));
    int index = 0;
    for (const auto& [number, frame] : files_) {
      STILLRAY_RETURN_IF_ERROR(
          AddFrame(number, frame, std::binary_search(shown.begin(), shown.end(), index)));
      ++index;
      if (options_.progress && !options_.progress(index, static_cast<int>(files_.size()))) {
        return Status::Cancelled();
      }
    }
    ThinToSize();
    result_.width = sizes_.width();
    result_.height = sizes_.height();
    return std::move(result_);
  }

 private:
  Status ReadFirstSize() {
    for (const PictureFiles& picture : files_.begin()->second) {
      if (!picture.empty()) {
        const std::string& path = picture.png.empty() ? picture.exr : picture.png;
        const Result<PictureFile> image = ReadPictureFile(path);
        return image.ok() ? sizes_.Add(image->colour, path) : image.status();
      }
    }
    return Status::Internal("a frame without files");
  }

  /// Approximate size of a frame in the page.
  double EstimateBytes(const FrameFiles& frame) const {
    const double pixels = static_cast<double>(sizes_.width()) * sizes_.height();
    double bytes = 0;
    for (int view = 0; view < kViewCount; ++view) {
      const PictureFiles& picture = frame[static_cast<size_t>(view)];
      if (!picture.png.empty()) {
        std::error_code error;
        const std::uintmax_t size = std::filesystem::file_size(picture.png, error);
        bytes += error ? 0.0 : static_cast<double>(size);
      } else if (!picture.exr.empty()) {
        bytes += kPictureBytesPerPixel * pixels;
      }
      if (view != kReference &&
          (CanMeasure(frame, view, kLinear) || CanMeasure(frame, view, kDisplay))) {
        bytes += kMapCount * kHeatMapBytesPerPixel * pixels;
      }
    }
    return bytes * 4 / 3;
  }

  /// Indices of the frames to show, limited by the estimated size of the page.
  std::vector<int> ChooseShown() const {
    std::vector<double> bytes;
    for (const auto& entry : files_) {
      bytes.push_back(EstimateBytes(entry.second));
    }
    const int total = static_cast<int>(files_.size());
    for (int count = std::min(options_.max_frames, total);; --count) {
      std::vector<int> chosen = SpreadEvenly(total, count);
      double sum = 0;
      for (const int index : chosen) {
        sum += bytes[static_cast<size_t>(index)];
      }
      if (count == 1 || sum <= static_cast<double>(options_.max_page_bytes)) {
        return chosen;
      }
    }
  }

  /// Drops frames if the estimate was too low.
  void ThinToSize() {
    const int total = static_cast<int>(result_.shown.size());
    for (int count = total;; --count) {
      const std::vector<int> kept = SpreadEvenly(total, count);
      size_t bytes = 0;
      for (const int index : kept) {
        bytes += BytesOf(result_.shown[static_cast<size_t>(index)]) * 4 / 3;
      }
      if (count == 1 || bytes <= static_cast<size_t>(options_.max_page_bytes)) {
        if (count < total) {
          Keep(kept);
        }
        return;
      }
    }
  }

  static size_t BytesOf(const ShownFrame& frame) {
    size_t bytes = 0;
    for (const ShownView& view : frame.views) {
      bytes += view.png.size();
      for (const std::string& map : view.maps) {
        bytes += map.size();
      }
    }
    return bytes;
  }

  void Keep(const std::vector<int>& kept) {
    std::vector<ShownFrame> rest;
    for (const int index : kept) {
      rest.push_back(std::move(result_.shown[static_cast<size_t>(index)]));
    }
    result_.shown = std::move(rest);
    result_.thinned_for_size = true;
  }

  Needs NeedsOf(const FrameFiles& frame, int view, bool shown) const {
    const auto measured = [&](Source source) {
      return view == kReference ? CanMeasureAny(frame, source) : CanMeasure(frame, view, source);
    };
    return {measured(kLinear), needs_display_ && measured(kDisplay), shown};
  }

  Status AddFrame(int64_t number, const FrameFiles& frame, bool shown) {
    std::array<LoadedView, kViewCount> views;
    STILLRAY_RETURN_IF_ERROR(InParallel(kViewCount, [&](int view) {
      const size_t v = static_cast<size_t>(view);
      return LoadView(frame[v], NeedsOf(frame, view, shown), log_, options_, &views[v]);
    }));
    for (size_t v = 0; v < kViewCount; ++v) {
      for (size_t source = 0; source < kSourceCount; ++source) {
        if (!views[v].image[source].empty()) {
          STILLRAY_RETURN_IF_ERROR(
              sizes_.Add(views[v].image[source], source == kLinear ? frame[v].exr : frame[v].png));
        }
      }
    }
    MeasuredFrame measured;
    measured.number = number;
    STILLRAY_RETURN_IF_ERROR(InParallel(kTestViewCount, [&](int view) {
      return Compare(frame, view, shown, views[kReference], &views[static_cast<size_t>(view)],
                     &measured);
    }));
    if (CanMeasureAny(frame, kLinear) || CanMeasureAny(frame, kDisplay)) {
      STILLRAY_RETURN_IF_ERROR(MeasureChanges(views, &measured));
      result_.measured.push_back(measured);
    }
    if (shown) {
      ShownFrame kept{number, {}};
      for (size_t v = 0; v < kViewCount; ++v) {
        kept.views[v] = std::move(views[v].shown);
      }
      result_.shown.push_back(std::move(kept));
    }
    previous_ = {number, std::move(views)};
    return Status::Ok();
  }

  Status MeasureChanges(const std::array<LoadedView, kViewCount>& views, MeasuredFrame* measured) {
    if (!previous_ || previous_->number + 1 != measured->number) {
      return Status::Ok();
    }
    const LoadedView& reference = views[kReference];
    const LoadedView& reference_before = previous_->views[kReference];
    for (const Source source : {kLinear, kDisplay}) {
      for (size_t v = 0; v < kTestViewCount; ++v) {
        const LoadedView& now = views[v];
        const LoadedView& before = previous_->views[v];
        if (!measured->metrics[source][v] || before.image[source].empty() ||
            reference_before.image[source].empty()) {
          continue;
        }
        const auto measure = [&](const auto& function) {
          return function(now.image[source], before.image[source], reference.image[source],
                          reference_before.image[source], now.motion, now.depth, before.depth,
                          source == kDisplay);
        };
        const Result<double> error = measure(TemporalError);
        STILLRAY_RETURN_IF_ERROR(error.status());
        const Result<LightChange> change = measure(MeasureLightChange);
        STILLRAY_RETURN_IF_ERROR(change.status());
        if (!std::isnan(*error)) {
          measured->temporal_error[source][v] = *error;
        }
        if (!std::isnan(change->Share())) {
          measured->light_change[source][v] = *change;
        }
        result_.without_motion = result_.without_motion || now.motion.empty();
      }
    }
    return Status::Ok();
  }

  Status Compare(const FrameFiles& frame, int view, bool shown, const LoadedView& reference,
                 LoadedView* loaded, MeasuredFrame* measured) const {
    bool has_maps = false;
    for (const Source source : {kLinear, kDisplay}) {
      if (!CanMeasure(frame, view, source) || (source == kDisplay && !needs_display_)) {
        continue;
      }
      const Result<ImageMetrics> metrics =
          CompareImages(loaded->image[source], reference.image[source], source == kDisplay);
      if (!metrics.ok()) {
        const std::string& path = source == kLinear ? frame[static_cast<size_t>(view)].exr
                                                    : frame[static_cast<size_t>(view)].png;
        return Status(metrics.status().code(), fmt::format("{} against the reference: {}", path,
                                                           metrics.status().message()));
      }
      measured->metrics[source][static_cast<size_t>(view)] = *metrics;
      if (shown && !has_maps) {
        STILLRAY_RETURN_IF_ERROR(MakeMaps(reference, source, loaded));
        has_maps = true;
      }
    }
    return Status::Ok();
  }

  const SequenceFiles& files_;
  const RenderLog& log_;
  const ReportOptions& options_;
  const bool needs_display_;
  SizeCheck sizes_;
  std::optional<PreviousFrame> previous_;
  Measurements result_;
};

}  // namespace

Result<Measurements> Measure(const SequenceFiles& files, const RenderLog& log,
                             const ReportOptions& options) {
  return Measurer(files, log, options).Run();
}

}  // namespace stillray::report

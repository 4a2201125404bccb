// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/output_size.h"

#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/run_summary.h"
#include "render/render_files.h"

namespace stillray {
namespace {

/// Bytes per pixel after compression, measured on the built-in scenes and on textured rooms at 640
/// x 360. Noise hardly compresses; denoised images and guides do.
constexpr double kExrPicture = 3.2;  ///< R, G, B in halves
constexpr double kExrNoisy = 30.0;   ///< all signals and guides
constexpr double kExrGuide = 4.0;    ///< motion and depth are floats, other guides halves
constexpr double kExrOutput = 3.0;   ///< a layer of the denoiser
constexpr double kFloatsOverHalves = 2.2;
constexpr double kPngPicture = 1.0;
constexpr double kPngNoisy = 2.6;
constexpr double kJpgPicture = 0.35;
constexpr double kJpgNoisy = 1.2;
constexpr double kVideo = 0.08;

/// Bytes per pixel of all frames, and additional bytes of frames with a reference.
struct PerPixel {
  double exr = 0;
  double png = 0;
  double jpg = 0;
};

PerPixel PerPixelOfFrame(const RenderOptions& options) {
  PerPixel sum = {kExrPicture + kExrGuide * static_cast<double>(options.guides.size()), kPngPicture,
                  kJpgPicture};
  for (const std::string& name : options.outputs) {
    sum.exr += kExrOutput;
    if (IsPictureOutput(name)) {
      sum.exr += kExrPicture;
      sum.png += kPngPicture;
      sum.jpg += kJpgPicture;
    }
  }
  if (options.text.save_inputs) {
    sum.exr += kExrNoisy;
    sum.png += kPngNoisy;
    sum.jpg += kJpgNoisy;
  }
  return sum;
}

}  // namespace

OutputSize EstimateOutputSize(const RenderOptions& options, int64_t first_frame) {
  const double pixels =
      static_cast<double>(options.render.width) * static_cast<double>(options.render.height);
  const PerPixel frame = PerPixelOfFrame(options);
  double exr = 0;
  double png = 0;
  double jpg = 0;
  for (int64_t i = first_frame; i <= options.frames.last; ++i) {
    const double reference = options.WantsReference(i) ? 1.0 : 0.0;
    exr += frame.exr + reference * kExrPicture;
    png += frame.png + reference * kPngPicture;
    jpg += frame.jpg + reference * kJpgPicture;
  }
  const double mp4 = kVideo * static_cast<double>(options.frames.count());
  exr *= options.exr_type == PixelType::kFloat ? kFloatsOverHalves : 1.0;
  OutputSize size;
  size.exr = options.exr ? static_cast<int64_t>(exr * pixels) : 0;
  size.png = options.png ? static_cast<int64_t>(png * pixels) : 0;
  size.jpg = options.jpg ? static_cast<int64_t>(jpg * pixels) : 0;
  size.mp4 = options.mp4 ? static_cast<int64_t>(mp4 * pixels) : 0;
  return size;
}

std::string OutputSizeText(const RenderOptions& options, int64_t first_frame) {
  const OutputSize size = EstimateOutputSize(options, first_frame);
  std::vector<std::string> parts;
  for (const auto& [name, bytes] : {std::pair("EXR", size.exr), std::pair("PNG", size.png),
                                    std::pair("JPEG", size.jpg), std::pair("video", size.mp4)}) {
    if (bytes > 0) {
      parts.push_back(fmt::format("{} {}", name, FormatBytes(bytes)));
    }
  }
  const int64_t frames = options.frames.last - first_frame + 1;
  const std::string formats =
      parts.size() > 1 ? fmt::format(" ({})", fmt::join(parts, ", ")) : std::string();
  return fmt::format("writing {} frame{} of {} x {} pixels to {}, about {}{}", frames,
                     frames == 1 ? "" : "s", options.render.width, options.render.height,
                     options.text.folder, FormatBytes(size.total()), formats);
}

std::string DiskSpaceWarning(const std::string& folder, const OutputSize& size) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error || space.available >= static_cast<uintmax_t>(size.total())) {
    return "";
  }
  return fmt::format("warning: the disk of {} has {} left\n", folder,
                     FormatBytes(static_cast<int64_t>(space.available)));
}

}  // namespace stillray

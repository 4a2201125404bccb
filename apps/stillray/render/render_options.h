// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The command line of `stillray render`, checked before any work begins.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/display_options.h"
#include "common/filter_options.h"
#include "common/post_options.h"
#include "common/tracer_options.h"
#include "render/vulkan/tracing_way.h"
#include "stillray/denoise.hpp"
#include "stillray/io.h"
#include "stillray/render.h"
#include "stillray/scene.h"

namespace stillray {

/// Unparsed option values.
struct RenderArguments {
  std::string scene = "builtin:cornell";
  std::string folder = "out";
  std::string size = "1280x720";
  std::string frames = "1-120";
  double fps = 30;
  TracerArguments tracer;
  FilterArguments filter;
  std::string environment;
  std::string lens_mask;
  std::string camera;
  int reference_spp = 0;
  std::string reference_frames;
  std::vector<std::string> aovs;
  std::string formats = "exr,png,mp4";
  bool formats_given = false;
  bool float_exr = false;
  bool save_inputs = false;
  DisplayArguments display;
  PostArguments post;
  bool still = false;
  int threads = 0;
  bool resume = false;
  bool timings = false;
  std::string device = "auto";
  std::string trace_device;  ///< empty: `device`
  bool verbose = false;
  std::string ray_tracing = "auto";
  std::string first_hits = "auto";
  std::string textures = "auto";
  std::string json_path;
};

/// Inclusive range of frame numbers. Frame 1 is the start of the animation.
struct FrameRange {
  int64_t first = 1;
  int64_t last = 120;
  int64_t count() const { return last - first + 1; }
  bool Contains(int64_t frame) const { return frame >= first && frame <= last; }
};

/// Parsed and validated options.
struct RenderOptions {
  RenderArguments text;
  FrameRange frames;
  std::vector<FrameRange> reference_frames;
  RenderSettings render;
  PostEffects post;
  /// With PostEffects::depth_of_field: `render` including its lens; `render` itself then has no
  /// lens.
  RenderSettings lens;
  std::string preset;  ///< base preset of `denoise`
  Settings denoise;
  render::TracingWay tracing_way = render::TracingWay::kAuto;
  render::FirstHits first_hits = render::FirstHits::kAuto;
  render::TextureWay textures = render::TextureWay::kAuto;
  PixelType exr_type = PixelType::kHalf;
  bool exr = false;
  bool png = false;
  bool jpg = false;
  bool mp4 = false;
  std::vector<std::string> outputs;  ///< outputs of the denoiser, by full name
  std::vector<std::string> guides;   ///< guides of the frame in the files of the denoised image

  bool WantsReference(int64_t frame) const;
  /// Whether files of the denoised image contain the guide.
  bool WritesGuide(std::string_view name) const;
  /// Time of a frame in seconds.
  double Seconds(int64_t frame) const;
  double PreviousSeconds(int64_t frame) const;
};

/// Paths per pixel and frame.
inline double SamplesPerPixel(const RenderSettings& render) {
  return static_cast<double>(render.spp) / render.cycle;
}

/// \return kInvalidArgument naming the option, its value and the expected ones
Result<RenderOptions> ParseRenderArguments(const RenderArguments& arguments);

/// Whether `count` frames of this size fit into main memory: with 2, one frame is rendered while
/// the files of another are written; with 3, a third frame is traced concurrently.
bool FramesFit(const RenderSettings& render, int count);

/// The name of a file without its folders.
std::string FileNameOf(const std::string& path);

/// Checksums of file contents as text; empty for built-in data.
std::string SceneContent(const Scene& scene);
std::string LensMaskContent(const RenderOptions& options, const Scene& scene);
std::string EnvironmentContent(const RenderOptions& options, const Scene& scene);

/// All settings that affect the images, one "name value" per line: runs with equal fingerprints
/// produce identical images. Scene and environment are identified by their content, not by their
/// path.
std::string RenderFingerprint(const RenderOptions& options, const Scene& scene);

}  // namespace stillray

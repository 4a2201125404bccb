// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/render_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>

#include "common/trace_device.h"
#include "core/checksum.h"
#include "core/nearest_names.h"
#include "denoise/output_names.h"
#include "io/memory_limit.h"
#include "render/render_files.h"

namespace stillray {
namespace {

constexpr int64_t kLastFrame = 99'999'999;
/// Memory of frame, histories and temporary planes in bytes, measured and rounded up, for rejecting
/// sizes that would exhaust main memory.
constexpr int64_t kBytesPerPixel = 800;
/// Memory of a second frame whose files are written concurrently: 40 planes, and the channels of
/// its files.
constexpr int64_t kBytesPerPixelOfSecondFrame = 300;
/// Memory of a third frame that is traced concurrently: all planes of a Frame with four signals,
/// and a reference.
constexpr int64_t kBytesPerPixelOfThirdFrame = 220;

template <typename T>
bool ParseWhole(std::string_view text, T* out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *out);
  return error == std::errc() && end == text.data() + text.size();
}

std::vector<std::string> SplitList(std::string_view text) {
  std::vector<std::string> parts;
  while (!text.empty()) {
    const size_t comma = text.find(',');
    if (comma != 0) {
      parts.emplace_back(text.substr(0, comma));
    }
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
  }
  return parts;
}

Status ParseSize(const std::string& text, RenderSettings* render) {
  const size_t x = text.find('x');
  const bool parsed = x != std::string::npos &&
                      ParseWhole(std::string_view(text).substr(0, x), &render->width) &&
                      ParseWhole(std::string_view(text).substr(x + 1), &render->height);
  if (!parsed || render->width < 1 || render->height < 1 || render->width > kMaxSide ||
      render->height > kMaxSide) {
    return Status::InvalidArgument(fmt::format(
        "--size is '{}', expected WIDTHxHEIGHT with 1 to {} pixels a side", text, kMaxSide));
  }
  const int64_t needed = int64_t{render->width} * render->height * kBytesPerPixel;
  const int64_t memory = AvailableMemory();
  if (memory > 0 && needed > memory) {
    return Status::InvalidArgument(
        fmt::format("--size is '{}', which takes about {} GB; this machine has {} GB", text,
                    needed / 1'000'000'000, memory / 1'000'000'000));
  }
  return Status::Ok();
}

Status ParseRange(const char* option, const std::string& text, FrameRange* range) {
  const size_t dash = text.find('-');
  const std::string_view all(text);
  bool parsed = ParseWhole(all.substr(0, dash), &range->first);
  range->last = range->first;
  if (dash != std::string::npos) {
    parsed = parsed && ParseWhole(all.substr(dash + 1), &range->last);
  }
  if (!parsed || range->first < 0 || range->last < range->first || range->last > kLastFrame) {
    return Status::InvalidArgument(
        fmt::format("{} is '{}', expected FIRST-LAST or one number, 0 to {}, such as 1-120", option,
                    text, kLastFrame));
  }
  return Status::Ok();
}

Status ParseFormats(const RenderArguments& arguments, RenderOptions* options) {
  for (const std::string& name : SplitList(arguments.formats)) {
    bool* wanted = name == "exr"   ? &options->exr
                   : name == "png" ? &options->png
                   : name == "jpg" ? &options->jpg
                   : name == "mp4" ? &options->mp4
                                   : nullptr;
    if (wanted == nullptr) {
      constexpr std::string_view kFormats[] = {"exr", "png", "jpg", "mp4"};
      return Status::InvalidArgument(
          fmt::format("--format has '{}', expected a list of exr, png, jpg, mp4{}", name,
                      DidYouMean(name, kFormats)));
    }
    *wanted = true;
  }
  if (!options->exr && !options->png && !options->jpg && !options->mp4) {
    return Status::InvalidArgument("--format is empty, expected a list of exr, png, jpg, mp4");
  }
  return Status::Ok();
}

/// Adds motion and depth, by which `stillray compare` reprojects frames for the temporal error
/// against a reference.
void AddGuidesOfMeasures(RenderOptions* options) {
  if (options->text.reference_spp <= 0) {
    return;
  }
  for (const char* name : {"motion", "depth"}) {
    if (!options->WritesGuide(name)) {
      options->guides.emplace_back(name);
    }
  }
}

Status UnknownAov(const std::string& name, const std::vector<std::string>& outputs) {
  std::vector<std::string> known(std::begin(kGuideNames), std::end(kGuideNames));
  known.insert(known.end(), outputs.begin(), outputs.end());
  return Status::InvalidArgument(fmt::format("--aov has '{}', expected some of {}{}", name,
                                             fmt::join(known, ", "), DidYouMeanOneOf(name, known)));
}

/// Splits the names of --aov into outputs of the denoiser and guides of the frame.
Status ParseAovs(const RenderArguments& arguments, RenderOptions* options) {
  const std::vector<std::string> known = Denoiser::OutputNames(options->denoise);
  for (const std::string& list : arguments.aovs) {
    for (const std::string& name : SplitList(list)) {
      if (std::find(std::begin(kGuideNames), std::end(kGuideNames), name) !=
          std::end(kGuideNames)) {
        if (!options->WritesGuide(name)) {
          options->guides.push_back(name);
        }
        continue;
      }
      if (!AddOutputs(known, name, &options->outputs)) {
        return UnknownAov(name, known);
      }
      if (!options->exr && !IsPictureOutput(name)) {
        return Status::InvalidArgument(
            fmt::format("--aov {} is written to EXR files only: add exr to --format", name));
      }
    }
  }
  return Status::Ok();
}

Status ParseReference(const RenderArguments& arguments, RenderOptions* options) {
  if (arguments.reference_frames.empty()) {
    if (arguments.reference_spp > 0) {
      options->reference_frames.push_back(options->frames);
    }
    return Status::Ok();
  }
  if (arguments.reference_spp <= 0) {
    return Status::InvalidArgument("--reference-frames needs --reference SPP");
  }
  for (const std::string& part : SplitList(arguments.reference_frames)) {
    FrameRange range;
    STILLRAY_RETURN_IF_ERROR(ParseRange("--reference-frames", part, &range));
    options->reference_frames.push_back(range);
  }
  return Status::Ok();
}

/// Parses all settings except the size, which is checked against main memory.
Status ParseTracer(const RenderArguments& arguments, const FilterOptions& filter,
                   RenderSettings* render) {
  const Result<RenderSettings> tracer = ParseTracerArguments(arguments.tracer, filter.render);
  STILLRAY_RETURN_IF_ERROR(tracer.status());
  *render = *tracer;
  if (render->guides == GuideCoverage::kSparse && render->cycle == 1) {
    return Status::InvalidArgument(
        fmt::format("--guides sparse is for --spp below 1, but --spp is {}", render->spp));
  }
  // Without temporal antialiasing jitter would only make edges flicker.
  render->jitter = render->jitter && filter.settings.antialias != Antialias::kOff;
  return Status::Ok();
}

Status ParseSettings(const RenderArguments& arguments, RenderOptions* options) {
  Result<FilterOptions> filter = ParseFilterArguments(arguments.filter);
  STILLRAY_RETURN_IF_ERROR(filter.status());
  STILLRAY_RETURN_IF_ERROR(SetDisplay(arguments.display, &filter->settings));
  options->preset = filter->preset;
  options->denoise = filter->settings;
  STILLRAY_RETURN_IF_ERROR(ParseTracer(arguments, *filter, &options->render));
  return ParseSize(arguments.size, &options->render);
}

/// Parses --post; with depth of field as an effect, frames are traced with a pinhole camera.
Status ParsePost(const RenderArguments& arguments, RenderOptions* options) {
  const Result<PostEffects> post = ParsePostArguments(arguments.post);
  STILLRAY_RETURN_IF_ERROR(post.status());
  options->post = *post;
  if (post->any() && options->render.guides == GuideCoverage::kSparse) {
    return Status::InvalidArgument("--post needs guides in every pixel, expected --guides full");
  }
  if (!post->depth_of_field) {
    return Status::Ok();
  }
  if (!arguments.lens_mask.empty() || options->render.blades.value_or(0) != 0) {
    return Status::InvalidArgument(
        fmt::format("--post dof has a round aperture, expected no {}",
                    arguments.lens_mask.empty() ? "--blades" : "--lens-mask"));
  }
  options->lens = options->render;
  options->render.aperture = 0.0f;
  options->render.f_number.reset();
  return Status::Ok();
}

/// "room.glb with content 0123456789abcdef".
std::string NameAndContent(const std::string& path, const std::string& content) {
  return FileNameOf(path) + (content.empty() ? "" : " with content " + content);
}

uint64_t ChecksumOf(const Image3& image) {
  uint64_t sum = kEmptyChecksum;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < image.height(); ++y) {
      const auto* row = reinterpret_cast<const uint8_t*>(image[c].Row(y));
      sum = AddToChecksum({row, static_cast<size_t>(image.width()) * sizeof(float)}, sum);
    }
  }
  return sum;
}

}  // namespace

bool FramesFit(const RenderSettings& render, int count) {
  const int64_t more =
      (count > 1 ? kBytesPerPixelOfSecondFrame : 0) + (count > 2 ? kBytesPerPixelOfThirdFrame : 0);
  const int64_t needed = int64_t{render.width} * render.height * (kBytesPerPixel + more);
  const int64_t memory = AvailableMemory();
  return memory <= 0 || needed <= memory;
}

bool RenderOptions::WritesGuide(std::string_view name) const {
  return std::find(guides.begin(), guides.end(), name) != guides.end();
}

bool RenderOptions::WantsReference(int64_t frame) const {
  return std::any_of(reference_frames.begin(), reference_frames.end(),
                     [&](const FrameRange& range) { return range.Contains(frame); });
}

double RenderOptions::Seconds(int64_t frame) const {
  return static_cast<double>((text.still ? frames.first : frame) - 1) / text.fps;
}

double RenderOptions::PreviousSeconds(int64_t frame) const {
  return text.still ? Seconds(frame) : Seconds(frame - 1);
}

Result<RenderOptions> ParseRenderArguments(const RenderArguments& arguments) {
  RenderOptions options;
  options.text = arguments;
  STILLRAY_RETURN_IF_ERROR(ParseRange("--frames", arguments.frames, &options.frames));
  STILLRAY_RETURN_IF_ERROR(ParseSettings(arguments, &options));
  STILLRAY_RETURN_IF_ERROR(ParsePost(arguments, &options));
  STILLRAY_RETURN_IF_ERROR(ParseFormats(arguments, &options));
  STILLRAY_RETURN_IF_ERROR(ParseAovs(arguments, &options));
  STILLRAY_RETURN_IF_ERROR(ParseReference(arguments, &options));
  AddGuidesOfMeasures(&options);
  const Result<render::TracingWay> way = ParseTracingWay(arguments.ray_tracing);
  STILLRAY_RETURN_IF_ERROR(way.status());
  options.tracing_way = *way;
  const Result<render::FirstHits> first_hits = ParseFirstHits(arguments.first_hits);
  STILLRAY_RETURN_IF_ERROR(first_hits.status());
  options.first_hits = *first_hits;
  const Result<render::TextureWay> textures = ParseTextureWay(arguments.textures);
  STILLRAY_RETURN_IF_ERROR(textures.status());
  options.textures = *textures;
  options.exr_type = arguments.float_exr ? PixelType::kFloat : PixelType::kHalf;
  return options;
}

std::string FileNameOf(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

std::string SceneContent(const Scene& scene) {
  return scene.checksum == 0 ? "" : fmt::format("{:016x}", scene.checksum);
}

std::string LensMaskContent(const RenderOptions& options, const Scene& scene) {
  if (options.text.lens_mask.empty()) {
    return "";
  }
  const Texture& mask = scene.textures[static_cast<size_t>(scene.cameras.front().lens.mask)];
  return fmt::format("{:016x}", AddToChecksum(mask.texels, kEmptyChecksum));
}

std::string EnvironmentContent(const RenderOptions& options, const Scene& scene) {
  return options.text.environment.empty()
             ? ""
             : fmt::format("{:016x}", ChecksumOf(scene.environment.map));
}

std::string RenderFingerprint(const RenderOptions& options, const Scene& scene) {
  const RenderArguments& a = options.text;
  const std::string scene_text = NameAndContent(a.scene, SceneContent(scene));
  const std::string environment_text =
      NameAndContent(a.environment, EnvironmentContent(options, scene));
  std::string text = fmt::format(
      "scene {}\nframes from {}\nsize {}\nfps {}\nenvironment {}\ncamera {}\nreference {}\n"
      "reference-frames {}\naov {}\nformat {}\nfloat {}\ninputs {}\nstill {}\n",
      scene_text, options.frames.first, a.size, a.fps, environment_text, a.camera, a.reference_spp,
      a.reference_frames, fmt::join(a.aovs, ","), a.formats, a.float_exr, a.save_inputs, a.still);
  if (!a.lens_mask.empty()) {
    text +=
        fmt::format("lens-mask {}\n", NameAndContent(a.lens_mask, LensMaskContent(options, scene)));
  }
  if (options.post.any()) {
    text += fmt::format("post {}\n", PostText(options.post));
  }
  if (options.post.depth_of_field) {
    text += fmt::format("post aperture {}\n", GetRenderParameter(options.lens, "aperture").value());
  }
  for (const Parameter& p : RenderParameters()) {
    text += fmt::format("{} {}\n", p.name, GetRenderParameter(options.render, p.name).value());
  }
  if (!a.trace_device.empty()) {
    text += fmt::format("trace-device {}\n", a.trace_device);
  }
  text += fmt::format("device {}\nray-tracing {}\nfirst-hits {}\ntextures {}\n", a.device,
                      a.ray_tracing, a.first_hits, a.textures);
  for (const Parameter& p : Parameters()) {
    text += fmt::format("{} {}\n", p.name, GetParameter(options.denoise, p.name).value());
  }
  return text;
}

}  // namespace stillray

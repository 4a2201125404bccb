// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray shaders: exports the compute shaders of the denoiser as a pack for engines.
#include <charconv>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "common/commands.h"
#include "common/console.h"
#include "common/filter_options.h"
#include "common/json_output.h"
#include "common/option_checks.h"
#include "common/output_folder.h"
#include "denoise/shader_pack.h"
#include "shaders/pack_json.h"
#include "shaders/pack_text.h"
#include "stillray/io.h"

namespace stillray {
namespace {

struct ShadersArguments {
  std::string folder;
  FilterArguments filter;
  std::string size = "1920x1080";
  std::string precision = "half";
  std::vector<std::string> inputs = {"direct_diffuse",
                                     "indirect_diffuse",
                                     "direct_specular",
                                     "indirect_specular",
                                     "depth",
                                     "normal",
                                     "id",
                                     "motion",
                                     "albedo",
                                     "specular_albedo",
                                     "emission"};
  std::vector<std::string> outputs = {"colour"};
  double samples_per_pixel = 1;
  double focal_pixels = 0;
  bool jittered = false;
  bool incomplete_guides = false;
  uint32_t shared_memory = 32768;
};

/// Maximum image size that Vulkan devices commonly support.
constexpr int kMostPixels = 16384;

Status ParseSize(const std::string& text, ScheduleOptions* options) {
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, options->width);
  if (width.ec == std::errc() && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, options->height);
    const auto fits = [](int side) { return side >= 1 && side <= kMostPixels; };
    if (height.ec == std::errc() && height.ptr == end && fits(options->width) &&
        fits(options->height)) {
      return Status::Ok();
    }
  }
  return Status::InvalidArgument(fmt::format(
      "--size is '{}', expected WIDTHxHEIGHT with 1 to {} pixels a side", text, kMostPixels));
}

/// Checks ranges by negated comparisons, so that NaN fails.
Status CheckNumbers(const ShadersArguments& a, const Settings& settings) {
  if (!(a.samples_per_pixel > 0 && a.samples_per_pixel <= 65536)) {
    return Status::InvalidArgument(
        fmt::format("--spp is {}, expected above 0, at most 65536", a.samples_per_pixel));
  }
  if (!(a.focal_pixels >= 0 && a.focal_pixels <= 1e6)) {
    return Status::InvalidArgument(
        fmt::format("--focal-pixels is {}, expected 0 to 1000000", a.focal_pixels));
  }
  if (settings.depth_weight == DepthWeight::kPosition && a.focal_pixels == 0) {
    return Status::InvalidArgument(
        "depth_weight=position needs --focal-pixels, the focal length of frames in pixels");
  }
  return Status::Ok();
}

Result<ScheduleOptions> ParseArguments(const ShadersArguments& a, const Settings& settings) {
  ScheduleOptions options;
  STILLRAY_RETURN_IF_ERROR(ParseSize(a.size, &options));
  STILLRAY_RETURN_IF_ERROR(CheckNumbers(a, settings));
  options.settings = settings;
  options.precision = a.precision == "float" ? DevicePrecision::kFloat : DevicePrecision::kHalf;
  options.inputs = a.inputs;
  options.outputs = a.outputs;
  options.samples_per_pixel = static_cast<float>(a.samples_per_pixel);
  options.focal_pixels = static_cast<float>(a.focal_pixels);
  options.jittered = a.jittered;
  options.incomplete_guides = a.incomplete_guides;
  options.shared_memory = a.shared_memory;
  return options;
}

class PackWriter {
 public:
  explicit PackWriter(std::filesystem::path folder) : folder_(std::move(folder)) {}

  Status Write(const std::string& name, const void* bytes, size_t size) {
    bytes_ += size;
    ++files_;
    return WriteFileAtomically((folder_ / name).string(), bytes, size);
  }
  Status Write(const std::string& name, const std::string& text) {
    return Write(name, text.data(), text.size());
  }
  size_t files() const { return files_; }
  size_t bytes() const { return bytes_; }

 private:
  std::filesystem::path folder_;
  size_t files_ = 0;
  size_t bytes_ = 0;
};

Status RunShaders(const ShadersArguments& a) {
  if (a.folder.empty()) {
    return Status::InvalidArgument("--output is empty, expected a folder");
  }
  const Result<FilterOptions> filter = ParseFilterArguments(a.filter);
  STILLRAY_RETURN_IF_ERROR(filter.status());
  const Result<ScheduleOptions> options = ParseArguments(a, filter->settings);
  STILLRAY_RETURN_IF_ERROR(options.status());
  const Result<ShaderTable> table = MakeShaderTable();
  STILLRAY_RETURN_IF_ERROR(table.status());
  const Result<FrameSchedule> schedule = MakeFrameSchedule(*options);
  STILLRAY_RETURN_IF_ERROR(schedule.status());
  STILLRAY_RETURN_IF_ERROR(MakeOutputFolder(a.folder));
  PackWriter writer(a.folder);
  for (const PackedShader& shader : table->shaders) {
    STILLRAY_RETURN_IF_ERROR(
        writer.Write(shader.name + ".spv", shader.code.data(), shader.code.size_bytes()));
  }
  STILLRAY_RETURN_IF_ERROR(writer.Write("shaders.json", JsonText(TableJson(*table))));
  STILLRAY_RETURN_IF_ERROR(writer.Write(
      "frames.json", JsonText(ScheduleJson(*schedule, *options, *table, filter->preset))));
  STILLRAY_RETURN_IF_ERROR(
      writer.Write("README.md", PackText(*table, *schedule, *options, filter->preset)));
  PrintTo(stderr, "{}: {} shaders, {} frames; {} files, {:.1f} MB\n", a.folder,
          table->shaders.size(), schedule->frames.size(), writer.files(),
          static_cast<double>(writer.bytes()) * 1e-6);
  return Status::Ok();
}

void AddFrameOptions(CLI::App* command, ShadersArguments* a) {
  command->add_option("--size", a->size, "Of frames: WIDTHxHEIGHT in pixels")
      ->capture_default_str();
  command
      ->add_option("--precision", a->precision,
                   "Of the filter's own images: half or float (docs/gpu.md)")
      ->check(OneOf({"half", "float"}))
      ->capture_default_str();
  command
      ->add_option("--inputs", a->inputs,
                   fmt::format("Images that frames have, a list of {}. Default: {}",
                               fmt::join(ScheduleInputNames(), ", "), fmt::join(a->inputs, ", ")))
      ->delimiter(',')
      ->take_all();
  command
      ->add_option("--outputs", a->outputs,
                   fmt::format("Images that the filter writes, a list of {}",
                               fmt::join(ScheduleOutputNames(), ", ")))
      ->delimiter(',')
      ->take_all()
      ->default_str(fmt::format("{}", fmt::join(a->outputs, ",")));
  command->add_option("--spp", a->samples_per_pixel, "Samples per pixel of frames")
      ->capture_default_str();
  command
      ->add_option("--focal-pixels", a->focal_pixels,
                   "Focal length in pixels, which depth_weight=position needs")
      ->capture_default_str();
  command->add_flag("--jitter", a->jittered,
                    "Rays of frames miss the centres of pixels: temporal antialiasing");
  command->add_flag("--incomplete-guides", a->incomplete_guides,
                    "Guides may be unknown in some pixels (fill_guides)");
  command
      ->add_option("--shared-memory", a->shared_memory,
                   "Bytes of shared memory of a workgroup on the device; 0: the wavelet uses none")
      ->check(InRange(0, 1048576))
      ->capture_default_str();
}

}  // namespace

void AddShadersCommand(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "shaders", "Write the filter's compute shaders, and how a frame runs them, for an engine");
  const auto a = std::make_shared<ShadersArguments>();
  command->add_option("-o,--output", a->folder, "Folder of the pack")->required();
  AddFilterOptions(command, &a->filter);
  AddFrameOptions(command, a.get());
  command->footer(
      "The folder receives the shaders as SPIR-V, their interfaces (shaders.json), the commands of "
      "frames (frames.json) and both as text (README.md): docs/gpu.md. No Vulkan device is "
      "needed.\n\n"
      "Examples:\n"
      "  stillray shaders -o pack\n"
      "  stillray shaders -o pack --preset svgf --size 2560x1440 --outputs colour_half\n"
      "  stillray shaders -o pack --jitter --outputs colour,display\n"
      "  stillray shaders -o pack --inputs indirect_diffuse,depth,normal,motion,albedo");
  command->callback([a, exit_code] {
    const Status status = RunShaders(*a);
    *exit_code = status.ok() ? kExitOk : ReportError(status);
  });
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/denoise_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "denoise/denoise_preview.h"
#include "denoise/future_blocks.h"
#include "io/frame_rate.h"
#include "io/memory_limit.h"

namespace stillray {
namespace {

/// What frame, histories and work planes take, measured and rounded up.
constexpr int64_t kBytesPerPixel = 700;
/// A channel is held once as read and once while it is written.
constexpr int64_t kBytesPerChannel = 2 * static_cast<int64_t>(sizeof(float));
/// --window both: the denoiser that plays backward and the frame in its hands, likewise.
constexpr int64_t kBytesPerPixelBackward = 700;
/// Seven planes for each of four signals.
constexpr int64_t kBytesPerPixelOfFuture = 7 * 4 * static_cast<int64_t>(sizeof(float));

/// --passes: two denoisers of parts, the parts and the new layers; measured and rounded up.
constexpr int64_t kBytesPerPixelOfPasses = 1100;

/// Where files are read and written beside the filter: the frame that is read, as a file, as its
/// channels and as planes; the bytes of the one that is written, old and new, and its channels.
constexpr int64_t kBytesPerChannelOverlapped = 6 * static_cast<int64_t>(sizeof(float));

int64_t BytesNeeded(const ExrExtent& extent, const DenoiseOptions& options) {
  int64_t per_pixel = kBytesPerPixel + extent.channels * kBytesPerChannel;
  if (options.window == Window::kBoth) {
    per_pixel += kBytesPerPixelBackward + kBytesPerPixelOfFuture;
  }
  if (options.text.passes) {
    per_pixel += kBytesPerPixelOfPasses;
  }
  return extent.pixels * per_pixel;
}

Status ParseSettings(const DenoiseArguments& arguments, DenoiseOptions* options) {
  Result<Settings> preset = PresetSettings(arguments.preset);
  if (!preset.ok()) {
    return Status::InvalidArgument("--preset: " + preset.status().message());
  }
  options->settings = std::move(preset.value());
  for (const std::string& assignment : arguments.set) {
    const size_t equals = assignment.find('=');
    if (equals == std::string::npos) {
      return Status::InvalidArgument(fmt::format("--set is '{}', expected name=value", assignment));
    }
    const std::string name = assignment.substr(0, equals);
    const Status set = SetParameter(&options->settings, name, assignment.substr(equals + 1));
    if (!set.ok()) {
      return Status::InvalidArgument("--set: " + set.message());
    }
    options->set_names.push_back(name);
  }
  STILLRAY_RETURN_IF_ERROR(SetDisplay(arguments.display, &options->settings));
  return ValidateSettings(options->settings);
}

Status CheckDisplayArguments(const DenoiseArguments& arguments) {
  const char* given = arguments.display.exposure  ? "--exposure"
                      : arguments.display.tonemap ? "--tonemap"
                      : arguments.fps_given       ? "--fps"
                                                  : nullptr;
  if (arguments.preview.empty() && given != nullptr) {
    return Status::InvalidArgument(
        fmt::format("{} is for display pictures, expected --preview with it", given));
  }
  if (!(arguments.fps >= kMinFps && arguments.fps <= kMaxFps)) {
    return Status::InvalidArgument(
        fmt::format("--fps is {}, expected {} to {}", arguments.fps, kMinFps, kMaxFps));
  }
  return Status::Ok();
}

/// "8G", "500M", bytes without a letter.
Status ParseMemory(const std::string& text, int64_t* bytes) {
  if (text.empty()) {
    *bytes = AvailableMemory();
    return Status::Ok();
  }
  double number = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string unit(stop, text.data() + text.size());
  const double factor = unit.empty()                 ? 1
                        : unit == "K" || unit == "k" ? 1e3
                        : unit == "M" || unit == "m" ? 1e6
                        : unit == "G" || unit == "g" ? 1e9
                                                     : 0;
  const double value = number * factor;
  if (error != std::errc() || !(value >= 1 && value <= 1e18)) {
    return Status::InvalidArgument(
        fmt::format("--memory-limit is '{}', expected a size such as 500M or 8G", text));
  }
  *bytes = static_cast<int64_t>(value);
  return Status::Ok();
}

}  // namespace

bool DenoiseOptions::IsSet(std::string_view parameter) const {
  return std::find(set_names.begin(), set_names.end(), parameter) != set_names.end();
}

Result<DenoiseOptions> ParseDenoiseArguments(const DenoiseArguments& arguments) {
  DenoiseOptions options;
  options.text = arguments;
  STILLRAY_RETURN_IF_ERROR(ParseSettings(arguments, &options));
  if (arguments.window != "auto" && arguments.window != "past" && arguments.window != "both") {
    return Status::InvalidArgument(
        fmt::format("--window is '{}', expected auto, past or both", arguments.window));
  }
  STILLRAY_RETURN_IF_ERROR(CheckDisplayArguments(arguments));
  STILLRAY_RETURN_IF_ERROR(ParseMemory(arguments.memory_limit, &options.memory_limit));
  Result<std::vector<SequenceFile>> files =
      ListSequence(arguments.inputs, arguments.output, arguments.frames);
  if (!files.ok()) {
    return files.status();
  }
  options.files = std::move(files.value());
  options.window_is_chosen = arguments.window == "auto";
  options.window = options.window_is_chosen     ? ChooseWindow(options.files, &options.window_note)
                   : arguments.window == "both" ? Window::kBoth
                                                : Window::kPast;
  STILLRAY_RETURN_IF_ERROR(CheckPreview(options));
  return options;
}

Window ChooseWindow(const std::vector<SequenceFile>& files, std::string* note) {
  if (files.size() < 2) {
    return Window::kPast;
  }
  const auto gap = std::adjacent_find(
      files.begin(), files.end(),
      [](const SequenceFile& a, const SequenceFile& b) { return b.frame != a.frame + 1; });
  if (gap == files.end()) {
    return Window::kBoth;
  }
  *note = fmt::format(
      "--window past, as frames are missing between {} and {}; --window both looks ahead up to "
      "every gap",
      gap->frame, (gap + 1)->frame);
  return Window::kPast;
}

std::string DenoiseFingerprint(const DenoiseOptions& options) {
  const DenoiseArguments& a = options.text;
  std::string text = fmt::format("denoise {}\noutput {}\nfirst {}\nrenderer {}\naov {}\n",
                                 fmt::join(a.inputs, " "), a.output, options.files.front().input,
                                 a.aovs.renderer, fmt::join(a.aovs.mappings, " "));
  text += fmt::format("view layer {}\n", a.aovs.view_layer);
  text += fmt::format("window {}\npasses {}\ndevice {}\n", WindowName(options.window), a.passes,
                      a.device);
  if (!a.preview.empty()) {
    text += fmt::format("preview {}\nfps {}\n", a.preview, a.fps);
  }
  if (options.window == Window::kBoth) {
    text += fmt::format("last frame (--frames) {}\n", options.files.back().input);
  }
  for (const Parameter& p : Parameters()) {
    text += fmt::format("{} {}\n", p.name, GetParameter(options.settings, p.name).value());
  }
  // What is set by name is kept where the files would choose another value.
  std::vector<std::string> set = options.set_names;
  std::sort(set.begin(), set.end());
  set.erase(std::unique(set.begin(), set.end()), set.end());
  text += fmt::format("set {}\n", fmt::join(set, " "));
  return text;
}

Status CheckMemory(const ExrExtent& extent, const DenoiseOptions& options,
                   const std::string& name) {
  if (options.memory_limit <= 0 || BytesNeeded(extent, options) <= options.memory_limit) {
    return Status::Ok();
  }
  return Status::OutOfMemory(
      fmt::format("{}: a frame of {} x {} pixels with {} channels takes about {:.1f} MB; {} {:.1f} "
                  "MB",
                  name, extent.width, extent.height, extent.channels,
                  static_cast<double>(BytesNeeded(extent, options)) / 1e6,
                  options.text.memory_limit.empty() ? "this machine has" : "--memory-limit is",
                  static_cast<double>(options.memory_limit) / 1e6));
}

Status OverlapFits(const ExrExtent& extent, const DenoiseOptions& options) {
  int64_t bytes =
      BytesNeeded(extent, options) + extent.pixels * extent.channels * kBytesPerChannelOverlapped;
  if (options.window == Window::kBoth) {
    bytes += (kFutureBlock - 1) * kBytesPerPixelOfFuture * extent.pixels;
  }
  if (options.memory_limit <= 0 || bytes <= options.memory_limit) {
    return Status::Ok();
  }
  return Status::OutOfMemory(
      fmt::format("that would take about {:.1f} MB; {} {:.1f} MB", static_cast<double>(bytes) / 1e6,
                  options.text.memory_limit.empty() ? "this machine has" : "--memory-limit is",
                  static_cast<double>(options.memory_limit) / 1e6));
}

Result<size_t> FuturesThatFit(const ExrExtent& extent, const DenoiseOptions& options,
                              const std::string& name) {
  STILLRAY_RETURN_IF_ERROR(CheckMemory(extent, options, name));
  if (options.memory_limit <= 0) {
    return kFutureBlock;
  }
  // One is part of what the frame itself needs.
  const int64_t left = options.memory_limit - BytesNeeded(extent, options);
  const int64_t each = kBytesPerPixelOfFuture * extent.pixels;
  return static_cast<size_t>(std::clamp<int64_t>(1 + left / each, 1, kFutureBlock));
}

}  // namespace stillray

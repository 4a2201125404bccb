// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/denoise_options.h"

#include <charconv>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "denoise/denoise_preview.h"
#include "io/memory_limit.h"
#include "render/lens.h"
#include "stillray/render.h"

namespace stillray {
namespace {

Status ParseSettings(const DenoiseArguments& arguments, DenoiseOptions* options) {
  Result<FilterOptions> filter = ParseFilterArguments(arguments.filter);
  STILLRAY_RETURN_IF_ERROR(filter.status());
  options->preset = filter->preset;
  options->sequence.settings = filter->settings;
  options->sequence.fixed_parameters = std::move(filter->set_names);
  return SetDisplay(arguments.display, &options->sequence.settings);
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
  return Status::Ok();
}

Status CheckLensArguments(const DenoiseArguments& arguments, const PostEffects& post) {
  const char* given = !arguments.aperture.empty() ? "--aperture"
                      : !arguments.focus.empty()  ? "--focus"
                      : arguments.fov             ? "--fov"
                                                  : nullptr;
  if (!post.depth_of_field && given != nullptr) {
    return Status::InvalidArgument(
        fmt::format("{} is for depth of field, expected --post dof with it", given));
  }
  return Status::Ok();
}

/// Parses the lens, with the option syntax of `stillray render`.
Status ParseLens(const DenoiseArguments& arguments, Lens* lens) {
  RenderSettings settings;
  for (const auto& [name, value] :
       {std::pair("aperture", arguments.aperture), std::pair("focus", arguments.focus)}) {
    const Status set = value.empty() ? Status::Ok() : SetRenderParameter(&settings, name, value);
    if (!set.ok()) {
      return Status::InvalidArgument("--" + set.message());
    }
  }
  *lens = render::LensOf(Scene(), settings, 0);
  if (!(lens->radius > 0.0f || lens->f_number > 0.0f)) {
    return Status::InvalidArgument("--post dof needs a lens, expected --aperture RADIUS or f/N");
  }
  return Status::Ok();
}

Status ParsePost(const DenoiseArguments& arguments, DenoiseOptions* options) {
  const Result<PostEffects> post = ParsePostArguments(arguments.post);
  STILLRAY_RETURN_IF_ERROR(post.status());
  options->post = *post;
  STILLRAY_RETURN_IF_ERROR(CheckLensArguments(arguments, *post));
  if (post->any() && arguments.passes) {
    return Status::InvalidArgument(
        "--passes and --post exclude each other: the layers would not add up to the blurred "
        "picture");
  }
  return post->depth_of_field ? ParseLens(arguments, &options->lens) : Status::Ok();
}

/// All options except SequenceOptions that affect the images, for --resume.
std::string Fingerprint(const DenoiseArguments& a) {
  std::string text = fmt::format("denoise {}\noutput {}\ndevice {}\n", fmt::join(a.inputs, " "),
                                 a.output, a.device);
  for (const std::string& effects : a.post.effects) {
    text += fmt::format("post {}\n", effects);
  }
  if (!a.post.effects.empty()) {
    text += fmt::format("shutter {}\naperture {}\nfocus {}\nfov {}\n", a.post.shutter.value_or(-1),
                        a.aperture, a.focus, a.fov.value_or(-1));
  }
  if (!a.preview.empty()) {
    text += fmt::format("preview {}\nfps {}\n", a.preview, a.fps);
  }
  return text;
}

/// Parses "8G", "500M", or bytes without a suffix.
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

Result<DenoiseOptions> ParseDenoiseArguments(const DenoiseArguments& arguments) {
  DenoiseOptions options;
  options.text = arguments;
  SequenceOptions& sequence = options.sequence;
  STILLRAY_RETURN_IF_ERROR(ParseSettings(arguments, &options));
  STILLRAY_RETURN_IF_ERROR(CheckDisplayArguments(arguments));
  STILLRAY_RETURN_IF_ERROR(ParsePost(arguments, &options));
  STILLRAY_RETURN_IF_ERROR(ParseMemory(arguments.memory_limit, &sequence.memory.bytes));
  Result<std::vector<SequenceFile>> files =
      ListSequence(arguments.inputs, arguments.output, arguments.frames);
  if (!files.ok()) {
    return files.status();
  }
  sequence.files = std::move(files.value());
  sequence.aovs = arguments.aovs;
  sequence.spp = arguments.spp;
  sequence.passes = arguments.passes;
  sequence.denoise_alpha = arguments.alpha == "denoise";
  sequence.motion = MotionSourceOf(arguments.motion).value_or(MotionSource::kAuto);
  sequence.cameras = arguments.cameras;
  sequence.memory.name = arguments.memory_limit.empty() ? "this machine has" : "--memory-limit is";
  sequence.state = {true, arguments.resume, Fingerprint(arguments)};
  sequence.window_may_narrow = arguments.window == "auto";
  sequence.window = sequence.window_may_narrow ? ChooseWindow(sequence.files, &options.window_note)
                    : arguments.window == "both" ? Window::kBoth
                                                 : Window::kPast;
  STILLRAY_RETURN_IF_ERROR(CheckPreview(options));
  return options;
}

}  // namespace stillray

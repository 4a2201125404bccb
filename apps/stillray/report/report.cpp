// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/report.h"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include <fmt/core.h>
#include <CLI/CLI.hpp>

#include "common/commands.h"
#include "common/console.h"
#include "common/display_options.h"
#include "io/frame_rate.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

struct ReportArguments {
  std::string folder;
  ReportSequences sequences;
  DisplayArguments display;
  std::string output;
  double max_megabytes = 40;
  ReportOptions options;
};

/// Tone maps radiance to display images like the renderer.
Result<Rgb8Image> Develop(const Image3& radiance, const std::string& tonemap, double exposure) {
  Settings settings;
  if (!tonemap.empty()) {
    const Status known = SetParameter(&settings, "tonemap", tonemap);
    if (!known.ok()) {
      return Status::BadData("render.json: tonemap: " + known.message());
    }
  }
  return Rgb8Image{radiance.width(), radiance.height(),
                   ToDisplay(radiance, static_cast<float>(exposure), settings.tonemap)};
}

/// Shows the frame count on a terminal, on one line that is overwritten.
bool ShowProgress(int done, int total) {
  std::fprintf(stderr, "\rframe %d of %d%s", done, total, done == total ? "\n" : "");
  std::fflush(stderr);
  return true;
}

constexpr double kMinMegabytes = 0.01;
constexpr double kMaxMegabytes = 2000;

/// Requires either a folder, or at least the denoised sequence and its input.
Status CheckSource(const ReportArguments& a) {
  const ReportSequences& s = a.sequences;
  const bool any = !s.noisy.empty() || !s.clean.empty() || !s.reference.empty();
  if (a.folder.empty() == !any) {
    return Status::InvalidArgument(
        "report takes the folder of a stillray render, or --noisy and --clean");
  }
  if (any && (s.noisy.empty() || s.clean.empty())) {
    return Status::InvalidArgument(
        fmt::format("report without a folder needs --noisy and --clean; "
                    "{} is missing",
                    s.noisy.empty() ? "--noisy" : "--clean"));
  }
  if (!any && (a.display.exposure || a.display.tonemap)) {
    return Status::InvalidArgument(
        "--exposure and --tonemap go with --clean; a folder has them in its render.json");
  }
  // Negated comparison, so that NaN fails.
  if (!(a.max_megabytes >= kMinMegabytes && a.max_megabytes <= kMaxMegabytes)) {
    return Status::InvalidArgument(fmt::format("--max-size is {}, expected {} to {} MB",
                                               a.max_megabytes, kMinMegabytes, kMaxMegabytes));
  }
  if (!(s.fps >= kMinFps && s.fps <= kMaxFps)) {
    return Status::InvalidArgument(
        fmt::format("--fps is {}, expected {} to {}", s.fps, kMinFps, kMaxFps));
  }
  return Status::Ok();
}

/// Sets exposure and tone curve, with the defaults of `stillray render`.
Status SetSequenceDisplay(const ReportArguments& arguments, ReportSequences* sequences) {
  Result<Settings> settings = PresetSettings("default");
  STILLRAY_RETURN_IF_ERROR(settings.status());
  STILLRAY_RETURN_IF_ERROR(SetDisplay(arguments.display, &settings.value()));
  const Result<std::string> curve = GetParameter(*settings, "tonemap");
  STILLRAY_RETURN_IF_ERROR(curve.status());
  sequences->exposure = double{settings->exposure};
  sequences->tonemap = *curve;
  return Status::Ok();
}

/// The default path of the page, in the folder of the images.
std::string DefaultOutput(const ReportArguments& arguments) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path clean(arguments.sequences.clean);
  const fs::path folder = !arguments.folder.empty()        ? fs::path(arguments.folder)
                          : fs::is_directory(clean, error) ? clean
                                                           : clean.parent_path();
  return (folder / "report.html").string();
}

Status Run(const ReportArguments& arguments) {
  STILLRAY_RETURN_IF_ERROR(CheckSource(arguments));
  ReportOptions options = arguments.options;
  options.max_page_bytes = static_cast<int64_t>(arguments.max_megabytes * 1e6);
  options.develop = Develop;
  if (isatty(STDERR_FILENO) != 0) {
    options.progress = ShowProgress;
  }
  const std::string path = !arguments.output.empty() ? arguments.output : DefaultOutput(arguments);
  ReportSummary summary;
  if (arguments.folder.empty()) {
    ReportSequences sequences = arguments.sequences;
    STILLRAY_RETURN_IF_ERROR(SetSequenceDisplay(arguments, &sequences));
    STILLRAY_RETURN_IF_ERROR(WriteReport(sequences, path, options, &summary));
  } else {
    STILLRAY_RETURN_IF_ERROR(WriteReport(arguments.folder, path, options, &summary));
  }
  for (const std::string& note : summary.notes) {
    PrintTo(stdout, "{}\n", note);
  }
  PrintTo(stdout, "{}: {} of {} frames, {:.1f} MB\n", path, summary.frames_shown,
          summary.frames_found, static_cast<double>(summary.page_bytes) / 1e6);
  return Status::Ok();
}

}  // namespace

void AddReportCommand(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "report", "Write one HTML page that compares the pictures of a rendered sequence");
  command->footer(R"(
Examples:
  stillray report out
  stillray report out -o comparison.html --max-frames 30 --max-size 100
  stillray report --noisy 'shot.####.exr' --clean clean --reference 'ref/####.exr' -o report.html
)");
  const auto arguments = std::make_shared<ReportArguments>();
  command->add_option("folder", arguments->folder, "A folder of stillray render");
  ReportSequences& sequences = arguments->sequences;
  command->add_option("--noisy", sequences.noisy,
                      "In place of a folder: the noisy pictures of any renderer, EXR or PNG, as a "
                      "pattern or a folder");
  command->add_option("--clean", sequences.clean, "The same frames, denoised by any denoiser");
  command->add_option("--reference", sequences.reference, "The same frames, converged");
  AddDisplayOptions(command, &arguments->display);
  command->add_option("--fps", sequences.fps, "Speed of playing, with --clean")
      ->capture_default_str();
  command->add_option("-o,--output", arguments->output,
                      "The page; default: report.html beside the pictures");
  command
      ->add_option("--max-frames", arguments->options.max_frames,
                   "Embed the pictures of at most this many frames, evenly spread")
      ->capture_default_str();
  command
      ->add_option("--max-size", arguments->max_megabytes,
                   "Embed fewer frames where the page would grow past this many MB")
      ->capture_default_str();
  command
      ->add_option("--zoom-width", arguments->options.zoom_width,
                   "Open the page zoomed in: this many picture pixels across; 0: whole picture")
      ->capture_default_str();
  command->callback([arguments, exit_code] {
    const Status status = Run(*arguments);
    *exit_code = status.ok() ? kExitOk : ReportError(status);
  });
}

}  // namespace stillray

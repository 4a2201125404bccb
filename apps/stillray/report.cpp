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

#include "commands.h"
#include "console.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

struct ReportArguments {
  std::string folder;
  std::string output;
  double max_megabytes = 40;
  ReportOptions options;
};

/// Makes display pictures as the renderer would have.
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

/// Counts frames on a terminal, one line that is written over.
bool ShowProgress(int done, int total) {
  std::fprintf(stderr, "\rframe %d of %d%s", done, total, done == total ? "\n" : "");
  std::fflush(stderr);
  return true;
}

Status Run(const ReportArguments& arguments) {
  ReportOptions options = arguments.options;
  options.max_page_bytes = static_cast<int64_t>(arguments.max_megabytes * 1e6);
  options.develop = Develop;
  if (isatty(STDERR_FILENO) != 0) {
    options.progress = ShowProgress;
  }
  const std::string path = !arguments.output.empty()
                               ? arguments.output
                               : (std::filesystem::path(arguments.folder) / "report.html").string();
  ReportSummary summary;
  STILLRAY_RETURN_IF_ERROR(WriteReport(arguments.folder, path, options, &summary));
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
)");
  const auto arguments = std::make_shared<ReportArguments>();
  command->add_option("folder", arguments->folder, "What stillray render wrote")->required();
  command->add_option("-o,--output", arguments->output,
                      "The page; default: report.html in the folder");
  command
      ->add_option("--max-frames", arguments->options.max_frames,
                   "Embed the pictures of at most this many frames, evenly spread")
      ->capture_default_str();
  command
      ->add_option("--max-size", arguments->max_megabytes,
                   "Embed fewer frames where the page would grow past this many MB")
      ->check(CLI::Range(0.01, 2000.0))
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

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/report.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/core.h>

#include "io/text.h"
#include "quality/render_log.h"
#include "quality/report_files.h"
#include "quality/report_measure.h"
#include "quality/report_page.h"

namespace stillray {
namespace {

using report::FrameFiles;
using report::kReference;
using report::kViewCount;
using report::kViewNames;
using report::Measurements;
using report::PageContent;
using report::SequenceFiles;

constexpr int kMaxFrames = 1000;
constexpr int kMaxZoomWidth = 32768;
/// A long sequence takes about 500 bytes a frame.
constexpr size_t kMaxLogBytes = size_t{16} << 20;

Status CheckOptions(const ReportOptions& options) {
  if (options.max_frames < 1 || options.max_frames > kMaxFrames) {
    return Status::InvalidArgument(
        fmt::format("number of frames: found {}, expected 1..{}", options.max_frames, kMaxFrames));
  }
  if (options.max_page_bytes < 1) {
    return Status::InvalidArgument(fmt::format(
        "size of the page: found {} bytes, expected 1 or more", options.max_page_bytes));
  }
  if (options.zoom_width < 0 || options.zoom_width > kMaxZoomWidth) {
    return Status::InvalidArgument(
        fmt::format("zoom width: found {}, expected 0..{}", options.zoom_width, kMaxZoomWidth));
  }
  return Status::Ok();
}

/// Reads render.json if present.
Status ReadLog(const std::string& folder, PageContent* content) {
  const std::string path = (std::filesystem::path(folder) / "render.json").string();
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return Status::Ok();
  }
  const Result<std::string> text = ReadWholeFile(path, kMaxLogBytes);
  if (!text.ok()) {
    return text.status();
  }
  Result<report::RenderLog> log = report::ParseRenderLog(*text, path);
  if (!log.ok()) {
    return log.status();
  }
  content->log = std::move(*log);
  content->has_log = true;
  return Status::Ok();
}

/// "a, b and 7 more": a few frame numbers.
std::string ListFrames(const std::vector<int64_t>& frames) {
  constexpr size_t kListed = 5;
  std::vector<std::string> names;
  for (size_t i = 0; i < frames.size() && i < kListed; ++i) {
    names.push_back(std::to_string(frames[i]));
  }
  if (frames.size() > kListed) {
    names.push_back(fmt::format("{} more", frames.size() - kListed));
  }
  return report::JoinNames(names);
}

void NoteViews(const SequenceFiles& files, bool of_folder, std::vector<std::string>* notes) {
  std::vector<std::string> absent;
  for (size_t view = 0; view < kViewCount; ++view) {
    std::vector<int64_t> gaps;
    for (const auto& [number, frame] : files) {
      if (frame[view].empty()) {
        gaps.push_back(number);
      }
    }
    if (gaps.size() == files.size()) {
      absent.push_back(kViewNames[view]);
    } else if (!gaps.empty()) {
      notes->push_back(fmt::format("There are no {} pictures of {} {}.", kViewNames[view],
                                   gaps.size() == 1 ? "frame" : "frames", ListFrames(gaps)));
    }
  }
  if (!absent.empty() && of_folder) {
    notes->push_back(fmt::format("The folder holds no {} pictures.", report::JoinNames(absent)));
  }
}

void NoteQuality(const Measurements& measurements, std::vector<std::string>* notes) {
  if (measurements.measured.empty()) {
    notes->emplace_back(
        "Quality is not measured: no frame has a reference picture beside another one of the same "
        "format.");
    return;
  }
  std::array<bool, report::kSourceCount> has_source = {};
  for (const report::MeasuredFrame& frame : measurements.measured) {
    for (size_t source = 0; source < report::kSourceCount; ++source) {
      for (const auto& metrics : frame.metrics[source]) {
        has_source[source] = has_source[source] || metrics.has_value();
      }
    }
  }
  if (has_source[report::kLinear] && has_source[report::kDisplay]) {
    notes->emplace_back(
        "Quality is measured on the linear radiance of EXR files where a view and the reference "
        "have them, and on the display values of PNG files for every view: numbers of the two "
        "are not comparable.");
  } else {
    notes->emplace_back(
        has_source[report::kLinear]
            ? "Quality is measured on the linear radiance of EXR files."
            : "Quality is measured on the display values of PNG files, since there are "
              "no EXR files of both the reference and a view.");
  }
  if (measurements.without_motion) {
    notes->emplace_back(
        "Temporal error: pictures without layers motion.X and motion.Y count as if nothing moved.");
  }
}

void NoteDeveloped(const Measurements& measurements, const ReportOptions& options,
                   const report::RenderLog& log, std::vector<std::string>* notes) {
  std::vector<std::string> made;
  for (size_t view = 0; view < kViewCount; ++view) {
    for (const report::ShownFrame& frame : measurements.shown) {
      if (frame.views[view].made_from_exr) {
        made.push_back(kViewNames[view]);
        break;
      }
    }
  }
  if (made.empty()) {
    return;
  }
  const bool curve = options.develop && !log.tonemap.empty();
  notes->push_back(fmt::format(
      "{} pictures have no PNG files; they were made from the EXR files with exposure {:+g} stops "
      "and {}.",
      report::JoinNames(made), log.exposure,
      curve ? "the tone curve " + log.tonemap : std::string("no tone curve, clipped at white")));
}

std::vector<std::string> MakeNotes(const SequenceFiles& files, const PageContent& content,
                                   const ReportOptions& options) {
  std::vector<std::string> notes;
  const size_t shown = content.measurements.shown.size();
  if (shown < files.size()) {
    notes.push_back(fmt::format("Pictures of {} of {} frames are embedded, evenly spread, {}.",
                                shown, files.size(),
                                content.measurements.thinned_for_size
                                    ? fmt::format("to keep this page below {:.3g} MB",
                                                  static_cast<double>(options.max_page_bytes) / 1e6)
                                    : std::string("to keep this page small")));
  }
  NoteViews(files, content.of_folder, &notes);
  NoteQuality(content.measurements, &notes);
  NoteDeveloped(content.measurements, options, content.log, &notes);
  if (!content.has_log && content.of_folder) {
    notes.emplace_back("There is no render.json: scene, settings, times and memory are not known.");
  } else if (content.has_log && content.log.frames.empty()) {
    notes.emplace_back("render.json lists no frames: times are not known.");
  }
  return notes;
}

/// The last component of a path, also of "shots/a/" and ".".
std::string LastComponent(const std::string& folder) {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::canonical(folder, error);
  return error || path.filename().empty() ? folder : path.filename().string();
}

/// \param content  complete except for images and notes
Result<std::string> Build(const SequenceFiles& files, PageContent content,
                          const ReportOptions& options, ReportSummary* summary) {
  content.frames_found = static_cast<int>(files.size());
  content.zoom_width = options.zoom_width;
  Result<Measurements> measurements = report::Measure(files, content.log, options);
  if (!measurements.ok()) {
    return measurements.status();
  }
  content.measurements = std::move(*measurements);
  content.notes = MakeNotes(files, content, options);
  std::string page = report::MakePage(content);
  if (summary != nullptr) {
    summary->frames_found = content.frames_found;
    summary->frames_shown = static_cast<int>(content.measurements.shown.size());
    summary->page_bytes = page.size();
    summary->notes = content.notes;
  }
  return page;
}

/// "clean/shot.####.exr": both sequences may have the same name in two folders.
std::string SequenceName(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::is_directory(name, error)) {
    return LastComponent(name);
  }
  const fs::path path(name);
  return (path.parent_path().filename() / path.filename()).string();
}

Result<std::string> BuildOfFolder(const std::string& folder, const ReportOptions& options,
                                  ReportSummary* summary) {
  STILLRAY_RETURN_IF_ERROR(CheckOptions(options));
  const Result<SequenceFiles> files = report::FindSequence(folder);
  if (!files.ok()) {
    return files.status();
  }
  PageContent content;
  content.name = LastComponent(folder);
  content.source = "the folder " + content.name;
  content.of_folder = true;
  STILLRAY_RETURN_IF_ERROR(ReadLog(folder, &content));
  return Build(*files, std::move(content), options, summary);
}

Result<std::string> BuildOfSequences(const ReportSequences& sequences, const ReportOptions& options,
                                     ReportSummary* summary) {
  STILLRAY_RETURN_IF_ERROR(CheckOptions(options));
  const Result<SequenceFiles> files =
      report::FindViews(sequences.noisy, sequences.clean, sequences.reference);
  if (!files.ok()) {
    return files.status();
  }
  PageContent content;
  content.name = SequenceName(sequences.clean);
  content.source = fmt::format("{} and {}", SequenceName(sequences.noisy), content.name);
  if (!sequences.reference.empty()) {
    content.source += ", with the reference " + SequenceName(sequences.reference);
  }
  content.log.exposure = sequences.exposure;
  content.log.tonemap = sequences.tonemap;
  content.log.fps = sequences.fps;
  return Build(*files, std::move(content), options, summary);
}

/// Names of folders and files may contain any character.
Result<std::string> OneLineError(Result<std::string> page) {
  return page.ok() ? std::move(page)
                   : Status(page.status().code(), io::OneLine(page.status().message()));
}

Status WritePage(const Result<std::string>& page, const std::string& path) {
  return page.ok() ? WriteFileAtomically(path, page->data(), page->size()) : page.status();
}

}  // namespace

Result<std::string> BuildReport(const std::string& folder, const ReportOptions& options,
                                ReportSummary* summary) {
  return OneLineError(BuildOfFolder(folder, options, summary));
}

Result<std::string> BuildReport(const ReportSequences& sequences, const ReportOptions& options,
                                ReportSummary* summary) {
  return OneLineError(BuildOfSequences(sequences, options, summary));
}

Status WriteReport(const std::string& folder, const std::string& path, const ReportOptions& options,
                   ReportSummary* summary) {
  return WritePage(BuildReport(folder, options, summary), path);
}

Status WriteReport(const ReportSequences& sequences, const std::string& path,
                   const ReportOptions& options, ReportSummary* summary) {
  return WritePage(BuildReport(sequences, options, summary), path);
}

}  // namespace stillray

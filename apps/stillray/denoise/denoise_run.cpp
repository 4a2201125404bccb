// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/denoise_run.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "common/console.h"
#include "common/device_option.h"
#include "common/interrupt.h"
#include "common/json_output.h"
#include "common/output_folder.h"
#include "common/progress.h"
#include "common/run_summary.h"
#include "denoise/denoise_check.h"
#include "denoise/denoise_log.h"
#include "denoise/denoise_preview.h"
#include "io/atomic_file.h"
#include "io/text.h"
#include "stillray/sequence.h"

namespace stillray {
namespace {

/// Runs a SequenceDenoiser with messages, preview and log.
class DenoiseRun {
 public:
  DenoiseRun(const DenoiseOptions& options, int threads)
      : options_(options),
        threads_(threads),
        folder_(
            std::filesystem::path(options.sequence.files.front().output).parent_path().string()) {
    options_.sequence.overlap = threads > 1;
  }

  Status Run();

 private:
  size_t FileCount() const { return options_.sequence.files.size(); }
  SequenceHooks Hooks();
  Status ApplyEffects(const Frame& frame, double focal_pixels, Image3* colour) const;
  Status Prepare();
  void PrintStart() const;
  Status CheckInputs();
  void PrintFindings() const;
  void PrintFrame(const FrameReport& report);
  Status Stop(const SequenceEnd& end) const;
  std::string Json(std::span<const FrameReport> frames) const;
  Status WriteJson() const;
  void PrintWarnings(const DenoiseLog& log) const;
  void Summarise() const;
  DenoiseLog Log(std::span<const FrameReport> frames) const;

  DenoiseOptions options_;
  int threads_;
  std::string folder_;
  OutputFolderMark folder_mark_;
  std::optional<Preview> preview_;
  std::optional<SequenceDenoiser> sequence_;
  std::optional<Progress> progress_;
  std::vector<Finding> findings_;
  std::string warning_;    ///< the denoiser's first warning
  double done_ = 0;        ///< number of frames that are denoised or accumulated backwards
  size_t resumed_at_ = 0;  ///< number of files finished by an earlier run
  double seconds_ = 0;     ///< time for this run's frames
  int64_t written_bytes_ = 0;
};

SequenceHooks DenoiseRun::Hooks() {
  SequenceHooks hooks;
  hooks.keep_going = [] { return !Interrupted(); };
  hooks.note = [this](const std::string& text) {
    if (progress_) {
      progress_->Clear();
    }
    PrintTo(stderr, "note: {}\n", text);
  };
  hooks.fell_back = [](const std::string& reason) {
    PrintTo(stderr, "denoising on the CPU after all: {}\n", reason);
  };
  hooks.looks_ahead = [this](const SequenceFile& file) {
    done_ += 1;
    progress_->Update(done_, fmt::format("looking ahead: frame {}", file.frame));
  };
  hooks.finished = [this](const FrameReport& report) { PrintFrame(report); };
  hooks.picture = [this](const SequenceFile& file, const Image3& colour) {
    return preview_ ? preview_->Write(file, colour) : Status::Ok();
  };
  if (options_.post.any()) {
    hooks.effects = [this](const SequenceFile&, const Frame& frame, double focal_pixels,
                           Image3* colour) { return ApplyEffects(frame, focal_pixels, colour); };
  }
  hooks.save_log = [this](std::span<const FrameReport> frames) { return Json(frames); };
  hooks.restore_log = [this](const std::string& text) -> Result<std::vector<FrameReport>> {
    Result<DenoiseLog> log = ParseDenoiseLog(text);
    STILLRAY_RETURN_IF_ERROR(log.status());
    findings_ = std::move(log->findings);
    return std::move(log->frames);
  };
  return hooks;
}

/// Applies the effects; --fov takes precedence over the cameras of the files.
Status DenoiseRun::ApplyEffects(const Frame& frame, double focal_pixels, Image3* colour) const {
  post::ThinLens lens;
  if (options_.post.depth_of_field) {
    const std::optional<double>& fov = options_.text.fov;
    if (!fov && !(focal_pixels > 0)) {
      return Status::InvalidArgument(
          "--post dof needs the angle of view, and the frame has no camera with perspective: "
          "expected --fov DEGREES, or --cameras");
    }
    const double yfov =
        fov ? *fov * std::numbers::pi / 180 : 2 * std::atan(frame.height / (2 * focal_pixels));
    lens = ThinLensOf(options_.lens, static_cast<float>(yfov), frame.width, frame.height);
  }
  return ApplyPostEffects(options_.post, lens, frame.guides, colour);
}

/// Examines the inputs; a resumed run has already logged and printed its findings.
Status DenoiseRun::CheckInputs() {
  if (!options_.text.no_check && !sequence_->resumed()) {
    Result<std::vector<Finding>> findings = CheckFirstFrames(options_, sequence_->derives_motion());
    if (findings.status().code() == StatusCode::kCancelled) {
      return Status(StatusCode::kCancelled,
                    fmt::format("stopped; 0 of {} frames are finished", FileCount()));
    }
    STILLRAY_RETURN_IF_ERROR(findings.status());
    findings_ = std::move(findings.value());
  }
  PrintFindings();
  return Status::Ok();
}

void DenoiseRun::PrintFindings() const {
  AovLayout shown = sequence_->layout();
  shown.notes = NotesBeside(findings_, sequence_->layout());
  WriteText(options_.text.json_path == "-" ? stderr : stdout, AovTable(shown));
  std::fflush(stdout);
  if (!sequence_->resumed()) {
    for (const Finding& finding : findings_) {
      PrintTo(stderr, "check: {}\n", io::OneLine(FindingLine(finding)));
    }
  }
}

/// Prints the first frame, and the reason for the window.
void DenoiseRun::PrintStart() const {
  if (!sequence_->resumed()) {
    if (!options_.window_note.empty() && sequence_->settings().temporal) {
      PrintTo(stderr, "note: {}\n", options_.window_note);
    }
  } else if (resumed_at_ < FileCount()) {
    PrintTo(stderr, "resuming with frame {}\n", options_.sequence.files[resumed_at_].frame);
  }
}

Status DenoiseRun::Prepare() {
  const SequenceDenoiser::OpenDevice open = [this] {
    return OpenDeviceOption(options_.text.device, options_.text.verbose, "denoising");
  };
  Result<SequenceDenoiser> sequence = SequenceDenoiser::Create(options_.sequence, open, Hooks());
  STILLRAY_RETURN_IF_ERROR(sequence.status());
  sequence_.emplace(std::move(sequence.value()));
  resumed_at_ = sequence_->finished();
  STILLRAY_RETURN_IF_ERROR(MakeOutputFolder(folder_));
  MarkOutputFolder(folder_, &folder_mark_);
  STILLRAY_RETURN_IF_ERROR(CheckJsonOutput(options_.text.json_path));
  io::RemoveStaleTemporaries(folder_);
  PrintStart();
  STILLRAY_RETURN_IF_ERROR(CheckInputs());
  if (options_.text.preview.empty()) {
    return Status::Ok();
  }
  preview_.emplace(options_, sequence_->settings());
  return preview_->Open(sequence_->extent(), sequence_->layout(), resumed_at_);
}

void DenoiseRun::PrintFrame(const FrameReport& report) {
  done_ += 1;
  seconds_ += report.elapsed_ms / 1000;
  written_bytes_ += report.written_bytes;
  if (warning_.empty() && !report.warning.empty()) {
    warning_ = fmt::format("frame {}: {}", report.frame, report.warning);
  }
  const std::string future = sequence_->options().window == Window::kBoth
                                 ? fmt::format("look ahead {:.0f} ms, ", report.future_ms)
                                 : "";
  progress_->Step(done_, fmt::format("frame {} ({} of {}): read {:.0f} ms, {}denoise {:.0f} ms, "
                                     "write {:.0f} ms{}",
                                     report.frame, sequence_->finished(), FileCount(),
                                     report.read_ms, future, report.denoise_ms, report.write_ms,
                                     report.restarted ? ", history restarted" : ""));
}

Status DenoiseRun::Stop(const SequenceEnd& end) const {
  StoppedRun run{end.status, end.save_status, sequence_->finished(), FileCount(), ""};
  if (end.can_resume) {
    run.resumes_from = fmt::format("frame {}", options_.sequence.files[end.resumes_at].frame);
  }
  return StopError(run);
}

DenoiseLog DenoiseRun::Log(std::span<const FrameReport> frames) const {
  return {findings_,
          {frames.begin(), frames.end()},
          sequence_->memory_bytes(),
          sequence_->device_memory()};
}

std::string DenoiseRun::Json(std::span<const FrameReport> frames) const {
  return DenoiseLogJson(options_, sequence_->layout(), sequence_->settings(),
                        sequence_->options().window, Log(frames), threads_);
}

Status DenoiseRun::WriteJson() const {
  if (options_.text.json_path.empty()) {
    return Status::Ok();
  }
  return WriteJsonOutput(options_.text.json_path, Json(sequence_->reports()));
}

void DenoiseRun::PrintWarnings(const DenoiseLog& log) const {
  int64_t bad_guides = 0;
  for (const FrameReport& frame : log.frames) {
    bad_guides += frame.bad_guides;
  }
  WriteText(stderr, MissingLightWarning(log));
  WriteText(stderr, MissingImagesWarning(log));
  if (!warning_.empty()) {
    PrintTo(stderr, "warning: {}\n", warning_);
  }
  if (bad_guides > 0) {
    PrintTo(stderr, "warning: {} pixels had no usable guides and were not filtered\n", bad_guides);
  }
  if (sequence_->layout().Find(Aov::kMotion) != nullptr &&
      sequence_->layout().renderer != "stillray" && !sequence_->derives_motion() &&
      !sequence_->motion_was_seen() && log.frames.size() > 1 &&
      !HasFinding(log.findings, "motion_zero")) {
    PrintTo(stderr,
            "warning: motion is zero in every frame; that is right for a still camera and scene "
            "only (Blender writes zeros where motion blur is on): --motion auto derives it\n");
  }
}

void DenoiseRun::Summarise() const {
  const DenoiseLog log = Log(sequence_->reports());
  PrintWarnings(log);
  std::FILE* out = options_.text.json_path == "-" ? stderr : stdout;
  if (options_.text.timings) {
    WriteText(out, DenoiseTimings(log));
  }
  PrintTo(out, "{}\n",
          RunSummaryText({sequence_->finished() - resumed_at_, resumed_at_, folder_, written_bytes_,
                          seconds_}));
  if (preview_) {
    PrintTo(out, "{}\n", preview_->Summary());
  }
}

Status DenoiseRun::Run() {
  STILLRAY_RETURN_IF_ERROR(Prepare());
  done_ = static_cast<double>(resumed_at_);
  progress_.emplace(static_cast<double>(FileCount() + sequence_->look_ahead_steps()), stderr);
  const SequenceEnd end = sequence_->Run();
  progress_.reset();
  if (!end.status.ok()) {
    return Stop(end);
  }
  if (preview_) {
    STILLRAY_RETURN_IF_ERROR(preview_->Finish());
  }
  STILLRAY_RETURN_IF_ERROR(WriteJson());
  sequence_->RemoveState();
  Summarise();
  return Status::Ok();
}

}  // namespace

Status RunDenoise(const DenoiseOptions& options, int threads) {
  return DenoiseRun(options, threads).Run();
}

}  // namespace stillray

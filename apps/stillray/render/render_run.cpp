// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/render_run.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
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
#include "io/atomic_file.h"
#include "render/frame_maker.h"
#include "render/output_size.h"
#include "render/render_files.h"
#include "render/render_options.h"
#include "render/run_log.h"
#include "sequence/finished_files.h"
#include "sequence/frame_loop.h"
#include "sequence/resume_state.h"
#include "stillray/quality.h"
#include "stillray/scene.h"

namespace stillray {
namespace {

/// The state of one run over all frames.
class RenderRun {
 public:
  RenderRun(const RenderOptions& options, const Scene& scene, int threads)
      : options_(options),
        scene_(scene),
        threads_(threads),
        fingerprint_(RenderFingerprint(options, scene)),
        key_(fmt::format("render frames from {}", options.frames.first)),
        next_frame_(options.frames.first),
        overlaps_(threads > 1 && FramesFit(options.render, 2)),
        maker_(options, scene) {}

  Status Run();

  // Callbacks of FrameLoop. Frame indices start at the first of --frames.
  using Picture = RenderPicture;
  Status Make(size_t at, Picture* picture);
  Status Write(Picture* picture);
  Status Finish(Picture* picture, const WriteResult& written);
  bool CanSave() const;
  Status Save(std::span<Picture* const> unwritten);

 private:
  Status Prepare();
  Status PrepareVideo();
  Status Resume();
  Status FeedVideoAgain();
  Status SaveState(ResumeState state);
  Status RunLoop();
  Status WriteLog() const;
  void MeasureQuality(const Picture& picture);
  std::string FilesText() const;
  std::string QualityText() const;
  void Summarise() const;
  int64_t FrameAt(size_t at) const { return options_.frames.first + static_cast<int64_t>(at); }
  std::string VideoPath() const {
    return (std::filesystem::path(options_.text.folder) / "denoised.mp4").string();
  }

  const RenderOptions& options_;
  const Scene& scene_;
  int threads_;
  std::string fingerprint_;
  std::string key_;        ///< key of the state for --resume
  int64_t next_frame_;     ///< all earlier frames are finished and written
  bool complete_ = false;  ///< an earlier run finished all frames
  /// Unwritten frames of an earlier run, starting with the next frame.
  std::vector<UnwrittenFrame> unwritten_;
  OutputFolderMark folder_mark_;
  bool overlaps_;  ///< whether frames are rendered while the previous one is written
  FrameMaker maker_;
  RenderPicture* made_ = nullptr;  ///< the last rendered frame
  std::unique_ptr<VideoWriter> video_;
  std::optional<Progress> progress_;
  RunLog log_;
  std::vector<FinishedFile> files_;    ///< files of all finished frames
  std::vector<FinishedFile> written_;  ///< files of the frame that is being written
  size_t synced_ = 0;                  ///< number of files flushed to disk
  int64_t first_written_ = 0;          ///< first frame written by this run
  int64_t written_bytes_ = 0;
  Clock::time_point start_;
  int64_t non_finite_ = 0;
  int64_t bad_guides_ = 0;
  // Sums over the frames of this run that have a reference.
  double psnr_ = 0;
  double noisy_psnr_ = 0;
  int measured_ = 0;
  int noisy_measured_ = 0;
};

Status RenderRun::Prepare() {
  STILLRAY_RETURN_IF_ERROR(maker_.FindCamera());
  STILLRAY_RETURN_IF_ERROR(ValidateRenderSettings(options_.render));
  const Result<RenderDevices> devices =
      OpenRenderDevices(options_.text.device, options_.text.trace_device, options_.text.verbose);
  STILLRAY_RETURN_IF_ERROR(devices.status());
  fingerprint_ += fmt::format("on {}\n", devices->filter.description());
  if (devices->differ()) {
    fingerprint_ += fmt::format("traced on {}\n", devices->tracer.description());
  }
  // Settings are validated before anything is written.
  const bool ahead = threads_ > 1 && FramesFit(options_.render, 3);
  STILLRAY_RETURN_IF_ERROR(maker_.Prepare(*devices, ahead));
  const std::string& folder = options_.text.folder;
  STILLRAY_RETURN_IF_ERROR(MakeOutputFolder(folder));
  MarkOutputFolder(folder, &folder_mark_);
  STILLRAY_RETURN_IF_ERROR(CheckJsonOutput(options_.text.json_path));
  io::RemoveStaleTemporaries(folder);
  log_.scene_content = SceneContent(scene_);
  log_.environment_content = EnvironmentContent(options_, scene_);
  log_.lens_mask_content = LensMaskContent(options_, scene_);
  log_.device = devices->filter.description();
  log_.tracer = maker_.place();
  log_.traces_ahead = maker_.traces_ahead();
  if (options_.text.resume) {
    STILLRAY_RETURN_IF_ERROR(Resume());
  } else {
    RemoveResumeState(folder, key_);
  }
  return complete_ || !options_.mp4 ? Status::Ok() : PrepareVideo();
}

Status RenderRun::PrepareVideo() {
  Result<std::unique_ptr<VideoWriter>> video = VideoWriter::Create(
      VideoPath(), options_.render.width, options_.render.height, options_.text.fps);
  if (video.ok()) {
    video_ = std::move(video.value());
    return FeedVideoAgain();
  }
  if (options_.text.formats_given || video.status().code() != StatusCode::kUnsupported) {
    return video.status();
  }
  PrintTo(stderr, "note: no video: {}\n", video.status().message());
  return Status::Ok();
}

Status RenderRun::Resume() {
  Result<ResumeState> state = LoadResumeState(options_.text.folder, key_);
  if (!state.ok() && state.status().code() == StatusCode::kNotFound) {
    PrintTo(stderr, "note: nothing to resume in {}, starting with frame {}\n", options_.text.folder,
            next_frame_);
    return Status::Ok();
  }
  if (!state.ok()) {
    return state.status();
  }
  const std::string difference = FingerprintDifference(state->fingerprint, fingerprint_);
  if (!difference.empty()) {
    return Status::InvalidArgument(
        fmt::format("cannot resume {}: {}", ResumePath(options_.text.folder, key_), difference));
  }
  const std::string changed = FirstChanged(options_.text.folder, state->files);
  if (!changed.empty()) {
    PrintTo(stderr, "note: starting again with frame {}: {}\n", next_frame_, changed);
    return Status::Ok();
  }
  // An unfinished video is encoded again; a video that never existed is not.
  const bool lacks_video = options_.mp4 && !std::filesystem::exists(VideoPath());
  complete_ = state->last_frame >= options_.frames.last && (state->history.empty() || !lacks_video);
  if (complete_) {
    PrintTo(stderr, "all frames are there already\n");
    return Status::Ok();
  }
  if (state->history.empty()) {
    PrintTo(stderr,
            "note: starting again with frame {}: the run ended at frame {} and kept no "
            "history\n",
            next_frame_, state->last_frame);
    return Status::Ok();
  }
  if (options_.mp4 && !options_.png) {
    PrintTo(stderr,
            "note: starting again with frame {}: a video can only be resumed where --format has "
            "png too\n",
            next_frame_);
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(maker_.RestoreHistory(
      state->history, state->last_frame + static_cast<int64_t>(state->unwritten.size())));
  Result<RunLog> log = ParseRunLog(state->log);
  if (!log.ok()) {
    return log.status();
  }
  log_.frames = std::move(log->frames);
  files_ = std::move(state->files);
  synced_ = files_.size();
  next_frame_ = state->last_frame + 1;
  unwritten_ = std::move(state->unwritten);
  PrintTo(stderr, "resuming with frame {}\n", next_frame_);
  return Status::Ok();
}

/// Encodes the finished frames of an earlier run from their image files.
Status RenderRun::FeedVideoAgain() {
  const std::string pattern = ViewPattern(options_.text.folder, "denoised", "png");
  for (int64_t frame = options_.frames.first; frame < next_frame_; ++frame) {
    const Result<Rgb8Image> picture = ReadPng8(FrameFileName(pattern, frame));
    if (!picture.ok()) {
      return picture.status();
    }
    STILLRAY_RETURN_IF_ERROR(video_->Write(*picture));
  }
  return Status::Ok();
}

Status RenderRun::Make(size_t at, Picture* picture) {
  // The files of the last frame no longer need its device images: this frame may reuse them.
  if (made_ != nullptr) {
    picture->traced.frame.on_device = std::move(made_->traced.frame.on_device);
  }
  made_ = nullptr;
  UnwrittenFrame* earlier = unwritten_.empty() ? nullptr : &unwritten_.front();
  STILLRAY_RETURN_IF_ERROR(maker_.Make(FrameAt(at), earlier, &*progress_, picture));
  if (earlier != nullptr) {
    unwritten_.erase(unwritten_.begin());
  }
  made_ = picture;
  log_.denoiser_bytes = maker_.denoiser().memory_bytes();
  log_.device_memory = maker_.denoiser().device_memory();
  log_.renderer_bytes = picture->traced.renderer_bytes;
  const size_t frames = 1 + (overlaps_ ? 1 : 0) + (maker_.traces_ahead() ? 1 : 0);
  log_.frame_bytes = frames * (FrameBytes(picture->traced.frame) + FrameBytes(picture->on_host));
  return Status::Ok();
}

Status RenderRun::Write(Picture* picture) {
  Rgb8Image display;
  std::vector<std::string> paths;
  written_.clear();
  STILLRAY_RETURN_IF_ERROR(WriteFrameFiles(
      options_, *picture->in_files, picture->denoised,
      picture->traced.reference.empty() ? nullptr : &picture->traced.reference, &display, &paths));
  STILLRAY_RETURN_IF_ERROR(AddFinishedFiles(options_.text.folder, paths, &written_));
  if (!picture->traced.reference.empty()) {
    MeasureQuality(*picture);
  }
  return video_ ? video_->Write(display) : Status::Ok();
}

/// Measures the quality over finite pixels; images without finite pixels are skipped.
void RenderRun::MeasureQuality(const Picture& picture) {
  const Result<double> clean = MeasurePsnr(picture.denoised.colour, picture.traced.reference);
  if (clean.ok()) {
    psnr_ += *clean;
    ++measured_;
  }
  if (picture.in_files->on_device != nullptr) {
    return;
  }
  const Result<double> noisy = MeasurePsnr(SumOfLight(*picture.in_files), picture.traced.reference);
  if (noisy.ok()) {
    noisy_psnr_ += *noisy;
    ++noisy_measured_;
  }
}

Status RenderRun::Finish(Picture* picture, const WriteResult& written) {
  STILLRAY_RETURN_IF_ERROR(written.status);
  files_.insert(files_.end(), written_.begin(), written_.end());
  for (const FinishedFile& file : written_) {
    written_bytes_ += static_cast<int64_t>(file.bytes);
  }
  FrameLog& log = picture->log;
  log.write_ms = written.milliseconds;
  non_finite_ += picture->denoised.non_finite + picture->denoised.negative;
  bad_guides_ += picture->denoised.bad_guides;
  next_frame_ = log.frame + 1;
  progress_->Step(
      WorkBefore(options_, next_frame_),
      fmt::format("{}: render {:.0f} ms, denoise {:.0f} ms, write {:.0f} ms",
                  FrameText(options_, log.frame), log.render_ms, log.denoise_ms, log.write_ms));
  log_.frames.push_back(std::move(log));
  return Status::Ok();
}

bool RenderRun::CanSave() const {
  return maker_.last_filtered() >= options_.frames.first && maker_.history_is_whole();
}

Status RenderRun::Save(std::span<Picture* const> unwritten) {
  ResumeState state;
  for (const Picture* picture : unwritten) {
    const DenoisedFrame& denoised = picture->denoised;
    state.unwritten.push_back({picture->log.frame, denoised.colour, denoised.images});
  }
  state.unwritten.insert(state.unwritten.end(), unwritten_.begin(), unwritten_.end());
  Result<std::vector<uint8_t>> history = maker_.SaveHistory();
  STILLRAY_RETURN_IF_ERROR(history.status());
  state.history = std::move(history.value());
  return SaveState(std::move(state));
}

Status RenderRun::SaveState(ResumeState state) {
  state.key = key_;
  state.fingerprint = fingerprint_;
  state.files = files_;
  state.log = RunLogJson(options_, log_, threads_);
  state.last_frame = next_frame_ - 1;
  return SaveResumeState(options_.text.folder, state, &synced_);
}

/// Writes the log, including frames of earlier runs with equal settings in the folder.
Status RenderRun::WriteLog() const {
  const std::string path = (std::filesystem::path(options_.text.folder) / "render.json").string();
  RunLog all = log_;
  constexpr size_t kLargestLog = size_t{1} << 28;
  if (const Result<std::string> text = ReadWholeFile(path, kLargestLog); text.ok()) {
    std::vector<FrameLog> earlier = FramesOfEarlierRun(*text, options_, log_);
    all.frames.insert(all.frames.end(), earlier.begin(), earlier.end());
    std::sort(all.frames.begin(), all.frames.end(),
              [](const FrameLog& a, const FrameLog& b) { return a.frame < b.frame; });
  }
  const std::string json = RunLogJson(options_, all, threads_);
  STILLRAY_RETURN_IF_ERROR(WriteFileAtomically(path, json.data(), json.size()));
  if (options_.text.json_path.empty()) {
    return Status::Ok();
  }
  return WriteJsonOutput(options_.text.json_path, json);
}

std::string RenderRun::FilesText() const {
  std::vector<std::string> names;
  for (const FinishedFile& file : files_) {
    names.push_back(file.name);
  }
  return FilePatternsText(names);
}

std::string RenderRun::QualityText() const {
  const std::string noisy =
      noisy_measured_ > 0 ? fmt::format(" (noisy: {:.1f} dB)", noisy_psnr_ / noisy_measured_) : "";
  return fmt::format(
      "against the reference, {} frame{}: PSNR {:.1f} dB{}; more: stillray compare, stillray "
      "report {}",
      measured_, measured_ == 1 ? "" : "s", psnr_ / measured_, noisy, options_.text.folder);
}

void RenderRun::Summarise() const {
  if (non_finite_ > 0) {
    PrintTo(stderr, "warning: {} samples were not finite or negative and were left out\n",
            non_finite_);
  }
  if (bad_guides_ > 0) {
    PrintTo(stderr, "warning: {} pixels had no usable guides and were not filtered\n", bad_guides_);
  }
  std::FILE* out = options_.text.json_path == "-" ? stderr : stdout;
  if (options_.text.timings) {
    WriteText(out, TimingsTable(log_));
  }
  RunSummary summary;
  summary.frames = static_cast<size_t>(next_frame_ - first_written_);
  summary.frames_before = static_cast<size_t>(first_written_ - options_.frames.first);
  summary.place = options_.text.folder;
  summary.bytes = written_bytes_;
  if (video_) {
    summary.bytes += FileBytes(VideoPath());
  }
  summary.seconds = MillisecondsSince(start_) / 1000;
  PrintTo(out, "{}\n", RunSummaryText(summary));
  PrintTo(out, "files: {}\n", FilesText());
  if (measured_ > 0) {
    PrintTo(out, "{}\n", QualityText());
  }
}

Status RenderRun::RunLoop() {
  LoopOptions loop;
  loop.begin = static_cast<size_t>(next_frame_ - options_.frames.first);
  loop.end = static_cast<size_t>(options_.frames.count());
  loop.overlap = overlaps_;
  loop.keep_going = [] { return !Interrupted(); };
  progress_.emplace(WorkBefore(options_, options_.frames.last + 1), stderr);
  LoopEnd end = FrameLoop<RenderRun>(this, std::move(loop)).Run();
  if (end.status.ok() && video_) {
    end.status = video_->Finish();
    if (!end.status.ok()) {
      end.save_status = Save({});
      end.saved = end.save_status.ok();
    }
  }
  progress_.reset();
  if (end.status.ok()) {
    return Status::Ok();
  }
  return StopError({end.status, end.save_status,
                    static_cast<size_t>(next_frame_ - options_.frames.first),
                    static_cast<size_t>(options_.frames.count()), end.saved ? "here" : ""});
}

Status RenderRun::Run() {
  STILLRAY_RETURN_IF_ERROR(Prepare());
  if (complete_) {
    return Status::Ok();
  }
  PrintTo(stderr, "{}\n", OutputSizeText(options_, next_frame_));
  WriteText(stderr,
            DiskSpaceWarning(options_.text.folder, EstimateOutputSize(options_, next_frame_)));
  first_written_ = next_frame_;
  start_ = Clock::now();
  STILLRAY_RETURN_IF_ERROR(RunLoop());
  if (video_) {
    STILLRAY_RETURN_IF_ERROR(AddFinishedFiles(options_.text.folder, {VideoPath()}, &files_));
  }
  STILLRAY_RETURN_IF_ERROR(WriteLog());
  STILLRAY_RETURN_IF_ERROR(SaveState(ResumeState()));
  Summarise();
  return Status::Ok();
}

}  // namespace

Status RunFrames(const RenderOptions& options, const Scene& scene, int threads) {
  return RenderRun(options, scene, threads).Run();
}

}  // namespace stillray

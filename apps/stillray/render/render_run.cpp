// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/render_run.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "common/console.h"
#include "common/device_option.h"
#include "common/interrupt.h"
#include "common/json_output.h"
#include "common/output_folder.h"
#include "common/progress.h"
#include "common/run_summary.h"
#include "common/trace_device.h"
#include "io/atomic_file.h"
#include "render/output_size.h"
#include "render/render_files.h"
#include "render/render_options.h"
#include "render/run_log.h"
#include "render/scene_check.h"
#include "sequence/background.h"
#include "sequence/finished_files.h"
#include "sequence/resume_state.h"
#include "stillray/scene.h"

namespace stillray {
namespace {

using Clock = std::chrono::steady_clock;

/// The history of a run that dies is not older than this, unless a single frame takes longer.
constexpr std::chrono::seconds kSaveInterval(30);

double Milliseconds(Clock::time_point since) {
  return std::chrono::duration<double, std::milli>(Clock::now() - since).count();
}

int PickCamera(const Scene& scene, const std::string& name) {
  for (size_t i = 0; i < scene.cameras.size(); ++i) {
    if (scene.cameras[i].name == name || std::to_string(i) == name) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

/// A frame on its way through the run.
struct FrameInWork {
  Frame frame;
  Frame on_host;  ///< room for its planes, if it lies on a device and files need them
  const Frame* in_files = nullptr;  ///< the frame with the planes that files need
  DenoisedFrame denoised;
  Image3 reference;  ///< empty: none
  FrameLog log;
};

struct WrittenFiles {
  Status status;
  std::vector<FinishedFile> files;
  double milliseconds = 0;
};

/// The frames of one run, one after the other, and everything that lives as long as it does. While
/// a frame is traced and filtered, the files of the one before it are written on a thread of their
/// own.
class RenderRun {
 public:
  RenderRun(const RenderOptions& options, const Scene& scene, int threads)
      : options_(options),
        scene_(scene),
        threads_(threads),
        overlap_(threads > 1 && TwoFramesFit(options.render)),
        fingerprint_(RenderFingerprint(options, scene)),
        key_(fmt::format("render frames from {}", options.frames.first)),
        next_frame_(options.frames.first),
        history_frame_(options.frames.first - 1) {}

  Status Run();

 private:
  Status Prepare();
  Status MakeRenderer(const Device& device);
  void TellTracingOnCpu();
  Status Resume();
  Status FeedVideoAgain();
  Status RenderOne(int64_t frame, Progress* progress);
  Status Filter(const RenderMoment& moment, const RenderProgress& shown, FrameInWork* work);
  void TakeUnwritten(int64_t number, DenoisedFrame* denoised);
  Status Denoise(const RenderMoment& moment, const RenderProgress& shown, FrameInWork* work);
  Status RenderReference(const RenderMoment& moment, Progress* progress, Image3* reference);
  Status BringToHost(FrameInWork* work) const;
  WrittenFiles WriteFiles(const FrameInWork& work);
  Status FinishWriting(Progress* progress);
  std::vector<UnwrittenFrame> Unwritten() const;
  Status SaveState(bool with_history);
  Status Stop(Status reason, Progress* progress);
  Status WriteLog() const;
  double Work(int64_t frame) const;
  double WorkBefore(int64_t frame) const;
  std::string FrameText(int64_t frame) const {
    return fmt::format("frame {} of {}", frame, options_.frames.last);
  }
  void Summarise() const;
  std::string VideoPath() const {
    return (std::filesystem::path(options_.text.folder) / "denoised.mp4").string();
  }

  const RenderOptions& options_;
  const Scene& scene_;
  int threads_;
  bool overlap_;  ///< whether files are written while the next frame is traced
  std::string fingerprint_;
  std::string key_;                        ///< of the state for --resume
  int64_t next_frame_;                     ///< all frames before it are done, their files written
  int64_t history_frame_;                  ///< the last frame whose light is in the history
  bool history_is_whole_ = true;           ///< false once the denoiser failed within a frame
  bool complete_ = false;                  ///< an earlier run did everything
  std::vector<UnwrittenFrame> unwritten_;  ///< of an earlier run
  int camera_ = 0;
  std::unique_ptr<DeviceRenderer> renderer_;
  std::optional<Denoiser> denoiser_;
  bool told_fall_back_ = false;
  std::unique_ptr<VideoWriter> video_;
  FrameInWork works_[2];
  size_t traced_ = 0;  ///< which of them is traced; the other may be written
  RunLog log_;
  std::vector<FinishedFile> files_;  ///< of all finished frames
  size_t synced_ = 0;                ///< how many of them were flushed to the disk
  Clock::time_point last_save_ = Clock::now();
  int64_t first_written_ = 0;  ///< of this run
  int64_t written_bytes_ = 0;
  Clock::time_point start_;
  int64_t non_finite_ = 0;
  int64_t bad_guides_ = 0;
  Background<WrittenFiles> writing_;  ///< last, so that its work ends before what it reads goes
};

/// Samples per pixel that a frame takes, as a measure of the time it will take. Filtering and
/// writing count as four.
double RenderRun::Work(int64_t frame) const {
  return SamplesPerPixel(options_.render) + 4.0 +
         (options_.WantsReference(frame) ? options_.text.reference_spp : 0);
}

double RenderRun::WorkBefore(int64_t frame) const {
  double work = 0;
  for (int64_t f = options_.frames.first; f < frame; ++f) {
    work += Work(f);
  }
  return work;
}

Status RenderRun::Prepare() {
  if (!options_.text.camera.empty()) {
    camera_ = PickCamera(scene_, options_.text.camera);
    if (camera_ < 0) {
      std::string names;
      for (const Camera& camera : scene_.cameras) {
        names += (names.empty() ? "" : ", ") + camera.name;
      }
      return Status::NotFound(
          fmt::format("--camera is '{}', the scene has: {}", options_.text.camera, names));
    }
  }
  STILLRAY_RETURN_IF_ERROR(render::CheckSettings(options_.render));
  const Result<Device> device =
      OpenDeviceOption(options_.text.device, options_.text.verbose, "rendering");
  if (!device.ok()) {
    return device.status();
  }
  fingerprint_ += fmt::format("on {}\n", device->description());
  // Whatever may be wrong with the settings is found before anything is written.
  STILLRAY_RETURN_IF_ERROR(MakeRenderer(*device));
  Result<Denoiser> denoiser = Denoiser::Create(options_.denoise, *device);
  if (!denoiser.ok()) {
    return denoiser.status();
  }
  denoiser_.emplace(std::move(denoiser.value()));
  STILLRAY_RETURN_IF_ERROR(denoiser_->SetOutputs(options_.outputs));
  const std::string& folder = options_.text.folder;
  STILLRAY_RETURN_IF_ERROR(MakeOutputFolder(folder));
  STILLRAY_RETURN_IF_ERROR(CheckJsonOutput(options_.text.json_path));
  io::RemoveStaleTemporaries(folder);
  log_.scene_content = SceneContent(scene_);
  log_.environment_content = EnvironmentContent(options_, scene_);
  log_.device = device->description();
  log_.tracer = renderer_->place();
  if (options_.text.resume) {
    STILLRAY_RETURN_IF_ERROR(Resume());
    if (complete_) {
      return Status::Ok();
    }
  } else {
    RemoveResumeState(folder, key_);
  }
  if (options_.mp4) {
    Result<std::unique_ptr<VideoWriter>> video = VideoWriter::Create(
        VideoPath(), options_.render.width, options_.render.height, options_.text.fps);
    if (!video.ok() &&
        (options_.text.formats_given || video.status().code() != StatusCode::kUnsupported)) {
      return video.status();
    }
    if (video.ok()) {
      video_ = std::move(video.value());
      STILLRAY_RETURN_IF_ERROR(FeedVideoAgain());
    } else {
      PrintTo(stderr, "note: no video: {}\n", video.status().message());
    }
  }
  return Status::Ok();
}

/// Where --device is auto, the CPU traces what the device cannot.
Status RenderRun::MakeRenderer(const Device& device) {
  TraceOptions options;
  options.way = options_.tracing_way;
  options.may_fall_back =
      options_.text.device == "auto" && options.way != render::TracingWay::kHardware;
  options.keep_going = [] { return !Interrupted(); };
  RenderSettings settings = options_.render;
  settings.on_device = true;  // the denoiser is on the same device
  Result<std::unique_ptr<DeviceRenderer>> renderer =
      DeviceRenderer::Create(device, scene_, settings, options);
  if (renderer.status().code() == StatusCode::kCancelled) {
    return Status(StatusCode::kCancelled, "stopped while the BVH was built");
  }
  STILLRAY_RETURN_IF_ERROR(renderer.status());
  renderer_ = std::move(renderer.value());
  TellTracingOnCpu();
  if (renderer_->on_device()) {
    PrintTo(stderr, "rays are traced {}\n", TracingWayText(device, options_.tracing_way));
  }
  return Status::Ok();
}

void RenderRun::TellTracingOnCpu() {
  if (const std::string remark = renderer_->TakeRemark(); !remark.empty()) {
    PrintTo(stderr, "tracing on the CPU: {}\n", remark);
  }
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
  // A video that could not be finished is made again; one that there never was is not.
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
  STILLRAY_RETURN_IF_ERROR(denoiser_->RestoreHistory(state->history));
  Result<RunLog> log = ParseRunLog(state->log);
  if (!log.ok()) {
    return log.status();
  }
  log_.frames = std::move(log->frames);
  files_ = std::move(state->files);
  synced_ = files_.size();
  next_frame_ = state->last_frame + 1;
  unwritten_ = std::move(state->unwritten);
  history_frame_ = state->last_frame + static_cast<int64_t>(unwritten_.size());
  PrintTo(stderr, "resuming with frame {}\n", next_frame_);
  return Status::Ok();
}

/// Encodes the frames that an earlier run finished, from their pictures.
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

Status RenderRun::RenderReference(const RenderMoment& moment, Progress* progress,
                                  Image3* reference) {
  const double before = WorkBefore(moment.frame_index) + SamplesPerPixel(options_.render);
  const int spp = options_.text.reference_spp;
  return renderer_->RenderReference(moment, spp, reference, [&](double part) {
    progress->Update(before + part * spp, FrameText(moment.frame_index) + ", reference");
    return !Interrupted();
  });
}

/// Denoises a frame, or takes what an earlier run made of it.
Status RenderRun::Filter(const RenderMoment& moment, const RenderProgress& shown,
                         FrameInWork* work) {
  if (moment.frame_index <= history_frame_) {
    TakeUnwritten(moment.frame_index, &work->denoised);
    return Status::Ok();
  }
  history_is_whole_ = false;
  STILLRAY_RETURN_IF_ERROR(Denoise(moment, shown, work));
  history_is_whole_ = true;
  history_frame_ = moment.frame_index;
  return Status::Ok();
}

/// Gives out what an earlier run filtered and could not write.
void RenderRun::TakeUnwritten(int64_t number, DenoisedFrame* denoised) {
  for (UnwrittenFrame& frame : unwritten_) {
    if (frame.frame == number) {
      *denoised = DenoisedFrame();
      denoised->colour = std::move(frame.colour);
      denoised->images = std::move(frame.images);
    }
  }
}

/// Where the denoiser goes on on the CPU, frames come to the host from then on; this one is traced
/// again, as it may be lost with the device.
Status RenderRun::Denoise(const RenderMoment& moment, const RenderProgress& shown,
                          FrameInWork* work) {
  const Status status = denoiser_->Denoise(work->frame, &work->denoised);
  if (denoiser_->remark().empty() || !renderer_->settings().on_device) {
    return status;
  }
  RenderSettings settings = renderer_->settings();
  settings.on_device = false;
  STILLRAY_RETURN_IF_ERROR(renderer_->SetSettings(settings));
  if (status.ok()) {
    return status;
  }
  STILLRAY_RETURN_IF_ERROR(renderer_->RenderFrame(moment, &work->frame, shown));
  TellTracingOnCpu();
  return denoiser_->Denoise(work->frame, &work->denoised);
}

/// Not on the thread that writes: it would have to wait for the device, which traces the next frame
/// by then.
Status RenderRun::BringToHost(FrameInWork* work) const {
  work->in_files = &work->frame;
  const uint32_t planes = PlanesInFiles(options_);
  if (work->frame.on_device == nullptr || planes == 0) {
    return Status::Ok();
  }
  const Clock::time_point start = Clock::now();
  const Result<const Frame*> brought = OnHost(work->frame, &work->on_host, planes);
  STILLRAY_RETURN_IF_ERROR(brought.status());
  work->in_files = *brought;
  work->log.stages.push_back({"frame_to_host", Milliseconds(start)});
  return Status::Ok();
}

Status RenderRun::RenderOne(int64_t number, Progress* progress) {
  FrameInWork& work = works_[traced_];
  RenderMoment moment;
  moment.frame_index = number;
  moment.seconds = options_.Seconds(number);
  moment.previous_seconds = options_.PreviousSeconds(number);
  moment.camera = camera_;
  work.log = FrameLog();
  work.log.frame = number;
  work.log.seconds = moment.seconds;
  const Clock::time_point start = Clock::now();
  const auto shown = [&](double part) {
    progress->Update(WorkBefore(number) + part * SamplesPerPixel(options_.render),
                     FrameText(number));
    return !Interrupted();
  };
  STILLRAY_RETURN_IF_ERROR(renderer_->RenderFrame(moment, &work.frame, shown));
  TellTracingOnCpu();
  work.log.render_ms = Milliseconds(start);
  std::vector<LoggedStage> traced;
  if (renderer_->on_device()) {
    traced = TraceStages(renderer_->timings());
  }
  work.reference = Image3();
  if (options_.WantsReference(number)) {
    STILLRAY_RETURN_IF_ERROR(RenderReference(moment, progress, &work.reference));
  }
  const Clock::time_point denoise_start = Clock::now();
  STILLRAY_RETURN_IF_ERROR(Filter(moment, shown, &work));
  TellFallBack(*denoiser_, &told_fall_back_);
  work.log.denoise_ms = Milliseconds(denoise_start);
  work.log.stages = LoggedStages(work.denoised.timings);
  work.log.stages.insert(work.log.stages.begin(), traced.begin(), traced.end());
  STILLRAY_RETURN_IF_ERROR(BringToHost(&work));
  log_.denoiser_bytes = denoiser_->memory_bytes();
  log_.device_memory = denoiser_->device_memory();
  log_.renderer_bytes = renderer_->memory_bytes();
  STILLRAY_RETURN_IF_ERROR(FinishWriting(progress));
  // What files need of it is on the host: the next frame may have its images.
  works_[1 - traced_].frame.on_device = std::move(work.frame.on_device);
  writing_.Start(overlap_, [this, &work] { return WriteFiles(work); });
  traced_ = 1 - traced_;
  const bool save = Clock::now() - last_save_ > kSaveInterval && number < options_.frames.last;
  if (!overlap_ || save || number == options_.frames.last) {
    STILLRAY_RETURN_IF_ERROR(FinishWriting(progress));
  }
  return save ? SaveState(true) : Status::Ok();
}

WrittenFiles RenderRun::WriteFiles(const FrameInWork& work) {
  const Clock::time_point start = Clock::now();
  Rgb8Image display;
  WrittenFiles written;
  std::vector<std::string> paths;
  written.status =
      WriteFrameFiles(options_, *work.in_files, work.denoised,
                      work.reference.empty() ? nullptr : &work.reference, &display, &paths);
  if (written.status.ok()) {
    written.status = AddFinishedFiles(options_.text.folder, paths, &written.files);
  }
  if (written.status.ok() && video_) {
    written.status = video_->Write(display);
  }
  written.milliseconds = Milliseconds(start);
  return written;
}

/// Waits for the files that are being written, if there are any. Only now their frame is done.
Status RenderRun::FinishWriting(Progress* progress) {
  if (!writing_.under_way()) {
    return Status::Ok();
  }
  const WrittenFiles written = writing_.Take();
  STILLRAY_RETURN_IF_ERROR(written.status);
  files_.insert(files_.end(), written.files.begin(), written.files.end());
  FrameInWork& work = works_[1 - traced_];
  work.log.write_ms = written.milliseconds;
  for (const FinishedFile& file : written.files) {
    written_bytes_ += static_cast<int64_t>(file.bytes);
  }
  non_finite_ += work.denoised.non_finite + work.denoised.negative;
  bad_guides_ += work.denoised.bad_guides;
  next_frame_ = work.log.frame + 1;
  progress->Step(WorkBefore(next_frame_),
                 fmt::format("{}: render {:.0f} ms, denoise {:.0f} ms, write {:.0f} ms",
                             FrameText(work.log.frame), work.log.render_ms, work.log.denoise_ms,
                             work.log.write_ms));
  log_.frames.push_back(std::move(work.log));
  return Status::Ok();
}

/// Frames whose light is in the history and whose files are not there.
std::vector<UnwrittenFrame> RenderRun::Unwritten() const {
  std::vector<UnwrittenFrame> frames;
  for (int64_t number = next_frame_; number <= history_frame_; ++number) {
    for (const FrameInWork& work : works_) {
      if (work.log.frame == number && !work.denoised.colour.empty()) {
        frames.push_back({number, work.denoised.colour, work.denoised.images});
        break;
      }
    }
    // Of an earlier run, and not taken yet.
    for (const UnwrittenFrame& frame : unwritten_) {
      if (frame.frame == number && !frame.colour.empty()) {
        frames.push_back(frame);
      }
    }
  }
  return frames;
}

Status RenderRun::SaveState(bool with_history) {
  ResumeState state;
  state.key = key_;
  state.fingerprint = fingerprint_;
  state.files = files_;
  state.log = RunLogJson(options_, log_, threads_);
  state.last_frame = next_frame_ - 1;
  if (with_history) {
    state.unwritten = Unwritten();
    Result<std::vector<uint8_t>> history = denoiser_->SaveHistory();
    STILLRAY_RETURN_IF_ERROR(history.status());
    state.history = std::move(history.value());
  }
  last_save_ = Clock::now();
  return SaveResumeState(options_.text.folder, state, &synced_);
}

/// With the frames that earlier runs of the same settings left in the folder.
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
  summary.seconds = Milliseconds(start_) / 1000;
  PrintTo(out, "{}\n", RunSummaryText(summary));
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
  {
    Progress progress(WorkBefore(options_.frames.last + 1), stderr);
    Status done;
    for (int64_t frame = next_frame_; done.ok() && frame <= options_.frames.last; ++frame) {
      done = RenderOne(frame, &progress);
    }
    if (done.ok() && video_) {
      done = video_->Finish();
    }
    if (!done.ok()) {
      return Stop(done, &progress);
    }
  }
  if (video_) {
    STILLRAY_RETURN_IF_ERROR(AddFinishedFiles(options_.text.folder, {VideoPath()}, &files_));
  }
  STILLRAY_RETURN_IF_ERROR(WriteLog());
  STILLRAY_RETURN_IF_ERROR(SaveState(false));
  Summarise();
  return Status::Ok();
}

/// Keeps what is done when a frame failed or the user stopped.
Status RenderRun::Stop(Status reason, Progress* progress) {
  // What is wrong with an earlier frame comes first.
  if (const Status written = FinishWriting(progress); !written.ok()) {
    reason = written;
  }
  progress->Clear();
  const bool cancelled = reason.code() == StatusCode::kCancelled;
  std::string message = cancelled ? "stopped" : reason.message();
  if (next_frame_ > options_.frames.first || cancelled) {
    message += fmt::format("; {} of {} frames are finished", next_frame_ - options_.frames.first,
                           options_.frames.count());
  }
  if (history_frame_ >= options_.frames.first && history_is_whole_) {
    const Status saved = SaveState(true);
    if (cancelled) {
      STILLRAY_RETURN_IF_ERROR(saved);
    }
    message += saved.ok() ? ", --resume goes on from here"
                          : "; the state for --resume could not be saved either";
  }
  return Status(reason.code(), message);
}

}  // namespace

Status RunFrames(const RenderOptions& options, const Scene& scene, int threads) {
  return RenderRun(options, scene, threads).Run();
}

}  // namespace stillray

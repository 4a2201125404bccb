// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/denoise_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "common/console.h"
#include "common/device_option.h"
#include "common/finished_files.h"
#include "common/interrupt.h"
#include "common/json_output.h"
#include "common/output_folder.h"
#include "common/progress.h"
#include "common/resume.h"
#include "common/run_summary.h"
#include "denoise/denoise_check.h"
#include "denoise/denoise_frames.h"
#include "denoise/denoise_future.h"
#include "denoise/denoise_log.h"
#include "denoise/denoise_passes.h"
#include "denoise/denoise_preview.h"
#include "denoise/denoise_reader.h"
#include "denoise/denoise_settings.h"
#include "denoise/denoise_writer.h"
#include "io/atomic_file.h"
#include "io/text.h"

namespace stillray {
namespace {

using Clock = std::chrono::steady_clock;

/// The history of a run that dies is not older than this, unless a single frame takes longer.
constexpr std::chrono::seconds kSaveInterval(30);

double Milliseconds(Clock::time_point since) {
  return std::chrono::duration<double, std::milli>(Clock::now() - since).count();
}

/// The frames of one run, one after the other, and everything that lives as long as it does. While
/// a frame is filtered, the file behind it is read and the one before it written, each on a thread
/// of its own. Everything else, the user's messages too, is done by the caller's, in the order of
/// the frames.
class DenoiseRun {
 public:
  DenoiseRun(const DenoiseOptions& options, int threads)
      : options_(options),
        threads_(threads),
        folder_(std::filesystem::path(options.files.front().output).parent_path().string()),
        key_("denoise to " +
             std::filesystem::path(options.files.front().output).filename().string()) {}

  Status Run();

 private:
  Status Prepare();
  Status Understand(ExrExtent* extent);
  Status PrepareDenoisers(const ExrExtent& extent);
  Status PrepareFuture(const ExrExtent& first);
  Status PlayBackward(const SequenceFile& file);
  void TakeWindowOfResumedRun();
  void FallBackToPast(const std::string& why);
  Status CheckInputs();
  Status CheckFormerInputs(const ResumeState& state) const;
  Status Resume();
  Status DenoiseFile(size_t at);
  void ChooseOverlap(const ExrExtent& first);
  Status Filter(SequenceFrame* frame, size_t at, DenoisedFrameLog* log);
  void StartWriting(SequenceFrame* frame, size_t at);
  Status FinishWriting();
  DeviceMemory UsedOnDevice() const;
  void TellProgress(const DenoisedFrameLog& log);
  std::string Note(Link link) const;
  Result<std::vector<uint8_t>> SaveHistory() const;
  Status RestoreHistory(std::span<const uint8_t> bytes);
  Status SaveState();
  Status Stop(Status reason);
  Status WriteJson() const;
  void Summarise() const;
  bool LooksAhead() const { return future_.has_value(); }

  DenoiseOptions options_;
  int threads_;
  std::string fingerprint_;
  std::string folder_;
  std::string key_;  ///< of the state for --resume
  size_t next_ = 0;  ///< files that are done: read, denoised and written
  AovLayout layout_;
  Settings settings_;
  Device device_;
  std::optional<Denoiser> denoiser_;
  bool told_fall_back_ = false;
  size_t futures_held_ = 0;
  std::optional<FuturePass> future_;
  bool overlap_ = false;  ///< whether files are read and written beside the filter
  std::optional<FrameReader> reader_;
  std::optional<Preview> preview_;
  std::optional<FrameWriter> writer_;
  std::optional<SequenceFrame> previous_;  ///< guides only
  std::optional<PassSplitter> splitter_;
  DenoisedFrame denoised_;
  std::vector<NewLayer> layers_;  ///< of the frame in work
  DenoiseLog log_;
  std::string warning_;                ///< of the denoiser, of the first frame that has one
  std::vector<FinishedFile> inputs_;   ///< of frames that are done
  std::vector<FinishedFile> outputs_;  ///< likewise
  size_t synced_ = 0;                  ///< outputs that were flushed to the disk
  DenoisedFrameLog writing_log_;       ///< of the frame that is being written
  Clock::time_point start_;            ///< of the frames
  Clock::time_point last_end_;         ///< when the frame before it was done
  int64_t written_bytes_ = 0;
  std::optional<Progress> progress_;
  double done_ = 0;  ///< frames denoised and played backward
  bool motion_was_seen_ = false;
  size_t seen_ = 0;        ///< files whose light is in the history
  size_t resumed_at_ = 0;  ///< files that an earlier run did
  size_t saved_ = 0;       ///< files done when the state was saved; 0: never
  Clock::time_point last_save_ = Clock::now();
};

Status DenoiseRun::PrepareFuture(const ExrExtent& first) {
  if (options_.window != Window::kBoth) {
    return Status::Ok();
  }
  if (!settings_.temporal) {
    FallBackToPast("without history there is no future either");
    return Status::Ok();
  }
  const Result<size_t> held = FuturesThatFit(first, options_, options_.files.front().input);
  if (!held.ok()) {
    return held.status();
  }
  futures_held_ = *held;
  Result<Denoiser> backward = Denoiser::Create(settings_, device_);
  if (!backward.ok()) {
    return backward.status();
  }
  future_.emplace(options_, layout_, std::move(backward.value()), futures_held_, overlap_,
                  [this](const SequenceFile& file) { return PlayBackward(file); });
  return Status::Ok();
}

/// One thread does one thing at a time. Memory decides last: what is held besides is never the
/// reason to refuse a frame.
void DenoiseRun::ChooseOverlap(const ExrExtent& first) {
  if (threads_ < 2) {
    return;
  }
  const Status fits = OverlapFits(first, options_);
  overlap_ = fits.ok();
  if (!overlap_) {
    PrintTo(stderr, "note: files are not read and written beside the filter: {}\n", fits.message());
  }
}

/// An unfinished run goes on with its own window, whatever the files would allow by now.
void DenoiseRun::TakeWindowOfResumedRun() {
  if (!options_.text.resume || !options_.window_is_chosen) {
    return;
  }
  const Result<ResumeState> state = LoadResumeState(folder_, key_);
  if (!state.ok()) {
    return;
  }
  for (const Window window : {Window::kPast, Window::kBoth}) {
    if (state->fingerprint.find(fmt::format("\nwindow {}\n", WindowName(window))) !=
        std::string::npos) {
      options_.window = window;
      options_.window_note.clear();
    }
  }
}

void DenoiseRun::FallBackToPast(const std::string& why) {
  options_.window = Window::kPast;
  PrintTo(stderr, "note: --window past: {}\n", why);
}

/// Reads the first file. \param extent  of it
Status DenoiseRun::Understand(ExrExtent* extent) {
  const SequenceFile& first = options_.files.front();
  Result<LoadedFile> file = LoadFile(first.input, options_, false);
  if (file.status().code() == StatusCode::kOutOfMemory && options_.window_is_chosen &&
      options_.window == Window::kBoth) {
    const std::string why = file.status().message();
    options_.window = Window::kPast;
    file = LoadFile(first.input, options_, false);
    if (file.ok()) {
      FallBackToPast(why);
    }
  }
  if (!file.ok()) {
    return file.status();
  }
  Result<AovLayout> layout = UnderstandAovs(file->image, options_.text.aovs, first.input);
  if (!layout.ok()) {
    return layout.status();
  }
  layout_ = std::move(layout.value());
  for (const std::string& note : file->image.notes) {
    PrintTo(stderr, "note: {}\n", note);
  }
  settings_ = SettingsFor(options_, layout_, file->image);
  if (options_.text.passes) {
    STILLRAY_RETURN_IF_ERROR(PassSplitter::Check(settings_, layout_));
  }
  *extent = file->extent;
  return Status::Ok();
}

/// What an earlier run found it has said, and its log has it.
Status DenoiseRun::CheckInputs() {
  if (!options_.text.no_check && next_ == 0) {
    Result<std::vector<Finding>> findings = CheckFirstFrames(options_, layout_);
    if (findings.status().code() == StatusCode::kCancelled) {
      return Status(StatusCode::kCancelled,
                    fmt::format("stopped; 0 of {} frames are finished", options_.files.size()));
    }
    STILLRAY_RETURN_IF_ERROR(findings.status());
    log_.findings = std::move(findings.value());
  }
  AovLayout shown = layout_;
  shown.notes = NotesBeside(log_.findings, layout_);
  WriteText(options_.text.json_path == "-" ? stderr : stdout, AovTable(shown));
  std::fflush(stdout);
  if (next_ == 0) {
    for (const Finding& finding : log_.findings) {
      PrintTo(stderr, "check: {}\n", io::OneLine(FindingLine(finding)));
    }
  }
  return Status::Ok();
}

Status DenoiseRun::Prepare() {
  ExrExtent extent;
  TakeWindowOfResumedRun();
  STILLRAY_RETURN_IF_ERROR(Understand(&extent));
  const Result<Device> device =
      OpenDeviceOption(options_.text.device, options_.text.verbose, "denoising");
  if (!device.ok()) {
    return device.status();
  }
  device_ = *device;
  ChooseOverlap(extent);
  STILLRAY_RETURN_IF_ERROR(PrepareDenoisers(extent));
  // The window is known only now.
  fingerprint_ = DenoiseFingerprint(options_) + fmt::format("on {}\n", device_.description());
  STILLRAY_RETURN_IF_ERROR(MakeOutputFolder(folder_));
  STILLRAY_RETURN_IF_ERROR(CheckJsonOutput(options_.text.json_path));
  io::RemoveStaleTemporaries(folder_);
  STILLRAY_RETURN_IF_ERROR(Resume());
  if (!options_.window_note.empty() && settings_.temporal) {
    PrintTo(stderr, "note: {}\n", options_.window_note);
  }
  STILLRAY_RETURN_IF_ERROR(CheckInputs());
  if (options_.text.preview.empty()) {
    return Status::Ok();
  }
  preview_.emplace(options_, settings_);
  return preview_->Open(extent, layout_, next_);
}

/// All on one device: of the light, of its parts, and of the sequence played backward.
Status DenoiseRun::PrepareDenoisers(const ExrExtent& extent) {
  Result<Denoiser> denoiser = Denoiser::Create(settings_, device_);
  if (!denoiser.ok()) {
    return denoiser.status();
  }
  denoiser_.emplace(std::move(denoiser.value()));
  std::vector<std::string> outputs;
  if (options_.text.passes) {
    splitter_.emplace(settings_, device_);
    outputs = PassSplitter::Outputs(settings_);
  }
  if (settings_.temporal) {
    outputs.emplace_back("disocclusion");
  }
  STILLRAY_RETURN_IF_ERROR(denoiser_->SetOutputs(outputs));
  return PrepareFuture(extent);
}

/// Frames that are done came from the files of then, and those to come continue their history.
Status DenoiseRun::CheckFormerInputs(const ResumeState& state) const {
  for (size_t i = 0; i < state.inputs.size() && i < options_.files.size(); ++i) {
    const std::string& path = options_.files[i].input;
    const auto name = [](const std::string& file) {
      return std::filesystem::path(file).filename().string();
    };
    if (name(path) != name(state.inputs[i].name)) {
      return Status::InvalidArgument(
          fmt::format("cannot resume {}: {} stands where {} was read there before; remove the "
                      "former to start again",
                      ResumePath(folder_, key_), path, name(state.inputs[i].name)));
    }
    const Result<FinishedFile> input = LookAtFile("", path);
    STILLRAY_RETURN_IF_ERROR(input.status());
    if (input->bytes != state.inputs[i].bytes || input->checksum != state.inputs[i].checksum) {
      return Status::InvalidArgument(
          fmt::format("cannot resume {}: {} has changed since; remove the former to start again",
                      ResumePath(folder_, key_), path));
    }
  }
  return Status::Ok();
}

Status DenoiseRun::Resume() {
  Result<ResumeState> state = LoadResumeState(folder_, key_);
  const bool ours = state.ok() && state->fingerprint == fingerprint_;
  if (!options_.text.resume) {
    if (ours) {
      RemoveResumeState(folder_, key_);
    }
    return Status::Ok();
  }
  if (!state.ok() && state.status().code() == StatusCode::kNotFound) {
    PrintTo(stderr, "note: nothing to resume in {}, starting with frame {}\n",
            folder_.empty() ? "." : folder_, options_.files.front().frame);
    return Status::Ok();
  }
  if (!state.ok()) {
    return state.status();
  }
  if (!ours) {
    return Status::InvalidArgument(
        fmt::format("cannot resume {}: {}", ResumePath(folder_, key_),
                    FingerprintDifference(state->fingerprint, fingerprint_)));
  }
  STILLRAY_RETURN_IF_ERROR(CheckFormerInputs(*state));
  const std::string changed = FirstChanged(folder_, state->files);
  if (!changed.empty()) {
    PrintTo(stderr, "note: starting again with frame {}: {}\n", options_.files.front().frame,
            changed);
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(RestoreHistory(state->history));
  Result<DenoiseLog> log = ParseDenoiseLog(state->log);
  if (!log.ok()) {
    return log.status();
  }
  log_ = std::move(log.value());
  inputs_ = std::move(state->inputs);
  outputs_ = std::move(state->files);
  synced_ = outputs_.size();
  while (next_ < options_.files.size() && options_.files[next_].frame <= state->last_frame) {
    ++next_;
  }
  saved_ = seen_ = resumed_at_ = next_;
  if (next_ > 0 && next_ < options_.files.size()) {
    Result<SequenceFrame> before = LoadFrame(options_.files[next_ - 1], options_, layout_, false);
    if (!before.ok()) {
      return before.status();
    }
    motion_was_seen_ = !IsStill(before->frame.guides.motion);
    previous_ = std::move(before.value());
    KeepGuidesOnly(&*previous_);
    PrintTo(stderr, "resuming with frame {}\n", options_.files[next_].frame);
  }
  return Status::Ok();
}

Status DenoiseRun::PlayBackward(const SequenceFile& file) {
  if (Interrupted()) {
    return Status::Cancelled();
  }
  if (writer_->ready()) {
    STILLRAY_RETURN_IF_ERROR(FinishWriting());
  }
  done_ += 1;
  progress_->Update(done_, fmt::format("looking ahead: frame {}", file.frame));
  return Status::Ok();
}

/// Denoises one frame. History is dropped where it belongs to something else: behind a gap in the
/// numbers and at a cut.
Status DenoiseRun::Filter(SequenceFrame* frame, size_t at, DenoisedFrameLog* log) {
  const Clock::time_point start = Clock::now();
  motion_was_seen_ = motion_was_seen_ || !IsStill(frame->frame.guides.motion);
  Link link = Link::kContinues;
  if (settings_.temporal && previous_) {
    link = LinkToPrevious(*previous_, layout_, frame);
  }
  if (link != Link::kContinues) {
    denoiser_->Reset();
    if (splitter_) {
      splitter_->Reset();
    }
    log->restarted = true;
  }
  FutureLight future;
  if (LooksAhead()) {
    const Clock::time_point future_start = Clock::now();
    STILLRAY_RETURN_IF_ERROR(future_->Take(at, &future));
    log->future_ms = Milliseconds(future_start);
  }
  const Status filtered = denoiser_->Denoise(frame->frame, future, &denoised_);
  TellFallBack(*denoiser_, &told_fall_back_);
  if (!filtered.ok()) {
    return Status(filtered.code(), fmt::format("{}: {}", log->input, filtered.message()));
  }
  seen_ = at + 1;
  if (splitter_) {
    STILLRAY_RETURN_IF_ERROR(splitter_->Split(frame->frame, layout_, std::move(frame->parts),
                                              denoised_, &denoised_.colour, &layers_));
  }
  log->without_history = settings_.temporal ? PartWithoutHistory(denoised_, frame->frame) : 1.0;
  log->denoise_ms = Milliseconds(start) - log->future_ms;
  log->missing_light = denoised_.non_finite + denoised_.negative;
  log->negative_light = denoised_.negative;
  log->bad_guides = denoised_.bad_guides;
  log->stages = LoggedStages(denoised_.timings);
  log->note = Note(link);
  if (warning_.empty() && !denoised_.warning.empty()) {
    warning_ = fmt::format("frame {}: {}", log->frame, denoised_.warning);
  }
  return Status::Ok();
}

std::string DenoiseRun::Note(Link link) const {
  switch (link) {
    case Link::kContinues:
      return "";
    case Link::kResized:
      return fmt::format("{} x {} pixels in place of {} x {}", denoised_.colour.width(),
                         denoised_.colour.height(), previous_->frame.width,
                         previous_->frame.height);
    case Link::kCut:
      return "hardly anything of the frame before is found again, a cut";
    case Link::kGap:
      break;
  }
  return fmt::format("frames after {} are missing", previous_->frame.index);
}

void DenoiseRun::StartWriting(SequenceFrame* frame, size_t at) {
  FrameToWrite job;
  job.names = options_.files[at];
  job.bytes = std::move(frame->bytes);
  job.stored = std::move(frame->stored);
  job.colour = std::move(denoised_.colour);
  job.layers = std::move(layers_);
  layers_.clear();
  writer_->Start(std::move(job));
}

/// Waits for the frame that is being written, if there is one. Only now it counts as done.
Status DenoiseRun::FinishWriting() {
  if (!writer_ || !writer_->under_way()) {
    return Status::Ok();
  }
  const WrittenFrame written = writer_->Finish();
  if (!writing_log_.note.empty()) {
    progress_->Clear();
    PrintTo(stderr, "note: frame {}: {}; the history starts again here\n", writing_log_.frame,
            writing_log_.note);
  }
  STILLRAY_RETURN_IF_ERROR(written.status);
  const Result<FinishedFile> input = LookAtFile("", writing_log_.input);
  STILLRAY_RETURN_IF_ERROR(input.status());
  inputs_.push_back(*input);
  STILLRAY_RETURN_IF_ERROR(AddFinishedFiles(folder_, {writing_log_.output}, &outputs_));
  writing_log_.write_ms = written.milliseconds;
  writing_log_.elapsed_ms =
      std::chrono::duration<double, std::milli>(written.end - last_end_).count();
  last_end_ = written.end;
  written_bytes_ += written.bytes;
  next_ += 1;
  done_ += 1;
  TellProgress(writing_log_);
  log_.frames.push_back(std::move(writing_log_));
  return Status::Ok();
}

void DenoiseRun::TellProgress(const DenoisedFrameLog& log) {
  progress_->Step(
      done_, fmt::format("frame {} ({} of {}): read {:.0f} ms, {}denoise {:.0f} ms, "
                         "write {:.0f} ms{}",
                         log.frame, next_, options_.files.size(), log.read_ms,
                         LooksAhead() ? fmt::format("look ahead {:.0f} ms, ", log.future_ms) : "",
                         log.denoise_ms, log.write_ms, log.restarted ? ", history restarted" : ""));
}

DeviceMemory DenoiseRun::UsedOnDevice() const {
  DeviceMemory sum = denoiser_->device_memory();
  if (LooksAhead()) {
    AddDeviceMemory(future_->device_memory(), &sum);
  }
  if (splitter_) {
    AddDeviceMemory(splitter_->device_memory(), &sum);
  }
  return sum;
}

Status DenoiseRun::DenoiseFile(size_t at) {
  const SequenceFile& names = options_.files[at];
  DenoisedFrameLog log;
  log.frame = names.frame;
  log.input = names.input;
  log.output = names.output;
  ReadFrame read = reader_->Next();
  if (!read.frame.ok()) {
    return read.frame.status();
  }
  log.read_ms = read.milliseconds;
  STILLRAY_RETURN_IF_ERROR(Filter(&*read.frame, at, &log));
  STILLRAY_RETURN_IF_ERROR(FinishWriting());
  writing_log_ = std::move(log);
  StartWriting(&*read.frame, at);
  previous_ = std::move(read.frame.value());
  KeepGuidesOnly(&*previous_);
  log_.denoiser_bytes =
      std::max(log_.denoiser_bytes, denoiser_->memory_bytes() +
                                        (LooksAhead() ? future_->memory_bytes() : 0) +
                                        (splitter_ ? splitter_->memory_bytes() : 0));
  log_.device_memory = UsedOnDevice();
  return overlap_ ? Status::Ok() : FinishWriting();
}

/// The history of the light, and behind it that of its parts. The last 8 bytes tell the size of the
/// first.
Result<std::vector<uint8_t>> DenoiseRun::SaveHistory() const {
  Result<std::vector<uint8_t>> saved = denoiser_->SaveHistory();
  if (saved.ok() && splitter_) {
    std::vector<uint8_t>& bytes = saved.value();
    const uint64_t size = bytes.size();
    const Result<std::vector<uint8_t>> parts = splitter_->SaveHistory();
    STILLRAY_RETURN_IF_ERROR(parts.status());
    bytes.insert(bytes.end(), parts->begin(), parts->end());
    bytes.resize(bytes.size() + sizeof(size));
    std::memcpy(bytes.data() + bytes.size() - sizeof(size), &size, sizeof(size));
  }
  return saved;
}

Status DenoiseRun::RestoreHistory(std::span<const uint8_t> bytes) {
  if (splitter_) {
    uint64_t size = 0;
    if (bytes.size() < sizeof(size)) {
      return Status::BadData(ResumePath(folder_, key_) + " is damaged: it has no history");
    }
    const std::span<const uint8_t> all = bytes.first(bytes.size() - sizeof(size));
    std::memcpy(&size, all.data() + all.size(), sizeof(size));
    if (size > all.size()) {
      return Status::BadData(ResumePath(folder_, key_) + " is damaged: its history is cut short");
    }
    STILLRAY_RETURN_IF_ERROR(splitter_->RestoreHistory(all.subspan(size)));
    bytes = all.first(size);
  }
  return denoiser_->RestoreHistory(bytes);
}

Status DenoiseRun::SaveState() {
  ResumeState state;
  state.key = key_;
  state.fingerprint = fingerprint_;
  state.inputs = inputs_;
  state.files = outputs_;
  state.log = DenoiseLogJson(options_, layout_, settings_, log_, threads_);
  state.last_frame = options_.files[next_ - 1].frame;
  Result<std::vector<uint8_t>> history = SaveHistory();
  STILLRAY_RETURN_IF_ERROR(history.status());
  state.history = std::move(history.value());
  last_save_ = Clock::now();
  saved_ = next_;
  return SaveResumeState(folder_, state, &synced_);
}

/// Keeps what is done when a frame failed or the user stopped.
Status DenoiseRun::Stop(Status reason) {
  // What is wrong with an earlier frame comes first.
  if (const Status written = FinishWriting(); !written.ok()) {
    reason = written;
  }
  progress_->Clear();
  const bool cancelled = reason.code() == StatusCode::kCancelled;
  std::string message = cancelled ? "stopped" : reason.message();
  // A frame that was denoised and could not be written is in the history already.
  if (next_ > 0 && seen_ == next_) {
    const Status saved = SaveState();
    if (!saved.ok()) {
      return cancelled ? saved : reason;
    }
  }
  if (next_ > 0 || cancelled) {
    message += fmt::format("; {} of {} frames are finished", next_, options_.files.size());
  }
  if (saved_ > 0) {
    message += fmt::format(", --resume goes on from frame {}", options_.files[saved_].frame);
  }
  return Status(reason.code(), message);
}

Status DenoiseRun::WriteJson() const {
  if (options_.text.json_path.empty()) {
    return Status::Ok();
  }
  const std::string json = DenoiseLogJson(options_, layout_, settings_, log_, threads_);
  return WriteJsonOutput(options_.text.json_path, json);
}

void DenoiseRun::Summarise() const {
  int64_t bad_guides = 0;
  for (const DenoisedFrameLog& frame : log_.frames) {
    bad_guides += frame.bad_guides;
  }
  WriteText(stderr, MissingLightWarning(log_));
  if (!warning_.empty()) {
    PrintTo(stderr, "warning: {}\n", warning_);
  }
  if (bad_guides > 0) {
    PrintTo(stderr, "warning: {} pixels had no usable guides and were not filtered\n", bad_guides);
  }
  if (layout_.Find(Aov::kMotion) != nullptr && !motion_was_seen_ && log_.frames.size() > 1 &&
      !HasFinding(log_.findings, "motion_zero")) {
    PrintTo(stderr,
            "warning: motion is zero in every frame; that is right for a still camera and scene "
            "only (Blender writes zeros where motion blur is on)\n");
  }
  std::FILE* out = options_.text.json_path == "-" ? stderr : stdout;
  if (options_.text.timings) {
    WriteText(out, DenoiseTimings(log_));
  }
  PrintTo(out, "{}\n",
          RunSummaryText({next_ - resumed_at_, resumed_at_, folder_, written_bytes_,
                          std::chrono::duration<double>(last_end_ - start_).count()}));
  if (preview_) {
    PrintTo(out, "{}\n", preview_->Summary());
  }
}

Status DenoiseRun::Run() {
  STILLRAY_RETURN_IF_ERROR(Prepare());
  const size_t files = options_.files.size();
  const size_t backward = LooksAhead() ? CountBackwardFrames(next_, files, futures_held_) : 0;
  done_ = static_cast<double>(next_);
  progress_.emplace(static_cast<double>(files + backward), stderr);
  std::vector<size_t> order(files - next_);
  std::iota(order.begin(), order.end(), next_);
  reader_.emplace(options_, layout_, std::move(order), true, overlap_);
  writer_.emplace(layout_, preview_ ? &*preview_ : nullptr, overlap_);
  start_ = last_end_ = Clock::now();
  for (size_t at = next_; at < files; ++at) {
    Status done = Interrupted() ? Status::Cancelled() : DenoiseFile(at);
    const bool save = Clock::now() - last_save_ > kSaveInterval && at + 1 < files;
    if (done.ok() && (save || at + 1 == files)) {
      done = FinishWriting();
    }
    if (!done.ok()) {
      return Stop(std::move(done));
    }
    if (save) {
      STILLRAY_RETURN_IF_ERROR(SaveState());
    }
  }
  progress_.reset();
  if (preview_) {
    STILLRAY_RETURN_IF_ERROR(preview_->Finish());
  }
  STILLRAY_RETURN_IF_ERROR(WriteJson());
  if (saved_ > 0) {
    RemoveResumeState(folder_, key_);
  }
  Summarise();
  return Status::Ok();
}

}  // namespace

Status RunDenoise(const DenoiseOptions& options, int threads) {
  return DenoiseRun(options, threads).Run();
}

}  // namespace stillray

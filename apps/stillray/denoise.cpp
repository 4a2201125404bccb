// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise: frames of any renderer in, the same files with clean light out.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include "commands.h"
#include "denoise_log.h"
#include "denoise_options.h"
#include "interrupt.h"
#include "progress.h"
#include "resume.h"

namespace stillray {
namespace {

using Clock = std::chrono::steady_clock;

/// The history of a run that dies is not older than this, unless a single frame takes longer.
constexpr std::chrono::seconds kSaveInterval(30);
constexpr size_t kMaxFileBytes = size_t{4} << 30;
/// A cut leaves hardly a pixel with history. What passes the tests by chance is worth nothing; a
/// fast pan that uncovers as much loses little.
constexpr double kCut = 0.9;

double Milliseconds(Clock::time_point since) {
  return std::chrono::duration<double, std::milli>(Clock::now() - since).count();
}

/// A file's bytes and what they hold: the bytes are needed again to write it.
struct LoadedFile {
  std::string bytes;
  ExrImage image;
};

Result<LoadedFile> Load(const std::string& path) {
  LoadedFile file;
  Result<std::string> bytes = ReadWholeFile(path, kMaxFileBytes);
  if (!bytes.ok()) {
    return bytes.status();
  }
  file.bytes = std::move(bytes.value());
  Result<ExrImage> image =
      DecodeExr(reinterpret_cast<const uint8_t*>(file.bytes.data()), file.bytes.size(), path);
  if (!image.ok()) {
    return image.status();
  }
  file.image = std::move(image.value());
  return file;
}

/// Part of the pixels with a surface that the mask marks; 0 where there is no surface at all.
double PartWithoutHistory(const DenoisedFrame& out, const Frame& frame) {
  const auto mask = std::find_if(out.images.begin(), out.images.end(),
                                 [](const NamedImage& i) { return i.name == "disocclusion"; });
  if (mask == out.images.end()) {
    return 0;
  }
  int64_t surfaces = 0;
  int64_t marked = 0;
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      if (std::isfinite(frame.guides.depth(x, y))) {
        ++surfaces;
        marked += mask->channels[0](x, y) > 0.5f;
      }
    }
  }
  return surfaces == 0 ? 0 : static_cast<double>(marked) / static_cast<double>(surfaces);
}

bool IsStill(const Image2& motion) {
  for (int c = 0; c < 2; ++c) {
    for (int y = 0; y < motion.height(); ++y) {
      const float* row = motion[c].Row(y);
      if (std::any_of(row, row + motion.width(), [](float v) { return v != 0; })) {
        return false;
      }
    }
  }
  return true;
}

/// The frames of one run, one after the other, and everything that lives as long as it does.
class DenoiseRun {
 public:
  DenoiseRun(const DenoiseOptions& options, int threads)
      : options_(options),
        threads_(threads),
        fingerprint_(DenoiseFingerprint(options)),
        folder_(std::filesystem::path(options.files.front().output).parent_path().string()) {}

  Status Run();

 private:
  Status Prepare();
  Status Understand();
  void ChooseSettings(const ExrImage& first);
  Status MakeFolder() const;
  Status Resume();
  Status DenoiseFile(size_t at, Progress* progress);
  Status Filter(const Frame& frame, size_t at, DenoisedFrameLog* log);
  Status SaveState();
  Status Stop(const Status& reason);
  Status WriteJson() const;
  void Summarise() const;

  const DenoiseOptions& options_;
  int threads_;
  std::string fingerprint_;
  std::string folder_;
  size_t next_ = 0;  ///< index into the files
  AovLayout layout_;
  Settings settings_;
  std::optional<Denoiser> denoiser_;
  DenoisedFrame denoised_;
  DenoiseLog log_;
  std::array<float, 2> jitter_ = {0, 0};  ///< of the frame before
  bool motion_was_seen_ = false;
  bool saved_ = false;
  Clock::time_point last_save_ = Clock::now();
};

/// Files without motion have no history to speak of; antialiasing in time needs jittered frames,
/// and would soften those of other renderers.
void DenoiseRun::ChooseSettings(const ExrImage& first) {
  settings_ = options_.settings;
  const bool has_motion = layout_.Find(Aov::kMotion) != nullptr;
  if (!has_motion) {
    settings_.temporal = false;
  }
  const auto jitter = first.attributes.find("jitter");
  const bool jittered = jitter != first.attributes.end() && jitter->second != "0 0";
  if (!has_motion || (!jittered && !options_.antialias_given)) {
    settings_.antialias = Antialias::kOff;
  }
}

Status DenoiseRun::Understand() {
  const SequenceFile& first = options_.files.front();
  const Result<LoadedFile> file = Load(first.input);
  if (!file.ok()) {
    return file.status();
  }
  STILLRAY_RETURN_IF_ERROR(CheckMemory(file->image, options_, first.input));
  Result<AovLayout> layout = UnderstandAovs(file->image, options_.text.aovs, first.input);
  if (!layout.ok()) {
    return layout.status();
  }
  layout_ = std::move(layout.value());
  fmt::print(options_.text.json_path == "-" ? stderr : stdout, "{}", AovTable(layout_));
  std::fflush(stdout);
  for (const std::string& note : file->image.notes) {
    fmt::print(stderr, "note: {}\n", note);
  }
  ChooseSettings(file->image);
  return Status::Ok();
}

Status DenoiseRun::MakeFolder() const {
  if (folder_.empty()) {
    return Status::Ok();
  }
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error || !std::filesystem::is_directory(folder_)) {
    return Status::Io(fmt::format("cannot make the folder {}: {}", folder_,
                                  error ? error.message() : "a file of that name exists"));
  }
  return Status::Ok();
}

Status DenoiseRun::Prepare() {
  STILLRAY_RETURN_IF_ERROR(Understand());
  Result<Denoiser> denoiser = Denoiser::Create(settings_);
  if (!denoiser.ok()) {
    return denoiser.status();
  }
  denoiser_.emplace(std::move(denoiser.value()));
  if (settings_.temporal) {
    STILLRAY_RETURN_IF_ERROR(denoiser_->SetOutputs({"disocclusion"}));
  }
  STILLRAY_RETURN_IF_ERROR(MakeFolder());
  return Resume();
}

Status DenoiseRun::Resume() {
  Result<ResumeState> state = LoadResumeState(folder_);
  const bool ours = state.ok() && state->fingerprint == fingerprint_;
  if (!options_.text.resume) {
    if (ours) {
      RemoveResumeState(folder_);
    }
    return Status::Ok();
  }
  if (!state.ok() && state.status().code() == StatusCode::kNotFound) {
    fmt::print(stderr, "note: nothing to resume in {}, starting with frame {}\n",
               folder_.empty() ? "." : folder_, options_.files.front().frame);
    return Status::Ok();
  }
  if (!state.ok()) {
    return state.status();
  }
  if (!ours) {
    return Status::InvalidArgument(
        fmt::format("cannot resume {}: {}", ResumePath(folder_),
                    FingerprintDifference(state->fingerprint, fingerprint_)));
  }
  STILLRAY_RETURN_IF_ERROR(denoiser_->RestoreHistory(state->history));
  Result<DenoiseLog> log = ParseDenoiseLog(state->log);
  if (!log.ok()) {
    return log.status();
  }
  log_ = std::move(log.value());
  while (next_ < options_.files.size() && options_.files[next_].frame <= state->last_frame) {
    ++next_;
  }
  saved_ = true;
  if (next_ > 0 && next_ < options_.files.size()) {
    const std::string& before = options_.files[next_ - 1].input;
    const Result<LoadedFile> file = Load(before);
    if (!file.ok()) {
      return file.status();
    }
    const Result<Frame> frame = ImportFrame(file->image, layout_, jitter_, before);
    if (!frame.ok()) {
      return frame.status();
    }
    jitter_ = {frame->jitter_x, frame->jitter_y};
    fmt::print(stderr, "resuming with frame {}\n", options_.files[next_].frame);
  }
  return Status::Ok();
}

/// Denoises one frame and drops the history where it belongs to something else: behind a gap in the
/// numbers, since motion points to the frame that is missing, and at a cut.
Status DenoiseRun::Filter(const Frame& frame, size_t at, DenoisedFrameLog* log) {
  const bool first = at == 0;
  if (!first && settings_.temporal &&
      options_.files[at].frame != options_.files[at - 1].frame + 1) {
    denoiser_->Reset();
    log->restarted = true;
  }
  STILLRAY_RETURN_IF_ERROR(denoiser_->Denoise(frame, &denoised_));
  log->without_history = settings_.temporal ? PartWithoutHistory(denoised_, frame) : 1.0;
  if (!first && settings_.temporal && !log->restarted && log->without_history > kCut) {
    denoiser_->Reset();
    log->restarted = true;
    STILLRAY_RETURN_IF_ERROR(denoiser_->Denoise(frame, &denoised_));
  }
  return Status::Ok();
}

Status DenoiseRun::DenoiseFile(size_t at, Progress* progress) {
  const SequenceFile& names = options_.files[at];
  DenoisedFrameLog log;
  log.frame = names.frame;
  log.input = names.input;
  log.output = names.output;
  Clock::time_point start = Clock::now();
  const Result<LoadedFile> file = Load(names.input);
  if (!file.ok()) {
    return file.status();
  }
  STILLRAY_RETURN_IF_ERROR(CheckMemory(file->image, options_, names.input));
  Result<Frame> frame = ImportFrame(file->image, layout_, jitter_, names.input);
  if (!frame.ok()) {
    return frame.status();
  }
  frame->index = names.frame;
  jitter_ = {frame->jitter_x, frame->jitter_y};
  motion_was_seen_ = motion_was_seen_ || !IsStill(frame->guides.motion);
  log.read_ms = Milliseconds(start);
  start = Clock::now();
  const Status filtered = Filter(*frame, at, &log);
  if (!filtered.ok()) {
    return Status(filtered.code(), fmt::format("{}: {}", names.input, filtered.message()));
  }
  log.denoise_ms = Milliseconds(start);
  start = Clock::now();
  const Result<std::string> bytes =
      ReplaceLight(file->bytes, layout_, denoised_.colour, names.input);
  if (!bytes.ok()) {
    return bytes.status();
  }
  STILLRAY_RETURN_IF_ERROR(WriteFileAtomically(names.output, bytes->data(), bytes->size()));
  log.write_ms = Milliseconds(start);
  log.missing_light = denoised_.non_finite + denoised_.negative;
  log.bad_guides = denoised_.bad_guides;
  log.stages = denoised_.timings;
  next_ = at + 1;
  progress->Step(static_cast<double>(next_),
                 fmt::format("frame {} ({} of {}): read {:.0f} ms, denoise {:.0f} ms, write {:.0f} "
                             "ms{}",
                             names.frame, next_, options_.files.size(), log.read_ms, log.denoise_ms,
                             log.write_ms, log.restarted ? ", history restarted" : ""));
  if (log.restarted) {
    progress->Clear();
    fmt::print(stderr, "note: frame {}: {}; the history starts again here\n", names.frame,
               log.without_history > kCut && options_.files[at - 1].frame + 1 == names.frame
                   ? "hardly a pixel has a history, a cut"
                   : fmt::format("frames after {} are missing", options_.files[at - 1].frame));
  }
  log_.frames.push_back(std::move(log));
  log_.denoiser_bytes = denoiser_->memory_bytes();
  return Status::Ok();
}

Status DenoiseRun::SaveState() {
  ResumeState state;
  state.fingerprint = fingerprint_;
  state.log = DenoiseLogJson(options_, layout_, settings_, log_, threads_);
  state.last_frame = options_.files[next_ - 1].frame;
  state.history = denoiser_->SaveHistory();
  last_save_ = Clock::now();
  saved_ = true;
  return SaveResumeState(folder_, state);
}

/// Keeps what is done when a frame failed or the user stopped.
Status DenoiseRun::Stop(const Status& reason) {
  if (reason.code() != StatusCode::kCancelled) {
    return reason;
  }
  if (next_ > 0) {
    STILLRAY_RETURN_IF_ERROR(SaveState());
  }
  return Status(StatusCode::kCancelled,
                fmt::format("stopped; {} of {} frames are finished{}", next_, options_.files.size(),
                            next_ > 0 ? ", --resume goes on from here" : ""));
}

Status DenoiseRun::WriteJson() const {
  if (options_.text.json_path.empty()) {
    return Status::Ok();
  }
  const std::string json = DenoiseLogJson(options_, layout_, settings_, log_, threads_);
  const std::string path = options_.text.json_path == "-" ? "/dev/stdout" : options_.text.json_path;
  return WriteFileAtomically(path, json.data(), json.size());
}

void DenoiseRun::Summarise() const {
  int64_t missing = 0;
  int64_t bad_guides = 0;
  for (const DenoisedFrameLog& frame : log_.frames) {
    missing += frame.missing_light;
    bad_guides += frame.bad_guides;
  }
  if (missing > 0) {
    fmt::print(stderr,
               "warning: {} pixels of light were not finite or negative and were left out\n",
               missing);
  }
  if (bad_guides > 0) {
    fmt::print(stderr, "warning: {} pixels had no usable guides and were not filtered\n",
               bad_guides);
  }
  if (layout_.Find(Aov::kMotion) != nullptr && !motion_was_seen_ && log_.frames.size() > 1) {
    fmt::print(stderr,
               "warning: motion is zero in every frame; that is right for a still camera and scene "
               "only (Blender writes zeros where motion blur is on)\n");
  }
  std::FILE* out = options_.text.json_path == "-" ? stderr : stdout;
  if (options_.text.timings) {
    fmt::print(out, "{}", DenoiseTimings(log_));
  }
  fmt::print(out, "{} frames, {} to {}\n", options_.files.size(), options_.files.front().output,
             options_.files.back().output);
}

Status DenoiseRun::Run() {
  STILLRAY_RETURN_IF_ERROR(Prepare());
  {
    Progress progress(static_cast<double>(options_.files.size()), stderr);
    while (next_ < options_.files.size()) {
      const Status done = Interrupted() ? Status::Cancelled() : DenoiseFile(next_, &progress);
      if (!done.ok()) {
        progress.Clear();
        return Stop(done);
      }
      if (Clock::now() - last_save_ > kSaveInterval && next_ < options_.files.size()) {
        STILLRAY_RETURN_IF_ERROR(SaveState());
      }
    }
  }
  STILLRAY_RETURN_IF_ERROR(WriteJson());
  if (saved_) {
    RemoveResumeState(folder_);
  }
  Summarise();
  return Status::Ok();
}

Status RunDenoise(const DenoiseArguments& arguments) {
  Result<DenoiseOptions> options = ParseDenoiseArguments(arguments);
  if (!options.ok()) {
    return options.status();
  }
  const int threads = arguments.threads > 0 ? arguments.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<size_t>(threads));
  SetExrThreads(threads - 1);
  CatchInterrupts();
  return DenoiseRun(*options, threads).Run();
}

constexpr const char* kExamples = R"(
Every file is written again with clean light in place of its colour (Blender: Combined; it is added
where a file has none). All other layers, the metadata and the compression stay as they are. See
docs/renderers.md for what is understood and how to map your own names.

Examples:
  stillray denoise 'shot.####.exr' -o 'clean/shot.####.exr'
  stillray denoise 'shot.%04d.exr' -o clean/ --frames 1-24 --renderer blender --preset svgf
  stillray denoise frames/ -o clean/ --aov normal=N,encoded --aov motion=mv,ndc,from_previous,y_up
  stillray denoise a.0001.exr a.0002.exr -o clean/ --timings --json log.json
  stillray denoise 'shot.####.exr' -o 'clean/shot.####.exr' --resume
)";

}  // namespace

void AddDenoiseCommand(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "denoise", "Denoise a sequence of EXR files of Blender, Arnold or another renderer");
  command->footer(kExamples);
  const auto a = std::make_shared<DenoiseArguments>();
  command
      ->add_option("input", a->inputs,
                   "A pattern (in.####.exr, in.%04d.exr), a folder with one sequence, or files")
      ->required()
      ->take_all();
  command->add_option("-o,--output", a->output, "A pattern, or a folder; made if needed")
      ->required();
  command->add_option("--frames", a->frames, "FIRST-LAST, or one frame; default: all");
  command
      ->add_option("--renderer", a->aovs.renderer,
                   fmt::format("Who named the layers: {}", fmt::join(RendererNames(), ", ")))
      ->capture_default_str();
  command
      ->add_option("--aov", a->aovs.mappings,
                   "A layer by name, as normal=LAYER[,WORD...]; NAME=none for none; repeatable")
      ->allow_extra_args(false)
      ->take_all();
  command->add_option("--preset", a->preset, fmt::format("{}", fmt::join(PresetNames(), ", ")))
      ->capture_default_str();
  command
      ->add_option("--set", a->set,
                   "A parameter of the denoiser as name=value (docs/parameters.md); repeatable. "
                   "antialias is off unless it is set here or the frames are jittered")
      ->allow_extra_args(false)
      ->take_all();
  command->add_option("--threads", a->threads, "Default: all processors")
      ->check(CLI::Range(0, 4096));
  command->add_option("--memory-limit", a->memory_limit,
                      "Refuse frames that take more, such as 8G; default: the machine's memory");
  command->add_flag("--resume", a->resume,
                    "Go on where an interrupted run with the same settings stopped");
  command->add_flag("--timings", a->timings, "Print milliseconds per stage, and memory");
  command->add_option(
      "--json", a->json_path,
      "Write settings, times and what was understood there (- for standard output)");
  command->callback([a, exit_code] {
    const Status status = RunDenoise(*a);
    *exit_code = status.ok() ? kExitOk : ReportError(status);
  });
}

}  // namespace stillray

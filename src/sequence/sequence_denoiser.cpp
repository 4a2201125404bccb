// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/sequence_denoiser.h"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "core/cameras.h"
#include "io/aov_seen.h"
#include "sequence/memory.h"
#include "sequence/settings.h"
#include "stillray/io.h"

namespace stillray {

const char* WindowName(Window window) {
  return window == Window::kBoth ? "both" : "past";
}

bool SequenceOptions::IsFixed(std::string_view parameter) const {
  return std::find(fixed_parameters.begin(), fixed_parameters.end(), parameter) !=
         fixed_parameters.end();
}

namespace {

Status CheckFiles(const std::vector<SequenceFile>& files) {
  if (files.empty()) {
    return Status::InvalidArgument("a sequence has no files, expected one or more");
  }
  for (size_t i = 1; i < files.size(); ++i) {
    if (files[i].frame <= files[i - 1].frame) {
      return Status::InvalidArgument(
          fmt::format("frame {} comes after frame {}, expected rising "
                      "frames",
                      files[i].frame, files[i - 1].frame));
    }
    const auto folder = [](const SequenceFile& file) {
      return std::filesystem::path(file.output).parent_path();
    };
    if (folder(files[i]) != folder(files[0])) {
      return Status::InvalidArgument(
          fmt::format("{} and {} lie in two folders, expected one for "
                      "all outputs",
                      files[0].output, files[i].output));
    }
  }
  return Status::Ok();
}

}  // namespace

using Impl = SequenceDenoiser::Impl;

Impl::Impl(const SequenceOptions& chosen, const SequenceHooks& calls)
    : options(chosen), hooks(calls) {
  const std::filesystem::path output(options.files.front().output);
  folder = output.parent_path().string();
  key = "denoise to " + output.filename().string();
}

void Impl::Note(const std::string& text) const {
  if (hooks.note) {
    hooks.note(text);
  }
}

void Impl::NarrowWindow(const std::string& why) {
  options.window = Window::kPast;
  Note("--window past: " + why);
}

/// The origin of motion replaces the layout's note about motion.
Status Impl::ChooseMotion(const ExrImage& first) {
  Result<MotionPlan> plan = PlanMotion(options, layout, first);
  STILLRAY_RETURN_IF_ERROR(plan.status());
  motion = std::move(plan.value());
  if (!motion.note.empty()) {
    std::erase_if(layout.notes,
                  [](const std::string& note) { return note.starts_with("no motion: "); });
    layout.notes.insert(layout.notes.begin(), motion.note);
  }
  if (const auto camera = CameraOfFrame(motion, options.files.front(), first);
      camera.ok() && *camera && HasPerspective(**camera, first.width, first.height)) {
    io::NoteSeenGuidesOfKnownCamera(first, &layout);
  }
  noted_images = io::IsNotedInLayout(layout);
  return Status::Ok();
}

/// Once, for the first frame with zero motion although its guides move.
void Impl::NoteDerivedMotion(const FrameReport& report) {
  const bool derived = report.motion == "camera" || report.motion == "estimate";
  if (!motion.from_file || !derived || noted_motion) {
    return;
  }
  noted_motion = true;
  Note(fmt::format("frame {}: motion is zero in the file; it is {} (--motion file: used as it is)",
                   report.frame,
                   motion.from_cameras ? "derived from the cameras and the guides"
                                       : "estimated from the guides"));
}

/// Once, unless the notes on the first file already include it.
void Impl::NoteMissingImages(const FrameReport& report) {
  if (!report.images_missing.empty() && !noted_images) {
    noted_images = true;
    Note(fmt::format("frame {}: {}", report.frame, report.images_missing));
  }
}

void Impl::NoteAntialiasing(const ExrImage& first) const {
  if (settings.antialias == Antialias::kTaa && !options.IsFixed("antialias")) {
    Note(fmt::format(
        "edges and textures are means over few samples: frames are antialiased in time, "
        "a new one counts for {:.2f} (antialias=off: not)",
        settings.taa_alpha));
  } else if (HasJaggedEdges(options, layout, first, motion.has_motion())) {
    Note(
        "all rays go through the centres of the pixels: edges are jagged "
        "(--set antialias=taa: smooth where the picture moves)");
  }
}

Status Impl::ReadFirstFile() {
  const std::string& path = options.files.front().input;
  Result<LoadedFile> file = LoadFile(path, options, false);
  if (file.status().code() == StatusCode::kOutOfMemory && options.window_may_narrow &&
      options.window == Window::kBoth) {
    const std::string why = file.status().message();
    options.window = Window::kPast;
    file = LoadFile(path, options, false);
    if (file.ok()) {
      NarrowWindow(why);
    }
  }
  STILLRAY_RETURN_IF_ERROR(file.status());
  Result<AovLayout> understood = UnderstandAovs(file->image, options.aovs, path);
  STILLRAY_RETURN_IF_ERROR(understood.status());
  layout = std::move(understood.value());
  STILLRAY_RETURN_IF_ERROR(ChooseMotion(file->image));
  for (const std::string& note : file->image.notes) {
    Note(note);
  }
  settings = SettingsFor(options, layout, file->image, motion.has_motion());
  NoteAntialiasing(file->image);
  const Result<int> samples = SamplesFor(options, layout, file->image, settings);
  STILLRAY_RETURN_IF_ERROR(samples.status());
  layout.samples = std::max(*samples, 1);
  if (*samples > 1 && options.spp == 0) {
    Note(
        fmt::format("the file states {} samples per pixel (--aov samples=none: each frame counts "
                    "as one)",
                    *samples));
  } else if (*samples == 0 && layout.renderer != "stillray") {
    Note("the file does not state its samples per pixel: each frame counts as one (--spp N: as N)");
  }
  if (options.passes) {
    STILLRAY_RETURN_IF_ERROR(PassSplitter::Check(settings, layout));
  }
  if (options.denoise_alpha && layout.Find(Aov::kAlpha) == nullptr) {
    return Status::InvalidArgument(
        fmt::format("--alpha denoise: {} has no alpha beside its picture", path));
  }
  if (options.window == Window::kBoth && !settings.temporal) {
    NarrowWindow("without history there is no future either");
  }
  extent = file->extent;
  return Status::Ok();
}

/// Memory for overlap is optional: without it frames are processed sequentially.
void Impl::ChooseOverlap() {
  const Status fits = options.overlap ? OverlapFits(extent, options) : Status::Ok();
  if (!fits.ok()) {
    options.overlap = false;
    Note("files are not read and written beside the filter: " + fits.message());
  }
}

Status Impl::ChooseFutures(size_t* held) {
  if (options.window == Window::kBoth) {
    const Result<size_t> fit = FuturesThatFit(extent, options, options.files.front().input);
    STILLRAY_RETURN_IF_ERROR(fit.status());
    *held = *fit;
  }
  return Status::Ok();
}

Status Impl::Prepare(const OpenDevice& open) {
  TakeWindowOfResumedRun();
  STILLRAY_RETURN_IF_ERROR(ReadFirstFile());
  const Result<Device> device = open();
  STILLRAY_RETURN_IF_ERROR(device.status());
  ChooseOverlap();
  STILLRAY_RETURN_IF_ERROR(ChooseFutures(&futures_held));
  if (options.window == Window::kBoth && motion.estimates && MotionFits(extent, options)) {
    cache.emplace(kLinkedFrames);
  }
  filter.emplace(View(), settings);
  STILLRAY_RETURN_IF_ERROR(
      filter->Prepare(*device, futures_held, options.overlap,
                      [this](const SequenceFile& file) { return LookAhead(file); }));
  fingerprint = Fingerprint(*device);
  return options.state.keep ? Resume() : Status::Ok();
}

Status Impl::LookAhead(const SequenceFile& file) {
  if (hooks.keep_going && !hooks.keep_going()) {
    return Status::Cancelled();
  }
  STILLRAY_RETURN_IF_ERROR(loop->Poll());
  if (hooks.looks_ahead) {
    hooks.looks_ahead(file);
  }
  return Status::Ok();
}

void Impl::ReportFallBack() {
  if (!fell_back && !filter->remark().empty()) {
    fell_back = true;
    if (hooks.fell_back) {
      hooks.fell_back(filter->remark());
    }
  }
}

Status Impl::ApplyEffects(const SequenceFile& file, const SequenceFrame& frame,
                          Picture* picture) const {
  if (!hooks.effects) {
    return Status::Ok();
  }
  const Clock::time_point start = Clock::now();
  const Status status = hooks.effects(file, frame.frame, frame.focal_pixels, &picture->colour);
  picture->report.stages.push_back({"effects", MillisecondsSince(start)});
  return status.ok() ? status : Status(status.code(), file.input + ": " + status.message());
}

Status Impl::Make(size_t at, Picture* picture) {
  const SequenceFile& names = options.files[at];
  ReadFrame read = reader->Next();
  STILLRAY_RETURN_IF_ERROR(read.frame.status());
  SequenceFrame& frame = *read.frame;
  *picture = Picture();
  picture->names = &names;
  const bool in_history = !waiting.empty();
  if (in_history) {
    TakeFirstWaiting(picture);
  }
  FrameReport& report = picture->report;
  report.frame = names.frame;
  report.input = names.input;
  report.output = names.output;
  report.read_ms = read.milliseconds;
  picture->bytes = std::move(frame.bytes);
  picture->stored = std::move(frame.stored);
  if (in_history) {
    filter->Skip(std::move(frame));
  } else {
    const Result<FinishedFile> input = LookAtFile("", names.input);
    STILLRAY_RETURN_IF_ERROR(input.status());
    const Status filtered = filter->Filter(&frame, at, &report, &picture->colour, &picture->layers);
    ReportFallBack();
    STILLRAY_RETURN_IF_ERROR(filtered);
    STILLRAY_RETURN_IF_ERROR(ApplyEffects(names, frame, picture));
    inputs.push_back(*input);
    filter->SetPrevious(std::move(frame));
  }
  made = at + 1;
  most_memory = std::max(most_memory, filter->memory_bytes());
  return Status::Ok();
}

Status Impl::Write(Picture* picture) {
  const SequenceFile& names = *picture->names;
  const Result<std::string> bytes =
      ReplaceLight(picture->bytes, layout, picture->colour, names.input, picture->layers,
                   std::move(picture->stored));
  STILLRAY_RETURN_IF_ERROR(bytes.status());
  picture->report.written_bytes = static_cast<int64_t>(bytes->size());
  // Written last, so that its existence implies a complete frame.
  if (hooks.picture) {
    STILLRAY_RETURN_IF_ERROR(hooks.picture(names, picture->colour));
  }
  return WriteFileAtomically(names.output, bytes->data(), bytes->size());
}

Status Impl::Finish(Picture* picture, const WriteResult& written) {
  FrameReport& report = picture->report;
  NoteDerivedMotion(report);
  NoteMissingImages(report);
  if (!report.note.empty()) {
    Note(fmt::format("frame {}: {}; the history starts again here", report.frame, report.note));
  }
  STILLRAY_RETURN_IF_ERROR(written.status);
  STILLRAY_RETURN_IF_ERROR(AddFinishedFiles(folder, {report.output}, &outputs));
  report.write_ms = written.milliseconds;
  report.elapsed_ms = std::chrono::duration<double, std::milli>(written.end - last_end).count();
  last_end = written.end;
  ++finished;
  if (hooks.finished) {
    hooks.finished(report);
  }
  reports.push_back(std::move(report));
  *picture = Picture();  // frees memory while the next frame is made
  return Status::Ok();
}

SequenceEnd Impl::Run() {
  if (has_old_state) {
    RemoveResumeState(folder, key);
  }
  const size_t files = options.files.size();
  std::vector<size_t> order(files - finished);
  std::iota(order.begin(), order.end(), finished);
  reader.emplace(View(), std::move(order), true, options.overlap);
  last_end = Clock::now();
  LoopOptions loop_options;
  loop_options.begin = finished;
  loop_options.end = files;
  loop_options.overlap = options.overlap;
  loop_options.keep_going = hooks.keep_going;
  FrameLoop<Impl> frames(this, std::move(loop_options));
  loop = &frames;
  const LoopEnd ended = frames.Run();
  loop = nullptr;
  SequenceEnd end;
  end.status = ended.status;
  end.save_status = ended.save_status;
  end.can_resume = saved_at.has_value();
  end.resumes_at = saved_at.value_or(0);
  return end;
}

SequenceDenoiser::SequenceDenoiser(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SequenceDenoiser::SequenceDenoiser(SequenceDenoiser&&) noexcept = default;
SequenceDenoiser& SequenceDenoiser::operator=(SequenceDenoiser&&) noexcept = default;
SequenceDenoiser::~SequenceDenoiser() = default;

Result<SequenceDenoiser> SequenceDenoiser::Create(const SequenceOptions& options,
                                                  const Device& device,
                                                  const SequenceHooks& hooks) {
  const OpenDevice open = [&]() -> Result<Device> { return device; };
  return Create(options, open, hooks);
}

Result<SequenceDenoiser> SequenceDenoiser::Create(const SequenceOptions& options,
                                                  const OpenDevice& open,
                                                  const SequenceHooks& hooks) {
  STILLRAY_RETURN_IF_ERROR(CheckFiles(options.files));
  auto impl = std::make_unique<Impl>(options, hooks);
  STILLRAY_RETURN_IF_ERROR(impl->Prepare(open));
  return SequenceDenoiser(std::move(impl));
}

const SequenceOptions& SequenceDenoiser::options() const {
  return impl_->options;
}

const AovLayout& SequenceDenoiser::layout() const {
  return impl_->layout;
}

const Settings& SequenceDenoiser::settings() const {
  return impl_->settings;
}

const ExrExtent& SequenceDenoiser::extent() const {
  return impl_->extent;
}

bool SequenceDenoiser::resumed() const {
  return impl_->resumed;
}

size_t SequenceDenoiser::finished() const {
  return impl_->finished;
}

size_t SequenceDenoiser::look_ahead_steps() const {
  return impl_->filter->has_future()
             ? CountBackwardFrames(impl_->filter->frames(), impl_->options.files.size(),
                                   impl_->futures_held)
             : 0;
}

SequenceEnd SequenceDenoiser::Run() {
  return impl_->Run();
}

void SequenceDenoiser::RemoveState() {
  impl_->RemoveState();
}

const std::vector<FrameReport>& SequenceDenoiser::reports() const {
  return impl_->reports;
}

bool SequenceDenoiser::derives_motion() const {
  return impl_->motion.derives();
}

bool SequenceDenoiser::motion_was_seen() const {
  return impl_->filter->motion_was_seen();
}

size_t SequenceDenoiser::memory_bytes() const {
  return impl_->most_memory;
}

DeviceMemory SequenceDenoiser::device_memory() const {
  return impl_->filter->device_memory();
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_engine.h"

#include <algorithm>
#include <exception>
#include <new>

#include <fmt/format.h>

#include "core/clock.h"
#include "core/lower_case.h"
#include "view/background.h"
#include "view/split.h"

namespace stillray::view {
namespace {

/// Samples per pixel at which a static view is finished: further samples would not be visible.
constexpr double kEnoughSamples = 4096;
constexpr int kEnoughReference = 16384;
/// Minimum samples of the reference for metrics: with fewer, its noise would dominate them.
constexpr int kMeasurableReference = 16;

/// Runs work that may throw std::bad_alloc, and returns a Status.
template <typename Body>
Status Guarded(const char* what, const Body& body) {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format("{}: out of memory", what));
  } catch (const std::exception& error) {
    return Status::Internal(fmt::format("{}: {}", what, error.what()));
  }
}

void AddLayer(const std::string& name, const std::vector<Image1>& values, bool main,
              ExrImage* image) {
  // Three channels are colours (or axes), two are x and y, one is a scalar.
  for (size_t c = 0; c < values.size(); ++c) {
    const char letter = values.size() == 3 ? "RGB"[c] : "XY"[std::min<size_t>(c, 1)];
    if (main) {
      image->Add(std::string(1, "RGB"[c]), PixelType::kFloat, values[c]);
    } else {
      image->Add(fmt::format("{}.{}", name, letter), PixelType::kFloat, values[c]);
    }
  }
}

}  // namespace

ViewEngine::ViewEngine(const ViewSettings& settings, std::function<void()> wake,
                       const RenderDevices& devices)
    : wake_(std::move(wake)),
      settings_(settings),
      devices_(devices),
      loader_([this](bool finished) {
        if (finished) {
          {
            const std::lock_guard lock(mutex_);
            scene_waiting_ = true;
          }
          work_.notify_all();
        }
        wake_();
      }) {
  worker_ = std::thread([this] { WorkLoop(); });
}

ViewEngine::~ViewEngine() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  work_.notify_all();
  worker_.join();
}

void ViewEngine::Open(const SceneRequest& request) {
  ViewSettings settings;
  Device tracer;
  {
    const std::lock_guard lock(mutex_);
    settings = settings_;
    tracer = devices_.tracer;
  }
  loader_.Load(request, settings, tracer);
}

uint64_t ViewEngine::Post(const ViewSettings& settings) {
  ViewSettings copy = settings;
  uint64_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    std::swap(settings_, copy);
    number = ++posted_;
  }
  work_.notify_all();
  return number;
}

std::vector<EngineMessage> ViewEngine::TakeMessages() {
  const std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

SceneInfo ViewEngine::scene_info() const {
  const std::lock_guard lock(mutex_);
  return scene_info_;
}

void ViewEngine::Tell(bool is_error, std::string text) {
  {
    const std::lock_guard lock(mutex_);
    messages_.push_back({is_error, std::move(text)});
  }
  wake_();
}

void ViewEngine::AddJob(Job job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  work_.notify_all();
}

bool ViewEngine::WaitForWork() {
  std::unique_lock lock(mutex_);
  work_.wait(lock, [&] {
    const bool frames_to_make = session_ && (!idle_ || posted_ != last_posted_);
    return stop_ || scene_waiting_ || !jobs_.empty() || frames_to_make;
  });
  return !stop_;
}

void ViewEngine::WorkLoop() {
  const BackgroundWork background;
  while (WaitForWork()) {
    TakeLoadedScene();
    RunJobs();
    if (session_ && (!idle_ || posted_ != last_posted_)) {
      const Status status = Guarded("making a frame", [this] {
        MakeFrame();
        return Status::Ok();
      });
      if (!status.ok()) {
        idle_ = true;
        Tell(true, status.message());
      }
    }
  }
  EndClip();
}

void ViewEngine::TakeLoadedScene() {
  scene_waiting_ = false;
  std::optional<SceneLoader::Outcome> outcome = loader_.Take();
  if (!outcome) {
    return;
  }
  if (!outcome->status.ok()) {
    Tell(true, outcome->status.message());
    return;
  }
  EndClip();
  session_.reset();  // frees the memory of the previous scene first
  RenderDevices devices;
  {
    const std::lock_guard lock(mutex_);
    devices = devices_;
  }
  session_ = std::make_unique<ViewSession>(std::move(*outcome->scene), devices);
  metrics_.Forget();
  idle_ = false;
  shown_ = {};
  const Scene& scene = session_->scene();
  SceneInfo info;
  info.request = session_->request();
  info.warnings = scene.warnings;
  info.triangles = scene.TriangleCount();
  info.length = scene.AnimationLength();
  info.moving_lights = session_->has_moving_lights();
  for (const Camera& camera : scene.cameras) {
    info.cameras.push_back(camera.name);
  }
  const std::lock_guard lock(mutex_);
  info.number = scene_info_.number + 1;
  std::swap(scene_info_, info);
}

void ViewEngine::RunJobs() {
  std::deque<Job> jobs;
  {
    const std::lock_guard lock(mutex_);
    jobs.swap(jobs_);
  }
  for (const Job& job : jobs) {
    job();
  }
}

bool ViewEngine::IsDone(const ViewSettings& settings, const ViewFrame& frame) const {
  const bool reference_done =
      !settings.reference || session_->reference().spp() >= kEnoughReference;
  const bool moving = settings.playing && frame.length > 0 &&
                      (settings.speed != 0 || (settings.light_speed.value_or(0) != 0));
  return frame.still && !moving && !clip_ && frame.samples >= kEnoughSamples && reference_done;
}

void ViewEngine::MakeFrame() {
  ViewSettings settings;
  {
    const std::lock_guard lock(mutex_);
    settings = settings_;
    last_posted_ = posted_;
    settings.revision = last_posted_;
    // A pose of the previous scene is not valid for this one.
    settings.free_camera = settings.free_camera && settings.pose_scene == scene_info_.number;
  }
  if (clip_) {
    // A video has a constant size, and a constant time step independent of frame times.
    settings.wall_clock = false;
    settings.auto_scale = false;
    settings.shares_pictures = false;  // host pixels are required
  }
  const double now = SecondsNow();
  const double elapsed = now - last_frame_at_;
  last_frame_at_ = now;
  ViewFrame& frame = frames_.back();
  const Status status = session_->RenderNext(
      settings, elapsed,
      [this](double) {
        const bool in_the_way = session_->refines() && posted_ != last_posted_;
        return !stop_ && !scene_waiting_ && !in_the_way;
      },
      &frame);
  if (!status.ok()) {
    if (status.code() != StatusCode::kCancelled) {
      idle_ = true;
      Tell(true, status.message());
    }
    return;
  }
  if (!frame.note.empty()) {
    Tell(true, frame.note);
    const std::lock_guard lock(mutex_);
    devices_ = session_->devices();
  }
  idle_ = IsDone(settings, frame);
  if (!frame.still || frame.samples <= frame.rate.value()) {
    metrics_.Forget();  // results of a different view or history
  }
  frame.measures = metrics_.latest();
  frame.posted = last_posted_;
  dividers_ = settings.dividers;
  area_width_ = settings.width;
  area_height_ = settings.height;
  sharp_pixels_ = settings.sharp_pixels;
  shown_ = frame.pictures;
  shown_panes_ = frame.panes;
  RecordFrame(frame);
  frames_made_ = frame.number;
  frames_.Publish();
  wake_();
  if (session_->WantsReference()) {
    // User input has priority.
    const Status refined = session_->RefineReference(
        [this](double) { return !stop_ && !scene_waiting_ && posted_ == last_posted_; });
    if (!refined.ok() && refined.code() != StatusCode::kCancelled) {
      Tell(true, refined.message());
    }
    const ReferenceAccumulator& reference = session_->reference();
    const Result<const Image3*> denoised = session_->Denoised();
    if (denoised.ok() && reference.spp() >= kMeasurableReference) {
      metrics_.Offer(**denoised, session_->noisy(), *reference.picture(), reference.spp());
    }
  }
}

void ViewEngine::Save(const std::string& path) {
  SaveFile(path, [this, path] { return SaveNow(path); });
}

void ViewEngine::SaveFile(const std::string& path, std::function<Status()> job) {
  AddJob([this, path, job = std::move(job)] {
    const Status status = Guarded("saving", job);
    Tell(!status.ok(), status.ok() ? "saved " + path : status.message());
  });
}

/// Composes all panes side by side, as in the window.
Result<Rgb8Image> ViewEngine::ShownPicture() const {
  std::vector<Rgb8Image> pictures = shown_;
  for (Rgb8Image& picture : pictures) {
    if (picture.pixels.empty()) {
      Result<Rgb8Image> made = session_->FinishedPicture();
      STILLRAY_RETURN_IF_ERROR(made.status());
      picture = std::move(made.value());
    }
  }
  return AsOnScreen(pictures);
}

Rgb8Image ViewEngine::AsOnScreen(const std::vector<Rgb8Image>& pictures) const {
  std::vector<Rgb8Image> large;
  for (const Rgb8Image& picture : pictures) {
    large.push_back(EnlargedTo(area_width_, area_height_, sharp_pixels_, picture));
  }
  return ComposePanes(large, dividers_);
}

/// Saves the colour of the first colour view.
Status ViewEngine::SaveRadiance(const std::string& path) const {
  for (const std::string& pane : shown_panes_) {
    Result<std::vector<Image1>> values = session_->Values(pane);
    if (values.ok() && values->size() == 3) {
      Image3 colour;
      for (size_t c = 0; c < 3; ++c) {
        colour[static_cast<int>(c)] = std::move((*values)[c]);
      }
      return WriteHdr(path, colour);
    }
  }
  return Status::InvalidArgument(fmt::format(
      "'{}' would hold a colour, and no view shows one; expected .exr, which holds any numbers",
      path));
}

Status ViewEngine::SaveNow(const std::string& path) const {
  if (shown_.empty()) {
    return Status::NotFound("there is no picture to save yet");
  }
  const std::string extension = LowerExtension(path);
  if (extension == ".png") {
    const Result<Rgb8Image> picture = ShownPicture();
    return picture.ok() ? WritePng(path, *picture) : picture.status();
  }
  if (extension == ".jpg" || extension == ".jpeg") {
    const Result<Rgb8Image> picture = ShownPicture();
    return picture.ok() ? WriteJpeg(path, *picture) : picture.status();
  }
  if (extension == ".hdr") {
    return SaveRadiance(path);
  }
  if (extension != ".exr") {
    return Status::InvalidArgument(
        fmt::format("'{}' ends in '{}', expected .png, .jpg, .exr or .hdr", path, extension));
  }
  ExrImage image;
  image.width = shown_[0].width;
  image.height = shown_[0].height;
  for (size_t i = 0; i < shown_panes_.size(); ++i) {
    Result<std::vector<Image1>> values = session_->Values(shown_panes_[i]);
    if (!values.ok()) {
      return values.status();
    }
    const bool main = i == 0 && values->size() == 3;
    const bool seen =
        std::find(shown_panes_.begin(), shown_panes_.begin() + static_cast<ptrdiff_t>(i),
                  shown_panes_[i]) != shown_panes_.begin() + static_cast<ptrdiff_t>(i);
    if (!seen) {
      AddLayer(shown_panes_[i], values.value(), main, &image);
    }
  }
  return WriteExr(path, image);
}

void ViewEngine::StartClip(const std::string& path, double fps) {
  AddJob([this, path, fps] {
    EndClip();
    if (shown_.empty()) {
      Tell(true, "there is no picture to record yet");
      return;
    }
    Result<std::unique_ptr<VideoWriter>> writer =
        VideoWriter::Create(path, std::max(area_width_, shown_[0].width),
                            std::max(area_height_, shown_[0].height), fps);
    if (!writer.ok()) {
      Tell(true, writer.status().message());
      return;
    }
    clip_ = std::move(writer.value());
    clip_path_ = path;
    recording_ = true;
    idle_ = false;
    wake_();
  });
}

void ViewEngine::StopClip() {
  AddJob([this] { EndClip(); });
}

void ViewEngine::RecordFrame(const ViewFrame& frame) {
  if (!clip_) {
    return;
  }
  const Status status = clip_->Write(AsOnScreen(shown_));
  if (!status.ok()) {
    Tell(true, fmt::format("the clip ends at frame {}: {}", frame.number, status.message()));
    EndClip();
  }
}

void ViewEngine::EndClip() {
  if (!clip_) {
    return;
  }
  const Status status = clip_->Finish();
  clip_.reset();
  recording_ = false;
  Tell(!status.ok(), status.ok() ? "saved " + clip_path_ : status.message());
}

}  // namespace stillray::view

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_session.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include "common/trace_ahead.h"
#include "core/clock.h"
#include "denoise/plan.h"
#include "view/exact_accumulation.h"
#include "view/history_seed.h"

namespace stillray::view {
namespace {

/// Maximum time step in seconds: after a pause (another window, a slow frame) animations continue
/// where they stopped.
constexpr double kLongestStep = 0.25;
/// Number of first frames that fill caches and memory pages, whose times are ignored.
constexpr uint64_t kFirstFrames = 2;
/// Weight in samples of the displayed image when it becomes the history of a filter: half of the
/// maximum history length, so that new samples soon become visible.
constexpr float kSeedSamples = 8;

/// Whether two poses give the same view; the orbit centre is ignored.
bool SameView(const ViewPose& a, const ViewPose& b) {
  return a.position == b.position && a.yaw == b.yaw && a.pitch == b.pitch && a.roll == b.roll &&
         a.yfov == b.yfov;
}

bool SameScene(const ViewSettings& a, const ViewSettings& b) {
  return SameLight(a.render, b.render) && a.restart == b.restart;
}

/// Whether a frame traced with settings `a` can be used for `b`.
/// \param moving  the pose may lag by one frame
bool TracesTheSame(const ViewSettings& a, ViewSettings b, bool moving) {
  if (moving) {
    b.pose = a.pose;
    b.revision = a.revision;
  }
  b.dividers = a.dividers;
  b.sharp_pixels = a.sharp_pixels;
  b.inspect_x = a.inspect_x;
  b.inspect_y = a.inspect_y;
  b.focus = a.focus;
  b.focus_x = a.focus_x;
  b.focus_y = a.focus_y;
  return a == b;
}

bool HasSparseGuides(const ViewSettings& s) {
  return s.render.guides == GuideCoverage::kSparse && s.rate.cycle > 1;
}

double Wrapped(double seconds, double length) {
  const double wrapped = std::fmod(seconds, length);
  return wrapped < 0 ? wrapped + length : wrapped;
}

}  // namespace

/// A frame that is traced while the previous one is filtered.
struct ViewSession::Ahead {
  ViewSettings requested;  ///< settings of the caller for the last frame
  NextFrame next;
  Frame frame;
  Tracing tracing;
  TraceAhead thread;  ///< last member: ends before its data is freed
};

ViewSession::ViewSession(LoadedScene loaded, const RenderDevices& devices)
    : loaded_(std::move(loaded)), animation_(loaded_.scene.get()), devices_(devices) {
  length_ = loaded_.scene->AnimationLength();
  bounds_ = SceneBounds(*loaded_.scene, 0);
}

ViewSession::~ViewSession() = default;
ViewSession::ViewSession(ViewSession&&) noexcept = default;

AnimationTime ViewSession::NextTime(const ViewSettings& s, double elapsed) const {
  if (s.seek != settings_.seek) {
    const double at = std::clamp(s.seek_seconds, 0.0, std::max(length_, 0.0));
    return {at, at};
  }
  if (!s.playing || frames_ == 0 || length_ <= 0) {
    return moment_.time;
  }
  const double step = s.wall_clock ? std::clamp(elapsed, 0.0, kLongestStep) : 1 / s.fps;
  return {Wrapped(moment_.time.all + step * s.speed, length_),
          Wrapped(moment_.time.lights + step * s.light_speed.value_or(s.speed), length_)};
}

/// Angle of the camera on its orbit in degrees.
double ViewSession::NextOrbit(const ViewSettings& s, double elapsed) const {
  if (!s.orbiting || frames_ == 0) {
    return 0;
  }
  const double step = s.wall_clock ? std::clamp(elapsed, 0.0, kLongestStep) : 1 / s.fps;
  return std::remainder(moment_.orbit_degrees + step * s.orbit_speed, 360.0);
}

ViewSession::Moment ViewSession::NextMoment(const ViewSettings& s, double elapsed) {
  Moment next;
  const bool first = frames_ == 0;
  next.render.frame_index = static_cast<int64_t>(frames_);
  next.time = NextTime(s, elapsed);
  const int count = static_cast<int>(loaded_.scene->cameras.size());
  next.render.camera = std::clamp(s.camera, 0, count - 1);
  animation_.Set(next.time, first ? next.time : moment_.time, &next.render.seconds,
                 &next.render.previous_seconds);
  next.pose = s.free_camera
                  ? s.pose
                  : FilePose(animation_.original(), bounds_, next.render.camera, next.time.all);
  if (s.orbiting) {
    next.orbit_degrees = NextOrbit(s, elapsed);
    next.pose = OnOrbit(next.pose, next.orbit_degrees * std::numbers::pi / 180, s.orbit_radius);
  }
  next.render.pose = CameraPose{ToMatrix(next.pose), next.pose.yfov};
  next.render.previous_pose = first ? next.render.pose : moment_.render.pose;
  return next;
}

/// Switches to the CPU, with a note, if another device failed. Errors of settings or frames would
/// also occur on the CPU.
bool ViewSession::FallsBack(const Status& status) {
  if (status.ok() || devices_.filter.is_cpu() || status.code() == StatusCode::kInvalidArgument) {
    return false;
  }
  Note("filtering goes on on the CPU: " + status.message());
  denoiser_.reset();
  devices_ = devices_.differ() ? RenderDevices(Device(), devices_.tracer) : RenderDevices();
  return true;
}

void ViewSession::Note(const std::string& what) {
  note_ += (note_.empty() ? "" : "; ") + what;
}

Status ViewSession::MakeDenoiser(const Settings& settings) {
  Result<Denoiser> denoiser = Denoiser::Create(settings, devices_.filter);
  if (FallsBack(denoiser.status())) {
    denoiser = Denoiser::Create(settings);
  }
  STILLRAY_RETURN_IF_ERROR(denoiser.status());
  denoiser_.emplace(std::move(denoiser.value()));
  return Status::Ok();
}

Status ViewSession::PrepareDenoiser(const ViewSettings& s) {
  shown_.ListViewsOf(s.denoise);
  const Status kept = denoiser_ ? denoiser_->SetSettings(s.denoise) : Status::Ok();
  if (!denoiser_ || FallsBack(kept)) {
    STILLRAY_RETURN_IF_ERROR(MakeDenoiser(s.denoise));
  } else {
    STILLRAY_RETURN_IF_ERROR(kept);
  }
  return AskForOutputs(s);
}

/// Requests the required results of the filter for the next frame.
Status ViewSession::AskForOutputs(const ViewSettings& s) {
  denoiser_->SetResults(shown_.WantedResults(s));
  return denoiser_->SetOutputs(shown_.WantedOutputs(s));
}

/// Whether settings may be replaced: not if views of intermediate data or the inspector are shown.
bool ViewSession::MayReplaceSettings(const ViewSettings& s) const {
  const bool plain = std::all_of(s.panes.begin(), s.panes.end(), [](const std::string& name) {
    return name == "denoised" || name == "noisy" || name == "reference";
  });
  return plain && !s.inspect && s.denoise.temporal;
}

/// The faster filter provides the finished image, but other intermediate images and sparse guides.
/// Settings without a wavelet, or without history, are not replaced.
bool ViewSession::AllowsFastFilter(const ViewSettings& s) const {
  return s.fast_filter && MayReplaceSettings(s) && s.denoise.wavelet != Wavelet::kOff;
}

FramePlan ViewSession::PlanFrame(const ViewSettings& s, bool moves, RateControl* control) const {
  RateChoice choice;
  choice.rate = s.rate;
  choice.auto_rate = s.auto_rate;
  choice.scale = s.scale;
  choice.auto_scale = s.auto_scale;
  choice.fast_filter = AllowsFastFilter(s);
  choice.target_ms = s.target_ms;
  return control->Next(choice, moves, s.revision != settings_.revision);
}

/// The settings modified by the plan.
ViewSettings ViewSession::Planned(ViewSettings s, const FramePlan& plan) const {
  s.rate = plan.rate;
  if (plan.fast_filter) {
    Settings fast = PresetSettings("psvgf").value();
    fast.exposure = s.denoise.exposure;
    fast.tonemap = s.denoise.tonemap;
    s.denoise = fast;
    s.render.guides = GuideCoverage::kSparse;
  }
  if (plan.still && s.still_converges && MayReplaceSettings(s)) {
    s.denoise = WithEqualWeights(s.denoise);
  }
  return s;
}

/// Plans the frame after the last one.
ViewSession::NextFrame ViewSession::PlanNext(const ViewSettings& settings, double elapsed,
                                             RateControl* control) {
  NextFrame next;
  next.elapsed = std::clamp(elapsed + owed_, 0.0, kLongestStep);
  next.moment = NextMoment(settings, next.elapsed);
  next.moved = frames_ == 0 || !SameView(next.moment.pose, moment_.pose) ||
               !(next.moment.time == moment_.time) || !SameScene(settings, settings_) ||
               settings.width != settings_.width || settings.height != settings_.height;
  next.plan = PlanFrame(settings, next.moved, control);
  next.settings = Planned(settings, next.plan);
  next.loses_history = LosesHistory(next);
  // Sample numbers depend on the rate: after a change, numbers would recur.
  const bool rate_changes = frames_ > 0 && !(next.settings.rate == settings_.rate);
  next.rate_changes = rate_changes_ + (rate_changes ? 1 : 0);
  return next;
}

RenderSettings ViewSession::RendererSettings(const NextFrame& next) const {
  RenderSettings wanted = RenderSettingsFor(next.settings, next.plan.rate, next.plan.scale);
  wanted.on_device = !devices_.filter.is_cpu() && !devices_.differ();
  return wanted;
}

/// Whether the filter loses its history, due to changed signals or size.
bool ViewSession::LosesHistory(const NextFrame& next) const {
  const ViewSettings& s = next.settings;
  int width = 0;
  int height = 0;
  PictureSize(s, next.plan.scale, &width, &height);
  return frames_ == 0 || width != frame_.width || height != frame_.height ||
         s.restart != settings_.restart || NeedsNewHistory(settings_.denoise, s.denoise) ||
         (s.denoise.temporal && !settings_.denoise.temporal);
}

/// Whether the displayed image can replace the lost history: the filter has a single signal, and
/// the view is unchanged.
bool ViewSession::CanSeed(const NextFrame& next) const {
  const ViewSettings& s = next.settings;
  if (frames_ == 0 || s.restart != settings_.restart || !SameScene(s, settings_) ||
      s.denoise.signals != SignalGrouping::kSingle || !s.denoise.temporal || !next.loses_history) {
    return false;
  }
  int width = 0;
  int height = 0;
  PictureSize(s, next.plan.scale, &width, &height);
  const double shape = static_cast<double>(width) * frame_.height / height / frame_.width;
  return std::abs(shape - 1) < 0.01;
}

/// Traces a frame of the last view in the new size, with guides in every pixel.
Result<Frame> ViewSession::GuidesOfLastView(const NextFrame& next,
                                            const RenderProgress& keep_going) {
  RenderSettings wanted = RendererSettings(next);
  const bool complete = !HasSparseGuides(settings_);
  Frame guides;
  Frame room;
  const Frame* last = &frame_;
  if (!complete || frame_.width != wanted.width || frame_.height != wanted.height) {
    wanted.guides = GuideCoverage::kFull;
    wanted.spp = 1;
    wanted.cycle = kMaxCycle;  // its radiance is not used
    RenderMoment moment = moment_.render;
    moment.previous_seconds = moment.seconds;
    moment.previous_pose = moment.pose;
    STILLRAY_RETURN_IF_ERROR(loaded_.renderer->SetSettings(wanted));
    STILLRAY_RETURN_IF_ERROR(loaded_.renderer->RenderFrame(moment, &guides, keep_going));
    last = &guides;
  }
  const Result<const Frame*> host = OnHost(*last, &room);
  return host.ok() ? Result<Frame>(**host) : Result<Frame>(host.status());
}

/// Makes the seed of the next filter's history; empty if there is none.
Status ViewSession::MakeSeed(const NextFrame& next, const RenderProgress& keep_going) {
  seed_.reset();
  if (!CanSeed(next)) {
    return Status::Ok();
  }
  const Result<const Image3*> shown = Denoised();
  STILLRAY_RETURN_IF_ERROR(shown.status());
  const Result<Frame> guides = GuidesOfLastView(next, keep_going);
  STILLRAY_RETURN_IF_ERROR(guides.status());
  seed_ = SeedFrame(*guides, **shown, kSeedSamples, HasSparseGuides(next.settings));
  return Status::Ok();
}

/// Plans and traces the next frame. Refining frames may be cancelled: the data of the last frame is
/// kept until the new frame is complete.
Status ViewSession::TraceNow(const ViewSettings& settings, double elapsed,
                             const RenderProgress& keep_going, NextFrame* next) {
  ahead_.reset();
  *next = PlanNext(settings, elapsed, &control_);
  plan_ = next->plan;
  STILLRAY_RETURN_IF_ERROR(MakeSeed(*next, keep_going));
  RenderSettings wanted = RendererSettings(*next);
  wanted.seed += next->rate_changes;
  if (plan_.refines) {
    next_frame_.on_device = nullptr;
  } else {
    next_frame_ = Frame();
  }
  Frame* frame = plan_.refines ? &next_frame_ : &frame_;
  STILLRAY_RETURN_IF_ERROR(TraceFrame(wanted, next->moment.render, keep_going,
                                      loaded_.renderer.get(), frame, &tracing_));
  if (plan_.refines) {
    std::swap(frame_, next_frame_);
  }
  owed_ = 0;
  return Status::Ok();
}

/// Whether the frame traced ahead matches these settings, which then become the plan. During motion
/// the pose may lag by one frame, as in every pipeline.
bool ViewSession::UsesAhead(const ViewSettings& settings) {
  if (ahead_ == nullptr ||
      ahead_->next.moment.render.frame_index != static_cast<int64_t>(frames_) ||
      !TracesTheSame(ahead_->requested, settings, !ahead_->next.plan.refines)) {
    return false;
  }
  RateControl control = control_;
  const FramePlan plan = PlanFrame(settings, ahead_->next.moved, &control);
  if (!(plan == ahead_->next.plan)) {
    return false;
  }
  control_ = control;
  plan_ = plan;
  return true;
}

/// Waits for the frame traced ahead.
Status ViewSession::TakeAhead(double elapsed, const RenderProgress& keep_going, NextFrame* next) {
  const std::unique_ptr<Ahead> ahead = std::move(ahead_);
  STILLRAY_RETURN_IF_ERROR(ahead->thread.Take(keep_going));
  *next = ahead->next;
  std::swap(frame_, ahead->frame);
  std::swap(next_frame_, ahead->frame);
  tracing_ = ahead->tracing;
  const double passed = std::clamp(elapsed, 0.0, kLongestStep);
  owed_ = std::clamp(owed_ + passed - next->elapsed, -kLongestStep, kLongestStep);
  return Status::Ok();
}

/// Starts tracing the next frame with unchanged settings, if path tracer and denoiser can work
/// concurrently. Not for frames that depend on the image of the current one.
void ViewSession::StartAhead(const ViewSettings& requested, double elapsed) {
  if (!devices_.differ() || requested.reference ||
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism) < 2) {
    return;
  }
  RateControl control = control_;
  const NextFrame next = PlanNext(requested, elapsed, &control);
  if (next.loses_history) {
    return;
  }
  ahead_ = std::make_unique<Ahead>();
  ahead_->requested = requested;
  ahead_->next = next;
  std::swap(ahead_->frame, next_frame_);
  RenderSettings wanted = RendererSettings(next);
  wanted.seed += next.rate_changes;
  // The session may be moved during tracing.
  ahead_->thread.Start([wanted, moment = next.moment.render, renderer = loaded_.renderer.get(),
                        ahead = ahead_.get()](const RenderProgress& keep_going) {
    return TraceFrame(wanted, moment, keep_going, renderer, &ahead->frame, &ahead->tracing);
  });
}

/// Prepares the filter and its history.
Status ViewSession::PrepareHistory(const ViewSettings& s) {
  STILLRAY_RETURN_IF_ERROR(PrepareDenoiser(s));
  if (frames_ > 0 && s.restart != settings_.restart) {
    denoiser_->Reset();
  }
  if (!seed_) {
    return Status::Ok();
  }
  denoiser_->SetResults({});
  STILLRAY_RETURN_IF_ERROR(denoiser_->SetOutputs({}));
  if (!denoiser_->Denoise(*seed_, &denoised_).ok()) {
    denoiser_->Reset();  // filtering the frame will report the error
  }
  seed_.reset();
  return AskForOutputs(s);
}

/// Filters the frame and downloads the data for display. If the device fails, the CPU takes over,
/// and the frame is traced again, since its data may be lost.
Status ViewSession::Filter(const ViewSettings& s, const RenderMoment& moment,
                           const RenderProgress& keep_going) {
  Status status = denoiser_->Denoise(frame_, &denoised_);
  if (status.ok()) {
    status = shown_.Take(frame_, s);
  }
  if (!FallsBack(status)) {
    return status;
  }
  STILLRAY_RETURN_IF_ERROR(MakeDenoiser(s.denoise));
  STILLRAY_RETURN_IF_ERROR(AskForOutputs(s));
  if (frame_.on_device != nullptr) {
    RenderSettings settings = loaded_.renderer->settings();
    settings.on_device = false;
    STILLRAY_RETURN_IF_ERROR(loaded_.renderer->SetSettings(settings));
    STILLRAY_RETURN_IF_ERROR(loaded_.renderer->RenderFrame(moment, &frame_, keep_going));
  }
  STILLRAY_RETURN_IF_ERROR(denoiser_->Denoise(frame_, &denoised_));
  return shown_.Take(frame_, s);
}

Status ViewSession::RenderNext(const ViewSettings& settings, double elapsed,
                               const RenderProgress& keep_going, ViewFrame* out) {
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(settings.denoise));
  NextFrame next;
  const bool overlapped = UsesAhead(settings);
  STILLRAY_RETURN_IF_ERROR(overlapped ? TakeAhead(elapsed, keep_going, &next)
                                      : TraceNow(settings, elapsed, keep_going, &next));
  if (!tracing_.remark.empty()) {
    Note("tracing goes on on the CPU: " + tracing_.remark);
  }
  const ViewSettings& s = next.settings;
  STILLRAY_RETURN_IF_ERROR(PrepareHistory(s));
  ViewSettings last_settings = std::exchange(settings_, s);
  const Moment last_moment = std::exchange(moment_, next.moment);
  const uint64_t last_rate_changes = std::exchange(rate_changes_, next.rate_changes);
  ++frames_;
  // Before the scene is updated to the next moment.
  const Status found = shown_.FindHits(*loaded_.scene, moment_.render, frame_, s);
  if (!found.ok()) {
    Note("no view of hits: " + found.message());
  }
  StartAhead(settings, elapsed);
  const Clock::time_point filter_start = Clock::now();
  const Status filtered = Filter(s, next.moment.render, keep_going);
  if (!filtered.ok()) {
    ahead_.reset();
    settings_ = std::move(last_settings);
    moment_ = last_moment;
    rate_changes_ = last_rate_changes;
    --frames_;
    return filtered;
  }
  const double denoise_ms = MillisecondsSince(filter_start);

  still_ = !next.moved;
  samples_ = (next.moved || next.loses_history ? 0 : samples_) + next.plan.rate.value();
  if (next.moved || reference_.HasOtherSize(frame_.width, frame_.height)) {
    reference_.Reset();
  }
  shown_.Derive(Parts(), s);
  shown_.Show(Parts(), s, out);
  Account(denoise_ms, overlapped, out);
  out->note = std::exchange(note_, {});
  if (frames_ > kFirstFrames) {
    control_.Observe(out->cost);
  }
  return Status::Ok();
}

Status ViewSession::RefineReference(const RenderProgress& keep_going) {
  if (!WantsReference()) {
    return Status::Ok();
  }
  return reference_.AddPass(moment_.render, loaded_.renderer.get(), keep_going);
}

FrameParts ViewSession::Parts() const {
  return {frame_, moment_.render, denoised_, reference_.picture(), settings_.denoise};
}

void ViewSession::Account(double denoise_ms, bool overlapped, ViewFrame* out) const {
  out->number = frames_;
  out->rate = plan_.rate;
  out->scale = plan_.scale;
  out->chosen_scale = settings_.scale;
  out->fast_filter = plan_.fast_filter;
  out->temporal = settings_.denoise.temporal;
  out->samples = samples_;
  out->still = still_;
  out->seconds = moment_.time.all;
  out->light_seconds = moment_.time.lights;
  out->length = length_;
  out->pose = moment_.pose;
  out->cost = {tracing_.milliseconds, denoise_ms + out->show_ms, tracing_.fixed_ms, overlapped};
  out->stages = tracing_.stages;
  out->stages.insert(out->stages.end(), denoised_.timings.begin(), denoised_.timings.end());
  out->stages.push_back({"make pictures", out->show_ms});
  // The frame in progress will have the size of this one.
  const size_t next_bytes = FrameBytes(ahead_ != nullptr ? frame_ : next_frame_);
  out->memory = {tracing_.memory_bytes, denoiser_->memory_bytes(),
                 FrameBytes(frame_) + next_bytes + shown_.bytes()};
  out->reference_spp = reference_.spp();
  out->device = devices_.filter.description();
  out->tracer = tracing_.place;
}

Result<const Image3*> ViewSession::Denoised() {
  if (frames_ == 0) {
    return Status::NotFound("there is no frame yet");
  }
  if (denoised_.colour.empty()) {
    STILLRAY_RETURN_IF_ERROR(denoiser_->ReadColour(&denoised_.colour));
  }
  return &denoised_.colour;
}

Result<Rgb8Image> ViewSession::FinishedPicture() {
  STILLRAY_RETURN_IF_ERROR(Denoised().status());
  return shown_.FinishedPicture(Parts());
}

Result<std::vector<Image1>> ViewSession::Values(const std::string& name) {
  const ViewInfo* view = frames_ > 0 ? shown_.Find(name) : nullptr;
  std::vector<Image1> values;
  if (view != nullptr) {
    if (view->name == "denoised") {
      STILLRAY_RETURN_IF_ERROR(Denoised().status());
    }
    Result<std::vector<Image1>> found = shown_.Values(*view, Parts(), settings_);
    STILLRAY_RETURN_IF_ERROR(found.status());
    values = std::move(*found);
  }
  if (values.empty()) {
    return Status::NotFound(fmt::format("there is no picture '{}' to save yet", name));
  }
  return values;
}

}  // namespace stillray::view

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// clang-format off
// The order of the stages, and the owner of their history. One frame:
//
//   stage                border   reads                          writes               history
//   fill_guides          pyramid  depth, ..., samples            completed guides     known guides   (only where some are unknown)
//   prepare_guides       1        depth, normal, id              guides               kept for the next frame
//   reproject            -        guides of both frames, motion  taps
//   per signal:
//     demodulate         -        lights, albedo, samples        new light
//     suppress_fireflies 1        new light                      new light
//     limit_history      wavelet  new light, taps, last history  longest length       (all signals at once)
//     accumulate         -        new light, taps, last history  history              colour, moments, length
//     merge_future       -        history, light of the future   merged history       (only where the future is known)
//   estimate_variance    3        histories, guides              variances
//   per level:
//     prefilter_variance 1        luminance, variance            luminance stops      (signal by signal)
//     atrous             wavelet  colour, variance, guides       colour, variance     colour of the feedback level
//   keep_mirrors         wavelet  new light, colour, roughness   colour               (only where a surface is smooth)
//   remodulate           -        colours, albedo, unfiltered    picture
//   fxaa                 9        picture, length                picture
//   antialias            4x4      picture, motion                picture              kept for the next frame
//
// Where nothing has to see what lies between them, prepare_guides runs with reproject, demodulate with accumulate and
// remodulate with antialias, row by row; their time is then that of the later one. accumulate then also leaves the
// variance of histories that are long enough, and estimate_variance looks at the others alone.
// clang-format on

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "core/guides.h"
#include "core/negative_limit.h"
#include "core/parallel.h"
#include "denoise/denoiser_impl.h"
#include "denoise/device_denoiser.h"
#include "denoise/filter_parameters.h"
#include "denoise/frame_check.h"
#include "denoise/history_bytes.h"
#include "denoise/output_names.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

/// Copies what the next frame needs to know of this one's guides; nothing if \p from is of another
/// size.
void CopyGuides(const GuidePlanes& from, GuidePlanes* to) {
  if (from.id.width() != to->id.width() || from.id.height() != to->id.height()) {
    return;
  }
  for (int y = 0; y < from.id.height(); ++y) {
    std::copy_n(from.inverse_depth.Row(y), from.id.width(), to->inverse_depth.Row(y));
    std::copy_n(from.id.Row(y), from.id.width(), to->id.Row(y));
  }
  CopyImage(from.normal, &to->normal);
}

/// Gives the light of a history another border.
void SetBorder(int border, SignalHistory* history) {
  for (Image3* image : {&history->colour, &history->behind}) {
    if (!image->empty() && (*image)[0].border() != border) {
      Image3 other(image->width(), image->height(), border);
      CopyImage(*image, &other);
      *image = std::move(other);
    }
  }
}

/// Border that the wavelet needs with these settings.
int BorderOf(const Settings& s) {
  const int longest = *std::max_element(s.steps.step.begin(), s.steps.step.begin() + s.steps.count);
  const int radius = s.kernel == Kernel::k5x5 ? 2 : 1;
  return std::max(longest * radius, kLimitHistoryRadius << (kLimitHistoryLevels - 1));
}

}  // namespace

void Denoiser::Impl::Allocate(int width, int height, size_t groups) {
  // Never shrinks, so that going back and forth between settings allocates nothing.
  const int before = border;
  border = std::max(BorderOf(settings), before);
  const bool same = state.width == width && state.height == height &&
                    state.signals.size() == groups &&
                    state.signals.front().compressed.empty() != settings.limit_history &&
                    state.signals.front().behind.empty() != BlendsFeedback(settings);
  if (!same) {
    state = DenoiserState(width, height, groups, settings.limit_history, BlendsFeedback(settings),
                          border);
    has_result = false;
    taps = ReprojectionTaps(width, height);
    staged = StagedHistory(width, height);
    light.clear();
    while (light.size() < groups) {
      light.push_back({Image3(width, height), Image1(width, height), Image1()});
    }
    fetched = EmptyHistory();
    fetched_is_empty = true;
    scratch = Image3(width, height);
    picture = Image3(width, height);
  }
  if (!same || before != border) {
    GuidePlanes wider(width, height, border);
    CopyGuides(state.guides, &wider);
    state.guides = std::move(wider);
    wavelet.clear();
    for (size_t i = 0; i < groups; ++i) {
      wavelet.emplace_back(width, height, border);
    }
  }
  const bool stops = settings.limit_history || settings.wavelet == Wavelet::kSvgf;
  for (WaveletPlanes& planes : wavelet) {
    if (stops == planes.stop.empty()) {
      planes.stop = stops ? Image1(width, height, border) : Image1();
    }
  }
  for (SignalHistory& signal : state.signals) {
    SetBorder(border, &signal);
  }
  SetBorder(border, &fetched);
}

/// How far the samples of this frame bring the next feedback of filtered light (PSVGF section 5).
void Denoiser::Impl::AdvanceFeedback() {
  double arrived = 1;
  if (!frame->samples.empty()) {
    arrived = Mean([&](int y) {
      const float* row = frame->samples.Row(y);
      double sum = 0;
      for (int x = 0; x < frame->width; ++x) {
        sum += row[x] > 0 && std::isfinite(row[x]) ? static_cast<double>(row[x]) : 0.0;
      }
      return sum;
    });
  }
  samples_per_pixel = static_cast<float>(arrived);
  state.feedback_progress =
      std::min(state.feedback_progress + static_cast<float>(std::min(arrived, 1.0)), 1.0f);
  const bool whole = state.feedback_progress > kWholeSample;
  feedback_phase = whole ? 1.0f : state.feedback_progress;
  was_fed_back = feeds_back;
  feeds_back = settings.temporal && settings.feedback > 0 &&
               (settings.feedback_when == FeedbackWhen::kFrame || whole);
  if (whole) {
    state.feedback_progress = 0;
  }
}

void Denoiser::Impl::RunFxaa() {
  if (!HasFxaa()) {
    return;
  }
  const StageTimer timer(&out->timings, "fxaa");
  FxaaParameters p;
  if (settings.fxaa == Fxaa::kSparse) {
    p.length = &state.signals.front().length;
  }
  stages->fxaa(picture, p, &scratch);
  std::swap(picture, scratch);
}

bool Denoiser::Impl::ComposesOnTheWay() const {
  return AntialiasesInTime(settings, state.jittered) && state.has_picture && !HasFxaa() &&
         outputs.empty();
}

void Denoiser::Impl::RunAntialias() {
  const bool first = !state.has_picture;
  if (!AntialiasesInTime(settings, state.jittered)) {
    std::swap(state.picture, picture);
    state.has_picture = false;
    return;
  }
  const StageTimer timer(&out->timings, "antialias");
  if (first) {
    std::swap(state.picture, picture);
  } else {
    AntialiasParameters p;
    p.alpha = settings.taa_alpha;
    if (settings.temporal) {
      p.length = &state.signals.front().length;
      p.samples = frame->samples.empty() ? nullptr : &frame->samples;
    }
    p.copy = Result();
    if (ComposesOnTheWay()) {
      out->non_finite +=
          stages->antialias_parts(parts, state.picture, guides->motion, state.guides, p, &scratch);
    } else {
      stages->antialias(picture, state.picture, guides->motion, state.guides, p, &scratch);
    }
    is_handed_over = p.copy != nullptr;
    std::swap(state.picture, scratch);
  }
  state.has_picture = true;
}

Denoiser::Denoiser(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Denoiser::Denoiser(Denoiser&&) noexcept = default;
Denoiser& Denoiser::operator=(Denoiser&&) noexcept = default;
Denoiser::~Denoiser() = default;

Result<Denoiser> Denoiser::Create(const Settings& settings, Backend backend) {
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(settings));
  auto impl = std::make_unique<Impl>();
  impl->settings = settings;
  impl->stages = backend == Backend::kReference ? &kReferenceStages : &kCpuStages;
  return Denoiser(std::move(impl));
}

Device::Device() : impl_(std::make_shared<Impl>(Impl{"cpu", {}, nullptr, false})) {}

Device MakeDevice(std::shared_ptr<DeviceBackend> backend, std::string description) {
  Device device;
  device.impl_->backend = std::move(backend);
  device.impl_->description = std::move(description);
  return device;
}

std::shared_ptr<DeviceBackend> BackendOf(const Device& device) {
  return device.impl_->backend;
}

bool Device::is_cpu() const {
  return impl_->backend == nullptr;
}

const std::string& Device::description() const {
  return impl_->description;
}

const std::string& Device::remark() const {
  return impl_->remark;
}

Result<Denoiser> Denoiser::Create(const Settings& settings, const Device& device,
                                  DevicePrecision precision) {
  Result<Denoiser> made = Create(settings);
  if (!made.ok() || device.is_cpu()) {
    return made;
  }
  Result<std::unique_ptr<DeviceDenoiser>> on_device =
      device.impl_->backend->CreateDenoiser(settings, precision);
  STILLRAY_RETURN_IF_ERROR(on_device.status());
  made->device_ = std::move(on_device.value());
  made->may_fall_back_ = device.impl_->may_fall_back;
  return made;
}

const Frame& Denoiser::Impl::Complete(const Frame& given) {
  if (given.on_device != nullptr || HasGuides(given, settings.demodulate)) {
    return given;
  }
  completed = given;
  FillMissingGuides(settings.demodulate, &completed);
  return completed;
}

Status Denoiser::Impl::Begin(const Frame& next_frame, DenoisedFrame* result) {
  const bool continues = state.width == next_frame.width && state.height == next_frame.height;
  const bool jittered =
      IsJittered(next_frame.jitter_x, next_frame.jitter_y) || (continues && state.jittered);
  const MotionUse use = {continues && HasHistory(),
                         continues && state.has_picture && AntialiasesInTime(settings, jittered)};
  STILLRAY_RETURN_IF_ERROR(CheckFrame(next_frame, settings, use));
  OddValues odd = FindOddValues(next_frame, use);
  const bool transmission = HasTransmission(next_frame);
  if (groups.empty() || transmission != groups_have_transmission || grouping != settings.signals) {
    groups = GroupsOf(settings.signals, transmission);
    groups_have_transmission = transmission;
    grouping = settings.signals;
  }
  Allocate(next_frame.width, next_frame.height, groups.size());
  state.jittered = jittered;
  frame = &next_frame;
  guides = &next_frame.guides;
  emission = &next_frame.emission;
  background = &next_frame.background;
  out = result;
  is_handed_over = false;
  out->timings.clear();
  out->images.clear();
  out->non_finite = out->negative = out->bad_guides = 0;
  composites.clear();
  if (settings.fill_guides && HasIncompleteGuides(next_frame)) {
    const StageTimer timer(&out->timings, "fill_guides");
    FillGuides(next_frame, *stages, &state.held, &fill_guides_work);
    guides = &state.held.guides;
    emission = &state.held.emission;
    background = &state.held.background;
  } else if (!state.held.empty()) {
    state.held = HeldGuides();
  }
  AdvanceFeedback();
  {
    const StageTimer timer(&out->timings, "demodulate");
    negative_limit = NegativeLimitOf(*frame, IsSparse());
  }
  std::swap(state.guides, state.previous_guides);
  if (state.guides.inverse_depth.border() != border || state.guides.id.empty()) {
    state.guides = GuidePlanes(frame->width, frame->height, border);
  }
  const Guides& g = *guides;
  const PrepareGuidesInput given = {&g.depth, &g.normal, g.id.empty() ? nullptr : &g.id};
  if (HasHistory()) {
    const StageTimer timer(&out->timings, "reproject");
    ReprojectParameters p;
    p.depth_tolerance = settings.history_depth;
    p.min_cosine = std::cos(settings.history_normal * 0.017453293f);
    p.test_id = settings.history_id;
    p.search = settings.history_search;
    out->bad_guides = stages->prepare_and_find_taps(given, state.previous_guides, g.motion, p,
                                                    &state.guides, &taps);
  } else {
    const StageTimer timer(&out->timings, "prepare_guides");
    out->bad_guides = stages->prepare_guides(given, &state.guides);
  }
  out->bad_guides += odd.bad_guides;
  out->warning = std::move(odd.warning);
  return Status::Ok();
}

/// A device that fails before the first frame is finished is given up, if the user left the choice
/// open. What is wrong with a frame would be so on the CPU as well.
bool Denoiser::FallsBack(const Status& status) {
  if (status.ok() || !may_fall_back_ || status.code() == StatusCode::kInvalidArgument) {
    may_fall_back_ = may_fall_back_ && !status.ok();
    return false;
  }
  remark_ = status.message();
  device_.reset();
  return true;
}

Status Denoiser::DenoiseOnDevice(const Frame& frame, const FutureLight& future,
                                 DenoisedFrame* out) {
  STILLRAY_RETURN_IF_ERROR(CheckFuture(frame, impl_->settings, future));
  const std::span<const SignalHistory> known =
      future.empty() ? std::span<const SignalHistory>() : future.impl_->signals;
  const Status status = device_->Denoise(frame, known, out);
  return FallsBack(status) ? Denoise(frame, future, out) : status;
}

Status Denoiser::Denoise(const Frame& frame, DenoisedFrame* out) {
  return Denoise(frame, FutureLight(), out);
}

Status Denoiser::Denoise(const Frame& given, const FutureLight& future, DenoisedFrame* out) {
  STILLRAY_RETURN_IF_ERROR(CheckSize(given));
  Impl& d = *impl_;
  const Frame& whole = d.Complete(given);
  if (device_ != nullptr) {
    return DenoiseOnDevice(whole, future, out);
  }
  const Result<const Frame*> host = OnHost(whole, &d.from_device);
  STILLRAY_RETURN_IF_ERROR(host.status());
  const Frame& frame = **host;
  STILLRAY_RETURN_IF_ERROR(CheckFuture(frame, d.settings, future));
  STILLRAY_RETURN_IF_ERROR(d.Begin(frame, out));
  d.merges_future = !future.empty();
  d.GatherSignals([&](size_t i) {
    d.RunAccumulate(i);
    d.BeginFilter(i, d.MergeFuture(i, future));
  });
  d.FilterSignals();
  d.RunKeepMirrors();
  d.FindPictureParts();
  if (!d.ComposesOnTheWay()) {
    d.ComposePicture();
  }
  if (d.Wants("disocclusion")) {
    Image1 mask(frame.width, frame.height);
    for (int y = 0; y < frame.height; ++y) {
      for (int x = 0; x < frame.width; ++x) {
        const bool surface = d.state.guides.inverse_depth(x, y) > 0;
        const bool found = d.HasHistory() && d.taps.Finds(x, y);
        mask(x, y) = surface && !found ? 1.0f : 0.0f;
      }
    }
    out->images.push_back({"disocclusion", {std::move(mask)}});
  }
  if (d.Wants("aliased")) {
    out->images.push_back({"aliased", {d.picture[0], d.picture[1], d.picture[2]}});
  }
  d.RunFxaa();
  d.RunAntialias();
  d.HandOver();
  for (auto& [name, image] : d.composites) {
    out->images.push_back({name, {std::move(image[0]), std::move(image[1]), std::move(image[2])}});
  }
  d.composites.clear();
  d.state.has_history = d.settings.temporal;
  d.frame = nullptr;
  d.out = nullptr;
  return Status::Ok();
}

bool NeedsNewHistory(const Settings& a, const Settings& b) {
  return a.signals != b.signals || a.demodulate != b.demodulate ||
         a.limit_history != b.limit_history || a.luminance != b.luminance ||
         BlendsFeedback(a) != BlendsFeedback(b) ||
         (a.firefly == Firefly::kCompress) != (b.firefly == Firefly::kCompress);
}

Status Denoiser::SetSettings(const Settings& settings) {
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(settings));
  const bool regroup = NeedsNewHistory(impl_->settings, settings);
  if (device_ != nullptr) {
    STILLRAY_RETURN_IF_ERROR(device_->SetSettings(settings));
  }
  impl_->settings = settings;
  if (regroup) {
    Reset();
  }
  return Status::Ok();
}

const Settings& Denoiser::settings() const {
  return impl_->settings;
}

std::vector<std::string> Denoiser::OutputNames(const Settings& settings) {
  std::vector<std::string> names = {"temporal"};
  for (int level = 1; level <= settings.steps.count; ++level) {
    names.push_back(fmt::format("atrous{}", level));
  }
  names.insert(names.end(), {"aliased", "disocclusion"});
  for (const char* kind : {"noisy", "accumulated", "filtered", "variance", "filtered_variance",
                           "history", "limit", "moment_mean", "moment_variance"}) {
    for (const SignalGroup& group : GroupsOf(settings.signals, true)) {
      names.push_back(fmt::format("{}.{}", kind, group.name));
    }
  }
  return names;
}

Status Denoiser::SetOutputs(const std::vector<std::string>& names) {
  const std::vector<std::string> known = OutputNames(impl_->settings);
  std::vector<std::string> wanted;
  for (const std::string& name : names) {
    if (!AddOutputs(known, name, &wanted)) {
      return Status::InvalidArgument(
          fmt::format("unknown output '{}'; outputs are: {}", name, fmt::join(known, ", ")));
    }
  }
  if (device_ != nullptr) {
    device_->SetOutputs(wanted);
  }
  impl_->outputs = std::move(wanted);
  return Status::Ok();
}

void Denoiser::Reset() {
  if (device_ != nullptr) {
    device_->Reset();
  }
  impl_->state.has_history = false;
  impl_->state.has_picture = false;
  impl_->state.jittered = false;
  impl_->state.held = HeldGuides();
  impl_->state.feedback_progress = 0;
}

size_t Denoiser::Impl::WorkBytes() const {
  size_t sum = taps.bytes() + staged.bytes() + fetched.bytes() + scratch.bytes() + picture.bytes() +
               fill_guides_work.bytes() + firefly_work.bytes() + mirror_work.bytes();
  for (const NewLight& of_signal : light) {
    sum += of_signal.bytes();
  }
  for (const SignalHistory& signal : merged) {
    sum += signal.bytes();
  }
  for (const WaveletPlanes& planes : wavelet) {
    sum += planes.bytes();
  }
  return sum;
}

DeviceMemory Denoiser::device_memory() const {
  return device_ != nullptr ? device_->device_memory() : DeviceMemory();
}

size_t Denoiser::memory_bytes() const {
  return (device_ != nullptr ? device_->memory_bytes() : 0) + impl_->state.bytes() +
         impl_->WorkBytes();
}

Result<std::vector<uint8_t>> Denoiser::SaveHistory() const {
  return device_ != nullptr ? device_->SaveHistory() : HistoryToBytes(impl_->state);
}

/// Where the user left the choice of the device open, what was begun on the CPU goes on there.
Status Denoiser::RestoreHistory(std::span<const uint8_t> bytes) {
  if (device_ != nullptr && may_fall_back_ && IsHistoryOfCpu(bytes)) {
    remark_ = "the saved history was made on the CPU";
    device_.reset();
  }
  if (device_ != nullptr) {
    const Status status = device_->RestoreHistory(bytes);
    may_fall_back_ = may_fall_back_ && !status.ok();  // the CPU knows nothing of this history
    return status;
  }
  Result<DenoiserState> restored =
      HistoryFromBytes(bytes, KeptBy(impl_->settings), BorderOf(impl_->settings));
  if (!restored.ok()) {
    return restored.status();
  }
  impl_->state = DenoiserState();
  impl_->Allocate(restored->width, restored->height, restored->signals.size());
  impl_->state = std::move(restored.value());
  impl_->has_result = false;
  impl_->feeds_back = true;  // perhaps: then the next frame looks
  return Status::Ok();
}

}  // namespace stillray

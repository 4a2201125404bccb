// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// clang-format off
// The order of the stages, and the owner of their history. One frame:
//
//   stage                border   reads                          writes               history
//   prepare_guides       1        depth, normal, id              guides               kept for the next frame
//   reproject            -        guides of both frames, motion  taps
//   per signal:
//     demodulate         -        lights, albedo, samples        new light
//     suppress_fireflies 1        new light                      new light
//     reproject (fetch)  -        taps, last history             fetched history
//     limit_history      wavelet  new light, fetched history     longest length
//     accumulate         -        new light, fetched history     history              colour, moments, length
//     estimate_variance  3        history, guides                variance
//     prefilter_variance 1        variance                       spread               (before every level)
//     atrous             wavelet  colour, variance, guides       colour, variance     colour of the feedback level
//     remodulate         -        colour, albedo                 picture
//   antialias            4x4      picture, motion                picture              kept for the next frame
// clang-format on

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "core/parallel.h"
#include "denoise/denoiser_impl.h"
#include "denoise/frame_check.h"
#include "denoise/history_bytes.h"
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

/// Border that the wavelet needs with these settings.
int BorderOf(const Settings& s) {
  const int longest = *std::max_element(s.steps.step.begin(), s.steps.step.begin() + s.steps.count);
  const int radius = s.kernel == Kernel::k5x5 ? 2 : 1;
  return std::max(longest * radius, 2 << (kLimitHistoryLevels - 1));
}

}  // namespace

void Denoiser::Impl::Allocate(int width, int height, size_t groups) {
  // Never shrinks, so that going back and forth between settings allocates nothing.
  const int border = std::max(BorderOf(settings), present.border());
  const bool same = state.width == width && state.height == height &&
                    state.signals.size() == groups && limit.empty() != settings.limit_history;
  if (!same) {
    state = DenoiserState(width, height, groups, settings.limit_history);
    taps = ReprojectionTaps(width, height);
    light = {Image3(width, height), Image1(width, height), Image1()};
    fetched = SignalHistory(width, height, settings.limit_history);
    limit = settings.limit_history ? Image1(width, height) : Image1();
    scratch = Image3(width, height);
    picture = Image3(width, height);
  }
  if (!same || present.border() != border) {
    GuidePlanes wider(width, height, border);
    CopyGuides(state.guides, &wider);
    state.guides = std::move(wider);
    filter[0] = FilterPlanes(width, height, border);
    filter[1] = FilterPlanes(width, height, border);
    spread = Image1(width, height, border);
    present = Image1(width, height, border);
  }
}

void Denoiser::Impl::RunAntialias() {
  const bool first = !state.has_picture;
  if (settings.antialias == Antialias::kOff) {
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
    stages->antialias(picture, state.picture, frame->guides.motion, state.guides, p, &scratch);
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

Status Denoiser::Denoise(const Frame& frame, DenoisedFrame* out) {
  STILLRAY_RETURN_IF_ERROR(CheckFrame(frame, impl_->settings));
  Impl& d = *impl_;
  const std::vector<SignalGroup> groups = GroupsOf(d.settings.signals, HasTransmission(frame));
  d.Allocate(frame.width, frame.height, groups.size());
  d.frame = &frame;
  d.out = out;
  out->timings.clear();
  out->images.clear();
  out->non_finite = out->negative = out->bad_guides = 0;
  d.composites.clear();
  for (int c = 0; c < 3; ++c) {
    d.picture[c].Fill(0.0f);
  }
  {
    const StageTimer timer(&out->timings, "prepare_guides");
    std::swap(d.state.guides, d.state.previous_guides);
    if (d.state.guides.inverse_depth.border() != d.present.border() || d.state.guides.id.empty()) {
      d.state.guides = GuidePlanes(frame.width, frame.height, d.present.border());
    }
    const Guides& g = frame.guides;
    out->bad_guides = d.stages->prepare_guides(
        {&g.depth, &g.normal, g.id.empty() ? nullptr : &g.id}, &d.state.guides);
  }
  if (d.settings.temporal && d.state.has_history) {
    const StageTimer timer(&out->timings, "reproject");
    ReprojectParameters p;
    p.depth_tolerance = d.settings.history_depth;
    p.min_cosine = std::cos(d.settings.history_normal * 0.017453293f);
    p.test_id = d.settings.history_id;
    p.search = d.settings.history_search;
    d.stages->find_taps(d.state.guides, d.state.previous_guides, frame.guides.motion, p, &d.taps);
  }
  for (size_t i = 0; i < groups.size(); ++i) {
    d.RunSignal(groups[i], &d.state.signals[i]);
  }
  if (d.Wants("disocclusion")) {
    Image1 mask(frame.width, frame.height);
    for (int y = 0; y < frame.height; ++y) {
      for (int x = 0; x < frame.width; ++x) {
        const bool surface = d.state.guides.inverse_depth(x, y) > 0;
        const bool found =
            d.settings.temporal && d.state.has_history &&
            (d.taps.search(x, y) != 0 || d.taps.weight[0](x, y) + d.taps.weight[1](x, y) +
                                                 d.taps.weight[2](x, y) + d.taps.weight[3](x, y) >
                                             0);
        mask(x, y) = surface && !found ? 1.0f : 0.0f;
      }
    }
    out->images.push_back({"disocclusion", {std::move(mask)}});
  }
  {
    const StageTimer timer(&out->timings, "remodulate");
    for (const Image3* unfiltered : {&frame.emission, &frame.background}) {
      if (!unfiltered->empty()) {
        out->non_finite += d.stages->add_unfiltered(*unfiltered, &d.picture);
        for (auto& [name, image] : d.composites) {
          d.stages->add_unfiltered(*unfiltered, &image);
        }
      }
    }
  }
  if (d.Wants("aliased")) {
    out->images.push_back({"aliased", {d.picture[0], d.picture[1], d.picture[2]}});
  }
  d.RunAntialias();
  if (out->colour.width() != frame.width || out->colour.height() != frame.height) {
    out->colour = Image3(frame.width, frame.height);
  }
  CopyImage(d.state.picture, &out->colour);
  for (auto& [name, image] : d.composites) {
    out->images.push_back({name, {std::move(image[0]), std::move(image[1]), std::move(image[2])}});
  }
  d.composites.clear();
  d.state.has_history = d.settings.temporal;
  d.frame = nullptr;
  d.out = nullptr;
  return Status::Ok();
}

Status Denoiser::SetSettings(const Settings& settings) {
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(settings));
  const bool regroup =
      settings.signals != impl_->settings.signals ||
      settings.demodulate != impl_->settings.demodulate ||
      settings.limit_history != impl_->settings.limit_history ||
      (settings.firefly == Firefly::kCompress) != (impl_->settings.firefly == Firefly::kCompress);
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
    const size_t before = wanted.size();
    for (const std::string& candidate : known) {
      if (candidate == name || candidate.substr(0, candidate.find('.')) == name) {
        wanted.push_back(candidate);
      }
    }
    if (wanted.size() == before) {
      return Status::InvalidArgument(
          fmt::format("unknown output '{}'; outputs are: {}", name, fmt::join(known, ", ")));
    }
  }
  impl_->outputs = std::move(wanted);
  return Status::Ok();
}

void Denoiser::Reset() {
  impl_->state.has_history = false;
  impl_->state.has_picture = false;
}

size_t Denoiser::Impl::WorkBytes() const {
  return taps.bytes() + light.bytes() + fetched.bytes() + filter[0].bytes() + filter[1].bytes() +
         spread.bytes() + present.bytes() + limit.bytes() + scratch.bytes() + picture.bytes();
}

size_t Denoiser::memory_bytes() const {
  return impl_->state.bytes() + impl_->WorkBytes();
}

std::vector<uint8_t> Denoiser::SaveHistory() const {
  return HistoryToBytes(impl_->state);
}

Status Denoiser::RestoreHistory(std::span<const uint8_t> bytes) {
  const Settings& s = impl_->settings;
  Result<DenoiserState> restored =
      HistoryFromBytes(bytes, GroupsOf(s.signals, false).size(), GroupsOf(s.signals, true).size(),
                       s.limit_history, BorderOf(s));
  if (!restored.ok()) {
    return restored.status();
  }
  impl_->state = DenoiserState();
  impl_->Allocate(restored->width, restored->height, restored->signals.size());
  impl_->state = std::move(restored.value());
  return Status::Ok();
}

std::vector<uint8_t> ToDisplay(const Image3& colour, float exposure, Tonemap curve) {
  std::vector<uint8_t> bytes(static_cast<size_t>(colour.width()) *
                             static_cast<size_t>(colour.height()) * 3);
  cpu::Tonemap(colour, std::exp2f(exposure), static_cast<int>(curve), bytes.data());
  return bytes;
}

}  // namespace stillray

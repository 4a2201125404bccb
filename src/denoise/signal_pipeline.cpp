// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The stages that run for each signal on its own: from its light to its history, and from what the
// wavelet has made of it to its part of the picture.
#include <algorithm>
#include <array>
#include <string>

#include <fmt/format.h>

#include "core/parallel.h"
#include "denoise/denoiser_impl.h"
#include "denoise/filter_parameters.h"
#include "denoise/stage_timer.h"

namespace stillray {
void CopyImage(const Image3& from, Image3* to) {
  ParallelRows(from.height(), 32, [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c) {
      for (int y = y0; y < y1; ++y) {
        std::copy_n(from[c].Row(y), from.width(), (*to)[c].Row(y));
      }
    }
  });
}

/// A small positive number for black light.
float Denoiser::Impl::MeanLuminance(const Image3& light_in) {
  const double mean = Mean([&](int y) {
    const float* row = light_in[0].Row(y);
    double sum = 0;
    for (int x = 0; x < state.width; ++x) {
      sum += static_cast<double>(row[x]);
    }
    return sum;
  });
  return static_cast<float>(std::max(mean, 1e-20));
}

Image3* Denoiser::Impl::Composite(const std::string& name) {
  for (auto& [known, image] : composites) {
    if (known == name) {
      return &image;
    }
  }
  composites.emplace_back(name, Image3(state.width, state.height));
  return &composites.back().second;
}

void Denoiser::Impl::KeepPlane(const char* kind, const SignalGroup& group, const Image1& plane) {
  if (outputs.empty()) {
    return;
  }
  const std::string name = fmt::format("{}.{}", kind, group.name);
  if (Wants(name)) {
    Image1 copy(state.width, state.height);
    for (int y = 0; y < state.height; ++y) {
      std::copy_n(plane.Row(y), state.width, copy.Row(y));
    }
    out->images.push_back({name, {std::move(copy)}});
  }
}

void Denoiser::Impl::KeepImage(const char* kind, const SignalGroup& group, const Image3& image) {
  if (outputs.empty()) {
    return;
  }
  const std::string name = fmt::format("{}.{}", kind, group.name);
  if (Wants(name)) {
    Image3 copy(state.width, state.height);
    const SignalLight light_out = {&image, AlbedoSum()};
    stages->remodulate({&light_out, 1}, {}, {Rec601(), false}, &copy);
    out->images.push_back({name, {copy[0], copy[1], copy[2]}});
  }
}

AlbedoSum Denoiser::Impl::Albedos(const SignalGroup& group) const {
  AlbedoSum sum;
  const Guides& g = *guides;
  const auto add = [&](bool used, const Image3& albedo) {
    if (settings.demodulate && used && !albedo.empty()) {
      sum.part[sum.count++] = &albedo;
    }
  };
  add(group.diffuse_albedo, g.albedo);
  add(group.specular_albedo, g.specular_albedo);
  add(group.transmission_albedo, g.transmission_albedo);
  return sum;
}

void Denoiser::Impl::AddSignal(const SignalGroup& group, const Image3& light_in, Image3* sum) {
  const Image3* expanded = &light_in;
  if (settings.firefly == Firefly::kCompress) {
    CopyImage(light_in, &scratch);
    stages->expand_light(&scratch);
    expanded = &scratch;
  }
  const SignalLight light_out = {expanded, Albedos(group)};
  stages->remodulate({&light_out, 1}, {}, {Rec601(), true}, sum);
}

DemodulateInput Denoiser::Impl::RadianceOf(const SignalGroup& group, NewLight* to) const {
  DemodulateInput in;
  bool within = false;
  for (const SignalKind kind : group.kinds) {
    const Signal* signal = frame->Find(kind);
    if (signal == nullptr) {
      continue;
    }
    const Image3& own = AlbedoOf(*guides, kind);
    in.radiance[in.count] = &signal->radiance;
    in.second_moment[in.count] = signal->second_moment.empty() ? nullptr : &signal->second_moment;
    in.own_albedo[in.count] = own.empty() ? nullptr : &own;
    within = within || !signal->second_moment.empty();
    ++in.count;
  }
  in.albedo = Albedos(group);
  in.rec601 = Rec601();
  in.negative_limit = negative_limit;
  in.samples = frame->samples.empty() ? nullptr : &frame->samples;
  if (within && to->within.empty()) {
    to->within = Image1(state.width, state.height);
  } else if (!within) {
    to->within = Image1();
  }
  return in;
}

void Denoiser::Impl::Count(const DemodulateCounts& counts) {
  out->non_finite += counts.non_finite;
  out->negative += counts.negative;
}

bool Denoiser::Impl::ChangesInPlace() const {
  const int64_t elsewhere = taps.Elsewhere();
  return elsewhere >= 0 && staged.HasRoom(static_cast<size_t>(elsewhere), taps.lanes);
}

bool Denoiser::Impl::JoinsOnTheWay() const {
  return HasHistory() && !settings.limit_history && settings.firefly == Firefly::kOff &&
         outputs.empty() && !MayKeepMirrors() && !ChangesInPlace();
}

/// Chooses the luminance that a signal is compressed with, and brings its history to it.
void Denoiser::Impl::UpdateCompressionScale(size_t signal) {
  SignalHistory& history = state.signals[signal];
  if (!HasHistory()) {
    history.compressed_scale = CompressionScale(0.0f, MeanLuminance(light[signal].colour));
    return;
  }
  const float mean = MeanLuminance(history.colour);
  const float scale = CompressionScale(history.compressed_scale, mean);
  if (scale != history.compressed_scale) {
    RescaleHistory(scale, &history);
  }
}

void Denoiser::Impl::RunLimitHistory() {
  const StageTimer timer(&out->timings, "limit_history");
  LimitHistoryParameters p;
  p.dead = settings.limit_dead;
  p.gain = settings.limit_gain;
  for (size_t i = 0; i < groups.size(); ++i) {
    p.scale = state.signals[i].compressed_scale;
    stages->compare_with_history(light[i], state.signals[i], taps, state.guides, p,
                                 &wavelet[i].filter[0], &wavelet[i].present);
  }
  std::array<AtrousSignal, kMostGroups> signals;
  int source = 0;
  for (int level = 0; level < kLimitHistoryLevels; ++level, source ^= 1) {
    for (size_t i = 0; i < groups.size(); ++i) {
      WaveletPlanes& w = wavelet[i];
      const FilterPlanes& from = w.filter[source];
      signals[i] = {&from.colour, &from.variance, &w.filter[source ^ 1], &w.stop, &w.present};
    }
    stages->atrous({signals.data(), groups.size()}, state.guides, GeometryLevel(level));
  }
  for (size_t i = 0; i < groups.size(); ++i) {
    WaveletPlanes& w = wavelet[i];
    stages->limit_history(w.filter[source], w.present, state.signals[i], taps, p, &w.stop);
    KeepPlane("limit", groups[i], w.stop);
  }
}

void Denoiser::Impl::GatherLight(size_t signal) {
  const SignalGroup& group = groups[signal];
  NewLight& light_of = light[signal];
  {
    const StageTimer timer(&out->timings, "demodulate");
    Count(stages->demodulate(RadianceOf(group, &light_of), &light_of));
  }
  if (settings.firefly != Firefly::kOff) {
    const StageTimer timer(&out->timings, "suppress_fireflies");
    if (settings.firefly == Firefly::kClamp) {
      stages->clamp_fireflies(light_of.colour, light_of.samples, &firefly_work, &scratch);
      std::swap(light_of.colour, scratch);
    } else {
      stages->compress_light(&light_of.colour);
    }
  }
  if (settings.limit_history) {
    UpdateCompressionScale(signal);
  }
  KeepImage("noisy", group, light_of.colour);
}

/// Leaves the history in `fetched`, and its variance where the wavelet looks for it.
void Denoiser::Impl::AccumulateRadiance(size_t signal, const AccumulateParameters& p) {
  WaveletPlanes& planes = wavelet[signal];
  const EstimateVarianceParameters of_variance = VarianceParameters();
  VarianceOnTheWay variance = {state.guides, of_variance, &planes.filter[0].variance, &planes.open};
  // Below one sample per pixel most histories are short.
  planes.has_variance = settings.wavelet == Wavelet::kSvgf && !merges_future && !IsSparse();
  Count(stages->accumulate_radiance(RadianceOf(groups[signal], &light[signal]),
                                    state.signals[signal], taps, p, &light[signal],
                                    planes.has_variance ? &variance : nullptr, &fetched));
  planes.complete = variance.complete;
}

void Denoiser::Impl::RunAccumulate(size_t signal) {
  const StageTimer timer(&out->timings, "accumulate");
  const NewLight& light_of = light[signal];
  SignalHistory* history = &state.signals[signal];
  wavelet[signal].has_variance = false;
  AccumulateParameters p;
  p.alpha_min = settings.alpha_min;
  p.alpha_moments = settings.alpha_moments;
  p.constant_weight = settings.history_weight == HistoryWeight::kConstant;
  p.max_history = settings.max_history;
  p.compressed_scale = settings.limit_history ? history->compressed_scale : 0.0f;
  if (!HasHistory()) {
    if (!fetched_is_empty) {
      fetched = EmptyHistory();
      fetched_is_empty = true;
    }
    stages->accumulate(light_of, fetched, nullptr, nullptr, p, history);
    return;
  }
  if (ChangesInPlace()) {
    p.lit_alone = !was_fed_back;
    stages->accumulate_in_place(light_of, taps, LimitOf(signal), p, &staged, history);
    return;
  }
  fetched.compressed_scale = history->compressed_scale;
  if (JoinsOnTheWay()) {
    AccumulateRadiance(signal, p);
  } else {
    stages->accumulate(light_of, *history, &taps, LimitOf(signal), p, &fetched);
  }
  std::swap(*history, fetched);
  fetched_is_empty = false;
}

/// What the history of this frame's pixels is worth after limit_history, as plain lengths and
/// weights.
SignalHistory Denoiser::Impl::ShortenedHistory(size_t signal) const {
  if (!HasHistory()) {
    return EmptyHistory();
  }
  SignalHistory shortened = EmptyHistory();
  stages->fetch_history(state.signals[signal], taps, &shortened);
  const Image1* limit = LimitOf(signal);
  for (int y = 0; limit != nullptr && y < state.height; ++y) {
    for (int x = 0; x < state.width; ++x) {
      const float most = (*limit)(x, y);
      if (most < shortened.length(x, y)) {
        shortened.length(x, y) = most;
        shortened.weights2(x, y) = std::max(shortened.weights2(x, y), 1.0f / most);
      }
    }
  }
  shortened.compressed = Image1();
  return shortened;
}

void Denoiser::Impl::FindPictureParts() {
  size_t unfiltered_count = 0;
  for (const Image3* image : {emission, background}) {
    if (!image->empty()) {
      unfiltered[unfiltered_count++] = image;
    }
  }
  for (size_t i = 0; i < groups.size(); ++i) {
    Image3* light_of_signal = wavelet[i].light;
    if (settings.firefly == Firefly::kCompress) {
      Image3* expanded = &wavelet[i].filter[wavelet[i].target].colour;
      CopyImage(*light_of_signal, expanded);
      stages->expand_light(expanded);
      light_of_signal = expanded;
    }
    filtered[i] = {light_of_signal, Albedos(groups[i])};
  }
  parts = {{filtered.data(), groups.size()},
           {unfiltered.data(), unfiltered_count},
           {Rec601(), /*add=*/false}};
}

void Denoiser::Impl::ComposePicture() {
  const StageTimer timer(&out->timings, "remodulate");
  out->non_finite +=
      stages->remodulate(parts.signals, parts.unfiltered, parts.remodulate, &picture);
  for (auto& [name, image] : composites) {
    stages->remodulate({}, parts.unfiltered, {Rec601(), /*add=*/true}, &image);
  }
}

}  // namespace stillray

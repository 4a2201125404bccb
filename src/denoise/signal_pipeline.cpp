// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The stages that run for each signal on its own: from its light to its part of the picture.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <string>

#include <fmt/format.h>

#include "core/parallel.h"
#include "denoise/denoiser_impl.h"
#include "denoise/filter_parameters.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

EdgeStopping EdgesOf(const Settings& s) {
  EdgeStopping edges;
  edges.sigma_n = s.sigma_n;
  edges.plane = s.depth_weight == DepthWeight::kPlane;
  edges.sigma_z = s.sigma_z;
  edges.plane_tolerance = s.plane_tolerance;
  edges.depth_epsilon = s.depth_epsilon;
  edges.max_slope = s.max_slope;
  return edges;
}

AtrousWeights WeightsOf(Wavelet wavelet) {
  return wavelet == Wavelet::kNaive ? AtrousWeights::kNaive
         : wavelet == Wavelet::kEaw ? AtrousWeights::kEaw
                                    : AtrousWeights::kSvgf;
}

/// Whether light is known on every surface.
bool IsComplete(const Image1& present, const GuidePlanes& guides) {
  std::atomic<bool> complete = true;
  ParallelRows(present.height(), 32, [&](int y0, int y1) {
    if (!complete) {
      return;  // another band has told
    }
    int missing = 0;
    for (int y = y0; y < y1; ++y) {
      const float* i = guides.inverse_depth.Row(y);
      const float* there = present.Row(y);
      for (int x = 0; x < present.width(); ++x) {
        missing += i[x] > 0 && there[x] == 0 ? 1 : 0;
      }
    }
    if (missing > 0) {
      complete = false;
    }
  });
  return complete;
}

/// Between the history before the last feedback and after it (PSVGF section 5).
void BlendFeedback(const SignalHistory& history, float phase, Image3* out) {
  ParallelRows(out->height(), 32, [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c) {
      for (int y = y0; y < y1; ++y) {
        const float* before = history.behind[c].Row(y);
        const float* after = history.colour[c].Row(y);
        float* to = (*out)[c].Row(y);
        for (int x = 0; x < out->width(); ++x) {
          to[x] = before[x] + phase * (after[x] - before[x]);
        }
      }
    }
  });
}

}  // namespace

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
         outputs.empty() && !ChangesInPlace();
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
  AtrousParameters geometry;
  geometry.weights = AtrousWeights::kGeometry;
  geometry.radius = kLimitHistoryRadius;
  geometry.edges = EdgesOf(settings);
  std::array<AtrousSignal, kMostGroups> signals;
  int source = 0;
  for (int level = 0; level < kLimitHistoryLevels; ++level, source ^= 1) {
    geometry.step = 1 << level;
    for (size_t i = 0; i < groups.size(); ++i) {
      WaveletPlanes& w = wavelet[i];
      const FilterPlanes& from = w.filter[source];
      signals[i] = {&from.colour, &from.variance, &w.filter[source ^ 1], &w.stop, &w.present};
    }
    stages->atrous({signals.data(), groups.size()}, state.guides, geometry);
  }
  for (size_t i = 0; i < groups.size(); ++i) {
    WaveletPlanes& w = wavelet[i];
    stages->limit_history(w.filter[source], w.present, state.signals[i], taps, p, &w.stop);
    KeepPlane("limit", groups[i], w.stop);
  }
}

PrefilterVarianceParameters Denoiser::Impl::PrefilterOf() const {
  PrefilterVarianceParameters p;
  p.smooth = settings.prefilter_variance;
  p.square_root = settings.luminance_scale == LuminanceScale::kDeviation;
  p.sigma_l = settings.sigma_l;
  p.luminance_epsilon = settings.luminance_epsilon;
  p.unbounded_below =
      settings.short_history == ShortHistory::kBlur ? ShortHistoryLength(settings) : 0.0f;
  return p;
}

AtrousParameters Denoiser::Impl::LevelParameters(int level) const {
  AtrousParameters p;
  p.step = settings.steps.step[static_cast<size_t>(level)];
  p.radius = settings.kernel == Kernel::k5x5 ? 2 : 1;
  p.weights = WeightsOf(settings.wavelet);
  p.edges = EdgesOf(settings);
  p.test_id = settings.wavelet_id;
  p.noise_ratio = settings.noise_ratio;
  p.prefilter = PrefilterOf();
  p.eaw_sigma_n = settings.eaw_sigma_n;
  p.eaw_sigma_z = settings.eaw_sigma_z;
  return p;
}

AtrousSignal Denoiser::Impl::LevelSignal(size_t signal, int level) {
  WaveletPlanes& planes = wavelet[signal];
  AtrousSignal s = {planes.light, planes.variance, &planes.filter[planes.target], nullptr,
                    planes.where};
  s.complete = planes.complete;
  s.length = &planes.history->length;
  s.eaw_sigma_l =
      settings.eaw_sigma_l * planes.mean_luminance * std::exp2f(static_cast<float>(-level));
  s.grown = IsSparse() && !planes.complete ? &planes.grown : nullptr;
  return s;
}

/// Runs a level, or two at once.
/// \return how many
int Denoiser::Impl::RunLevels(int first) {
  std::array<AtrousSignal, kMostGroups> of_level;
  const std::span<AtrousSignal> signals(of_level.data(), groups.size());
  bool pair = first + 1 < settings.steps.count && settings.wavelet == Wavelet::kSvgf &&
              StopsOnTheWay() && outputs.empty();
  for (size_t i = 0; i < signals.size(); ++i) {
    signals[i] = LevelSignal(i, first);
    pair = pair && signals[i].complete;
  }
  if (pair && stages->pair_pays(signals, state.guides, LevelParameters(first),
                                LevelParameters(first + 1))) {
    RunPair(signals, first);
    return 2;
  }
  RunLevel(signals, first);
  return 1;
}

/// Where the light that is fed back goes while levels go on: room that none of them reads.
Image3* Denoiser::Impl::RoomToKeep(size_t signal) {
  WaveletPlanes& planes = wavelet[signal];
  SignalHistory& history = *planes.history;
  if (!history.behind.empty()) {
    return &history.behind;
  }
  const bool reads_history = planes.light == &history.colour;
  return reads_history ? &planes.filter[planes.target ^ 1].colour : &history.colour;
}

/// See KeepLevel for what becomes of the history.
void Denoiser::Impl::RunPair(std::span<AtrousSignal> signals, int first) {
  const bool keep = feeds_back && settings.feedback == first + 1;
  for (size_t i = 0; i < signals.size() && keep; ++i) {
    signals[i].kept = RoomToKeep(i);
  }
  {
    const StageTimer timer(&out->timings, "atrous");
    stages->atrous_pair(signals, state.guides, LevelParameters(first), LevelParameters(first + 1));
  }
  for (size_t i = 0; i < signals.size(); ++i) {
    if (keep && signals[i].kept != &wavelet[i].history->colour) {
      std::swap(wavelet[i].history->colour, *signals[i].kept);
    }
    FinishLevel(signals[i], &wavelet[i]);
  }
}

void Denoiser::Impl::FinishLevel(const AtrousSignal& signal, WaveletPlanes* planes) {
  FilterPlanes& filtered = planes->filter[planes->target];
  planes->light = &filtered.colour;
  planes->variance = &filtered.variance;
  planes->target ^= 1;
  if (signal.grown != nullptr) {
    std::swap(planes->present, planes->grown);
    planes->complete = IsComplete(planes->present, state.guides);
  }
}

void Denoiser::Impl::RunLevel(std::span<AtrousSignal> signals, int level) {
  const AtrousParameters p = LevelParameters(level);
  for (size_t i = 0; i < signals.size() && !StopsOnTheWay(); ++i) {
    const StageTimer timer(&out->timings, "prefilter_variance");
    stages->prefilter_variance(PrefilterInputOf(signals[i], state.guides), p.prefilter,
                               &wavelet[i].stop);
    signals[i].stop = &wavelet[i].stop;
  }
  const StageTimer timer(&out->timings, "atrous");
  stages->atrous(signals, state.guides, p);
  for (size_t i = 0; i < signals.size(); ++i) {
    FinishLevel(signals[i], &wavelet[i]);
  }
}

/// What is wanted of a level's output besides the next level.
void Denoiser::Impl::KeepLevel(int level) {
  const std::string name = outputs.empty() ? "" : fmt::format("atrous{}", level + 1);
  const bool wanted = Wants(name);
  for (size_t i = 0; i < groups.size(); ++i) {
    WaveletPlanes& planes = wavelet[i];
    SignalHistory* history = planes.history;
    if (settings.feedback == level + 1 && feeds_back) {
      if (!history->behind.empty()) {
        std::swap(history->colour, history->behind);
      }
      // What was the history is room for another level now.
      std::swap(history->colour, *planes.light);
      planes.light = &history->colour;
    }
    if (wanted) {
      AddSignal(groups[i], *planes.light, Composite(name));
    }
  }
}

/// Marks where there is light, if that is not everywhere.
void Denoiser::Impl::FindPresent(WaveletPlanes* planes) const {
  const Image1& surface = state.guides.inverse_depth;
  const Image1& length = planes->history->length;
  planes->where = planes->complete ? &surface : &planes->present;
  if (planes->complete) {
    return;
  }
  ParallelRows(state.height, 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float* i = surface.Row(y);
      const float* samples = length.Row(y);
      float* to = planes->present.Row(y);
      for (int x = 0; x < state.width; ++x) {
        to[x] = i[x] > 0 && samples[x] > 0 ? 1.0f : 0.0f;
      }
    }
  });
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

void Denoiser::Impl::BeginFilter(size_t signal, SignalHistory* history) {
  const SignalGroup& group = groups[signal];
  KeepImage("accumulated", group, history->colour);
  KeepPlane("history", group, history->length);
  KeepPlane("moment_mean", group, history->mean);
  KeepPlane("moment_variance", group, history->variance);
  if (Wants("temporal")) {
    AddSignal(group, history->colour, Composite("temporal"));
  }
  WaveletPlanes& planes = wavelet[signal];
  planes.history = history;
  planes.light = &history->colour;
  planes.variance = &planes.filter[0].variance;
  planes.target = 1;
  if (settings.wavelet == Wavelet::kOff) {
    return;
  }
  if (IsSparse() && (planes.grown.width() != state.width || planes.grown.height() != state.height ||
                     planes.grown.border() != planes.present.border())) {
    planes.grown = Image1(state.width, state.height, planes.present.border());
  }
  if (settings.wavelet == Wavelet::kEaw) {
    planes.mean_luminance = MeanLuminance(history->colour);
  }
  if (feedback_phase < 1 && !history->behind.empty()) {
    BlendFeedback(*history, feedback_phase, &planes.filter[0].colour);
    planes.light = &planes.filter[0].colour;
  }
}

EstimateVarianceParameters Denoiser::Impl::VarianceParameters() const {
  EstimateVarianceParameters p;
  p.of_mean = settings.variance_of == VarianceOf::kMean;
  p.spatial = settings.short_history == ShortHistory::kSpatial;
  p.short_length = ShortHistoryLength(settings);
  p.least_evidence = IsSparse() ? kLeastEvidence : 0.0f;
  p.boost = settings.short_history_boost;
  p.edges = EdgesOf(settings);
  return p;
}

void Denoiser::Impl::RunEstimateVariance() {
  const StageTimer timer(&out->timings, "estimate_variance");
  std::array<VarianceSignal, kMostGroups> signals;
  for (size_t i = 0; i < groups.size(); ++i) {
    const WaveletPlanes& planes = wavelet[i];
    signals[i] = {planes.history, frame->samples.empty() ? nullptr : &light[i].samples,
                  planes.variance, planes.has_variance ? &planes.open : nullptr, planes.complete};
  }
  stages->estimate_variance({signals.data(), groups.size()}, state.guides, VarianceParameters());
  for (size_t i = 0; i < groups.size(); ++i) {
    wavelet[i].complete = signals[i].complete;
    KeepPlane("variance", groups[i], *wavelet[i].variance);
  }
}

void Denoiser::Impl::FilterSignals() {
  if (settings.wavelet == Wavelet::kOff) {
    return;
  }
  if (settings.wavelet == Wavelet::kSvgf) {
    RunEstimateVariance();
  }
  for (size_t i = 0; i < groups.size(); ++i) {
    WaveletPlanes& planes = wavelet[i];
    if (settings.wavelet != Wavelet::kSvgf) {
      planes.complete = IsComplete(planes.history->length, state.guides);
    }
    FindPresent(&planes);
  }
  for (int level = 0; level < settings.steps.count;) {
    level += RunLevels(level);
    KeepLevel(level - 1);
  }
  for (size_t i = 0; i < groups.size(); ++i) {
    KeepImage("filtered", groups[i], *wavelet[i].light);
    KeepPlane("filtered_variance", groups[i], *wavelet[i].variance);
  }
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

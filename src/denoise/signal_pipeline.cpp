// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The stages that run for each signal on its own: from its light to its part of the picture.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "core/colour_shared.h"
#include "core/parallel.h"
#include "denoise/denoiser_impl.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

/// Mean luminance in double precision, rows added in order; a small positive number for a black
/// image.
float MeanLuminance(const Image3& image) {
  std::vector<double> rows(static_cast<size_t>(image.height()));
  ParallelRows(image.height(), 8, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      double sum = 0;
      for (int x = 0; x < image.width(); ++x) {
        sum += Luminance709(image[0](x, y), image[1](x, y), image[2](x, y));
      }
      rows[static_cast<size_t>(y)] = sum;
    }
  });
  double total = 0;
  for (const double row : rows) {
    total += row;
  }
  const double mean = total / (static_cast<double>(image.width()) * image.height());
  return static_cast<float>(std::max(mean, 1e-20));
}

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

/// Samples that the 7x7 neighbourhood must have below one per pixel.
constexpr float kLeastEvidence = 4.0f;

/// Lengths are means of whole numbers with weights that sum to one but for rounding: a little less
/// than the limit is no short history, or roundings would decide.
float ShortHistoryLength(const Settings& s) {
  constexpr float kRounding = 1e-3f;
  return static_cast<float>(s.short_history_length) - kRounding;
}

AtrousWeights WeightsOf(Wavelet wavelet) {
  return wavelet == Wavelet::kNaive ? AtrousWeights::kNaive
         : wavelet == Wavelet::kEaw ? AtrousWeights::kEaw
                                    : AtrousWeights::kSvgf;
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

Image3* Denoiser::Impl::Composite(const std::string& name) {
  for (auto& [known, image] : composites) {
    if (known == name) {
      return &image;
    }
  }
  composites.emplace_back(name, Image3(state.width, state.height));
  return &composites.back().second;
}

void Denoiser::Impl::KeepPlane(const std::string& kind, const SignalGroup& group,
                               const Image1& plane) {
  const std::string name = kind + "." + group.name;
  if (Wants(name)) {
    Image1 copy(state.width, state.height);
    for (int y = 0; y < state.height; ++y) {
      std::copy_n(plane.Row(y), state.width, copy.Row(y));
    }
    out->images.push_back({name, {std::move(copy)}});
  }
}

void Denoiser::Impl::KeepImage(const std::string& kind, const SignalGroup& group,
                               const Image3& image) {
  const std::string name = kind + "." + group.name;
  if (Wants(name)) {
    Image3 copy(state.width, state.height);
    CopyImage(image, &copy);
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
  stages->remodulate(*expanded, Albedos(group), sum);
}

void Denoiser::Impl::RunDemodulate(const SignalGroup& group) {
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
  in.samples = frame->samples.empty() ? nullptr : &frame->samples;
  if (within && light.within.empty()) {
    light.within = Image1(state.width, state.height);
  } else if (!within) {
    light.within = Image1();
  }
  const DemodulateCounts counts = stages->demodulate(in, &light);
  out->non_finite += counts.non_finite;
  out->negative += counts.negative;
}

/// Chooses fetched.compressed_scale and brings the fetched history to it.
void Denoiser::Impl::UpdateCompressionScale(const SignalHistory& history, bool has_history) {
  const float mean = MeanLuminance(has_history ? fetched.colour : light.colour);
  fetched.compressed_scale = has_history ? history.compressed_scale : 0.0f;
  const float scale = CompressionScale(fetched.compressed_scale, mean);
  if (scale != fetched.compressed_scale) {
    RescaleHistory(scale, &fetched);
  }
}

void Denoiser::Impl::RunLimitHistory() {
  LimitHistoryParameters p;
  p.scale = fetched.compressed_scale;
  p.dead = settings.limit_dead;
  p.gain = settings.limit_gain;
  p.rec601 = settings.luminance == LuminanceWeights::kRec601;
  stages->compare_with_history(light, fetched, state.guides, p, &filter[0], &present);
  AtrousParameters geometry;
  geometry.weights = AtrousWeights::kGeometry;
  geometry.edges = EdgesOf(settings);
  int source = 0;
  for (int level = 0; level < kLimitHistoryLevels; ++level, source ^= 1) {
    geometry.step = 1 << level;
    stages->atrous(filter[source], spread, present, state.guides, geometry, &filter[source ^ 1]);
  }
  stages->limit_history(filter[source], present, fetched, p, &limit);
}

void Denoiser::Impl::RunLevel(int level, float mean_luminance, const SignalHistory& history,
                              int source) {
  if (settings.wavelet == Wavelet::kSvgf) {
    const StageTimer timer(&out->timings, "prefilter_variance");
    PrefilterVarianceParameters p;
    p.smooth = settings.prefilter_variance;
    p.square_root = settings.luminance_scale == LuminanceScale::kDeviation;
    p.unbounded_below =
        settings.short_history == ShortHistory::kBlur ? ShortHistoryLength(settings) : 0.0f;
    stages->prefilter_variance(filter[source].variance, present, history.length, p, &spread);
  }
  const StageTimer timer(&out->timings, "atrous");
  AtrousParameters p;
  p.step = settings.steps.step[static_cast<size_t>(level)];
  p.radius = settings.kernel == Kernel::k5x5 ? 2 : 1;
  p.weights = WeightsOf(settings.wavelet);
  p.edges = EdgesOf(settings);
  p.test_id = settings.wavelet_id;
  p.sigma_l = settings.sigma_l;
  p.noise_ratio = settings.noise_ratio;
  p.luminance_epsilon = settings.luminance_epsilon;
  p.rec601 = settings.luminance == LuminanceWeights::kRec601;
  p.eaw_sigma_l = settings.eaw_sigma_l * mean_luminance * std::exp2f(static_cast<float>(-level));
  p.eaw_sigma_n = settings.eaw_sigma_n;
  p.eaw_sigma_z = settings.eaw_sigma_z;
  p.grown = IsSparse() ? &grown : nullptr;
  stages->atrous(filter[source], spread, present, state.guides, p, &filter[source ^ 1]);
  if (p.grown != nullptr) {
    std::swap(present, grown);
  }
}

void Denoiser::Impl::RunWavelet(const SignalGroup& group, SignalHistory* history) {
  ParallelRows(state.height, 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float* i = state.guides.inverse_depth.Row(y);
      const float* length = history->length.Row(y);
      float* to = present.Row(y);
      for (int x = 0; x < state.width; ++x) {
        to[x] = i[x] > 0 && length[x] > 0 ? 1.0f : 0.0f;
      }
    }
  });
  if (feedback_phase < 1 && !history->behind.empty()) {
    BlendFeedback(*history, feedback_phase, &filter[0].colour);
  } else {
    CopyImage(history->colour, &filter[0].colour);
  }
  if (IsSparse() && (grown.width() != state.width || grown.height() != state.height ||
                     grown.border() != present.border())) {
    grown = Image1(state.width, state.height, present.border());
  }
  const float mean = settings.wavelet == Wavelet::kEaw ? MeanLuminance(history->colour) : 1.0f;
  int source = 0;
  for (int level = 0; level < settings.steps.count; ++level, source ^= 1) {
    RunLevel(level, mean, *history, source);
    const Image3& filtered = filter[source ^ 1].colour;
    if (settings.feedback == level + 1 && feeds_back) {
      if (!history->behind.empty()) {
        CopyImage(history->colour, &history->behind);
      }
      CopyImage(filtered, &history->colour);
    }
    const std::string name = fmt::format("atrous{}", level + 1);
    if (Wants(name)) {
      AddSignal(group, filtered, Composite(name));
    }
  }
  KeepImage("filtered", group, filter[source].colour);
  KeepPlane("filtered_variance", group, filter[source].variance);
  const StageTimer timer(&out->timings, "remodulate");
  AddSignal(group, filter[source].colour, &picture);
}

bool Denoiser::Impl::GatherLight(const SignalGroup& group, const SignalHistory& history) {
  {
    const StageTimer timer(&out->timings, "demodulate");
    RunDemodulate(group);
  }
  if (settings.firefly != Firefly::kOff) {
    const StageTimer timer(&out->timings, "suppress_fireflies");
    if (settings.firefly == Firefly::kClamp) {
      stages->clamp_fireflies(light.colour, light.samples, &scratch);
      std::swap(light.colour, scratch);
    } else {
      stages->compress_light(&light.colour);
    }
  }
  const bool has_history = settings.temporal && state.has_history;
  {
    const StageTimer timer(&out->timings, "reproject");
    if (has_history) {
      stages->fetch_history(history, taps, &fetched);
    } else {
      fetched = SignalHistory(state.width, state.height, settings.limit_history,
                              BlendsFeedback(settings));
    }
  }
  if (settings.limit_history) {
    UpdateCompressionScale(history, has_history);
  }
  const bool limited = has_history && settings.limit_history;
  if (limited) {
    const StageTimer timer(&out->timings, "limit_history");
    RunLimitHistory();
    KeepPlane("limit", group, limit);
  }
  KeepImage("noisy", group, light.colour);
  return limited;
}

void Denoiser::Impl::RunAccumulate(bool limited, SignalHistory* history) {
  const StageTimer timer(&out->timings, "accumulate");
  AccumulateParameters p;
  p.alpha_min = settings.alpha_min;
  p.alpha_moments = settings.alpha_moments;
  p.constant_weight = settings.history_weight == HistoryWeight::kConstant;
  p.max_history = settings.max_history;
  p.rec601 = settings.luminance == LuminanceWeights::kRec601;
  p.compressed_scale = fetched.compressed_scale;
  stages->accumulate(light, fetched, limited ? &limit : nullptr, p, history);
  history->compressed_scale = fetched.compressed_scale;
}

/// What `fetched` is worth after limit_history, as plain lengths and weights.
SignalHistory Denoiser::Impl::ShortenedHistory(bool limited) const {
  SignalHistory shortened = fetched;
  shortened.compressed = Image1();
  for (int y = 0; limited && y < state.height; ++y) {
    for (int x = 0; x < state.width; ++x) {
      const float most = limit(x, y);
      if (most < shortened.length(x, y)) {
        shortened.length(x, y) = most;
        shortened.weights2(x, y) = std::max(shortened.weights2(x, y), 1.0f / most);
      }
    }
  }
  return shortened;
}

void Denoiser::Impl::FilterSignal(const SignalGroup& group, SignalHistory* history) {
  KeepImage("accumulated", group, history->colour);
  KeepPlane("history", group, history->length);
  KeepPlane("moment_mean", group, history->mean);
  KeepPlane("moment_variance", group, history->variance);
  if (Wants("temporal")) {
    AddSignal(group, history->colour, Composite("temporal"));
  }
  if (settings.wavelet == Wavelet::kOff) {
    const StageTimer timer(&out->timings, "remodulate");
    AddSignal(group, history->colour, &picture);
    return;
  }
  if (settings.wavelet == Wavelet::kSvgf) {
    const StageTimer timer(&out->timings, "estimate_variance");
    EstimateVarianceParameters p;
    p.of_mean = settings.variance_of == VarianceOf::kMean;
    p.spatial = settings.short_history == ShortHistory::kSpatial;
    p.short_length = ShortHistoryLength(settings);
    p.least_evidence = IsSparse() ? kLeastEvidence : 0.0f;
    p.boost = settings.short_history_boost;
    p.edges = EdgesOf(settings);
    stages->estimate_variance(*history, light.samples, state.guides, p, &filter[0].variance);
    KeepPlane("variance", group, filter[0].variance);
  }
  RunWavelet(group, history);
}

}  // namespace stillray

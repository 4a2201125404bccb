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
#include <chrono>
#include <cstring>

#include <fmt/format.h>

#include "core/check.h"
#include "core/colour_shared.h"
#include "core/parallel.h"
#include "denoise/denoiser_state.h"
#include "denoise/frame_check.h"
#include "denoise/history_bytes.h"
#include "denoise/signal_groups.h"
#include "denoise/stage_table.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

/// Adds the time from its making to its end to the stage of that name.
class StageTimer {
 public:
  StageTimer(std::vector<StageTime>* times, const char* name) : times_(times), name_(name) {}
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;
  ~StageTimer() {
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start_;
    const auto at = std::find_if(times_->begin(), times_->end(),
                                 [&](const StageTime& t) { return t.name == name_; });
    if (at == times_->end()) {
      times_->push_back({name_, elapsed.count()});
    } else {
      at->milliseconds += elapsed.count();
    }
  }

 private:
  std::vector<StageTime>* times_;
  const char* name_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

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

void CopyImage(const Image3& from, Image3* to) {
  ParallelRows(from.height(), 32, [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c) {
      for (int y = y0; y < y1; ++y) {
        std::copy_n(from[c].Row(y), from.width(), (*to)[c].Row(y));
      }
    }
  });
}

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

constexpr int kLimitHistoryLevels = 3;

/// Border that the wavelet needs with these settings.
int BorderOf(const Settings& s) {
  const int longest = *std::max_element(s.steps.step.begin(), s.steps.step.begin() + s.steps.count);
  const int radius = s.kernel == Kernel::k5x5 ? 2 : 1;
  return std::max(longest * radius, 2 << (kLimitHistoryLevels - 1));
}

}  // namespace

struct Denoiser::Impl {
  Settings settings;
  const StageTable* stages = &kCpuStages;
  std::vector<std::string> outputs;
  DenoiserState state;

  // Work planes, kept between frames so that nothing is allocated in the steady state.
  ReprojectionTaps taps;
  NewLight light;
  SignalHistory fetched;
  FilterPlanes filter[2];
  Image1 spread;
  Image1 present;
  Image1 limit;
  Image3 scratch;
  Image3 picture;

  // The frame in progress.
  const Frame* frame = nullptr;
  DenoisedFrame* out = nullptr;

  void Allocate(int width, int height, size_t groups);
  void RunSignal(const SignalGroup& group, SignalHistory* history);
  void RunDemodulate(const SignalGroup& group);
  void UpdateCompressionScale(const SignalHistory& history, bool has_history);
  void RunLimitHistory();
  void RunWavelet(const SignalGroup& group, SignalHistory* history);
  void RunLevel(int level, float mean_luminance, const SignalHistory& history, int source);
  void RunAntialias();
  AlbedoSum Albedos(const SignalGroup& group) const;
  void AddSignal(const SignalGroup& group, const Image3& light_in, Image3* sum);

  bool Wants(const std::string& name) const {
    return std::find(outputs.begin(), outputs.end(), name) != outputs.end();
  }
  /// The composite picture called `name` among the outputs, made on first use.
  Image3* Composite(const std::string& name);
  void KeepPlane(const std::string& kind, const SignalGroup& group, const Image1& plane);
  void KeepImage(const std::string& kind, const SignalGroup& group, const Image3& image);
  size_t WorkBytes() const;

  // Composites of several signals while a frame is in progress.
  std::vector<std::pair<std::string, Image3>> composites;
};

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
  const Guides& g = frame->guides;
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
    const Image3& own = AlbedoOf(frame->guides, kind);
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
    p.unbounded_below = settings.short_history == ShortHistory::kBlur
                            ? static_cast<float>(settings.short_history_length)
                            : 0.0f;
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
  stages->atrous(filter[source], spread, present, state.guides, p, &filter[source ^ 1]);
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
  CopyImage(history->colour, &filter[0].colour);
  const float mean = settings.wavelet == Wavelet::kEaw ? MeanLuminance(history->colour) : 1.0f;
  int source = 0;
  for (int level = 0; level < settings.steps.count; ++level, source ^= 1) {
    RunLevel(level, mean, *history, source);
    const Image3& filtered = filter[source ^ 1].colour;
    if (settings.feedback == level + 1 && settings.temporal) {
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

void Denoiser::Impl::RunSignal(const SignalGroup& group, SignalHistory* history) {
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
      stages->fetch_history(*history, taps, &fetched);
    } else {
      fetched = SignalHistory(state.width, state.height, settings.limit_history);
    }
  }
  if (settings.limit_history) {
    UpdateCompressionScale(*history, has_history);
  }
  const bool limited = has_history && settings.limit_history;
  if (limited) {
    const StageTimer timer(&out->timings, "limit_history");
    RunLimitHistory();
    KeepPlane("limit", group, limit);
  }
  {
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
  KeepImage("noisy", group, light.colour);
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
    p.short_length = static_cast<float>(settings.short_history_length);
    p.boost = settings.short_history_boost;
    p.edges = EdgesOf(settings);
    stages->estimate_variance(*history, light.samples, state.guides, p, &filter[0].variance);
    KeepPlane("variance", group, filter[0].variance);
  }
  RunWavelet(group, history);
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

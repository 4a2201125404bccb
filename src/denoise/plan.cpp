// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/plan.h"

#include <algorithm>
#include <cmath>

#include "core/guides.h"
#include "denoise/row_sums.h"
#include "denoise/stages/keep_mirrors.h"
#include "denoise/stages/keep_samples.h"
#include "denoise/stages/limit_history.h"
#include "denoise/stages/restore_detail.h"

namespace stillray {
namespace {

/// Numbers of samples are integers, or means of integers, with rounding errors. Thresholds for them
/// are lowered by this tolerance.
constexpr float kSampleRounding = 1e-3f;

/// Minimum number of samples in the neighbourhood that estimates the variance of short histories,
/// for frames with less than one sample per pixel.
constexpr float kLeastEvidence = 4.0f - kSampleRounding;

/// One sample per pixel, less the rounding error of its sum over the frames of a cycle.
constexpr float kWholeSample = 1.0f - 1e-4f;

constexpr float kRadiansPerDegree = 0.017453293f;

int Int(bool on) {
  return on ? 1 : 0;
}

int WeightsOf(Wavelet wavelet) {
  switch (wavelet) {
    case Wavelet::kEaw:
      return kAtrousEaw;
    case Wavelet::kSvgf:
      return kAtrousSvgf;
    case Wavelet::kNaive:
    case Wavelet::kOff:
      break;
  }
  return kAtrousNaive;
}

EdgeStopping EdgesOf(const Settings& s, const FrameFacts& facts) {
  return {.sigma_n = s.sigma_n,
          .curvature = s.curvature,
          .depth_weight_plane = Int(s.depth_weight == DepthWeight::kPlane),
          .sigma_z = s.sigma_z,
          .plane_tolerance = s.plane_tolerance,
          .depth_epsilon = s.depth_epsilon,
          .max_slope = s.max_slope,
          .depth_weight_position = Int(s.depth_weight == DepthWeight::kPosition),
          .position_sigma = s.position_sigma,
          .focal_pixels = facts.focal_pixels,
          .centre_x = 0.5f * static_cast<float>(facts.width),
          .centre_y = 0.5f * static_cast<float>(facts.height)};
}

/// Second differences need samples in three consecutive pixels, which sparse frames rarely have:
/// the variance over a wider neighbourhood replaces them there.
int ShortHistoryOf(const Settings& s, bool is_sparse) {
  switch (s.short_history) {
    case ShortHistory::kBlur:
      return kShortHistoryNone;
    case ShortHistory::kSecondDifference:
      return is_sparse ? kShortHistorySpread : kShortHistorySecondDifference;
    case ShortHistory::kSpatial:
      break;
  }
  return kShortHistorySpread;
}

int ShortHistoryRadius(const Settings& s, bool is_sparse) {
  const bool replaced = is_sparse && s.short_history == ShortHistory::kSecondDifference;
  return replaced || s.short_history_window == ShortHistoryWindow::k7x7 ? 3 : 2;
}

float ShortHistoryLength(const Settings& s) {
  return static_cast<float>(s.short_history_length) - kSampleRounding;
}

bool IsTransmitted(SignalKind kind) {
  return kind == SignalKind::kDirectTransmission || kind == SignalKind::kIndirectTransmission;
}

/// Light that varies slowly, from few bright samples: indirect diffuse light, also through glass.
bool IsSmooth(SignalKind kind) {
  return kind == SignalKind::kIndirectDiffuse || IsTransmitted(kind);
}

constexpr uint32_t kReflectedLights = 1u << static_cast<uint32_t>(SignalKind::kDirectSpecular) |
                                      1u << static_cast<uint32_t>(SignalKind::kIndirectSpecular);

bool IsReflected(SignalKind kind) {
  return kind == SignalKind::kDirectSpecular || kind == SignalKind::kIndirectSpecular;
}

/// Bit mask of the signals that contain light of the given kinds only.
/// \param lights  FrameFacts::lights
int SignalsOfOnly(bool (*is_one)(SignalKind), std::span<const SignalGroup> signals,
                  uint32_t lights) {
  int mask = 0;
  for (size_t i = 0; i < signals.size(); ++i) {
    bool any = false;
    bool all = true;
    for (const SignalKind kind : signals[i].kinds) {
      if ((lights >> static_cast<uint32_t>(kind) & 1u) != 0) {
        any = true;
        all = all && is_one(kind);
      }
    }
    mask |= any && all ? 1 << i : 0;
  }
  return mask;
}

/// Bit mask of the signals with direct lighting, which has sharp shadows and highlights.
int FineSignals(std::span<const SignalGroup> signals, uint32_t lights) {
  int mask = 0;
  for (size_t i = 0; i < signals.size(); ++i) {
    for (const SignalKind kind : signals[i].kinds) {
      const bool given = (lights >> static_cast<uint32_t>(kind) & 1u) != 0;
      const bool direct = kind == SignalKind::kDirectDiffuse || kind == SignalKind::kDirectSpecular;
      mask |= given && direct ? 1 << i : 0;
    }
  }
  return mask;
}

/// Bit mask of the signals with reflected or refracted light.
int MirrorSignals(std::span<const SignalGroup> signals, uint32_t lights) {
  int mask = 0;
  for (size_t i = 0; i < signals.size(); ++i) {
    for (const SignalKind kind : signals[i].kinds) {
      const bool given = (lights >> static_cast<uint32_t>(kind) & 1u) != 0;
      mask |= given && IsSharpAtMirrors(kind) ? 1 << i : 0;
    }
  }
  return mask;
}

/// Bit mask of the signals with any of these lights.
int SignalsOf(std::span<const SignalGroup> signals, uint32_t lights) {
  int mask = 0;
  for (size_t i = 0; i < signals.size(); ++i) {
    for (const SignalKind kind : signals[i].kinds) {
      mask |= (lights >> static_cast<uint32_t>(kind) & 1u) != 0 ? 1 << i : 0;
    }
  }
  return mask;
}

bool HasTransmission(uint32_t lights) {
  constexpr uint32_t kTransmission = 1u << static_cast<uint32_t>(SignalKind::kDirectTransmission) |
                                     1u << static_cast<uint32_t>(SignalKind::kIndirectTransmission);
  return (lights & kTransmission) != 0;
}

/// The source of a signal's guides: a virtual image only if it applies to all light of the signal.
GuideSource SourceOf(const SignalGroup& signal, const FrameFacts& facts) {
  const bool reflected = signal.specular_albedo && !signal.diffuse_albedo;
  const bool refracted = signal.transmission_albedo && !signal.diffuse_albedo;
  if (reflected && !refracted && facts.has_reflection) {
    return GuideSource::kReflection;
  }
  return refracted && !reflected && facts.has_refraction ? GuideSource::kRefraction
                                                         : GuideSource::kSurface;
}

/// Bit mask of the reflected signals under guides of virtual images. Frames of reflected light
/// alone are layers that a device denoises by themselves.
int ImageSignals(const Settings& s, std::span<const SignalGroup> signals, const FrameFacts& facts) {
  const bool is_layer =
      facts.has_roughness && facts.lights != 0 && (facts.lights & ~kReflectedLights) == 0;
  int mask = 0;
  for (size_t i = 0; i < signals.size(); ++i) {
    const bool has_images =
        s.virtual_roughness > 0 && SourceOf(signals[i], facts) == GuideSource::kReflection;
    mask |= has_images || is_layer ? 1 << i : 0;
  }
  return mask & SignalsOfOnly(IsReflected, signals, facts.lights);
}

/// Whether keep_samples runs: it needs second moments of several samples per pixel. Samples under
/// firefly=compress are biased, so they are not kept.
bool RunsKeepSamples(const Settings& s, const FrameFacts& facts) {
  return s.keep_samples && s.wavelet != Wavelet::kOff && s.firefly != Firefly::kCompress &&
         facts.second_moments != 0 && facts.samples_per_pixel >= kFewestKept - kSampleRounding;
}

/// Divisor of sigma_l, which is relative to the standard deviation of the noise. With a constant
/// sigma_l the bias of the filter would not decrease with the noise. The bandwidth that minimises
/// the mean squared error (variance plus squared bias) falls with a power of the noise; the cube
/// root of the samples per pixel has the least error for 4 to 256 samples (docs/denoiser.md,
/// keep_samples).
float FallOfSigmaL(const Settings& s, const FrameFacts& facts) {
  return s.variance_of == VarianceOf::kMean ? std::cbrt(std::max(facts.samples_per_pixel, 1.0f))
                                            : 1.0f;
}

/// The stages that run. \param now  the progress with this frame's jitter
StagesRun StagesOf(const Settings& s, const FrameFacts& facts, const SequenceProgress& now,
                   bool sparse) {
  const bool has_history = s.temporal && now.has_history;
  return {.fill_guides = s.fill_guides && facts.has_incomplete_guides,
          .reproject = has_history,
          .clamp_fireflies = s.firefly == Firefly::kClamp,
          .compress_light = s.firefly == Firefly::kCompress,
          .limit_history = s.limit_history && has_history,
          .find_moving_light = s.limit_history && has_history &&
                               FindsMovingLight(Int(s.correct_history), Int(sparse)),
          .merge_future = facts.has_future,
          .wavelet = s.wavelet != Wavelet::kOff,
          .estimate_variance = s.wavelet == Wavelet::kSvgf,
          .smooth_variance =
              s.wavelet == Wavelet::kSvgf && s.prefilter_variance == PrefilterVariance::kOnce,
          .measure_luminance = s.wavelet == Wavelet::kEaw,
          .clip_outliers = s.clip_outliers > 0 && s.wavelet == Wavelet::kSvgf,
          .restore_energy = RestoresEnergy(s),
          .keep_samples = RunsKeepSamples(s, facts),
          .keep_mirrors = s.mirror_roughness > 0 && facts.has_roughness,
          .restore_detail = s.restore_detail && s.temporal && s.wavelet != Wavelet::kOff,
          .fxaa = s.fxaa == Fxaa::kOn || (s.fxaa == Fxaa::kSparse && sparse),
          .antialias = AntialiasesInTime(s, now.jittered),
          .tonemap = facts.is_displayed};
}

/// The number of signals with diffuse light, which come first. Specular reflections do not count:
/// they move over the surface.
/// \param lights  FrameFacts::lights; ~0: all
int DiffuseSignals(std::span<const SignalGroup> signals, uint32_t lights) {
  const auto is_diffuse = [&](const SignalGroup& group) {
    return std::any_of(group.kinds.begin(), group.kinds.end(), [&](SignalKind kind) {
      const bool diffuse =
          kind == SignalKind::kDirectDiffuse || kind == SignalKind::kIndirectDiffuse;
      return diffuse && (lights >> static_cast<uint32_t>(kind) & 1u) != 0;
    });
  };
  const auto end = std::find_if_not(signals.begin(), signals.end(), is_diffuse);
  return static_cast<int>(end - signals.begin());
}

/// Whether the frame, or the part of it, has images whose albedo is summed.
bool SumsImages(const FrameFacts& facts, const FramePlan& plan) {
  const bool reflects = std::any_of(
      plan.layers.begin(), plan.layers.end(),
      [](const PlannedLayer& layer) { return layer.guides == GuideSource::kReflection; });
  return (reflects && SumsImageAlbedo(facts.albedos, plan.runs.fill_guides)) ||
         facts.albedo_of_images;
}

void PlanSignals(const Settings& s, const FrameFacts& facts, FramePlan* plan) {
  plan->demodulate = {.demodulate = Int(s.demodulate),
                      .luminance_rec601 = Int(s.luminance == LuminanceWeights::kRec601),
                      .firefly = static_cast<int>(s.firefly)};
  plan->select_guides = SelectGuidesOf(s, GuideSource::kReflection);
  plan->reproject = {.history_depth = s.history_depth,
                     .history_normal_cosine = std::cos(s.history_normal * kRadiansPerDegree),
                     .history_id = Int(s.history_id),
                     .history_search = Int(s.history_search),
                     .history_taps_nearest = Int(s.history_taps == HistoryTaps::kNearest)};
  plan->limit_history = {
      .correct_history = Int(s.correct_history),
      .limit_dead = s.limit_dead,
      .limit_gain = s.limit_gain,
      .has_roughness = Int(facts.has_roughness),
      .jitter_x = facts.jitter_x,
      .jitter_y = facts.jitter_y,
      .wide_signals = DiffuseSignals(plan->signals, facts.lights),
      .fine_signals = plan->is_sparse ? 0 : FineSignals(plan->signals, facts.lights)};
  plan->compared.edges.sigma_n = kComparedSigmaN;
  plan->compared.edges.depth_weight_plane = 1;
  plan->compared.edges.plane_tolerance = kComparedTolerance;
  plan->accumulate = {.alpha_min = s.alpha_min,
                      .alpha_moments = s.alpha_moments,
                      .history_weight_constant = Int(s.history_weight == HistoryWeight::kConstant),
                      .max_history = s.max_history};
}

void PlanWavelet(const Settings& s, const FrameFacts& facts, FramePlan* plan) {
  plan->estimate_variance = {.edges = EdgesOf(s, facts),
                             .variance_of_mean = Int(s.variance_of == VarianceOf::kMean),
                             .short_history = ShortHistoryOf(s, plan->is_sparse),
                             .short_history_length = ShortHistoryLength(s),
                             .short_history_boost = s.short_history_boost,
                             .least_evidence = plan->is_sparse ? kLeastEvidence : 0.0f,
                             .short_history_radius = ShortHistoryRadius(s, plan->is_sparse)};
  plan->prefilter_variance = {
      .prefilter_variance = Int(s.prefilter_variance == PrefilterVariance::kOn),
      .luminance_scale_deviation = Int(s.luminance_scale == LuminanceScale::kDeviation),
      .sigma_l = s.sigma_l / FallOfSigmaL(s, facts),
      .luminance_epsilon = s.luminance_epsilon,
      .luminance_floor = s.luminance_floor,
      .short_history_blur = s.short_history == ShortHistory::kBlur ? ShortHistoryLength(s) : 0.0f,
      .volume_signals = SignalsOfOnly(IsTransmitted, plan->signals, facts.lights),
      .volume_widening = std::sqrt(FallOfSigmaL(s, facts)),
      .prefilter_limit = s.prefilter_variance == PrefilterVariance::kOn ? s.prefilter_limit : 0.0f};
  plan->atrous = {.edges = EdgesOf(s, facts),
                  .wavelet_id = Int(s.wavelet_id),
                  .noise_ratio = s.noise_ratio,
                  .eaw_sigma_l = s.eaw_sigma_l,
                  .eaw_sigma_n = s.eaw_sigma_n,
                  .eaw_sigma_z = s.eaw_sigma_z,
                  .grows = Int(plan->is_sparse),
                  .reflected_signals = SignalsOfOnly(IsReflected, plan->signals, facts.lights)};
  plan->levels = ListLevels(s, &plan->level);
  plan->pilot_signals = PilotSignals(s, plan->signals, facts.lights);
}

/// The filter's number in the shaders.
int ResamplingOf(TaaFilter filter) {
  switch (filter) {
    case TaaFilter::kCatmullRom:
      return kCatmullRom;
    case TaaFilter::kSpline:
      return kSpline;
    case TaaFilter::kSubcell:
      break;
  }
  return kSubcell;
}

void PlanPicture(const Settings& s, const FrameFacts& facts, FramePlan* plan) {
  plan->clip_outliers = {.clip_outliers = s.clip_outliers};
  if (plan->runs.restore_energy) {
    const int images = ImageSignals(s, plan->signals, facts);
    plan->restore_energy = {
        .energy_signals = SignalsOfOnly(IsSmooth, plan->signals, facts.lights) | images,
        .image_signals = images};
  }
  plan->keep_samples = {
      .kept_signals = plan->runs.keep_samples ? SignalsOf(plan->signals, facts.second_moments) : 0,
      .kept_reach = facts.has_estimated_moments ? ReachOfEstimates(facts.samples_per_pixel) : 0};
  plan->keep_mirrors = {
      .mirror_roughness = s.mirror_roughness,
      .mirror_signals = plan->runs.keep_mirrors ? MirrorSignals(plan->signals, facts.lights) : 0};
  plan->restore_detail = {.detail_signals = DetailSignals(plan->signals, facts.lights),
                          .alpha_min = s.alpha_min};
  plan->fxaa = {.fxaa_sparse = Int(s.fxaa == Fxaa::kSparse)};
  plan->antialias = {
      .taa_alpha = s.taa_alpha,
      .taa_moving_alpha = s.taa_moving_alpha,
      .weigh_by_length = Int(s.temporal),
      .resampling = s.antialias != Antialias::kOff ? ResamplingOf(s.taa_filter) : kCatmullRom,
      .extrapolate_motion = Int(s.taa_extrapolate_motion),
      .follow_light = s.antialias != Antialias::kOff && s.temporal && s.taa_follow_light
                          ? DiffuseSignals(plan->signals, ~0u)
                          : 0,
      .clamp_light = Int(KeepsAlbedo(s) && facts.albedos != 0),
      .image_albedo = Int(KeepsAlbedo(s) && SumsImages(facts, *plan)),
      .image_length = Int(UsesImageLengths(s, plan->runs.fill_guides) &&
                          (plan->layers.count > 1 || facts.length_of_images)),
      .tone_scale = s.taa_tonemapped ? std::exp2(s.exposure) : 0.0f};
  plan->tonemap = TonemapOf(s.exposure, s.tonemap, s.dither, facts.index);
}

/// Plans the feedback of filtered light from the number of samples (PSVGF section 5).
void PlanFeedback(const Settings& s, const FrameFacts& facts, FramePlan* plan) {
  float& progress = plan->after.feedback_progress;
  progress = std::min(progress + std::min(facts.samples_per_pixel, 1.0f), 1.0f);
  const bool whole = progress > kWholeSample;
  const bool feeds_back = s.temporal && s.feedback > 0 &&
                          (s.feedback_when == FeedbackWhen::kFrame || whole) && !facts.has_future &&
                          !facts.is_backward;
  // Light that is merged with future frames has no version without feedback to blend with.
  plan->feedback_phase = whole || facts.has_future ? 1.0f : progress;
  plan->feedback_level = feeds_back ? s.feedback : 0;
  plan->after.fed_back = feeds_back;
  if (whole) {
    progress = 0;
  }
}

}  // namespace

FramePlan MakePlan(const Settings& s, const FrameFacts& facts, const SequenceProgress& progress) {
  FramePlan plan = {};
  plan.signals = GroupsOf(s.signals, HasTransmission(facts.lights));
  plan.layers = LayersOf(s, facts);
  plan.layout = LayoutOf(s);
  plan.normals = s.normals;
  plan.border = BorderOf(s);
  plan.is_sparse = facts.samples_per_pixel < kWholeSample;
  plan.was_fed_back = progress.fed_back;
  plan.after = progress;
  plan.after.jittered = progress.jittered || IsJittered(facts);
  plan.runs = StagesOf(s, facts, plan.after, plan.is_sparse);
  plan.has_picture = progress.has_picture && plan.runs.antialias;
  PlanSignals(s, facts, &plan);
  PlanWavelet(s, facts, &plan);
  PlanPicture(s, facts, &plan);
  PlanFeedback(s, facts, &plan);
  plan.has_followed = plan.has_picture && progress.has_followed;
  plan.after.has_followed = plan.has_picture && plan.antialias.follow_light != 0;
  plan.has_albedo = plan.has_picture && progress.has_albedo && plan.antialias.clamp_light != 0;
  plan.after.has_history = s.temporal;
  plan.after.has_picture = plan.runs.antialias && !facts.is_backward;
  plan.after.has_albedo = plan.after.has_picture && plan.antialias.clamp_light != 0;
  return plan;
}

FramePlan PlanOfLayer(const FramePlan& plan, const PlannedLayer& layer) {
  FramePlan of_layer = plan;
  const int mask = (1 << layer.count) - 1;
  of_layer.signals = plan.signals.subspan(layer.first, layer.count);
  of_layer.select_guides = SelectGuidesOf(plan.select_guides, layer.guides);
  for (int& signals : of_layer.pilot_signals) {
    signals = signals >> layer.first & mask;
  }
  int& volumes = of_layer.prefilter_variance.volume_signals;
  volumes = volumes >> layer.first & mask;
  int& reflected = of_layer.atrous.reflected_signals;
  reflected = reflected >> layer.first & mask;
  int& wide = of_layer.limit_history.wide_signals;
  wide = std::clamp(wide - static_cast<int>(layer.first), 0, static_cast<int>(layer.count));
  int& fine = of_layer.limit_history.fine_signals;
  fine = fine >> layer.first & mask;
  int& kept = of_layer.keep_samples.kept_signals;
  kept = kept >> layer.first & mask;
  int& mirrors = of_layer.keep_mirrors.mirror_signals;
  mirrors = mirrors >> layer.first & mask;
  int& energy = of_layer.restore_energy.energy_signals;
  energy = energy >> layer.first & mask;
  int& images = of_layer.restore_energy.image_signals;
  images = images >> layer.first & mask;
  int& detail = of_layer.restore_detail.detail_signals;
  detail = detail >> layer.first & mask;
  return of_layer;
}

Settings SettingsOfLayer(Settings settings) {
  settings.signals = SignalGrouping::kSingle;
  settings.antialias = Antialias::kOff;
  settings.fxaa = Fxaa::kOff;
  return settings;
}

LayerList LayersOf(const Settings& s, const FrameFacts& facts) {
  const std::span<const SignalGroup> signals = GroupsOf(s.signals, HasTransmission(facts.lights));
  LayerList list;
  for (size_t i = 0; i < signals.size(); ++i) {
    const GuideSource source =
        s.virtual_roughness > 0 ? SourceOf(signals[i], facts) : GuideSource::kSurface;
    if (list.count == 0 || list.layer[list.count - 1].guides != source) {
      list.layer[list.count++] = {source, i, 0, signals[i].channel >= 0};
    }
    ++list.layer[list.count - 1].count;
  }
  return list;
}

std::array<int, kPilotLevels> PilotSignals(const Settings& s, std::span<const SignalGroup> signals,
                                           uint32_t lights) {
  if (!s.pilot || s.wavelet != Wavelet::kSvgf) {
    return {};
  }
  return {(1 << signals.size()) - 1, SignalsOfOnly(IsSmooth, signals, lights)};
}

int DetailSignals(std::span<const SignalGroup> signals, uint32_t lights) {
  return ~SignalsOfOnly(IsSmooth, signals, lights) & ((1 << signals.size()) - 1);
}

Status CheckDeviceSettings(const Settings& s) {
  if (s.restore_detail) {
    return Status::InvalidArgument(
        "restore_detail, which preset best turns on, runs on the CPU only: turn it off or choose "
        "the device cpu");
  }
  return Status::Ok();
}

bool AntialiasesInTime(const Settings& s, bool jittered) {
  return s.antialias == Antialias::kTaa || (s.antialias == Antialias::kAuto && jittered);
}

bool UsesImageLengths(const Settings& s, bool fills_guides) {
  return s.antialias != Antialias::kOff && s.temporal && !fills_guides;
}

bool SumsImageAlbedo(uint32_t albedos, bool fills_guides) {
  constexpr uint32_t kSpecular = 2;
  return (albedos & kSpecular) != 0 && !fills_guides;
}

bool KeepsAlbedo(const Settings& s) {
  return s.antialias != Antialias::kOff && s.temporal && s.taa_clamp == TaaClamp::kLight;
}

bool RestoresEnergy(const Settings& s) {
  return s.restore_energy && s.wavelet != Wavelet::kOff && s.firefly != Firefly::kCompress &&
         !(s.temporal && s.feedback > 0);
}

HistoryLayout LayoutOf(const Settings& s) {
  return {.with_compressed = s.limit_history,
          .with_behind = s.temporal && s.feedback > 0 && s.wavelet != Wavelet::kOff &&
                         s.feedback_when == FeedbackWhen::kBlend};
}

int ListLevels(const Settings& s, std::array<AtrousLevel, kMaxLevels>* levels) {
  if (s.wavelet == Wavelet::kOff) {
    return 0;
  }
  for (size_t i = 0; i < static_cast<size_t>(s.steps.count); ++i) {
    (*levels)[i] = {.weights = WeightsOf(s.wavelet),
                    .radius = s.kernel == Kernel::k5x5 ? 2 : 1,
                    .step = s.steps.step[i]};
  }
  return s.steps.count;
}

int BorderOf(const Settings& s) {
  std::array<AtrousLevel, kMaxLevels> levels;
  const int count = ListLevels(s, &levels);
  const int last = s.restore_detail ? kRestoreDetailLevels - 1 : kKeepSamplesLevels - 1;
  int border = ReachOf(GeometryLevel(last));
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    border = std::max(border, ReachOf(levels[i]));
  }
  return border;
}

MotionUse UseOfMotion(const Settings& s, bool jittered, const SequenceProgress& progress) {
  return {.temporal = s.temporal && progress.has_history,
          .antialias = progress.has_picture && AntialiasesInTime(s, jittered || progress.jittered)};
}

TonemapParameters TonemapOf(float exposure, Tonemap curve, float dither, int64_t frame) {
  return {.exposure_scale = std::exp2(exposure),
          .tonemap = static_cast<int>(curve),
          .dither = dither,
          .frame = static_cast<uint32_t>(frame)};
}

FrameFacts FactsOf(const Frame& f) {
  FrameFacts facts;
  facts.index = f.index;
  facts.width = f.width;
  facts.height = f.height;
  facts.focal_pixels = f.focal_pixels;
  facts.jitter_x = f.jitter_x;
  facts.jitter_y = f.jitter_y;
  for (const Signal& signal : f.signals) {
    const uint32_t bit = 1u << static_cast<uint32_t>(signal.kind);
    facts.lights |= bit;
    facts.second_moments |= signal.second_moment.empty() ? 0u : bit;
  }
  facts.has_estimated_moments = f.has_estimated_moments;
  const auto albedos = AlbedosOf(f.guides);
  for (size_t i = 0; i < albedos.size(); ++i) {
    facts.albedos |= albedos[i]->empty() ? 0u : 1u << i;
  }
  facts.has_samples = !f.samples.empty();
  facts.has_id = !f.guides.id.empty();
  facts.has_emission = !f.emission.empty();
  facts.has_background = !f.background.empty();
  facts.has_roughness = !f.guides.roughness.empty();
  facts.has_previous_normal = !f.guides.previous_normal.empty();
  facts.has_reflection =
      !f.reflection.empty() || (f.on_device != nullptr && f.on_device->has_reflection());
  facts.has_refraction =
      !f.refraction.empty() || (f.on_device != nullptr && f.on_device->has_refraction());
  facts.has_confidence = !f.confidence.empty();
  return facts;
}

float SamplesPerPixel(const Frame& frame, std::vector<double>* row_sums) {
  if (frame.samples.empty()) {
    return 1;
  }
  const double mean = MeanOfRows(frame.width, frame.height, row_sums, [&](int y) {
    const float* row = frame.samples.Row(y);
    double sum = 0;
    for (int x = 0; x < frame.width; ++x) {
      sum += row[x] > 0 && std::isfinite(row[x]) ? static_cast<double>(row[x]) : 0.0;
    }
    return sum;
  });
  return static_cast<float>(mean);
}

}  // namespace stillray

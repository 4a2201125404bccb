// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The plan of one frame: the stages that run, and their parameters. It is made once, from the
/// settings, the facts of the frame and the progress of the sequence; the pipelines on the CPU and
/// on Vulkan read the plan and no settings.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "denoise/guide_source.h"
#include "denoise/signal_groups.h"
#include "denoise/stages/accumulate_shared.h"
#include "denoise/stages/antialias_shared.h"
#include "denoise/stages/atrous.h"
#include "denoise/stages/clip_outliers_shared.h"
#include "denoise/stages/demodulate_shared.h"
#include "denoise/stages/estimate_variance_shared.h"
#include "denoise/stages/fxaa_shared.h"
#include "denoise/stages/keep_mirrors_shared.h"
#include "denoise/stages/keep_samples_shared.h"
#include "denoise/stages/limit_history_shared.h"
#include "denoise/stages/prefilter_variance_shared.h"
#include "denoise/stages/reproject_shared.h"
#include "denoise/stages/restore_detail_shared.h"
#include "denoise/stages/tonemap_shared.h"
#include "stillray/denoise.hpp"

namespace stillray {

/// Properties of a frame that determine its plan.
struct FrameFacts {
  int64_t index = 0;
  int width = 0;
  int height = 0;
  float focal_pixels = 0;       ///< Frame::focal_pixels
  uint32_t lights = 0;          ///< bit k: light of SignalKind k is given
  uint32_t black_lights = 0;    ///< those of `lights` that are black everywhere, without images
  uint32_t second_moments = 0;  ///< likewise
  bool has_estimated_moments = false;  ///< Frame::has_estimated_moments
  uint32_t albedos = 0;                ///< bit 0 albedo, 1 specular, 2 transmission albedo
  bool has_samples = false;
  bool has_id = false;
  bool has_emission = false;
  bool has_background = false;
  bool has_roughness = false;
  bool has_previous_normal = false;
  bool has_reflection = false;         ///< virtual guides of the specular signals are given
  bool has_refraction = false;         ///< of the transmission signals
  bool albedo_of_images = false;       ///< of a part: the specular albedo is that of images, too
  bool length_of_images = false;       ///< of a part: alphas of the emission are those lengths
  bool keeps_length = false;           ///< the picture's alpha is the length of the history
  bool has_confidence = false;         ///< in the light of the last frame
  bool has_incomplete_guides = false;  ///< depth 0 and no sample, somewhere
  float samples_per_pixel = 1;         ///< mean over the frame; below 1 the frame is sparse
  float jitter_x = 0, jitter_y = 0;    ///< as in Frame
  bool has_future = false;             ///< light of later frames is given
  bool is_backward = false;            ///< the sequence is played backward: no picture is made
  bool is_displayed = false;           ///< 8-bit rows are requested
};

/// The progress of a sequence.
struct SequenceProgress {
  bool has_history = false;
  bool has_picture = false;   ///< the last frame's picture was antialiased in time
  bool has_followed = false;  ///< ... and follow_light ran
  bool has_albedo = false;    ///< ... and so was its albedo
  bool jittered = false;      ///< some frame since the history began was
  bool fed_back = false;      ///< the last frame's filtered light is part of the history, or may be
  float feedback_progress = 0;  ///< samples per pixel since the last feedback, 0..1
};

/// The optional stages of a frame; the others always run.
struct StagesRun {
  bool fill_guides;
  bool reproject;  ///< there is a history
  bool clamp_fireflies;
  bool compress_light;
  bool limit_history;
  bool find_moving_light;  ///< within limit_history
  bool merge_future;
  bool wavelet;            ///< the levels
  bool estimate_variance;  ///< and prefilter_variance
  bool smooth_variance;    ///< before the levels
  bool measure_luminance;  ///< the mean of each signal, which scales eaw_sigma_l
  bool clip_outliers;      ///< after the levels
  bool restore_energy;
  bool keep_samples;
  bool keep_mirrors;  ///< if the frame shows any
  bool restore_detail;
  bool fxaa;
  bool antialias;
  bool tonemap;
};

/// Planes of each signal's history beside light and moments. Depends on the settings alone.
struct HistoryLayout {
  bool with_compressed = false;  ///< means of compressed luminances, for limit_history
  bool with_behind = false;      ///< light without the last feedback, for feedback_when=blend

  friend bool operator==(const HistoryLayout&, const HistoryLayout&) = default;
};

/// Signals with common guides; next to each other in FramePlan::signals.
struct PlannedLayer {
  GuideSource guides = GuideSource::kSurface;
  size_t first = 0;
  size_t count = 0;
  bool by_channel = false;  ///< each signal is one channel of colour

  friend bool operator==(const PlannedLayer&, const PlannedLayer&) = default;
};

/// The layers of a frame in the order of their signals: the surface, and the virtual images that
/// have guides of their own.
struct LayerList {
  std::array<PlannedLayer, 3> layer;
  size_t count = 0;

  const PlannedLayer* begin() const { return layer.data(); }
  const PlannedLayer* end() const { return layer.data() + count; }
  friend bool operator==(const LayerList&, const LayerList&) = default;
};

struct FramePlan {
  std::span<const SignalGroup> signals;
  LayerList layers;
  HistoryLayout layout;
  NormalStorage normals;
  int border;         ///< pixels around the picture that wavelets read
  bool is_sparse;     ///< less than one sample per pixel
  bool has_picture;   ///< there is a last picture for antialiasing
  bool has_followed;  ///< the light of that picture is known to follow_light
  bool has_albedo;    ///< the antialiased albedo of that picture is there
  bool was_fed_back;  ///< SequenceProgress::fed_back before this frame
  StagesRun runs;

  SelectGuidesParameters select_guides;
  DemodulateParameters demodulate;
  ReprojectParameters reproject;
  LimitHistoryParameters limit_history;
  AtrousParameters compared;  ///< of the levels of limit_history
  AccumulateParameters accumulate;
  EstimateVarianceParameters estimate_variance;
  PrefilterVarianceParameters prefilter_variance;
  AtrousParameters atrous;
  std::array<AtrousLevel, kMaxLevels> level;
  /// Of the first levels; bit s: the weights of signal s compare a pilot estimate.
  std::array<int, kPilotLevels> pilot_signals;
  int levels;          ///< 0: no wavelet
  int feedback_level;  ///< whose output becomes history, from 1 on; 0: the accumulated light does
  /// Weight of the history with the last feedback in the wavelet's input; the rest is the history
  /// without it (PSVGF section 5).
  float feedback_phase;
  ClipOutliersParameters clip_outliers;
  int energy_signals;  ///< bit s: restore_energy runs for signal s
  KeepSamplesParameters keep_samples;
  KeepMirrorsParameters keep_mirrors;
  RestoreDetailParameters restore_detail;
  FxaaParameters fxaa;
  AntialiasParameters antialias;
  TonemapParameters tonemap;

  SequenceProgress after;  ///< of the sequence, once the frame is finished
};

/// \param progress  before the frame; that of a new sequence if the history does not fit the frame
FramePlan MakePlan(const Settings& settings, const FrameFacts& facts,
                   const SequenceProgress& progress);

/// The plan of one layer's signals alone.
FramePlan PlanOfLayer(const FramePlan& plan, const PlannedLayer& layer);

/// The settings of a layer that is denoised as a frame of its own: one signal, and no stage of the
/// finished picture.
Settings SettingsOfLayer(Settings settings);

/// \param facts  its lights and virtual guides
LayerList LayersOf(const Settings& settings, const FrameFacts& facts);

HistoryLayout LayoutOf(const Settings& settings);

/// Whether the filter keeps normals as PackNormal. \param by_default  of the implementation
inline bool PacksNormals(NormalStorage normals, bool by_default = false) {
  return normals == NormalStorage::kAuto ? by_default : normals == NormalStorage::kOctahedral;
}

/// FramePlan::pilot_signals; zeros if there is no pilot. \param lights  FrameFacts::lights
std::array<int, kPilotLevels> PilotSignals(const Settings& s, std::span<const SignalGroup> signals,
                                           uint32_t lights);

/// RestoreDetailParameters::detail_signals: all but those of nothing but indirect diffuse or
/// transmitted light. Their samples are rare and bright, and darken what they are compared with.
int DetailSignals(std::span<const SignalGroup> signals, uint32_t lights);

/// kInvalidArgument if a stage is on that only the CPU has.
Status CheckDeviceSettings(const Settings& settings);

/// The levels of the wavelet; none where it is off. \return their number
int ListLevels(const Settings& settings, std::array<AtrousLevel, kMaxLevels>* levels);

/// Pixels around a picture that wavelets with these settings read.
int BorderOf(const Settings& settings);

/// Whether a history made with the settings \p a cannot be used with \p b.
bool NeedsNewHistory(const Settings& a, const Settings& b);

/// The data of the last frame that are looked up along the motion. First frames have none.
struct MotionUse {
  bool temporal = false;   ///< the history
  bool antialias = false;  ///< the last picture
  bool any() const { return temporal || antialias; }
};
MotionUse UseOfMotion(const Settings& settings, bool jittered, const SequenceProgress& progress);

/// Whether pictures are antialiased in time. \param jittered  this frame or one before it was
bool AntialiasesInTime(const Settings& settings, bool jittered);

/// Whether antialiasing sums the albedo of reflected light with that of what mirrors show, of
/// frames that have images. Where guides are filled, most pixels have none: beside those that have
/// one it would be another albedo. \param albedos  FrameFacts::albedos
bool SumsImageAlbedo(uint32_t albedos, bool fills_guides);

/// Whether antialias keeps the albedo of pictures, of frames that have one.
bool KeepsAlbedo(const Settings& settings);

/// Whether restore_energy runs: the light before and after the wavelet must be comparable.
bool RestoresEnergy(const Settings& settings);

/// Whether the rays of a frame missed the pixels' centres.
inline bool IsJittered(float jitter_x, float jitter_y) {
  return jitter_x != 0 || jitter_y != 0;
}
inline bool IsJittered(const FrameFacts& facts) {
  return IsJittered(facts.jitter_x, facts.jitter_y);
}

/// Parameters of the display picture. \param frame  seed of the dither
TonemapParameters TonemapOf(float exposure, Tonemap curve, float dither, int64_t frame);

/// The facts of a frame in host memory, except those that depend on its pixels: incomplete guides
/// and samples per pixel.
FrameFacts FactsOf(const Frame& frame);

/// Mean of a frame's samples; 1 where it gives none. \param row_sums  work memory
float SamplesPerPixel(const Frame& frame, std::vector<double>* row_sums);

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The plan of one frame: the stages that run, and their parameters. It is made once per frame,
/// from the settings, the properties of the frame and the progress of the sequence; the pipelines
/// on the CPU and on Vulkan read only the plan, not the settings.
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
#include "denoise/stages/restore_energy_shared.h"
#include "denoise/stages/tonemap_shared.h"
#include "stillray/denoise.hpp"

namespace stillray {

/// Properties of a frame that determine its plan.
struct FrameFacts {
  int64_t index = 0;
  int width = 0;
  int height = 0;
  float focal_pixels = 0;              ///< Frame::focal_pixels
  uint32_t lights = 0;                 ///< bit k: radiance of SignalKind k is given
  uint32_t black_lights = 0;           ///< bit k: radiance of kind k is black and has no image
  uint32_t second_moments = 0;         ///< bit k: the second moment of SignalKind k is given
  bool has_estimated_moments = false;  ///< Frame::has_estimated_moments
  uint32_t albedos = 0;                ///< bit 0 albedo, 1 specular, 2 transmission albedo
  bool has_samples = false;
  bool has_id = false;
  bool has_emission = false;
  bool has_background = false;
  bool has_roughness = false;
  bool has_previous_normal = false;
  bool has_reflection = false;    ///< virtual guides of the specular signals are given
  bool has_refraction = false;    ///< virtual guides of the transmission signals are given
  bool albedo_of_images = false;  ///< of a part: specular albedo includes that of virtual images
  bool length_of_images = false;  ///< of a part: the emission's alpha is a history length
  bool keeps_length = false;      ///< the output image's alpha is the history length
  bool has_confidence = false;    ///< Frame::confidence is given
  bool has_incomplete_guides = false;  ///< some pixel has depth 0 and no sample
  float samples_per_pixel = 1;         ///< mean over the frame; below 1 the frame is sparse
  float jitter_x = 0, jitter_y = 0;    ///< as in Frame
  bool has_future = false;             ///< a history of later frames is given
  bool is_backward = false;            ///< the sequence is processed backward: no output image
  bool is_displayed = false;           ///< 8-bit rows are requested
};

/// The progress of a sequence.
struct SequenceProgress {
  bool has_history = false;
  bool has_picture = false;     ///< the last frame's image was temporally antialiased
  bool has_followed = false;    ///< has_picture, and follow_light ran
  bool has_albedo = false;      ///< has_picture, and the albedo was antialiased too
  bool jittered = false;        ///< some frame since the history began was jittered
  bool fed_back = false;        ///< the history may contain the last frame's filtered signal
  float feedback_progress = 0;  ///< samples per pixel since the last feedback, 0..1
};

/// The optional stages of a frame; all other stages always run.
struct StagesRun {
  bool fill_guides;
  bool reproject;  ///< there is a history
  bool clamp_fireflies;
  bool compress_light;
  bool limit_history;
  bool find_moving_light;  ///< part of limit_history
  bool merge_future;
  bool wavelet;            ///< the levels
  bool estimate_variance;  ///< and prefilter_variance
  bool smooth_variance;    ///< before the levels
  bool measure_luminance;  ///< the mean of each signal, which scales eaw_sigma_l
  bool clip_outliers;      ///< after the levels
  bool restore_energy;
  bool keep_samples;
  bool keep_mirrors;  ///< if the frame has mirrors
  bool restore_detail;
  bool fxaa;
  bool antialias;
  bool tonemap;
};

/// Optional planes of each signal's history. Depends only on the settings.
struct HistoryLayout {
  bool with_compressed = false;  ///< means of compressed luminances, for limit_history
  bool with_behind = false;      ///< colour without the last feedback, for feedback_when=blend

  friend bool operator==(const HistoryLayout&, const HistoryLayout&) = default;
};

/// Signals with common guides, which are consecutive in FramePlan::signals.
struct PlannedLayer {
  GuideSource guides = GuideSource::kSurface;
  size_t first = 0;
  size_t count = 0;
  bool by_channel = false;  ///< each signal is one channel of colour

  friend bool operator==(const PlannedLayer&, const PlannedLayer&) = default;
};

/// The layers of a frame in the order of their signals: the surface, and the virtual images that
/// have separate guides.
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
  int border;         ///< pixels around the image that wavelets read
  bool is_sparse;     ///< less than one sample per pixel
  bool has_picture;   ///< the last output image exists, for antialias
  bool has_followed;  ///< follow_light has the radiance of the last frame
  bool has_albedo;    ///< the antialiased albedo of the last frame exists
  bool was_fed_back;  ///< SequenceProgress::fed_back before this frame
  StagesRun runs;

  SelectGuidesParameters select_guides;
  DemodulateParameters demodulate;
  ReprojectParameters reproject;
  LimitHistoryParameters limit_history;
  AtrousParameters compared;  ///< parameters of limit_history's levels
  AccumulateParameters accumulate;
  EstimateVarianceParameters estimate_variance;
  PrefilterVarianceParameters prefilter_variance;
  AtrousParameters atrous;
  std::array<AtrousLevel, kMaxLevels> level;
  /// Of the first levels; bit s: the weights of signal s compare a pilot estimate.
  std::array<int, kPilotLevels> pilot_signals;
  int levels;          ///< 0: no wavelet
  int feedback_level;  ///< level whose output becomes history, from 1; 0: none, the accumulated
                       ///< signal does
  /// Weight of the history with the last feedback in the wavelet's input; the rest is the history
  /// without it (PSVGF section 5).
  float feedback_phase;
  ClipOutliersParameters clip_outliers;
  RestoreEnergyParameters restore_energy;
  KeepSamplesParameters keep_samples;
  KeepMirrorsParameters keep_mirrors;
  RestoreDetailParameters restore_detail;
  FxaaParameters fxaa;
  AntialiasParameters antialias;
  TonemapParameters tonemap;

  SequenceProgress after;  ///< progress of the sequence after this frame
};

/// \param progress  progress before the frame; default values if the history does not fit the frame
FramePlan MakePlan(const Settings& settings, const FrameFacts& facts,
                   const SequenceProgress& progress);

/// The plan restricted to the signals of one layer.
FramePlan PlanOfLayer(const FramePlan& plan, const PlannedLayer& layer);

/// The settings of a layer that is denoised as a separate frame: one signal, without the stages
/// after remodulate.
Settings SettingsOfLayer(Settings settings);

/// \param facts  members used: lights and virtual guides
LayerList LayersOf(const Settings& settings, const FrameFacts& facts);

HistoryLayout LayoutOf(const Settings& settings);

/// Whether the filter stores normals by PackNormal. \param by_default  default of the
/// implementation
inline bool PacksNormals(NormalStorage normals, bool by_default = false) {
  return normals == NormalStorage::kAuto ? by_default : normals == NormalStorage::kOctahedral;
}

/// FramePlan::pilot_signals; zeros if there is no pilot. \param lights  FrameFacts::lights
std::array<int, kPilotLevels> PilotSignals(const Settings& s, std::span<const SignalGroup> signals,
                                           uint32_t lights);

/// RestoreDetailParameters::detail_signals: all signals except those with only indirect diffuse or
/// only transmitted light. Their samples are rare and bright, so that the filtered signal, with
/// which they are compared, is too dark.
int DetailSignals(std::span<const SignalGroup> signals, uint32_t lights);

/// \return kInvalidArgument if a stage is enabled that only the CPU supports
Status CheckDeviceSettings(const Settings& settings);

/// The levels of the wavelet; none if it is off. \return number of levels
int ListLevels(const Settings& settings, std::array<AtrousLevel, kMaxLevels>* levels);

/// Pixels around an image that wavelets with these settings read.
int BorderOf(const Settings& settings);

/// Whether a history made with the settings \p a cannot be used with \p b.
bool NeedsNewHistory(const Settings& a, const Settings& b);

/// The data of the last frame that are fetched along the motion; none in the first frame.
struct MotionUse {
  bool temporal = false;   ///< the history
  bool antialias = false;  ///< the last output image
  bool any() const { return temporal || antialias; }
};
MotionUse UseOfMotion(const Settings& settings, bool jittered, const SequenceProgress& progress);

/// Whether images are temporally antialiased. \param jittered  this frame or an earlier one was
/// jittered
bool AntialiasesInTime(const Settings& settings, bool jittered);

/// Whether sum_albedo includes the albedo of reflected surfaces, in frames with virtual images. Not
/// where guides are filled: most pixels then have no virtual image, and their albedo would differ
/// from that of neighbours with one. \param albedos  FrameFacts::albedos
bool SumsImageAlbedo(uint32_t albedos, bool fills_guides);

/// Whether antialias uses the history lengths of virtual images, in frames with them. Not where
/// guides are filled, as for SumsImageAlbedo.
bool UsesImageLengths(const Settings& settings, bool fills_guides);

/// Whether antialias keeps the albedo of images, for frames with an albedo.
bool KeepsAlbedo(const Settings& settings);

/// Whether restore_energy runs: the signals before and after the wavelet must be comparable.
bool RestoresEnergy(const Settings& settings);

/// Whether the rays of a frame were offset from the pixel centres.
inline bool IsJittered(float jitter_x, float jitter_y) {
  return jitter_x != 0 || jitter_y != 0;
}
inline bool IsJittered(const FrameFacts& facts) {
  return IsJittered(facts.jitter_x, facts.jitter_y);
}

/// Parameters of the displayed image. \param frame  seed of the dither
TonemapParameters TonemapOf(float exposure, Tonemap curve, float dither, int64_t frame);

/// The properties of a frame in host memory, except those that depend on pixel values (incomplete
/// guides, samples per pixel).
FrameFacts FactsOf(const Frame& frame);

/// Mean of Frame::samples; 1 if not given. \param row_sums  work memory
float SamplesPerPixel(const Frame& frame, std::vector<double>* row_sums);

}  // namespace stillray

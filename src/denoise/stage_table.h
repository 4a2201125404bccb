// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The stage functions of one backend: the pipeline is written once, for all backends.
#pragma once

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/stages/accumulate.h"
#include "denoise/stages/antialias.h"
#include "denoise/stages/atrous.h"
#include "denoise/stages/clip_outliers.h"
#include "denoise/stages/demodulate.h"
#include "denoise/stages/estimate_variance.h"
#include "denoise/stages/follow_light.h"
#include "denoise/stages/fxaa.h"
#include "denoise/stages/keep_mirrors.h"
#include "denoise/stages/keep_samples.h"
#include "denoise/stages/limit_history.h"
#include "denoise/stages/merge_future.h"
#include "denoise/stages/mix_pilot.h"
#include "denoise/stages/prefilter_variance.h"
#include "denoise/stages/prepare_guides.h"
#include "denoise/stages/remodulate.h"
#include "denoise/stages/reproject.h"
#include "denoise/stages/restore_detail.h"
#include "denoise/stages/restore_energy.h"
#include "denoise/stages/select_guides.h"
#include "denoise/stages/spline_coefficients.h"
#include "denoise/stages/sum_albedo.h"
#include "denoise/stages/suppress_fireflies.h"
#include "denoise/stages/tonemap.h"

namespace stillray {

struct StageTable {
  decltype(&reference::FillGuides) fill_guides;
  decltype(&reference::PrepareGuides) prepare_guides;
  decltype(&reference::SelectGuides) select_guides;
  decltype(&reference::Demodulate) demodulate;
  decltype(&reference::ClampFireflies) clamp_fireflies;
  decltype(&reference::CompressLight) compress_light;
  decltype(&reference::ExpandLight) expand_light;
  decltype(&reference::FindTaps) find_taps;
  decltype(&reference::FetchHistory) fetch_history;
  decltype(&reference::CompareWithHistory) compare_with_history;
  decltype(&reference::MeasureChange) measure_change;
  decltype(&reference::CorrectHistory) correct_history;
  decltype(&reference::LimitHistory) limit_history;
  decltype(&reference::Accumulate) accumulate;
  decltype(&reference::MergeFuture) merge_future;
  decltype(&reference::EstimateVariance) estimate_variance;
  decltype(&reference::MixPilot) mix_pilot;
  decltype(&reference::SmoothVariance) smooth_variance;
  decltype(&reference::PrefilterVariance) prefilter_variance;
  decltype(&reference::Atrous) atrous;
  decltype(&reference::ClipOutliers) clip_outliers;
  decltype(&reference::MeasureEnergy) measure_energy;
  decltype(&reference::RestoreEnergy) restore_energy;
  decltype(&reference::MeasureMirrors) measure_mirrors;
  decltype(&reference::MeasureSamples) measure_samples;
  decltype(&reference::KeepSamples) keep_samples;
  decltype(&reference::BeginDetail) begin_detail;
  decltype(&reference::MeasureDetail) measure_detail;
  decltype(&reference::RestoreDetail) restore_detail;
  decltype(&reference::AccumulateResidual) accumulate_residual;
  decltype(&reference::Remodulate) remodulate;
  decltype(&reference::Fxaa) fxaa;
  decltype(&reference::FollowLight) follow_light;
  decltype(&reference::SplineCoefficients) spline_coefficients;
  decltype(&reference::SumAlbedo) sum_albedo;
  decltype(&reference::Antialias) antialias;
  decltype(&reference::Tonemap) tonemap;
};

#define STILLRAY_STAGES_OF(backend)                                                                \
  StageTable {                                                                                     \
    .fill_guides = &backend::FillGuides, .prepare_guides = &backend::PrepareGuides,                \
    .select_guides = &backend::SelectGuides, .demodulate = &backend::Demodulate,                   \
    .clamp_fireflies = &backend::ClampFireflies, .compress_light = &backend::CompressLight,        \
    .expand_light = &backend::ExpandLight, .find_taps = &backend::FindTaps,                        \
    .fetch_history = &backend::FetchHistory, .compare_with_history = &backend::CompareWithHistory, \
    .measure_change = &backend::MeasureChange, .correct_history = &backend::CorrectHistory,        \
    .limit_history = &backend::LimitHistory, .accumulate = &backend::Accumulate,                   \
    .merge_future = &backend::MergeFuture, .estimate_variance = &backend::EstimateVariance,        \
    .mix_pilot = &backend::MixPilot, .smooth_variance = &backend::SmoothVariance,                  \
    .prefilter_variance = &backend::PrefilterVariance, .atrous = &backend::Atrous,                 \
    .clip_outliers = &backend::ClipOutliers, .measure_energy = &backend::MeasureEnergy,            \
    .restore_energy = &backend::RestoreEnergy, .measure_mirrors = &backend::MeasureMirrors,        \
    .measure_samples = &backend::MeasureSamples, .keep_samples = &backend::KeepSamples,            \
    .begin_detail = &backend::BeginDetail, .measure_detail = &backend::MeasureDetail,              \
    .restore_detail = &backend::RestoreDetail,                                                     \
    .accumulate_residual = &backend::AccumulateResidual, .remodulate = &backend::Remodulate,       \
    .fxaa = &backend::Fxaa, .follow_light = &backend::FollowLight,                                 \
    .spline_coefficients = &backend::SplineCoefficients, .sum_albedo = &backend::SumAlbedo,        \
    .antialias = &backend::Antialias, .tonemap = &backend::Tonemap,                                \
  }

inline constexpr StageTable kReferenceStages = STILLRAY_STAGES_OF(reference);
inline constexpr StageTable kCpuStages = STILLRAY_STAGES_OF(cpu);

}  // namespace stillray

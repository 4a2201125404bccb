// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The stages of one backend, so that the pipeline is written once.
#pragma once

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/stages/accumulate.h"
#include "denoise/stages/antialias.h"
#include "denoise/stages/atrous.h"
#include "denoise/stages/demodulate.h"
#include "denoise/stages/estimate_variance.h"
#include "denoise/stages/fxaa.h"
#include "denoise/stages/keep_mirrors.h"
#include "denoise/stages/limit_history.h"
#include "denoise/stages/merge_future.h"
#include "denoise/stages/prefilter_variance.h"
#include "denoise/stages/prepare_guides.h"
#include "denoise/stages/remodulate.h"
#include "denoise/stages/reproject.h"
#include "denoise/stages/suppress_fireflies.h"
#include "denoise/stages/tonemap.h"

namespace stillray {

struct StageTable {
  decltype(&reference::FillGuides) fill_guides;
  decltype(&reference::PrepareGuides) prepare_guides;
  decltype(&reference::PrepareAndFindTaps) prepare_and_find_taps;
  decltype(&reference::Demodulate) demodulate;
  decltype(&reference::ClampFireflies) clamp_fireflies;
  decltype(&reference::CompressLight) compress_light;
  decltype(&reference::ExpandLight) expand_light;
  decltype(&reference::FindTaps) find_taps;
  decltype(&reference::FetchHistory) fetch_history;
  decltype(&reference::CompareWithHistory) compare_with_history;
  decltype(&reference::LimitHistory) limit_history;
  decltype(&reference::Accumulate) accumulate;
  decltype(&reference::AccumulateInPlace) accumulate_in_place;
  decltype(&reference::AccumulateRadiance) accumulate_radiance;
  decltype(&reference::MergeFuture) merge_future;
  decltype(&reference::EstimateVariance) estimate_variance;
  decltype(&reference::PrefilterVariance) prefilter_variance;
  decltype(&reference::Atrous) atrous;
  decltype(&reference::MeasureMirrors) measure_mirrors;
  decltype(&reference::KeepMirrors) keep_mirrors;
  decltype(&reference::Remodulate) remodulate;
  decltype(&reference::Fxaa) fxaa;
  decltype(&reference::Antialias) antialias;
  decltype(&reference::AntialiasParts) antialias_parts;
  decltype(&reference::Tonemap) tonemap;
};

#define STILLRAY_STAGES_OF(backend)                                                            \
  StageTable {                                                                                 \
    &backend::FillGuides, &backend::PrepareGuides, &backend::PrepareAndFindTaps,               \
        &backend::Demodulate, &backend::ClampFireflies, &backend::CompressLight,               \
        &backend::ExpandLight, &backend::FindTaps, &backend::FetchHistory,                     \
        &backend::CompareWithHistory, &backend::LimitHistory, &backend::Accumulate,            \
        &backend::AccumulateInPlace, &backend::AccumulateRadiance, &backend::MergeFuture,      \
        &backend::EstimateVariance, &backend::PrefilterVariance, &backend::Atrous,             \
        &backend::MeasureMirrors, &backend::KeepMirrors, &backend::Remodulate, &backend::Fxaa, \
        &backend::Antialias, &backend::AntialiasParts, &backend::Tonemap                       \
  }

inline constexpr StageTable kReferenceStages = STILLRAY_STAGES_OF(reference);
inline constexpr StageTable kCpuStages = STILLRAY_STAGES_OF(cpu);

}  // namespace stillray

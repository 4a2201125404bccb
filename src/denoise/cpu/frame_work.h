// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "denoise/cpu/history.h"
#include "denoise/fill_guides/fill_guides.h"
#include "denoise/plan.h"
#include "denoise/planes.h"
#include "denoise/stages/limit_history.h"
#include "denoise/stages/sum_albedo.h"

namespace stillray {

/// One signal between the wavelet levels.
struct WaveletPlanes {
  FilterPlanes filter[2];
  /// Luminance factors of the wavelet (prefilter_variance); until then, the relative bias of the
  /// history (limit_history). Empty if neither stage runs.
  Image1 luminance_factor;
  Image1 ratio;  ///< HistoryRatio per pixel (limit_history); empty until that has run
  Image1 pilot;  ///< see RunPilot; empty until it has run
  Image1 valid;
  Image1 valid_out;               ///< `valid` of the next level; empty until a frame is sparse
  int target = 0;                 ///< index in `filter` of the next level's output
  LumaImage3* light = nullptr;    ///< input of the next level; after the last one, the result
  Image1* variance = nullptr;     ///< variance of `light`
  const Image1* where = nullptr;  ///< positive for surfaces with samples
  bool all_valid = false;         ///< `valid` is 1 on every surface
  float mean_luminance = 1;
  SignalHistory* history = nullptr;  ///< the history that the wavelet filters

  WaveletPlanes() = default;
  WaveletPlanes(int width, int height, int border)
      : filter{{width, height, border}, {width, height, border}}, valid(width, height, border) {}
  size_t bytes() const {
    return filter[0].bytes() + filter[1].bytes() + luminance_factor.bytes() + ratio.bytes() +
           pilot.bytes() + valid.bytes() + valid_out.bytes();
  }
};

/// Work planes of one layer. They are kept between frames only to avoid allocations; no content is
/// passed to the next frame.
struct LayerWork {
  Guides selected;  ///< output of select_guides; empty in the surface's layer
  ReprojectionTaps taps;
  std::vector<NewLight> light;  ///< of every signal
  SignalHistory spare;          ///< buffer for the next history of a signal
  bool spare_is_empty = false;  ///< `spare` has no samples anywhere
  StagedHistory staged;
  std::vector<SignalHistory>
      merged;  ///< histories merged with the future; empty until there is one
  std::vector<WaveletPlanes> wavelet;    ///< of every signal
  GuidePlanes coarse;                    ///< guides of the coarse grid; empty until that is used
  std::vector<ComparedPlanes> compared;  ///< of every signal
  Image3 scratch;
  Image1 firefly;  ///< empty unless fireflies are clamped
  /// Output of keep_samples, keep_mirrors and restore_detail; empty until one of them has run.
  FilterPlanes blended;
  FilterPlanes detail;     ///< of restore_detail; empty until that has run
  SignalHistory residual;  ///< buffer for the next mean residual of a signal
  std::vector<double> row_sums;
  int border = 0;  ///< of the input planes of wavelets; never shrinks, to avoid reallocation

  size_t bytes() const;
};

/// Work planes of one frame.
struct FrameWork {
  std::vector<LayerWork> layers;
  Image3 picture;  ///< the output image before antialiasing
  Image2 motion;   ///< motion of surfaces and virtual images; empty without virtual guides
  Image1 images;   ///< depth of reflected images (FindImages); empty until there are virtual guides
  Image1 refracted_images;
  Image1 length;  ///< history length of the visible radiance (TakeLengths); empty until there are
                  ///< virtual images
  Image3 spline;  ///< spline coefficients of the last image; empty unless taa_filter is spline
  SummedAlbedo albedo;   ///< output of sum_albedo; empty unless that runs, as are albedo_spline and
                         ///< albedo_out
  Image3 albedo_spline;  ///< spline coefficients of the last frame's antialiased albedo
  Image3 albedo_out;     ///< this frame's antialiased albedo
  FollowedBlocks
      followed_blocks;  ///< of follow_light, as the next two planes; empty unless it runs
  Image1 followed;      ///< radiance of this frame per block
  Image1 ratio;
  FillGuidesWork fill_guides;
  std::vector<double> row_sums;

  int border() const { return layers.empty() ? 0 : layers.front().border; }
  size_t bytes() const;
};

/// Allocates the planes with the size and border of another plane, if necessary.
void MakeRoom(const Image1& like, FilterPlanes* planes);

/// Allocates memory for a frame of this size under the plan, if necessary.
void MakeRoom(const FramePlan& plan, int width, int height, FrameWork* work);

/// Restarts the history if it does not fit the frame and the plan, and extends it by the border
/// that the wavelet reads. \return whether it was restarted
bool FitHistory(const FramePlan& plan, int width, int height, int border, History* history);

}  // namespace stillray

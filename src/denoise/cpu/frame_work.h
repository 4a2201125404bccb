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
  /// Luminance factors of the wavelet (see prefilter_variance); before it, the relative bias of the
  /// history (see limit_history). Empty if neither runs.
  Image1 luminance_factor;
  Image1 ratio;  ///< of present to history (limit_history); empty until it has run
  Image1 pilot;  ///< see RunPilot; empty until it has run
  Image1 valid;
  Image1 valid_out;               ///< `valid` of the next level; empty until a frame is sparse
  int target = 0;                 ///< index in `filter` of the next level's output
  LumaImage3* light = nullptr;    ///< input of the next level, or the result
  Image1* variance = nullptr;     ///< of it
  const Image1* where = nullptr;  ///< positive where there is light on a surface
  bool all_valid = false;         ///< `valid` is 1 on every surface
  float mean_luminance = 1;
  SignalHistory* history = nullptr;  ///< the source of the light

  WaveletPlanes() = default;
  WaveletPlanes(int width, int height, int border)
      : filter{{width, height, border}, {width, height, border}}, valid(width, height, border) {}
  size_t bytes() const {
    return filter[0].bytes() + filter[1].bytes() + luminance_factor.bytes() + ratio.bytes() +
           pilot.bytes() + valid.bytes() + valid_out.bytes();
  }
};

/// Work planes of one layer. They are kept between frames, so that nothing is allocated in the
/// steady state; the next frame does not read them.
struct LayerWork {
  Guides selected;  ///< see select_guides; empty in the surface's layer
  ReprojectionTaps taps;
  std::vector<NewLight> light;  ///< of every signal
  SignalHistory spare;          ///< buffer for the next history of a signal
  bool spare_is_empty = false;  ///< no light in it anywhere
  StagedHistory staged;
  std::vector<SignalHistory> merged;     ///< with the future; empty until there is one
  std::vector<WaveletPlanes> wavelet;    ///< of every signal
  GuidePlanes coarse;                    ///< of limit_history; empty until it has run, as the next
  std::vector<ComparedPlanes> compared;  ///< of every signal
  Image3 scratch;
  Image1 firefly;  ///< empty unless fireflies are clamped
  /// Output of keep_samples, keep_mirrors and restore_detail; empty until one of them has run.
  FilterPlanes blended;
  FilterPlanes detail;     ///< of restore_detail; empty until it has run, as the next
  SignalHistory residual;  ///< buffer for the next mean residual of a signal
  std::vector<double> row_sums;
  int border = 0;  ///< of the planes that wavelets read; never shrinks, so that none is reallocated

  size_t bytes() const;
};

/// Work planes of one frame.
struct FrameWork {
  std::vector<LayerWork> layers;
  Image3 picture;  ///< before it is antialiased
  Image2 motion;   ///< of the picture; empty until there are virtual guides
  Image1 images;   ///< of FindImages, as the next; empty until there are virtual guides
  Image1 refracted_images;
  Image1 length;         ///< of the light that the picture shows; empty until there are images
  Image3 spline;         ///< coefficients of the last picture; empty unless it is resampled so
  SummedAlbedo albedo;   ///< of sum_albedo, as the next two; empty unless it runs
  Image3 albedo_spline;  ///< coefficients of the last frame's antialiased albedo
  Image3 albedo_out;     ///< this frame's
  FollowedBlocks followed_blocks;  ///< of follow_light, as the next two; empty unless it runs
  Image1 followed;                 ///< the light of this frame
  Image1 ratio;
  FillGuidesWork fill_guides;
  std::vector<double> row_sums;

  int border() const { return layers.empty() ? 0 : layers.front().border; }
  size_t bytes() const;
};

/// Gives the planes the size and the border of another plane, if necessary.
void MakeRoom(const Image1& like, FilterPlanes* planes);

/// Allocates memory for a frame of this size under the plan, if necessary.
void MakeRoom(const FramePlan& plan, int width, int height, FrameWork* work);

/// Restarts the history if it does not fit the frame and the plan, and gives it the border that the
/// wavelet reads. \return whether it was restarted
bool FitHistory(const FramePlan& plan, int width, int height, int border, History* history);

}  // namespace stillray

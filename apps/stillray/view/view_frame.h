// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The result of a frame that the engine passes to the interface: finished images and readouts.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stillray/denoise.hpp"
#include "stillray/io.h"
#include "stillray/quality.h"
#include "stillray/shared_picture.h"
#include "view/rate_control.h"
#include "view/view_pose.h"
#include "view/view_range.h"

namespace stillray::view {

struct InspectedValue {
  std::string view;
  std::vector<float> values;  ///< 1 to 3
};

/// Metrics of the denoised and of the noisy image against the reference.
struct LiveMeasures {
  ImageMetrics denoised;
  ImageMetrics noisy;
  int reference_spp = 0;
};

struct MemoryUse {
  size_t scene = 0;  ///< acceleration structure and light tables
  size_t denoiser = 0;
  size_t frame = 0;  ///< signals, guides, images
};

struct ViewFrame {
  uint64_t number = 0;  ///< number of the frame since the scene was opened, from 1
  uint64_t posted = 0;  ///< number of the last ViewEngine::Post included in the frame
  int width = 0;        ///< size of the images
  int height = 0;
  std::vector<std::string> panes;
  std::vector<Rgb8Image> pictures;  ///< one image per pane
  /// Per pane: nullptr, or the shared image that replaces its pixels.
  std::vector<std::shared_ptr<const SharedPicture>> shared;

  std::vector<ViewRange> ranges;  ///< range of the colour scale, per pane

  SampleRate rate;
  float scale = 0;         ///< resolution in use
  float chosen_scale = 0;  ///< requested resolution; above `scale` if frames took too long
  /// Filtered by `psvgf` with sparse guides instead of the configured filter.
  bool fast_filter = false;
  bool temporal = true;  ///< the filter accumulates
  /// Samples per pixel in the history or, without history, since the last change of the view.
  double samples = 0;
  bool still = false;  ///< static since the last frame
  double seconds = 0;
  double light_seconds = 0;  ///< time of the moving lights' clock
  double length = 0;         ///< duration of the animation in seconds; 0: no animation
  ViewPose pose;             ///< pose of the camera in this frame

  FrameCost cost;
  double show_ms = 0;             ///< time for creating the images
  std::vector<StageTime> stages;  ///< tracer first, then the denoiser
  MemoryUse memory;
  std::string device;     ///< device of the filter: see Device::description
  std::string tracer;     ///< device of the tracer
  std::string note;       ///< message for the user about this frame; usually empty
  int reference_spp = 0;  ///< samples in the reference; 0: none
  std::optional<LiveMeasures> measures;

  int inspect_x = 0;  ///< pixel of `inspected`
  int inspect_y = 0;
  std::vector<InspectedValue> inspected;
  uint64_t focus = 0;     ///< the last focus request answered by this frame
  float focus_depth = 0;  ///< 0: no surface
};

}  // namespace stillray::view

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// From settings and a frame's facts to what the shaders read.
#pragma once

#include <cstdint>
#include <span>

#include "denoise/signal_groups.h"
#include "denoise/vulkan/frame_images.h"
#include "denoise/vulkan/frame_shared.h"

namespace stillray::vulkan {

/// What is known of a frame before any of its pixels is read.
struct FrameFacts {
  int64_t index = 0;
  uint32_t lights = 0;          ///< bit k: light of SignalKind k is given
  uint32_t second_moments = 0;  ///< likewise
  uint32_t albedos = 0;         ///< bit 0 albedo, 1 specular, 2 transmission albedo
  bool has_samples = false;
  bool has_id = false;
  bool has_emission = false;
  bool has_background = false;
  bool has_roughness = false;   ///< and mirrors are looked for in it
  bool fills_guides = false;    ///< some pixels' guides are unknown
  float samples_per_pixel = 1;  ///< mean of this frame; below 1 the filter is told so
  bool jittered = false;        ///< rays did not go through the centres of the pixels
  bool colour_is_half = false;  ///< the output image is R16G16B16A16_SFLOAT
  bool shows = false;           ///< a display image is wanted
};

/// What a sequence has come to.
struct Progress {
  bool has_history = false;
  bool has_picture = false;  ///< the last frame's picture was antialiased
  bool jittered = false;     ///< some frame since the history began was
  float feedback_progress = 0;
  // Of the frame in progress:
  bool sparse = false;
  bool feeds_back = false;
  float feedback_phase = 1;
};

/// Advances the progress to a new frame: how far its samples bring the next feedback.
void AdvanceFeedback(const Settings& settings, float samples_per_pixel, Progress* progress);

/// The images that settings need; `storage` and size are the caller's.
Shape ShapeOf(const Settings& settings, int width, int height, int signals, Storage storage);

FrameParameters MakeParameters(const Settings& settings, std::span<const SignalGroup> groups,
                               const Shape& shape, const FrameFacts& facts,
                               const Progress& progress);

}  // namespace stillray::vulkan

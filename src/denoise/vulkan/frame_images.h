// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The images of a denoiser on Vulkan.
#pragma once

#include <array>

#include "denoise/vulkan/shaders.h"
#include "gpu/memory.h"

namespace stillray::vulkan {

/// Everything that determines the set of images.
struct Shape {
  int width = 0;
  int height = 0;
  int signals = 1;
  bool with_compressed = false;  ///< limit_history runs
  bool with_coarse = false;      ///< limit_history or restore_energy runs
  bool with_behind = false;      ///< feedback is blended in
  bool with_within = true;       ///< second moments may be given
  bool clamps_fireflies = false;
  bool luminance_factors = true;  ///< the wavelet has luminance weights
  bool with_albedo = false;       ///< antialias keeps the albedo
  Storage storage = Storage::kHalf;
  bool octahedral = true;  ///< normals of surfaces

  friend bool operator==(const Shape&, const Shape&) = default;
};

/// The history of all signals, one layer each; in half or single precision: colour (luminance, red,
/// blue, -), moments (mean, deviation, length, sum of squared weights), mean of compressed
/// luminances. See SignalHistory.
struct HistoryImages {
  const gpu::Image* colour = nullptr;
  const gpu::Image* behind = nullptr;  ///< `nothing` unless feedback is blended in
  const gpu::Image* moments = nullptr;
  const gpu::Image* compressed = nullptr;  ///< `nothing` unless limit_history runs
};

/// Guides, encoded by PackSurface and PackDetail of common.glsl.
struct GuideImages {
  const gpu::Image* surface = nullptr;
  const gpu::Image* detail = nullptr;
};

/// Histories of the later frames for all signals, one layer each, as floats in the unit of the
/// input: (luminance, red, blue, length) and (mean, variance, sum of squared weights, -).
struct FutureImages {
  const gpu::Image* light = nullptr;
  const gpu::Image* moments = nullptr;
};

struct FrameImages {
  HistoryImages history;
  HistoryImages fetched;
  const gpu::Image* noisy = nullptr;      ///< luminance, red, blue, samples
  const gpu::Image* unclamped = nullptr;  ///< `noisy` before fireflies are clamped
  const gpu::Image* within = nullptr;
  GuideImages coarse;  ///< of limit_history and restore_energy, at half the size, as are all images
                       ///< up to `ratio`
  const gpu::Image* compared[2] = {};  ///< see compare_history.comp
  const gpu::Image* compressed_light = nullptr;
  const gpu::Image* wide = nullptr;  ///< of limit_history: changes of the wide surroundings
  const gpu::Image* ratio = nullptr;
  const gpu::Image* wavelet[2] = {};  ///< luminance, red, blue, deviation (negative: no samples)
  const gpu::Image* luminance_factor = nullptr;
  GuideImages guides;
  GuideImages previous_guides;
  const gpu::Image* turn2 = nullptr;    ///< SquaredTurn of the normals; one layer
  const gpu::Image* picture = nullptr;  ///< output image of this frame, times its exposure
  const gpu::Image* scratch = nullptr;
  const gpu::Image* shown = nullptr;  ///< the last antialiased image
  // Of antialias; placeholders unless it keeps the albedo:
  const gpu::Image* albedo = nullptr;         ///< the sum of this frame
  const gpu::Image* albedo_range = nullptr;   ///< range of each block: lowest and highest
  const gpu::Image* albedo_before = nullptr;  ///< the last antialiased sum
  const gpu::Image* albedo_out = nullptr;
  // Of follow_light; one texel per block, floats:
  const gpu::Image* followed = nullptr;         ///< radiance of this frame
  const gpu::Image* followed_before = nullptr;  ///< radiance of the last frame
  const gpu::Image* changes = nullptr;          ///< see follow_light.comp
  const gpu::Image* followed_ratio = nullptr;
  /// Placeholders for absent images; one pixel.
  const gpu::Image* nothing = nullptr;           ///< an array of radiance
  const gpu::Image* nothing_scalar = nullptr;    ///< an array of scalars
  const gpu::Image* nothing_fraction = nullptr;  ///< an array of numbers in 0..1
  const gpu::Image* no_input = nullptr;
  const gpu::Image* no_ids = nullptr;
  const gpu::Image* no_float_output = nullptr;
  const gpu::Image* no_half_output = nullptr;
  const gpu::Image* no_display = nullptr;

  const gpu::Buffer* parameters = nullptr;
  const gpu::Buffer* state = nullptr;
  const gpu::Buffer* partials = nullptr;
  const gpu::Buffer* history_sums = nullptr;  ///< see prepare_guides.comp
};

/// Numbers of workgroups that cover an image.
struct Groups {
  uint32_t x = 0;
  uint32_t y = 0;

  uint32_t count() const { return x * y; }
};
inline constexpr int kGroupWidth = 16;
inline constexpr int kGroupHeight = 8;
inline Groups GroupsFor(int width, int height) {
  return {static_cast<uint32_t>((width + kGroupWidth - 1) / kGroupWidth),
          static_cast<uint32_t>((height + kGroupHeight - 1) / kGroupHeight)};
}

/// Adds all images and buffers of the shape to the arena; allocates no memory yet.
Result<FrameImages> AddImages(const Shape& shape, gpu::Arena* arena);

}  // namespace stillray::vulkan

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The two ways of tracing rays on a device. All other code is the same.
#pragma once

#include <cstdint>

namespace stillray::render {

enum class TracingWay : uint8_t {
  kAuto,      ///< hardware if a GPU has units for it, else compute
  kHardware,  ///< VK_KHR_ray_tracing_pipeline
  kCompute,   ///< stillray's BVH, traversed by compute shaders: on any device
};

/// Ways of finding the camera's first hits.
enum class FirstHits : uint8_t {
  kAuto,  ///< drawn, except on GPUs whose driver emulates ray tracing pipelines: see DrawsFirstHits
  kDraw,  ///< by the rasteriser, if the device can
  kTrace,  ///< as all other rays
};

/// Ways of reading textures.
enum class TextureWay : uint8_t {
  kAuto,     ///< sampled by GPUs, unless they have no images of the size that the scene needs
  kExact,    ///< texels from a buffer, filtered as on the CPU: the same values
  kSampled,  ///< by texture units, which filter with fractions of 8 bits
};

}  // namespace stillray::render

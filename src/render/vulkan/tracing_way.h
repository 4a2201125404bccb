// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Selects ray tracing pipelines or compute shaders for tracing rays on a device; all other code is
/// common to both.
#pragma once

#include <cstdint>

namespace stillray::render {

enum class TracingWay : uint8_t {
  kAuto,      ///< kHardware if the GPU has ray tracing units, else kCompute
  kHardware,  ///< VK_KHR_ray_tracing_pipeline
  kCompute,   ///< stillray's BVH, traversed by compute shaders; runs on any device
};

/// Method for primary hits.
enum class FirstHits : uint8_t {
  kAuto,  ///< kDraw, except on GPUs whose driver emulates ray tracing pipelines: see DrawsFirstHits
  kDraw,  ///< rasterised, if the device supports it
  kTrace,  ///< traced like all other rays
};

/// Method for texture lookups.
enum class TextureWay : uint8_t {
  kAuto,     ///< kSampled on GPUs, unless the scene's textures exceed the device's image size
  kExact,    ///< texels from a buffer, filtered as on the CPU, with equal values
  kSampled,  ///< by texture units, which filter with 8-bit fractions
};

}  // namespace stillray::render

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Layer names of renderers: one table per renderer.
#pragma once

#include <span>
#include <string_view>

#include "stillray/aov.h"

namespace stillray::io {

/// The layer of an AOV. Of several rows with the same `aov`, the first one that exists in the file
/// is used.
struct AovNameRow {
  Aov aov;
  const char* layer;     ///< without its prefix ("ViewLayer."); "" for the main image
  const char* channels;  ///< one letter per component: "RGB", "XYZ", "Z"
};

struct AovPreset {
  std::string_view name;
  std::span<const AovNameRow> rows;
  MotionConvention motion;
  MotionConvention next_motion;
  DepthConvention depth;
  NormalConvention normal;
  bool light_is_divided = false;
  bool id_is_index = false;  ///< ids are user-defined numbers from 0, not hashes
};

/// In the order of preference of "auto" for presets that match equally many layers.
std::span<const AovPreset> AovPresets();

}  // namespace stillray::io

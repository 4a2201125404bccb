// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Layer names of renderers: one table per renderer.
#pragma once

#include <span>
#include <string_view>

#include "stillray/aov.h"

namespace stillray::io {

/// A layer that serves as `aov`. Of several rows with the same `aov`, the first that the file has
/// is used.
struct AovNameRow {
  Aov aov;
  const char* layer;     ///< without its prefix ("ViewLayer."); "" for the main picture
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
  bool id_is_index = false;  ///< ids are numbers from 0 that users assign, not hashes
};

/// In the order of preference of "auto" when they match equally many layers.
std::span<const AovPreset> AovPresets();

}  // namespace stillray::io

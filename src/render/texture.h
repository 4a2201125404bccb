// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Texture lookups as in glTF 2.0 (3.8.4), without mip levels.
#pragma once

#include "stillray/scene.h"

namespace stillray::render {

enum class TexelEncoding : uint8_t { kLinear, kSrgb };  ///< of RGB; alpha is always linear

/// Texture lookup at `uv` (already transformed; (0,0) is the top left corner): bilinear, or nearest
/// if the texture specifies it; each component in 0..1.
vec4 SampleTexture(const Texture& texture, vec2 uv, TexelEncoding encoding);

/// Applies KHR_texture_transform.
inline vec2 TransformUv(const TextureRef& ref, vec2 uv) {
  const vec3 t = ref.transform * vec3(uv, 1.0f);
  return {t.x, t.y};
}

}  // namespace stillray::render

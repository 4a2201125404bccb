// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Texel addresses: glTF 2.0 (3.8.4), without mip levels.
#ifndef STILLRAY_RENDER_TEXTURE_SHARED_H
#define STILLRAY_RENDER_TEXTURE_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Values of Wrap.
const int kWrapRepeat = 0;
const int kWrapMirror = 1;
const int kWrapClamp = 2;

SHARED_FN int WrapTexel(int i, int size, int wrap) {
  if (wrap == kWrapRepeat) {
    if ((size & (size - 1)) == 0) {
      return i & (size - 1);
    }
    int m = i - i / size * size;  // in GLSL % of negative numbers is undefined
    return m < 0 ? m + size : m;
  }
  if (wrap == kWrapMirror) {
    int m = i - i / (2 * size) * (2 * size);
    m = m < 0 ? m + 2 * size : m;
    return m < size ? m : 2 * size - 1 - m;
  }
  return i < 0 ? 0 : (i >= size ? size - 1 : i);
}

// Replaces texture coordinates by 0 that are NaN or would overflow an int after scaling: they come
// from files.
SHARED_FN float SafeCoordinate(float x) {
  const float kLimit = 1e6f;
  return x > -kLimit && x < kLimit ? x : 0.0f;
}

// floor(x) for a SafeCoordinate, which fits into an int.
SHARED_FN int FloorToInt(float x) {
  int towards_zero = int(x);
  return towards_zero - (x < float(towards_zero) ? 1 : 0);
}

// Maps x to 0..`size` such that a bilinear lookup in the texture with a border of one texel equals
// the lookup in the wrapped texture at x.
SHARED_FN float WrapCoordinate(float x, float size, int wrap) {
  if (wrap == kWrapClamp) {
    return clamp(x, 0.0f, size);
  }
  float period = wrap == kWrapMirror ? 2.0f * size : size;
  float in_period = clamp(x - floor(x / period) * period, 0.0f, period);
  return in_period > size ? period - in_period : in_period;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_TEXTURE_SHARED_H

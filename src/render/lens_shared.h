// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The thin lens: points on the aperture.
//
// The aperture lies in the unit disk (a mask: in its bounding square), x to the right and y up as
// seen along the view direction. A point of the lens acts as a pinhole camera with a shifted image
// plane (CameraView::Through); the rays of a pixel through all lens points meet in the plane of
// focus. Potmesil and Chakravarty (1981), "A Lens and Aperture Camera Model for Synthetic Image
// Generation"; Cook, Porter and Carpenter (1984), "Distributed Ray Tracing".
//
// In C++ the cumulative sums of a mask are an argument, LENS_IN. In GLSL, which cannot pass them,
// the including shader first declares a variable `lens` of LensShape, and
//   float LensSum(int i)    the i-th cumulative sum
#ifndef STILLRAY_RENDER_LENS_SHARED_H
#define STILLRAY_RENDER_LENS_SHARED_H

#ifdef __cplusplus
#include "render/lens_shape_shared.h"
#endif

STILLRAY_RENDER_BEGIN

#ifdef __cplusplus
struct LensArrays : LensShape {
  const float* sums = nullptr;
};
inline float LensSum(const LensArrays& lens, int i) {
  return lens.sums[i];
}
#define LENS_IN const LensArrays &lens,
#define LENS lens,
#else
#define LENS_IN
#define LENS
#endif

// Cumulative sums from 0 to 1: of the mask's rows, then of the columns of each row.
SHARED_FN int FirstLensColumn(LENS_IN int row) {
  return lens.mask_height + 1 + row * (lens.mask_width + 1);
}

// Continuous index of u among the `count` intervals of the sums from `first` on: the interval's
// index plus the fraction within it.
SHARED_FN float FindInLensSums(LENS_IN int first, int count, float u) {
  int low = 1;
  int high = count;
  while (low < high) {
    int middle = (low + high) / 2;
    if (LensSum(LENS first + middle) > u) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  float below = LensSum(LENS first + low - 1);
  float width = LensSum(LENS first + low) - below;
  float within = width > 0.0f ? clamp((u - below) / width, 0.0f, kBelowOne) : 0.5f;
  return float(low - 1) + within;
}

// Samples the mask in proportion to its luminance: rows, then columns. The longer side of the mask
// spans the square.
SHARED_FN vec2 LensPointOfMask(LENS_IN vec2 u) {
  float y = FindInLensSums(LENS 0, lens.mask_height, u.y);
  int row = min(int(y), lens.mask_height - 1);
  float x = FindInLensSums(LENS FirstLensColumn(LENS row), lens.mask_width, u.x);
  float width = float(lens.mask_width);
  float height = float(lens.mask_height);
  return vec2(2.0f * x - width, height - 2.0f * y) / max(width, height);
}

// A point of the aperture, uniform by area. u in [0, 1)^2.
SHARED_FN vec2 LensPoint(LENS_IN vec2 u) {
  if (lens.mask_width > 0) {
    return LensPointOfMask(LENS u);
  }
  float r = sqrt(u.y);
  if (lens.blades == 0) {
    return r * CosSinOfTurn(u.x);
  }
  // Samples a triangle between the centre and two corners.
  float blades = float(lens.blades);
  float corner = min(floor(u.x * blades), blades - 1.0f);
  float along = min(u.x * blades - corner, 1.0f);
  vec2 a = CosSinOfTurn(fract(lens.rotation + corner / blades));
  vec2 b = CosSinOfTurn(fract(lens.rotation + (corner + 1.0f) / blades));
  return r * (a * (1.0f - along) + b * along);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_LENS_SHARED_H

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/shared.h"
#include "denoise/stages/antialias.h"
#include "denoise/stages/antialias_shared.h"
#include "denoise/stages/follow_light.h"
#include "denoise/stages/reproject_shared.h"

namespace stillray::reference {
namespace {

vec3 Load(const Image3& image, int x, int y) {
  x = std::clamp(x, 0, image.width() - 1);
  y = std::clamp(y, 0, image.height() - 1);
  return {image[0](x, y), image[1](x, y), image[2](x, y)};
}

/// Motion of the nearest surface of the 3x3 neighbourhood in front of the centre's own; of equal
/// ones the first in reading order.
vec2 NearestMotion(const Image2& motion, const GuidePlanes& guides, int x, int y) {
  const float centre = guides.inverse_depth(x, y);
  const vec2 gradient = {guides.gradient[0](x, y), guides.gradient[1](x, y)};
  float nearest = centre;
  vec2 result = {motion[0](x, y), motion[1](x, y)};
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int qx = std::clamp(x + dx, 0, motion.width() - 1);
      const int qy = std::clamp(y + dy, 0, motion.height() - 1);
      const vec2 offset = {static_cast<float>(qx - x), static_cast<float>(qy - y)};
      if (guides.inverse_depth(qx, qy) > nearest &&
          StandsInFront(centre, guides.inverse_depth(qx, qy), gradient, offset)) {
        nearest = guides.inverse_depth(qx, qy);
        result = {motion[0](qx, qy), motion[1](qx, qy)};
      }
    }
  }
  return result;
}

/// The longest history in the 3x3 neighbourhood.
float LongestAround(const Image1& length, int x, int y) {
  float longest = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      longest = std::max(longest, length(std::clamp(x + dx, 0, length.width() - 1),
                                         std::clamp(y + dy, 0, length.height() - 1)));
    }
  }
  return longest;
}

/// Weight of the new picture at a pixel.
float NewWeight(const AntialiasInput& in, float taa_alpha, int x, int y) {
  if (in.length == nullptr) {
    return taa_alpha;
  }
  const float given = in.confidence == nullptr ? 1.0f : (*in.confidence)(x, y);
  const float alpha = ConfidentAlpha(taa_alpha, UsedConfidence(given, std::isnan(given)));
  return NewPictureWeight(alpha, LongestAround(*in.length, x, y),
                          in.samples == nullptr ? 1.0f : (*in.samples)(x, y));
}

/// The previous picture at a place.
vec3 SamplePrevious(const AntialiasInput& in, vec2 place) {
  const float fx = std::floor(place.x);
  const float fy = std::floor(place.y);
  const float u = place.x - fx;
  const float v = place.y - fy;
  if (u == 0 && v == 0) {
    return Load(in.previous, static_cast<int>(fx), static_cast<int>(fy));
  }
  const bool spline = in.spline != nullptr;
  const Image3& image = spline ? *in.spline : in.previous;
  const vec4 wx = spline ? CubicSpline(u) : CatmullRom(u);
  const vec4 wy = spline ? CubicSpline(v) : CatmullRom(v);
  vec3 sum(0.0f);
  for (int j = 0; j < 4; ++j) {
    vec3 row(0.0f);
    for (int i = 0; i < 4; ++i) {
      row += wx[i] * Load(image, static_cast<int>(fx) + i - 1, static_cast<int>(fy) + j - 1);
    }
    sum += wy[j] * row;
  }
  return sum;
}

}  // namespace

void Antialias(const Image3& colour, const AntialiasInput& in, const AntialiasParameters& p,
               Image3* out) {
  const int width = colour.width();
  const int height = colour.height();
  std::vector<float> ratio(static_cast<size_t>(width), 1.0f);
  for (int y = 0; y < height; ++y) {
    if (in.ratio != nullptr) {
      FollowedRow(*in.ratio, y, width, ratio.data());
    }
    for (int x = 0; x < width; ++x) {
      const vec3 now = Load(colour, x, y);
      const vec2 m = NearestMotion(in.motion, in.guides, x, y);
      const vec2 place = {static_cast<float>(x) + m.x, static_cast<float>(y) + m.y};
      const bool inside = place.x > -0.5f && place.y > -0.5f &&
                          place.x < static_cast<float>(width) - 0.5f &&
                          place.y < static_cast<float>(height) - 0.5f;
      vec3 result = now;
      if (inside) {
        vec3 low = now;
        vec3 high = now;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            low = min(low, Load(colour, x + dx, y + dy));
            high = max(high, Load(colour, x + dx, y + dy));
          }
        }
        const vec3 before =
            min(max(ratio[static_cast<size_t>(x)] * SamplePrevious(in, place), low), high);
        const float alpha = NewWeight(in, p.taa_alpha, x, y);
        for (int c = 0; c < 3; ++c) {
          result[c] = p.tone_scale > 0 ? BlendTonemapped(before[c], now[c], alpha, p.tone_scale)
                                       : before[c] + alpha * (now[c] - before[c]);
        }
      }
      for (int c = 0; c < 3; ++c) {
        (*out)[c](x, y) = result[c];
        if (in.copy != nullptr) {
          (*in.copy)[c](x, y) = result[c];
        }
      }
    }
  }
}

}  // namespace stillray::reference

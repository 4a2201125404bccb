// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/colour.h"
#include "core/colour_shared.h"
#include "core/parallel.h"
#include "denoise/stages/follow_light.h"

namespace stillray {
namespace {

float Finite(float value, float otherwise) {
  return std::isfinite(value) ? value : otherwise;
}

/// The luminance of a signal's divisor; for a signal of one channel, that channel's part.
float AlbedoAt(const AlbedoSum& albedo, int x, int y) {
  vec3 sum(0.0f);
  for (int i = 0; i < albedo.count; ++i) {
    const Image3& part = *albedo.part[i];
    sum += vec3(part[0](x, y), part[1](x, y), part[2](x, y));
  }
  if (const int c = albedo.channel; c >= 0) {
    vec3 part(0.0f);
    part[c] = albedo.count == 0 ? 1.0f : Finite(std::max(sum[c], kAlbedoFloor), 1.0f);
    return Luminance709(part);
  }
  return albedo.count == 0 ? 1.0f : Finite(std::max(Luminance709(sum), kAlbedoFloor), 1.0f);
}

/// Luminances of a pixel.
struct PixelLight {
  float own = 0;  ///< of the followed signals, demodulated
  float albedo = 0;
  float rest = 0;  ///< of all other radiance
};

PixelLight LightAt(const FollowLightInput& in, int x, int y) {
  PixelLight light;
  for (size_t k = 0; k < in.parts.signals.size(); ++k) {
    const SignalLight& signal = in.parts.signals[k];
    const float albedo = AlbedoAt(signal.albedo, x, y);
    const float reflected = albedo * std::max((*signal.light)[0](x, y), 0.0f);
    if (k < in.followed_signals) {
      light.own += reflected;
      light.albedo += albedo;
    } else {
      light.rest += reflected;
    }
  }
  for (const Image3* image : in.parts.unfiltered) {
    const vec3 value((*image)[0](x, y), (*image)[1](x, y), (*image)[2](x, y));
    light.rest += std::max(Finite(Luminance709(value), 0.0f), 0.0f);
  }
  light.own = light.albedo > 0 ? light.own / light.albedo : 0.0f;
  return light;
}

/// Whether another surface is within kFollowClear pixels along an axis.
bool IsNearSurface(const Image1& inverse_depth, int x, int y) {
  const float here = inverse_depth(x, y);
  for (int k = 1; k <= kFollowClear; ++k) {
    const bool row = x >= k && x + k < inverse_depth.width() &&
                     IsBesideSurface(here, inverse_depth(x - k, y), inverse_depth(x + k, y));
    const bool column = y >= k && y + k < inverse_depth.height() &&
                        IsBesideSurface(here, inverse_depth(x, y - k), inverse_depth(x, y + k));
    if (row || column) {
      return true;
    }
  }
  return false;
}

/// \return the radiance of a pixel's surface in the last frame; negative: unknown
float LightBefore(const FollowLightInput& in, int x, int y) {
  if (in.before == nullptr || !(in.guides.inverse_depth(x, y) > 0)) {
    return -1;
  }
  const vec2 motion(in.motion[0](x, y), in.motion[1](x, y));
  const float px = static_cast<float>(x) + motion.x;
  const float py = static_cast<float>(y) + motion.y;
  const auto width = static_cast<float>(in.motion.width());
  const auto height = static_cast<float>(in.motion.height());
  const bool inside = px > -0.5f && py > -0.5f && px < width - 0.5f && py < height - 0.5f;
  const float apart = std::abs(in.picture_motion[0](x, y) - motion.x) +
                      std::abs(in.picture_motion[1](x, y) - motion.y);
  const float n = in.samples != nullptr ? (*in.samples)(x, y) : 1.0f;
  if (!inside || !(apart < kMostMotionApart) || !(in.length(x, y) > n) ||
      IsNearSurface(in.guides.inverse_depth, x, y)) {
    return -1;
  }
  return (*in.before)(FollowNearest(px, in.before->width()),
                      FollowNearest(py, in.before->height()));
}

void CompareRow(const FollowLightInput& in, int by, FollowedBlocks* blocks, Image1* now) {
  const int y = FollowPixel(by, in.motion.height());
  for (int bx = 0; bx < now->width(); ++bx) {
    const int x = FollowPixel(bx, in.motion.width());
    const PixelLight light = LightAt(in, x, y);
    const float before = LightBefore(in, x, y);
    (*now)(bx, by) = light.own;
    const float was = light.albedo * std::max(before, 0.0f) + light.rest;
    const float change = LogChange(light.albedo * light.own + light.rest, was);
    blocks->known(bx, by) = before >= 0 ? 1.0f : 0.0f;
    blocks->change(bx, by) = before >= 0 ? change : 0.0f;
    blocks->inverse_depth(bx, by) = in.guides.inverse_depth(x, y);
    const vec3 normal = NormalAt(in.guides, x, y);
    for (int c = 0; c < 3; ++c) {
      blocks->normal[c](bx, by) = normal[c];
    }
    for (int c = 0; c < 2; ++c) {
      blocks->gradient[c](bx, by) = in.guides.gradient[c](x, y);
    }
    blocks->id(bx, by) = in.guides.id(x, y);
  }
}

}  // namespace

FollowedBlocks::FollowedBlocks(int width, int height)
    : change(FollowSize(width), FollowSize(height), kFollowRadius),
      known(FollowSize(width), FollowSize(height), kFollowRadius),
      inverse_depth(FollowSize(width), FollowSize(height), kFollowRadius),
      normal(FollowSize(width), FollowSize(height), kFollowRadius),
      gradient(FollowSize(width), FollowSize(height), kFollowRadius),
      id(FollowSize(width), FollowSize(height), kFollowRadius) {}

void CompareBlocks(const FollowLightInput& in, FollowedBlocks* blocks, Image1* now) {
  ParallelRows(now->height(), 8, [&](int y0, int y1) {
    for (int by = y0; by < y1; ++by) {
      CompareRow(in, by, blocks, now);
    }
  });
}

void FollowedRow(const Image1& ratio, int y, int width, float* row) {
  constexpr float kStep = 1.0f / kFollowBlock;
  const float place = (static_cast<float>(y) - 0.5f * kFollowBlock) * kStep;
  const float above = std::floor(place);
  const float v = place - above;
  const int last = ratio.height() - 1;
  const float* top = ratio.Row(std::clamp(static_cast<int>(above), 0, last));
  const float* bottom = ratio.Row(std::clamp(static_cast<int>(above) + 1, 0, last));
  const auto at = [&](int block) {
    const int b = std::clamp(block, 0, ratio.width() - 1);
    return top[b] + v * (bottom[b] - top[b]);
  };
  // The pixel of block b is at kFollowBlock * b + kFollowBlock / 2.
  for (int b = -1; b < ratio.width(); ++b) {
    const float left = at(b);
    const float step = kStep * (at(b + 1) - left);
    for (int i = 0; i < kFollowBlock; ++i) {
      const int x = kFollowBlock * b + kFollowBlock / 2 + i;
      if (x >= 0 && x < width) {
        row[x] = left + step * static_cast<float>(i);
      }
    }
  }
}

}  // namespace stillray

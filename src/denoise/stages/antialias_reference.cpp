// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
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

/// Motion of the nearest surface of the 3x3 neighbourhood in front of the centre, else that of the
/// centre; of equal depths the first in row order. \param extrapolates  ExtrapolatedMotion
vec2 NearestMotion(const Image2& motion, const GuidePlanes& guides, bool extrapolates, int x,
                   int y) {
  const auto clamped = [&](int qx, int qy) {
    return std::pair(std::clamp(qx, 0, motion.width() - 1), std::clamp(qy, 0, motion.height() - 1));
  };
  const auto gradient_at = [&](int qx, int qy) {
    return vec2(guides.gradient[0](qx, qy), guides.gradient[1](qx, qy));
  };
  const auto motion_at = [&](int qx, int qy) { return vec2(motion[0](qx, qy), motion[1](qx, qy)); };
  const float centre = guides.inverse_depth(x, y);
  const vec2 gradient = gradient_at(x, y);
  float nearest = centre;
  vec2 to_nearest(0.0f);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const auto [qx, qy] = clamped(x + dx, y + dy);
      const vec2 offset = {static_cast<float>(qx - x), static_cast<float>(qy - y)};
      if (guides.inverse_depth(qx, qy) > nearest &&
          StandsInFront(centre, guides.inverse_depth(qx, qy), gradient, offset)) {
        nearest = guides.inverse_depth(qx, qy);
        to_nearest = offset;
      }
    }
  }
  const int qx = x + static_cast<int>(to_nearest.x);
  const int qy = y + static_cast<int>(to_nearest.y);
  const vec2 result = motion_at(qx, qy);
  if (!extrapolates || !(nearest > centre)) {
    return result;
  }
  const vec2 gradient_of_nearest = gradient_at(qx, qy);
  vec2 next[2];
  for (int k = 0; k < 2; ++k) {
    const vec2 offset = static_cast<float>(k + 1) * to_nearest;
    const auto [nx, ny] = clamped(qx + static_cast<int>(offset.x), qy + static_cast<int>(offset.y));
    if (!IsOnPlane(nearest, gradient_of_nearest, guides.inverse_depth(nx, ny), offset)) {
      return result;
    }
    next[k] = motion_at(nx, ny);
  }
  return ExtrapolatedMotion(result, next[0], next[1]);
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

/// The smallest AlbedoAgreement of the three channels.
float AgreementOf(vec3 now, vec3 antialiased) {
  float agreement = 1.0f;
  for (int c = 0; c < 3; ++c) {
    agreement = min(agreement, AlbedoAgreement(now[c], antialiased[c]));
  }
  return agreement;
}

/// Weight of the new image at a pixel. \param least  that of MovingAlpha
float NewWeight(const AntialiasInput& in, float least, int x, int y) {
  if (in.length == nullptr) {
    return least;
  }
  const float given = in.confidence == nullptr ? 1.0f : (*in.confidence)(x, y);
  const float alpha = ConfidentAlpha(least, UsedConfidence(given, std::isnan(given)));
  return NewPictureWeight(alpha, LongestAround(*in.length, x, y),
                          in.samples == nullptr ? 1.0f : (*in.samples)(x, y));
}

/// An image of the last frame, and how it is resampled.
struct PreviousImage {
  const Image3& image;
  const Image3* spline;  ///< its spline coefficients; nullptr: not with a spline
  bool subcell;          ///< ResampleSubcell
};

vec3 SampleSubcell(const Image3& image, int x, int y, float u, float v) {
  vec3 result;
  for (int c = 0; c < 3; ++c) {
    std::array<float, 4> rows;
    for (int j = 0; j < 4; ++j) {
      const auto tap = [&](int i) { return Load(image, x + i - 1, y + j - 1)[c]; };
      rows[static_cast<size_t>(j)] = ResampleSubcell(tap(0), tap(1), tap(2), tap(3), u);
    }
    result[c] = ResampleSubcell(rows[0], rows[1], rows[2], rows[3], v);
  }
  return result;
}

vec3 Sample(const PreviousImage& previous, vec2 place) {
  const float fx = std::floor(place.x);
  const float fy = std::floor(place.y);
  const float u = place.x - fx;
  const float v = place.y - fy;
  if (u == 0 && v == 0) {
    return Load(previous.image, static_cast<int>(fx), static_cast<int>(fy));
  }
  if (previous.subcell) {
    return SampleSubcell(previous.image, static_cast<int>(fx), static_cast<int>(fy), u, v);
  }
  const bool spline = previous.spline != nullptr;
  const Image3& image = spline ? *previous.spline : previous.image;
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

struct Range {
  vec3 low, high;
};

vec3 Clamp(vec3 value, const Range& range) {
  return min(max(value, range.low), range.high);
}

/// The range of load(x, y) in the 3x3 neighbourhood.
template <typename LoadPixel>
Range RangeAround(const LoadPixel& load, int x, int y) {
  Range range = {load(x, y), load(x, y)};
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      range.low = min(range.low, load(x + dx, y + dy));
      range.high = max(range.high, load(x + dx, y + dy));
    }
  }
  return range;
}

vec3 LightOf(vec3 picture, vec3 albedo) {
  return {LightOfPicture(picture.x, albedo.x), LightOfPicture(picture.y, albedo.y),
          LightOfPicture(picture.z, albedo.z)};
}

vec3 PictureOf(vec3 light, vec3 albedo) {
  return {PictureOfLight(light.x, albedo.x), PictureOfLight(light.y, albedo.y),
          PictureOfLight(light.z, albedo.z)};
}

/// Whether another surface is within kTextureClear pixels along an axis.
bool IsBesideSurface(const GuidePlanes& guides, int x, int y) {
  const float here = guides.inverse_depth(x, y);
  const vec2 gradient = {guides.gradient[0](x, y), guides.gradient[1](x, y)};
  const auto differs = [&](int dx, int dy) {
    const int qx = std::clamp(x + dx, 0, guides.id.width() - 1);
    const int qy = std::clamp(y + dy, 0, guides.id.height() - 1);
    const vec2 offset = {static_cast<float>(qx - x), static_cast<float>(qy - y)};
    return !IsOnPlane(here, gradient, guides.inverse_depth(qx, qy), offset);
  };
  for (int k = 1; k <= kTextureClear; ++k) {
    if (differs(-k, 0) || differs(k, 0) || differs(0, -k) || differs(0, k)) {
      return true;
    }
  }
  return false;
}

/// WasBesideSurface for the pixel of the last frame that is nearest to a position.
bool WasBesideSurface(const Image1& inverse_depth, vec2 place) {
  const auto at = [&](int x, int y) {
    return inverse_depth(std::clamp(x, 0, inverse_depth.width() - 1),
                         std::clamp(y, 0, inverse_depth.height() - 1));
  };
  const int x = static_cast<int>(std::floor(place.x + 0.5f));
  const int y = static_cast<int>(std::floor(place.y + 0.5f));
  for (int k = 1; k <= kTextureClear; ++k) {
    if (stillray::WasBesideSurface(at(x, y), at(x - k, y), at(x + k, y)) ||
        stillray::WasBesideSurface(at(x, y), at(x, y - k), at(x, y + k))) {
      return true;
    }
  }
  return false;
}

/// The previous albedo at a position, clamped.
/// \param around  the range of the albedo
vec3 PreviousAlbedo(const AntialiasInput& in, bool subcell, const Range& around, vec2 place, int x,
                    int y) {
  const SummedAlbedo& albedo = in.texture->albedo;
  const int bx = x / kAlbedoBlock;
  const int by = y / kAlbedoBlock;
  const vec3 before = Sample({*in.texture->before, in.texture->spline, subcell}, place);
  const vec3 inside = Clamp(before, {Load(albedo.low, bx, by), Load(albedo.high, bx, by)});
  const float n = in.samples == nullptr ? 1.0f : (*in.samples)(x, y);
  const bool beside_image = !albedo.beside_image.empty() && albedo.beside_image(x, y) != 0;
  const bool clamps = IsYoung((*in.length)(x, y), n) || IsBesideSurface(in.guides, x, y) ||
                      WasBesideSurface(*in.texture->depth_before, place) || beside_image;
  return clamps ? Clamp(inside, around) : inside;
}

/// The range of the image, widened by WidenedLow and WidenedHigh.
Range Widened(const Range& picture, vec3 albedo, const Range& albedos) {
  Range wide;
  for (int c = 0; c < 3; ++c) {
    wide.low[c] = WidenedLow(picture.low[c], albedo[c], albedos.low[c]);
    wide.high[c] = WidenedHigh(picture.high[c], albedo[c], albedos.high[c]);
  }
  return wide;
}

void Store(vec3 value, int x, int y, Image3* image) {
  for (int c = 0; c < 3; ++c) {
    (*image)[c](x, y) = value[c];
  }
}

/// The previous image at a position, clamped, and its albedo.
struct Previous {
  vec3 picture, albedo;
};

Previous FindPrevious(const Image3& colour, const AntialiasInput& in, bool subcell, float ratio,
                      vec2 place, int x, int y) {
  const auto now = [&](int qx, int qy) { return Load(colour, qx, qy); };
  const vec3 before = ratio * Sample({in.previous, in.spline, subcell}, place);
  const Range picture = RangeAround(now, x, y);
  if (in.texture == nullptr || in.texture->before == nullptr) {
    return {Clamp(before, picture), vec3(0.0f)};
  }
  const auto light = [&](int qx, int qy) {
    return LightOf(now(qx, qy), Load(in.texture->albedo.sum, qx, qy));
  };
  const Range albedos =
      RangeAround([&](int qx, int qy) { return Load(in.texture->albedo.sum, qx, qy); }, x, y);
  const vec3 albedo = PreviousAlbedo(in, subcell, albedos, place, x, y);
  const vec3 clamped = PictureOf(Clamp(LightOf(before, albedo), RangeAround(light, x, y)), albedo);
  return {Clamp(clamped, Widened(picture, albedo, albedos)), albedo};
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
      const vec2 m = NearestMotion(in.motion, in.guides, p.extrapolate_motion != 0, x, y);
      const vec2 place = {static_cast<float>(x) + m.x, static_cast<float>(y) + m.y};
      const bool inside = place.x > -0.5f && place.y > -0.5f &&
                          place.x < static_cast<float>(width) - 0.5f &&
                          place.y < static_cast<float>(height) - 0.5f;
      const bool with_albedo = inside && in.texture != nullptr && in.texture->before != nullptr;
      vec3 result = now;
      vec3 albedo = in.texture != nullptr ? Load(in.texture->albedo.sum, x, y) : vec3(0.0f);
      if (inside) {
        const Previous before = FindPrevious(colour, in, p.resampling == kSubcell,
                                             ratio[static_cast<size_t>(x)], place, x, y);
        const float agreement = with_albedo ? AgreementOf(albedo, before.albedo) : 1.0f;
        const float alpha =
            NewWeight(in, MovingAlpha(p.taa_alpha, p.taa_moving_alpha, m, agreement), x, y);
        for (int c = 0; c < 3; ++c) {
          result[c] = p.tone_scale > 0
                          ? BlendTonemapped(before.picture[c], now[c], alpha, p.tone_scale)
                          : before.picture[c] + alpha * (now[c] - before.picture[c]);
        }
        albedo = with_albedo ? before.albedo + alpha * (albedo - before.albedo) : albedo;
      }
      Store(result, x, y, out);
      if (in.copy != nullptr) {
        Store(result, x, y, in.copy);
      }
      if (in.texture != nullptr) {
        Store(albedo, x, y, in.texture->out);
      }
    }
  }
}

}  // namespace stillray::reference

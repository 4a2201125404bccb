// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames made by formula for the tests of the denoiser.
#pragma once

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "core/random.h"
#include "denoise/planes.h"
#include "stillray/frame.h"

namespace stillray::test {

inline float Random(uint32_t a, uint32_t b, uint32_t c) {
  return UniformFloat(HashCombine(HashCombine(a, b), c));
}

inline void FillImage(Image1* image, const std::function<float(int, int)>& f) {
  for (int y = 0; y < image->height(); ++y) {
    for (int x = 0; x < image->width(); ++x) {
      (*image)(x, y) = f(x, y);
    }
  }
}

template <int N>
void FillImage(Planes<float, N>* image, const std::function<float(int, int, int)>& f) {
  for (int c = 0; c < N; ++c) {
    FillImage(&(*image)[c], [&](int x, int y) { return f(x, y, c); });
  }
}

/// A frame of the size with all images: a wall at depth 5 facing the camera, albedo 0.5, one
/// surface id, no motion, no light.
inline Frame MakeWall(int width, int height, int64_t index = 0) {
  Frame f;
  f.width = width;
  f.height = height;
  f.index = index;
  f.focal_pixels = 1.2f * static_cast<float>(width);
  for (const SignalKind kind : {SignalKind::kDirectDiffuse, SignalKind::kIndirectDiffuse,
                                SignalKind::kDirectSpecular, SignalKind::kIndirectSpecular}) {
    f.signals.push_back({kind, Image3(width, height), Image1()});
  }
  f.guides.depth = Image1(width, height);
  f.guides.depth.Fill(5.0f);
  f.guides.normal = Image3(width, height);
  f.guides.normal[2].Fill(1.0f);
  f.guides.albedo = Image3(width, height);
  f.guides.specular_albedo = Image3(width, height);
  for (int c = 0; c < 3; ++c) {
    f.guides.albedo[c].Fill(0.5f);
    f.guides.specular_albedo[c].Fill(0.04f);
  }
  f.guides.motion = Image2(width, height);
  f.guides.id = Plane<uint32_t>(width, height);
  f.guides.id.Fill(1);
  f.guides.roughness = Image1(width, height);
  f.guides.roughness.Fill(0.5f);
  f.emission = Image3(width, height);
  f.background = Image3(width, height);
  return f;
}

inline Image3& Light(Frame* f, SignalKind kind) {
  for (Signal& s : f->signals) {
    if (s.kind == kind) {
      return s.radiance;
    }
  }
  return f->signals.front().radiance;
}

/// A wall at one sample per pixel: a third of the samples is lit, the others are `dark`.
inline Frame MakeSparseLight(int width, int height, int64_t index, float dark, float lit = 3.0f) {
  Frame f = MakeWall(width, height, index);
  for (const SignalKind kind : {SignalKind::kDirectDiffuse, SignalKind::kIndirectDiffuse}) {
    FillImage<3>(&Light(&f, kind), [&](int x, int y, int) {
      const auto pixel = static_cast<uint32_t>(y * width + x);
      const uint32_t draw = 2 * static_cast<uint32_t>(index) + static_cast<uint32_t>(kind);
      return Random(draw, pixel, 17) < 1.0f / 3.0f ? lit : dark;
    });
  }
  return f;
}

inline double MeanOf(const Image3& image) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        sum += static_cast<double>(image[c](x, y));
      }
    }
  }
  return sum / (3.0 * image.width() * image.height());
}

/// A busy frame: tilted planes in three depths, two of them mirrors and one of these with a
/// curved normal, background, random light, motion of the whole picture by (1.25, -0.5) per frame,
/// some missing and some broken samples; jittered, so that all presets with antialiasing in time
/// run it.
inline Frame MakeBusyFrame(int width, int height, int64_t index, uint32_t seed = 7) {
  Frame f = MakeWall(width, height, index);
  f.jitter_x = index % 2 == 0 ? 0.25f : -0.25f;
  f.jitter_y = 0.125f;
  const uint32_t s = seed * 1000 + static_cast<uint32_t>(index);
  const auto surface = [&](int x, int y) {
    return (x + static_cast<int>(index)) * 5 / (width + 8) + y * 2 / height;
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int which = surface(x, y) % 5;
      const float fx = static_cast<float>(x) + 0.75f * static_cast<float>(index);
      const float fy = static_cast<float>(y);
      const float z =
          which == 4
              ? std::numeric_limits<float>::infinity()
              : 1.0f / (0.1f + 0.15f * static_cast<float>(which) + 0.0004f * fx + 0.0007f * fy);
      f.guides.depth(x, y) = z;
      const float bend = which == 2 ? 0.03f * fx : 0.2f * static_cast<float>(which);
      f.guides.normal[0](x, y) = which == 4 ? 0.0f : std::sin(bend);
      f.guides.normal[1](x, y) = 0.0f;
      f.guides.normal[2](x, y) = which == 4 ? 0.0f : std::cos(bend);
      f.guides.roughness(x, y) = which == 1 || which == 2 ? 0.02f : 0.5f;
      f.guides.id(x, y) = which == 4 ? 0u : static_cast<uint32_t>(which + 1);
      f.guides.motion[0](x, y) = 1.25f + 0.01f * fy;
      f.guides.motion[1](x, y) = -0.5f;
      for (int c = 0; c < 3; ++c) {
        f.guides.albedo[c](x, y) = which == 3 ? 0.0f
                                              : 0.3f + 0.2f * Random(static_cast<uint32_t>(x / 4),
                                                                     static_cast<uint32_t>(y / 4),
                                                                     static_cast<uint32_t>(c));
        f.background[c](x, y) = which == 4 ? 0.7f : 0.0f;
      }
    }
  }
  uint32_t k = 0;
  for (Signal& signal : f.signals) {
    ++k;
    FillImage<3>(&signal.radiance, [&](int x, int y, int c) {
      const float u =
          Random(s + k * 77, static_cast<uint32_t>(y * width + x), static_cast<uint32_t>(c) / 3);
      const float tint = 0.5f + 0.25f * static_cast<float>(c);
      return surface(x, y) % 5 == 4 ? 0.0f
                                    : tint * (u > 0.6f ? 4.0f * u * u : 0.0f) *
                                          (0.5f + 0.02f * static_cast<float>(y % 17));
    });
  }
  f.samples = Image1(width, height);
  FillImage(&f.samples, [&](int x, int y) {
    return Random(s, static_cast<uint32_t>(y * width + x), 99) < 0.03f ? 0.0f : 1.0f;
  });
  const auto poke = [&](int x, int y, float value) {
    if (x < width && y < height) {
      f.signals[static_cast<size_t>((x + y) % 4)].radiance[(x + y) % 3](x, y) = value;
    }
  };
  poke(3, 2, std::numeric_limits<float>::quiet_NaN());
  poke(10, 7, std::numeric_limits<float>::infinity());
  poke(17, 11, -1.0f);
  return f;
}

/// Whether two pictures are of one size and equal, signs of zeros and kinds of NaN included.
template <typename Basis>
bool SameBits(const Planes<float, 3, Basis>& a, const Planes<float, 3, Basis>& b) {
  if (a.width() != b.width() || a.height() != b.height()) {
    return false;
  }
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < a.height(); ++y) {
      if (std::memcmp(a[c].Row(y), b[c].Row(y), static_cast<size_t>(a.width()) * sizeof(float)) !=
          0) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace stillray::test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of tests with mirrors.
#pragma once

#include <cstdint>
#include <utility>

#include "denoise/stage_parity.h"
#include "denoise/stage_test.h"
#include "denoise/test_frames.h"
#include "gpu/device.h"

namespace stillray::test {

/// Of pictures whose second moments the host and the device have rescaled each by itself. The
/// variance is the moment less the square of the mean, a small difference of large numbers: moments
/// that differ by one unit in the last place give pictures 4e-4 apart in the third frame, with 4 %
/// outliers; moments that are not rescaled, 2e-3 in the first, with 28 %. GPUs, which fuse products
/// and sums, give pictures up to 2.8e-3 apart, by 0.2 % of the pixels (an H200).
inline Tolerance RescaledMoments(const gpu::Device& device) {
  return {device.context().is_software ? 1e-3 : 4e-3, 0.1};
}

/// Squares of pixels with ids of their own.
inline Plane<uint32_t> Ids(int width, int height, uint32_t first, int side) {
  Plane<uint32_t> ids(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      ids(x, y) = first + static_cast<uint32_t>(x / side + y / side);
    }
  }
  return ids;
}

/// Images in one half of the picture that move to the right. \param first  id
inline VirtualGuides MakeSeen(int width, int height, int index, uint32_t first) {
  VirtualGuides v;
  v.depth = MakePlane(width, height, [&](int x, int y) {
    return y < height / 2 ? 0.0f : (x + index) % 16 < 8 ? 20.0f : 30.0f;
  });
  v.normal = Image3(width, height);
  v.normal[1].Fill(1.0f);
  v.albedo = MakeImage(width, height, [](int x, int y, int c) {
    return 0.2f + 0.1f * static_cast<float>((x / 3 + y / 3 + c) % 5);
  });
  v.motion = Image2(width, height);
  v.motion[0].Fill(-0.5f);
  v.id = Ids(width, height, first, 8);
  return v;
}

inline void SetMoments(bool second_moments, Frame* f) {
  for (Signal& signal : f->signals) {
    signal.second_moment =
        second_moments ? MakePlane(f->width, f->height,
                                   [&](int x, int y) {
                                     return 40 + RandomAt(x, y, static_cast<uint32_t>(signal.kind));
                                   })
                       : Image1();
  }
}

/// A frame of a sequence whose mirrors show what moves otherwise than they do; jittered.
inline Frame MakeMirrors(int width, int height, int index, bool second_moments) {
  Frame f = MakeBusyFrame(width, height, index);
  f.reflection = MakeSeen(width, height, index, 1000);
  f.guides.previous_normal = f.guides.normal;
  SetMoments(second_moments, &f);
  return f;
}

/// The same with transmitted light, which has images of its own.
inline Frame MakeGlass(int width, int height, int index, bool second_moments) {
  Frame f = MakeMirrors(width, height, index, second_moments);
  f.refraction = MakeSeen(width, height, 3 * index, 2000);
  f.refraction.motion[0].Fill(0.75f);
  f.guides.transmission_albedo = MakeImage(width, height, [](int x, int y, int c) {
    return 0.9f * RandomAt(x / 6, y / 6, 70 + static_cast<uint32_t>(c));
  });
  for (const SignalKind kind :
       {SignalKind::kDirectTransmission, SignalKind::kIndirectTransmission}) {
    Signal signal = f.signals[2];
    signal.kind = kind;
    for (Image1& plane : signal.radiance.channel) {
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          plane(x, y) *= 1.5f * RandomAt(x, y, static_cast<uint32_t>(kind) + 31);
        }
      }
    }
    f.signals.push_back(std::move(signal));
  }
  SetMoments(second_moments, &f);
  return f;
}

}  // namespace stillray::test

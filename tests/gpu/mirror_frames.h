// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of tests with mirrors.
#pragma once

#include <cstdint>

#include "denoise/stage_test.h"
#include "denoise/test_frames.h"

namespace stillray::test {

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

/// A frame of a sequence whose mirrors show what moves otherwise than they do; jittered.
inline Frame MakeMirrors(int width, int height, int index, bool second_moments) {
  Frame f = MakeBusyFrame(width, height, index);
  VirtualGuides& v = f.reflection;
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
  v.id = Ids(width, height, 1000, 8);
  f.guides.previous_normal = f.guides.normal;
  for (Signal& signal : f.signals) {
    if (second_moments) {
      signal.second_moment = MakePlane(width, height, [&](int x, int y) {
        return 40 + RandomAt(x, y, static_cast<uint32_t>(signal.kind));
      });
    } else {
      signal.second_moment = Image1();
    }
  }
  return f;
}

}  // namespace stillray::test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames with mostly unknown guides.
#pragma once

#include <functional>
#include <vector>

#include "denoise/test_frames.h"

namespace stillray::test {

/// Forgets everything of the pixels for which `known` is false.
inline void ForgetUnless(const std::function<bool(int, int)>& known, Frame* f) {
  for (int y = 0; y < f->height; ++y) {
    for (int x = 0; x < f->width; ++x) {
      f->samples(x, y) = known(x, y) ? 1.0f : 0.0f;
      if (known(x, y)) {
        continue;
      }
      f->guides.depth(x, y) = 0;
      f->guides.id(x, y) = 0;
      for (auto* image : {&f->guides.normal, &f->guides.albedo, &f->guides.specular_albedo,
                          &f->emission, &f->background}) {
        for (Image1& plane : image->channel) {
          plane(x, y) = 0;
        }
      }
      for (Image1& plane : f->guides.motion.channel) {
        plane(x, y) = 0;
      }
    }
  }
}

struct SparseCase {
  int width;
  int height;
  int one_of;    ///< pixels of which one is known
  float motion;  ///< of the whole picture, in pixels per frame
  bool sky;
  bool ids = true;
};

/// Frame `index` of a case: some frames move, some are still; the lamp is seen from frame 3 on.
inline Frame MakeSparseFrame(const SparseCase& c, int index) {
  Frame f = MakeBusyFrame(c.width, c.height, index);
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      const bool still = index % 5 >= 3 || c.motion == 0;
      f.guides.motion[0](x, y) = still ? 0.0f : c.motion * (1 + 0.01f * static_cast<float>(y));
      f.guides.motion[1](x, y) = still ? 0.0f : -0.4f * c.motion;
      if (!c.sky && !(f.guides.depth(x, y) < 1e30f)) {
        f.guides.depth(x, y) = 4;
        f.guides.id(x, y) = 9;
        f.guides.normal[1](x, y) = 1;
        for (Image1& plane : f.background.channel) {
          plane(x, y) = 0;
        }
      }
      if (index >= 3 && x > c.width / 2 && y < c.height / 2 && f.guides.depth(x, y) < 1e30f) {
        f.emission[1](x, y) = 3 + static_cast<float>(x);
      }
    }
  }
  ForgetUnless(
      [&](int x, int y) {
        return Random(static_cast<uint32_t>(y * c.width + x), static_cast<uint32_t>(index), 21) *
                   static_cast<float>(c.one_of) <
               1;
      },
      &f);
  if (!c.ids) {
    f.guides.id = Plane<uint32_t>();
  }
  return f;
}

inline const std::vector<SparseCase>& SparseCases() {
  static const std::vector<SparseCase> cases = {
      {1, 1, 2, 0, true},      {2, 7, 3, 0.3f, true},    {3, 3, 4, 0, false},
      {61, 45, 24, 0, true},   {61, 45, 24, 1.3f, true}, {100, 31, 128, 0, false},
      {81, 30, 10, 7, false},  {100, 50, 2, 0.6f, true}, {131, 40, 60, 0.4f, true, false},
      {64, 9, 50, -1.5f, true}};
  return cases;
}

}  // namespace stillray::test

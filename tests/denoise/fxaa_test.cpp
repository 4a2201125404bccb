// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// fxaa: the vector version against the scalar one.
#include <gtest/gtest.h>

#include <limits>

#include <hwy/targets.h>

#include "denoise/stages/fxaa.h"
#include "denoise/test_frames.h"

namespace stillray::fxaa_test {
namespace {

using test::FillImage;
using test::Random;

/// Slanted edges of several contrasts, some noise, and one broken pixel.
Image3 MakePicture(int width, int height, bool noisy) {
  Image3 picture(width, height);
  FillImage<3>(&picture, [&](int x, int y, int c) {
    const float edge = 5 * y > x + 20 ? 1.0f : (3 * x > 40 + y ? 0.7f : 0.1f);
    const float noise =
        noisy ? Random(static_cast<uint32_t>(x), static_cast<uint32_t>(y), 3) : 0.5f;
    return edge * (1 + 0.2f * static_cast<float>(c)) * (0.5f + noise);
  });
  if (noisy && width > 9 && height > 9) {
    picture[1](9, 9) = -2.0f;
    picture[0](8, 9) = std::numeric_limits<float>::infinity();
  }
  return picture;
}

TEST(Fxaa, VectorVersionHasTheBitsOfTheReferenceOnEveryTarget) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, {2, 3}, {5, 1}, {1, 9}, {61, 45}, {64, 20}, {131, 33}}) {
    Image1 length(width, height);
    FillImage(&length, [&](int x, int y) { return static_cast<float>((x / 7 + y / 5) % 7); });
    Image1 old(width, height);
    old.Fill(4.0f);
    for (const bool noisy : {false, true}) {
      const Image3 picture = MakePicture(width, height, noisy);
      for (const Image1* of :
           {static_cast<const Image1*>(nullptr), static_cast<const Image1*>(&length),
            static_cast<const Image1*>(&old)}) {
        Image3 expected(width, height);
        reference::Fxaa(picture, of, &expected);
        for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
          hwy::SetSupportedTargetsForTest(target);
          hwy::GetChosenTarget().Update(hwy::SupportedTargets());
          Image3 out(width, height);
          cpu::Fxaa(picture, of, &out);
          for (int c = 0; c < 3; ++c) {
            for (int y = 0; y < height; ++y) {
              for (int x = 0; x < width; ++x) {
                EXPECT_TRUE(
                    out[c](x, y) == expected[c](x, y) ||
                    (out[c](x, y) != out[c](x, y) && expected[c](x, y) != expected[c](x, y)))
                    << x << " " << y << ": " << out[c](x, y) << " for " << expected[c](x, y);
              }
            }
          }
        }
        hwy::SetSupportedTargetsForTest(0);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      }
    }
  }
}

}  // namespace
}  // namespace stillray::fxaa_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/texture.h"

#include <gtest/gtest.h>

namespace stillray::render::texture_test {
namespace {

// Two texels side by side, red 0 and 255.
Texture TwoTexels(Wrap wrap) {
  Texture texture;
  texture.width = 2;
  texture.height = 1;
  texture.texels = {0, 0, 0, 255, 255, 0, 0, 51};
  texture.wrap_u = texture.wrap_v = wrap;
  return texture;
}

float Red(const Texture& texture, float u) {
  return SampleTexture(texture, vec2(u, 0.5f), TexelEncoding::kLinear).x;
}

TEST(TextureTest, InterpolatesBetweenTexelCentres) {
  const Texture texture = TwoTexels(Wrap::kClamp);
  EXPECT_FLOAT_EQ(Red(texture, 0.25f), 0.0f);
  EXPECT_FLOAT_EQ(Red(texture, 0.5f), 0.5f);
  EXPECT_FLOAT_EQ(Red(texture, 0.625f), 0.75f);
  EXPECT_FLOAT_EQ(Red(texture, 0.75f), 1.0f);
  EXPECT_FLOAT_EQ(SampleTexture(texture, vec2(0.5f), TexelEncoding::kSrgb).w, 0.6f);
}

TEST(TextureTest, Wraps) {
  EXPECT_FLOAT_EQ(Red(TwoTexels(Wrap::kClamp), 1.0f), 1.0f);
  EXPECT_FLOAT_EQ(Red(TwoTexels(Wrap::kClamp), -3.0f), 0.0f);
  EXPECT_FLOAT_EQ(Red(TwoTexels(Wrap::kRepeat), 1.0f), 0.5f);
  EXPECT_FLOAT_EQ(Red(TwoTexels(Wrap::kRepeat), -0.25f), 1.0f);
  EXPECT_FLOAT_EQ(Red(TwoTexels(Wrap::kRepeat), 7.75f), 1.0f);
  EXPECT_FLOAT_EQ(Red(TwoTexels(Wrap::kMirror), 1.0f), 1.0f);
  EXPECT_FLOAT_EQ(Red(TwoTexels(Wrap::kMirror), 1.25f), 1.0f);
  EXPECT_FLOAT_EQ(Red(TwoTexels(Wrap::kMirror), 1.75f), 0.0f);
  EXPECT_FLOAT_EQ(Red(TwoTexels(Wrap::kMirror), -0.75f), 1.0f);
}

TEST(TextureTest, NearestTakesTheTexelItLiesIn) {
  Texture texture = TwoTexels(Wrap::kRepeat);
  texture.nearest = true;
  EXPECT_EQ(Red(texture, 0.49f), 0.0f);
  EXPECT_EQ(Red(texture, 0.51f), 1.0f);
  EXPECT_EQ(Red(texture, -0.01f), 1.0f);
}

TEST(TextureTest, SrgbIsDecodedBeforeInterpolation) {
  const Texture texture = TwoTexels(Wrap::kClamp);
  EXPECT_FLOAT_EQ(SampleTexture(texture, vec2(0.5f), TexelEncoding::kSrgb).x, 0.5f);
  Texture grey = texture;
  grey.texels = {188, 188, 188, 255, 188, 188, 188, 255};
  // ((188 / 255 + 0.055) / 1.055)^2.4
  EXPECT_NEAR(SampleTexture(grey, vec2(0.5f), TexelEncoding::kSrgb).y, 0.50289f, 1e-4f);
}

TEST(TextureTest, TransformIsApplied) {
  TextureRef ref;
  ref.transform = mat3(2.0f, 0.0f, 0.0f, 0.0f, 3.0f, 0.0f, 0.5f, -1.0f, 1.0f);
  EXPECT_EQ(TransformUv(ref, vec2(1.0f, 1.0f)), vec2(2.5f, 2.0f));
}

}  // namespace
}  // namespace stillray::render::texture_test

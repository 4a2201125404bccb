// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "post/motion_blur.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "post/pictures.h"

namespace stillray::post::motion_blur_test {
namespace {

using ::testing::HasSubstr;

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Image2 FlatMotion(int width, int height, float x, float y) {
  Image2 motion(width, height);
  motion[0].Fill(x);
  motion[1].Fill(y);
  return motion;
}

Image3 Blurred(float open, const Image2& motion, const Image1& depth, const Image3& colour) {
  Image3 out = colour;
  Shutter shutter;
  shutter.open = open;
  const Status status = MotionBlur(shutter, motion, depth, &out);
  EXPECT_TRUE(status.ok()) << status.message();
  return out;
}

/// A red square on green, and what it takes to move it.
struct Shot {
  Image3 colour = FlatColour(96, 64, 0.0f, 1.0f, 0.0f);
  Image2 motion = FlatMotion(96, 64, 0.0f, 0.0f);
  Image1 depth = Flat(96, 64, 5.0f);

  static constexpr int kLeft = 40, kRight = 60, kTop = 20, kBottom = 44;

  template <typename Change>
  void InSquare(const Change& change) {
    for (int y = kTop; y < kBottom; ++y) {
      for (int x = kLeft; x < kRight; ++x) {
        change(x, y);
      }
    }
  }
  Shot(float mx, float my, float square_depth) {
    InSquare([&](int x, int y) {
      colour[0](x, y) = 1.0f;
      colour[1](x, y) = 0.0f;
      motion[0](x, y) = mx;
      motion[1](x, y) = my;
      depth(x, y) = square_depth;
    });
  }
};

/// The part of [at - half, at + half] that lies within [low, high].
double BoxShare(double at, double half, double low, double high) {
  const double covered = std::fmin(at + half, high) - std::fmax(at - half, low);
  return std::fmax(covered, 0.0) / (2 * half);
}

TEST(MotionBlur, KeepsAConstantPicture) {
  const Image3 colour = FlatColour(70, 50, 0.25f, 3.0f, 1000.0f);
  Image2 motion(70, 50);
  motion[0] = Noise(70, 50, -30.0f, 30.0f, 1);
  motion[1] = Noise(70, 50, -20.0f, 20.0f, 2);
  const Image3 out = Blurred(1.0f, motion, Noise(70, 50, 1.0f, 9.0f, 3), colour);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 50; ++y) {
      for (int x = 0; x < 70; ++x) {
        ASSERT_NEAR(out[c](x, y) / colour[c](x, y), 1.0f, 1e-5f) << x << " " << y;
      }
    }
  }
}

TEST(MotionBlur, KeepsAStillPicture) {
  const Image3 colour = NoiseColour(70, 50, 4);
  const Image1 depth = Noise(70, 50, 1.0f, 9.0f, 3);
  EXPECT_TRUE(SameBits(Blurred(1.0f, FlatMotion(70, 50, 0.0f, 0.0f), depth, colour), colour));
  EXPECT_TRUE(SameBits(Blurred(0.0f, FlatMotion(70, 50, 30.0f, 9.0f), depth, colour), colour));
}

TEST(MotionBlur, AMovingSquareIsTheBoxBlur) {
  for (const float path : {17.0f, 8.5f, 70.0f}) {  // up to more than two tiles to both sides
    const double half = static_cast<double>(path) / 2;
    const Shot across(path, 0.0f, 2.0f);
    const Image3 out = Blurred(1.0f, across.motion, across.depth, across.colour);
    const Shot fast(2.0f * path, 0.0f, 2.0f);
    if (path < 50.0f) {
      EXPECT_TRUE(SameBits(Blurred(0.5f, fast.motion, fast.depth, fast.colour), out));
    }
    for (int x = 2; x < 94; ++x) {
      const double share = BoxShare(x + 0.5, half, Shot::kLeft, Shot::kRight);
      EXPECT_NEAR(out[0](x, 32), share, 1e-5) << x << " " << path;
      EXPECT_NEAR(out[1](x, 32), 1.0 - share, 1e-5) << x << " " << path;
    }
    // Nothing moves sideways.
    EXPECT_EQ(out[0](50, Shot::kTop - 1), 0.0f);
    EXPECT_GT(out[0](50, Shot::kTop), 0.2f);
    const Shot down(0.0f, -path, 2.0f);
    const Image3 vertical = Blurred(1.0f, down.motion, down.depth, down.colour);
    for (int y = 0; y < 64; ++y) {
      const double share = BoxShare(y + 0.5, half, Shot::kTop, Shot::kBottom);
      EXPECT_NEAR(vertical[0](50, y), share, 1e-5) << y << " " << path;
    }
  }
}

TEST(MotionBlur, ADiagonalMoveKeepsTheEnergy) {
  const Shot shot(12.0f, 9.0f, 2.0f);
  const Image3 out = Blurred(1.0f, shot.motion, shot.depth, shot.colour);
  EXPECT_NEAR(SumOf(out[0]) / SumOf(shot.colour[0]), 1.0, 0.02);
  EXPECT_GT(out[0](Shot::kRight + 2, Shot::kBottom + 1), 0.05f);
  EXPECT_EQ(out[0](Shot::kRight + 6, Shot::kTop - 4), 0.0f);
}

// A square that slides on the ground it touches.
TEST(MotionBlur, WhatMovesAtTheSameDepthIsInFront) {
  const Shot shot(17.0f, 0.0f, 5.0f);
  const Image3 out = Blurred(1.0f, shot.motion, shot.depth, shot.colour);
  for (int x = 10; x < 90; ++x) {
    EXPECT_NEAR(out[0](x, 32), BoxShare(x + 0.5, 8.5, Shot::kLeft, Shot::kRight), 0.1) << x;
  }
}

TEST(MotionBlur, AMovingBackgroundStaysOffAStillForeground) {
  Shot shot(0.0f, 0.0f, 2.0f);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (shot.depth(x, y) > 2.0f) {
        shot.motion[0](x, y) = 25.0f;
        shot.motion[1](x, y) = 4.0f;
      }
    }
  }
  const Image3 out = Blurred(1.0f, shot.motion, shot.depth, shot.colour);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      ASSERT_NEAR(out[0](x, y), shot.colour[0](x, y), 1e-6f) << x << " " << y;
      ASSERT_NEAR(out[1](x, y), shot.colour[1](x, y), 1e-6f) << x << " " << y;
    }
  }
}

TEST(MotionBlur, WhatMovesBehindStaysBehind) {
  const Shot shot(30.0f, 0.0f, 9.0f);  // behind the wall that shows it
  const Image3 out = Blurred(1.0f, shot.motion, shot.depth, shot.colour);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (shot.depth(x, y) < 9.0f) {
        ASSERT_EQ(out[1](x, y), 1.0f) << x << " " << y;
      }
    }
  }
}

TEST(MotionBlur, MotionThatLeadsNowhereCountsAsStill) {
  const Image3 colour = NoiseColour(60, 40, 9);
  const Image1 depth = Noise(60, 40, 1.0f, 4.0f, 10);
  for (const float motion : {kNan, kInfinite, 120.0f, -3e38f}) {
    const Image3 out = Blurred(1.0f, FlatMotion(60, 40, motion, 1.0f), depth, colour);
    EXPECT_TRUE(SameBits(out, colour)) << motion;
  }
}

TEST(MotionBlur, UnknownDepthIsInfinitelyFar) {
  Shot shot(17.0f, 3.0f, 2.0f);
  shot.depth.Fill(kInfinite);
  shot.InSquare([&](int x, int y) { shot.depth(x, y) = 2.0f; });
  const Image3 sky = Blurred(1.0f, shot.motion, shot.depth, shot.colour);
  const float values[] = {kNan, 0.0f, -3.0f, -kInfinite};
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (shot.depth(x, y) > 2.0f) {
        shot.depth(x, y) = values[(x + y) % 4];
      }
    }
  }
  EXPECT_TRUE(SameBits(Blurred(1.0f, shot.motion, shot.depth, shot.colour), sky));
  EXPECT_TRUE(std::isfinite(SumOf(sky[0])));
}

// Uniform motion of one plane is the box filter along it, at every pixel.
TEST(MotionBlur, APanIsTheBoxFilterInDoublePrecision) {
  const Image3 colour = NoiseColour(80, 30, 6);
  const Image3 out = Blurred(0.5f, FlatMotion(80, 30, 13.0f, 0.0f), Flat(80, 30, 3.0f), colour);
  constexpr double kHalf = 13.0 * 0.5 / 2;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 80; ++x) {
      double sum = 0;
      for (int t = -5; t <= 5; ++t) {
        const double weight = std::fmin(std::fmax(kHalf + 0.5 - std::abs(t), 0.0), 1.0);
        sum += weight * static_cast<double>(colour[0](std::min(std::max(x + t, 0), 79), y));
      }
      ASSERT_NEAR(out[0](x, y), sum / (2 * kHalf), 1e-5) << x << " " << y;
    }
  }
}

TEST(MotionBlur, LimitsTheLength) {
  const Image3 colour = NoiseColour(200, 20, 6);
  const Image1 depth = Flat(200, 20, 3.0f);
  Image3 out = colour;
  Shutter shutter;
  shutter.open = 1.0f;
  shutter.max_radius = 4.0f;
  ASSERT_TRUE(MotionBlur(shutter, FlatMotion(200, 20, 150.0f, 0.0f), depth, &out).ok());
  EXPECT_TRUE(SameBits(out, Blurred(1.0f, FlatMotion(200, 20, 8.0f, 0.0f), depth, colour)));
}

TEST(MotionBlur, TheNumberOfThreadsChangesNoBit) {
  const Image3 colour = NoiseColour(150, 90, 1);
  const Image1 depth = Noise(150, 90, 0.8f, 9.0f, 2);
  Image2 motion(150, 90);
  motion[0] = Noise(150, 90, -30.0f, 30.0f, 1);
  motion[1] = Noise(150, 90, -20.0f, 20.0f, 2);
  Image3 one;
  {
    const Threads limit(1);
    one = Blurred(1.0f, motion, depth, colour);
  }
  const Threads limit(4);
  EXPECT_TRUE(SameBits(Blurred(1.0f, motion, depth, colour), one));
}

TEST(MotionBlur, RejectsBadSettingsAndSizes) {
  Image3 colour = NoiseColour(8, 8, 1);
  const Image2 motion = FlatMotion(8, 8, 1.0f, 1.0f);
  const Image1 depth = Flat(8, 8, 1.0f);
  Shutter shutter;
  for (const float open : {-0.1f, 1.1f, kNan}) {
    shutter.open = open;
    const Status status = MotionBlur(shutter, motion, depth, &colour);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_THAT(status.message(), HasSubstr("expected 0 to 1"));
  }
  EXPECT_THAT(MotionBlur({0.5f, 0.0f}, motion, depth, &colour).message(), HasSubstr("max_radius"));
  EXPECT_THAT(MotionBlur({}, FlatMotion(8, 9, 1, 1), depth, &colour).message(),
              HasSubstr("motion has 8 x 9 pixels"));
  EXPECT_THAT(MotionBlur({}, motion, Flat(4, 8, 1.0f), &colour).message(),
              HasSubstr("depth has 4 x 8 pixels"));
}

}  // namespace
}  // namespace stillray::post::motion_blur_test

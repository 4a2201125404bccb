// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Surfaces that turn: their history is found by the normal that they had in the last frame.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "denoise/make_denoiser.h"
#include "denoise/next_motion.h"
#include "denoise/stages/reproject.h"
#include "denoise/stages/select_guides.h"
#include "denoise/test_frames.h"
#include "stage_test.h"

namespace stillray::previous_normal_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kTurn = 0.62831853f;  // 36 degrees
constexpr int kWidth = 40;
constexpr int kHeight = 24;
const ReprojectParameters kParameters = {0.05f, std::cos(0.43633f), 1, 1, 0};

using FindTapsVersion = decltype(&cpu::FindTaps);
constexpr FindTapsVersion kVersions[] = {&reference::FindTaps, &cpu::FindTaps};

Image3 Normals(float angle) {
  return test::MakeImage(kWidth, kHeight, [&](int, int, int c) {
    return c == 0 ? std::sin(angle) : c == 2 ? std::cos(angle) : 0.0f;
  });
}

GuidePlanes WallAt(float angle) {
  GuidePlanes guides(kWidth, kHeight, 4);
  const Image3 normals = Normals(angle);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      guides.inverse_depth(x, y) = 0.25f;
      guides.depth(x, y) = 4;
      guides.id(x, y) = 1;
      for (int c = 0; c < 3; ++c) {
        guides.normal[c](x, y) = normals[c](x, y);
      }
    }
  }
  return guides;
}

TEST(PreviousNormal, Formula) {
  const vec3 now(0, 0, 1);
  EXPECT_EQ(HistoryNormal(now, vec3(0.0f)), now);
  EXPECT_EQ(HistoryNormal(now, vec3(0, 2, 0)), vec3(0, 1, 0));
  EXPECT_EQ(HistoryNormal(now, vec3(kNan, 0, 0)), now);
  EXPECT_EQ(HistoryNormal(now, vec3(0, std::numeric_limits<float>::infinity(), 0)), now);
  const vec3 unit = HistoryNormal(now, vec3(3, 0, -4));
  EXPECT_FLOAT_EQ(unit.x, 0.6f);
  EXPECT_FLOAT_EQ(unit.z, -0.8f);
}

TEST(PreviousNormal, FindsTheHistoryOfATurnedSurface) {
  const GuidePlanes before = WallAt(0);
  const GuidePlanes now = WallAt(kTurn);
  const Image2 still(kWidth, kHeight);
  Image3 previous = Normals(0);
  for (int y = 0; y < kHeight; ++y) {
    for (int c = 0; c < 3; ++c) {
      for (int x = 0; x < 10; ++x) {
        previous[c](x, y) = x < 5 ? 0.0f : kNan;  // as now
      }
      for (int x = 10; x < kWidth; ++x) {
        previous[c](x, y) *= 3;  // of any length
      }
    }
  }
  for (const FindTapsVersion find_taps : kVersions) {
    ReprojectionTaps taps(kWidth, kHeight);
    find_taps(now, before, still, kParameters, &taps);
    EXPECT_FALSE(taps.HasHistory(20, 12));
    taps.previous_normal = &previous;
    find_taps(now, before, still, kParameters, &taps);
    for (int x = 0; x < kWidth; ++x) {
      // In the columns next to them the search reaches no further: taps are tested by their own.
      EXPECT_EQ(taps.HasHistory(x, 12), x >= 10) << x;
    }
  }
}

TEST(PreviousNormal, VersionsAgree) {
  test::ForSizesAndTargets([](int width, int height) {
    GuidePlanes guides[2] = {{width, height, 4}, {width, height, 4}};
    for (uint32_t i = 0; i < 2; ++i) {
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const float angle = 0.3f * test::RandomAt(x, y, 10 + i);
          guides[i].inverse_depth(x, y) = test::RandomAt(x, y, 20 + i) < 0.1f ? 0.0f : 0.25f;
          guides[i].normal[0](x, y) = std::sin(angle);
          guides[i].normal[2](x, y) = std::cos(angle);
        }
      }
    }
    Image3 previous = test::RandomImage(width, height, 30);
    for (int x = 0; x < width; x += 3) {
      previous[0](x, 0) = x % 2 == 0 ? kNan : 0.0f;
      previous[1](x, 0) = previous[2](x, 0) = 0;
    }
    Image2 motion(width, height);
    motion[0] = test::RandomPlane(width, height, 40, 1.5f);
    ReprojectionTaps expected(width, height);
    ReprojectionTaps got(width, height);
    expected.previous_normal = got.previous_normal = &previous;
    reference::FindTaps(guides[1], guides[0], motion, kParameters, &expected);
    cpu::FindTaps(guides[1], guides[0], motion, kParameters, &got);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        ASSERT_EQ(got.HasHistory(x, y), expected.HasHistory(x, y)) << x << ", " << y;
      }
    }
  });
}

TEST(PreviousNormal, IsOfTheSurfaceAlone) {
  // A pixel that shows an image has none; one that shows its surface has that of the surface.
  Guides surface;
  surface.depth = Image1(2, 1);
  surface.depth.Fill(2);
  surface.normal = Image3(2, 1);
  surface.normal[2].Fill(1);
  VirtualGuides image;
  image.depth = Image1(2, 1);
  image.depth(1, 0) = 5;
  const Image1 smooth;
  const Image3 white;
  Image3 previous(2, 1);
  previous[1].Fill(1);
  for (const auto& select : {&reference::SelectGuides, &cpu::SelectGuides}) {
    Guides out;
    Image3 albedo;
    select({&surface, &image, &smooth, &white, &previous}, {0.2f, 1.0f, 0.0f}, &out, &albedo);
    EXPECT_EQ(out.previous_normal[1](0, 0), 1);
    EXPECT_EQ(out.previous_normal[1](1, 0), 0);
    select({&surface, &image, &smooth, &white}, {0.2f, 1.0f, 0.0f}, &out, &albedo);
    EXPECT_TRUE(out.previous_normal.empty());
  }
}

TEST(PreviousNormal, OfFramesThatArePlayedBackwardIsTurnedForward) {
  // The next frame shows, a pixel to the right, what has turned about y by 36 degrees. Here it
  // shows the same face, and a face 10 degrees off.
  Frame now = test::MakeWall(kWidth, kHeight);
  now.guides.normal = Normals(0.2f);
  const float other = 0.2f - 0.17453293f;
  for (int c = 0; c < 3; ++c) {
    now.guides.normal[c](20, 5) = Normals(other)[c](0, 0);
  }
  Frame next = test::MakeWall(kWidth, kHeight, 1);
  next.guides.normal = Normals(0.2f + kTurn);
  Image2 motion(kWidth, kHeight);
  motion[0].Fill(1.2f);
  EXPECT_TRUE(MotionTowards(now, next, motion).normal.empty());
  next.guides.previous_normal = Normals(0.2f);
  for (int c = 0; c < 3; ++c) {
    next.guides.previous_normal[c](31, 7) = 0;                              // not known
    next.guides.previous_normal[c](31, 8) = -next.guides.normal[c](31, 8);  // any axis
  }
  FrameMotion moved = MotionTowards(now, next, motion);
  const auto expect = [&](int x, int y, float angle) {
    EXPECT_NEAR(moved.normal[0](x, y), std::sin(angle), 1e-6);
    EXPECT_NEAR(moved.normal[1](x, y), 0, 1e-6);
    EXPECT_NEAR(moved.normal[2](x, y), std::cos(angle), 1e-6);
  };
  expect(10, 5, 0.2f + kTurn);
  expect(20, 5, other + kTurn);
  for (const auto& [x, y] : {std::pair{30, 7}, {30, 8}, {kWidth - 1, 5}}) {
    EXPECT_EQ(moved.normal[2](x, y), 0) << x << ", " << y;
  }
  SwapMotion(&moved, &now);
  EXPECT_NEAR(now.guides.previous_normal[0](10, 5), std::sin(0.2f + kTurn), 1e-6);
  EXPECT_TRUE(moved.normal.empty());
}

/// Frame `i` of a wall that turns by 36 degrees.
Frame TurningFrame(int i, bool given) {
  Frame f = test::MakeWall(kWidth, kHeight, i);
  f.guides.normal = Normals(kTurn * static_cast<float>(i));
  if (given) {
    f.guides.previous_normal = Normals(kTurn * static_cast<float>(i - 1));
  }
  return f;
}

TEST(PreviousNormal, AHistoryGrowsWhileItsSurfaceTurns) {
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    for (const bool given : {false, true}) {
      Denoiser denoiser = std::move(Denoiser::Create(Settings(), backend).value());
      ASSERT_TRUE(denoiser.SetOutputs({"history.direct", "history.specular"}).ok());
      DenoisedFrame out;
      for (int i = 0; i < 5; ++i) {
        ASSERT_TRUE(denoiser.Denoise(TurningFrame(i, given), &out).ok());
      }
      for (const NamedImage& image : out.images) {
        EXPECT_NEAR(image.channels[0](20, 12), given ? 5 : 1, 1e-3) << image.name;
      }
    }
  }
}

TEST(PreviousNormal, OfTheSizeOfTheFrame) {
  Denoiser denoiser = test::MakeDenoiser(Settings());
  Frame f = TurningFrame(0, true);
  f.guides.previous_normal = Image3(3, 3);
  DenoisedFrame out;
  const Status status = denoiser.Denoise(f, &out);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("previous_normal"), std::string::npos) << status.message();
}

}  // namespace
}  // namespace stillray::previous_normal_test

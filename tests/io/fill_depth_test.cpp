// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/fill_depth.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace stillray::io::fill_depth_test {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

/// A wall that the camera does not face, with light on it. Inverse depth and motion are linear.
Frame Wall(int width, int height) {
  Frame frame;
  frame.width = width;
  frame.height = height;
  Guides& g = frame.guides;
  g.depth = Image1(width, height);
  g.normal = Image3(width, height);
  g.albedo = Image3(width, height);
  g.specular_albedo = Image3(width, height);
  g.motion = Image2(width, height);
  g.id = Plane<uint32_t>(width, height);
  frame.signals.push_back({SignalKind::kDirectDiffuse, Image3(width, height), Image1()});
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      g.depth(x, y) = 1 / (0.25f + 0.01f * static_cast<float>(x));
      g.normal[0](x, y) = 0.6f;
      g.normal[2](x, y) = 0.8f;
      g.motion[0](x, y) = 0.5f * static_cast<float>(y);
      g.id(x, y) = 7;
      for (int c = 0; c < 3; ++c) {
        g.albedo[c](x, y) = 0.5f;
        g.specular_albedo[c](x, y) = 0.25f;
        frame.signals[0].radiance[c](x, y) = 1;
      }
    }
  }
  return frame;
}

/// The sample met nothing, and neither did any other with `none`.
void Hit(Frame* frame, int x, int y, bool none) {
  Guides& g = frame->guides;
  g.depth(x, y) = kInf;
  g.id(x, y) = 0;
  for (int c = 0; c < 3 && none; ++c) {
    g.normal[c](x, y) = 0;
    g.albedo[c](x, y) = 0;
    g.specular_albedo[c](x, y) = 0;
  }
  for (int c = 0; c < 2 && none; ++c) {
    g.motion[c](x, y) = 0;
  }
}

void SetLight(Frame* frame, int x, int y, float value) {
  for (int c = 0; c < 3; ++c) {
    frame->signals[0].radiance[c](x, y) = value;
  }
}

TEST(FindCoveredWithoutDepth, FramesWithADepthForAllLightHaveNone) {
  Frame frame = Wall(8, 8);
  EXPECT_TRUE(FindCoveredWithoutDepth(frame, {}).empty());
  Hit(&frame, 3, 3, true);
  SetLight(&frame, 3, 3, 0);  // black sky
  EXPECT_TRUE(FindCoveredWithoutDepth(frame, {}).empty());
}

TEST(FindCoveredWithoutDepth, SamplesThatPassAVolumeBelongToItsMean) {
  Frame frame = Wall(16, 9);
  for (int y = 3; y < 6; ++y) {
    for (int x = 0; x < 16; ++x) {
      Hit(&frame, x, y, true);
      SetLight(&frame, x, y, x == 4 && y == 4 ? 1.0f : 0.0f);
    }
  }
  frame.background = Image3(16, 9);
  frame.background[1](5, 4) = 1;  // the sky behind it
  const Plane<uint8_t> marked = FindCoveredWithoutDepth(frame, {});
  ASSERT_FALSE(marked.empty());
  for (int x = 0; x < 16; ++x) {
    EXPECT_EQ(marked(x, 4), x >= 2 && x <= 6 ? 1 : 0) << x;
    EXPECT_EQ(marked(x, 2), 0) << x;
  }
}

TEST(FindCoveredWithoutDepth, BlackAmongSurfacesIsThinSmoke) {
  Frame frame = Wall(16, 8);
  Hit(&frame, 12, 4, true);
  SetLight(&frame, 12, 4, 0);
  EXPECT_TRUE(FindCoveredWithoutDepth(frame, {}).empty()) << "a hole, without any volume";
  Hit(&frame, 2, 4, true);  // lit smoke far away
  const Plane<uint8_t> marked = FindCoveredWithoutDepth(frame, {});
  ASSERT_FALSE(marked.empty());
  EXPECT_EQ(marked(12, 4), 1);
  frame.background = Image3(16, 8);
  frame.background[2](12, 4) = 1;  // sky in the hole
  EXPECT_EQ(FindCoveredWithoutDepth(frame, {})(12, 4), 0);
}

TEST(FindCoveredWithoutDepth, HairIsNoVolume) {
  Frame frame = Wall(8, 8);
  Hit(&frame, 3, 3, false);  // one sample between the hairs, others met some
  Hit(&frame, 4, 3, true);
  SetLight(&frame, 4, 3, 0);
  const Plane<uint8_t> marked = FindCoveredWithoutDepth(frame, {});
  ASSERT_FALSE(marked.empty());
  EXPECT_EQ(marked(3, 3), 1);
  EXPECT_EQ(marked(4, 3), 0);
}

TEST(FindCoveredWithoutDepth, ATransparentFilmSaysWhatIsCovered) {
  Frame frame = Wall(8, 8);
  for (int x = 2; x < 6; ++x) {
    Hit(&frame, x, 3, true);
    SetLight(&frame, x, 3, 0);
  }
  Image1 alpha(8, 8);
  alpha.Fill(1);
  EXPECT_TRUE(FindCoveredWithoutDepth(frame, alpha).empty()) << "an opaque film covers the sky too";
  alpha(2, 3) = 0;
  alpha(3, 3) = 0.5f;
  const Plane<uint8_t> marked = FindCoveredWithoutDepth(frame, alpha);
  ASSERT_FALSE(marked.empty());
  EXPECT_EQ(marked(2, 3), 0);
  EXPECT_EQ(marked(3, 3), 1);
  EXPECT_EQ(marked(4, 3), 1);
}

TEST(FillDepth, LinearGuidesAreFoundAgain) {
  Frame frame = Wall(32, 16);
  const Frame wall = frame;
  Plane<uint8_t> marked(32, 16);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 32; ++x) {
      if ((x + y) % 2 == 1) {
        Hit(&frame, x, y, (x + y) % 4 == 1);
        marked(x, y) = 1;
      }
    }
  }
  FillDepth(marked, &frame.guides);
  for (int y = 2; y < 14; ++y) {
    for (int x = 2; x < 30; ++x) {
      // interpolation of four neighbours within the cells of 2x2 pixels errs by half a pixel
      EXPECT_NEAR(1 / frame.guides.depth(x, y), 1 / wall.guides.depth(x, y), 0.0051f);
      EXPECT_NEAR(frame.guides.motion[0](x, y), wall.guides.motion[0](x, y), 0.26f);
      EXPECT_NEAR(frame.guides.normal[0](x, y), 0.6f, 1e-6f);
      EXPECT_NEAR(frame.guides.normal[2](x, y), 0.8f, 1e-6f);
      EXPECT_NEAR(frame.guides.albedo[1](x, y), 0.5f, 1e-6f);
      EXPECT_NEAR(frame.guides.specular_albedo[1](x, y), 0.25f, 1e-6f);
      EXPECT_EQ(frame.guides.id(x, y), 7u);
      if (marked(x, y) == 0) {
        EXPECT_EQ(frame.guides.depth(x, y), wall.guides.depth(x, y));
        EXPECT_EQ(frame.guides.motion[0](x, y), wall.guides.motion[0](x, y));
      }
    }
  }
}

TEST(FillDepth, NothingButTheMarkedPixelsChangesAndTheirOwnGuidesStay) {
  Frame frame = Wall(9, 7);
  Hit(&frame, 4, 3, false);
  Hit(&frame, 1, 1, true);
  frame.guides.normal[0](4, 3) = -1;
  frame.guides.normal[2](4, 3) = 0;
  frame.guides.motion[0](4, 3) = 9;
  frame.guides.albedo[0](4, 3) = 0.125f;
  Plane<uint8_t> marked(9, 7);
  marked(4, 3) = 1;
  FillDepth(marked, &frame.guides);
  EXPECT_EQ(frame.guides.depth(1, 1), kInf);
  EXPECT_EQ(frame.guides.normal[0](1, 1), 0);
  EXPECT_NEAR(1 / frame.guides.depth(4, 3), 0.29f, 0.0051f);
  EXPECT_EQ(frame.guides.normal[0](4, 3), -1);
  EXPECT_EQ(frame.guides.motion[0](4, 3), 9);
  EXPECT_EQ(frame.guides.albedo[0](4, 3), 0.125f);
}

TEST(FillDepth, FarHolesTakeTheGuidesOfTheirSurroundings) {
  Frame frame = Wall(33, 17);
  Plane<uint8_t> marked(33, 17);
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 33; ++x) {
      frame.guides.depth(x, y) = 4;
      if (x > 0 || y > 0) {
        Hit(&frame, x, y, true);
        marked(x, y) = 1;
      }
    }
  }
  FillDepth(marked, &frame.guides);
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 33; ++x) {
      EXPECT_FLOAT_EQ(frame.guides.depth(x, y), 4);
      EXPECT_EQ(frame.guides.id(x, y), 7u);
    }
  }
}

TEST(FillDepth, WithoutAnyDepthThereIsAPlane) {
  Frame frame = Wall(5, 3);
  Plane<uint8_t> marked(5, 3);
  marked.Fill(1);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) {
      Hit(&frame, x, y, true);
    }
  }
  FillDepth(marked, &frame.guides);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) {
      EXPECT_EQ(frame.guides.depth(x, y), 1);
      EXPECT_EQ(frame.guides.normal[2](x, y), 1);
      EXPECT_EQ(frame.guides.motion[0](x, y), 0);
    }
  }
}

TEST(FillDepth, BadGuidesDoNotSpread) {
  Frame frame = Wall(9, 9);
  frame.guides.depth(3, 4) = std::nanf("");
  frame.guides.normal[1](5, 4) = std::nanf("");
  frame.guides.motion[0](4, 3) = std::nanf("");
  frame.guides.albedo[0](4, 5) = kInf;
  Hit(&frame, 4, 4, true);
  Plane<uint8_t> marked(9, 9);
  marked(4, 4) = 1;
  FillDepth(marked, &frame.guides);
  EXPECT_NEAR(1 / frame.guides.depth(4, 4), 0.29f, 0.02f);
  EXPECT_TRUE(std::isfinite(frame.guides.motion[0](4, 4)));
  EXPECT_TRUE(std::isfinite(frame.guides.albedo[0](4, 4)));
  EXPECT_NEAR(frame.guides.normal[0](4, 4), 0.6f, 1e-6f);
}

TEST(FillDepth, EmptyPlanesStayEmpty) {
  Frame frame = Wall(4, 4);
  Hit(&frame, 2, 2, false);
  frame.guides.motion = Image2();
  frame.guides.id = Plane<uint32_t>();
  Plane<uint8_t> marked(4, 4);
  marked(2, 2) = 1;
  FillDepth(marked, &frame.guides);
  EXPECT_TRUE(frame.guides.motion.empty());
  EXPECT_TRUE(frame.guides.id.empty());
  EXPECT_TRUE(std::isfinite(frame.guides.depth(2, 2)));
}

TEST(TakeBackground, ItsNoiseBehindAVolumeIsFiltered) {
  Image3 background(4, 1);
  Image3 volume(4, 1);
  Image3 normal(4, 1);
  Plane<uint8_t> without_depth(4, 1);
  for (int x = 0; x < 4; ++x) {
    without_depth(x, 0) = x > 0 ? 1 : 0;
    normal[1](x, 0) = x >= 2 ? 0.5f : 0.0f;
    for (int c = 0; c < 3; ++c) {
      background[c](x, 0) = 2;
    }
  }
  volume[0](2, 0) = 0.25f;
  const Image3 taken = TakeBackground(without_depth, volume, normal, &background);
  for (int x = 0; x < 4; ++x) {
    const bool is_taken = x == 1 || x == 2;  // the last one shows hair
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(background[c](x, 0), is_taken ? 0.0f : 2.0f) << x;
      EXPECT_EQ(taken[c](x, 0), is_taken ? 2.0f : 0.0f) << x;
    }
  }
}

TEST(DivideByHits, TheNoiseOfTheFractionLeavesTheAlbedo) {
  Image3 volume(4, 1);
  Image3 normal(4, 1);
  Image3 albedo(4, 1);
  const float fraction[4] = {0.25f, 0.5f, 1, 0.5f};
  for (int x = 0; x < 4; ++x) {
    volume[2](x, 0) = x < 3 ? 0.1f : 0.0f;  // the last one shows no volume
    normal[1](x, 0) = -fraction[x];
    for (int c = 0; c < 3; ++c) {
      albedo[c](x, 0) = (c == 0 ? 0.6f : c == 1 ? 1.0f : 3.0f) * fraction[x];
    }
  }
  DivideByHits(volume, normal, &albedo);
  for (int x = 0; x < 3; ++x) {
    EXPECT_FLOAT_EQ(albedo[0](x, 0), 0.6f) << x;
    EXPECT_FLOAT_EQ(albedo[1](x, 0), 1) << x;
  }
  EXPECT_FLOAT_EQ(albedo[2](0, 0), 1) << "an albedo is at most 1 ...";
  EXPECT_FLOAT_EQ(albedo[2](1, 0), 1.5f) << "... unless it was larger";
  EXPECT_EQ(albedo[0](3, 0), 0.3f);
}

}  // namespace
}  // namespace stillray::io::fill_depth_test

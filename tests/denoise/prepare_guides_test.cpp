// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/prepare_guides.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "stage_test.h"

namespace stillray::prepare_guides_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kBorder = 4;

using Version = decltype(&cpu::PrepareGuides);
constexpr Version kVersions[] = {&reference::PrepareGuides, &cpu::PrepareGuides};

/// A plane whose inverse depth is 0.5 + slope_x x + slope_y y, seen along its normal.
struct Scene {
  Image1 depth;
  Image3 normal;
  Plane<uint32_t> id;

  Scene(int width, int height, float slope_x, float slope_y)
      : depth(test::MakePlane(width, height,
                              [&](int x, int y) {
                                return 1 / (0.5f + slope_x * static_cast<float>(x) +
                                            slope_y * static_cast<float>(y));
                              })),
        normal(width, height),
        id(width, height) {
    normal[2].Fill(1);
    id.Fill(1);
  }
  PrepareGuidesInput Input() const { return {&depth, &normal, &id}; }
};

TEST(PrepareGuides, SlopeOfAPlaneIsConstantUpToTheEdges) {
  const Scene scene(19, 6, 0.01f, -0.02f);
  for (const Version prepare : kVersions) {
    GuidePlanes out(19, 6, kBorder);
    EXPECT_EQ(prepare(scene.Input(), &out), 0);
    for (int y = 0; y < 6; ++y) {
      for (int x = 0; x < 19; ++x) {
        EXPECT_NEAR(out.inverse_depth(x, y), 0.5 + 0.01 * x - 0.02 * y, 1e-6);
        EXPECT_NEAR(out.gradient[0](x, y), 0.01f, 1e-6f) << x << " " << y;
        EXPECT_NEAR(out.gradient[1](x, y), -0.02f, 1e-6f) << x << " " << y;
      }
    }
  }
}

TEST(PrepareGuides, SlopeDoesNotCrossEdges) {
  Scene scene(20, 4, 0.01f, 0);
  for (int y = 0; y < 4; ++y) {
    for (int x = 7; x < 20; ++x) {
      scene.depth(x, y) *= 3;
      scene.id(x, y) = 2;  // another surface from column 7 on
    }
    for (int x = 13; x < 20; ++x) {
      scene.depth(x, y) *= 3;
      scene.normal[0](x, y) = 1;  // a fold of 45 degrees from column 13 on
    }
  }
  for (const Version prepare : kVersions) {
    GuidePlanes out(20, 4, kBorder);
    prepare(scene.Input(), &out);
    for (int x = 0; x < 20; ++x) {
      const float slope = x < 7 ? 0.01f : x < 13 ? 0.01f / 3 : 0.01f / 9;
      EXPECT_NEAR(out.gradient[0](x, 2), slope, 1e-6f) << x;
    }
  }
}

TEST(PrepareGuides, NormalsHaveUnitLength) {
  Scene scene(9, 3, 0, 0);
  scene.normal[0](4, 1) = 3;
  scene.normal[2](4, 1) = 4;
  for (const Version prepare : kVersions) {
    GuidePlanes out(9, 3, kBorder);
    prepare(scene.Input(), &out);
    EXPECT_NEAR(out.normal[0](4, 1), 0.6f, 1e-6f);
    EXPECT_NEAR(out.normal[2](4, 1), 0.8f, 1e-6f);
  }
}

TEST(PrepareGuides, NoSurfaceIsZero) {
  Scene scene(9, 3, 0.01f, 0);
  scene.depth(0, 1) = kInfinity;  // sky: no surface, but a usable guide
  scene.depth(1, 1) = 0;
  scene.depth(2, 1) = -1;
  scene.depth(3, 1) = kNan;
  scene.normal[1](4, 1) = kNan;
  scene.normal[2](5, 1) = 0;  // no normal: no surface
  for (const Version prepare : kVersions) {
    GuidePlanes out(9, 3, kBorder);
    EXPECT_EQ(prepare(scene.Input(), &out), 4);
    for (int x = 0; x < 6; ++x) {
      EXPECT_EQ(out.inverse_depth(x, 1), 0) << x;
      EXPECT_EQ(out.depth(x, 1), 0) << x;
      EXPECT_EQ(out.id(x, 1), 0u) << x;
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(out.normal[c](x, 1), 0) << x;
      }
      EXPECT_NEAR(out.gradient[1](x, 0), 0, 1e-6f) << x;  // the neighbour below does not count
    }
    EXPECT_EQ(out.id(6, 1), 1u);
  }
}

// A ball of 40 pixels seen from far away, beside a wall: the normal turns by 1/40 per pixel and
// axis at its centre, and not at all on the wall, up to the ball's edge.
TEST(PrepareGuides, BallsTurnAndWallsDoNot) {
  constexpr int kSize = 101;
  constexpr float kRadius = 40;
  Image1 depth(kSize, kSize);
  Image3 normal(kSize, kSize);
  depth.Fill(1000);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const float nx = static_cast<float>(x - 50) / kRadius;
      const float ny = static_cast<float>(y - 50) / kRadius;
      const float rest = 1 - nx * nx - ny * ny;
      normal[0](x, y) = rest > 0 ? nx : 0.0f;
      normal[1](x, y) = rest > 0 ? ny : 0.0f;
      normal[2](x, y) = rest > 0 ? std::sqrt(rest) : -1.0f;
    }
  }
  for (const Version prepare : kVersions) {
    GuidePlanes out(kSize, kSize, kBorder);
    out.turn2 = Image1(kSize, kSize);
    prepare({&depth, &normal, nullptr}, &out);
    EXPECT_NEAR(out.turn2(50, 50), 2 / (kRadius * kRadius), 1e-5);
    EXPECT_GT(out.turn2(80, 50), out.turn2(50, 50));
    for (int y = 1; y < kSize - 1; ++y) {
      for (int x = 1; x < 12; ++x) {
        if (normal[2](x, y) < 0 && normal[2](x + 1, y) < 0) {
          ASSERT_NEAR(out.turn2(x, y), 0, 1e-6) << x << " " << y;
        }
      }
    }
  }
}

// Slopes and turns are those of the rounded normals.
TEST(PrepareGuides, PackedNormalsAreTheRoundedOnes) {
  test::ForSizesAndTargets([](int width, int height) {
    Scene scene(width, height, 0.003f, -0.002f);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) {
          scene.normal[c](x, y) = 2 * test::RandomAt(x / 3, y / 2, static_cast<uint32_t>(c)) - 1;
        }
        scene.depth(x, y) = test::RandomAt(x, y, 3) < 0.1f ? kInfinity : scene.depth(x, y);
      }
    }
    GuidePlanes plain(width, height, kBorder);
    reference::PrepareGuides(scene.Input(), &plain);
    for (const Version prepare : kVersions) {
      GuidePlanes out(width, height, kBorder, true);
      out.turn2 = Image1(width, height);
      prepare(scene.Input(), &out);
      EXPECT_TRUE(out.normal.empty());
      EXPECT_LT(out.bytes(), plain.bytes());
      test::ExpectNear(out.gradient, plain.gradient, 1e-5, 1e-6);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const vec3 n = NormalAt(plain, x, y);
          EXPECT_NEAR(glm::distance(NormalAt(out, x, y), n), 0, 6.6e-5f);
          EXPECT_EQ(out.packed_normal(x, y) == 0, n == vec3(0.0f));
        }
      }
      EXPECT_EQ(out.packed_normal(-1, 0), 0u);
    }
  });
}

TEST(PrepareGuides, VectorsMatchTheReference) {
  test::ForSizesAndTargets([](int width, int height) {
    Scene scene(width, height, 0.003f, -0.002f);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        scene.id(x, y) = 1 + static_cast<uint32_t>(3 * test::RandomAt(x / 6, y / 4, 1));
        scene.depth(x, y) *= 1 + 0.1f * static_cast<float>(scene.id(x, y));
        scene.normal[0](x, y) = 0.8f * test::RandomAt(x, y, 2);
        if (test::RandomAt(x, y, 3) < 0.1f) {
          scene.depth(x, y) = test::RandomAt(x, y, 4) < 0.5f ? kInfinity : kNan;
        }
      }
    }
    for (const bool has_id : {true, false}) {
      PrepareGuidesInput in = scene.Input();
      in.id = has_id ? in.id : nullptr;
      GuidePlanes expected(width, height, kBorder);
      GuidePlanes got(width, height, kBorder);
      expected.turn2 = got.turn2 = Image1(width, height);
      EXPECT_EQ(cpu::PrepareGuides(in, &got), reference::PrepareGuides(in, &expected));
      test::ExpectNear(got.inverse_depth, expected.inverse_depth, 1e-6);
      test::ExpectEqual(got.depth, expected.depth);
      test::ExpectNear(got.normal, expected.normal, 1e-6, 1e-6);
      test::ExpectNear(got.gradient, expected.gradient, 1e-6, 1e-6);
      test::ExpectNear(got.turn2, expected.turn2, 0, 2e-6);
      test::ExpectEqual(got.id, expected.id);
    }
  });
}

}  // namespace
}  // namespace stillray::prepare_guides_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/picture_motion.h"

#include <limits>

#include <gtest/gtest.h>

#include "denoise/picture_motion_shared.h"
#include "denoise/test_frames.h"

namespace stillray::picture_motion_test {
namespace {

constexpr int kWidth = 32;
constexpr int kHeight = 16;

/// A wall whose left half is a mirror with an image that moves by 2, of a wall that moves by 1.
struct Wall {
  Guides surface;
  Guides selected;
  Image3 albedo{kWidth, kHeight};
  Image3 other;  // of the other kind of image

  Wall() {
    surface = test::MakeWall(kWidth, kHeight).guides;
    surface.motion[0].Fill(1);
    selected.depth = surface.depth;
    selected.motion = surface.motion;
    for (int c = 0; c < 3; ++c) {
      albedo[c].Fill(0.9f);
    }
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth / 2; ++x) {
        surface.id(x, y) = 2;
        selected.depth(x, y) = 20;
        selected.motion[0](x, y) = 2;
        for (int c = 0; c < 3; ++c) {
          surface.albedo[c](x, y) = 0.01f;
        }
      }
    }
  }
  Image1 Images() const {
    Image1 images;
    FindImages(surface, selected, albedo, other, &images);
    return images;
  }
  Image2 Motion() const {
    Image2 motion = surface.motion;
    FollowImages(Images(), surface, selected.motion, &motion);
    return motion;
  }
};

TEST(PictureMotion, FollowsImagesExceptNearSilhouettes) {
  const Image2 motion = Wall().Motion();
  for (int x = 0; x < kWidth; ++x) {
    EXPECT_EQ(motion[0](x, 8), x < kWidth / 2 - 1 ? 2 : 1) << x;
    EXPECT_EQ(motion[1](x, 8), 0);
  }
}

TEST(PictureMotion, ImagesAreFoundWithTheirDepth) {
  Wall wall;
  wall.selected.depth(3, 8) = std::numeric_limits<float>::infinity();
  const Image1 images = wall.Images();
  for (int x = 0; x < kWidth; ++x) {
    EXPECT_EQ(images(x, 8), x == 3 ? 1e30f : (x < kWidth / 2 ? 20 : 0)) << x;
  }
  wall.selected.motion = Image2();
  EXPECT_EQ(wall.Images()(5, 8), 0);
}

TEST(PictureMotion, FollowsSurfacesThatAreDiffuseToo) {
  Wall wall;
  for (int c = 0; c < 3; ++c) {
    wall.surface.albedo[c].Fill(0.2f);
  }
  EXPECT_EQ(wall.Motion()[0](5, 8), 1);
}

// Of a pane: the image with more light.
TEST(PictureMotion, FollowsTheBrighterOfTwoImages) {
  for (const float other : {0.5f, 0.9f, 0.95f}) {
    Wall wall;
    wall.other = Image3(kWidth, kHeight);
    for (int c = 0; c < 3; ++c) {
      wall.other[c].Fill(other);
    }
    EXPECT_EQ(wall.Motion()[0](5, 8), other <= 0.9f ? 2 : 1) << other;
  }
}

TEST(PictureMotion, FollowsSurfacesWhoseImageHasNoMotion) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  for (const float unknown : {2.0f * kWidth, -1.0f * kWidth, kNone}) {
    Wall wall;
    wall.selected.motion[0](5, 8) = unknown;
    const Image2 motion = wall.Motion();
    EXPECT_EQ(motion[0](5, 8), 1);
    EXPECT_EQ(motion[0](6, 8), 2);  // beside it
    EXPECT_EQ(wall.Images()(5, 8), 20);
  }
}

/// The wall with an image from column 6 on, to column 10, that is nearer and moves by (0, 3).
Wall WallWithBox(float depth) {
  Wall wall;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 6; x < 10; ++x) {
      wall.selected.depth(x, y) = depth;
      wall.selected.motion[0](x, y) = 0;
      wall.selected.motion[1](x, y) = 3;
    }
  }
  return wall;
}

// The pixels on both sides of the box move with it.
TEST(PictureMotion, SilhouettesOfImagesMoveWithTheNearerImage) {
  const Image2 motion = WallWithBox(12).Motion();
  for (int x = 0; x < kWidth / 2 - 2; ++x) {
    EXPECT_EQ(motion[1](x, 8), x >= 5 && x <= 10 ? 3 : 0) << x;
    EXPECT_EQ(motion[0](x, 8), x >= 5 && x <= 10 ? 0 : 2) << x;
  }
}

TEST(PictureMotion, ImagesThatAreFartherOrHardlyNearerDoNotMoveTheirNeighbours) {
  for (const float depth : {25.0f, 19.5f}) {
    const Image2 motion = WallWithBox(depth).Motion();
    for (int x = 0; x < kWidth / 2 - 2; ++x) {
      const bool box = x >= 6 && x < 10;
      const bool edge = depth > 20 && (x == 6 || x == 9);  // the wall is in front of the box
      EXPECT_EQ(motion[1](x, 8), box && !edge ? 3 : 0) << x << " " << depth;
    }
  }
}

// As in curved mirrors and glass.
TEST(PictureMotion, MotionsThatDifferByManyPixelsAreNotTaken) {
  Wall wall = WallWithBox(12);
  wall.selected.motion[1].Fill(kMostMotionStep);
  for (int x = 0; x < kWidth / 2; ++x) {
    wall.selected.motion[1](x, 8) = x >= 6 && x < 10 ? kMostMotionStep : 0;
  }
  const Image2 motion = wall.Motion();
  EXPECT_EQ(motion[1](5, 8), 0);
  EXPECT_EQ(motion[1](6, 8), kMostMotionStep);
}

// Inverse depths of a plane that is seen at a grazing angle are linear in the picture: a neighbour
// that is nearer by 10 % is no other image.
TEST(PictureMotion, ImagesOfSlantedPlanesMoveEachPixelByItsOwnMotion) {
  Wall wall;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) {
      wall.selected.depth(x, y) = 20.0f / (1.0f + 0.15f * static_cast<float>(x));
      wall.selected.motion[1](x, y) = 0.1f * static_cast<float>(x);
    }
  }
  const Image2 motion = wall.Motion();
  for (int x = 1; x < kWidth / 2 - 2; ++x) {
    EXPECT_EQ(motion[1](x, 8), 0.1f * static_cast<float>(x)) << x;
  }
}

TEST(PictureMotion, TakesLengthsWhereImagesAre) {
  const Wall wall;
  Image1 length(kWidth, kHeight);
  length.Fill(30);
  Image1 of_image(kWidth, kHeight);
  of_image.Fill(2);
  TakeLengths(wall.Images(), of_image, &length);
  for (int x = 0; x < kWidth; ++x) {
    EXPECT_EQ(length(x, 8), x < kWidth / 2 ? 2 : 30) << x;
  }
}

TEST(PictureMotion, NoMotionStaysNone) {
  const Wall wall;
  Image2 none;
  FollowImages(wall.Images(), wall.surface, wall.selected.motion, &none);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace stillray::picture_motion_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Files with Cycles' Denoising Data: virtual guides of the frame, and the notes on them.
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mirror_file.h"
#include "mirror_room.h"
#include "stillray/aov.h"

namespace stillray::aov_seen_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

RoomPicture Picture(RoomSurface surface = RoomSurface::kMirror) {
  RoomCamera now;
  now.pan = -0.1;
  RoomCamera before = now;
  before.position.x -= 0.1;
  Room room = RoomWithMirror();
  room.rectangles.back().surface = surface;
  return Trace(room, now, before);
}

int Shown(const VirtualGuides& guides) {
  int count = 0;
  for (int y = 0; y < guides.depth.height(); ++y) {
    for (int x = 0; x < guides.depth.width(); ++x) {
      count += guides.depth(x, y) > 0 ? 1 : 0;
    }
  }
  return count;
}

struct Understood {
  AovLayout layout;
  Frame frame;
};

Understood Import(const ExrImage& image, const AovOptions& options = {"blender", {}}) {
  Understood result;
  Result<AovLayout> layout = UnderstandAovs(image, options, "file");
  EXPECT_TRUE(layout.ok()) << layout.status().message();
  if (layout.ok()) {
    Result<Frame> frame = ImportFrame(image, *layout, {0, 0}, "file");
    EXPECT_TRUE(frame.ok()) << frame.status().message();
    result = {std::move(*layout), frame.ok() ? std::move(*frame) : Frame()};
  }
  return result;
}

constexpr const char* kFollow = "reflections in mirrors and what is seen through glass follow";
constexpr const char* kDoNotFollow = "reflections and refractions do not follow";

TEST(AovSeen, AFileWithDenoisingDataHasVirtualGuides) {
  const RoomPicture picture = Picture();
  const Understood file = Import(FileOf(picture));
  EXPECT_GT(Shown(file.frame.reflection), 2000);
  EXPECT_EQ(Shown(file.frame.refraction), 0);
  for (const ivec2& p : {ivec2(80, 50), ivec2(100, 60)}) {
    ASSERT_GT(picture.expected.depth(p.x, p.y), 0);
    EXPECT_NEAR(file.frame.reflection.motion[0](p.x, p.y), picture.expected.motion[0](p.x, p.y),
                0.02);
    EXPECT_NEAR(file.frame.reflection.motion[1](p.x, p.y), picture.expected.motion[1](p.x, p.y),
                0.02);
  }
  EXPECT_THAT(file.layout.notes, Contains(HasSubstr(kFollow)));
  EXPECT_THAT(file.layout.notes, Not(Contains(HasSubstr(kDoNotFollow))));
  EXPECT_THAT(AovTable(file.layout), HasSubstr("seen_depth              V.Denoising Depth"));
}

// Volumes have no colour layer: transmitted light then counts as white where nothing transmits.
TEST(AovSeen, MirrorsInFogStillReflect) {
  ExrImage image = FileOf(Picture());
  image.Add("V.VolumeDir.", PixelType::kHalf, White(image.width, image.height));
  const Understood file = Import(image);
  EXPECT_GT(Shown(file.frame.reflection), 2000);
  EXPECT_EQ(Shown(file.frame.refraction), 0);
  EXPECT_EQ(file.frame.guides.transmission_albedo[0](80, 50), 1);
}

TEST(AovSeen, PanesNeedLayersOfTransmission) {
  const RoomPicture pane = Picture(RoomSurface::kPane);
  EXPECT_GT(Shown(Import(FileOf(pane)).frame.refraction), 2000);
  EXPECT_TRUE(Import(FileOf(pane, "Trans")).frame.refraction.empty());
}

TEST(AovSeen, WithoutALayerThatTheyNeedTheyAreCarriedThrough) {
  const RoomPicture picture = Picture();
  const struct {
    const char* without;
    const char* note;
  } cases[] = {{"Vector", "the file has no motion"},
               {"Normal", "the file has no normal"},
               {"Depth", "the file has no depth"}};
  for (const auto& [without, note] : cases) {
    const Understood file = Import(FileOf(picture, without));
    EXPECT_TRUE(file.frame.reflection.empty() && file.frame.refraction.empty()) << without;
    EXPECT_THAT(file.layout.carried, Contains("V.Denoising Depth"));
    EXPECT_THAT(file.layout.carried, Contains("V.Denoising Albedo"));
    EXPECT_THAT(file.layout.notes, Contains(HasSubstr(note)));
    EXPECT_THAT(file.layout.notes, Not(Contains(HasSubstr(kFollow))));
  }
  const Understood next = Import(FileOf(picture), {"blender", {"motion=Vector,to_next"}});
  EXPECT_TRUE(next.frame.reflection.empty());
  EXPECT_THAT(next.layout.notes, Contains(HasSubstr("no motion to the previous frame")));
}

// Light of one colour has no mirrors of its own.
TEST(AovSeen, LightAsOneColourHasNone) {
  const Understood file = Import(FileOf(Picture(), "Diff"));
  ASSERT_TRUE(file.layout.from_colour);
  EXPECT_TRUE(file.frame.reflection.empty());
  EXPECT_THAT(file.layout.carried, Contains("V.Denoising Depth"));
  EXPECT_THAT(file.layout.notes, Not(Contains(HasSubstr("Denoising Depth"))));
}

TEST(AovSeen, FilesWithoutTheLayersHaveNoNote) {
  for (const char* without : {"Denoising", "Denoising Albedo"}) {
    const Understood file = Import(FileOf(Picture(), without));
    EXPECT_TRUE(file.frame.reflection.empty());
    EXPECT_THAT(file.layout.notes, Not(Contains(HasSubstr("refractions")))) << without;
  }
  const Understood file = Import(FileOf(Picture()), {"blender", {"seen_depth=none"}});
  EXPECT_TRUE(file.frame.reflection.empty());
  EXPECT_THAT(file.layout.notes, Not(Contains(HasSubstr("refractions"))));
}

float Hash(int x, int y) {
  return static_cast<float>((x * 37 + y * 91) % 19);
}

TEST(AovSeen, TheNoteNamesThePassThatDoesNotFit) {
  RoomPicture distances = Picture();
  RoomPicture normals = Picture();
  RoomPicture motion = Picture();
  normals.seen.normal = Image3(160, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      distances.seen.depth(x, y) = 1 + Hash(x, y);
      motion.frame.guides.motion[0](x, y) = Hash(x, y);
    }
  }
  const struct {
    const RoomPicture& picture;
    const char* note;
  } cases[] = {{distances, "V.Denoising Depth is not the length of paths to the depth in V.Depth"},
               {normals, "V.Denoising Normal has not the normals of V.Normal"},
               {motion, "V.Vector is not the motion of a camera"}};
  for (const auto& [picture, note] : cases) {
    const Understood file = Import(FileOf(picture));
    EXPECT_EQ(Shown(file.frame.reflection), 0);
    EXPECT_THAT(file.layout.notes, Contains(HasSubstr(note)));
    EXPECT_THAT(file.layout.notes, Contains(HasSubstr(kDoNotFollow)));
    EXPECT_THAT(file.layout.notes, Not(Contains(HasSubstr(kFollow))));
  }
}

}  // namespace
}  // namespace stillray::aov_seen_test

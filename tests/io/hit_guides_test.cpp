// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Files with hit distances and motion of reflections: virtual guides of the frame, and the notes on
// them.
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/pixels.h"
#include "io/aov_importer.h"
#include "mirror_file.h"
#include "mirror_room.h"
#include "stillray/aov.h"

namespace stillray::hit_guides_test {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr int kWidth = 160;
constexpr int kHeight = 120;

RoomCamera Now() {
  RoomCamera camera;
  camera.pan = -0.1;
  return camera;
}

RoomCamera Before() {
  RoomCamera camera = Now();
  camera.position += glm::dvec3(-0.1, 0.02, -0.05);
  camera.pan = -0.12;
  return camera;
}

RoomPicture PictureOf(const Room& room) {
  RoomOptions options;
  options.outliers = 0;
  return Trace(room, Now(), Before(), options);
}

RoomPicture Picture() {
  return PictureOf(RoomWithMirror());
}

RoomPicture PictureOfBall() {
  Room room = EmptyRoom();
  room.balls.push_back({{0, 1.5, 0.2}, 0.8, RoomSurface::kMirror});
  return PictureOf(room);
}

/// Of the images of mirrors: what is left of the path behind the surface.
Image1 HitsOf(const RoomPicture& picture, const VirtualGuides& images) {
  Image1 hits(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float image = images.depth(x, y);
      const double secant = glm::length(Now().Ray(PointOfPixel(kWidth, kHeight, x, y)));
      if (image > 0) {
        hits(x, y) =
            std::isinf(image)
                ? 1e10f
                : static_cast<float>(
                      (static_cast<double>(image) - picture.frame.guides.depth(x, y)) * secant);
      }
    }
  }
  return hits;
}

ExrImage FileWith(const RoomPicture& picture, const Image1& hits,
                  const std::string& without = "Denoising") {
  ExrImage image = FileOf(picture, without);
  image.Add("V.Hit.Z", PixelType::kFloat, hits);
  return image;
}

struct Understood {
  AovLayout layout;
  Frame frame;
  io::FrameImages images;
};

Understood Import(const ExrImage& image, std::vector<std::string> mappings = {"hit_distance=Hit"},
                  const CameraMatrices* camera = nullptr) {
  Understood result;
  Result<AovLayout> layout = UnderstandAovs(image, {"blender", std::move(mappings)}, "file");
  EXPECT_TRUE(layout.ok()) << layout.status().message();
  if (layout.ok()) {
    io::ImportExtras extras;
    extras.images = &result.images;
    extras.camera = camera;
    Result<Frame> frame = io::ImportFrameWith(image, *layout, {0, 0}, "file", extras);
    EXPECT_TRUE(frame.ok()) << frame.status().message();
    result.layout = std::move(*layout);
    result.frame = frame.ok() ? std::move(*frame) : Frame();
  }
  return result;
}

struct Comparison {
  int expected = 0;
  int found = 0;
  int right = 0;  ///< of those found: depth up to 0.5 %, motion up to a distance in pixels
  int elsewhere = 0;
};

Comparison Compare(const VirtualGuides& found, const VirtualGuides& expected,
                   float pixels = 0.02f) {
  Comparison result;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float e = expected.depth(x, y);
      const float f = found.empty() ? 0.0f : found.depth(x, y);
      result.expected += e > 0 ? 1 : 0;
      result.found += e > 0 && f > 0 ? 1 : 0;
      result.elsewhere += e > 0 ? 0 : f > 0;
      if (e > 0 && f > 0) {
        const float off = std::hypot(found.motion[0](x, y) - expected.motion[0](x, y),
                                     found.motion[1](x, y) - expected.motion[1](x, y));
        result.right += (e == f || std::abs(f / e - 1) < 0.005f) && off < pixels ? 1 : 0;
      }
    }
  }
  return result;
}

void ExpectMirror(const Comparison& mirror) {
  EXPECT_GT(mirror.expected, 2000);
  EXPECT_GT(mirror.found, 0.99 * mirror.expected);
  EXPECT_GT(mirror.right, 0.985 * mirror.found);
  EXPECT_EQ(mirror.elsewhere, 0);
}

constexpr const char* kFollow = "reflections follow V.Hit";
constexpr const char* kDoNotFollow = "reflections do not follow V.Hit, and are blurred";

TEST(HitGuides, APlanarMirrorHasTheImageThatTheyPlace) {
  const RoomPicture picture = Picture();
  const ExrImage image = FileWith(picture, HitsOf(picture, picture.expected));
  const Understood file = Import(image);
  ExpectMirror(Compare(file.frame.reflection, picture.expected));
  EXPECT_TRUE(file.frame.refraction.empty());
  EXPECT_THAT(file.layout.notes, Contains(kFollow));
  EXPECT_THAT(AovTable(file.layout), HasSubstr("hit_distance            V.Hit"));
  // Normals are those of the mirror, and what it shows counts as white.
  EXPECT_EQ(VectorAt(file.frame.reflection.normal, 80, 50),
            VectorAt(file.frame.guides.normal, 80, 50));
  EXPECT_EQ(file.frame.reflection.albedo[0](80, 50), 1);
  ExpectMirror(Compare(
      Import(image, {fmt::format("hit_distance=Hit,focal={}", kWidth / 2 / 0.6)}).frame.reflection,
      picture.expected));
}

/// The focal length may be known in other ways: a wrong one shows.
TEST(HitGuides, TheCameraGivesTheFocalLength) {
  const RoomPicture picture = Picture();
  const ExrImage image = FileWith(picture, HitsOf(picture, picture.expected));
  const CameraMatrices camera = MatricesOfOpenGl(Now(), kWidth, kHeight);
  ExpectMirror(
      Compare(Import(image, {"hit_distance=Hit"}, &camera).frame.reflection, picture.expected));
  const Comparison wrong =
      Compare(Import(image, {"hit_distance=Hit,focal=60"}).frame.reflection, picture.expected);
  EXPECT_LT(wrong.right, 0.5 * wrong.found);
}

TEST(HitGuides, ACameraWithAShiftedLensIsExact) {
  RoomCamera now = Now();
  now.shift = {0.3, -0.2};
  RoomOptions options;
  options.outliers = 0;
  RoomCamera before = Before();
  before.shift = now.shift;
  const RoomPicture picture = Trace(RoomWithMirror(), now, before, options);
  Image1 hits(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double secant = glm::length(now.Ray(PointOfPixel(kWidth, kHeight, x, y)));
      const float image = picture.expected.depth(x, y);
      hits(x, y) = image > 0
                       ? static_cast<float>((image - picture.frame.guides.depth(x, y)) * secant)
                       : 0.0f;
    }
  }
  const CameraMatrices camera = MatricesOf(now, kWidth, kHeight);
  const Comparison mirror =
      Compare(Import(FileWith(picture, hits), {"hit_distance=Hit"}, &camera).frame.reflection,
              picture.expected);
  EXPECT_GT(mirror.expected, 1500);
  EXPECT_GT(mirror.right, 0.98 * mirror.expected);
}

TEST(HitGuides, CurvedMirrorsFollowTheLawOfReflection) {
  const RoomPicture picture = PictureOfBall();
  const Understood file = Import(FileWith(picture, HitsOf(picture, picture.curved)));
  const Comparison ball = Compare(file.frame.reflection, picture.curved, 0.2f);
  EXPECT_GT(ball.expected, 1500);
  EXPECT_GT(ball.found, 0.85 * ball.expected);
  EXPECT_GT(ball.right, 0.8 * ball.expected);
  EXPECT_EQ(ball.elsewhere, 0);
}

/// Distances of random rays.
Image1 RandomHits(const RoomPicture& picture) {
  Image1 hits = HitsOf(picture, picture.expected);
  std::mt19937 random(7);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float hit = 0.5f + static_cast<float>(random() % 1000) * 0.02f;
      hits(x, y) = hits(x, y) > 0 ? hit : 0.0f;
    }
  }
  return hits;
}

TEST(HitGuides, RoughSurfacesHaveNone) {
  const RoomPicture picture = Picture();
  const Comparison mirror =
      Compare(Import(FileWith(picture, RandomHits(picture))).frame.reflection, picture.expected);
  EXPECT_GT(mirror.expected, 2000);
  EXPECT_EQ(mirror.found, 0);
}

/// With roughness the denoiser decides which surfaces are smooth (select_guides).
TEST(HitGuides, WithRoughnessEveryPixelHasItsOwn) {
  const RoomPicture picture = Picture();
  ExrImage image = FileWith(picture, RandomHits(picture));
  Image1 roughness(kWidth, kHeight);
  roughness.Fill(0.3f);
  image.Add("V.Rough.X", PixelType::kHalf, roughness);
  const Understood file = Import(image, {"hit_distance=Hit", "roughness=Rough"});
  const Comparison mirror = Compare(file.frame.reflection, picture.expected);
  EXPECT_EQ(mirror.found, mirror.expected);
  EXPECT_EQ(file.frame.guides.roughness(80, 50), 0.3f);
  ExrImage smooth = FileWith(picture, HitsOf(picture, picture.expected));
  smooth.Add("V.Rough.X", PixelType::kHalf, Image1(kWidth, kHeight));
  const Comparison own = Compare(
      Import(smooth, {"hit_distance=Hit", "roughness=Rough"}).frame.reflection, picture.expected);
  EXPECT_EQ(own.found, own.expected);
  EXPECT_GT(own.right, 0.99 * own.expected);
}

TEST(HitGuides, PixelsWithoutOneShowNone) {
  const RoomPicture picture = Picture();
  Image1 hits = HitsOf(picture, picture.expected);
  const float none[] = {0, -1, kNan, -kInf};
  for (int i = 0; i < 4; ++i) {
    ASSERT_GT(hits(70 + i, 50), 0);
    hits(70 + i, 50) = none[i];
  }
  hits(74, 50) = kInf;
  hits(75, 50) = 2e9f;
  ExrImage image = FileWith(picture, hits);
  image.Add("V.Rough.X", PixelType::kHalf, Image1(kWidth, kHeight));
  const VirtualGuides found =
      Import(image, {"hit_distance=Hit", "roughness=Rough"}).frame.reflection;
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(found.depth(70 + i, 50), 0) << i;
  }
  EXPECT_EQ(found.depth(74, 50), kInf);
  EXPECT_EQ(found.depth(75, 50), kInf);
  EXPECT_GT(found.depth(76, 50), 0);
}

TEST(HitGuides, OtherUnits) {
  const RoomPicture picture = Picture();
  const Image1 hits = HitsOf(picture, picture.expected);
  Image1 inverse(kWidth, kHeight);
  Image1 normalised(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float hit = hits(x, y);
      inverse(x, y) = hit == 0 ? -1.0f : hit > 1e9f ? 0.0f : 1 / hit;
      normalised(x, y) = hit > 1e9f ? 1.0f : hit / 50;
    }
  }
  ExpectMirror(
      Compare(Import(FileWith(picture, inverse), {"hit_distance=Hit,inverse"}).frame.reflection,
              picture.expected));
  const Understood file =
      Import(FileWith(picture, normalised), {"hit_distance=Hit,normalised,far=50"});
  ExpectMirror(Compare(file.frame.reflection, picture.expected));
  EXPECT_THAT(AovTable(file.layout), HasSubstr("normalised, near=0, far=50"));
}

TEST(HitGuides, NormalsAndAlbedoOfWhatIsSeen) {
  const RoomPicture picture = Picture();
  ExrImage image = FileWith(picture, HitsOf(picture, picture.expected), "nothing");
  const auto right = [&](const Understood& file) {
    int count = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const VirtualGuides& e = picture.expected;
        const VirtualGuides& f = file.frame.reflection;
        count += e.depth(x, y) > 0 && std::isfinite(e.depth(x, y)) && f.depth(x, y) > 0 &&
                 glm::length(VectorAt(f.normal, x, y) - VectorAt(e.normal, x, y)) < 0.02f &&
                 glm::length(VectorAt(f.albedo, x, y) - VectorAt(e.albedo, x, y)) < 0.01f;
      }
    }
    return count;
  };
  // With the length of the seen path, and without it.
  EXPECT_GT(right(Import(image)), 1700);
  EXPECT_GT(right(Import(image, {"hit_distance=Hit", "seen_depth=none"})), 1700);
  EXPECT_EQ(right(Import(image, {"hit_distance=Hit", "seen_depth=none", "seen_normal=none",
                                 "seen_albedo=none"})),
            0);
  // Layers that describe something else do not count.
  for (Channel& channel : image.channels) {
    if (channel.name == "V.Denoising Depth.Z") {
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          channel.values(x, y) *= picture.expected.depth(x, y) > 0 ? 3.0f : 1.0f;
        }
      }
    }
  }
  EXPECT_LT(right(Import(image)), 100);
}

void AddMotion(const Image2& motion, float scale, ExrImage* image) {
  const char* letters[] = {"V.SpecVec.X", "V.SpecVec.Y"};
  for (int c = 0; c < 2; ++c) {
    Image1 plane = motion[c];
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        plane(x, y) *= scale;
      }
    }
    image->Add(letters[c], PixelType::kFloat, plane);
  }
}

/// As if everything moved by itself.
RoomPicture WithoutACamera() {
  RoomPicture picture = Picture();
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      picture.frame.guides.motion[0](x, y) = static_cast<float>((x * 37 + y * 91) % 19);
    }
  }
  return picture;
}

TEST(HitGuides, MotionOfReflectionsNeedsNoCamera) {
  const RoomPicture picture = WithoutACamera();
  RoomPicture moved = picture;
  moved.expected.motion[0](80, 50) = kNan;
  ExrImage image = FileWith(picture, HitsOf(picture, picture.expected));
  AddMotion(moved.expected.motion, -1, &image);
  const Understood without = Import(image);
  EXPECT_EQ(Compare(without.frame.reflection, picture.expected).found, 0);
  EXPECT_EQ(without.images.missing, io::NoSeenGuides::kMotion);
  EXPECT_THAT(without.layout.notes, Contains(HasSubstr(kDoNotFollow)));
  const Understood file =
      Import(image, {"hit_distance=Hit", "specular_motion=SpecVec,from_previous,y_down"});
  ExpectMirror(Compare(file.frame.reflection, picture.expected));
  EXPECT_EQ(file.images.missing, io::NoSeenGuides::kNone);
  EXPECT_EQ(file.frame.reflection.motion[0](80, 50), 2 * kWidth);
  EXPECT_THAT(file.layout.notes, Contains(kFollow));
  EXPECT_THAT(AovTable(file.layout), HasSubstr("specular_motion         V.SpecVec"));
}

TEST(HitGuides, MotionOfReflectionsServesDenoisingDataToo) {
  const RoomPicture picture = WithoutACamera();
  ExrImage image = FileOf(picture);
  AddMotion(picture.expected.motion, 1, &image);
  const Understood file = Import(image, {"specular_motion=SpecVec,y_down"});
  const Comparison mirror = Compare(file.frame.reflection, picture.expected);
  EXPECT_GT(mirror.found, 0.99 * mirror.expected);
  EXPECT_GT(mirror.right, 0.98 * mirror.found);
}

TEST(HitGuides, AnUnknownFocalLengthIsNoted) {
  const RoomPicture picture = Picture();
  ExrImage image = FileWith(picture, HitsOf(picture, picture.expected), "Normal");
  const Understood file = Import(image, {"hit_distance=Hit", "seen_normal=none"});
  EXPECT_TRUE(file.frame.reflection.empty());
  EXPECT_EQ(file.images.missing, io::NoSeenGuides::kFocal);
  EXPECT_THAT(file.layout.notes,
              Contains(::testing::AllOf(HasSubstr(kDoNotFollow), HasSubstr("the focal length"),
                                        HasSubstr("--aov hit_distance=LAYER,focal=PIXELS"))));
  const Understood given = Import(image, {"hit_distance=Hit,focal=133.3", "seen_normal=none"});
  EXPECT_EQ(given.images.missing, io::NoSeenGuides::kNone);
  EXPECT_FALSE(given.frame.reflection.empty());
}

/// Normals that are all parallel reveal no angle of view, but paths through mirrors do.
TEST(HitGuides, LengthsOfPathsRevealTheFocalLength) {
  const RoomPicture picture = Picture();
  ExrImage image = FileWith(picture, HitsOf(picture, picture.expected), "nothing");
  for (Channel& channel : image.channels) {
    if (channel.name.starts_with("V.Normal.")) {
      channel.values.Fill(channel.name.ends_with("Z") ? -1.0f : 0.0f);
    }
  }
  const Understood file = Import(image);
  EXPECT_EQ(file.images.missing, io::NoSeenGuides::kNone);
  const Comparison mirror = Compare(file.frame.reflection, picture.expected);
  EXPECT_GT(mirror.found, 0.95 * mirror.expected);
  EXPECT_GT(mirror.right, 0.95 * mirror.found);
  EXPECT_EQ(Import(image, {"hit_distance=Hit", "seen_depth=none"}).images.missing,
            io::NoSeenGuides::kFocal);
}

TEST(HitGuides, LayersThatCannotBeUsedAreNoted) {
  const RoomPicture picture = Picture();
  const Image1 hits = HitsOf(picture, picture.expected);
  const struct {
    const char* without;
    const char* note;
  } cases[] = {{"Depth", "V.Hit is not used as hit_distance: the file has no depth"},
               {"Gloss", "V.Hit is not used as hit_distance: no layers hold reflected light"}};
  for (const auto& [without, note] : cases) {
    const Understood file =
        Import(FileWith(picture, hits, without), {"hit_distance=Hit", "seen_depth=none"});
    EXPECT_TRUE(file.frame.reflection.empty()) << without;
    EXPECT_THAT(file.layout.notes, Contains(HasSubstr(note)));
    EXPECT_THAT(file.layout.carried, Contains("V.Hit"));
  }
  ExrImage both = FileWith(picture, hits);
  both.Add("V.Image.Z", PixelType::kFloat, picture.expected.depth);
  EXPECT_THAT(Import(both, {"hit_distance=Hit", "reflection_depth=Image"}).layout.notes,
              Contains(HasSubstr("V.Image is given as reflection_depth")));
  ExrImage motion = FileOf(picture, "Denoising");
  AddMotion(picture.expected.motion, 1, &motion);
  EXPECT_THAT(Import(motion, {"specular_motion=SpecVec"}).layout.notes,
              Contains(HasSubstr("V.SpecVec is not used as specular_motion: the depth of what is "
                                 "reflected is unknown")));
}

TEST(HitGuides, WordsThatAreNotUnderstood) {
  const RoomPicture picture = Picture();
  const ExrImage image = FileWith(picture, HitsOf(picture, picture.expected));
  const auto message = [&](const char* mapping) {
    return UnderstandAovs(image, {"blender", {mapping}}, "file").status().message();
  };
  EXPECT_THAT(message("hit_distance=Hit,ray"),
              HasSubstr("--aov hit_distance: 'ray' is not understood, expected linear, inverse"));
  EXPECT_THAT(message("hit_distance=Hit,normalised"),
              HasSubstr("--aov hit_distance: normalised needs near= and far="));
  EXPECT_THAT(message("specular_motion=Vector,upwards"),
              HasSubstr("--aov specular_motion: 'upwards' is not understood"));
  EXPECT_THAT(message("hit_distance=Nowhere"), HasSubstr("no layers are called 'Nowhere'"));
}

}  // namespace
}  // namespace stillray::hit_guides_test

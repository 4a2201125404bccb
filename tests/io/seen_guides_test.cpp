// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Virtual guides of a room with mirrors against points reflected at their planes.
#include "io/seen_guides.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "core/cameras.h"
#include "core/pixels.h"
#include "mirror_room.h"

namespace stillray::io::seen_guides_test {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

NoSeenGuides SetSeen(const SeenLayers& seen, Frame* frame) {
  CameraFits fits(frame->guides);
  FrameImages images;
  SetSeenGuides(seen, frame, &images);
  MoveSeenGuides(&fits, frame, &images);
  return images.missing;
}

RoomCamera Now() {
  RoomCamera camera;
  camera.position = {0.1, 1.5, -4.0};
  camera.pan = -0.1;
  return camera;
}

RoomCamera Before() {
  RoomCamera camera;
  camera.position = {-0.05, 1.46, -4.15};
  camera.pan = -0.13;
  camera.tilt = 0.01;
  camera.tangent = 0.61;
  return camera;
}

RoomPicture Picture(const Room& room, const RoomOptions& options = {}) {
  return Trace(room, Now(), Before(), options);
}

void ForEachPixel(const RoomPicture& picture, const std::function<void(int, int)>& visit) {
  for (int y = 0; y < picture.frame.height; ++y) {
    for (int x = 0; x < picture.frame.width; ++x) {
      visit(x, y);
    }
  }
}

int Count(const RoomPicture& picture, const std::function<bool(int, int)>& is) {
  int count = 0;
  ForEachPixel(picture, [&](int x, int y) { count += is(x, y) ? 1 : 0; });
  return count;
}

/// How virtual guides compare with the expected ones, over pixels that both have.
struct Comparison {
  int expected = 0;  ///< pixels that show an image
  int found = 0;     ///< those of them that have guides
  int right = 0;     ///< those of them where all guides are right
  int sky = 0;       ///< those of them that show the sky
};

/// Within the precision of halves.
bool IsRight(const VirtualGuides& g, const VirtualGuides& e, int x, int y) {
  const vec2 motion = {g.motion[0](x, y) - e.motion[0](x, y),
                       g.motion[1](x, y) - e.motion[1](x, y)};
  if (!(glm::length(motion) < 0.02f)) {
    return false;
  }
  if (std::isinf(e.depth(x, y))) {
    return std::isinf(g.depth(x, y));
  }
  return std::abs(g.depth(x, y) / e.depth(x, y) - 1) < 0.005f &&
         glm::length(VectorAt(g.normal, x, y) - VectorAt(e.normal, x, y)) < 0.01f &&
         std::abs(glm::length(VectorAt(g.normal, x, y)) - 1) < 1e-5f &&
         glm::length(VectorAt(g.albedo, x, y) - VectorAt(e.albedo, x, y)) < 0.005f;
}

Comparison Compare(const VirtualGuides& g, const RoomPicture& picture) {
  Comparison result;
  ForEachPixel(picture, [&](int x, int y) {
    if (picture.expected.depth(x, y) > 0) {
      ++result.expected;
      result.found += g.depth(x, y) > 0 ? 1 : 0;
      result.right += g.depth(x, y) > 0 && IsRight(g, picture.expected, x, y) ? 1 : 0;
      result.sky += std::isinf(g.depth(x, y)) ? 1 : 0;
    }
  });
  return result;
}

int Shown(const RoomPicture& picture, const VirtualGuides& g) {
  return Count(picture, [&](int x, int y) { return g.depth(x, y) != 0; });
}

TEST(SetSeenGuides, APlanarMirrorHasTheGuidesOfTheReflectedWorld) {
  RoomOptions options;
  options.outliers = 0;
  RoomPicture picture = Picture(RoomWithMirror(), options);
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  const Comparison reflection = Compare(picture.frame.reflection, picture);
  EXPECT_GT(reflection.expected, 2000);
  EXPECT_GT(reflection.found, 0.99 * reflection.expected);
  // Corners of a single pixel take their neighbours' guides.
  EXPECT_GT(reflection.right, 0.985 * reflection.found);
  EXPECT_GT(reflection.sky, 50);
  EXPECT_EQ(Shown(picture, picture.frame.reflection), reflection.found);  // nothing elsewhere
  EXPECT_EQ(Shown(picture, picture.frame.refraction), 0);
}

// The image does not move with the mirror's surface: else the test above would show nothing.
TEST(SetSeenGuides, TheImageMovesOtherwiseThanTheMirror) {
  const RoomPicture picture = Picture(RoomWithMirror());
  const Image2& surface = picture.frame.guides.motion;
  const int apart = Count(picture, [&](int x, int y) {
    const VirtualGuides& e = picture.expected;
    return e.depth(x, y) > 0 && std::abs(e.motion[0](x, y) - surface[0](x, y)) > 0.2f;
  });
  EXPECT_GT(apart, 2000);
}

/// Pixels whose image is at another depth, or has another normal.
int CountDifferent(const RoomPicture& picture, const Image1& depth, const Image3& normal,
                   const VirtualGuides& other) {
  return Count(picture, [&](int x, int y) {
    const float a = depth(x, y);
    const float b = other.depth(x, y);
    const bool same = a == b || std::abs(a / b - 1) < 0.1f;
    return b > 0 &&
           !(same && glm::length(VectorAt(normal, x, y) - VectorAt(other.normal, x, y)) < 0.1f);
  });
}

TEST(SetSeenGuides, OutliersTakeTheGuidesOfTheirNeighbours) {
  RoomOptions options;  // lines of the floor are close enough in depth
  options.width = 480;
  options.height = 360;
  options.outliers = 0;
  RoomPicture clean = Picture(RoomWithMirror(), options);
  options.outliers = 0.02;
  RoomPicture picture = Picture(RoomWithMirror(), options);
  ASSERT_EQ(SetSeen(clean.seen, &clean.frame), NoSeenGuides::kNone);
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  const VirtualGuides& expected = clean.frame.reflection;
  const VirtualGuides& g = picture.frame.reflection;
  const int outliers = Count(
      picture, [&](int x, int y) { return picture.seen.depth(x, y) != clean.seen.depth(x, y); });
  EXPECT_GT(outliers, 30);
  EXPECT_LT(CountDifferent(picture, g.depth, g.normal, expected), 0.1 * outliers);
}

TEST(SetSeenGuides, OutliersOfColourAloneTakeThatOfTheirNeighbours) {
  RoomOptions options;
  options.width = 480;
  options.height = 360;
  options.outliers = 0;
  RoomPicture picture = Picture(RoomWithMirror(), options);
  RoomPicture spotted = picture;
  int spots = 0;
  ForEachPixel(picture, [&](int x, int y) {
    if ((x * 7 + y * 13) % 60 == 0) {
      const bool dark = picture.seen.albedo[0](x, y) < 0.3f;
      for (int c = 0; c < 3; ++c) {
        spotted.seen.albedo[c](x, y) = dark ? 0.8f : 0.1f;
      }
      spots += picture.expected.depth(x, y) > 0 ? 1 : 0;
    }
  });
  EXPECT_GT(spots, 200);
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  ASSERT_EQ(SetSeen(spotted.seen, &spotted.frame), NoSeenGuides::kNone);
  const VirtualGuides& g = spotted.frame.reflection;
  const VirtualGuides& expected = picture.frame.reflection;
  const int wrong = Count(picture, [&](int x, int y) {
    const vec3 difference = VectorAt(g.albedo, x, y) - VectorAt(expected.albedo, x, y);
    return std::isfinite(expected.depth(x, y)) && glm::length(difference) > 0.01f;
  });
  EXPECT_LT(wrong, 0.35 * spots);  // those beside edges of the texture
}

// As before a wall on a floor. The side walls, in the mirror alone, have the third direction.
TEST(SetSeenGuides, NormalsOfTwoDirectionsAreEnough) {
  Room room = RoomWithMirror();
  for (const size_t i : {3u, 4u}) {  // side walls, only beside and behind the camera
    room.rectangles[i].corner.z = -20;
    room.rectangles[i].b = {0, 3, 0};
  }
  room.rectangles[5].b = {0, 0, 0};
  RoomOptions options;
  options.outliers = 0;
  RoomPicture picture = Picture(room, options);
  ForEachPixel(picture, [&](int x, int y) {
    if (picture.what(x, y) == 1) {
      ASSERT_NEAR(picture.frame.guides.normal[0](x, y), 0, 1e-3);
    }
  });
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  const Comparison reflection = Compare(picture.frame.reflection, picture);
  EXPECT_GT(reflection.expected, 2000);
  EXPECT_GT(reflection.right, 0.98 * reflection.expected);
}

TEST(SetSeenGuides, AMovingObjectChangesNothing) {
  Room room = RoomWithMirror();
  room.rectangles.push_back(MovingBoard());
  RoomOptions options;
  options.outliers = 0;
  RoomPicture picture = Picture(room, options);
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  const Comparison reflection = Compare(picture.frame.reflection, picture);
  EXPECT_GT(reflection.expected, 1500);
  // The board's own image moves with the board, which the length of the path does not tell.
  EXPECT_GT(reflection.right, 0.9 * reflection.expected);
}

/// The mirror's surface in place of a smooth one.
Room WithMirrorOf(RoomSurface surface, glm::dvec3 colour) {
  Room room = RoomWithMirror();
  room.rectangles.back().surface = surface;
  room.rectangles.back().colour = colour;
  return room;
}

TEST(SetSeenGuides, APaneRefracts) {
  Room room = WithMirrorOf(RoomSurface::kPane, {0.95, 0.95, 0.9});
  room.rectangles.back().corner.z = 1.5;
  RoomOptions options;
  options.outliers = 0;
  RoomPicture picture = Picture(room, options);
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  const Comparison refraction = Compare(picture.frame.refraction, picture);
  EXPECT_GT(refraction.expected, 2500);
  EXPECT_GT(refraction.found, 0.99 * refraction.expected);
  EXPECT_GT(refraction.right, 0.985 * refraction.found);
  EXPECT_EQ(Shown(picture, picture.frame.reflection), 0);
  EXPECT_EQ(Shown(picture, picture.frame.refraction), refraction.found);
}

/// Light of one lobe of the pane: a pixel's only sample was reflected, or came through.
void SetLobe(bool through, int x, int y, Frame* frame) {
  for (Signal& signal : frame->signals) {
    const bool transmitted = signal.kind == SignalKind::kIndirectTransmission;
    signal.radiance[0](x, y) = transmitted == through ? 1.0f : 0.0f;
  }
}

TEST(SetSeenGuides, SamplesOfAPanesOtherLobeTakeTheGuidesOfTheirNeighbours) {
  Room room = WithMirrorOf(RoomSurface::kPane, {0.95, 0.95, 0.9});
  room.rectangles.back().corner.z = 1.5;
  RoomOptions options;
  options.outliers = 0;
  RoomPicture picture = Picture(room, options);
  Frame& frame = picture.frame;
  for (const SignalKind kind : {SignalKind::kIndirectSpecular, SignalKind::kIndirectTransmission}) {
    frame.signals.push_back({kind, Image3(frame.width, frame.height), Image1()});
  }
  int reflected = 0;
  ForEachPixel(picture, [&](int x, int y) {
    // Pairs of columns, so that such pixels agree with each other.
    const bool other = (x / 2 * 7 + y / 3 * 5) % 11 == 0;
    SetLobe(!other, x, y, &frame);
    if (other && picture.expected.depth(x, y) > 0) {
      picture.seen.depth(x, y) *= 3;
      ++reflected;
    }
  });
  EXPECT_GT(reflected, 200);
  Frame without_light = frame;
  without_light.signals.clear();
  ASSERT_EQ(SetSeen(picture.seen, &without_light), NoSeenGuides::kNone);
  const Comparison before = Compare(without_light.refraction, picture);
  EXPECT_LT(before.right, before.expected - 0.9 * reflected);
  ASSERT_EQ(SetSeen(picture.seen, &frame), NoSeenGuides::kNone);
  const Comparison refraction = Compare(frame.refraction, picture);
  EXPECT_GT(refraction.found, 0.98 * refraction.expected);
  // Some lie beside an edge and take the guides of its other side.
  EXPECT_GT(refraction.right, refraction.expected - 0.6 * reflected);
}

TEST(SetSeenGuides, WithoutTransmittedLightThereIsNoRefraction) {
  RoomPicture picture = Picture(RoomWithMirror());
  picture.frame.guides.transmission_albedo = Image3();
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  EXPECT_TRUE(picture.frame.refraction.empty());
  EXPECT_GT(Shown(picture, picture.frame.reflection), 2000);
}

TEST(SetSeenGuides, ARoughSurfaceHasNone) {
  RoomPicture picture = Picture(WithMirrorOf(RoomSurface::kRough, {0.9, 0.8, 0.7}));
  EXPECT_GT(Count(picture, [&](int x, int y) { return picture.what(x, y) == 4; }), 2000);
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  EXPECT_EQ(Shown(picture, picture.frame.reflection), 0);
}

Room RoomWithBall(double radius, RoomSurface surface) {
  Room room = EmptyRoom();
  room.balls.push_back({{0, 1.5, 0.2}, radius, surface});
  return room;
}

RoomPicture PictureOfBall(double radius, RoomSurface surface, int width) {
  RoomOptions options;
  options.width = width;
  options.height = width * 3 / 4;
  options.outliers = 0;
  return Picture(RoomWithBall(radius, surface), options);
}

/// How the guides of a ball compare with the expected ones.
struct BallComparison {
  int pixels = 0;
  int inner = 0;  ///< ... not near the outline
  int found = 0;  ///< those of them that have guides
  int right = 0;  ///< those of them where depth, normal and albedo are right
  int moved = 0;  ///< ... of the inner ones, and the motion is right to a tenth of a pixel
};

BallComparison CompareBall(const VirtualGuides& g, const RoomPicture& picture) {
  constexpr float kInner = 0.35f;  // cosine of the angle to the ray
  const VirtualGuides& e = picture.curved;
  BallComparison result;
  ForEachPixel(picture, [&](int x, int y) {
    if (!(e.depth(x, y) > 0)) {
      return;
    }
    ++result.pixels;
    result.found += g.depth(x, y) > 0 ? 1 : 0;
    const bool sky = std::isinf(e.depth(x, y));
    const bool right =
        sky ? std::isinf(g.depth(x, y))
            : std::abs(g.depth(x, y) / e.depth(x, y) - 1) < 0.01f &&
                  glm::length(VectorAt(g.normal, x, y) - VectorAt(e.normal, x, y)) < 0.01f &&
                  glm::length(VectorAt(g.albedo, x, y) - VectorAt(e.albedo, x, y)) < 0.01f;
    result.right += right ? 1 : 0;
    const vec2 off(g.motion[0](x, y) - e.motion[0](x, y), g.motion[1](x, y) - e.motion[1](x, y));
    const glm::dvec2 p = PointOfPixel(picture.frame.width, picture.frame.height, x, y);
    const float facing =
        -dot(VectorAt(picture.frame.guides.normal, x, y), vec3(glm::normalize(Now().Ray(p))));
    const bool inner = facing > kInner && right;
    result.inner += inner ? 1 : 0;
    result.moved += inner && glm::length(off) < 0.1f ? 1 : 0;
  });
  return result;
}

TEST(SetSeenGuides, AChromeBallHasTheGuidesOfTheReflectedWorld) {
  for (const double radius : {0.4, 1.2}) {
    for (const int width : {160, 640}) {
      RoomPicture picture = PictureOfBall(radius, RoomSurface::kMirror, width);
      ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
      const BallComparison ball = CompareBall(picture.frame.reflection, picture);
      EXPECT_GT(ball.pixels, 500);
      EXPECT_GT(ball.found, 0.99 * ball.pixels) << radius << " " << width;
      EXPECT_GT(ball.right, 0.9 * ball.pixels) << radius << " " << width;
      EXPECT_GT(ball.inner, 0.75 * ball.pixels) << radius << " " << width;
      EXPECT_GT(ball.moved, 0.95 * ball.inner) << radius << " " << width;
      EXPECT_EQ(Shown(picture, picture.frame.reflection), ball.found);
      EXPECT_EQ(Shown(picture, picture.frame.refraction), 0);
    }
  }
}

// Neither moves the image as the ball's surface does, nor as a point at its depth would.
TEST(SetSeenGuides, ImagesInABallMoveOtherwiseThanTheBall) {
  const RoomPicture picture = PictureOfBall(1.2, RoomSurface::kMirror, 160);
  const Image2& surface = picture.frame.guides.motion;
  const VirtualGuides& e = picture.curved;
  const int shown = Count(picture, [&](int x, int y) { return e.depth(x, y) > 0; });
  const int apart = Count(picture, [&](int x, int y) {
    return e.depth(x, y) > 0 && std::abs(e.motion[0](x, y) - surface[0](x, y)) > 0.6f;
  });
  EXPECT_GT(apart, 0.5 * shown);
}

/// Reflected light, as much in each pixel.
void AddReflectedLight(float light, Frame* frame) {
  frame->signals.push_back(
      {SignalKind::kDirectSpecular, Image3(frame->width, frame->height), Image1()});
  Image3& radiance = frame->signals.back().radiance;
  for (int c = 0; c < 3; ++c) {
    radiance[c].Fill(light);
  }
}

// The albedo of a lamp contains what it emits, unless the light says that it is something else.
TEST(SetSeenGuides, ALampInAMirrorHasItsRadianceAsAlbedo) {
  for (const double radius : {0.0, 1.2}) {  // a planar mirror, a ball
    const Room room = radius > 0 ? RoomWithBall(radius, RoomSurface::kMirror) : RoomWithMirror();
    RoomOptions options;
    options.outliers = 0;
    for (const float light : {20.0f, 0.5f}) {
      RoomPicture picture = Picture(room, options);
      AddReflectedLight(light, &picture.frame);
      for (int c = 0; c < 3; ++c) {
        picture.seen.albedo[c].Fill(9);
      }
      ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
      const VirtualGuides& g = picture.frame.reflection;
      EXPECT_GT(Shown(picture, g), 2000);
      const float expected = light > 1 ? 9 / 0.8f : 1.0f;  // of the mirror's green
      EXPECT_EQ(Count(picture,
                      [&](int x, int y) {
                        return g.depth(x, y) > 0 &&
                               std::abs(g.albedo[1](x, y) / expected - 1) > 0.01f;
                      }),
                0)
          << radius << " " << light;
      // Nothing beside it is on the same surface.
      const VirtualGuides& plain = radius > 0 ? picture.curved : picture.expected;
      const int turned = Count(picture, [&](int x, int y) {
        return dot(VectorAt(g.normal, x, y), VectorAt(plain.normal, x, y)) < -0.99f;
      });
      EXPECT_EQ(turned > 1000, light > 1) << radius << " " << light;
    }
  }
}

TEST(SetSeenGuides, AGlassBallHasTheGuidesOfWhatIsSeenThroughIt) {
  RoomPicture picture = PictureOfBall(1.2, RoomSurface::kPane, 160);
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  const VirtualGuides& g = picture.frame.refraction;
  const BallComparison ball = CompareBall(g, picture);
  EXPECT_GT(ball.pixels, 2000);
  EXPECT_GT(ball.found, 0.85 * ball.pixels);  // without the outline
  EXPECT_LT(ball.found, ball.pixels);
  EXPECT_GT(ball.right, 0.9 * ball.found);
  EXPECT_EQ(Shown(picture, picture.frame.reflection), 0);
  EXPECT_EQ(Count(picture,
                  [&](int x, int y) {
                    return g.depth(x, y) > 0 &&
                           g.motion[0](x, y) != picture.frame.guides.motion[0](x, y);
                  }),
            0);
}

TEST(SetSeenGuides, ARoughBallHasNone) {
  RoomPicture picture = PictureOfBall(1.2, RoomSurface::kRough, 160);
  EXPECT_GT(Count(picture, [&](int x, int y) { return picture.what(x, y) == 4; }), 2000);
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  EXPECT_EQ(Shown(picture, picture.frame.reflection), 0);
}

TEST(SetSeenGuides, WithoutMirrorsThereAreNone) {
  RoomPicture picture = Picture(EmptyRoom());
  ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone);
  EXPECT_EQ(Shown(picture, picture.frame.reflection), 0);
  EXPECT_EQ(Shown(picture, picture.frame.refraction), 0);
}

bool IsFiniteAndUnit(const VirtualGuides& g, int x, int y) {
  const vec3 normal = VectorAt(g.normal, x, y);
  const vec3 albedo = VectorAt(g.albedo, x, y);
  const bool sky = std::isinf(g.depth(x, y));
  return !std::isnan(g.depth(x, y)) && std::isfinite(g.motion[0](x, y) + g.motion[1](x, y)) &&
         (sky || std::abs(glm::length(normal) - 1) < 1e-5f) &&
         std::min({albedo.x, albedo.y, albedo.z}) > 0 &&
         std::max({albedo.x, albedo.y, albedo.z}) <= 1;
}

constexpr float kInvalid[] = {std::numeric_limits<float>::quiet_NaN(), kInf, -kInf, -3.0f, 3e38f};

/// Sets one layer of every twentieth pixel to a value.
void Spoil(float value, RoomPicture* picture) {
  SeenLayers& seen = picture->seen;
  ForEachPixel(*picture, [&](int x, int y) {
    const int kind = (x * 7 + y * 13) % 60;
    if (kind == 0) {
      seen.depth(x, y) = value;
    } else if (kind == 1) {
      seen.normal[y % 3](x, y) = value;
    } else if (kind == 2) {
      seen.albedo[y % 3](x, y) = value;
    }
  });
}

TEST(SetSeenGuides, InvalidValuesDoNoHarm) {
  for (const float value : kInvalid) {
    RoomPicture picture = Picture(RoomWithMirror());
    Spoil(value, &picture);
    ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone) << value;
    const VirtualGuides& g = picture.frame.reflection;
    const Comparison reflection = Compare(g, picture);
    EXPECT_GT(reflection.right, 0.9 * reflection.expected) << value;
    EXPECT_EQ(Count(picture,
                    [&](int x, int y) { return g.depth(x, y) != 0 && !IsFiniteAndUnit(g, x, y); }),
              0)
        << value;
  }
}

TEST(SetSeenGuides, InvalidValuesInABallDoNoHarm) {
  for (const RoomSurface surface : {RoomSurface::kMirror, RoomSurface::kPane}) {
    for (const float value : kInvalid) {
      RoomPicture picture = PictureOfBall(1.2, surface, 160);
      Spoil(value, &picture);
      ASSERT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kNone) << value;
      const bool mirror = surface == RoomSurface::kMirror;
      const VirtualGuides& g = mirror ? picture.frame.reflection : picture.frame.refraction;
      const BallComparison ball = CompareBall(g, picture);
      EXPECT_GT(ball.right, 0.75 * ball.pixels) << value << " " << mirror;
      EXPECT_EQ(
          Count(picture,
                [&](int x, int y) { return g.depth(x, y) != 0 && !IsFiniteAndUnit(g, x, y); }),
          0)
          << value << " " << mirror;
    }
  }
}

TEST(SetSeenGuides, NamesWhatDoesNotFit) {
  const RoomPicture picture = Picture(RoomWithMirror());
  RoomPicture broken = picture;
  ForEachPixel(picture, [&](int x, int y) {
    broken.seen.depth(x, y) = static_cast<float>(1 + (x * 37 + y * 91) % 19);
  });
  EXPECT_EQ(SetSeen(broken.seen, &broken.frame), NoSeenGuides::kLens);
  broken = picture;
  broken.seen.normal = Image3(160, 120);
  EXPECT_EQ(SetSeen(broken.seen, &broken.frame), NoSeenGuides::kNormal);
  broken = picture;
  ForEachPixel(picture, [&](int x, int y) {
    broken.frame.guides.motion[0](x, y) = static_cast<float>((x * 37 + y * 91) % 19);
  });
  EXPECT_EQ(SetSeen(broken.seen, &broken.frame), NoSeenGuides::kMotion);
  EXPECT_EQ(Shown(broken, broken.frame.reflection), 0);
}

/// The left half of what is no mirror has another normal, as by a normal map.
void TiltLeftHalf(RoomPicture* picture) {
  const glm::dvec3 up(0, 1, 0);
  const vec3 in_camera(Now().InCamera(Now().position + up));
  ForEachPixel(*picture, [&](int x, int y) {
    if (x < 80 && picture->what(x, y) == static_cast<uint32_t>(RoomSurface::kMatt) + 1) {
      for (int c = 0; c < 3; ++c) {
        picture->frame.guides.normal[c](x, y) = static_cast<float>(up[c]);
        picture->seen.normal[c](x, y) = in_camera[c];
      }
    }
  });
}

// A mirror on a wall that fills the picture.
TEST(SetSeenGuides, OnePlaneTellsNoMotion) {
  Room room = RoomWithMirror();
  room.rectangles = {{{-50, -50, 12.5},
                      {100, 0, -15},
                      {0, 100, 0},
                      RoomSurface::kMatt,
                      glm::dvec3(0.5),
                      glm::dvec3(0.0)},
                     {{-50, -50, -6},
                      {100, 0, 0},
                      {0, 100, 0},
                      RoomSurface::kMatt,
                      glm::dvec3(0.5),
                      glm::dvec3(0.0)},
                     room.rectangles.back()};
  RoomRectangle& mirror = room.rectangles.back();  // on the wall in front
  mirror.corner = {-1, 0.5, 12.5 - 49 * 0.15 - 1e-4};
  mirror.a = {3.2, 0, -3.2 * 0.15};
  mirror.b = {0, 2, 0};
  RoomPicture picture = Picture(room);
  RoomPicture still = Trace(room, Now(), Now());
  TiltLeftHalf(&picture);
  TiltLeftHalf(&still);
  EXPECT_EQ(SetSeen(picture.seen, &picture.frame), NoSeenGuides::kOnePlane);
  EXPECT_EQ(Shown(picture, picture.frame.reflection), 0);
  EXPECT_EQ(SetSeen(still.seen, &still.frame), NoSeenGuides::kNone);
  EXPECT_GT(Shown(still, still.frame.reflection), 500);
}

/// Images that move with the camera of known matrices, although everything but mirrors moves.
/// \param picture  [in,out]
void SetSeenOfKnownCamera(RoomPicture* picture) {
  Frame& frame = picture->frame;
  ForEachPixel(*picture, [&](int x, int y) {
    const uint32_t what = picture->what(x, y);
    if (what != static_cast<uint32_t>(RoomSurface::kMirror) + 1) {
      frame.guides.motion[0](x, y) = static_cast<float>((x * 37 + y * 91) % 19);
    }
  });
  CameraFits fits(frame.guides);
  EXPECT_FALSE(fits.Motion().has_value());
  FrameImages images;
  SetSeenGuides(picture->seen, &frame, &images);
  EXPECT_EQ(images.missing, NoSeenGuides::kNone);
  const std::optional<CameraMotion> camera =
      MotionOfCamera(MatricesOf(Now(), frame.width, frame.height),
                     MatricesOf(Before(), frame.width, frame.height), frame.width, frame.height);
  ASSERT_TRUE(camera.has_value());
  SetImageMotion(images.reflection, images.lens, *camera, &fits, frame.guides, &frame.reflection);
}

TEST(SetImageMotion, KnownCamerasMoveWhatPlanarMirrorsShow) {
  RoomOptions options;
  options.outliers = 0;
  RoomPicture picture = Picture(RoomWithMirror(), options);
  SetSeenOfKnownCamera(&picture);
  const Comparison reflection = Compare(picture.frame.reflection, picture);
  EXPECT_GT(reflection.found, 2000);
  EXPECT_GT(reflection.right, 0.985 * reflection.found);
}

TEST(SetImageMotion, KnownCamerasMoveWhatBallsShow) {
  RoomPicture picture = PictureOfBall(0.8, RoomSurface::kMirror, 160);
  SetSeenOfKnownCamera(&picture);
  const BallComparison ball = CompareBall(picture.frame.reflection, picture);
  EXPECT_GT(ball.inner, 500);
  EXPECT_GT(ball.moved, 0.95 * ball.inner);
}

}  // namespace
}  // namespace stillray::io::seen_guides_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Reflections and refractions that follow the guides of virtual images (VirtualGuides).
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"
#include "stillray/two_way.hpp"

namespace stillray::virtual_guides_test {
namespace {

using test::Denoised;
using test::Light;
using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::MakeWall;
using test::Random;
using test::SameBits;
using testing::HasSubstr;

constexpr int kWidth = 64;
constexpr int kHeight = 40;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// The surface's own guides as those of an image.
VirtualGuides OwnGuides(const Frame& f) {
  VirtualGuides guides;
  guides.depth = f.guides.depth;
  guides.normal = f.guides.normal;
  guides.motion = f.guides.motion;
  guides.id = f.guides.id;
  return guides;
}

std::vector<Frame> BusyFrames(int count) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) {
    frames.push_back(MakeBusyFrame(kWidth, kHeight, i));
    frames.back().guides.roughness = Image1();
  }
  return frames;
}

// A wall with a mirror, behind whose plane a checkerboard moves by kSpeed pixels per frame.
constexpr float kSpeed = 0.7f;

float Checker(float x, int y) {
  return (static_cast<int>(std::floor(x / 6)) + y / 6) % 2 == 0 ? 1.0f : 0.2f;
}

float SeenAt(int x, int y, int64_t frame) {
  return Checker(static_cast<float>(x) + 600.0f - kSpeed * static_cast<float>(frame), y);
}

Frame MakeMirror(int64_t index, bool with_guides) {
  Frame f = MakeWall(kWidth, kHeight, index);
  f.guides.roughness.Fill(0);
  for (int c = 0; c < 3; ++c) {
    f.guides.specular_albedo[c].Fill(1);
  }
  test::FillImage<3>(&Light(&f, SignalKind::kIndirectSpecular), [&](int x, int y, int) {
    const auto pixel = static_cast<uint32_t>(y * kWidth + x);
    const float noise = Random(static_cast<uint32_t>(index), pixel, 5) < 0.25f ? 4.0f : 0.0f;
    return noise * SeenAt(x, y, index);
  });
  if (!with_guides) {
    return f;
  }
  f.reflection.depth = Image1(kWidth, kHeight);
  f.reflection.depth.Fill(12);
  f.reflection.normal = f.guides.normal;
  f.reflection.motion = Image2(kWidth, kHeight);
  f.reflection.motion[0].Fill(-kSpeed);
  f.reflection.albedo = Image3(kWidth, kHeight);
  test::FillImage<3>(&f.reflection.albedo, [&](int x, int y, int) { return SeenAt(x, y, index); });
  return f;
}

std::vector<Frame> MirrorFrames(int count, bool with_guides) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) {
    frames.push_back(MakeMirror(i, with_guides));
  }
  return frames;
}

double ErrorInMirror(const Image3& image, int64_t frame) {
  double sum = 0;
  for (int y = 8; y < kHeight - 8; ++y) {
    for (int x = 16; x < kWidth - 8; ++x) {
      const double d = static_cast<double>(image[1](x, y) - SeenAt(x, y, frame));
      sum += d * d;
    }
  }
  return sum / ((kHeight - 16) * (kWidth - 24));
}

TEST(VirtualGuides, ThoseOfTheSurfaceItselfChangeNoBit) {
  const std::vector<Frame> without = BusyFrames(5);
  std::vector<Frame> with = without;
  for (Frame& f : with) {
    f.reflection = OwnGuides(f);
  }
  Settings settings;
  settings.limit_history = false;   // for which noise in images differs
  settings.restore_energy = false;  // which includes reflected light under guides of images
  EXPECT_TRUE(SameBits(Denoised(settings, with), Denoised(settings, without)));
}

TEST(VirtualGuides, OtherPresetsAndRoughSurfacesIgnoreThem) {
  const auto frames = [](bool with) {
    std::vector<Frame> made = MirrorFrames(3, with);
    for (Frame& f : made) {
      f.guides.roughness.Fill(0.6f);
    }
    return made;
  };
  for (const char* preset : {"svgf", "psvgf", "eaw", "temporal", "default"}) {
    const Settings settings = PresetSettings(preset).value();
    EXPECT_TRUE(SameBits(Denoised(settings, frames(true)), Denoised(settings, frames(false))))
        << preset;
  }
  const std::vector<Frame> smooth = MirrorFrames(3, true);
  EXPECT_FALSE(
      SameBits(Denoised(Settings(), smooth), Denoised(Settings(), MirrorFrames(3, false))));
  Settings off;
  off.virtual_roughness = 0;
  EXPECT_TRUE(SameBits(Denoised(off, smooth), Denoised(off, MirrorFrames(3, false))));
}

TEST(VirtualGuides, WhatAMirrorShowsIsSharpAndDoesNotLag) {
  constexpr int kFrames = 24;
  const double with = ErrorInMirror(Denoised(Settings(), MirrorFrames(kFrames, true)), kFrames - 1);
  const double without =
      ErrorInMirror(Denoised(Settings(), MirrorFrames(kFrames, false)), kFrames - 1);
  EXPECT_LT(with, 0.01);
  EXPECT_LT(with, 0.1 * without);
}

// The surface's own guides, with the motion of the image.
TEST(VirtualGuides, WhatARoughSurfaceReflectsDoesNotLag) {
  constexpr int kFrames = 24;
  std::vector<Frame> frames = MirrorFrames(kFrames, true);
  for (Frame& f : frames) {
    f.guides.roughness.Fill(0.3f);
    f.reflection.albedo = Image3();
  }
  Settings with_surface;
  with_surface.virtual_motion_roughness = 0;
  const double with = ErrorInMirror(Denoised(Settings(), frames), kFrames - 1);
  const double without = ErrorInMirror(Denoised(with_surface, frames), kFrames - 1);
  EXPECT_LT(with, 0.6 * without);
}

TEST(VirtualGuides, RoughSurfacesThatDoNotMoveKeepTheirBits) {
  std::vector<Frame> frames = MirrorFrames(4, true);
  for (Frame& f : frames) {
    f.guides.roughness.Fill(0.3f);
    f.reflection.motion = f.guides.motion;
  }
  Settings with_surface;
  with_surface.virtual_motion_roughness = 0;
  EXPECT_TRUE(SameBits(Denoised(Settings(), frames), Denoised(with_surface, frames)));
}

TEST(VirtualGuides, EdgesOfTheImageStayWhole) {
  // Noise-free light of two walls in the mirror: nothing crosses the edge between them.
  Frame f = MakeMirror(0, true);
  f.reflection.albedo = Image3();
  test::FillImage(&f.reflection.depth, [](int x, int) { return x < 30 ? 9.0f : 20.0f; });
  test::FillImage<3>(&Light(&f, SignalKind::kIndirectSpecular),
                     [](int x, int, int) { return x < 30 ? 1.0f : 5.0f; });
  const Image3 out = Denoised(Settings(), {f, f, f});
  for (int x = 0; x < kWidth; ++x) {
    EXPECT_NEAR(out[0](x, 20), x < 30 ? 1 : 5, 1e-4) << x;
  }
}

/// Bright lines a third of a pixel wide. \param x  from the left edge, pixels
float ThinLines(float x) {
  return std::fmod(x, 3.7f) < 1.0f / 3 ? 1.0f : 0.1f;
}

/// The lines in a mirror or on the wall itself; every frame has one point of each pixel. Without
/// noise.
Frame MakeThinLines(int64_t index, bool in_mirror) {
  Frame f = MakeWall(kWidth, kHeight, index);
  f.jitter_x = static_cast<float>((index * 5) % 16) / 16 - 0.46875f;
  Image3 texture(kWidth, kHeight);
  test::FillImage<3>(&texture, [&](int x, int, int) {
    return ThinLines(static_cast<float>(x) + 0.5f + f.jitter_x);
  });
  for (int c = 0; c < 3; ++c) {
    f.guides.albedo[c].Fill(0);
    f.guides.specular_albedo[c].Fill(in_mirror ? 0.9f : 0.0f);
  }
  if (in_mirror) {
    f.guides.roughness.Fill(0);
    f.reflection = OwnGuides(f);
    f.reflection.depth.Fill(10);
    f.reflection.albedo = texture;
  } else {
    f.guides.albedo = texture;
  }
  Image3& light =
      Light(&f, in_mirror ? SignalKind::kIndirectSpecular : SignalKind::kIndirectDiffuse);
  test::FillImage<3>(&light, [&](int x, int y, int c) { return texture[c](x, y) * 0.9f; });
  return f;
}

/// Root mean square error of the last of 40 frames, against the mean over the area of each pixel.
double ErrorOfThinLines(bool in_mirror) {
  std::vector<Frame> frames;
  for (int64_t i = 0; i < 40; ++i) {
    frames.push_back(MakeThinLines(i, in_mirror));
  }
  const Image3 picture = Denoised(PresetSettings("default").value(), frames);
  constexpr int kPoints = 64;  // of a pixel
  double sum = 0;
  for (int x = 8; x < kWidth - 8; ++x) {
    double mean = 0;
    for (int i = 0; i < kPoints; ++i) {
      const float at = static_cast<float>(x) + (static_cast<float>(i) + 0.5f) / kPoints;
      mean += 0.9 / kPoints * static_cast<double>(ThinLines(at));
    }
    sum += std::pow(static_cast<double>(picture[1](x, kHeight / 2)) - mean, 2);
  }
  return std::sqrt(sum / (kWidth - 16));
}

// The rays of most frames miss them: clamped to the light of one frame they would vanish.
TEST(VirtualGuides, ThinLinesInAMirrorAreAsOnAWall) {
  const double on_wall = ErrorOfThinLines(false);
  EXPECT_LT(on_wall, 0.06);
  EXPECT_LT(ErrorOfThinLines(true), 1.2 * on_wall);
}

/// A white bar that moves by three pixels per frame in a mirror, before a black wall.
Frame MakeBarInMirror(int index) {
  const auto is_bar = [&](int x) { return x >= 3 * index - 9 && x < 3 * index; };
  Frame f = MakeThinLines(index, true);
  f.jitter_x = 0.25f * static_cast<float>(index % 4) - 0.375f;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      f.reflection.depth(x, y) = is_bar(x) ? 8.0f : 10.0f;
      f.reflection.motion[0](x, y) = is_bar(x) ? -3.0f : 0.0f;
      for (int c = 0; c < 3; ++c) {
        f.reflection.albedo[c](x, y) = is_bar(x) ? 0.9f : 0.1f;
      }
    }
  }
  test::FillImage<3>(&Light(&f, SignalKind::kIndirectSpecular),
                     [&](int x, int y, int c) { return 0.9f * f.reflection.albedo[c](x, y); });
  return f;
}

TEST(VirtualGuides, WhatMovesInAMirrorLeavesNoTrail) {
  constexpr int kLast = 12;
  std::vector<Frame> frames;
  for (int i = 0; i <= kLast; ++i) {
    frames.push_back(MakeBarInMirror(i));
  }
  const Image3 picture = Denoised(PresetSettings("default").value(), frames);
  for (int x = 3; x < kWidth - 3; ++x) {
    if (x < 3 * kLast - 10 || x > 3 * kLast) {  // the wall, but for one pixel at each edge
      EXPECT_NEAR(picture[1](x, kHeight / 2), 0.09f, 0.005f) << x;
    }
  }
}

// As in a glass ball before a moving box: nothing of what it showed before is in the picture.
TEST(VirtualGuides, ImagesThatWereOutOfSightBeginAnew) {
  const float bright[] = {0.8f, 0.2f, 0.5f};
  std::vector<Frame> frames;
  for (int i = 0; i < 12; ++i) {
    Frame f = MakeBarInMirror(i);
    f.reflection.motion[0].Fill(2 * kWidth);
    for (int c = 0; c < 3; ++c) {
      f.reflection.albedo[c].Fill(bright[i % 3]);
      Light(&f, SignalKind::kIndirectSpecular)[c].Fill(0.9f * bright[i % 3]);
    }
    frames.push_back(std::move(f));
  }
  for (const TaaFilter filter : {TaaFilter::kSubcell, TaaFilter::kSpline, TaaFilter::kCatmullRom}) {
    Settings settings = PresetSettings("default").value();
    settings.taa_filter = filter;
    const Image3 picture = Denoised(settings, frames);
    for (int x = 3; x < kWidth - 3; ++x) {
      EXPECT_NEAR(picture[1](x, kHeight / 2), 0.9f * bright[11 % 3], 0.001f) << x;
    }
  }
}

TEST(VirtualGuides, TheSkyInAMirrorIsLightLikeOther) {
  Frame f = MakeMirror(0, true);
  f.reflection.depth.Fill(kInfinity);
  f.reflection.normal = Image3();
  f.reflection.albedo = Image3();
  test::FillImage<3>(&Light(&f, SignalKind::kIndirectSpecular),
                     [](int, int, int c) { return 1.0f + static_cast<float>(c); });
  const Image3 out = Denoised(Settings(), {f, f});
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(out[c](30, 20), 1 + c, 1e-4);
  }
}

TEST(VirtualGuides, InvalidValuesAreNotUsed) {
  std::vector<Frame> frames = MirrorFrames(4, true);
  for (Frame& f : frames) {
    for (int y = 0; y < kHeight; ++y) {
      f.reflection.depth(y, y) = kNan;
      f.reflection.depth(y + 1, y) = -2;
      f.reflection.normal[0](y + 2, y) = kNan;
      f.reflection.albedo[0](y + 3, y) = kNan;
      f.reflection.albedo[1](y + 4, y) = -kInfinity;
      f.reflection.motion[0](y + 5, y) = kNan;
    }
  }
  const Image3 out = Denoised(Settings(), frames);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_TRUE(std::isfinite(out[c](x, y))) << x << ", " << y;
      }
    }
  }
  EXPECT_LT(ErrorInMirror(out, 3), 0.1);
}

TEST(VirtualGuides, TransmittedLightHasItsOwn) {
  // A pane: transmitted light follows the world behind it, reflected light the pane.
  const auto frames = [](bool with) {
    std::vector<Frame> made = MirrorFrames(16, with);
    for (Frame& f : made) {
      Signal& signal = f.signals[static_cast<size_t>(SignalKind::kIndirectSpecular)];
      signal.kind = SignalKind::kIndirectTransmission;
      f.guides.transmission_albedo = f.guides.specular_albedo;
      f.refraction = std::move(f.reflection);
      f.reflection = VirtualGuides();
    }
    return made;
  };
  const double with = ErrorInMirror(Denoised(Settings(), frames(true)), 15);
  const double without = ErrorInMirror(Denoised(Settings(), frames(false)), 15);
  EXPECT_LT(with, 0.02);
  EXPECT_LT(with, 0.2 * without);
}

TEST(VirtualGuides, SavedHistoriesContinueWithTheSameBits) {
  const std::vector<Frame> frames = MirrorFrames(6, true);
  const Image3 expected = Denoised(Settings(), frames);
  Denoiser first = MakeDenoiser(Settings());
  DenoisedFrame out;
  for (size_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(first.Denoise(frames[i], &out).ok());
  }
  const Result<std::vector<uint8_t>> saved = first.SaveHistory();
  ASSERT_TRUE(saved.ok());
  Denoiser second = MakeDenoiser(Settings());
  ASSERT_TRUE(second.RestoreHistory(*saved).ok());
  for (size_t i = 3; i < frames.size(); ++i) {
    ASSERT_TRUE(second.Denoise(frames[i], &out).ok());
  }
  EXPECT_TRUE(SameBits(out.colour, expected));

  Settings off;
  off.virtual_roughness = 0;
  const Status status = MakeDenoiser(off).RestoreHistory(*saved);
  EXPECT_EQ(status.code(), StatusCode::kBadData);
  EXPECT_THAT(status.message(), HasSubstr("virtual guides"));
}

TEST(VirtualGuides, FramesWithoutThemBeginANewHistory) {
  std::vector<Frame> frames = MirrorFrames(4, true);
  frames[2] = MakeMirror(2, false);
  frames[3] = MakeMirror(3, false);
  const std::vector<Frame> last(frames.begin() + 2, frames.end());
  EXPECT_TRUE(SameBits(Denoised(Settings(), frames), Denoised(Settings(), last)));
}

TEST(VirtualGuides, TheFutureOfMirrorsIsFoundToo) {
  constexpr int kFrames = 12;
  Result<TwoWayDenoiser> denoiser = TwoWayDenoiser::Create(Settings());
  ASSERT_TRUE(denoiser.ok());
  for (Frame& f : MirrorFrames(kFrames, true)) {
    const Status pushed = denoiser->Push(std::move(f));
    ASSERT_TRUE(pushed.ok()) << pushed.message();
  }
  denoiser->Finish();
  DenoisedFrame out;
  const Result<bool> pulled = denoiser->Pull(&out);
  ASSERT_TRUE(pulled.ok() && *pulled) << pulled.status().message();
  const double both = ErrorInMirror(out.colour, 0);
  const double alone = ErrorInMirror(Denoised(Settings(), MirrorFrames(1, true)), 0);
  EXPECT_LT(both, 0.001);
  EXPECT_LT(both, 0.6 * alone);
}

TEST(VirtualGuides, ErrorsNameTheImage) {
  const auto message = [](const auto& change) {
    Denoiser denoiser = MakeDenoiser(Settings());
    DenoisedFrame out;
    EXPECT_TRUE(denoiser.Denoise(MakeMirror(0, true), &out).ok());
    Frame f = MakeMirror(1, true);
    change(&f);
    const Status status = denoiser.Denoise(f, &out);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    return status.message();
  };
  EXPECT_THAT(message([](Frame* f) { f->reflection.motion = Image2(); }),
              HasSubstr("'reflection_motion' is missing"));
  EXPECT_THAT(message([](Frame* f) { f->reflection.depth = Image1(); }),
              HasSubstr("'reflection_depth' is missing"));
  EXPECT_THAT(message([](Frame* f) { f->reflection.albedo = Image3(3, 4); }),
              HasSubstr("'reflection_albedo[0]' is 3x4, expected 64x40"));
  EXPECT_THAT(message([](Frame* f) { f->refraction.id = Plane<uint32_t>(kWidth, kHeight); }),
              HasSubstr("'refraction_depth' is missing"));
}

}  // namespace
}  // namespace stillray::virtual_guides_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames of less than one sample per pixel: guides that are filled, light that is kept, feedback
// that waits.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "denoise/fill_guides/fill_guides_shared.h"
#include "denoise/fill_guides/pyramid.h"
#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::sparse_test {
namespace {

using test::FillImage;
using test::Light;
using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::MakeWall;
using test::Random;

constexpr int kWidth = 61;
constexpr int kHeight = 45;

/// The frame of a renderer that traces one pixel of `cycle` per frame, with guides only there.
Frame MakeSparse(Frame f, int cycle, bool sparse_guides) {
  f.samples = Image1(f.width, f.height);
  const auto phase = static_cast<uint32_t>(f.index % cycle);
  for (int y = 0; y < f.height; ++y) {
    for (int x = 0; x < f.width; ++x) {
      const auto pixel = static_cast<uint32_t>(y * f.width + x);
      const auto turn = static_cast<uint32_t>(
          Random(pixel, static_cast<uint32_t>(f.index / cycle), 5) * static_cast<float>(cycle));
      if (turn == phase) {
        f.samples(x, y) = 1;
        continue;
      }
      for (Signal& signal : f.signals) {
        for (int c = 0; c < 3; ++c) {
          signal.radiance[c](x, y) = 0;
        }
      }
      if (sparse_guides) {
        f.guides.depth(x, y) = 0;
        f.guides.id(x, y) = 0;
        for (int c = 0; c < 3; ++c) {
          f.guides.normal[c](x, y) = 0;
          f.guides.albedo[c](x, y) = 0;
          f.guides.specular_albedo[c](x, y) = 0;
          f.emission[c](x, y) = 0;
          f.background[c](x, y) = 0;
        }
        for (int c = 0; c < 2; ++c) {
          f.guides.motion[c](x, y) = 0;
        }
      }
    }
  }
  return f;
}

Frame MakeLitWall(int64_t index, float radiance) {
  Frame f = MakeWall(kWidth, kHeight, index);
  FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse),
               [&](int, int, int c) { return radiance * (1.0f + 0.5f * static_cast<float>(c)); });
  return f;
}

TEST(FillGuides, ParentsOfTheThreeChildren) {
  // (x + 1/2) / 3 - 1/2: x = 3 lies 1/3 of the way from cell 0 to cell 1, plus 1/3 more.
  EXPECT_EQ(FirstParent(3), 0);
  EXPECT_FLOAT_EQ(SecondParentWeight(3), 2.0f / 3.0f);
  EXPECT_EQ(FirstParent(4), 1);
  EXPECT_FLOAT_EQ(SecondParentWeight(4), 0.0f);
  EXPECT_EQ(FirstParent(5), 1);
  EXPECT_FLOAT_EQ(SecondParentWeight(5), 1.0f / 3.0f);
}

TEST(FillGuides, HandWorkedRow) {
  // Nine pixels, known: 1 at x = 1, 4 at x = 4, nothing in the last three. Level 1: 1, 4, hole.
  // Level 2: mean 2.5, which fills the hole. Downward: x = 3 is 1/3 * 1 + 2/3 * 4 = 3.
  Image1 known(9, 1);
  Image1 plane(9, 1);
  known(1, 0) = known(4, 0) = 1;
  plane(1, 0) = 1;
  plane(4, 0) = 4;
  ASSERT_TRUE(reference::FillHoles(known, &plane));
  const float expected[] = {1, 1, 2, 3, 4, 3.5f, 3, 2.5f, 2.5f};
  for (int x = 0; x < 9; ++x) {
    EXPECT_NEAR(plane(x, 0), expected[x], 1e-6f) << x;
  }
}

TEST(FillGuides, KnownStaysAndConstantsStay) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 7}, {61, 45}, {81, 3}, {100, 100}}) {
    Image1 known(width, height);
    FillImage(&known, [&](int x, int y) {
      return Random(static_cast<uint32_t>(x), static_cast<uint32_t>(y), 3) < 0.03f ? 1.0f : 0.0f;
    });
    known(width / 2, height / 2) = 1;
    Image1 a(width, height);
    Image1 constant(width, height);
    constant.Fill(7.25f);
    FillImage(&a, [&](int x, int y) {
      return Random(static_cast<uint32_t>(x), static_cast<uint32_t>(y), 9);
    });
    const Image1 before = a;
    Plane<uint32_t> ids(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        ids(x, y) = known(x, y) > 0 ? static_cast<uint32_t>(1 + x + 1000 * y) : 0u;
      }
    }
    ASSERT_TRUE(reference::FillHoles(known, &a));
    ASSERT_TRUE(reference::FillHoles(known, &constant));
    ASSERT_TRUE(reference::FillIds(known, &ids));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        EXPECT_FLOAT_EQ(constant(x, y), 7.25f);
        EXPECT_NE(ids(x, y), 0u);
        if (known(x, y) > 0) {
          EXPECT_EQ(a(x, y), before(x, y));
        }
      }
    }
  }
}

TEST(FillGuides, NothingKnownIsSaid) {
  const Image1 known(8, 8);
  Image1 plane(8, 8);
  EXPECT_FALSE(reference::FillHoles(known, &plane));
}

TEST(Sparse, ConstantLightStaysConstant) {
  for (const std::string_view preset : {"default", "psvgf", "svgf", "temporal"}) {
    for (const bool sparse_guides : {false, true}) {
      Denoiser d = MakeDenoiser(PresetSettings(preset).value());
      DenoisedFrame out;
      for (int i = 0; i < 40; ++i) {
        ASSERT_TRUE(d.Denoise(MakeSparse(MakeLitWall(i, 0.8f), 16, sparse_guides), &out).ok());
      }
      for (int c = 0; c < 3; ++c) {
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            EXPECT_NEAR(out.colour[c](x, y), 0.8f * (1.0f + 0.5f * static_cast<float>(c)), 2e-3f)
                << preset << " " << sparse_guides << " " << x << " " << y;
          }
        }
      }
    }
  }
}

TEST(Sparse, MissingPixelsKeepLightMomentsAndAge) {
  Settings s = PresetSettings("psvgf").value();
  s.feedback = 0;
  Denoiser d = MakeDenoiser(s);
  ASSERT_TRUE(d.SetOutputs({"history", "moment_mean", "moment_variance", "accumulated"}).ok());
  DenoisedFrame before;
  DenoisedFrame after;
  for (int i = 0; i < 9; ++i) {
    Frame f = MakeWall(kWidth, kHeight, i);
    FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
      return Random(static_cast<uint32_t>(i), static_cast<uint32_t>(x), static_cast<uint32_t>(y));
    });
    ASSERT_TRUE(d.Denoise(f, &before).ok());
  }
  const Frame sparse = MakeSparse(MakeLitWall(9, 5.0f), 8, false);
  ASSERT_TRUE(d.Denoise(sparse, &after).ok());
  int touched = 0;
  for (size_t image = 0; image < after.images.size(); ++image) {
    for (size_t c = 0; c < after.images[image].channels.size(); ++c) {
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const float was = before.images[image].channels[c](x, y);
          const float is = after.images[image].channels[c](x, y);
          if (sparse.samples(x, y) == 0) {
            EXPECT_EQ(was, is) << after.images[image].name;
          } else {
            touched += was != is;
          }
        }
      }
    }
  }
  EXPECT_GT(touched, 100);
}

TEST(Sparse, AgeCountsSamplesNotFrames) {
  Denoiser d = MakeDenoiser(PresetSettings("psvgf").value());
  ASSERT_TRUE(d.SetOutputs({"history.light"}).ok());
  DenoisedFrame out;
  Image1 received(kWidth, kHeight);
  for (int i = 0; i < 50; ++i) {
    const Frame f = MakeSparse(MakeLitWall(i, 1.0f), 10, true);
    FillImage(&received, [&](int x, int y) { return received(x, y) + f.samples(x, y); });
    ASSERT_TRUE(d.Denoise(f, &out).ok());
  }
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_EQ(out.images[0].channels[0](x, y), received(x, y)) << x << " " << y;
    }
  }
}

TEST(Sparse, HeldGuidesOfAStillViewBecomeExact) {
  // A wall with a step in depth, normal and albedo: once every pixel had its path, the edge is as
  // sharp as with full guides.
  const auto scene = [](int64_t i) {
    Frame f = MakeLitWall(i, 1.0f);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 30; x < kWidth; ++x) {
        f.guides.depth(x, y) = 2;
        f.guides.id(x, y) = 2;
        f.guides.normal[2](x, y) = 0;
        f.guides.normal[0](x, y) = 1;
        for (int c = 0; c < 3; ++c) {
          f.guides.albedo[c](x, y) = 0.1f;
          Light(&f, SignalKind::kDirectDiffuse)[c](x, y) = 0.2f;
        }
      }
    }
    return f;
  };
  Settings s = PresetSettings("psvgf").value();
  s.antialias = Antialias::kOff;
  s.fxaa = Fxaa::kOff;
  Denoiser sparse = MakeDenoiser(s);
  DenoisedFrame out;
  for (int i = 0; i < 24; ++i) {
    ASSERT_TRUE(sparse.Denoise(MakeSparse(scene(i), 8, true), &out).ok());
  }
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_NEAR(out.colour[0](x, y), x < 30 ? 1.0f : 0.2f, 1e-3f) << x << " " << y;
    }
  }
}

TEST(Sparse, NoGhostOfAnObjectThatLeft) {
  // A bright object crosses the picture; some frames later nothing of it may be left behind it.
  const auto scene = [](int64_t i) {
    Frame f = MakeLitWall(i, 0.2f);
    const int left = 2 + static_cast<int>(i);
    for (int y = 10; y < 35; ++y) {
      for (int x = left; x < std::min(left + 12, kWidth); ++x) {
        f.guides.depth(x, y) = 2;
        f.guides.id(x, y) = 2;
        f.guides.motion[0](x, y) = -1;
        for (int c = 0; c < 3; ++c) {
          Light(&f, SignalKind::kDirectDiffuse)[c](x, y) = 5.0f;
        }
      }
    }
    return f;
  };
  Denoiser d = MakeDenoiser(PresetSettings("default").value());
  DenoisedFrame out;
  for (int i = 0; i < 44; ++i) {
    ASSERT_TRUE(d.Denoise(MakeSparse(scene(i), 8, true), &out).ok());
  }
  double trail = 0;
  for (int y = 12; y < 33; ++y) {
    for (int x = 4; x < 30; ++x) {
      trail += out.colour[0](x, y) / (26.0 * 21.0);
    }
  }
  EXPECT_NEAR(trail, 0.2, 0.02);
}

TEST(Sparse, TheFirstFrameHasNeitherHolesNorDots) {
  // One pixel of 32, each with noise as large as the light: pixels filled by one level must be taps
  // of the next, and the luminance weight must not isolate single samples.
  for (const std::string_view preset : {"default", "psvgf"}) {
    Denoiser d = MakeDenoiser(PresetSettings(preset).value());
    Frame f = MakeWall(kWidth, kHeight);
    FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
      return 2.0f * Random(11u, static_cast<uint32_t>(x), static_cast<uint32_t>(y));
    });
    DenoisedFrame out;
    ASSERT_TRUE(d.Denoise(MakeSparse(std::move(f), 32, true), &out).ok());
    double sum = 0;
    double sum2 = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        EXPECT_GT(out.colour[0](x, y), 0.2f) << preset << " " << x << " " << y;
        sum += out.colour[0](x, y);
        sum2 += out.colour[0](x, y) * out.colour[0](x, y);
      }
    }
    const double mean = sum / (kWidth * kHeight);
    // A sample's deviation is 0.58 of the mean.
    EXPECT_LT(std::sqrt(sum2 / (kWidth * kHeight) - mean * mean), 0.3 * mean) << preset;
  }
}

/// Sum over frames of the mean squared change of the picture, at frames that end a cycle and
/// others.
struct Jumps {
  double at_cycle = 0;
  double elsewhere = 0;
};

/// A wall with a soft shadow line, lit by noise, at one pixel of eight per frame.
Frame MakeNoisy(int64_t i) {
  Frame f = MakeWall(kWidth, kHeight, i);
  FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
    const float u = Random(static_cast<uint32_t>(i) * 77 + 1, static_cast<uint32_t>(x),
                           static_cast<uint32_t>(y));
    return (x / 4 % 2 == 0 ? 0.2f : 1.0f) * 2 * u;
  });
  return MakeSparse(std::move(f), 8, false);
}

Settings FeedbackSettings(FeedbackWhen when) {
  Settings s = PresetSettings("psvgf").value();
  s.antialias = Antialias::kOff;
  s.fxaa = Fxaa::kOff;
  s.feedback_when = when;
  return s;
}

TEST(Sparse, FeedbackOfEveryFrameBlursOnAndOnAndDelayedFeedbackDoesNot) {
  // PSVGF section 5: untouched pixels are blurred again in every frame. All samples agree on the
  // stripes, so their contrast is only lost to repeated filtering.
  const auto contrast = [](FeedbackWhen when) {
    Denoiser d = MakeDenoiser(FeedbackSettings(when));
    DenoisedFrame out;
    for (int i = 0; i < 160; ++i) {
      EXPECT_TRUE(d.Denoise(MakeNoisy(i), &out).ok());
    }
    double dark = 0;
    double bright = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < 56; ++x) {
        (x / 4 % 2 == 0 ? dark : bright) += out.colour[0](x, y);
      }
    }
    return (bright - dark) / (bright + dark);
  };
  const double every = contrast(FeedbackWhen::kFrame);
  const double delayed = contrast(FeedbackWhen::kBlend);
  EXPECT_GT(delayed, every + 0.03) << every;
}

TEST(Sparse, DelayedFeedbackJumpsUnlessItIsBlended) {
  const auto jumps = [](FeedbackWhen when) {
    Denoiser d = MakeDenoiser(FeedbackSettings(when));
    DenoisedFrame out;
    Image3 last;
    Jumps j;
    for (int i = 0; i < 96; ++i) {
      EXPECT_TRUE(d.Denoise(MakeNoisy(i), &out).ok());
      double change = 0;
      for (int y = 0; i > 32 && y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const double difference = out.colour[0](x, y) - last[0](x, y);
          change += difference * difference;
        }
      }
      // Fed back at the end of frames 7, 15, ...: seen in the frame after.
      (i % 8 == 0 ? j.at_cycle : j.elsewhere) += change / (i % 8 == 0 ? 1 : 7);
      last = out.colour;
    }
    return j;
  };
  const Jumps without = jumps(FeedbackWhen::kSample);
  const Jumps with = jumps(FeedbackWhen::kBlend);
  EXPECT_GT(without.at_cycle, 1.5 * without.elsewhere);
  EXPECT_LT(with.at_cycle, 1.25 * with.elsewhere);
}

TEST(Sparse, FeedbackWhenIsOneAtAWholeSamplePerPixel) {
  std::vector<Image3> pictures;
  for (const FeedbackWhen when :
       {FeedbackWhen::kFrame, FeedbackWhen::kSample, FeedbackWhen::kBlend}) {
    Denoiser d = MakeDenoiser(FeedbackSettings(when));
    DenoisedFrame out;
    for (int i = 0; i < 5; ++i) {
      Frame f = MakeNoisy(i * 8);
      f.samples = Image1();
      ASSERT_TRUE(d.Denoise(f, &out).ok());
    }
    pictures.push_back(out.colour);
  }
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_EQ(pictures[0][0](x, y), pictures[1][0](x, y));
      EXPECT_EQ(pictures[0][0](x, y), pictures[2][0](x, y));
    }
  }
}

/// Frame i of a sequence in which nothing moves but the light.
Frame MakeStillFrame(int64_t i) {
  Frame f = MakeBusyFrame(kWidth, kHeight, 3);
  f.index = i;
  f.signals = MakeBusyFrame(kWidth, kHeight, i).signals;
  f.guides.motion = Image2(kWidth, kHeight);
  return f;
}

void ExpectVersionsAgree(bool still) {
  for (const std::string_view preset : {"default", "psvgf"}) {
    Settings s = PresetSettings(preset).value();
    s.fxaa = Fxaa::kOff;  // decides at thresholds; one code serves both versions
    Denoiser reference = MakeDenoiser(s, Backend::kReference);
    Denoiser cpu = MakeDenoiser(s);
    Denoiser resumed = MakeDenoiser(s);
    DenoisedFrame expected;
    DenoisedFrame out;
    DenoisedFrame again;
    double error = 0;
    double square = 0;
    int far = 0;
    for (int i = 0; i < 14; ++i) {
      const Frame f =
          MakeSparse(still ? MakeStillFrame(i) : MakeBusyFrame(kWidth, kHeight, i), 4, true);
      ASSERT_TRUE(reference.Denoise(f, &expected).ok());
      ASSERT_TRUE(cpu.Denoise(f, &out).ok());
      if (i == 6) {
        ASSERT_TRUE(resumed.RestoreHistory(cpu.SaveHistory().value()).ok());
      }
      if (i > 6) {
        ASSERT_TRUE(resumed.Denoise(f, &again).ok());
      }
      for (int c = 0; c < 3; ++c) {
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            const double difference = out.colour[c](x, y) - expected.colour[c](x, y);
            ASSERT_TRUE(std::isfinite(difference));
            error += difference * difference;
            far += std::abs(difference) > 0.01 * (std::abs(expected.colour[c](x, y)) + 0.05);
            square += static_cast<double>(expected.colour[c](x, y)) * expected.colour[c](x, y);
            if (i > 6) {
              EXPECT_EQ(out.colour[c](x, y), again.colour[c](x, y)) << i;
            }
          }
        }
      }
    }
    // A tap that one version accepts at a threshold and the other does not changes a few pixels;
    // guides that are guesses have many at thresholds.
    EXPECT_LT(far, 14 * 3 * kWidth * kHeight / 100) << preset;
    EXPECT_LT(std::sqrt(error / square), 0.02) << preset << " " << far;
  }
}

TEST(Sparse, VersionsAgreeAndSavedHistoryGoesOnWithTheSameBits) {
  ExpectVersionsAgree(false);
}

TEST(Sparse, VersionsAgreeInAStillViewToo) {
  ExpectVersionsAgree(true);
}

TEST(Sparse, FramesWithoutAnySampleKeepThePicture) {
  Denoiser d = MakeDenoiser(PresetSettings("psvgf").value());
  DenoisedFrame out;
  Frame nothing = MakeSparse(MakeLitWall(0, 1.0f), 1000, true);
  nothing.samples.Fill(0.0f);
  nothing.guides.depth.Fill(0.0f);
  ASSERT_TRUE(d.Denoise(nothing, &out).ok());  // nothing is known yet
  for (int i = 0; i < 12; ++i) {
    ASSERT_TRUE(d.Denoise(MakeSparse(MakeLitWall(i, 1.0f), 4, true), &out).ok());
  }
  const Image3 before = out.colour;
  ASSERT_TRUE(d.Denoise(nothing, &out).ok());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_NEAR(out.colour[0](x, y), before[0](x, y), 1e-3f);
    }
  }
}

TEST(Fxaa, SmoothsAStaircaseAndKeepsFlatAndStraight) {
  Settings s = PresetSettings("eaw").value();
  s.wavelet = Wavelet::kOff;
  s.temporal = false;
  s.antialias = Antialias::kOff;
  s.demodulate = false;
  const auto picture = [&](Fxaa fxaa, bool slanted) {
    s.fxaa = fxaa;
    Denoiser d = MakeDenoiser(s);
    Frame f = MakeWall(kWidth, kHeight);
    FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
      return (slanted ? 5 * y > x + 100 : y > 20) ? 1.0f : 0.1f;
    });
    DenoisedFrame out;
    EXPECT_TRUE(d.Denoise(f, &out).ok());
    return out.colour;
  };
  const Image3 straight = picture(Fxaa::kOn, false);
  const Image3 jagged = picture(Fxaa::kOff, true);
  const Image3 smooth = picture(Fxaa::kOn, true);
  double error_before = 0;
  double error_after = 0;
  for (int y = 4; y < kHeight - 4; ++y) {
    for (int x = 10; x < kWidth - 10; ++x) {
      EXPECT_EQ(straight[0](x, y), y > 20 ? 1.0f : 0.1f) << x << " " << y;
      // Coverage of the pixel by the half plane 5 y > x + 100, taken at its middle column: exact
      // enough to distinguish jagged from smooth.
      const double cover = std::clamp(y - (x + 100.0) / 5.0 + 0.5, 0.0, 1.0);
      const double truth = 0.1 + 0.9 * cover;
      error_before += std::pow(jagged[0](x, y) - truth, 2);
      error_after += std::pow(smooth[0](x, y) - truth, 2);
    }
  }
  EXPECT_LT(error_after, 0.5 * error_before);
}

TEST(Dither, KeepsTheMeanAndBlackAndWhite) {
  Image3 flat(256, 256);
  flat[0].Fill(0.2f);
  flat[1].Fill(0.0f);
  flat[2].Fill(50.0f);
  const std::vector<uint8_t> plain = ToDisplay(flat, 0, Tonemap::kLinear);
  const std::vector<uint8_t> noisy = ToDisplay(flat, 0, Tonemap::kLinear, 1.0f, 3);
  double sum = 0;
  int different = 0;
  for (size_t i = 0; i < noisy.size(); i += 3) {
    sum += noisy[i];
    different += noisy[i] != plain[i];
    EXPECT_LE(std::abs(noisy[i] - plain[i]), 1);
    EXPECT_EQ(noisy[i + 1], 0);
    EXPECT_EQ(noisy[i + 2], 255);
  }
  // sRGB of 0.2 is 0.4845292 (1.055 * 0.2^(1/2.4) - 0.055): 123.55 steps, which the noise's mean
  // keeps and rounding alone cannot.
  EXPECT_NEAR(sum / (256.0 * 256.0), 0.4845292 * 255, 0.02);
  EXPECT_GT(different, 10000);
  EXPECT_EQ(noisy, ToDisplay(flat, 0, Tonemap::kLinear, 1.0f, 3));
  EXPECT_NE(noisy, ToDisplay(flat, 0, Tonemap::kLinear, 1.0f, 4));
}

}  // namespace
}  // namespace stillray::sparse_test

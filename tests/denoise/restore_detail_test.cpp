// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// restore_detail: its formulas, the stage on computed planes, and the denoiser with it.
#include "denoise/stages/restore_detail.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "denoise/backend.h"
#include "denoise/every_target.h"
#include "denoise/make_denoiser.h"
#include "denoise/stage_test.h"
#include "denoise/test_frames.h"

namespace stillray::restore_detail_test {
namespace {

using test::FillImage;
using test::Light;
using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::MakeWall;
using test::OnEveryTarget;
using test::Random;
using test::SameBits;
using ::testing::HasSubstr;

constexpr int kWidth = 43;
constexpr int kHeight = 29;
constexpr int kBorder = 4;

Settings Best() {
  return PresetSettings("best").value();
}

/// Of the normal distribution with mean 0 and variance 1.
double Normal(uint32_t a, uint32_t b) {
  const double u = static_cast<double>(std::max(Random(a, b, 1), 1e-7f));
  return std::sqrt(-2 * std::log(u)) *
         std::cos(6.283185307179586 * static_cast<double>(Random(a, b, 2)));
}

TEST(RestoreDetail, Formulas) {
  EXPECT_FLOAT_EQ(DetailScale(0.6f, 6.4f), 1.0f);  // sqrt(0.36 + 0.1 * 6.4)
  EXPECT_EQ(DetailScale(0.0f, 0.0f), kLeastDetailScale);
  EXPECT_FLOAT_EQ(ScaledDetail(-3.0f, 2.0f), -1.5f);
  EXPECT_EQ(ScaledDetail(1.0f, kLeastDetailScale), kMostDetail);
  EXPECT_FLOAT_EQ(DetailShare(2.0f, 4.0f, 1.0f), 0.375f);  // 2 / 4 * (1 - 1 / 4)
  EXPECT_FLOAT_EQ(DetailShare(8.0f, 4.0f, 1.0f), 0.75f);   // no more than the mean
  EXPECT_EQ(DetailShare(2.0f, 4.0f, 4.0f), 0.0f);          // noise alone
  EXPECT_EQ(DetailShare(-2.0f, 4.0f, 0.0f), 0.0f);
  EXPECT_EQ(DetailShare(0.0f, 0.0f, 0.0f), 0.0f);
  EXPECT_FLOAT_EQ(ResidualAlpha(2.0f, 8.0f, 0.1f), 0.25f);
  EXPECT_FLOAT_EQ(ResidualAlpha(1.0f, 80.0f, 0.1f), 0.1f);
}

/// The noise of the mean residual, by following the noise of many pixels through the average.
TEST(RestoreDetail, VarianceOfTheMeanResidual) {
  constexpr int kPixels = 20000;
  constexpr float kAlpha = 0.1f;
  for (const int frames : {1, 4, 10, 60}) {
    for (const int samples : {1, 4}) {
      double square = 0;
      for (uint32_t pixel = 0; pixel < kPixels; ++pixel) {
        double mean = 0;
        for (int i = 0; i < frames; ++i) {
          const auto length = static_cast<float>((i + 1) * samples);
          const double alpha =
              static_cast<double>(ResidualAlpha(static_cast<float>(samples), length, kAlpha));
          const double noise = 3 * Normal(pixel, static_cast<uint32_t>(i)) / std::sqrt(samples);
          mean += alpha * (noise - mean);
        }
        square += mean * mean / kPixels;
      }
      const float formula = ResidualVariance(9.0f, static_cast<float>(samples),
                                             static_cast<float>(frames * samples), kAlpha);
      EXPECT_NEAR(static_cast<double>(formula) / square, 1, 0.1) << frames << " " << samples;
    }
  }
}

/// Where nothing is uncertain the share is the product of regression and Wiener filter: E(d^2) /
/// E(m^2) each.
TEST(RestoreDetail, ShareOfAMeanWithNoise) {
  for (const double noise : {0.0, 0.5, 1.0}) {
    constexpr int kCount = 1 << 18;
    double product = 0;
    double square = 0;
    for (uint32_t i = 0; i < kCount; ++i) {
      const double detail = i % 2 == 0 ? 1 : -1;
      const double mean = detail + noise * Normal(i, 3);
      product += mean * (detail + 3 * Normal(i, 4)) / kCount;
      square += mean * mean / kCount;
    }
    const float share = DetailShare(static_cast<float>(product), static_cast<float>(square),
                                    static_cast<float>(noise * noise));
    const double regression = 1 / (1 + noise * noise);
    EXPECT_NEAR(static_cast<double>(share), regression * regression, 0.02) << noise;
  }
}

/// Planes of a wall and some sky, with missing samples, and residuals without history in places.
struct Planes {
  NewLight light = {LumaImage3(kWidth, kHeight), Image1(kWidth, kHeight), Image1()};
  LumaImage3 filtered{kWidth, kHeight};
  Image1 variance{kWidth, kHeight};
  GuidePlanes guides = GuidePlanes(kWidth, kHeight, kBorder);
  SignalHistory residual;

  Planes() {
    residual.colour = LumaImage3(kWidth, kHeight);
    residual.length = Image1(kWidth, kHeight);
    const auto u = [&](int x, int y, uint32_t what) {
      return Random(static_cast<uint32_t>(x), static_cast<uint32_t>(y), what);
    };
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        for (int c = 0; c < 3; ++c) {
          light.colour[c](x, y) = 2 * u(x, y, static_cast<uint32_t>(c));
          filtered[c](x, y) = 0.5f + 0.5f * u(x, y, static_cast<uint32_t>(c + 3));
          residual.colour[c](x, y) = u(x, y, static_cast<uint32_t>(c + 6)) - 0.5f;
        }
        variance(x, y) = u(x, y, 9);
        light.samples(x, y) = u(x, y, 10) < 0.1f ? 0.0f : u(x, y, 10) < 0.5f ? 1.0f : 4.0f;
        guides.inverse_depth(x, y) = u(x, y, 11) < 0.1f ? 0.0f : 0.25f;
        residual.length(x, y) = u(x, y, 12) < 0.1f ? 0.0f : 20 * u(x, y, 13);
      }
    }
  }
  DetailInput Input() const { return {&light, &filtered, &variance}; }
};

constexpr RestoreDetailParameters kParameters = {.detail_signals = 1, .alpha_min = 0.1f};

/// All four functions, one after the other.
struct Outcome {
  FilterPlanes mean{kWidth, kHeight, kBorder};
  Image1 valid{kWidth, kHeight, kBorder};
  FilterPlanes measured{kWidth, kHeight, kBorder};
  LumaImage3 restored;
  SignalHistory residual;
};

TEST(RestoreDetail, EveryTargetGivesTheBitsOfTheReference) {
  const Planes planes;
  Outcome expected;
  reference::BeginDetail(planes.Input(), planes.residual, planes.guides, kParameters,
                         &expected.mean, &expected.valid);
  reference::MeasureDetail(planes.Input(), expected.mean, expected.valid, &expected.measured);
  expected.restored = planes.filtered;
  reference::RestoreDetail(expected.measured, expected.mean, planes.variance, expected.valid,
                           &expected.restored);
  expected.residual = planes.residual;
  reference::AccumulateResidual(planes.Input(), kParameters, &expected.residual);
  ASSERT_FALSE(SameBits(expected.restored, planes.filtered));
  OnEveryTarget([&] {
    Outcome got;
    cpu::BeginDetail(planes.Input(), planes.residual, planes.guides, kParameters, &got.mean,
                     &got.valid);
    cpu::MeasureDetail(planes.Input(), got.mean, got.valid, &got.measured);
    got.restored = planes.filtered;
    cpu::RestoreDetail(got.measured, got.mean, planes.variance, got.valid, &got.restored);
    got.residual = planes.residual;
    cpu::AccumulateResidual(planes.Input(), kParameters, &got.residual);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(got.valid(x, y), expected.valid(x, y)) << x << " " << y;
        ASSERT_EQ(got.residual.length(x, y), expected.residual.length(x, y)) << x << " " << y;
        for (int c = 0; c < 2; ++c) {
          ASSERT_EQ(got.measured.colour[c](x, y), expected.measured.colour[c](x, y))
              << x << " " << y;
        }
        ASSERT_EQ(got.mean.variance(x, y), expected.mean.variance(x, y)) << x << " " << y;
      }
    }
    EXPECT_TRUE(SameBits(got.mean.colour, expected.mean.colour));
    EXPECT_TRUE(SameBits(got.restored, expected.restored));
    EXPECT_TRUE(SameBits(got.residual.colour, expected.residual.colour));
  });
}

TEST(RestoreDetail, MeanResidualIsThatOfAllSamplesThenMovesOn) {
  Planes planes;
  planes.light.samples.Fill(1.0f);
  planes.residual.length.Fill(0.0f);
  double sum = 0;
  double recent = 0;
  for (uint32_t frame = 0; frame < 40; ++frame) {
    planes.light.colour[0](5, 7) = 3 * Random(frame, 1, 2);
    const double now = static_cast<double>(planes.light.colour[0](5, 7)) -
                       static_cast<double>(planes.filtered[0](5, 7));
    sum += now;
    cpu::AccumulateResidual(planes.Input(), kParameters, &planes.residual);
    recent = frame < 10 ? sum / (frame + 1.0) : 0.9 * recent + 0.1 * now;
    ASSERT_NEAR(static_cast<double>(planes.residual.colour[0](5, 7)), recent, 1e-5) << frame;
  }
}

constexpr int kSize = 64;

/// Stripes of light, four pixels wide, as narrow as contact shadows.
float Stripes(int x, int shift) {
  return (x + shift) / 4 % 2 == 0 ? 1.0f : 0.7f;
}

/// One sample of the stripes per pixel; `lit` of the samples have all the light.
Frame MakeStripes(int64_t index, int shift, float lit) {
  Frame f = MakeWall(kSize, kSize, index);
  FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
    const float u = Random(static_cast<uint32_t>(index), static_cast<uint32_t>(y * kSize + x), 5);
    return 0.5f * Stripes(x, shift) * (u < lit ? 1 / lit : 0.0f);
  });
  return f;
}

/// Mean squared error of the last picture, relative to the light of the stripes.
double StripesError(const DenoisedFrame& out, int shift) {
  double sum = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double e =
          static_cast<double>(out.colour[0](x, y)) / 0.5 - static_cast<double>(Stripes(x, shift));
      sum += e * e / (kSize * kSize);
    }
  }
  return sum;
}

struct StripeErrors {
  double still;
  double changed;  ///< right after the stripes have changed places
};

StripeErrors ErrorsOfStripes(const char* preset, float lit) {
  Denoiser d = MakeDenoiser(PresetSettings(preset).value());
  DenoisedFrame out;
  StripeErrors errors = {};
  for (int i = 0; i < 32; ++i) {
    EXPECT_TRUE(d.Denoise(MakeStripes(i, 0, lit), &out).ok());
  }
  errors.still = StripesError(out, 0);
  for (int i = 32; i < 35; ++i) {
    EXPECT_TRUE(d.Denoise(MakeStripes(i, 4, lit), &out).ok());
  }
  errors.changed = StripesError(out, 4);
  return errors;
}

TEST(RestoreDetail, TexturesOfStillLightComeBackAndThoseThatMoveAreNotAdded) {
  const StripeErrors without = ErrorsOfStripes("default", 0.5f);
  const StripeErrors with = ErrorsOfStripes("best", 0.5f);
  EXPECT_LT(with.still, 0.85 * without.still);
  EXPECT_LT(with.changed, 1.01 * without.changed);
}

/// Where the noise hides the detail, hardly any of it is added.
TEST(RestoreDetail, StrongNoiseStaysRemoved) {
  const StripeErrors without = ErrorsOfStripes("default", 0.2f);
  const StripeErrors with = ErrorsOfStripes("best", 0.2f);
  EXPECT_LT(with.still, 1.08 * without.still);
  EXPECT_LT(with.changed, 1.03 * without.changed);
}

TEST(RestoreDetail, ConstantLightStaysConstant) {
  Denoiser d = MakeDenoiser(Best());
  DenoisedFrame out;
  for (int i = 0; i < 6; ++i) {
    Frame f = MakeWall(kSize, kSize, i);
    for (int c = 0; c < 3; ++c) {
      Light(&f, SignalKind::kDirectDiffuse)[c].Fill(0.375f);
    }
    ASSERT_TRUE(d.Denoise(f, &out).ok());
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        ASSERT_NEAR(out.colour[1](x, y), 0.375f, 1e-5f) << x << " " << y << " frame " << i;
      }
    }
  }
}

/// What it adds is not fed back: accumulated light and its variance keep their bits.
TEST(RestoreDetail, HistoryOfTheLightIsNotChanged) {
  Denoiser with = MakeDenoiser(Best());
  Denoiser without = MakeDenoiser(PresetSettings("default").value());
  DenoisedFrame a;
  DenoisedFrame b;
  for (Denoiser* d : {&with, &without}) {
    ASSERT_TRUE(d->SetOutputs({"accumulated", "variance"}).ok());
  }
  for (int i = 0; i < 8; ++i) {
    ASSERT_TRUE(with.Denoise(MakeBusyFrame(kSize, kSize, i), &a).ok());
    ASSERT_TRUE(without.Denoise(MakeBusyFrame(kSize, kSize, i), &b).ok());
  }
  ASSERT_EQ(a.images.size(), b.images.size());
  ASSERT_GT(a.images.size(), 3u);
  for (size_t i = 0; i < a.images.size(); ++i) {
    ASSERT_EQ(a.images[i].channels.size(), b.images[i].channels.size());
    for (size_t c = 0; c < a.images[i].channels.size(); ++c) {
      test::ExpectEqual(a.images[i].channels[c], b.images[i].channels[c]);
    }
  }
  EXPECT_FALSE(SameBits(a.colour, b.colour));
}

TEST(RestoreDetail, TurnedOffItLeavesNoMemory) {
  Denoiser d = MakeDenoiser(Best());
  DenoisedFrame out;
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(d.Denoise(MakeBusyFrame(kSize, kSize, i), &out).ok());
  }
  const size_t with = d.SaveHistory().value().size();
  ASSERT_TRUE(d.SetSettings(PresetSettings("default").value()).ok());
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(kSize, kSize, 2), &out).ok());
  // direct diffuse and specular light: three colours and the length
  EXPECT_EQ(with - d.SaveHistory().value().size(), 2u * 4 * 4 * kSize * kSize);
}

/// A device that must not be used.
class NoDenoiser final : public DeviceBackend {
 public:
  Result<std::unique_ptr<DenoiserBackend>> CreateDenoiser(const Settings& /*settings*/,
                                                          DevicePrecision /*precision*/) override {
    return Status::Internal("made on the device");
  }
};

TEST(RestoreDetail, DevicesRefuseIt) {
  const Device device = MakeDevice(std::make_shared<NoDenoiser>(), "a device");
  const Result<Denoiser> refused = Denoiser::Create(Best(), device);
  EXPECT_EQ(refused.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(refused.status().message(), HasSubstr("restore_detail"));
  EXPECT_THAT(refused.status().message(), HasSubstr("CPU only"));
}

}  // namespace
}  // namespace stillray::restore_detail_test

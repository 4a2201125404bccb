// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "post/depth_of_field.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "post/pictures.h"

namespace stillray::post::depth_of_field_test {
namespace {

using ::testing::HasSubstr;

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Infinity is blurred by `radius` pixels, the plane of focus lies at 2.
ThinLens LensOfRadius(float radius) {
  ThinLens lens;
  lens.radius = 0.1f;
  lens.focus = 2.0f;
  lens.pixels_per_tangent = radius / (0.1f / 2.0f);
  return lens;
}

/// The depth in front of the plane of focus that LensOfRadius(far) blurs by `radius`.
float NearDepth(float far, float radius) {
  return 2.0f / (1.0f + radius / far);
}

Image3 Blurred(const ThinLens& lens, const Image1& depth, const Image3& colour) {
  Image3 out = colour;
  const Status status = DepthOfField(lens, depth, &out);
  EXPECT_TRUE(status.ok()) << status.message();
  return out;
}

TEST(CircleOfConfusion, IsTheFormulaOfTheLens) {
  ThinLens lens;
  lens.radius = 0.05f;
  lens.focus = 3.0f;
  lens.pixels_per_tangent = PixelsPerTangent(720, 0.8);
  const double pixels = 720.0 / (2.0 * std::tan(0.4));
  EXPECT_NEAR(lens.pixels_per_tangent, pixels, 1e-3);
  EXPECT_NEAR(CircleOfConfusion(lens, 6.0f), 0.05 * (1.0 / 3.0 - 1.0 / 6.0) * pixels, 1e-4);
  EXPECT_NEAR(CircleOfConfusion(lens, 1.0f), 0.05 * (1.0 / 3.0 - 1.0) * pixels, 1e-4);
  EXPECT_EQ(CircleOfConfusion(lens, 3.0f), 0.0f);
  const float sky = CircleOfConfusion(lens, kInfinite);
  EXPECT_NEAR(sky, 0.05 / 3.0 * pixels, 1e-4);
  for (const float depth : {kNan, 0.0f, -1.0f, -kInfinite}) {
    EXPECT_EQ(CircleOfConfusion(lens, depth), sky) << depth;
  }
  EXPECT_TRUE(std::isfinite(CircleOfConfusion(lens, 1e-45f)));
  lens.focus = kInfinite;
  EXPECT_EQ(CircleOfConfusion(lens, kInfinite), 0.0f);
}

TEST(DepthOfField, KeepsAConstantPicture) {
  const Image3 colour = FlatColour(70, 50, 0.25f, 3.0f, 1000.0f);
  const Image3 out = Blurred(LensOfRadius(9.0f), Noise(70, 50, 0.9f, 20.0f, 1), colour);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 50; ++y) {
      for (int x = 0; x < 70; ++x) {
        ASSERT_NEAR(out[c](x, y) / colour[c](x, y), 1.0f, 1e-5f) << x << " " << y;
      }
    }
  }
}

TEST(DepthOfField, KeepsWhatIsInFocus) {
  const Image3 colour = NoiseColour(64, 40, 5);
  const Image3 out = Blurred(LensOfRadius(8.0f), Flat(64, 40, 2.0f), colour);
  EXPECT_TRUE(SameBits(out, colour));
}

TEST(DepthOfField, ABlurredBackgroundStaysOffASharpForeground) {
  Image1 depth = Flat(64, 40, kInfinite);
  Image3 colour = FlatColour(64, 40, 1000.0f, 1000.0f, 1000.0f);
  const Image3 noise = NoiseColour(64, 40, 7);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 32; ++x) {
      depth(x, y) = 2.0f;
      for (int c = 0; c < 3; ++c) {
        colour[c](x, y) = noise[c](x, y);
      }
    }
  }
  for (const float radius : {1.2f, 1.8f, 8.0f, 20.0f}) {
    const Image3 out = Blurred(LensOfRadius(radius), depth, colour);
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 64; ++x) {
          if (x < 32) {
            ASSERT_EQ(out[c](x, y), colour[c](x, y)) << x << " " << y;
          } else {
            // Nor does the sharp surface spread over the background.
            ASSERT_NEAR(out[c](x, y), 1000.0f, 0.05f) << x << " " << y;
          }
        }
      }
    }
  }
}

TEST(DepthOfField, ADotBecomesADiscOfTheCircleOfConfusion) {
  for (const float radius : {3.0f, 7.5f, 20.0f}) {
    Image3 colour(101, 101);
    colour[1](50, 50) = 100.0f;
    const Image3 out = Blurred(LensOfRadius(radius), Flat(101, 101, kInfinite), colour);
    double moment = 0;
    for (int y = 0; y < 101; ++y) {
      for (int x = 0; x < 101; ++x) {
        const double square = (x - 50) * (x - 50) + (y - 50) * (y - 50);
        moment += square * static_cast<double>(out[1](x, y));
        if (std::sqrt(square) > static_cast<double>(radius) + 0.5) {
          ASSERT_EQ(out[1](x, y), 0.0f);
        }
      }
    }
    const double sum = SumOf(out[1]);
    EXPECT_NEAR(sum, 100.0, 1e-2) << radius;
    EXPECT_EQ(SumOf(out[0]), 0.0);
    const double r = static_cast<double>(radius);
    const double expected = r * r / 2 + 1.0 / 6;  // of the disc, and of the dot, which is a pixel
    EXPECT_NEAR(moment / sum, expected, 0.02 * expected) << radius;
  }
}

TEST(DepthOfField, KeepsTheEnergyInsideABlurredPlane) {
  Image3 colour(90, 80);
  const Image3 noise = NoiseColour(90, 80, 3);
  for (int y = 20; y < 60; ++y) {
    for (int x = 20; x < 70; ++x) {
      for (int c = 0; c < 3; ++c) {
        colour[c](x, y) = noise[c](x, y);
      }
    }
  }
  const Image3 out = Blurred(LensOfRadius(9.5f), Flat(90, 80, kInfinite), colour);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(SumOf(out[c]) / SumOf(colour[c]), 1.0, 1e-4);
  }
}

/// The part of a disc that lies left of a line at x.
double PartLeftOf(double x, double radius) {
  const double u = std::fmin(std::fmax(x / radius, -1.0), 1.0);
  return 0.5 + (u * std::sqrt(1 - u * u) + std::asin(u)) / std::numbers::pi;
}

TEST(DepthOfField, ABlurredForegroundCoversByItsShareOfTheDisc) {
  constexpr float kRadius = 8.0f;
  Image1 depth = Flat(80, 40, 2.0f);  // the background is sharp
  Image3 colour = FlatColour(80, 40, 0.0f, 1.0f, 0.0f);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      depth(x, y) = NearDepth(20.0f, kRadius);
      colour[0](x, y) = 1.0f;
      colour[1](x, y) = 0.0f;
    }
  }
  const Image3 out = Blurred(LensOfRadius(20.0f), depth, colour);
  for (int x = 20; x < 60; ++x) {
    const double share = PartLeftOf(40.0 - (x + 0.5), static_cast<double>(kRadius));
    EXPECT_NEAR(out[0](x, 20), share, 0.02) << x;
    EXPECT_NEAR(out[1](x, 20), 1.0 - share, 0.02) << x;
  }
}

TEST(DepthOfField, UnknownDepthIsInfinitelyFar) {
  const Image3 colour = NoiseColour(50, 40, 11);
  Image1 depth = Noise(50, 40, 1.0f, 5.0f, 12);
  Image1 sky = depth;
  const float values[] = {kNan, 0.0f, -3.0f, -kInfinite};
  for (int i = 0; i < 40; ++i) {
    depth(i, i) = values[i % 4];
    sky(i, i) = kInfinite;
  }
  const Image3 out = Blurred(LensOfRadius(6.0f), depth, colour);
  EXPECT_TRUE(SameBits(out, Blurred(LensOfRadius(6.0f), sky, colour)));
  for (int c = 0; c < 3; ++c) {
    EXPECT_TRUE(std::isfinite(SumOf(out[c])));
  }
}

TEST(DepthOfField, LightThatIsNotFiniteDoesNotSpread) {
  Image3 colour = NoiseColour(40, 40, 2);
  colour[0](20, 20) = kNan;
  colour[1](10, 12) = kInfinite;
  const Image3 out = Blurred(LensOfRadius(6.0f), Flat(40, 40, kInfinite), colour);
  for (int c = 0; c < 3; ++c) {
    EXPECT_TRUE(std::isfinite(SumOf(out[c])));
  }
}

TEST(DepthOfField, LimitsTheRadius) {
  ThinLens lens = LensOfRadius(100.0f);
  lens.max_radius = 5.0f;
  Image3 colour(41, 41);
  colour[0](20, 20) = 1.0f;
  const Image3 out = Blurred(lens, Flat(41, 41, kInfinite), colour);
  EXPECT_TRUE(SameBits(out, Blurred(LensOfRadius(5.0f), Flat(41, 41, kInfinite), colour)));
}

// The definition, one pixel at a time and in double precision.
struct Pixel {
  double order;
  double radius;
  double area;
};

Pixel PixelOf(const ThinLens& lens, float depth) {
  const double order = static_cast<double>(lens.radius) *
                       static_cast<double>(lens.pixels_per_tangent) *
                       (1.0 / static_cast<double>(lens.focus) - 1.0 / static_cast<double>(depth));
  const double radius = std::fmax(std::fabs(order), 0.5);
  const double area =
      radius > 0.5 ? std::fmax(std::numbers::pi * (radius * radius + 1.0 / 12.0), 1.0) : 1.0;
  return {order, radius, area};
}

double Ramp(double x) {
  return std::fmin(std::fmax(x, 0.0), 1.0);
}

double ReferenceAt(const ThinLens& lens, const Image1& depth, const Image1& light, int px, int py) {
  const Pixel p = PixelOf(lens, depth(px, py));
  double front = 0, front_light = 0, own = 0, own_light = 0, back = 0, back_light = 0, hidden = 0;
  for (int y = -20; y <= 20; ++y) {
    for (int x = -20; x <= 20; ++x) {
      const int qx = std::min(std::max(px + x, 0), depth.width() - 1);
      const int qy = std::min(std::max(py + y, 0), depth.height() - 1);
      const Pixel q = PixelOf(lens, depth(qx, qy));
      const double value = static_cast<double>(light(qx, qy));
      const double d = std::sqrt(x * x + y * y);
      const double by_p = Ramp(p.radius + 0.5 - d);
      const double by_q = Ramp(q.radius + 0.5 - d);
      const double in_front = Ramp(p.order - q.order - 1.0);
      const double behind = Ramp(q.order - p.order - 1.0);
      const double beside = 1.0 - in_front - behind;
      front += in_front * by_q / q.area;
      front_light += in_front * by_q / q.area * value;
      const double spread =
          q.order > p.order ? std::fmin(by_p, by_q) / std::fmin(p.area, q.area) : by_q / q.area;
      own += beside * spread;
      own_light += beside * spread * value;
      back += behind * by_p / p.area;
      back_light += behind * by_p / p.area * value;
      hidden += in_front * std::fmax(by_p - by_q, 0.0) / p.area;
    }
  }
  const double a = std::fmin(front, 1.0);
  double b = std::fmin(own / std::fmax(1.0 - hidden, own), 1.0 - a);
  double c = 1.0 - a - b;
  if (back <= 0) {
    b += c;
    c = 0;
  }
  return (a > 0 ? a * front_light / front : 0) + b * own_light / own +
         (c > 0 ? c * back_light / back : 0);
}

TEST(DepthOfField, IsItsDefinitionInDoublePrecision) {
  const ThinLens lens = LensOfRadius(4.0f);
  // Steps and slopes on both sides of the plane of focus.
  Image1 depth = Noise(44, 37, 1.2f, 1.5f, 4);
  for (int y = 0; y < 37; ++y) {
    for (int x = 0; x < 44; ++x) {
      if (x > 12 || y > 25) {
        depth(x, y) = 1.8f + 0.05f * static_cast<float>(x) + 0.3f * static_cast<float>(y % 9 == 0);
      }
    }
  }
  const Image3 colour = NoiseColour(44, 37, 8);
  const Image3 out = Blurred(lens, depth, colour);
  for (int y = 0; y < 37; ++y) {
    for (int x = 0; x < 44; ++x) {
      ASSERT_NEAR(out[2](x, y), ReferenceAt(lens, depth, colour[2], x, y), 2e-4) << x << " " << y;
    }
  }
}

TEST(DepthOfField, TheNumberOfThreadsChangesNoBit) {
  const Image3 colour = NoiseColour(150, 90, 1);
  const Image1 depth = Noise(150, 90, 0.8f, 9.0f, 2);
  Image3 one;
  {
    const Threads limit(1);
    one = Blurred(LensOfRadius(7.0f), depth, colour);
  }
  const Threads limit(4);
  EXPECT_TRUE(SameBits(Blurred(LensOfRadius(7.0f), depth, colour), one));
}

TEST(DepthOfField, RejectsBadSettingsAndSizes) {
  Image3 colour = NoiseColour(8, 8, 1);
  const Image3 before = colour;
  const Image1 depth = Flat(8, 8, 1.0f);
  const auto message = [&](ThinLens lens, const Image1& guide) {
    const Status status = DepthOfField(lens, guide, &colour);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    return status.message();
  };
  ThinLens lens;
  lens.radius = -1.0f;
  EXPECT_THAT(message(lens, depth), HasSubstr("radius of the lens is -1"));
  lens.radius = kNan;
  EXPECT_THAT(message(lens, depth), HasSubstr("radius of the lens"));
  lens = {};
  lens.focus = 0.0f;
  EXPECT_THAT(message(lens, depth), HasSubstr("focus is 0"));
  lens = {};
  lens.pixels_per_tangent = kInfinite;
  EXPECT_THAT(message(lens, depth), HasSubstr("pixels_per_tangent"));
  lens = {};
  lens.max_radius = 300.0f;
  EXPECT_THAT(message(lens, depth), HasSubstr("max_radius is 300, expected 0.5 to 256"));
  EXPECT_THAT(message({}, Flat(7, 8, 1.0f)),
              HasSubstr("depth has 7 x 8 pixels, the picture 8 x 8"));
  EXPECT_TRUE(SameBits(colour, before));
}

}  // namespace
}  // namespace stillray::post::depth_of_field_test

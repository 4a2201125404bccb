// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/atrous.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "denoise/stages/mix_pilot.h"
#include "stage_test.h"

namespace stillray::atrous_test {
namespace {

constexpr int kBorder = 16;
constexpr int kAllWeights[] = {kAtrousNaive, kAtrousGeometry, kAtrousSvgf, kAtrousEaw};

using Version = decltype(&cpu::Atrous);
constexpr Version kVersions[] = {&reference::Atrous, &cpu::Atrous};

AtrousParameters MakeParameters() {
  AtrousParameters p = {};
  p.edges.sigma_n = 64;
  p.edges.depth_weight_plane = 1;
  p.edges.sigma_z = 1;
  p.edges.plane_tolerance = 0.01f;
  p.edges.depth_epsilon = 0.001f;
  p.noise_ratio = 1;
  p.eaw_sigma_l = 1;
  p.eaw_sigma_n = 0.3f;
  p.eaw_sigma_z = 0.05f;
  return p;
}

/// By the distance of positions.
AtrousParameters ByPosition(AtrousParameters p, int width, int height, float sigma = 0.1f) {
  p.edges.depth_weight_plane = 0;
  p.edges.depth_weight_position = 1;
  p.edges.position_sigma = sigma;
  p.edges.focal_pixels = static_cast<float>(width);
  p.edges.centre_x = 0.5f * static_cast<float>(width);
  p.edges.centre_y = 0.5f * static_cast<float>(height);
  return p;
}

/// A lit wall that faces the camera, of one id. The border has neither light nor a surface.
struct Picture {
  int width;
  int height;
  GuidePlanes guides{width, height, kBorder};
  LumaImage3 colour{width, height, kBorder};
  Image1 variance{width, height, kBorder};
  Image1 luminance_factor{width, height, kBorder};
  Image1 valid{width, height, kBorder};
  bool reflected = false;  ///< the light is specular

  Picture(int w, int h) : width(w), height(h) {
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        guides.inverse_depth(x, y) = 0.25f;
        guides.depth(x, y) = 4;
        guides.normal[2](x, y) = 1;
        guides.id(x, y) = 1;
        valid(x, y) = 1;
        variance(x, y) = 1;
        for (int c = 0; c < 3; ++c) {
          colour[c](x, y) = 1;
        }
      }
    }
  }
  /// Runs fill(x, y) for the pixels from a column on.
  template <typename Fill>
  void From(int column, const Fill& fill) {
    for (int y = 0; y < height; ++y) {
      for (int x = column; x < width; ++x) {
        fill(x, y);
      }
    }
  }
};

struct Filtered {
  FilterPlanes planes;
  Image1 valid_out;

  explicit Filtered(const Picture& picture)
      : planes(picture.width, picture.height, kBorder),
        valid_out(picture.width, picture.height, kBorder) {}
};

/// The same picture with packed normals.
Picture WithPackedNormals(Picture picture) {
  GuidePlanes& g = picture.guides;
  g.packed_normal = Plane<uint32_t>(picture.width, picture.height, kBorder);
  picture.From(0, [&](int x, int y) {
    g.packed_normal(x, y) = PackNormal({g.normal[0](x, y), g.normal[1](x, y), g.normal[2](x, y)});
  });
  g.normal = Image3();
  return picture;
}

Filtered RunStage(Version atrous, const Picture& picture, const AtrousLevel& level,
                  const AtrousParameters& p, const Image1* pilot = nullptr) {
  Filtered out(picture);
  AtrousSignal signal = {&picture.colour, &picture.variance, &out.planes, &picture.luminance_factor,
                         &picture.valid};
  signal.eaw_sigma_l = p.eaw_sigma_l;
  signal.valid_out = &out.valid_out;
  signal.pilot = pilot;
  signal.reflected = picture.reflected;
  atrous({&signal, 1}, picture.guides, level, p);
  return out;
}

TEST(Atrous, ConstantStaysConstant) {
  Picture picture(41, 19);
  picture.From(0, [&](int x, int y) {
    picture.guides.inverse_depth(x, y) = 0.25f + 0.002f * test::RandomAt(x, y, 1);
    picture.guides.depth(x, y) = 1 / picture.guides.inverse_depth(x, y);
    picture.guides.normal[0](x, y) = 0.3f * test::RandomAt(x, y, 2);
    picture.luminance_factor(x, y) = test::RandomAt(x, y, 3);
    picture.valid(x, y) = test::RandomAt(x, y, 4) < 0.7f ? 1.0f : 0.0f;
  });
  const auto expect_constant = [](const Picture& filtered, const Filtered& out) {
    for (int y = 0; y < filtered.height; ++y) {
      for (int x = 0; x < filtered.width; ++x) {
        if (filtered.valid(x, y) > 0) {
          ASSERT_NEAR(out.planes.colour[0](x, y), 1, 2e-6f) << x << " " << y;
          ASSERT_LE(out.planes.variance(x, y), 1 + 2e-6f) << x << " " << y;
        }
      }
    }
  };
  const Picture packed = WithPackedNormals(picture);
  for (const int weights : kAllWeights) {
    for (const int radius : {1, 2}) {
      for (const int step : {1, 2, 8}) {
        for (const Version version : kVersions) {
          for (const AtrousParameters& p :
               {MakeParameters(), ByPosition(MakeParameters(), picture.width, picture.height)}) {
            expect_constant(picture, RunStage(version, picture, {weights, radius, step}, p));
            expect_constant(packed, RunStage(version, packed, {weights, radius, step}, p));
          }
        }
      }
    }
  }
}

/// Weight of the kernel at an offset in taps.
float Kernel(int radius, int dx, int dy) {
  constexpr float kKernel[2][3] = {{1.0f / 2, 1.0f / 4, 0}, {3.0f / 8, 1.0f / 4, 1.0f / 16}};
  const float* kernel = kKernel[radius - 1];
  return std::max(std::abs(dx), std::abs(dy)) > radius
             ? 0.0f
             : kernel[std::abs(dx)] * kernel[std::abs(dy)];
}

TEST(Atrous, OnAWallThatIsTheKernel) {
  Picture picture(33, 33);
  picture.From(0, [&](int x, int y) {
    picture.colour[0](x, y) = picture.colour[1](x, y) = x == 16 && y == 16 ? 1.0f : 0.0f;
  });
  for (const int weights : {kAtrousNaive, kAtrousGeometry, kAtrousSvgf}) {
    for (const int radius : {1, 2}) {
      for (const int step : {1, 4}) {
        for (const Version version : kVersions) {
          const Filtered out =
              RunStage(version, picture, {weights, radius, step}, MakeParameters());
          double sum = 0;
          for (int y = 0; y < 33; ++y) {
            for (int x = 0; x < 33; ++x) {
              const int dx = x - 16;
              const int dy = y - 16;
              const bool is_tap = dx % step == 0 && dy % step == 0;
              const float expected = is_tap ? Kernel(radius, dx / step, dy / step) : 0.0f;
              EXPECT_NEAR(out.planes.colour[0](x, y), expected, 1e-5f) << x << " " << y;
              EXPECT_NEAR(out.planes.colour[1](x, y), expected, 1e-5f) << x << " " << y;
              sum += static_cast<double>(out.planes.colour[0](x, y));
            }
          }
          EXPECT_NEAR(sum, 1, 1e-5);
          // Of independent pixels with variance 1: the sum of the squared weights.
          const double one = radius == 1 ? 0.375 : 0.2734375;
          EXPECT_NEAR(out.planes.variance(16, 16), one * one, 1e-5);
        }
      }
    }
  }
}

/// Light 1 left of column 16, 1000 from there on.
void ExpectNoLeak(Picture picture, int weights, const AtrousParameters& p) {
  picture.From(16, [&](int x, int y) {
    for (int c = 0; c < 3; ++c) {
      picture.colour[c](x, y) = 1000;
    }
  });
  for (const Version version : kVersions) {
    for (const int step : {1, 2}) {
      SCOPED_TRACE("weights " + std::to_string(weights) + " step " + std::to_string(step) +
                   (version == &cpu::Atrous ? " vectors" : " reference"));
      const Filtered out = RunStage(version, picture, {weights, 2, step}, p);
      for (int x = 0; x < picture.width; ++x) {
        const float expected = x < 16 ? 1.0f : 1000.0f;
        EXPECT_NEAR(out.planes.colour[0](x, 4), expected, 1e-4f * expected) << x;
        EXPECT_NEAR(out.planes.colour[1](x, 4), expected, 1e-4f * expected) << x;
      }
    }
  }
}

TEST(Atrous, NothingLeaksBetweenDepths) {
  Picture picture(33, 9);
  picture.From(16, [&](int x, int y) {
    picture.guides.inverse_depth(x, y) = 0.5f;
    picture.guides.depth(x, y) = 2;
  });
  AtrousParameters p = MakeParameters();
  p.eaw_sigma_l = 1e6f;  // depth alone
  for (const int weights : {kAtrousGeometry, kAtrousSvgf, kAtrousEaw}) {
    ExpectNoLeak(picture, weights, p);
    ExpectNoLeak(picture, weights, ByPosition(p, picture.width, picture.height));
  }
  p.edges.depth_weight_plane = 0;
  ExpectNoLeak(picture, kAtrousSvgf, p);
}

TEST(Atrous, NothingLeaksBetweenNormals) {
  Picture picture(33, 9);
  picture.From(16, [&](int x, int y) {
    picture.guides.normal[0](x, y) = 1;
    picture.guides.normal[2](x, y) = 0;
  });
  AtrousParameters p = MakeParameters();
  p.eaw_sigma_l = 1e6f;  // of the weights of this wavelet, those of the normals alone
  for (const int weights : {kAtrousGeometry, kAtrousSvgf, kAtrousEaw}) {
    ExpectNoLeak(picture, weights, p);
  }
}

TEST(Atrous, NothingLeaksBetweenIds) {
  Picture picture(33, 9);
  picture.From(16, [&](int x, int y) { picture.guides.id(x, y) = 2; });
  AtrousParameters p = MakeParameters();
  p.wavelet_id = 1;
  ExpectNoLeak(picture, kAtrousSvgf, p);
}

TEST(Atrous, NothingLeaksBetweenLuminances) {
  Picture picture(33, 9);
  picture.From(0, [&](int x, int y) { picture.luminance_factor(x, y) = 1; });
  ExpectNoLeak(picture, kAtrousSvgf, MakeParameters());
  ExpectNoLeak(picture, kAtrousEaw, MakeParameters());
}

TEST(Atrous, ANoisyNeighbourLowersTheStopByTheRatio) {
  // Two columns of taps reach over the edge at column 16: from 15, with 1/4 of the kernel 3x3.
  Picture picture(33, 9);
  picture.From(0, [&](int x, int y) {
    picture.luminance_factor(x, y) = x < 16 ? 2.0f : 0.0f;  // infinitely noisy to the right
    picture.colour[0](x, y) = x < 16 ? 1.0f : 2.0f;
  });
  for (const float ratio : {1.0f, 2.0f}) {
    AtrousParameters p = MakeParameters();
    p.noise_ratio = ratio;
    const double edge = std::exp2(-2.0 / static_cast<double>(ratio));
    const double expected = (0.75 * 1 + 0.25 * edge * 2) / (0.75 + 0.25 * edge);
    for (const Version version : kVersions) {
      const Filtered out = RunStage(version, picture, {kAtrousSvgf, 1, 1}, p);
      EXPECT_NEAR(out.planes.colour[0](15, 4), expected, 2e-5);
    }
  }
}

TEST(Atrous, PixelsWithoutLightAreFilledAndAreNoTaps) {
  Picture picture(33, 9);
  picture.colour[0](20, 4) = picture.valid(20, 4) = 0;
  for (const int weights : {kAtrousNaive, kAtrousSvgf, kAtrousEaw}) {
    for (const Version version : kVersions) {
      const Filtered out = RunStage(version, picture, {weights, 1, 1}, MakeParameters());
      for (int x = 0; x < 33; ++x) {
        EXPECT_NEAR(out.planes.colour[0](x, 4), 1, 1e-6f) << x;
        EXPECT_EQ(out.valid_out(x, 4), 1) << x;
      }
    }
  }
  // Where no tap has light, a pixel keeps its value, and the next level has no tap there either.
  picture.From(0, [&](int x, int y) { picture.valid(x, y) = 0; });
  picture.colour[0](20, 4) = 0.5f;
  for (const Version version : kVersions) {
    const Filtered out = RunStage(version, picture, {kAtrousSvgf, 2, 1}, MakeParameters());
    EXPECT_EQ(out.planes.colour[0](20, 4), 0.5f);
    EXPECT_EQ(out.valid_out(20, 4), 0);
  }
}

TEST(Atrous, PixelsWithoutASurfacePassThrough) {
  Picture picture(33, 9);
  picture.From(25, [&](int x, int y) {
    picture.guides.inverse_depth(x, y) = picture.guides.depth(x, y) = 0;
    picture.guides.normal[2](x, y) = 0;
    picture.valid(x, y) = 0;
    picture.colour[0](x, y) = 7 + static_cast<float>(x);
  });
  for (const int weights : {kAtrousNaive, kAtrousSvgf, kAtrousEaw}) {
    for (const Version version : kVersions) {
      const Filtered out = RunStage(version, picture, {weights, 2, 2}, MakeParameters());
      for (int x = 25; x < 33; ++x) {
        EXPECT_EQ(out.planes.colour[0](x, 4), 7 + static_cast<float>(x));
        EXPECT_EQ(out.planes.variance(x, 4), 1);
      }
      EXPECT_NEAR(out.planes.colour[0](24, 4), 1, 1e-6f);
    }
  }
}

/// All that can differ from pixel to pixel.
Picture MakeBusyPicture(int width, int height, float lit) {
  Picture picture(width, height);
  picture.guides.turn2 = Image1(width, height);
  picture.From(0, [&](int x, int y) {
    GuidePlanes& g = picture.guides;
    const bool sky = test::RandomAt(x / 5, y / 4, 1) < 0.15f;
    g.inverse_depth(x, y) = sky ? 0.0f : 0.25f + 0.005f * test::RandomAt(x / 3, y, 2);
    g.depth(x, y) = sky ? 0.0f : 1 / g.inverse_depth(x, y);
    const float bend = sky ? 0.0f : 0.3f * test::RandomAt(x, y / 2, 3);
    g.normal[0](x, y) = std::sin(bend);
    g.normal[2](x, y) = sky ? 0.0f : std::cos(bend);
    g.turn2(x, y) = 0.1f * test::RandomAt(x, y, 13);
    g.gradient[0](x, y) = 1e-3f * test::RandomAt(x, y, 4);
    g.id(x, y) = 1 + static_cast<uint32_t>(2 * test::RandomAt(x / 11, y / 5, 5));
    const bool valid = !sky && test::RandomAt(x, y, 6) < lit;
    picture.valid(x, y) = valid ? 1.0f : 0.0f;
    picture.variance(x, y) = valid ? test::RandomAt(x, y, 7) : 0.0f;
    picture.luminance_factor(x, y) = valid ? 4 * test::RandomAt(x, y, 8) : 0.0f;
    for (uint32_t c = 0; c < 3; ++c) {
      picture.colour[static_cast<int>(c)](x, y) = valid ? 2 * test::RandomAt(x, y, 9 + c) : 0.0f;
    }
  });
  return picture;
}

/// kAtrousGeometry leaves pixels without light undefined.
void ClearUndefined(const Picture& picture, Filtered* filtered) {
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (!(picture.valid(x, y) > 0)) {
        filtered->planes.colour[0](x, y) = filtered->planes.colour[1](x, y) = 0;
        filtered->planes.variance(x, y) = 0;
      }
    }
  }
}

void CompareVersions(const Picture& picture, const AtrousLevel& level, const AtrousParameters& p,
                     const Image1* pilot = nullptr) {
  Filtered expected = RunStage(&reference::Atrous, picture, level, p, pilot);
  Filtered got = RunStage(&cpu::Atrous, picture, level, p, pilot);
  if (level.weights == kAtrousGeometry) {
    ClearUndefined(picture, &expected);
    ClearUndefined(picture, &got);
  }
  // Exponentials are approximated to 1.5e-5 at best; weights of large exponents are less exact.
  const int channels = level.weights == kAtrousGeometry ? 2 : 3;
  for (int c = 0; c < channels; ++c) {
    test::ExpectNear(got.planes.colour[c], expected.planes.colour[c], 1e-3, 1e-4);
  }
  test::ExpectNear(got.planes.variance, expected.planes.variance, 1e-3, 1e-4);
  if (level.weights != kAtrousGeometry) {
    test::ExpectEqual(got.valid_out, expected.valid_out);
  }
}

// Two halves with the same light; what separates them is the pilot. And the other way round.
TEST(Atrous, ThePilotDecidesInPlaceOfTheLight) {
  Picture picture(24, 8);
  Image1 pilot(24, 8, kBorder);
  picture.From(0, [&](int x, int y) {
    picture.luminance_factor(x, y) = 100;
    picture.colour[0](x, y) = x % 2 == 0 ? 0.0f : 2.0f;
    pilot(x, y) = x < 12 ? 1.0f : 3.0f;
  });
  picture.From(12, [&](int x, int y) { picture.colour[1](x, y) = 5; });
  for (const Version version : kVersions) {
    const Filtered with = RunStage(version, picture, {kAtrousSvgf, 2, 1}, MakeParameters(), &pilot);
    const Filtered without = RunStage(version, picture, {kAtrousSvgf, 2, 1}, MakeParameters());
    EXPECT_NEAR(with.planes.colour[0](6, 4), 1, 1e-5) << "noise is averaged";
    EXPECT_NEAR(with.planes.colour[1](11, 4), 1, 1e-5) << "nothing leaks over the pilot's edge";
    EXPECT_NEAR(with.planes.colour[1](12, 4), 5, 1e-5);
    EXPECT_NEAR(without.planes.colour[0](6, 4), 0, 1e-5);
  }
}

// Light as samples give it, 0 or 10: without a pilot bright pixels are refused, and the mean falls.
TEST(Atrous, ThePilotKeepsTheMeanOfSparseLight) {
  constexpr int kSize = 96;
  Picture picture(kSize, kSize);
  double given = 0;
  picture.From(0, [&](int x, int y) {
    const float l = test::RandomAt(x, y, 1) < 0.1f ? 10.0f : 0.0f;
    given += l;
    for (int c = 0; c < 3; ++c) {
      picture.colour[c](x, y) = l;
    }
    picture.variance(x, y) = 9;
  });
  Image1 pilot(kSize, kSize, kBorder);
  const AtrousParameters p = MakeParameters();
  for (const Version version : kVersions) {
    const Filtered mean = RunStage(version, picture, PilotLevel(0), p);
    const auto sum = [&](const Image1* compared, float deviation) {
      picture.luminance_factor.Fill(1.44269504f / (3 * deviation));
      const Filtered out = RunStage(version, picture, {kAtrousSvgf, 2, 1}, p, compared);
      double total = 0;
      picture.From(0, [&](int x, int y) { total += out.planes.colour[0](x, y); });
      return total / given;
    };
    // The deviation of a pixel, and that of the mean of 3x3.
    EXPECT_LT(sum(nullptr, 3.0f), 0.8);
    EXPECT_GT(sum(&mean.planes.colour[0], 1.0f), 0.9);
    EXPECT_LT(sum(&mean.planes.colour[0], 1.0f), 1.03);
  }
}

// Taller than the rows that are unpacked at once, in every order of rows.
TEST(Atrous, PackedNormalsMatchTheReference) {
  for (const auto& [width, height] : {std::pair{5, 3}, std::pair{37, 61}}) {
    SCOPED_TRACE(width);
    const Picture packed = WithPackedNormals(MakeBusyPicture(width, height, 0.8f));
    Picture rounded = packed;
    rounded.guides.packed_normal = Plane<uint32_t>();
    rounded.guides.normal = Image3(width, height, kBorder);
    rounded.From(0, [&](int x, int y) {
      const vec3 n = NormalAt(packed.guides, x, y);
      for (int c = 0; c < 3; ++c) {
        rounded.guides.normal[c](x, y) = n[c];
      }
    });
    test::OnEveryTarget([&] {
      for (const int weights : kAllWeights) {
        for (const AtrousLevel& level :
             {AtrousLevel{weights, 1, 1}, {weights, 2, 1}, {weights, 1, 16}, {weights, 2, 5}}) {
          SCOPED_TRACE("weights " + std::to_string(weights) + " radius " +
                       std::to_string(level.radius) + " step " + std::to_string(level.step));
          AtrousParameters curved = MakeParameters();
          curved.edges.curvature = 0.5f;
          for (const AtrousParameters& p : {MakeParameters(), curved}) {
            CompareVersions(packed, level, p);
            Filtered got = RunStage(&cpu::Atrous, packed, level, p);
            Filtered expected = RunStage(&cpu::Atrous, rounded, level, p);
            if (weights == kAtrousGeometry) {
              ClearUndefined(packed, &got);
              ClearUndefined(packed, &expected);
            }
            test::ExpectNear(got.planes.colour[0], expected.planes.colour[0], 2e-4, 1e-5);
          }
        }
      }
    });
  }
}

/// A cylinder whose normals turn by `turn` radians per column.
Picture MakeCylinder(float turn) {
  Picture picture(33, 9);
  picture.guides.turn2 = Image1(33, 9);
  picture.From(0, [&](int x, int y) {
    const float angle = turn * static_cast<float>(x - 16);
    picture.guides.normal[0](x, y) = std::sin(angle);
    picture.guides.normal[2](x, y) = std::cos(angle);
    picture.guides.turn2(x, y) = turn * turn;
  });
  return picture;
}

// By hand: where normals turn by a radians per column, the exponent of diffuse light is
// sigma_n / (1 + curvature sigma_n a^2), that of specular light 32 if that is more.
TEST(Atrous, SpecularLightIsNotBlurredAcrossStrongTurns) {
  AtrousParameters p = MakeParameters();
  p.edges.sigma_n = 128;
  p.edges.curvature = 0.5f;
  const AtrousLevel level = {kAtrousSvgf, 1, 1};
  for (const Version version : kVersions) {
    for (const double turn : {0.1, 0.2, 0.3, 0.4}) {
      SCOPED_TRACE(turn);
      Picture picture = MakeCylinder(static_cast<float>(turn));
      for (int y = 0; y < picture.height; ++y) {
        picture.colour[0](16, y) = 5;
      }
      const float diffuse = RunStage(version, picture, level, p).planes.colour[0](16, 4);
      picture.reflected = true;
      const float specular = RunStage(version, picture, level, p).planes.colour[0](16, 4);
      const auto expected = [&](double least) {
        const double exponent = std::max(128 / (1 + 0.5 * 128 * turn * turn), least);
        const double neighbour = 0.5 * std::pow(std::cos(turn), exponent);
        return (0.5 * 5 + neighbour) / (0.5 + neighbour);
      };
      // The logarithm of the cosine is to second order.
      EXPECT_NEAR(diffuse, expected(8), 0.02);
      EXPECT_NEAR(specular, expected(32), 0.02);
      EXPECT_TRUE(turn < 0.21 ? specular == diffuse : specular > diffuse + 0.2f);
    }
  }
}

// The exponents of specular light replace those of other light: no signal sees another's.
TEST(Atrous, SpecularLightBesideOtherLightIsFilteredAsAlone) {
  AtrousParameters p = MakeParameters();
  p.edges.curvature = 0.5f;
  p.noise_ratio = 1.5f;
  Picture picture = MakeBusyPicture(53, 21, 1.0f);
  const Filtered diffuse = RunStage(&cpu::Atrous, picture, {kAtrousSvgf, 2, 2}, p);
  picture.reflected = true;
  const Filtered specular = RunStage(&cpu::Atrous, picture, {kAtrousSvgf, 2, 2}, p);
  Filtered out[3] = {Filtered(picture), Filtered(picture), Filtered(picture)};
  std::vector<AtrousSignal> signals;
  for (const int i : {0, 1, 2}) {
    signals.push_back({&picture.colour, &picture.variance, &out[i].planes,
                       &picture.luminance_factor, &picture.valid});
    signals.back().reflected = i == 1;
  }
  cpu::Atrous(signals, picture.guides, {kAtrousSvgf, 2, 2}, p);
  for (const int i : {0, 1, 2}) {
    const Filtered& alone = i == 1 ? specular : diffuse;
    test::ExpectEqual(out[i].planes.colour[0], alone.planes.colour[0]);
    test::ExpectEqual(out[i].planes.variance, alone.planes.variance);
  }
  float difference = 0;
  picture.From(0, [&](int x, int y) {
    difference = std::max(
        difference, std::abs(diffuse.planes.colour[0](x, y) - specular.planes.colour[0](x, y)));
  });
  EXPECT_GT(difference, 0.01f);
}

/// Runs a geometry-only level with the flags that spare it tests.
Filtered RunDense(Version atrous, const Picture& picture, const AtrousLevel& level,
                  const AtrousParameters& p, const Image1* mixed_length = nullptr) {
  const bool complete = mixed_length != nullptr;
  Filtered out(picture);
  AtrousSignal signal = {&picture.colour, &picture.variance, &out.planes, nullptr, &picture.valid};
  signal.all_valid = signal.luminance_only = complete;
  signal.zero_where_absent = !complete;
  signal.mixed_length = mixed_length;
  signal.mixed_full = 4;
  atrous({&signal, 1}, picture.guides, level, p);
  return out;
}

// Nothing is tested where planes are zero without light; there the result is zero.
TEST(Atrous, ZerosNeedNoTests) {
  test::ForSizesAndTargets([](int width, int height) {
    const Picture picture = MakeBusyPicture(width, height, 0.8f);
    AtrousParameters curved = MakeParameters();
    curved.edges.curvature = 0.5f;
    AtrousParameters low = MakeParameters();
    low.edges.sigma_n = 16;
    AtrousParameters gradient = low;
    gradient.edges.depth_weight_plane = 0;
    gradient.wavelet_id = 1;  // not compared with geometry-only weights
    for (const AtrousParameters& p :
         {MakeParameters(), curved, low, gradient, ByPosition(low, width, height)}) {
      for (const AtrousLevel& level : {AtrousLevel{kAtrousGeometry, 1, 1, true},
                                       {kAtrousGeometry, 1, 3, true},
                                       {kAtrousGeometry, 2, 8, true}}) {
        Filtered expected = RunStage(&reference::Atrous, picture, level, p);
        ClearUndefined(picture, &expected);
        const Filtered got = RunDense(&cpu::Atrous, picture, level, p);
        for (const int c : {0, 1}) {
          test::ExpectNear(got.planes.colour[c], expected.planes.colour[c], 2e-3, 2e-4);
        }
        test::ExpectNear(got.planes.variance, expected.planes.variance, 2e-3, 2e-4);
      }
    }
  });
}

// The same bits as the level and the stage after it.
TEST(Atrous, MixesThePilotItself) {
  test::ForSizesAndTargets([](int width, int height) {
    Picture picture = MakeBusyPicture(width, height, 1.0f);
    Image1 length(width, height);
    picture.From(0, [&](int x, int y) { length(x, y) = 9 * test::RandomAt(x, y, 21); });
    for (const int step : {1, 2}) {
      const AtrousLevel level = {kAtrousGeometry, 1, step, true};
      AtrousParameters p = MakeParameters();
      p.edges.curvature = 0.5f;
      const Filtered got = RunDense(&cpu::Atrous, picture, level, p, &length);
      Filtered expected = RunDense(&cpu::Atrous, picture, level, p);
      Image1& mean = expected.planes.colour[0];
      cpu::MixPilot({&picture.colour[0], &picture.variance, &length}, 4, &mean,
                    &expected.planes.variance);
      picture.From(0, [&](int x, int y) {
        if (picture.valid(x, y) > 0) {
          ASSERT_EQ(got.planes.colour[0](x, y), mean(x, y)) << x << " " << y;
          ASSERT_EQ(got.planes.variance(x, y), expected.planes.variance(x, y)) << x << " " << y;
        }
      });
    }
  });
}

TEST(Atrous, VectorsMatchTheReference) {
  test::ForSizesAndTargets([](int width, int height) {
    for (const float lit : {0.1f, 0.8f, 1.0f}) {
      const Picture picture = MakeBusyPicture(width, height, lit);
      Picture reflected = picture;
      reflected.reflected = true;
      for (const int weights : kAllWeights) {
        for (const AtrousLevel& level : {AtrousLevel{weights, 1, 1},
                                         {weights, 2, 1},
                                         {weights, 1, 4},
                                         {weights, 2, 8},
                                         {weights, 1, 3, weights == kAtrousGeometry}}) {
          SCOPED_TRACE("weights " + std::to_string(weights) + " radius " +
                       std::to_string(level.radius) + " step " + std::to_string(level.step));
          CompareVersions(picture, level, MakeParameters());
          AtrousParameters other = MakeParameters();
          other.edges.depth_weight_plane = 0;
          other.wavelet_id = 1;
          other.noise_ratio = 1.5f;
          CompareVersions(picture, level, other);
          AtrousParameters curved = MakeParameters();
          curved.edges.curvature = 0.5f;
          CompareVersions(picture, level, curved);
          other.edges.curvature = 2;
          CompareVersions(picture, level, other);
          CompareVersions(picture, level, curved, &picture.variance);
          CompareVersions(reflected, level, curved, &picture.variance);
          CompareVersions(reflected, level, other);
          for (const AtrousParameters& any : {MakeParameters(), other, curved}) {
            CompareVersions(picture, level, ByPosition(any, width, height, 0.3f));
            CompareVersions(reflected, level, ByPosition(any, width, height, 0.3f));
          }
          AtrousParameters low = MakeParameters();
          low.edges.sigma_n = 16;  // by the logarithm
          CompareVersions(picture, level, ByPosition(low, width, height));
        }
      }
    }
  });
}

}  // namespace
}  // namespace stillray::atrous_test

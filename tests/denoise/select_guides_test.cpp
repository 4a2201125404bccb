// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/select_guides.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "denoise/guide_source.h"
#include "stage_test.h"

namespace stillray::select_guides_test {
namespace {

using test::MakePlane;
using test::RandomAt;
using test::RandomImage;
using test::RandomPlane;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(SelectGuides, Formulas) {
  EXPECT_TRUE(ShowsImage(1, 2, 0.1f, 0.1f));
  EXPECT_TRUE(ShowsImage(1, kInfinity, 0, 0.1f));  // the sky in a mirror
  EXPECT_FALSE(ShowsImage(1, 0, 0, 0.1f));         // no image
  EXPECT_FALSE(ShowsImage(1, -1, 0, 0.1f));
  EXPECT_FALSE(ShowsImage(1, kNan, 0, 0.1f));
  EXPECT_FALSE(ShowsImage(kInfinity, 2, 0, 0.1f));  // no surface
  EXPECT_FALSE(ShowsImage(0, 2, 0, 0.1f));
  EXPECT_FALSE(ShowsImage(1, 2, 0.11f, 0.1f));
  EXPECT_FALSE(ShowsImage(1, 2, kNan, 0.1f));
  EXPECT_EQ(ImageDepth(3), 3);
  EXPECT_EQ(ImageDepth(kInfinity), kImageOfSky);
  EXPECT_TRUE(IsNormalLength2(1));
  EXPECT_FALSE(IsNormalLength2(0));
  EXPECT_FALSE(IsNormalLength2(kNan));
  EXPECT_FALSE(IsNormalLength2(kInfinity));
  EXPECT_EQ(SeenAlbedo(0.25f), 0.25f);
  EXPECT_EQ(SeenAlbedo(kNan), 1);
  EXPECT_EQ(SeenAlbedo(-1), 1);
  EXPECT_TRUE(HasNoLight(vec3(0, 0, 0)));
  EXPECT_FALSE(HasNoLight(vec3(0, 1e-6f, 0)));
  EXPECT_FALSE(HasNoLight(vec3(0, 0, kNan)));
}

Image2 RandomMotion(int width, int height, uint32_t seed) {
  Image2 motion;
  motion[0] = RandomPlane(width, height, seed);
  motion[1] = RandomPlane(width, height, seed + 1);
  return motion;
}

/// Guides of a surface and of the image in it, with invalid values among them.
struct Inputs {
  Guides surface;
  VirtualGuides image;
  Image1 roughness;

  Inputs(int width, int height) {
    surface.depth = RandomPlane(width, height, 1, 4);
    surface.normal = RandomImage<Image3>(width, height, 2);
    surface.motion = RandomMotion(width, height, 30);
    surface.specular_albedo = RandomImage<Image3>(width, height, 4);
    surface.id = Plane<uint32_t>(width, height);
    image.depth = MakePlane(width, height, [](int x, int y) {
      const float u = RandomAt(x, y, 5);
      return u < 0.1f ? kNan : u < 0.2f ? kInfinity : u < 0.5f ? 0.0f : 8 * u;
    });
    image.normal = RandomImage<Image3>(width, height, 6);
    image.albedo = RandomImage<Image3>(width, height, 7);
    image.motion = RandomMotion(width, height, 80);
    image.id = Plane<uint32_t>(width, height);
    roughness = RandomPlane(width, height, 9, 1);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        surface.id(x, y) = static_cast<uint32_t>(x);
        image.id(x, y) = 1000 + static_cast<uint32_t>(x);
        for (int c = 0; c < 3 && x % 11 == 10; ++c) {
          surface.specular_albedo[c](x, y) = c == 1 ? 1e-3f * static_cast<float>(y % 2) : 0.0f;
        }
        if (x % 7 == 3) {
          image.normal[1](x, y) = kNan;
          image.albedo[2](x, y) = kInfinity;
        }
      }
    }
  }
};

TEST(SelectGuides, TakesTheImageWhereThereIsOne) {
  for (const auto& version : {&reference::SelectGuides, &cpu::SelectGuides}) {
    Inputs in(4, 1);
    in.surface.depth.Fill(2);
    in.roughness.Fill(0.1f);
    in.roughness(3, 0) = 0.5f;
    for (int x = 0; x < 4; ++x) {
      const float depth[4] = {0, 5, kInfinity, 5};
      in.image.depth(x, 0) = depth[x];
      for (int c = 0; c < 3; ++c) {
        in.image.normal[c](x, 0) = x == 2 ? 0.0f : 0.5f;
      }
    }
    Guides out;
    Image3 albedo;
    version({&in.surface, &in.image, &in.roughness, &in.surface.specular_albedo},
            {0.2f, 1.0f, 0.0f}, &out, &albedo);
    EXPECT_EQ(out.depth(0, 0), 2);
    EXPECT_EQ(out.depth(1, 0), 5);
    EXPECT_EQ(out.depth(2, 0), kImageOfSky);
    EXPECT_EQ(out.depth(3, 0), 2);  // rough
    EXPECT_EQ(out.normal[0](1, 0), 0.5f);
    EXPECT_EQ(out.normal[0](2, 0), in.surface.normal[0](2, 0));  // the sky has none
    EXPECT_EQ(out.motion[1](0, 0), in.surface.motion[1](0, 0));
    EXPECT_EQ(out.motion[1](1, 0), in.image.motion[1](1, 0));
    EXPECT_EQ(out.id(0, 0), 0u);
    EXPECT_EQ(out.id(1, 0), 1001u);
    EXPECT_EQ(out.roughness(1, 0), kRoughnessOfImage);
    EXPECT_EQ(out.roughness(3, 0), 0.5f);
    EXPECT_FLOAT_EQ(albedo[0](1, 0),
                    in.surface.specular_albedo[0](1, 0) * in.image.albedo[0](1, 0));
    EXPECT_EQ(albedo[0](3, 0), in.surface.specular_albedo[0](3, 0));
  }
}

// A pane shows what is beside it too, in the same place: the normals tell which is seen through it.
TEST(SelectGuides, NormalsOfTransmittedImagesAreNegated) {
  EXPECT_EQ(SelectGuidesOf(Settings(), GuideSource::kReflection).image_normal, 1);
  const SelectGuidesParameters parameters = SelectGuidesOf(Settings(), GuideSource::kRefraction);
  for (const auto& version : {&reference::SelectGuides, &cpu::SelectGuides}) {
    Inputs in(3, 1);
    in.surface.depth.Fill(2);
    in.roughness.Fill(0.5f);  // of an alpha-blended surface
    in.image.depth.Fill(5);
    in.image.depth(2, 0) = 0;
    for (int c = 0; c < 3; ++c) {
      in.image.normal[c](0, 0) = 0.5f;
      in.image.normal[c](1, 0) = 0;  // not given
    }
    Guides out;
    Image3 albedo;
    version({&in.surface, &in.image, &in.roughness, &in.surface.specular_albedo}, parameters, &out,
            &albedo);
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(out.normal[c](0, 0), -0.5f);
      EXPECT_EQ(out.normal[c](1, 0), -in.surface.normal[c](1, 0));
      EXPECT_EQ(out.normal[c](2, 0), in.surface.normal[c](2, 0));
    }
  }
}

TEST(SelectGuides, PixelsWithoutLightHaveNoSurface) {
  for (const auto& version : {&reference::SelectGuides, &cpu::SelectGuides}) {
    Inputs in(3, 1);
    in.surface.depth.Fill(2);
    in.roughness.Fill(0.1f);
    in.image.depth.Fill(5);
    in.image.depth(1, 0) = 0;
    for (int c = 0; c < 3; ++c) {
      in.surface.specular_albedo[c].Fill(0);
    }
    in.surface.specular_albedo[2](2, 0) = 0.01f;  // little light, in one channel
    Guides out;
    Image3 albedo;
    version({&in.surface, &in.image, &in.roughness, &in.surface.specular_albedo},
            {0.2f, 1.0f, 0.0f}, &out, &albedo);
    EXPECT_EQ(out.depth(0, 0), kInfinity);
    EXPECT_EQ(out.depth(1, 0), kInfinity);
    EXPECT_EQ(out.depth(2, 0), 5);
  }
}

TEST(SelectGuides, ImagesThatAreNotGivenAreThoseOfTheSurface) {
  for (const auto& version : {&reference::SelectGuides, &cpu::SelectGuides}) {
    Inputs in(9, 5);
    in.image.depth(0, 0) = 0;
    in.image.depth(1, 0) = 5;
    in.image.normal = Image3();
    in.image.albedo = Image3();
    in.image.motion = Image2();
    in.image.id = Plane<uint32_t>();
    in.surface.specular_albedo = Image3();
    const Image1 unknown;
    Guides out;
    Image3 albedo;
    version({&in.surface, &in.image, &unknown, &in.surface.specular_albedo}, {0.2f, 1.0f, 0.0f},
            &out, &albedo);
    test::ExpectEqual(out.normal[0], in.surface.normal[0]);
    test::ExpectEqual(out.motion[0], in.surface.motion[0]);
    test::ExpectEqual(out.id, in.surface.id);
    EXPECT_EQ(out.roughness(0, 0), 1);
    EXPECT_EQ(out.roughness(1, 0), kRoughnessOfImage);
    EXPECT_TRUE(albedo.empty());
  }
}

TEST(SelectGuides, FormulasOfImageMotion) {
  EXPECT_TRUE(MayMoveWithImage(1, 2, 0.3f, 0.1f, 0.5f));
  EXPECT_FALSE(MayMoveWithImage(1, 2, 0.1f, 0.1f, 0.5f));  // shows the image
  EXPECT_FALSE(MayMoveWithImage(1, 2, 0.6f, 0.1f, 0.5f));
  EXPECT_FALSE(MayMoveWithImage(1, 0, 0.3f, 0.1f, 0.5f));  // no image
  EXPECT_FALSE(MayMoveWithImage(1, 2, kNan, 0.1f, 0.5f));
  EXPECT_TRUE(IsSameReflector({0, 0, 1}, 3, {0, 0, 2}, 3));
  EXPECT_FALSE(IsSameReflector({0, 0, 1}, 3, {0, 0, 1}, 4));
  EXPECT_TRUE(IsSameReflector({0, 0, 1}, 0, {0.59f, 0, 0.81f}, 0));
  EXPECT_FALSE(IsSameReflector({0, 0, 1}, 0, {0.61f, 0, 0.79f}, 0));
  EXPECT_FALSE(IsSameReflector({0, 0, 1}, 0, {0, 0, -1}, 0));
  EXPECT_FALSE(IsSameReflector({0, 0, 0}, 0, {0, 0, 0}, 0));  // no surface
  EXPECT_FALSE(IsSameReflector({0, 0, kNan}, 0, {0, 0, 1}, 0));
  const vec4 one = AddImageMotion(vec4(0.0f), {3, 4});
  EXPECT_EQ(one, vec4(3, 4, 25, 1));
  EXPECT_EQ(AddImageMotion(one, {kNan, 0}), one);
  EXPECT_EQ(AddImageMotion(one, {1e6f, 0}), one);
  EXPECT_EQ(MeanImageMotion(AddImageMotion(one, {1, 0})), vec2(2, 2));
  EXPECT_FALSE(AreMotionsAlike(vec4(0.0f)));
  EXPECT_TRUE(AreMotionsAlike(one));
  // Mean 2, standard deviation 0.5 and 1.
  EXPECT_TRUE(AreMotionsAlike(AddImageMotion(AddImageMotion(vec4(0.0f), {1.5f, 0}), {2.5f, 0})));
  EXPECT_FALSE(AreMotionsAlike(AddImageMotion(AddImageMotion(vec4(0.0f), {1, 0}), {3, 0})));
  EXPECT_TRUE(IsAtSameDepth(10, 10.2f, {5, 0}));
  EXPECT_FALSE(IsAtSameDepth(10, 10.4f, {5, 0}));
  EXPECT_TRUE(IsAtSameDepth(10, 12, {1, -1}));
  EXPECT_FALSE(IsAtSameDepth(10, kNan, {5, 0}));
}

/// A rough reflector, whose image moves by (3, 0) pixels more than its surface.
struct RoughReflector {
  Guides surface;
  VirtualGuides image;
  Image1 roughness;

  RoughReflector(int width, int height) {
    surface.depth = Image1(width, height);
    surface.depth.Fill(2);
    surface.normal = Image3(width, height);
    surface.normal[2].Fill(1);
    surface.motion = RandomMotion(width, height, 30);
    surface.id = Plane<uint32_t>(width, height);
    image.depth = Image1(width, height);
    image.depth.Fill(5);
    image.motion = surface.motion;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        image.motion[0](x, y) += 3;
        surface.id(x, y) = 1;
      }
    }
    roughness = Image1(width, height);
    roughness.Fill(0.3f);
  }

  /// What its light moves by at a pixel, less the surface.
  vec2 OffsetAt(int x, int y, float most = 0.5f) const {
    vec2 offset(kNan);
    for (const auto& version : {&reference::SelectGuides, &cpu::SelectGuides}) {
      Guides out;
      Image3 albedo;
      version({&surface, &image, &roughness, &surface.specular_albedo}, {0.1f, 1.0f, most}, &out,
              &albedo);
      EXPECT_EQ(out.depth(x, y), surface.depth(x, y));
      EXPECT_EQ(out.normal[2](x, y), surface.normal[2](x, y));
      EXPECT_EQ(out.id(x, y), surface.id(x, y));
      EXPECT_EQ(out.roughness(x, y), roughness(x, y));
      const vec2 found(out.motion[0](x, y) - surface.motion[0](x, y),
                       out.motion[1](x, y) - surface.motion[1](x, y));
      EXPECT_TRUE(version == &reference::SelectGuides || found == offset);
      offset = found;
    }
    return offset;
  }
};

TEST(SelectGuides, LightOfRoughReflectorsMovesWithTheImage) {
  const RoughReflector in(24, 9);
  const vec2 offset = in.OffsetAt(9, 4);
  EXPECT_NEAR(offset.x, 3, 1e-5f);
  EXPECT_NEAR(offset.y, 0, 1e-5f);
  EXPECT_EQ(in.OffsetAt(9, 4, 0.2f), vec2(0.0f));  // too rough
  EXPECT_EQ(in.OffsetAt(22, 4), vec2(0.0f));       // out of the picture
}

TEST(SelectGuides, LightOfRoughReflectorsStaysOnThem) {
  RoughReflector other_id(24, 9);
  other_id.surface.id(12, 4) = 2;
  EXPECT_EQ(other_id.OffsetAt(9, 4), vec2(0.0f));
  RoughReflector edge(24, 9);
  edge.surface.normal[2](12, 4) = 0;
  edge.surface.normal[0](12, 4) = 1;
  EXPECT_EQ(edge.OffsetAt(9, 4), vec2(0.0f));
  RoughReflector step(24, 9);
  step.surface.depth(12, 4) = 3;
  EXPECT_EQ(step.OffsetAt(9, 4), vec2(0.0f));
}

TEST(SelectGuides, LightOfDetailedReflectorsMovesWithTheSurface) {
  RoughReflector in(24, 9);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 24; ++x) {
      in.image.motion[0](x, y) = in.surface.motion[0](x, y) + (x / 3 % 2 == 0 ? 3.0f : -3.0f);
    }
  }
  EXPECT_EQ(in.OffsetAt(9, 4), vec2(0.0f));
  // Where nothing is known of the image around, the pixel's own is used.
  in.image.depth.Fill(kNan);
  in.image.depth(9, 4) = kInfinity;
  EXPECT_NEAR(in.OffsetAt(9, 4).x, -3, 1e-5f);
  in.image.motion[0](9, 4) = kNan;
  EXPECT_EQ(in.OffsetAt(9, 4), vec2(0.0f));
}

TEST(SelectGuides, VersionsAgree) {
  test::ForSizesAndTargets([](int width, int height) {
    const Inputs in(width, height);
    const SelectGuidesInput given = {&in.surface, &in.image, &in.roughness,
                                     &in.surface.specular_albedo};
    for (const float image_normal : {1.0f, -1.0f}) {
      const SelectGuidesParameters parameters = {0.4f, image_normal, 0.8f};
      Guides expected;
      Guides got;
      Image3 expected_albedo;
      Image3 got_albedo;
      reference::SelectGuides(given, parameters, &expected, &expected_albedo);
      cpu::SelectGuides(given, parameters, &got, &got_albedo);
      test::ExpectEqual(got.depth, expected.depth);
      test::ExpectEqual(got.id, expected.id);
      test::ExpectEqual(got.roughness, expected.roughness);
      for (int c = 0; c < 3; ++c) {
        test::ExpectEqual(got.normal[c], expected.normal[c]);
        test::ExpectEqual(got_albedo[c], expected_albedo[c]);
      }
      for (int c = 0; c < 2; ++c) {
        test::ExpectEqual(got.motion[c], expected.motion[c]);
      }
    }
  });
}

}  // namespace
}  // namespace stillray::select_guides_test

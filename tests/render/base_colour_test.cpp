// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Base colours averaged over the pixel, against means over many points of the pixel in double
// precision.
#include "render/base_colour.h"

#include <cmath>
#include <functional>

#include "core/random.h"
#include "render/texture.h"
#include "test_scenes.h"

namespace stillray::render::base_colour_test {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr int kWidth = 64;
constexpr int kHeight = 48;

RenderSettings Size(bool filter) {
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  settings.jitter = true;
  settings.filter_textures = filter;
  return settings;
}

/// Random texels, none of them black: neighbours have nothing in common.
Texture NoiseTexture(int width, int height) {
  Texture texture;
  texture.width = width;
  texture.height = height;
  texture.wrap_u = texture.wrap_v = Wrap::kRepeat;
  for (int i = 0; i < width * height; ++i) {
    const uint32_t bits = HashU32(static_cast<uint32_t>(i));
    for (int c = 0; c < 3; ++c) {
      texture.texels.push_back(static_cast<uint8_t>(80 + (bits >> (8 * c) & 127u)));
    }
    texture.texels.push_back(255);
  }
  return texture;
}

/// A white diffuse material with the scene's first texture.
Material Textured() {
  Material material = Lambert(vec3(1.0f));
  material.base_color_texture.texture = 0;
  return material;
}

/// The camera of SceneBuilder at the origin, looking along -z.
dvec3 DirectionOf(dvec2 p) {
  const double focal = kHeight * 0.5 / std::tan(0.4);
  return glm::normalize(dvec3((p.x - 0.5 * kWidth) / focal, -(p.y - 0.5 * kHeight) / focal, -1.0));
}

/// A parallelogram in double precision, with the texture coordinates of Quad.
struct Parallelogram {
  dvec3 corner, x, y;

  double Distance(dvec3 origin, dvec3 direction) const {
    const dvec3 n = glm::cross(x, y);
    return glm::dot(corner - origin, n) / glm::dot(direction, n);
  }
  dvec2 UvAt(dvec3 point) const {
    const dvec3 n = glm::cross(x, y);
    const dvec3 offset = point - corner;
    return {glm::dot(glm::cross(offset, y), n) / glm::dot(n, n),
            glm::dot(glm::cross(x, offset), n) / glm::dot(n, n)};
  }
  Mesh mesh() const { return Quad(vec3(corner), vec3(x), vec3(y)); }
};

using ColourAt = std::function<vec3(dvec2 image_point)>;

dvec3 MeanOverPixel(const ColourAt& colour_at, int x, int y) {
  constexpr int kSide = 24;
  dvec3 sum(0.0);
  for (int i = 0; i < kSide * kSide; ++i) {
    const dvec2 within((i % kSide + 0.5) / kSide, (i / kSide + 0.5) / kSide);
    sum += dvec3(colour_at(dvec2(x, y) + within));
  }
  return sum / static_cast<double>(kSide * kSide);
}

struct Errors {
  double mean = 0;   ///< root mean square
  double worst = 0;  ///< largest
};

/// Errors of an albedo against the mean over each pixel, without these columns and rows at each
/// side of the image.
Errors ErrorsOf(const Image3& albedo, const ColourAt& colour_at, int columns, int rows) {
  Errors errors;
  int count = 0;
  for (int y = rows; y < kHeight - rows; ++y) {
    for (int x = columns; x < kWidth - columns; ++x) {
      const dvec3 expected = MeanOverPixel(colour_at, x, y);
      for (int c = 0; c < 3; ++c) {
        const double e = albedo[c](x, y) - expected[c];
        errors.mean += e * e;
        errors.worst = std::max(errors.worst, std::abs(e));
        ++count;
      }
    }
  }
  errors.mean = std::sqrt(errors.mean / count);
  return errors;
}

RenderMoment JitteredMoment() {
  RenderMoment moment;
  moment.frame_index = 3;
  return moment;
}

vec3 TexelsAt(const Texture& texture, dvec2 uv) {
  return vec3(SampleTexture(texture, vec2(uv), TexelEncoding::kSrgb));
}

// A wall seen at an angle: two to four texels per pixel along each axis.
TEST(BaseColourTest, VisibleTexturesAreMeansOverThePixel) {
  const Parallelogram wall = {dvec3(-30, -20, -4), dvec3(60, 0, -12), dvec3(0, 40, -14)};
  SceneBuilder builder;
  builder.scene.textures = {NoiseTexture(512, 340)};
  builder.Add(wall.mesh(), Textured());
  const ColourAt colour_at = [&](dvec2 p) {
    const dvec3 d = DirectionOf(p);
    return TexelsAt(builder.scene.textures[0], wall.UvAt(d * wall.Distance(dvec3(0.0), d)));
  };
  const auto errors = [&](bool filter) {
    const Frame frame = RenderOne(builder.scene, Size(filter), JitteredMoment());
    return ErrorsOf(frame.guides.albedo, colour_at, 4, 4);
  };
  const Errors points = errors(false);
  const Errors means = errors(true);
  EXPECT_GT(points.mean, 0.05);
  EXPECT_LT(means.mean, 0.2 * points.mean) << points.mean;
  // Along the diagonal of the wall only the part of the pixel in the hit triangle counts.
  EXPECT_LT(means.worst, 0.6 * points.worst) << points.worst;
}

// The pixel of the mirror has its footprint on the wall behind the camera.
struct MirrorRoom {
  Parallelogram wall = {dvec3(20, -15, 3), dvec3(-40, 0, 2), dvec3(0, 30, 1)};
  Parallelogram mirror = {dvec3(-6, -6, -4.5), dvec3(12, 0, 1), dvec3(0, 12, -1)};
  SceneBuilder builder;

  explicit MirrorRoom(const Material& of_wall) {
    builder.scene.textures = {NoiseTexture(200, 150)};
    builder.Add(mirror.mesh(), Metal(vec3(0.8f, 0.9f, 1.0f), 0.0f));
    builder.Add(wall.mesh(), of_wall);
  }
  vec3 ColourAt(dvec2 p) const {
    const dvec3 d = DirectionOf(p);
    const dvec3 n = glm::normalize(glm::cross(mirror.x, mirror.y));
    const dvec3 at = d * mirror.Distance(dvec3(0.0), d);
    const dvec3 onward = glm::reflect(d, n);
    return TexelsAt(builder.scene.textures[0], wall.UvAt(at + onward * wall.Distance(at, onward)));
  }
};

TEST(BaseColourTest, TexturesInAMirrorAreMeansOverThePixel) {
  const MirrorRoom room(Textured());
  const ColourAt colour_at = [&](dvec2 p) { return room.ColourAt(p); };
  const auto errors = [&](bool filter) {
    const Frame frame = RenderOne(room.builder.scene, Size(filter), JitteredMoment());
    return ErrorsOf(frame.reflection.albedo, colour_at, 4, 4);
  };
  const Errors points = errors(false);
  const Errors means = errors(true);
  EXPECT_GT(points.mean, 0.05);
  EXPECT_LT(means.mean, 0.2 * points.mean) << points.mean;
}

// The rays beside that of the pixel diverge by the curvature of the ball.
TEST(BaseColourTest, TexturesInAChromeBallAreMeansOverThePixel) {
  const dvec3 centre(0, 0, -4);
  const Parallelogram wall = {dvec3(60, -60, 8), dvec3(-120, 0, 0), dvec3(0, 120, 0)};
  SceneBuilder builder;
  builder.scene.textures = {NoiseTexture(600, 600)};
  Mesh ball;
  constexpr int kRows = 64;
  constexpr int kColumns = 128;
  for (int j = 0; j <= kRows; ++j) {
    for (int i = 0; i <= kColumns; ++i) {
      const double theta = M_PI * j / kRows;
      const double phi = 2 * M_PI * i / kColumns;
      const vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta),
                   std::sin(theta) * std::sin(phi));
      ball.positions.push_back(vec3(centre) + n);
      ball.normals.push_back(n);
      if (i < kColumns && j < kRows) {
        const auto a = static_cast<uint32_t>(j * (kColumns + 1) + i);
        const uint32_t b = a + kColumns + 1;
        for (const uint32_t corner : {a, a + 1, b, a + 1, b + 1, b}) {
          ball.indices.push_back(corner);
        }
      }
    }
  }
  builder.Add(std::move(ball), Metal(vec3(1.0f), 0.0f));
  builder.Add(wall.mesh(), Textured());
  const ColourAt colour_at = [&](dvec2 p) {
    const dvec3 d = DirectionOf(p);
    const double b = glm::dot(centre, d);
    const double root = b * b - glm::dot(centre, centre) + 1;
    const dvec3 at = d * (b - std::sqrt(root));
    const dvec3 onward = glm::reflect(d, at - centre);
    return TexelsAt(builder.scene.textures[0], wall.UvAt(at + onward * wall.Distance(at, onward)));
  };
  const auto errors = [&](bool filter) {
    const Frame frame = RenderOne(builder.scene, Size(filter), JitteredMoment());
    return ErrorsOf(frame.reflection.albedo, colour_at, 26, 18);  // the front of the ball
  };
  const Errors points = errors(false);
  const Errors means = errors(true);
  EXPECT_GT(points.mean, 0.03);
  // The ball's triangles and normals are not exactly those of a sphere.
  EXPECT_LT(means.mean, 0.25 * points.mean) << points.mean;
}

// Light in a mirror is the product of the image's albedo and what does not depend on the texture:
// demodulated, it has no texture. Equal random numbers give equal paths.
TEST(BaseColourTest, PathsHaveTheColourOfTheImage) {
  const auto render = [](const Material& of_wall) {
    MirrorRoom room(of_wall);
    room.builder.scene.environment.radiance = vec3(1.0f);
    RenderSettings settings = Size(true);
    settings.bounces = 1;
    return RenderOne(room.builder.scene, settings, JitteredMoment());
  };
  const Frame textured = render(Textured());
  const Frame plain = render(Lambert(vec3(1.0f)));
  int compared = 0;
  for (const SignalKind kind : {SignalKind::kDirectSpecular, SignalKind::kIndirectSpecular}) {
    const Image3& light = textured.Find(kind)->radiance;
    const Image3& of_plain = plain.Find(kind)->radiance;
    for (int y = 4; y < kHeight - 4; ++y) {
      for (int x = 4; x < kWidth - 4; ++x) {
        for (int c = 0; c < 3 && of_plain[c](x, y) > 0.01f; ++c) {
          const float expected = of_plain[c](x, y) * textured.reflection.albedo[c](x, y);
          EXPECT_NEAR(light[c](x, y), expected, 1e-4f * expected) << x << " " << y;
          ++compared;
        }
      }
    }
  }
  EXPECT_GT(compared, kWidth * kHeight);
}

TEST(BaseColourTest, WithoutJitterTheColourIsThatOfTheCentre) {
  MirrorRoom room(Textured());
  RenderSettings settings = Size(true);
  settings.jitter = false;
  const Frame frame = RenderOne(room.builder.scene, settings, JitteredMoment());
  for (int y = 6; y < kHeight - 6; y += 5) {
    for (int x = 6; x < kWidth - 6; x += 5) {
      const vec3 expected = room.ColourAt(dvec2(x + 0.5, y + 0.5));
      ExpectNear(Pixel(frame.reflection.albedo, x, y), expected, 0.01f);
    }
  }
}

// Leaves: the colour of transparent texels, often black, is not part of the mean.
TEST(BaseColourTest, TransparentTexelsDoNotCount) {
  SceneBuilder builder;
  Texture leaves = NoiseTexture(400, 400);
  for (size_t i = 0; i < leaves.texels.size(); i += 4) {
    const bool visible = HashU32(static_cast<uint32_t>(i)) % 2 == 0;
    for (size_t c = 0; c < 3; ++c) {
      leaves.texels[i + c] = visible ? 188 : 0;
    }
    leaves.texels[i + 3] = visible ? 255 : 0;
  }
  leaves.nearest = true;
  builder.scene.textures = {leaves};
  Material material = Textured();
  material.alpha_mode = AlphaMode::kMask;
  material.double_sided = true;
  builder.Add(Quad(vec3(-8, -8, -8), vec3(16, 0, 0), vec3(0, 16, 0)), material);
  const Frame frame = RenderOne(builder.scene, Size(true), JitteredMoment());
  int seen = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (frame.guides.id(x, y) != 0) {
        // ((188 / 255 + 0.055) / 1.055)^2.4
        ASSERT_NEAR(frame.guides.albedo[0](x, y), 0.50289f, 1e-4f) << x << " " << y;
        ++seen;
      }
    }
  }
  EXPECT_GT(seen, kWidth * kHeight / 4);
}

TEST(BaseColourTest, FramesWithJitterHaveTheMeanOfTheReference) {
  // Footprints end at the edges of triangles: the mean over all points of a pixel is the same with
  // and without the filter.
  const Parallelogram wall = {dvec3(-1.5, -1, -4), dvec3(3, 0, 0.5), dvec3(0, 2, 0)};
  SceneBuilder builder;
  builder.scene.textures = {NoiseTexture(80, 60)};
  builder.Add(wall.mesh(), Textured());
  const auto mean = [&](bool filter) {
    auto renderer = CreateRenderer(builder.scene, Size(filter));
    EXPECT_TRUE(renderer.ok());
    Image3 sum(kWidth, kHeight);
    Frame frame;
    for (int i = 0; i < 16; ++i) {
      RenderMoment moment;
      moment.frame_index = i;
      EXPECT_TRUE((*renderer)->RenderFrame(moment, &frame).ok());
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          sum[0](x, y) += frame.guides.albedo[0](x, y) / 16;
        }
      }
    }
    return sum;
  };
  const Image3 points = mean(false);
  const Image3 means = mean(true);
  double difference = 0;
  double total = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      difference += means[0](x, y) - points[0](x, y);
      total += points[0](x, y);
    }
  }
  EXPECT_GT(total, 100);
  EXPECT_NEAR(difference / total, 0, 2e-3);
}

TEST(BaseColourTest, OneSampleForEachTexel) {
  EXPECT_EQ(TapsAlong(vec2(0.0f)), 1);
  EXPECT_EQ(TapsAlong(vec2(0.6f, 0.8f)), 1);
  EXPECT_EQ(TapsAlong(vec2(1.01f, 0.0f)), 2);
  EXPECT_EQ(TapsAlong(vec2(3.0f, 4.0f)), 5);
  EXPECT_EQ(TapsAlong(vec2(1e6f)), kMostTaps);
  EXPECT_EQ(TapsAlong(vec2(std::nanf(""))), kMostTaps);  // finite in any case
}

TEST(BaseColourTest, RaysThatMissThePlaneHaveNoFootprint) {
  const vec3 u(1, 0, 0);
  const vec3 v(0, 1, 0);
  const ChainRay hit = {vec3(0, 0, 2), vec3(0, 0, -1)};
  for (const vec3& direction : {vec3(1, 0, 0), vec3(0, 0, 1), vec3(std::nanf(""))}) {
    const ChainRay miss = {vec3(0, 0, 2), direction};
    const Footprint footprint = MakeFootprint(u, v, vec3(0.0f), hit, miss);
    EXPECT_EQ(footprint.right, vec2(0.0f));
    EXPECT_EQ(footprint.down, vec2(0.0f));
  }
  // Half a pixel apart: 0.25 along u is half of the change per pixel.
  const ChainRay beside = {vec3(0.25f, 0, 2), vec3(0, 0, -1)};
  const Footprint footprint = MakeFootprint(u, v, vec3(0.0f), beside, hit);
  EXPECT_EQ(footprint.right, vec2(0.5f, 0.0f));
  EXPECT_EQ(footprint.down, vec2(0.0f));
}

}  // namespace
}  // namespace stillray::render::base_colour_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames of less than one path per pixel.
#include <cmath>
#include <cstring>

#include <tbb/global_control.h>

#include "test_scenes.h"

namespace stillray::render::sparse_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 75;
constexpr int kHeight = 52;

SceneBuilder Room() {
  SceneBuilder builder;
  builder.Add(Quad(vec3(-4, -1, 4), vec3(8, 0, 0), vec3(0, 0, -8)),
              Lambert(vec3(0.7f, 0.6f, 0.5f)));
  builder.Add(FacetedSphere(vec3(-0.6f, 0, -3), 0.8f, 2), Metal(vec3(0.9f, 0.7f, 0.4f), 0.3f));
  builder.Add(Quad(vec3(-1, 2.0f, -4), vec3(2, 0, 0), vec3(0, 0, 2)), Emitter(vec3(4.0f)));
  builder.Add(Quad(vec3(0.5f, -1, -4), vec3(1.5f, 0, 0), vec3(0, 2, 0)), Emitter(vec3(0.5f)));
  builder.scene.environment.radiance = vec3(0.1f, 0.15f, 0.2f);
  return builder;
}

RenderSettings SparseSettings(int cycle, GuideCoverage guides) {
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  settings.cycle = cycle;
  settings.guides = guides;
  return settings;
}

RenderMoment MomentOf(int64_t frame) {
  RenderMoment moment;
  moment.frame_index = frame;
  return moment;
}

std::unique_ptr<Renderer> MakeRenderer(const SceneBuilder& builder,
                                       const RenderSettings& settings) {
  auto renderer = Renderer::Create(builder.scene, settings);
  EXPECT_TRUE(renderer.ok()) << renderer.status().message();
  return std::move(renderer.value());
}

template <typename T>
void ExpectSame(const Plane<T>& a, const Plane<T>& b, const char* what) {
  ASSERT_EQ(a.width(), b.width()) << what;
  ASSERT_EQ(a.height(), b.height()) << what;
  for (int y = 0; y < a.height(); ++y) {
    ASSERT_EQ(std::memcmp(a.Row(y), b.Row(y), sizeof(T) * static_cast<size_t>(a.width())), 0)
        << what << ", row " << y;
  }
}

template <typename T, int N>
void ExpectSame(const Planes<T, N>& a, const Planes<T, N>& b, const char* what) {
  for (int c = 0; c < N; ++c) {
    ExpectSame(a[c], b[c], what);
  }
}

void ExpectSameFrame(const Frame& a, const Frame& b) {
  ASSERT_EQ(a.signals.size(), b.signals.size());
  for (size_t k = 0; k < a.signals.size(); ++k) {
    ExpectSame(a.signals[k].radiance, b.signals[k].radiance, SignalName(a.signals[k].kind));
  }
  ExpectSame(a.samples, b.samples, "samples");
  ExpectSame(a.guides.depth, b.guides.depth, "depth");
  ExpectSame(a.guides.normal, b.guides.normal, "normal");
  ExpectSame(a.guides.albedo, b.guides.albedo, "albedo");
  ExpectSame(a.guides.specular_albedo, b.guides.specular_albedo, "specular_albedo");
  ExpectSame(a.guides.motion, b.guides.motion, "motion");
  ExpectSame(a.guides.id, b.guides.id, "id");
  ExpectSame(a.guides.roughness, b.guides.roughness, "roughness");
  ExpectSame(a.emission, b.emission, "emission");
  ExpectSame(a.background, b.background, "background");
}

// Everything that a pixel of a frame holds, added up without signs.
double Content(const Frame& frame, int x, int y, bool with_guides) {
  double sum = 0;
  const auto add = [&](const auto& image) {
    for (const auto& plane : image.channel) {
      sum += std::abs(static_cast<double>(plane(x, y)));
    }
  };
  for (const Signal& signal : frame.signals) {
    add(signal.radiance);
  }
  if (with_guides) {
    const Guides& g = frame.guides;
    sum += g.depth(x, y) + g.id(x, y) + g.roughness(x, y);
    add(g.normal);
    add(g.albedo);
    add(g.specular_albedo);
    add(g.motion);
    add(frame.emission);
    add(frame.background);
  }
  return sum;
}

TEST(SparseTest, ACycleReachesEveryPixelOnce) {
  const SceneBuilder builder = Room();
  for (const int cycle : {2, 3, 7, 16, 100, 256}) {
    const auto renderer = MakeRenderer(builder, SparseSettings(cycle, GuideCoverage::kSparse));
    Image1 received(kWidth, kHeight);
    Frame frame;
    for (int f = 3 * cycle; f < 4 * cycle; ++f) {
      ASSERT_TRUE(renderer->RenderFrame(MomentOf(f), &frame).ok());
      int traced = 0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          received(x, y) += frame.samples(x, y);
          traced += frame.samples(x, y) == 1.0f;
          ASSERT_TRUE(frame.samples(x, y) == 1.0f || Content(frame, x, y, true) == 0.0)
              << x << ' ' << y;
        }
      }
      EXPECT_NEAR(traced, static_cast<double>(kWidth * kHeight) / cycle,
                  2 + 0.25 * kWidth * kHeight / cycle)
          << cycle << ' ' << f;
    }
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(received(x, y), 1.0f) << cycle << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST(SparseTest, ACycleAddsUpToOneSample) {
  // The k-th sample of a pixel is the same whether its frame holds all pixels or some.
  const SceneBuilder builder = Room();
  constexpr int kSample = 5;
  const auto whole = MakeRenderer(builder, SmallSettings(kWidth, kHeight, 1));
  Frame expected;
  ASSERT_TRUE(whole->RenderFrame(MomentOf(kSample), &expected).ok());
  for (const GuideCoverage guides : {GuideCoverage::kFull, GuideCoverage::kSparse}) {
    constexpr int kCycle = 12;
    const auto renderer = MakeRenderer(builder, SparseSettings(kCycle, guides));
    Image3 sum(kWidth, kHeight);
    Frame frame;
    for (int f = kCycle * kSample; f < kCycle * (kSample + 1); ++f) {
      ASSERT_TRUE(renderer->RenderFrame(MomentOf(f), &frame).ok());
      for (const Signal& signal : frame.signals) {
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            for (int c = 0; c < 3; ++c) {
              sum[c](x, y) += signal.radiance[c](x, y);
            }
          }
        }
      }
    }
    // Rays in another packet may round another way, which seldom sends a path elsewhere.
    int different = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        vec3 light(0.0f);
        for (const Signal& signal : expected.signals) {
          light += Pixel(signal.radiance, x, y);
        }
        const vec3 difference = glm::abs(Pixel(sum, x, y) - light);
        different += difference.x + difference.y + difference.z > 1e-3f * (0.1f + light.y);
      }
    }
    EXPECT_LT(different, kWidth * kHeight / 500);
  }
}

TEST(SparseTest, CyclesConvergeToTheReference) {
  // A still view: frame after frame of one in nine pixels adds up to the picture that plain
  // accumulation of whole frames converges to, about as fast as random numbers would.
  const SceneBuilder builder = Room();
  constexpr int kCycle = 9;
  constexpr int kCycles = 96;
  RenderSettings settings = SparseSettings(kCycle, GuideCoverage::kSparse);
  settings.width = 28;
  settings.height = 20;
  const auto renderer = MakeRenderer(builder, settings);
  Image3 truth;
  ASSERT_TRUE(renderer->RenderReference({}, 1024, &truth).ok());
  Image3 sum(settings.width, settings.height);
  const auto error = [&](int cycles) {
    double squares = 0;
    for (int y = 0; y < settings.height; ++y) {
      for (int x = 0; x < settings.width; ++x) {
        const vec3 d = Pixel(sum, x, y) / static_cast<float>(cycles) - Pixel(truth, x, y);
        squares += glm::dot(d, d);
      }
    }
    return std::sqrt(squares);
  };
  double after_six = 0;
  Frame frame;
  for (int f = 0; f < kCycle * kCycles; ++f) {
    ASSERT_TRUE(renderer->RenderFrame(MomentOf(f), &frame).ok());
    const Image3 light = SumOfLight(frame);
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < settings.height; ++y) {
        for (int x = 0; x < settings.width; ++x) {
          sum[c](x, y) += light[c](x, y);
        }
      }
    }
    after_six = f + 1 == kCycle * 6 ? error(6) : after_six;
  }
  const vec3 mean = Mean(sum) / static_cast<float>(kCycles);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(mean[c] / Mean(truth)[c], 1.0f, 0.005f) << c;
  }
  // Sixteen times the samples; the truth has noise of its own.
  EXPECT_LT(error(kCycles), after_six / 3);
}

TEST(SparseTest, FullGuidesAreThoseOfAWholeFrame) {
  const SceneBuilder builder = Room();
  const Frame whole = RenderOne(builder.scene, SmallSettings(kWidth, kHeight, 1), MomentOf(9));
  const auto renderer = MakeRenderer(builder, SparseSettings(8, GuideCoverage::kFull));
  Frame frame;
  for (const int f : {2, 9}) {
    ASSERT_TRUE(renderer->RenderFrame(MomentOf(f), &frame).ok());
  }
  ExpectSame(frame.guides.depth, whole.guides.depth, "depth");
  ExpectSame(frame.guides.normal, whole.guides.normal, "normal");
  ExpectSame(frame.guides.albedo, whole.guides.albedo, "albedo");
  ExpectSame(frame.guides.motion, whole.guides.motion, "motion");
  ExpectSame(frame.emission, whole.emission, "emission");
  ExpectSame(frame.background, whole.background, "background");
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_TRUE(frame.samples(x, y) == 1.0f || Content(frame, x, y, false) == 0.0);
    }
  }
}

TEST(SparseTest, FramesThatComeBackAreAsNewOnes) {
  const SceneBuilder builder = Room();
  const auto renderer = MakeRenderer(builder, SparseSettings(16, GuideCoverage::kSparse));
  Frame reused;
  // Independent of earlier frames: other coverage, other cycles, whole frames, several samples.
  const auto render = [&](int spp, int cycle, GuideCoverage guides, int64_t index) {
    RenderSettings settings = SparseSettings(cycle, guides);
    settings.spp = spp;
    ASSERT_TRUE(renderer->SetSettings(settings).ok());
    ASSERT_TRUE(renderer->RenderFrame(MomentOf(index), &reused).ok());
    Frame fresh;
    ASSERT_TRUE(MakeRenderer(builder, settings)->RenderFrame(MomentOf(index), &fresh).ok());
    ExpectSameFrame(reused, fresh);
  };
  render(1, 16, GuideCoverage::kSparse, 1);
  render(1, 16, GuideCoverage::kSparse, 2);
  render(1, 5, GuideCoverage::kFull, 3);
  render(1, 5, GuideCoverage::kFull, 4);
  render(1, 5, GuideCoverage::kSparse, 5);
  render(1, 1, GuideCoverage::kSparse, 6);
  render(1, 5, GuideCoverage::kSparse, 7);
  render(4, 1, GuideCoverage::kFull, 8);
  render(1, 64, GuideCoverage::kSparse, 9);
  // A frame of another renderer, or a cancelled one.
  ASSERT_TRUE(MakeRenderer(builder, SparseSettings(2, GuideCoverage::kFull))
                  ->RenderFrame(MomentOf(0), &reused)
                  .ok());
  render(1, 64, GuideCoverage::kSparse, 10);
  EXPECT_EQ(renderer->RenderFrame(MomentOf(11), &reused, [](double) { return false; }).code(),
            StatusCode::kCancelled);
  render(1, 64, GuideCoverage::kSparse, 12);
}

TEST(SparseTest, SameBitsWithAnyNumberOfThreads) {
  const SceneBuilder builder = Room();
  RenderSettings settings = SparseSettings(6, GuideCoverage::kSparse);
  settings.width = 1100;  // several regions wide and high
  settings.height = 70;
  settings.jitter = true;
  Frame frames[2];
  for (const int threads : {1, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<size_t>(threads));
    const auto renderer = MakeRenderer(builder, settings);
    Frame& frame = frames[threads == 1 ? 0 : 1];
    for (const int index : {12, 13}) {
      ASSERT_TRUE(renderer->RenderFrame(MomentOf(index), &frame).ok());
    }
  }
  ExpectSameFrame(frames[0], frames[1]);
  Frame fresh;
  ASSERT_TRUE(MakeRenderer(builder, settings)->RenderFrame(MomentOf(13), &fresh).ok());
  ExpectSameFrame(frames[0], fresh);
}

TEST(SparseTest, SettingsChangeInPlace) {
  const SceneBuilder builder = Room();
  const auto renderer = MakeRenderer(builder, SmallSettings(20, 10, 1));
  RenderSettings settings = SmallSettings(33, 21, 2);
  settings.bounces = 2;
  settings.seed = 5;
  settings.regularise = true;
  settings.sampler = SamplerKind::kHalton16;
  ASSERT_TRUE(renderer->SetSettings(settings).ok());
  Frame frame;
  ASSERT_TRUE(renderer->RenderFrame(MomentOf(4), &frame).ok());
  ExpectSameFrame(frame, RenderOne(builder.scene, settings, MomentOf(4)));
  RenderSettings wrong = settings;
  wrong.cycle = 257;
  EXPECT_THAT(renderer->SetSettings(wrong).message(),
              HasSubstr("spp is '2/257', expected 1 to 65536, or 1/2 to 1/256"));
  wrong.cycle = 4;
  EXPECT_THAT(renderer->SetSettings(wrong).message(), HasSubstr("spp is '2/4'"));
  wrong = settings;
  wrong.guides = static_cast<GuideCoverage>(9);
  EXPECT_THAT(renderer->SetSettings(wrong).message(),
              HasSubstr("guides is '9', expected full or sparse"));
  EXPECT_EQ(renderer->settings().width, 33);
  ASSERT_TRUE(renderer->RenderFrame(MomentOf(4), &frame).ok());
  EXPECT_EQ(frame.width, 33);
}

TEST(SparseTest, ProgressRisesToOne) {
  const SceneBuilder builder = Room();
  for (const GuideCoverage guides : {GuideCoverage::kFull, GuideCoverage::kSparse}) {
    const auto renderer = MakeRenderer(builder, SparseSettings(3, guides));
    double last = 0;
    Frame frame;
    ASSERT_TRUE(renderer
                    ->RenderFrame(MomentOf(0), &frame,
                                  [&](double part) {
                                    EXPECT_GT(part, last);
                                    last = part;
                                    return true;
                                  })
                    .ok());
    EXPECT_DOUBLE_EQ(last, 1.0);
  }
}

}  // namespace
}  // namespace stillray::render::sparse_test

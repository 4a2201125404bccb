// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The denoiser on Vulkan as its users see it.
#include <algorithm>
#include <thread>
#include <vector>

#include "denoise/mirror_scene.h"
#include "denoise/test_frames.h"
#include "gpu/device_test.h"
#include "gpu/shared_pipelines.h"

namespace stillray::device_denoiser_test {
namespace {

using test::ExpectImage;
using test::MakeBusyFrame;
using test::With;
using DeviceDenoiser = test::DeviceTest;

TEST_F(DeviceDenoiser, FxaaFindsTheSameEdges) {
  // Slanted edges of noiseless light: every pixel decides far from its thresholds.
  Frame frame = test::MakeWall(96, 64);
  test::FillImage<3>(&test::Light(&frame, SignalKind::kDirectDiffuse), [](int x, int y, int c) {
    const int slanted = (x * 2 + y * 9) / 40 + (y > 40 ? x / 13 : 0);
    return slanted % 2 == 0 ? 1.0f : 0.2f + 0.1f * static_cast<float>(c);
  });
  for (const char* antialias : {"off", "taa"}) {
    const Settings settings =
        With("default", {{"fxaa", "on"}, {"wavelet", "off"}, {"antialias", antialias}});
    Result<Denoiser> reference = Denoiser::Create(settings, Backend::kReference);
    Denoiser tested = MakeDenoiser(settings, DevicePrecision::kFloat);
    DenoisedFrame expected;
    DenoisedFrame got;
    ASSERT_TRUE(reference->Denoise(frame, &expected).ok());
    ASSERT_TRUE(tested.Denoise(frame, &got).ok());
    int changed = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 96; ++x) {
        EXPECT_NEAR(got.colour[1](x, y), expected.colour[1](x, y), 1e-5) << x << "," << y;
        const float light = test::Light(&frame, SignalKind::kDirectDiffuse)[1](x, y);
        changed += std::abs(expected.colour[1](x, y) - light) > 0.01f ? 1 : 0;
      }
    }
    EXPECT_GT(changed, 100);
  }
}

/// Frames that use all that the history depends on, but light of the future.
Frame MakeFrameOfDoubts(int index) {
  Frame f = MakeBusyFrame(67, 41, index);
  f.confidence = Image1(67, 41);
  f.guides.previous_normal = Image3(67, 41);
  test::FillImage(&f.confidence, [&](int x, int) { return static_cast<float>(x % 11) / 9; });
  test::FillImage<3>(&f.guides.previous_normal,
                     [&](int x, int, int c) { return c == 2 && x % 5 == 0 ? 1.0f : 0.0f; });
  return f;
}

// Where the fetched history is not an output, it passes through no image.
TEST_F(DeviceDenoiser, ReprojectionWithAccumulationHasTheBitsOfBothApart) {
  const Settings many[] = {With("temporal", {}),
                           With("svgf", {}),
                           With("svgf", {{"feedback", "2"}, {"feedback_when", "sample"}}),
                           With("psvgf", {}),
                           With("svgf", {{"max_history", "7"}}),
                           With("default", {{"limit_history", "off"}})};
  for (const DevicePrecision precision : {DevicePrecision::kHalf, DevicePrecision::kFloat}) {
    for (const Settings& settings : many) {
      Denoiser at_once = MakeDenoiser(settings, precision);
      Denoiser apart = MakeDenoiser(settings, precision);
      ASSERT_TRUE(apart.SetOutputs({"disocclusion"}).ok());
      DenoisedFrame found;
      DenoisedFrame expected;
      for (int i = 0; i < 6; ++i) {
        const Frame f = MakeFrameOfDoubts(i);
        ASSERT_TRUE(at_once.Denoise(f, &found).ok());
        ASSERT_TRUE(apart.Denoise(f, &expected).ok());
        EXPECT_TRUE(test::SameBits(found.colour, expected.colour)) << i;
        const auto has_stage = [](const DenoisedFrame& frame) {
          return std::any_of(frame.timings.begin(), frame.timings.end(),
                             [](const StageTime& time) { return time.name == "reproject"; });
        };
        EXPECT_FALSE(has_stage(found));
        EXPECT_EQ(has_stage(expected), i > 0 && !expected.timings.empty());
      }
    }
  }
}

TEST_F(DeviceDenoiser, DenoisersOfADeviceShareItsPipelines) {
  const auto created = [&] { return device_->context().pipelines->created(); };
  const auto picture = [&](const char* preset) {
    Denoiser denoiser = MakeDenoiser(PresetSettings(preset).value(), DevicePrecision::kHalf);
    DenoisedFrame out;
    for (int i = 0; i < 3; ++i) {
      EXPECT_TRUE(denoiser.Denoise(MakeBusyFrame(30, 20, i), &out).ok());
    }
    return std::move(out.colour);
  };
  const Image3 first = picture("default");
  const size_t of_one = created();
  EXPECT_GT(of_one, 10u);
  EXPECT_TRUE(test::SameBits(picture("default"), first));  // the first denoiser has ended
  EXPECT_EQ(created(), of_one);
  std::vector<Image3> pictures(2);
  std::vector<std::thread> threads;
  for (Image3& one : pictures) {
    threads.emplace_back([&] { one = picture("default"); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_TRUE(test::SameBits(pictures[0], first));
  EXPECT_TRUE(test::SameBits(pictures[1], first));
  EXPECT_EQ(created(), of_one);
  // Another preset has most shaders in common.
  picture("svgf");
  EXPECT_LT(created(), of_one + 5);
}

// As above, without anything that was made before.
TEST_F(DeviceDenoiser, TwoThreadsMakeTheFirstPipelines) {
  ASSERT_NO_FATAL_FAILURE(UseNewDevice());
  std::vector<Image3> pictures(2);
  std::vector<std::thread> threads;
  for (Image3& one : pictures) {
    threads.emplace_back([&] {
      Denoiser denoiser = MakeDenoiser(PresetSettings("default").value(), DevicePrecision::kHalf);
      DenoisedFrame out;
      EXPECT_TRUE(denoiser.Denoise(MakeBusyFrame(30, 20, 0), &out).ok());
      one = std::move(out.colour);
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_TRUE(test::SameBits(pictures[0], pictures[1]));
  const size_t of_both = device_->context().pipelines->created();
  Denoiser third = MakeDenoiser(PresetSettings("default").value(), DevicePrecision::kHalf);
  DenoisedFrame out;
  EXPECT_TRUE(third.Denoise(MakeBusyFrame(30, 20, 0), &out).ok());
  EXPECT_EQ(device_->context().pipelines->created(), of_both);
}

TEST_F(DeviceDenoiser, MirrorsKeepTheirSamples) {
  // Pictures of the CPU's quality from halves, whose squares are another matter than light.
  const test::MirrorScene scene(96, 54, 1.0f);
  constexpr int kFrames = 6;
  const Frame last = scene.Trace(kFrames);
  const Image3 reference = SumOfLight(scene.Trace(kFrames, 64));
  const auto psnr = [&](Denoiser denoiser) {
    DenoisedFrame out;
    for (int i = 1; i <= kFrames; ++i) {
      EXPECT_TRUE(denoiser.Denoise(scene.Trace(i), &out).ok());
    }
    return test::RegionPsnr(out.colour, reference, last.guides.id, test::MirrorScene::kChrome);
  };
  const Settings settings;
  Settings off;
  off.mirror_roughness = 0;
  const double cpu = psnr(std::move(Denoiser::Create(settings).value()));
  for (const DevicePrecision precision : {DevicePrecision::kFloat, DevicePrecision::kHalf}) {
    const double kept = psnr(MakeDenoiser(settings, precision));
    EXPECT_NEAR(kept, cpu, 0.1);
    EXPECT_GT(kept, psnr(MakeDenoiser(off, precision)) + 1);
  }
}

/// The frame with all its light scaled.
Frame Scaled(Frame frame, float factor) {
  const auto scale = [&](Image3* image) {
    test::FillImage<3>(image,
                       [&, copy = *image](int x, int y, int c) { return factor * copy[c](x, y); });
  };
  for (Signal& signal : frame.signals) {
    scale(&signal.radiance);
  }
  scale(&frame.background);
  return frame;
}

TEST_F(DeviceDenoiser, ExposureFollowsTheLight) {
  // Light of any unit: halves hold it, and twice the light is twice the picture. The exposures are
  // powers of two, so that nothing differs but where a last bit decides a rounding to halves.
  constexpr float kRounding = 3e-3f;
  const Settings settings = PresetSettings("default").value();
  Denoiser plain = MakeDenoiser(settings, DevicePrecision::kHalf);
  Denoiser bright = MakeDenoiser(settings, DevicePrecision::kHalf);
  Denoiser dark = MakeDenoiser(settings, DevicePrecision::kHalf);
  constexpr float kFactor = 1 << 24;
  for (int i = 0; i < 4; ++i) {
    const Frame frame = MakeBusyFrame(40, 30, i);
    DenoisedFrame a;
    DenoisedFrame b;
    DenoisedFrame c;
    ASSERT_TRUE(plain.Denoise(frame, &a).ok());
    ASSERT_TRUE(bright.Denoise(Scaled(frame, kFactor), &b).ok());
    ASSERT_TRUE(dark.Denoise(Scaled(frame, 1 / kFactor), &c).ok());
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 40; ++x) {
        const float value = a.colour[0](x, y);
        ASSERT_NEAR(value, b.colour[0](x, y) / kFactor, kRounding * value)
            << i << " " << x << "," << y;
        ASSERT_NEAR(value, c.colour[0](x, y) * kFactor, kRounding * value)
            << i << " " << x << "," << y;
      }
    }
  }
}

TEST_F(DeviceDenoiser, RoundingBelowZeroIsZero) {
  // Of all sizes that are measured in another way: whole, and every 16th pixel.
  for (const auto& [width, height] : {std::pair(96, 64), std::pair(300, 220)}) {
    const int frames = width == 96 ? 2 : 1;
    const Settings settings = PresetSettings("default").value();
    Denoiser zeros = MakeDenoiser(settings, DevicePrecision::kFloat);
    Denoiser rounded = MakeDenoiser(settings, DevicePrecision::kFloat);
    Denoiser negative = MakeDenoiser(settings, DevicePrecision::kFloat);
    Denoiser on_cpu = std::move(Denoiser::Create(settings).value());
    DenoisedFrame a;
    DenoisedFrame b;
    for (int i = 0; i < frames; ++i) {
      ASSERT_TRUE(zeros.Denoise(test::MakeSparseLight(width, height, i, 0), &a).ok());
      ASSERT_TRUE(rounded.Denoise(test::MakeSparseLight(width, height, i, -1e-6f), &b).ok());
      EXPECT_EQ(b.negative, 0);
      EXPECT_NEAR(test::MeanOf(b.colour), test::MeanOf(a.colour), 1e-5);
      const Frame real = test::MakeSparseLight(width, height, i, -0.1f);
      ASSERT_TRUE(negative.Denoise(real, &a).ok());
      ASSERT_TRUE(on_cpu.Denoise(real, &b).ok());
      EXPECT_GT(a.negative, 0);
      EXPECT_EQ(a.negative, b.negative);
    }
  }
}

TEST_F(DeviceDenoiser, CompressedFirefliesKeepTheMean) {
  for (const DevicePrecision precision : {DevicePrecision::kHalf, DevicePrecision::kFloat}) {
    Denoiser off = MakeDenoiser(PresetSettings("svgf").value(), precision);
    Denoiser on = MakeDenoiser(With("svgf", {{"firefly", "compress"}}), precision);
    DenoisedFrame a;
    DenoisedFrame b;
    for (int i = 0; i < 4; ++i) {
      const Frame frame = test::MakeSparseLight(64, 48, i, 0);
      ASSERT_TRUE(off.Denoise(frame, &a).ok());
      ASSERT_TRUE(on.Denoise(frame, &b).ok());
      EXPECT_NEAR(test::MeanOf(b.colour) / test::MeanOf(a.colour), 1, 0.01) << i;
    }
  }
}

TEST_F(DeviceDenoiser, LightThatGrowsAThousandfoldKeepsItsHistory) {
  // The exposure changes in between, and the history is rescaled.
  const Settings settings = With("svgf", {{"fxaa", "off"}});
  Denoiser reference = std::move(Denoiser::Create(settings, Backend::kReference).value());
  Denoiser tested = MakeDenoiser(settings, DevicePrecision::kHalf);
  float factor = 1;
  for (int i = 0; i < 5; ++i, factor *= 6) {
    const Frame frame = Scaled(MakeBusyFrame(60, 40, i), factor);
    DenoisedFrame expected;
    DenoisedFrame got;
    ASSERT_TRUE(reference.Denoise(frame, &expected).ok());
    ASSERT_TRUE(tested.Denoise(frame, &got).ok());
    ExpectImage({"colour", {got.colour[1]}}, {"colour", {expected.colour[1]}}, test::kHalf,
                "frame " + std::to_string(i));
  }
}

TEST_F(DeviceDenoiser, LightThatMovesIsFoundAlike) {
  // Large enough for the blocks of the picture to be evidence (MovingLight). With a MovingLight of
  // 0 the history would be corrected by a hundredth less.
  const Settings settings = With("default", {{"antialias", "off"}});
  Denoiser on_cpu = std::move(Denoiser::Create(settings).value());
  Denoiser tested = MakeDenoiser(settings, DevicePrecision::kFloat);
  float factor = 1;
  for (int i = 0; i < 4; ++i, factor *= 1.25f) {
    const Frame frame = Scaled(test::MakeSparseLight(320, 200, i, 0), factor);
    DenoisedFrame expected;
    DenoisedFrame got;
    ASSERT_TRUE(on_cpu.Denoise(frame, &expected).ok());
    ASSERT_TRUE(tested.Denoise(frame, &got).ok());
    EXPECT_NEAR(test::MeanOf(got.colour) / test::MeanOf(expected.colour), 1, 5e-4) << i;
    EXPECT_NEAR(test::MeanOf(got.colour) / (2 * factor), 1, 0.025) << i;  // light of two signals
  }
}

TEST_F(DeviceDenoiser, TheSameBitsTwice) {
  for (const DevicePrecision precision : {DevicePrecision::kHalf, DevicePrecision::kFloat}) {
    Denoiser one = MakeDenoiser(PresetSettings("default").value(), precision);
    Denoiser two = MakeDenoiser(PresetSettings("default").value(), precision);
    for (int i = 0; i < 3; ++i) {
      DenoisedFrame a;
      DenoisedFrame b;
      ASSERT_TRUE(one.Denoise(MakeBusyFrame(70, 40, i), &a).ok());
      ASSERT_TRUE(two.Denoise(MakeBusyFrame(70, 40, i), &b).ok());
      for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 70; ++x) {
          ASSERT_EQ(a.colour[1](x, y), b.colour[1](x, y));
        }
      }
    }
  }
}

TEST_F(DeviceDenoiser, BrokenInputReachesNothing) {
  for (const DevicePrecision precision : {DevicePrecision::kHalf, DevicePrecision::kFloat}) {
    Denoiser d = MakeDenoiser(PresetSettings("default").value(), precision);
    DenoisedFrame out;
    for (int i = 0; i < 4; ++i) {
      Frame f = MakeBusyFrame(48, 32, i);
      for (int k = 0; k < 32; ++k) {
        f.guides.motion[0](k, 3) = NAN;
        f.guides.depth(k, 9) = NAN;
        f.guides.normal[1](k, 12) = INFINITY;
        f.emission[2](k, 15) = NAN;
        f.samples(k, 18) = -INFINITY;
        f.signals[0].radiance[0](k, 21) = INFINITY;
      }
      ASSERT_TRUE(d.Denoise(f, &out).ok());
      EXPECT_GE(out.bad_guides, 64);
      for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 48; ++x) {
          for (int c = 0; c < 3; ++c) {
            ASSERT_TRUE(std::isfinite(out.colour[c](x, y))) << i << " " << x << "," << y;
          }
        }
      }
    }
  }
}

TEST_F(DeviceDenoiser, SettingsMayChangeOnTheWay) {
  Denoiser reference =
      std::move(Denoiser::Create(PresetSettings("default").value(), Backend::kReference).value());
  Denoiser tested = MakeDenoiser(PresetSettings("default").value(), DevicePrecision::kFloat);
  DenoisedFrame expected;
  DenoisedFrame got;
  int i = 0;
  for (const Settings& settings :
       {With("default", {{"kernel", "3x3"}, {"fxaa", "off"}}),
        With("default", {{"steps", "1,2"}, {"fxaa", "off"}}), With("svgf", {{"fxaa", "off"}}),
        With("svgf", {{"fxaa", "off"}, {"sigma_l", "2"}})}) {
    ASSERT_TRUE(reference.SetSettings(settings).ok());
    ASSERT_TRUE(tested.SetSettings(settings).ok());
    for (int k = 0; k < 2; ++k, ++i) {
      ASSERT_TRUE(reference.Denoise(MakeBusyFrame(40, 30, i), &expected).ok());
      ASSERT_TRUE(tested.Denoise(MakeBusyFrame(40, 30, i), &got).ok());
      ExpectImage({"colour", {got.colour[1]}}, {"colour", {expected.colour[1]}}, test::kFloat,
                  "frame " + std::to_string(i));
    }
  }
  tested.Reset();
  Denoiser fresh = MakeDenoiser(tested.settings(), DevicePrecision::kFloat);
  ASSERT_TRUE(tested.Denoise(MakeBusyFrame(40, 30, 0), &got).ok());
  ASSERT_TRUE(fresh.Denoise(MakeBusyFrame(40, 30, 0), &expected).ok());
  ExpectImage({"colour", {got.colour[1]}}, {"colour", {expected.colour[1]}}, {1e-6, 0}, "reset");
  ASSERT_TRUE(tested.Denoise(MakeBusyFrame(33, 45, 1), &got).ok());  // another size
  EXPECT_EQ(got.colour.width(), 33);
}

TEST_F(DeviceDenoiser, HandsOverWhatIsWanted) {
  for (const DevicePrecision precision : {DevicePrecision::kHalf, DevicePrecision::kFloat}) {
    const Settings settings = With("default", {{"exposure", "0.5"}, {"dither", "1"}});
    Denoiser d = MakeDenoiser(settings, precision);
    Denoiser plain = MakeDenoiser(settings, precision);
    Image3 late;
    EXPECT_EQ(d.ReadColour(&late).code(), StatusCode::kNotFound);
    DenoisedFrame out;
    DenoisedFrame expected;
    int i = 0;
    for (const auto& [colour, display] : {std::pair(true, false), std::pair(false, true),
                                          std::pair(true, true), std::pair(false, false)}) {
      d.SetResults({.colour = colour, .display = display});
      const Frame frame = MakeBusyFrame(37, 21, i);
      ASSERT_TRUE(d.Denoise(frame, &out).ok());
      ASSERT_TRUE(plain.Denoise(frame, &expected).ok());
      EXPECT_EQ(out.colour.empty(), !colour);
      EXPECT_EQ(out.display.size(), display ? 37u * 21 * 3 : 0u);
      ASSERT_TRUE(d.ReadColour(&late).ok());
      EXPECT_TRUE(test::SameBits(late, expected.colour)) << "nothing else changes, frame " << i;
      const std::vector<uint8_t> shown =
          ToDisplay(expected.colour, settings.exposure, settings.tonemap, settings.dither, i);
      for (size_t k = 0; k < out.display.size(); ++k) {
        ASSERT_NEAR(out.display[k], shown[k], 1) << "byte " << k << " of frame " << i;
      }
      ++i;
    }
    ASSERT_TRUE(d.Denoise(MakeBusyFrame(12, 9, i), &out).ok());  // another size
    ASSERT_TRUE(d.ReadColour(&late).ok());
    EXPECT_EQ(late.width(), 12);
  }
}

TEST_F(DeviceDenoiser, BrokenFramesAreRefusedAndMemoryIsTold) {
  Denoiser d = MakeDenoiser(PresetSettings("default").value(), DevicePrecision::kHalf);
  DenoisedFrame out;
  Frame broken = MakeBusyFrame(8, 8, 0);
  broken.guides.depth = Image1(9, 8);
  EXPECT_EQ(d.Denoise(broken, &out).code(), StatusCode::kInvalidArgument);
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(8, 8, 0), &out).ok());
  EXPECT_GT(d.device_memory().bytes, 8u * 8u * 100u);
  EXPECT_FALSE(out.timings.empty());
}

// Outputs are read back through buffers of their own, in one block of memory.
TEST_F(DeviceDenoiser, MemoryOfOutputsIsCounted) {
  const Frame frame = MakeBusyFrame(40, 30, 0);
  const auto memory = [&](const std::vector<std::string>& outputs) {
    Denoiser d = MakeDenoiser(PresetSettings("default").value(), DevicePrecision::kHalf);
    EXPECT_TRUE(d.SetOutputs(outputs).ok());
    DenoisedFrame out;
    EXPECT_TRUE(d.Denoise(frame, &out).ok());
    EXPECT_EQ(d.memory_bytes(), d.device_memory().bytes);
    return d.device_memory();
  };
  const DeviceMemory without = memory({});
  const DeviceMemory with = memory({"temporal", "filtered.direct"});
  EXPECT_EQ(with.allocations, without.allocations + 1);
  EXPECT_GT(with.resources, without.resources);
  EXPECT_GE(with.bytes, without.bytes + 2u * 40u * 30u * 8u);
}

TEST(DeviceChoice, NamesWhatIsWrong) {
  for (const char* bad : {"", "gpu", "vulkan:", "vulkan:one", "cpu:0"}) {
    const Result<Device> opened = Device::Open(bad);
    ASSERT_FALSE(opened.ok()) << bad;
    EXPECT_EQ(opened.status().code(), StatusCode::kInvalidArgument) << bad;
    EXPECT_NE(opened.status().message().find("expected auto, cpu, vulkan or vulkan:N"),
              std::string::npos);
  }
}

TEST(DeviceChoice, AutoIsAGpuOrTheCpuWithTheReason) {
  const Result<Device> opened = Device::Open("auto");
  ASSERT_TRUE(opened.ok()) << opened.status().message();
  std::string remark;
  bool gpu = false;
  for (const DeviceDescription& d : ListDevices(&remark)) {
    gpu = gpu || (d.is_gpu && d.usable.ok());
  }
  EXPECT_EQ(opened->is_cpu(), !gpu);
  EXPECT_EQ(opened->remark().empty(), gpu);
  EXPECT_TRUE(Device::Open("cpu")->is_cpu());
  EXPECT_TRUE(Device::Open("cpu")->remark().empty());
}

}  // namespace
}  // namespace stillray::device_denoiser_test

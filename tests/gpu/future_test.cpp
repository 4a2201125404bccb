// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Sequences played backward, then forward, on the device.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "denoise/sparse_frames.h"
#include "denoise/test_frames.h"
#include "gpu/device_test.h"

namespace stillray::future_test {
namespace {

using test::ExpectImage;
using test::MakeBusyFrame;
using test::With;
using ::testing::HasSubstr;

using Frames = std::vector<Frame>;

Denoiser Reference(const Settings& settings) {
  return std::move(Denoiser::Create(settings, Backend::kReference).value());
}

Frames BusyFrames(int width, int height, int count) {
  Frames frames;
  for (int i = 0; i < count; ++i) {
    frames.push_back(MakeBusyFrame(width, height, i));
  }
  return frames;
}

class DeviceFuture : public test::DeviceTest {
 protected:
  static std::vector<FutureLight> PlayBackward(Denoiser denoiser, const Frames& frames) {
    std::vector<FutureLight> future(frames.size());
    for (size_t i = frames.size(); i-- > 0;) {
      Frame reversed = frames[i];
      if (i + 1 < frames.size()) {
        reversed.guides.motion =
            ReverseMotion(frames[i + 1].guides.motion, frames[i + 1].guides.depth);
      }
      const Status status = denoiser.Accumulate(reversed, &future[i]);
      EXPECT_TRUE(status.ok()) << status.message();
    }
    return future;
  }

  /// Both ways on both, within what each picture of a frame without a future is held to.
  void ExpectTheReference(const Settings& settings, DevicePrecision precision,
                          const Frames& frames) {
    const std::vector<FutureLight> slow = PlayBackward(Reference(settings), frames);
    const std::vector<FutureLight> fast = PlayBackward(MakeDenoiser(settings, precision), frames);
    Denoiser reference = Reference(settings);
    Denoiser tested = MakeDenoiser(settings, precision);
    for (Denoiser* d : {&reference, &tested}) {
      ASSERT_TRUE(d->SetOutputs({"temporal", "accumulated", "history", "moment_mean"}).ok());
    }
    for (size_t i = 0; i < frames.size(); ++i) {
      const std::string what = "frame " + std::to_string(i);
      DenoisedFrame a;
      DenoisedFrame b;
      ASSERT_TRUE(reference.Denoise(frames[i], slow[i], &a).ok());
      const Status status = tested.Denoise(frames[i], fast[i], &b);
      ASSERT_TRUE(status.ok()) << status.message();
      for (const NamedImage& expected : a.images) {
        const auto got = std::find_if(b.images.begin(), b.images.end(),
                                      [&](const NamedImage& n) { return n.name == expected.name; });
        ASSERT_NE(got, b.images.end()) << expected.name;
        ExpectImage(*got, expected, WithFuture(expected.name, precision), what);
      }
      ExpectImage({"colour", {b.colour[0], b.colour[1], b.colour[2]}},
                  {"colour", {a.colour[0], a.colour[1], a.colour[2]}},
                  WithFuture("colour", precision), what);
    }
  }

 private:
  /// How much the past counts against the future follows from the length of the history, which
  /// limit_history finds from the difference of two squares: halves of nearly equal ones.
  static test::Tolerance WithFuture(const std::string& name, DevicePrecision precision) {
    test::Tolerance tolerance = test::ToleranceOf(name, precision);
    if (precision == DevicePrecision::kHalf) {
      tolerance.rms = std::max(tolerance.rms, 0.03);
    }
    return tolerance;
  }
};

TEST_F(DeviceFuture, MatchesTheReference) {
  for (const DevicePrecision precision : {DevicePrecision::kFloat, DevicePrecision::kHalf}) {
    for (const char* preset : {"default", "svgf", "psvgf", "eaw"}) {
      SCOPED_TRACE(std::string(preset) +
                   (precision == DevicePrecision::kHalf ? ", halves" : ", floats"));
      ExpectTheReference(With(preset, {{"fxaa", "off"}}), precision, BusyFrames(67, 35, 6));
    }
  }
}

TEST_F(DeviceFuture, OddSizesMatchTheReference) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {1, 7}, {17, 9}}) {
    SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
    ExpectTheReference(With("default", {{"fxaa", "off"}}), DevicePrecision::kFloat,
                       BusyFrames(width, height, 3));
  }
}

TEST_F(DeviceFuture, FramesThatKnowLittleOfTheirGuidesMatchTheReference) {
  Frames frames;
  for (int i = 0; i < 5; ++i) {
    frames.push_back(test::MakeSparseFrame({40, 24, 3, 0, true}, i));
  }
  // The scale of compressed luminances changes in such frames: histories are rescaled.
  const Settings s = With("default", {{"fxaa", "off"}});
  const std::vector<FutureLight> slow = PlayBackward(Reference(s), frames);
  const std::vector<FutureLight> fast =
      PlayBackward(MakeDenoiser(s, DevicePrecision::kFloat), frames);
  Denoiser reference = Reference(s);
  Denoiser tested = MakeDenoiser(s, DevicePrecision::kFloat);
  for (size_t i = 0; i < frames.size(); ++i) {
    DenoisedFrame a;
    DenoisedFrame b;
    ASSERT_TRUE(reference.Denoise(frames[i], slow[i], &a).ok());
    ASSERT_TRUE(tested.Denoise(frames[i], fast[i], &b).ok());
    ExpectImage({"colour", {b.colour[1]}}, {"colour", {a.colour[1]}}, test::kFloat,
                "frame " + std::to_string(i));
  }
}

TEST_F(DeviceFuture, WithAPlainMeanEveryFrameOfAStillViewIsTheMeanOfAll) {
  const Settings s = With("default", {{"wavelet", "off"},
                                      {"antialias", "off"},
                                      {"fxaa", "off"},
                                      {"limit_history", "off"},
                                      {"alpha_min", "0"},
                                      {"alpha_moments", "0"}});
  Frames frames;
  for (int i = 0; i < 7; ++i) {
    frames.push_back(test::MakeWall(24, 16, i));
    test::FillImage<3>(&test::Light(&frames.back(), SignalKind::kDirectDiffuse),
                       [&](int x, int y, int) {
                         return test::Random(static_cast<uint32_t>(i), static_cast<uint32_t>(x),
                                             static_cast<uint32_t>(y));
                       });
  }
  const std::vector<FutureLight> future =
      PlayBackward(MakeDenoiser(s, DevicePrecision::kFloat), frames);
  Denoiser d = MakeDenoiser(s, DevicePrecision::kFloat);
  ASSERT_TRUE(d.SetOutputs({"history"}).ok());
  for (size_t i = 0; i < frames.size(); ++i) {
    DenoisedFrame out;
    ASSERT_TRUE(d.Denoise(frames[i], future[i], &out).ok());
    for (const auto& [x, y] : {std::pair{3, 5}, {20, 10}, {23, 15}}) {
      double mean = 0;
      for (const Frame& f : frames) {
        mean += static_cast<double>(f.signals[0].radiance[0](x, y)) / 7.0;
      }
      EXPECT_NEAR(out.colour[0](x, y), mean, 1e-5) << "frame " << i;
      EXPECT_FLOAT_EQ(out.images[0].channels[0](x, y), 7.0f);
    }
  }
}

TEST_F(DeviceFuture, TheHistoryStaysFreeOfIt) {
  // With feedback, too: the merged light never becomes history.
  const Settings s = With("svgf", {{"antialias", "off"}, {"feedback", "0"}});
  const Frames frames = BusyFrames(33, 20, 4);
  const std::vector<FutureLight> future =
      PlayBackward(MakeDenoiser(s, DevicePrecision::kHalf), frames);
  Denoiser alone = MakeDenoiser(s, DevicePrecision::kHalf);
  Denoiser both = MakeDenoiser(s, DevicePrecision::kHalf);
  DenoisedFrame a;
  DenoisedFrame b;
  for (size_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(alone.Denoise(frames[i], &a).ok());
    ASSERT_TRUE(both.Denoise(frames[i], future[i], &b).ok());
  }
  EXPECT_NE(a.colour[0](16, 10), b.colour[0](16, 10));
  ASSERT_TRUE(alone.Denoise(frames[3], &a).ok());
  ASSERT_TRUE(both.Denoise(frames[3], &b).ok());
  for (int y = 0; y < 20; ++y) {
    EXPECT_EQ(std::memcmp(a.colour[0].Row(y), b.colour[0].Row(y), 33 * sizeof(float)), 0);
  }
}

TEST_F(DeviceFuture, OfTheCpuIsTakenByTheDeviceAndTheOtherWayRound) {
  const Settings s = With("default", {{"fxaa", "off"}});
  const Frames frames = BusyFrames(40, 24, 4);
  const std::vector<FutureLight> of_cpu =
      PlayBackward(std::move(Denoiser::Create(s).value()), frames);
  const std::vector<FutureLight> of_device =
      PlayBackward(MakeDenoiser(s, DevicePrecision::kFloat), frames);
  Denoiser cpu = std::move(Denoiser::Create(s).value());
  Denoiser device = MakeDenoiser(s, DevicePrecision::kFloat);
  for (size_t i = 0; i < frames.size(); ++i) {
    DenoisedFrame a;
    DenoisedFrame b;
    ASSERT_TRUE(cpu.Denoise(frames[i], of_device[i], &a).ok());
    ASSERT_TRUE(device.Denoise(frames[i], of_cpu[i], &b).ok());
    ExpectImage({"colour", {b.colour[1]}}, {"colour", {a.colour[1]}}, test::kFloat,
                "frame " + std::to_string(i));
  }
}

TEST_F(DeviceFuture, OfOtherFramesIsRefused) {
  const Settings s = PresetSettings("default").value();
  const Frames frames = BusyFrames(40, 24, 2);
  const std::vector<FutureLight> future =
      PlayBackward(MakeDenoiser(s, DevicePrecision::kHalf), frames);
  EXPECT_GE(future[0].bytes(), 3u * 40 * 24 * 4 * 7);
  Denoiser d = MakeDenoiser(s, DevicePrecision::kHalf);
  DenoisedFrame out;
  const Status refused = d.Denoise(MakeBusyFrame(32, 32, 9), future[0], &out);
  EXPECT_EQ(refused.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(refused.message(),
              HasSubstr("frame 9: the light of its future has 3 signals of 40x24, expected 3 of "
                        "32x32"));
  Frame broken = MakeBusyFrame(8, 8, 0);
  broken.guides.depth = Image1(9, 8);
  FutureLight none;
  EXPECT_EQ(d.Accumulate(broken, &none).code(), StatusCode::kInvalidArgument);
  EXPECT_TRUE(none.empty());
}

TEST_F(DeviceFuture, SizesMayChangeOnTheWay) {
  const Settings s = PresetSettings("default").value();
  Denoiser d = MakeDenoiser(s, DevicePrecision::kHalf);
  DenoisedFrame out;
  for (const int width : {20, 31, 20}) {
    const Frames frames = BusyFrames(width, 11, 2);
    const std::vector<FutureLight> future =
        PlayBackward(MakeDenoiser(s, DevicePrecision::kHalf), frames);
    for (size_t i = 0; i < 2; ++i) {
      const Status status = d.Denoise(frames[i], future[i], &out);
      ASSERT_TRUE(status.ok()) << status.message();
    }
  }
}

}  // namespace
}  // namespace stillray::future_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// A renderer whose frames change their size within the denoiser's images, and its outputs of single
// signals.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "gpu/mirror_frames.h"
#include "gpu/renderer_test.h"

namespace stillray::resized_frames_test {
namespace {

using test::kRendererHeight;
using test::kRendererWidth;
using test::Slot;
using ::testing::HasSubstr;

class ResizedFrames : public test::RendererTest {
 protected:
  /// The picture of one frame, submitted and finished.
  Image3 PictureOf(VulkanDenoiser* denoiser, int index) {
    Slot& slot = slots_.front();
    Begin(&slot);
    const VulkanFrame frame = FreshFrame(index, &slot);
    const Status recorded = denoiser->Record(slot.commands, frame);
    EXPECT_TRUE(recorded.ok()) << recorded.message();
    ReadBack(slot.commands, slot);
    Submit(&slot);
    Wait(&slot);
    EXPECT_TRUE(arena_->Invalidate().ok());
    return Picture(slot, frame.width, frame.height);
  }
};

TEST_F(ResizedFrames, SmallerFramesAreThoseOfASmallerDenoiser) {
  constexpr int kWidth = 33;
  constexpr int kHeight = 21;
  std::vector<Frame> frames;
  for (int i = 0; i < 4; ++i) {
    frames.push_back(test::MakeMirrors(kWidth, kHeight, i, false));
    frames.back().samples = Image1();
  }
  Prepare(frames, 1);
  for (const bool virtual_guides : {false, true}) {
    VulkanOptions o = options("default", 1);
    o.virtual_guides = virtual_guides;
    if (!virtual_guides) {
      for (Frame& f : host_) {
        f.reflection = VirtualGuides();
      }
    }
    Result<VulkanDenoiser> large = VulkanDenoiser::Create(context(), o);
    ASSERT_TRUE(large.ok()) << large.status().message();
    o.width = kWidth;
    o.height = kHeight;
    o.share_with = &*large;
    Result<VulkanDenoiser> small = VulkanDenoiser::Create(context(), o);
    ASSERT_TRUE(small.ok()) << small.status().message();
    host_ = frames;
    for (int i = 0; i < 8; ++i) {
      SCOPED_TRACE(i);
      if (!virtual_guides) {
        host_[static_cast<size_t>(i) % host_.size()].reflection = VirtualGuides();
      }
      const Image3 expected = PictureOf(&*small, i);
      EXPECT_TRUE(test::SameBits(PictureOf(&*large, i), expected));
    }
  }
}

/// Two walls side by side, the right one brighter, at one sample per pixel: half of the samples are
/// lit, so that the mean is 1 and 4.
Frame MakeTwoWalls(int width, int height, int index) {
  Frame f = test::MakeWall(width, height, index);
  test::FillImage(&f.guides.depth, [&](int x, int) { return 2 * x < width ? 5.0f : 15.0f; });
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      f.guides.id(x, y) = 2 * x < width ? 1 : 2;
    }
  }
  Signal& light = f.signals[1];  // indirect diffuse
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool lit = test::RandomAt(x, y, static_cast<uint32_t>(97 + index)) < 0.5f;
      for (int c = 0; c < 3; ++c) {
        light.radiance[c](x, y) = !lit ? 0.0f : 2 * x < width ? 2.0f : 8.0f;
      }
    }
  }
  return f;
}

/// Root mean square error relative to the mean of each wall, of the pixels at least `margin` away
/// from the edge.
double RelativeError(const Image3& picture, int margin) {
  double sum = 0;
  int count = 0;
  const int width = picture[0].width();
  for (int y = 0; y < picture[0].height(); ++y) {
    for (int x = 0; x < width; ++x) {
      if (std::abs(2 * x + 1 - width) < 2 * margin) {
        continue;
      }
      const double mean = 2 * x < width ? 1 : 4;
      const double error = static_cast<double>(picture[1](x, y)) / mean - 1;
      sum += error * error;
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

// The light of 24 frames stays when the size changes, up and down, and does not leak over the edge.
TEST_F(ResizedFrames, TheHistoryStays) {
  constexpr int kSizes[][2] = {{44, 26}, {30, 18}, {36, 22}};
  std::vector<Frame> frames;
  for (const auto& [width, height] : kSizes) {
    for (int i = 0; i < 24; ++i) {
      frames.push_back(MakeTwoWalls(width, height, i));
    }
  }
  Prepare(frames, 1);
  VulkanOptions o = options("temporal", 1);  // no filter hides the noise
  ASSERT_TRUE(SetParameter(&o.settings, "antialias", "off").ok());
  Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(made.ok()) << made.status().message();
  const double first = RelativeError(PictureOf(&*made, 0), 0);
  EXPECT_NEAR(first, 1, 0.1);  // half of the samples
  double before = first;
  for (int i = 1; i < 24; ++i) {
    before = RelativeError(PictureOf(&*made, i), 0);
  }
  EXPECT_LT(before, 0.5);
  for (int i = 24; i < 26; ++i) {
    EXPECT_LT(RelativeError(PictureOf(&*made, i), 0), 1.15 * before);
  }
  EXPECT_LT(RelativeError(PictureOf(&*made, 48), 0), 1.15 * before);
  // A fresh denoiser knows one frame.
  Result<VulkanDenoiser> fresh = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(fresh.ok());
  EXPECT_GT(RelativeError(PictureOf(&*fresh, 49), 0), 0.9);
}

TEST_F(ResizedFrames, SizesMayChangeWhileFramesAreOnTheWay) {
  constexpr int kFrames = 60;
  constexpr int kSizes[][2] = {{45, 26}, {31, 26}, {45, 17}, {16, 9}, {40, 23}};
  std::vector<Frame> frames;
  for (int i = 0; i < 15; ++i) {  // three of each size
    const auto& size = kSizes[i / 3];
    frames.push_back(test::MakeMirrors(size[0], size[1], i, false));
    frames.back().samples = Image1();
  }
  Prepare(frames, 3);
  VulkanOptions o = options("default", 1);
  o.virtual_guides = true;
  std::vector<Image3> expected;
  {
    Result<VulkanDenoiser> alone = VulkanDenoiser::Create(context(), o);
    ASSERT_TRUE(alone.ok()) << alone.status().message();
    for (int i = 0; i < kFrames; ++i) {
      expected.push_back(PictureOf(&*alone, i));
      for (int c = 0; c < 3; ++c) {
        for (int y = 0; y < expected.back()[c].height(); ++y) {
          for (int x = 0; x < expected.back()[c].width(); ++x) {
            ASSERT_TRUE(std::isfinite(expected.back()[c](x, y)));
          }
        }
      }
    }
  }
  o.frames_in_flight = 3;
  Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(made.ok()) << made.status().message();
  for (int i = 0; i < kFrames + 3; ++i) {
    SCOPED_TRACE(i);
    Slot& slot = slots_[static_cast<size_t>(i) % slots_.size()];
    if (i >= 3) {
      Wait(&slot);
      ExpectPicture(slot, expected[static_cast<size_t>(i) - 3]);
    }
    if (i < kFrames) {
      Begin(&slot);
      const Status recorded = made->Record(slot.commands, FreshFrame(i, &slot));
      ASSERT_TRUE(recorded.ok()) << recorded.message();
      ReadBack(slot.commands, slot);
      Submit(&slot);
    }
  }
}

TEST_F(ResizedFrames, GuidesAreFilledAtAllSizes) {
  std::vector<Frame> frames;
  for (int i = 0; i < 6; ++i) {
    frames.push_back(test::MakeBusyFrame(i < 3 ? 45 : 24, i < 3 ? 26 : 15, i));
    test::FillImage(&frames.back().samples,
                    [&](int x, int y) { return (x + y + i) % 3 == 0 ? 1.0f : 0.0f; });
    for (int y = 0; y < frames.back().height; ++y) {
      for (int x = 0; x < frames.back().width; ++x) {
        if ((x + y + i) % 3 != 0) {
          frames.back().guides.depth(x, y) = 0;
        }
      }
    }
  }
  Prepare(frames, 1);
  VulkanOptions o = options("default", 1);
  o.incomplete_guides = true;
  Result<VulkanDenoiser> large = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(large.ok()) << large.status().message();
  for (int i = 0; i < 3; ++i) {
    PictureOf(&*large, i);
  }
  large->Reset();
  o.width = 24;
  o.height = 15;
  Result<VulkanDenoiser> small = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(small.ok()) << small.status().message();
  for (int i = 3; i < 6; ++i) {
    EXPECT_TRUE(test::SameBits(PictureOf(&*large, i), PictureOf(&*small, i))) << i;
  }
}

/// Sum of a pixel's filtered signals times their albedos, with what is not filtered.
float Composed(const Frame& f, const std::vector<Image3>& filtered, int x, int y, int c) {
  double sum =
      static_cast<double>(f.emission[c](x, y)) + static_cast<double>(f.background[c](x, y));
  for (size_t s = 0; s < filtered.size(); ++s) {
    const Image3& albedo = s + 1 < filtered.size() ? f.guides.albedo : f.guides.specular_albedo;
    sum += static_cast<double>(filtered[s][c](x, y)) *
           std::max(static_cast<double>(albedo[c](x, y)), 0.01);
  }
  return static_cast<float>(sum);
}

// Of `split` and of `diffuse_specular`: the last signal is specular.
TEST_F(ResizedFrames, OutputsOfSignalsComposeThePicture) {
  std::vector<Frame> frames = {test::MakeBusyFrame(kRendererWidth, kRendererHeight, 0),
                               test::MakeBusyFrame(kRendererWidth, kRendererHeight, 1)};
  Prepare(frames, 4);
  for (const char* signals : {"split", "diffuse_specular"}) {
    VulkanOptions o = options("default", 1);
    ASSERT_TRUE(SetParameter(&o.settings, "antialias", "off").ok());
    ASSERT_TRUE(SetParameter(&o.settings, "fxaa", "off").ok());
    ASSERT_TRUE(SetParameter(&o.settings, "signals", signals).ok());
    o.precision = DevicePrecision::kFloat;
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
    ASSERT_TRUE(made.ok()) << made.status().message();
    const size_t count = std::string(signals) == "split" ? 3 : 2;
    for (int i = 0; i < 2; ++i) {
      Slot& slot = slots_.front();
      VulkanFrame frame = FreshFrame(i, &slot);
      for (size_t s = 0; s < count; ++s) {
        frame.filtered[s] = FreshView(*slots_[s + 1].colour, &slot);
      }
      Begin(&slot);
      const Status recorded = made->Record(slot.commands, frame);
      ASSERT_TRUE(recorded.ok()) << recorded.message();
      for (size_t s = 0; s <= count; ++s) {
        ReadBack(slot.commands, slots_[s]);
      }
      Submit(&slot);
      Wait(&slot);
      ASSERT_TRUE(arena_->Invalidate().ok());
      const Image3 picture = Picture(slot, kRendererWidth, kRendererHeight);
      std::vector<Image3> filtered;
      for (size_t s = 0; s < count; ++s) {
        filtered.push_back(Picture(slots_[s + 1], kRendererWidth, kRendererHeight));
      }
      const Frame& f = host_[static_cast<size_t>(i)];
      int differ = 0;
      for (int y = 0; y < kRendererHeight; ++y) {
        for (int x = 0; x < kRendererWidth; ++x) {
          for (int c = 0; c < 3; ++c) {
            const float sum = Composed(f, filtered, x, y, c);
            differ += std::abs(picture[c](x, y) - sum) > 1e-4f * (1 + std::abs(sum)) ? 1 : 0;
          }
        }
      }
      EXPECT_EQ(differ, 0) << signals << " frame " << i;
    }
  }
}

TEST_F(ResizedFrames, SaysWhatIsWrong) {
  std::vector<Frame> frames = {test::MakeMirrors(kRendererWidth, kRendererHeight, 0, false)};
  frames.back().samples = Image1();
  Prepare(frames, 1);
  VulkanOptions o = options("default", 1);
  o.virtual_guides = true;
  Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(made.ok()) << made.status().message();
  Slot& slot = slots_.front();
  Begin(&slot);
  const VulkanFrame right = FreshFrame(0, &slot);
  const auto message = [&](auto change) {
    VulkanFrame frame = right;
    change(&frame);
    return made->Record(slot.commands, frame).message();
  };
  EXPECT_EQ(message([](VulkanFrame* f) { f->width = 46; }),
            "frame 0: it is 46x26, expected 1x1 to 45x26, or 0x0 for the latter");
  EXPECT_THAT(message([](VulkanFrame* f) { f->height = 0; }), HasSubstr("it is 45x0"));
  EXPECT_THAT(message([](VulkanFrame* f) { f->width = -1; }), HasSubstr("it is -1x26"));
  EXPECT_EQ(message([&](VulkanFrame* f) { f->filtered[3] = right.colour; }),
            "frame 0: image 'filtered[3]' is given, but there are 3 signals");
  EXPECT_EQ(message([&](VulkanFrame* f) { f->filtered[2] = right.colour; }),
            "frame 0: image 'filtered[2]' is given, but the light of the signal 'specular' has "
            "virtual guides");
  ASSERT_EQ(vk().EndCommandBuffer(slot.commands), VK_SUCCESS);
}

}  // namespace
}  // namespace stillray::resized_frames_test

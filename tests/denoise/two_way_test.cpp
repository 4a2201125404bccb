// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames in memory denoised with light of the past and of the future.
#include "stillray/two_way.hpp"

#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "denoise/future_blocks.h"
#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"

namespace stillray::two_way_test {
namespace {

using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::MakeWall;
using test::SameBits;
using ::testing::HasSubstr;

constexpr int kWidth = 37;
constexpr int kHeight = 21;

std::vector<Frame> BusyFrames(int count) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) {
    frames.push_back(MakeBusyFrame(kWidth, kHeight, i));
  }
  return frames;
}

TwoWayDenoiser MakeTwoWay(const Settings& s, const TwoWayOptions& options = {}) {
  Result<TwoWayDenoiser> made = TwoWayDenoiser::Create(s, Device(), options);
  EXPECT_TRUE(made.ok()) << made.status().message();
  return std::move(made.value());
}

/// Pulls all frames that are ready.
void PullReady(TwoWayDenoiser* denoiser, std::vector<Image3>* pictures) {
  for (;;) {
    DenoisedFrame out;
    const Result<bool> pulled = denoiser->Pull(&out);
    ASSERT_TRUE(pulled.ok()) << pulled.status().message();
    if (!*pulled) {
      return;
    }
    pictures->push_back(std::move(out.colour));
  }
}

std::vector<Image3> DenoiseAll(TwoWayDenoiser* denoiser, const std::vector<Frame>& frames) {
  std::vector<Image3> pictures;
  for (const Frame& frame : frames) {
    const Status pushed = denoiser->Push(frame, Cut::kNo);
    EXPECT_TRUE(pushed.ok()) << pushed.message();
    PullReady(denoiser, &pictures);
  }
  denoiser->Finish();
  PullReady(denoiser, &pictures);
  return pictures;
}

/// The same, put together from Denoiser::Accumulate and Denoise as the documentation has it.
std::vector<Image3> DenoiseByHand(const Settings& s, const std::vector<Frame>& frames) {
  Denoiser forward = MakeDenoiser(s);
  std::vector<Image3> pictures;
  for (size_t begin = 0; begin < frames.size(); begin += 16) {
    Denoiser backward = MakeDenoiser(s);
    std::vector<FutureLight> future(frames.size());
    const size_t last = std::min(begin + 32, frames.size()) - 1;
    for (size_t i = last + 1; i-- > begin;) {
      Frame frame = frames[i];
      if (i < last) {
        frame.guides.motion =
            ReverseMotion(frames[i + 1].guides.motion, frames[i + 1].guides.depth);
      }
      EXPECT_TRUE(backward.Accumulate(frame, &future[i]).ok());
    }
    for (size_t i = begin; i < std::min(begin + 16, frames.size()); ++i) {
      DenoisedFrame out;
      EXPECT_TRUE(forward.Denoise(frames[i], future[i], &out).ok());
      pictures.push_back(std::move(out.colour));
    }
  }
  return pictures;
}

void ExpectSame(const std::vector<Image3>& a, const std::vector<Image3>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(SameBits(a[i], b[i])) << "frame " << i;
  }
}

TEST(FutureBlocks, RangesReachPastTheEndOfTheirBlock) {
  const FutureRange first = FutureRangeFrom(0, 100, 16);
  EXPECT_EQ(first.end, 16u);
  EXPECT_EQ(first.look_end, 32u);
  const FutureRange part = FutureRangeFrom(20, 40, 5);
  EXPECT_EQ(part.begin, 20u);
  EXPECT_EQ(part.end, 25u);
  EXPECT_EQ(part.look_end, 40u);
  EXPECT_EQ(CountBackwardFrames(0, 40, 16), 32u + 24 + 8);
  EXPECT_EQ(CountBackwardFrames(0, 16, 4), 16u + 12 + 8 + 4);
  EXPECT_EQ(CountBackwardFrames(30, 40, 16), 10u + 8);
  EXPECT_EQ(FramesNeeded(15), 32u);
  EXPECT_EQ(FramesNeeded(16), 48u);
}

TEST(TwoWay, EqualsThePassesPutTogetherByHand) {
  const Settings s;
  for (const int count : {1, 16, 40}) {
    const std::vector<Frame> frames = BusyFrames(count);
    TwoWayDenoiser denoiser = MakeTwoWay(s);
    ExpectSame(DenoiseAll(&denoiser, frames), DenoiseByHand(s, frames));
  }
}

TEST(TwoWay, BitsDependNeitherOnTheFuturesHeldNorOnWhenFramesArePulled) {
  const Settings s;
  const std::vector<Frame> frames = BusyFrames(36);
  TwoWayDenoiser whole = MakeTwoWay(s);
  const std::vector<Image3> expected = DenoiseAll(&whole, frames);
  TwoWayOptions few;
  few.futures = 5;
  TwoWayDenoiser parts = MakeTwoWay(s, few);
  ExpectSame(DenoiseAll(&parts, frames), expected);

  TwoWayDenoiser late = MakeTwoWay(s);
  for (const Frame& frame : frames) {
    ASSERT_TRUE(late.Push(frame, Cut::kNo).ok());
  }
  late.Finish();
  std::vector<Image3> pictures;
  PullReady(&late, &pictures);
  ExpectSame(pictures, expected);
}

TEST(TwoWay, ABlockIsReadyOnceItsLookAheadIsKnown) {
  TwoWayDenoiser denoiser = MakeTwoWay(Settings());
  for (size_t i = 0; i < 2 * kMostWaiting; ++i) {
    ASSERT_TRUE(denoiser.Push(MakeWall(8, 8, static_cast<int64_t>(i)), Cut::kNo).ok());
    const bool ready = i + 1 >= kMostWaiting && (i + 1) % kFutureBlock == 0;
    ASSERT_EQ(denoiser.ready(), ready) << i;
    std::vector<Image3> pictures;
    PullReady(&denoiser, &pictures);
    EXPECT_EQ(pictures.size(), ready ? kFutureBlock : 0u);
  }
  EXPECT_EQ(denoiser.waiting(), kLookAhead);
  denoiser.Finish();
  EXPECT_TRUE(denoiser.ready());
  EXPECT_EQ(denoiser.Next()->index, static_cast<int64_t>(2 * kMostWaiting - kLookAhead));
}

TEST(TwoWay, AfterAFinishedSequenceAnotherBegins) {
  const std::vector<Frame> frames = BusyFrames(20);
  TwoWayDenoiser denoiser = MakeTwoWay(Settings());
  const std::vector<Image3> first = DenoiseAll(&denoiser, frames);
  ExpectSame(DenoiseAll(&denoiser, frames), first);
  ASSERT_TRUE(denoiser.Push(frames[7], Cut::kNo).ok());
  denoiser.Reset();
  EXPECT_EQ(denoiser.waiting(), 0u);
  ExpectSame(DenoiseAll(&denoiser, frames), first);
}

TEST(TwoWay, NoLightComesOverACut) {
  std::vector<Frame> frames = BusyFrames(10);
  TwoWayDenoiser denoiser = MakeTwoWay(Settings());
  const std::vector<Frame> shot(frames.begin() + 4, frames.end());
  const std::vector<Image3> alone = DenoiseAll(&denoiser, shot);
  std::vector<Image3> pictures;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (i == 4) {
      frames[i].guides.motion = Image2();  // not used
    }
    ASSERT_TRUE(denoiser.Push(frames[i], i == 4 ? Cut::kYes : Cut::kNo).ok());
  }
  denoiser.Finish();
  PullReady(&denoiser, &pictures);
  ASSERT_EQ(pictures.size(), 10u);
  pictures.erase(pictures.begin(), pictures.begin() + 4);
  ExpectSame(pictures, alone);
}

TEST(TwoWay, FindsCutsAndChangesOfSize) {
  const auto wall = [](int width, float depth, int64_t index) {
    Frame frame = MakeWall(width, 16, index);
    frame.guides.depth.Fill(depth);
    test::FillImage<3>(&frame.signals[0].radiance, [&](int x, int y, int) {
      return test::Random(static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                          static_cast<uint32_t>(index));
    });
    return frame;
  };
  const auto last_picture = [&](const std::vector<Frame>& frames) {
    TwoWayDenoiser denoiser = MakeTwoWay(Settings());
    for (const Frame& frame : frames) {
      EXPECT_TRUE(denoiser.Push(frame).ok());
    }
    denoiser.Finish();
    std::vector<Image3> pictures;
    PullReady(&denoiser, &pictures);
    return std::move(pictures.back());
  };
  const Image3 alone = last_picture({wall(16, 5, 2)});
  EXPECT_TRUE(SameBits(last_picture({wall(16, 50, 1), wall(16, 5, 2)}), alone));
  EXPECT_TRUE(SameBits(last_picture({wall(20, 5, 1), wall(16, 5, 2)}), alone));
  EXPECT_FALSE(SameBits(last_picture({wall(16, 5.01f, 1), wall(16, 5, 2)}), alone));
}

TEST(TwoWay, MotionTowardsTheNextFrameIsUsedWhereItIsGiven) {
  const std::vector<Frame> frames = BusyFrames(3);
  TwoWayDenoiser denoiser = MakeTwoWay(Settings());
  const std::vector<Image3> found = DenoiseAll(&denoiser, frames);
  for (const bool same : {true, false}) {
    for (size_t i = 0; i < frames.size(); ++i) {
      Image2 motion;
      if (i + 1 < frames.size()) {
        motion = ReverseMotion(frames[i + 1].guides.motion, frames[i + 1].guides.depth);
        motion[0](20, 10) += same ? 0.0f : 5.0f;
      }
      ASSERT_TRUE(denoiser.Push(frames[i], Cut::kNo, std::move(motion)).ok());
    }
    denoiser.Finish();
    std::vector<Image3> given;
    PullReady(&denoiser, &given);
    EXPECT_EQ(SameBits(given[0], found[0]), same);
  }
}

TEST(TwoWay, CancellingLosesNothing) {
  const std::vector<Frame> frames = BusyFrames(12);
  TwoWayDenoiser denoiser = MakeTwoWay(Settings());
  const std::vector<Image3> expected = DenoiseAll(&denoiser, frames);
  for (const Frame& frame : frames) {
    ASSERT_TRUE(denoiser.Push(frame, Cut::kNo).ok());
  }
  denoiser.Finish();
  std::vector<Image3> pictures;
  DenoisedFrame out;
  std::vector<double> steps;
  for (const size_t stop_at : {1u, 7u, 13u}) {
    steps.clear();
    const Result<bool> pulled = denoiser.Pull(&out, nullptr, [&](double done) {
      steps.push_back(done);
      return steps.size() < stop_at;
    });
    EXPECT_EQ(pulled.status().code(), StatusCode::kCancelled);
    EXPECT_EQ(denoiser.waiting(), frames.size());
  }
  EXPECT_EQ(steps.front(), 0.0);
  EXPECT_NEAR(steps.back(), 12.0 / 13, 1e-9);
  PullReady(&denoiser, &pictures);
  ExpectSame(pictures, expected);
}

TEST(TwoWay, HandsTheNoisyFrameBack) {
  TwoWayDenoiser denoiser = MakeTwoWay(Settings());
  ASSERT_TRUE(denoiser.SetOutputs({"temporal"}).ok());
  const Frame frame = MakeBusyFrame(kWidth, kHeight, 5);
  ASSERT_TRUE(denoiser.Push(frame).ok());
  ASSERT_TRUE(denoiser.Push(MakeBusyFrame(kWidth, kHeight, 6)).ok());
  denoiser.Finish();
  DenoisedFrame out;
  Frame noisy;
  ASSERT_TRUE(denoiser.Pull(&out, &noisy).ok());
  EXPECT_EQ(noisy.index, 5);
  EXPECT_TRUE(SameBits(noisy.signals[1].radiance, frame.signals[1].radiance));
  for (int c = 0; c < 2; ++c) {
    EXPECT_EQ(noisy.guides.motion[c](9, 9), frame.guides.motion[c](9, 9));
  }
  ASSERT_EQ(out.images.size(), 1u);
  EXPECT_EQ(out.images[0].name, "temporal");
}

TEST(TwoWay, WrongCallsNameWhatIsWrong) {
  Settings still;
  still.temporal = false;
  EXPECT_THAT(TwoWayDenoiser::Create(still).status().message(), HasSubstr("'temporal'"));
  TwoWayOptions options;
  options.futures = 17;
  EXPECT_THAT(TwoWayDenoiser::Create(Settings(), Device(), options).status().message(),
              HasSubstr("futures is 17, expected 1 to 16"));
  TwoWayDenoiser denoiser = MakeTwoWay(Settings());
  ASSERT_TRUE(denoiser.Push(MakeWall(8, 8, 0)).ok());
  Frame lacks_motion = MakeWall(8, 8, 1);
  lacks_motion.guides.motion = Image2();
  EXPECT_THAT(denoiser.Push(lacks_motion).message(), HasSubstr("image 'motion' is missing"));
  EXPECT_THAT(denoiser.Push(MakeWall(8, 8, 1), Cut::kNo, Image2(8, 9)).message(),
              HasSubstr("frame 1: image 'next_motion' is 8x9, expected 8x8"));
  EXPECT_EQ(denoiser.waiting(), 1u);
  denoiser.Finish();
  EXPECT_THAT(denoiser.Push(MakeWall(8, 8, 1)).message(), HasSubstr("1 of its frames wait"));
}

/// The most memory that is held while a sequence is denoised.
size_t MostHeld(TwoWayDenoiser* denoiser, const std::vector<Frame>& frames, bool next_motion) {
  size_t most = 0;
  for (const Frame& frame : frames) {
    Image2 motion = next_motion ? Image2(frame.width, frame.height) : Image2();
    EXPECT_TRUE(denoiser->Push(frame, Cut::kNo, std::move(motion)).ok());
    DenoisedFrame out;
    while (denoiser->ready()) {
      // Between the backward pass and the first frame of the block.
      EXPECT_TRUE(denoiser
                      ->Pull(&out, nullptr,
                             [&](double) {
                               most = std::max(most, denoiser->memory_bytes());
                               return true;
                             })
                      .ok());
    }
  }
  return most;
}

TEST(TwoWay, TheMemoryNeedIsExact) {
  Settings svgf = PresetSettings("svgf").value();
  Settings psvgf = PresetSettings("psvgf").value();
  struct Case {
    Settings settings;
    int width;
    int height;
    bool next_motion;
    size_t futures;
  };
  for (const Case& c : {Case{Settings(), 64, 48, false, 16}, Case{Settings(), 101, 67, true, 3},
                        Case{svgf, 53, 5, false, 16}, Case{psvgf, 40, 31, true, 1}}) {
    std::vector<Frame> frames;
    for (int i = 0; i < 48; ++i) {
      frames.push_back(MakeBusyFrame(c.width, c.height, i));
      frames.back().samples = Image1();  // one everywhere
    }
    TwoWayOptions options;
    options.futures = c.futures;
    const Result<TwoWayMemory> need =
        TwoWayDenoiser::MemoryNeed(c.settings, frames.front(), c.next_motion, Device(), options);
    ASSERT_TRUE(need.ok()) << need.status().message();
    TwoWayDenoiser denoiser = MakeTwoWay(c.settings, options);
    EXPECT_EQ(MostHeld(&denoiser, frames, c.next_motion), need->most) << c.width << "x" << c.height;
  }
}

TEST(TwoWay, TheMemoryNeedIsKnownBeforeThereIsAFrame) {
  const Frame frame = MakeBusyFrame(64, 48, 0);
  Frame shape;
  shape.width = 64;
  shape.height = 48;
  for (const Signal& signal : frame.signals) {
    shape.signals.push_back({signal.kind, Image3(1, 1), Image1()});
  }
  Guides& g = shape.guides;
  g.albedo = g.specular_albedo = Image3(1, 1);
  g.id = Plane<uint32_t>(1, 1);
  g.roughness = shape.samples = Image1(1, 1);
  shape.emission = shape.background = Image3(1, 1);
  const Result<TwoWayMemory> of_shape = TwoWayDenoiser::MemoryNeed(Settings(), shape);
  const Result<TwoWayMemory> of_frame = TwoWayDenoiser::MemoryNeed(Settings(), frame);
  ASSERT_TRUE(of_shape.ok() && of_frame.ok());
  EXPECT_EQ(of_shape->most, of_frame->most);
  EXPECT_EQ(of_frame->per_frame, FrameBytes(frame));
}

}  // namespace
}  // namespace stillray::two_way_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames that are pushed, and pulled when light of the past and of the future is known.
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "capi/capi_frames.h"
#include "stillray/two_way.hpp"

namespace stillray::test::two_way_test {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 29;
constexpr int kHeight = 18;

CallerFrame BusyFrame(int index) {
  return CallerFrame(MakeBusyFrame(kWidth, kHeight, index));
}

void Push(stillray_denoiser* denoiser, CallerFrame* frame, int32_t cut = STILLRAY_CUT_NO) {
  frame->Give(denoiser);
  ASSERT_EQ(stillray_denoiser_push(denoiser, cut), STILLRAY_OK) << stillray_error_message(denoiser);
  // Its memory goes with the frame.
  ASSERT_EQ(stillray_denoiser_set_output(denoiser, "colour", nullptr), STILLRAY_OK);
}

/// Pulls all frames that are ready.
void PullReady(stillray_denoiser* denoiser, std::vector<std::vector<char>>* pictures) {
  Buffer colour(kWidth, kHeight, 3, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
  ASSERT_EQ(stillray_denoiser_set_output(denoiser, "colour", &colour.image), STILLRAY_OK);
  for (;;) {
    int32_t pulled = 0;
    ASSERT_EQ(stillray_denoiser_pull(denoiser, &pulled), STILLRAY_OK)
        << stillray_error_message(denoiser);
    if (pulled == 0) {
      return;
    }
    pictures->push_back(colour.bytes);
  }
}

std::vector<std::vector<char>> DenoiseBusyFrames(stillray_denoiser* denoiser, int count) {
  std::vector<std::vector<char>> pictures;
  for (int i = 0; i < count; ++i) {
    CallerFrame frame = BusyFrame(i);
    Push(denoiser, &frame);
    PullReady(denoiser, &pictures);
  }
  EXPECT_EQ(stillray_denoiser_finish(denoiser), STILLRAY_OK);
  PullReady(denoiser, &pictures);
  return pictures;
}

std::vector<char> Interleaved(const Image3& image) {
  Buffer buffer(image.width(), image.height(), 3, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        buffer.Set(x, y, c, image[c](x, y));
      }
    }
  }
  return buffer.bytes;
}

stillray_waiting Waiting(stillray_denoiser* denoiser) {
  stillray_waiting waiting = STILLRAY_WAITING_INIT;
  EXPECT_EQ(stillray_denoiser_waiting(denoiser, &waiting), STILLRAY_OK);
  return waiting;
}

TEST(TwoWayCapi, GivesTheEnginesBits) {
  constexpr int kFrames = 36;
  Result<TwoWayDenoiser> engine = TwoWayDenoiser::Create(Settings());
  ASSERT_TRUE(engine.ok());
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(engine->Push(MakeBusyFrame(kWidth, kHeight, i), Cut::kNo).ok());
  }
  engine->Finish();
  const DenoiserHandle denoiser = MakeDenoiser();
  const std::vector<std::vector<char>> pictures = DenoiseBusyFrames(denoiser.get(), kFrames);
  ASSERT_EQ(pictures.size(), static_cast<size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i) {
    DenoisedFrame out;
    ASSERT_TRUE(engine->Pull(&out).ok());
    EXPECT_EQ(pictures[static_cast<size_t>(i)], Interleaved(out.colour)) << "frame " << i;
  }
}

TEST(TwoWayCapi, SaysWhatWaits) {
  const DenoiserHandle denoiser = MakeDenoiser();
  EXPECT_EQ(Waiting(denoiser.get()).frames, 0u);
  int32_t pulled = 1;
  EXPECT_EQ(stillray_denoiser_pull(denoiser.get(), &pulled), STILLRAY_OK);
  EXPECT_EQ(pulled, 0);
  ASSERT_EQ(stillray_denoiser_set_frame_index(denoiser.get(), 101), STILLRAY_OK);
  for (int i = 0; i < 2; ++i) {
    CallerFrame frame = BusyFrame(i);
    Push(denoiser.get(), &frame);
  }
  EXPECT_EQ(Waiting(denoiser.get()).ready, 0);
  ASSERT_EQ(stillray_denoiser_finish(denoiser.get()), STILLRAY_OK);
  const stillray_waiting first = Waiting(denoiser.get());
  EXPECT_EQ(first.frames, 2u);
  EXPECT_EQ(first.ready, 1);
  EXPECT_EQ(first.width, kWidth);
  EXPECT_EQ(first.height, kHeight);
  EXPECT_EQ(first.index, 101);
  Buffer colour(kWidth, kHeight, 3, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
  ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), "colour", &colour.image), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_pull(denoiser.get(), &pulled), STILLRAY_OK);
  EXPECT_EQ(Waiting(denoiser.get()).index, 102);
  ASSERT_EQ(stillray_denoiser_reset(denoiser.get()), STILLRAY_OK);
  EXPECT_EQ(Waiting(denoiser.get()).frames, 0u);
}

TEST(TwoWayCapi, OtherOutputsBelongToTheFrameThatIsPulled) {
  const DenoiserHandle denoiser = MakeDenoiser();
  for (int i = 0; i < 3; ++i) {
    CallerFrame frame(MakeSparseLight(kWidth, kHeight, i, 0.5f, 0.6f));
    Push(denoiser.get(), &frame);
  }
  ASSERT_EQ(stillray_denoiser_finish(denoiser.get()), STILLRAY_OK);
  Buffer variance(kWidth, kHeight, 1, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
  Buffer length(kWidth, kHeight, 1, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
  ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), "variance", &variance.image), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), "history_length", &length.image),
            STILLRAY_OK);
  int32_t pulled = 0;
  ASSERT_EQ(stillray_denoiser_pull(denoiser.get(), &pulled), STILLRAY_OK);
  double sum = 0;
  float longest = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      sum += variance.Get(x, y, 0);
      longest = std::max(longest, length.Get(x, y, 0));
    }
  }
  EXPECT_GT(sum, 0);
  EXPECT_GT(longest, 1.5f);  // of a first frame, which alone has one sample
}

TEST(TwoWayCapi, MotionTowardsTheNextFrameIsAnInput) {
  std::vector<std::vector<char>> pictures;
  for (const float shift : {0.0f, 0.0f, 9.0f}) {
    const DenoiserHandle denoiser = MakeDenoiser();
    for (int i = 0; i < 2; ++i) {
      CallerFrame frame = BusyFrame(i);
      Image2 motion(kWidth, kHeight);
      motion[0].Fill(-1.25f + shift);
      motion[1].Fill(0.5f);
      frame.Add("next_motion", motion);
      Push(denoiser.get(), &frame);
    }
    ASSERT_EQ(stillray_denoiser_finish(denoiser.get()), STILLRAY_OK);
    std::vector<std::vector<char>> of_run;
    PullReady(denoiser.get(), &of_run);
    pictures.push_back(of_run.front());
  }
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_NE(pictures[0], pictures[2]);
}

TEST(TwoWayCapi, CancellingLosesNothing) {
  const DenoiserHandle undisturbed = MakeDenoiser();
  const std::vector<std::vector<char>> expected = DenoiseBusyFrames(undisturbed.get(), 6);
  const DenoiserHandle denoiser = MakeDenoiser();
  Buffer colour(kWidth, kHeight, 3, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
  for (int i = 0; i < 6; ++i) {
    CallerFrame frame = BusyFrame(i);
    Push(denoiser.get(), &frame);
  }
  ASSERT_EQ(stillray_denoiser_finish(denoiser.get()), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), "colour", &colour.image), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_set_progress(
                denoiser.get(), [](void*, double) { return 1; }, nullptr),
            STILLRAY_OK);
  int32_t pulled = 1;
  EXPECT_EQ(stillray_denoiser_pull(denoiser.get(), &pulled), STILLRAY_ERROR_CANCELLED);
  EXPECT_EQ(pulled, 0);
  EXPECT_EQ(Waiting(denoiser.get()).frames, 6u);
  ASSERT_EQ(stillray_denoiser_set_progress(denoiser.get(), nullptr, nullptr), STILLRAY_OK);
  std::vector<std::vector<char>> pictures;
  PullReady(denoiser.get(), &pictures);
  EXPECT_EQ(pictures, expected);
}

TEST(TwoWayCapi, TheMemoryNeedIsThatOfTheEngine) {
  const DenoiserHandle denoiser = MakeDenoiser();
  stillray_memory_need need = STILLRAY_MEMORY_NEED_INIT;
  EXPECT_EQ(stillray_denoiser_memory_need(denoiser.get(), &need), STILLRAY_ERROR_INVALID_ARGUMENT);
  const Frame frame = MakeBusyFrame(kWidth, kHeight, 0);
  CallerFrame caller(frame);
  caller.Give(denoiser.get());
  ASSERT_EQ(stillray_denoiser_memory_need(denoiser.get(), &need), STILLRAY_OK)
      << stillray_error_message(denoiser.get());
  const Result<TwoWayMemory> expected = TwoWayDenoiser::MemoryNeed(Settings(), frame);
  ASSERT_TRUE(expected.ok());
  EXPECT_EQ(need.denoisers, expected->denoisers);
  EXPECT_EQ(need.per_future, expected->per_future);
  EXPECT_EQ(need.per_frame, expected->per_frame);
  EXPECT_EQ(need.most, expected->most);
  Push(denoiser.get(), &caller);
  stillray_statistics statistics = STILLRAY_STATISTICS_INIT;
  ASSERT_EQ(stillray_denoiser_statistics(denoiser.get(), &statistics), STILLRAY_OK);
  EXPECT_GE(statistics.memory_bytes, need.per_frame);
}

TEST(TwoWayCapi, WrongCallsNameWhatIsWrong) {
  const DenoiserHandle denoiser = MakeDenoiser();
  const auto message = [&] { return std::string(stillray_error_message(denoiser.get())); };
  CallerFrame frame = BusyFrame(0);
  frame.Give(denoiser.get());
  EXPECT_EQ(stillray_denoiser_push(denoiser.get(), 3), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(message(), "cut is 3, expected 0 to 2");
  Push(denoiser.get(), &frame);

  EXPECT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_THAT(message(), HasSubstr("execute was called while frames wait (1)"));
  ASSERT_EQ(stillray_denoiser_set(denoiser.get(), "sigma_l", "2"), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_push(denoiser.get(), STILLRAY_CUT_NO),
            STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_THAT(message(), HasSubstr("settings were changed while frames wait (1)"));

  ASSERT_EQ(stillray_denoiser_finish(denoiser.get()), STILLRAY_OK);
  Buffer small(kWidth, kHeight - 1, 3, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
  ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), "colour", &small.image), STILLRAY_OK);
  int32_t pulled = 1;
  EXPECT_EQ(stillray_denoiser_pull(denoiser.get(), &pulled), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(message(), "image 'colour' is 29x17, expected 29x18 as frame 0");
  EXPECT_EQ(pulled, 0);
  EXPECT_EQ(stillray_denoiser_pull(denoiser.get(), nullptr), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(message(), "pulled is NULL");
  std::vector<std::vector<char>> pictures;
  PullReady(denoiser.get(), &pictures);
  EXPECT_EQ(pictures.size(), 1u);  // it waited

  ASSERT_EQ(stillray_denoiser_set(denoiser.get(), "temporal", "off"), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_set(denoiser.get(), "antialias", "off"), STILLRAY_OK);
  frame.Give(denoiser.get());
  EXPECT_EQ(stillray_denoiser_push(denoiser.get(), STILLRAY_CUT_NO),
            STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_THAT(message(), HasSubstr("parameter 'temporal' is 'off'"));
  stillray_waiting waiting = {};
  EXPECT_EQ(stillray_denoiser_waiting(denoiser.get(), &waiting), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(message(), "waiting->struct_size is 0, expected sizeof(stillray_waiting)");
}

}  // namespace
}  // namespace stillray::test::two_way_test

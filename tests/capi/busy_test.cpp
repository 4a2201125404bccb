// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A second call on a denoiser that is at work is refused, and harms neither call.
#include <future>
#include <thread>

#include <gmock/gmock.h>

#include "capi/capi_frames.h"

namespace stillray::test::busy_test {
namespace {

constexpr char kAtWork[] =
    "this denoiser is at work on a frame: wait for it, or use one per thread";

CallerFrame Busy(int index) {
  return CallerFrame(MakeBusyFrame(40, 24, index));
}

std::vector<char> Denoise(stillray_denoiser* denoiser, int index) {
  CallerFrame caller = Busy(index);
  caller.Run(denoiser);
  return caller.colour.bytes;
}

/// The codes of every call that works on the denoiser.
std::vector<stillray_error> CallEverything(stillray_denoiser* denoiser, const stillray_image& image,
                                           stillray_progress progress) {
  const char* text = nullptr;
  size_t size = 0;
  char byte = 0;
  stillray_statistics statistics = STILLRAY_STATISTICS_INIT;
  return {stillray_denoiser_execute(denoiser),
          stillray_denoiser_set_preset(denoiser, "svgf"),
          stillray_denoiser_set(denoiser, "wavelet", "off"),
          stillray_denoiser_get(denoiser, "wavelet", &text),
          stillray_denoiser_set_input(denoiser, "depth", nullptr),
          stillray_denoiser_set_output(denoiser, "colour", &image),
          stillray_denoiser_set_jitter(denoiser, 0.25f, 0.25f),
          stillray_denoiser_set_focal_pixels(denoiser, 100),
          stillray_denoiser_set_progress(denoiser, progress, nullptr),
          stillray_denoiser_resize(denoiser, 8, 8),
          stillray_denoiser_reset(denoiser),
          stillray_denoiser_save_history(denoiser, nullptr, 0, &size),
          stillray_denoiser_restore_history(denoiser, &byte, 1),
          stillray_denoiser_statistics(denoiser, &statistics)};
}

struct Inner {
  stillray_denoiser* denoiser = nullptr;
  stillray_image image = {};
  std::vector<stillray_error> errors;
  std::string message;
  size_t outputs = 1;
};

int CallFromWithin(void* user, double fraction) {
  auto* inner = static_cast<Inner*>(user);
  if (fraction == 0) {
    inner->outputs = stillray_denoiser_output_count(inner->denoiser);
    EXPECT_EQ(stillray_denoiser_output_name(inner->denoiser, 0), nullptr);
    inner->errors = CallEverything(inner->denoiser, inner->image, nullptr);
    inner->message = stillray_error_message(inner->denoiser);
  }
  return 0;
}

TEST(BusyTest, CallsFromItsOwnProgressCallbackAreRefused) {
  const DenoiserHandle denoiser = MakeDenoiser();
  const DenoiserHandle undisturbed = MakeDenoiser();
  float value[64 * 3] = {};
  Inner inner;
  inner.denoiser = denoiser.get();
  inner.image = stillray_interleaved(value, STILLRAY_FORMAT_FLOAT, 3, 8, 8);
  ASSERT_EQ(stillray_denoiser_set_progress(denoiser.get(), CallFromWithin, &inner), STILLRAY_OK);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(Denoise(denoiser.get(), i), Denoise(undisturbed.get(), i));
  }
  EXPECT_THAT(inner.errors, testing::Each(STILLRAY_ERROR_BUSY));
  EXPECT_EQ(inner.outputs, 0u);
  EXPECT_EQ(inner.message, kAtWork);
  EXPECT_STREQ(stillray_error_name(STILLRAY_ERROR_BUSY), "busy");
}

/// Holds the first frame until another thread has made its calls.
struct Gate {
  std::promise<void> at_work;
  std::promise<void> opened;
  bool passed = false;
};

int WaitAtGate(void* user, double /*fraction*/) {
  auto* gate = static_cast<Gate*>(user);
  if (!gate->passed) {
    gate->passed = true;
    gate->at_work.set_value();
    gate->opened.get_future().wait();
  }
  return 0;
}

TEST(BusyTest, CallsFromAnotherThreadAreRefused) {
  const DenoiserHandle denoiser = MakeDenoiser();
  const DenoiserHandle undisturbed = MakeDenoiser();
  Gate gate;
  ASSERT_EQ(stillray_denoiser_set_progress(denoiser.get(), WaitAtGate, &gate), STILLRAY_OK);
  std::vector<char> first;
  std::thread worker([&] { first = Denoise(denoiser.get(), 0); });
  gate.at_work.get_future().wait();
  float value[64 * 3] = {};
  const stillray_image image = stillray_interleaved(value, STILLRAY_FORMAT_FLOAT, 3, 8, 8);
  EXPECT_THAT(CallEverything(denoiser.get(), image, nullptr), testing::Each(STILLRAY_ERROR_BUSY));
  EXPECT_STREQ(stillray_error_message(denoiser.get()), kAtWork);
  gate.opened.set_value();
  worker.join();
  // Still the reason of this thread's last failure, and not of the worker's, which had none.
  EXPECT_STREQ(stillray_error_message(denoiser.get()), kAtWork);
  EXPECT_EQ(first, Denoise(undisturbed.get(), 0));
  EXPECT_EQ(Denoise(denoiser.get(), 1), Denoise(undisturbed.get(), 1));
  EXPECT_STREQ(stillray_error_message(denoiser.get()), "");
}

TEST(BusyTest, ManyThreadsOnOneDenoiserEndInPicturesOrRefusals) {
  const DenoiserHandle denoiser = MakeDenoiser();
  CallerFrame caller = Busy(0);
  caller.Give(denoiser.get());
  std::vector<std::thread> threads;
  std::atomic<int> pictures = 0;
  std::atomic<int> refusals = 0;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 50; ++i) {
        const stillray_error error = stillray_denoiser_execute(denoiser.get());
        pictures += error == STILLRAY_OK ? 1 : 0;
        refusals += error == STILLRAY_ERROR_BUSY ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_GE(pictures, 1);
  EXPECT_EQ(pictures + refusals, 200);
}

int ReleaseWithin(void* user, double fraction) {
  if (fraction == 0) {
    stillray_denoiser_release(*static_cast<stillray_denoiser**>(user));
  }
  return 0;
}

TEST(BusyTest, ReleasedWhileAtWorkItFinishesItsFrame) {
  stillray_denoiser* denoiser = MakeDenoiser().release();
  const DenoiserHandle undisturbed = MakeDenoiser();
  CallerFrame caller = Busy(0);
  caller.Give(denoiser);
  ASSERT_EQ(stillray_denoiser_set_progress(denoiser, ReleaseWithin, &denoiser), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_execute(denoiser), STILLRAY_OK);
  EXPECT_EQ(caller.colour.bytes, Denoise(undisturbed.get(), 0));
}

}  // namespace
}  // namespace stillray::test::busy_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// State that outlasts a frame: history, sizes, settings, progress.
#include <thread>

#include <gmock/gmock.h>

#include "capi/capi_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::test::session_test {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 24;

CallerFrame Busy(int index, int width = kWidth, int height = kHeight) {
  return CallerFrame(MakeBusyFrame(width, height, index));
}

std::vector<char> Denoise(stillray_denoiser* denoiser, int index, int width = kWidth,
                          int height = kHeight) {
  CallerFrame caller = Busy(index, width, height);
  caller.Run(denoiser);
  return caller.colour.bytes;
}

std::vector<char> FirstFrame(int index, int width = kWidth, int height = kHeight) {
  const DenoiserHandle fresh = MakeDenoiser();
  return Denoise(fresh.get(), index, width, height);
}

TEST(SessionTest, SavedHistoryContinuesWithTheSameBits) {
  const DenoiserHandle whole = MakeDenoiser();
  Denoise(whole.get(), 0);
  Denoise(whole.get(), 1);
  size_t size = 0;
  ASSERT_EQ(stillray_denoiser_save_history(whole.get(), nullptr, 0, &size), STILLRAY_OK);
  std::vector<char> saved(size);
  ASSERT_EQ(stillray_denoiser_save_history(whole.get(), saved.data(), size, &size), STILLRAY_OK);
  EXPECT_EQ(size, saved.size());

  const DenoiserHandle later = MakeDenoiser();
  ASSERT_EQ(stillray_denoiser_restore_history(later.get(), saved.data(), saved.size()),
            STILLRAY_OK);
  const std::vector<char> continued = Denoise(later.get(), 2);
  EXPECT_EQ(continued, Denoise(whole.get(), 2));
  EXPECT_NE(continued, FirstFrame(2));
}

TEST(SessionTest, DamagedHistoryLeavesTheOldOne) {
  const DenoiserHandle denoiser = MakeDenoiser();
  const DenoiserHandle undisturbed = MakeDenoiser();
  Denoise(denoiser.get(), 0);
  Denoise(undisturbed.get(), 0);
  size_t size = 0;
  ASSERT_EQ(stillray_denoiser_save_history(denoiser.get(), nullptr, 0, &size), STILLRAY_OK);
  std::vector<char> saved(size);
  ASSERT_EQ(stillray_denoiser_save_history(denoiser.get(), saved.data(), size, &size), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_restore_history(denoiser.get(), saved.data(), size - 1),
            STILLRAY_ERROR_BAD_DATA);
  EXPECT_EQ(stillray_denoiser_restore_history(denoiser.get(), saved.data(), 0),
            STILLRAY_ERROR_BAD_DATA);
  saved[0] ^= 1;
  EXPECT_EQ(stillray_denoiser_restore_history(denoiser.get(), saved.data(), size),
            STILLRAY_ERROR_BAD_DATA);
  EXPECT_STRNE(stillray_error_message(denoiser.get()), "");
  EXPECT_EQ(Denoise(denoiser.get(), 1), Denoise(undisturbed.get(), 1));
}

TEST(SessionTest, HistoryBeforeTheFirstFrameCanBeSaved) {
  const DenoiserHandle denoiser = MakeDenoiser();
  size_t size = 0;
  EXPECT_EQ(stillray_denoiser_save_history(denoiser.get(), nullptr, 0, &size), STILLRAY_OK);
  EXPECT_GT(size, 0u);
}

TEST(SessionTest, SmallBufferIsNotWritten) {
  const DenoiserHandle denoiser = MakeDenoiser();
  Denoise(denoiser.get(), 0);
  size_t needed = 0;
  ASSERT_EQ(stillray_denoiser_save_history(denoiser.get(), nullptr, 0, &needed), STILLRAY_OK);
  std::vector<char> small(100, 7);
  size_t size = 0;
  EXPECT_EQ(stillray_denoiser_save_history(denoiser.get(), small.data(), small.size(), &size),
            STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(size, needed);
  EXPECT_EQ(small, std::vector<char>(100, 7));
}

TEST(SessionTest, ResetMakesTheNextFrameAFirstFrame) {
  const DenoiserHandle denoiser = MakeDenoiser();
  Denoise(denoiser.get(), 0);
  ASSERT_EQ(stillray_denoiser_reset(denoiser.get()), STILLRAY_OK);
  EXPECT_EQ(Denoise(denoiser.get(), 1), FirstFrame(1));
}

TEST(SessionTest, AnotherResolutionRestartsAndWorks) {
  const DenoiserHandle denoiser = MakeDenoiser();
  for (const auto& [width, height] :
       {std::pair{40, 24}, {64, 48}, {1, 1}, {17, 3}, {17, 40}, {40, 24}}) {
    EXPECT_EQ(Denoise(denoiser.get(), 1, width, height), FirstFrame(1, width, height))
        << width << "x" << height;
  }
}

TEST(SessionTest, ResizeForgetsImagesAndRefusesOthers) {
  const DenoiserHandle denoiser = MakeDenoiser();
  Denoise(denoiser.get(), 0);
  ASSERT_EQ(stillray_denoiser_resize(denoiser.get(), 20, 10), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_STREQ(stillray_error_message(denoiser.get()), "no input is set");
  stillray_statistics statistics = STILLRAY_STATISTICS_INIT;
  ASSERT_EQ(stillray_denoiser_statistics(denoiser.get(), &statistics), STILLRAY_OK);
  EXPECT_EQ(statistics.memory_bytes, 0u);
  float value = 0;
  const stillray_image image = stillray_interleaved(&value, STILLRAY_FORMAT_FLOAT, 1, 1, 1);
  EXPECT_EQ(stillray_denoiser_set_input(denoiser.get(), "depth", &image),
            STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_STREQ(stillray_error_message(denoiser.get()),
               "image 'depth' is 1x1, expected 20x10 as resized to");
  EXPECT_EQ(Denoise(denoiser.get(), 1, 20, 10), FirstFrame(1, 20, 10));
  ASSERT_EQ(stillray_denoiser_resize(denoiser.get(), 0, 0), STILLRAY_OK);
  EXPECT_EQ(Denoise(denoiser.get(), 2), FirstFrame(2));
}

TEST(SessionTest, SettingsComeBackAsText) {
  const DenoiserHandle denoiser = MakeDenoiser("svgf");
  const char* value = nullptr;
  ASSERT_EQ(stillray_denoiser_get(denoiser.get(), "alpha_min", &value), STILLRAY_OK);
  EXPECT_STREQ(value, "0.2");
  ASSERT_EQ(stillray_denoiser_set(denoiser.get(), "alpha_min", "0.15"), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_get(denoiser.get(), "alpha_min", &value), STILLRAY_OK);
  EXPECT_STREQ(value, "0.15");
  ASSERT_EQ(stillray_denoiser_set_preset(denoiser.get(), "default"), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_get(denoiser.get(), "alpha_min", &value), STILLRAY_OK);
  EXPECT_STREQ(value, "0.1");
}

TEST(SessionTest, ASettingChangesTheNextFrame) {
  const DenoiserHandle denoiser = MakeDenoiser();
  ASSERT_EQ(stillray_denoiser_set(denoiser.get(), "wavelet", "off"), STILLRAY_OK);
  EXPECT_NE(Denoise(denoiser.get(), 0), FirstFrame(0));
}

TEST(SessionTest, JitterTurnsAntialiasingInTimeOn) {
  const auto second = [](float jitter, const char* antialias) {
    const DenoiserHandle denoiser = MakeDenoiser();
    // Expects differences by jitter.
    EXPECT_EQ(stillray_denoiser_set(denoiser.get(), "limit_history", "off"), STILLRAY_OK);
    if (antialias != nullptr) {
      EXPECT_EQ(stillray_denoiser_set(denoiser.get(), "antialias", antialias), STILLRAY_OK);
    }
    std::vector<char> colour;
    for (int i = 0; i < 2; ++i) {
      CallerFrame caller = Busy(i);
      caller.jitter_x = caller.jitter_y = jitter;
      caller.Run(denoiser.get());
      colour = caller.colour.bytes;
    }
    return colour;
  };
  EXPECT_NE(second(0.25f, nullptr), second(0, nullptr));
  EXPECT_EQ(second(0.25f, nullptr), second(0, "taa"));
  EXPECT_EQ(second(0, nullptr), second(0.25f, "off"));
}

TEST(SessionTest, PositionsFollowFromTheFocalLength) {
  const auto denoise = [](float focal_pixels) {
    const DenoiserHandle denoiser = MakeDenoiser();
    EXPECT_EQ(stillray_denoiser_set(denoiser.get(), "depth_weight", "position"), STILLRAY_OK);
    CallerFrame caller = Busy(0);
    caller.focal_pixels = focal_pixels;
    caller.Run(denoiser.get());
    return caller.colour.bytes;
  };
  EXPECT_NE(denoise(10), denoise(100));
  const DenoiserHandle denoiser = MakeDenoiser();
  ASSERT_EQ(stillray_denoiser_set(denoiser.get(), "depth_weight", "position"), STILLRAY_OK);
  CallerFrame caller = Busy(0);
  caller.focal_pixels = 0;
  caller.Give(denoiser.get());
  EXPECT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_THAT(stillray_error_message(denoiser.get()),
              testing::HasSubstr("stillray_denoiser_set_focal_pixels"));
}

TEST(SessionTest, EveryParameterTakesItsDefault) {
  const DenoiserHandle denoiser = MakeDenoiser();
  ASSERT_GT(stillray_parameter_count(), 20u);
  for (size_t i = 0; i < stillray_parameter_count(); ++i) {
    stillray_parameter p = STILLRAY_PARAMETER_INIT;
    ASSERT_EQ(stillray_parameter_at(i, &p), STILLRAY_OK);
    EXPECT_STRNE(p.help, "");
    EXPECT_LE(p.min, p.max);
    EXPECT_EQ(p.choices != nullptr, p.type == STILLRAY_PARAMETER_CHOICE) << p.name;
    for (size_t c = 0; c < p.choice_count; ++c) {
      EXPECT_EQ(stillray_denoiser_set(denoiser.get(), p.name, p.choices[c]), STILLRAY_OK);
    }
    EXPECT_EQ(stillray_denoiser_set(denoiser.get(), p.name, p.default_value), STILLRAY_OK)
        << stillray_error_message(denoiser.get());
  }
  EXPECT_EQ(Denoise(denoiser.get(), 0), FirstFrame(0));
}

TEST(SessionTest, EveryOutputCanBeWritten) {
  const DenoiserHandle denoiser = MakeDenoiser();
  CallerFrame caller = Busy(0);
  caller.Give(denoiser.get());
  const size_t count = stillray_denoiser_output_count(denoiser.get());
  ASSERT_GT(count, 10u);
  std::vector<Buffer> buffers;
  for (size_t i = 0; i < count; ++i) {
    buffers.emplace_back(kWidth, kHeight, 3, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
    const std::string name = stillray_denoiser_output_name(denoiser.get(), i);
    ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), name.c_str(), &buffers.back().image),
              STILLRAY_OK)
        << stillray_error_message(denoiser.get());
  }
  ASSERT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_OK)
      << stillray_error_message(denoiser.get());
  uint32_t untouched = 0x55555555u;
  for (size_t i = 0; i < count; ++i) {
    EXPECT_NE(std::memcmp(buffers[i].bytes.data(), &untouched, 4), 0)
        << stillray_denoiser_output_name(denoiser.get(), i);
  }
  EXPECT_EQ(stillray_denoiser_output_name(denoiser.get(), count), nullptr);
}

TEST(SessionTest, ColourAloneIsDenoised) {
  const DenoiserHandle alone = MakeDenoiser();
  Frame frame = MakeBusyFrame(kWidth, kHeight, 0);
  frame.signals.resize(1);
  frame.guides = Guides();
  frame.emission = frame.background = Image3();
  frame.samples = Image1();
  CallerFrame caller(frame);
  caller.Run(alone.get());
  Result<Denoiser> engine = Denoiser::Create(PresetSettings("default").value());
  ASSERT_TRUE(engine.ok());
  DenoisedFrame expected;
  ASSERT_TRUE(engine->Denoise(frame, &expected).ok());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_EQ(caller.colour.Get(x, y, 1), expected.colour[1](x, y)) << x << " " << y;
    }
  }
}

TEST(SessionTest, ConfidenceAndPreviousNormalsAreThoseOfCpp) {
  const DenoiserHandle denoiser = MakeDenoiser();
  Result<Denoiser> engine = Denoiser::Create(PresetSettings("default").value());
  ASSERT_TRUE(engine.ok());
  for (int i = 0; i < 4; ++i) {
    Frame frame = MakeBusyFrame(kWidth, kHeight, i);
    frame.confidence = Image1(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        frame.confidence(x, y) = static_cast<float>((x + y + i) % 5) / 4;
      }
    }
    frame.guides.previous_normal = Image3(kWidth, kHeight);
    frame.guides.previous_normal[2].Fill(1);  // at an angle to some surfaces
    CallerFrame caller(frame);
    caller.Run(denoiser.get());
    DenoisedFrame expected;
    ASSERT_TRUE(engine->Denoise(frame, &expected).ok());
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(caller.colour.Get(x, y, 1), expected.colour[1](x, y)) << x << " " << y;
      }
    }
  }
  // Another frame without it.
  CallerFrame last(MakeBusyFrame(kWidth, kHeight, 4));
  last.Give(denoiser.get());
  for (const char* input : {"confidence", "previous_normal"}) {
    ASSERT_EQ(stillray_denoiser_set_input(denoiser.get(), input, nullptr), STILLRAY_OK);
  }
  EXPECT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_OK);
}

TEST(SessionTest, ConfidenceOfAnotherSizeIsRefused) {
  const DenoiserHandle denoiser = MakeDenoiser();
  CallerFrame caller(MakeBusyFrame(kWidth, kHeight, 0));
  caller.Give(denoiser.get());
  float value = 1;
  const stillray_image small = stillray_interleaved(&value, STILLRAY_FORMAT_FLOAT, 1, 1, 1);
  ASSERT_EQ(stillray_denoiser_set_input(denoiser.get(), "confidence", &small), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(stillray_error_message(denoiser.get())).find("image 'confidence' is 1x1"),
            std::string::npos);
}

TEST(SessionTest, WarnsOfNormalsThatAreAllZero) {
  const DenoiserHandle denoiser = MakeDenoiser();
  EXPECT_STREQ(stillray_denoiser_warning(denoiser.get()), "");
  Frame frame = MakeBusyFrame(kWidth, kHeight, 0);
  frame.guides.normal = Image3(kWidth, kHeight);
  CallerFrame caller(frame);
  caller.Run(denoiser.get());
  EXPECT_NE(std::string(stillray_denoiser_warning(denoiser.get()))
                .find("image 'normal' is zero at every surface"),
            std::string::npos);
  Denoise(denoiser.get(), 1);
  EXPECT_STREQ(stillray_denoiser_warning(denoiser.get()), "");
  EXPECT_STREQ(stillray_denoiser_warning(nullptr), "");
}

struct Watch {
  int calls = 0;
  double last = -1;
  bool rising = true;
  std::thread::id thread;
  double cancel_at = 2;
};

int OnProgress(void* user, double fraction) {
  auto* watch = static_cast<Watch*>(user);
  ++watch->calls;
  watch->rising = watch->rising && fraction >= watch->last;
  watch->last = fraction;
  watch->thread = std::this_thread::get_id();
  return fraction >= watch->cancel_at ? 1 : 0;
}

TEST(SessionTest, ProgressRisesFromZeroToOneOnTheCallersThread) {
  const DenoiserHandle denoiser = MakeDenoiser();
  for (int i = 0; i < 3; ++i) {
    Watch watch;
    ASSERT_EQ(stillray_denoiser_set_progress(denoiser.get(), OnProgress, &watch), STILLRAY_OK);
    Denoise(denoiser.get(), i);
    EXPECT_GE(watch.calls, 3);
    EXPECT_TRUE(watch.rising);
    EXPECT_EQ(watch.last, 1.0);
    EXPECT_EQ(watch.thread, std::this_thread::get_id());
  }
}

TEST(SessionTest, ProgressDoesNotChangeTheBits) {
  const DenoiserHandle plain = MakeDenoiser();
  const DenoiserHandle watched = MakeDenoiser();
  Watch watch;
  ASSERT_EQ(stillray_denoiser_set_progress(watched.get(), OnProgress, &watch), STILLRAY_OK);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(Denoise(plain.get(), i), Denoise(watched.get(), i));
  }
}

TEST(SessionTest, CancelledBeforeFilteringChangesNothing) {
  const DenoiserHandle denoiser = MakeDenoiser();
  const DenoiserHandle undisturbed = MakeDenoiser();
  Denoise(denoiser.get(), 0);
  Denoise(undisturbed.get(), 0);
  Watch watch;
  watch.cancel_at = 0;
  ASSERT_EQ(stillray_denoiser_set_progress(denoiser.get(), OnProgress, &watch), STILLRAY_OK);
  CallerFrame caller = Busy(1);
  const std::vector<char> before = caller.colour.bytes;
  caller.Give(denoiser.get());
  EXPECT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_ERROR_CANCELLED);
  EXPECT_STREQ(stillray_error_message(denoiser.get()), "cancelled");
  EXPECT_EQ(watch.calls, 1);
  EXPECT_EQ(caller.colour.bytes, before);
  ASSERT_EQ(stillray_denoiser_set_progress(denoiser.get(), nullptr, nullptr), STILLRAY_OK);
  EXPECT_EQ(Denoise(denoiser.get(), 1), Denoise(undisturbed.get(), 1));
}

TEST(SessionTest, CancelledWhileFilteringWritesNothingAndRestarts) {
  constexpr int kLarge = 400;
  const DenoiserHandle denoiser = MakeDenoiser();
  Denoise(denoiser.get(), 0, kLarge, kLarge);
  Watch watch;
  watch.cancel_at = 0.005;
  ASSERT_EQ(stillray_denoiser_set_progress(denoiser.get(), OnProgress, &watch), STILLRAY_OK);
  CallerFrame caller = Busy(1, kLarge, kLarge);
  const std::vector<char> before = caller.colour.bytes;
  caller.Give(denoiser.get());
  EXPECT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_ERROR_CANCELLED);
  EXPECT_EQ(caller.colour.bytes, before);
  // Not called again after it requested a stop, nor for the end.
  EXPECT_EQ(watch.calls, 2);
  ASSERT_EQ(stillray_denoiser_set_progress(denoiser.get(), nullptr, nullptr), STILLRAY_OK);
  EXPECT_EQ(Denoise(denoiser.get(), 2, kLarge, kLarge), FirstFrame(2, kLarge, kLarge));
}

}  // namespace
}  // namespace stillray::test::session_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The C++ wrapper of the C API passes everything on.
#include "stillray/stillray.hpp"

#include <utility>

#include <gmock/gmock.h>

#include "capi/capi_frames.h"

namespace stillray::test::wrapper_test {
namespace {

void Give(CallerFrame* caller, api::Denoiser* denoiser) {
  for (const auto& [name, buffer] : caller->inputs) {
    ASSERT_TRUE(denoiser->SetInput(name.c_str(), buffer.image).ok());
  }
  ASSERT_TRUE(denoiser->SetJitter(caller->jitter_x, caller->jitter_y).ok());
  ASSERT_TRUE(denoiser->SetFocalPixels(caller->focal_pixels).ok());
  ASSERT_TRUE(denoiser->SetOutput("colour", caller->colour.image).ok());
}

TEST(WrapperTest, GivesTheBitsOfTheCApi) {
  api::Device device;
  ASSERT_TRUE(device.Create(2).ok());
  EXPECT_GE(device.threads(), 1);
  api::Denoiser first;
  ASSERT_TRUE(first.Create(device, "svgf").ok());
  api::Denoiser denoiser = std::move(first);
  const DenoiserHandle c = MakeDenoiser("svgf");
  double last = 0;
  ASSERT_TRUE(denoiser
                  .SetProgress([&](double fraction) {
                    last = fraction;
                    return true;
                  })
                  .ok());
  for (int i = 0; i < 2; ++i) {
    CallerFrame caller(MakeBusyFrame(30, 20, i));
    CallerFrame expected(MakeBusyFrame(30, 20, i));
    Give(&caller, &denoiser);
    ASSERT_TRUE(denoiser.Execute().ok());
    expected.Run(c.get());
    EXPECT_EQ(caller.colour.bytes, expected.colour.bytes);
  }
  EXPECT_EQ(last, 1.0);
  std::vector<uint8_t> history;
  ASSERT_TRUE(denoiser.SaveHistory(&history).ok());
  EXPECT_TRUE(denoiser.RestoreHistory(history).ok());
  history.pop_back();
  EXPECT_EQ(denoiser.RestoreHistory(history).code, STILLRAY_ERROR_BAD_DATA);
  EXPECT_THAT(denoiser.OutputNames(), testing::Contains("history_length"));
}

TEST(WrapperTest, PushesAndPulls) {
  api::Device device;
  ASSERT_TRUE(device.Create(2).ok());
  api::Denoiser denoiser;
  ASSERT_TRUE(denoiser.Create(device).ok());
  CallerFrame caller(MakeBusyFrame(30, 20, 0));
  Give(&caller, &denoiser);
  ASSERT_TRUE(denoiser.SetFrameIndex(7).ok());
  stillray_memory_need need = STILLRAY_MEMORY_NEED_INIT;
  ASSERT_TRUE(denoiser.GetMemoryNeed(&need).ok());
  EXPECT_GT(need.most, need.denoisers);
  ASSERT_TRUE(denoiser.Push().ok());
  bool pulled = true;
  ASSERT_TRUE(denoiser.Pull(&pulled).ok());
  EXPECT_FALSE(pulled);
  ASSERT_TRUE(denoiser.Finish().ok());
  stillray_waiting waiting = STILLRAY_WAITING_INIT;
  ASSERT_TRUE(denoiser.GetWaiting(&waiting).ok());
  EXPECT_EQ(waiting.index, 7);
  ASSERT_TRUE(denoiser.Pull(&pulled).ok());
  EXPECT_TRUE(pulled);
}

TEST(WrapperTest, ErrorsHaveMessages) {
  api::Device device;
  EXPECT_EQ(device.Create(-1).message, "threads is -1, expected 0 to 1024");
  api::Denoiser denoiser;
  EXPECT_EQ(denoiser.Create(device).message, "device is NULL");
  EXPECT_EQ(denoiser.Execute().message, "denoiser is NULL");
  ASSERT_TRUE(device.Create().ok());
  EXPECT_THAT(denoiser.Create(device, "nicest").message, testing::HasSubstr("'nicest'"));
  ASSERT_TRUE(denoiser.Create(device).ok());
  EXPECT_EQ(denoiser.Execute().message, "no input is set");
  EXPECT_THAT(denoiser.Set("alpha", "1").message, testing::HasSubstr("'alpha'"));
  std::string value;
  ASSERT_TRUE(denoiser.Get("alpha_min", &value).ok());
  EXPECT_EQ(value, "0.1");
}

TEST(WrapperTest, AFalseFromProgressCancels) {
  api::Device device;
  api::Denoiser denoiser;
  ASSERT_TRUE(device.Create().ok());
  ASSERT_TRUE(denoiser.Create(device).ok());
  CallerFrame caller(MakeBusyFrame(30, 20, 0));
  Give(&caller, &denoiser);
  ASSERT_TRUE(denoiser.SetProgress([](double) { return false; }).ok());
  EXPECT_EQ(denoiser.Execute().code, STILLRAY_ERROR_CANCELLED);
  ASSERT_TRUE(denoiser.SetProgress(nullptr).ok());
  EXPECT_TRUE(denoiser.Execute().ok());
}

}  // namespace
}  // namespace stillray::test::wrapper_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The C API with its denoisers on another device.
#include <thread>

#include "capi/capi_frames.h"
#include "core/guides.h"
#include "gpu/device_test.h"

namespace stillray::test::capi_device_test {
namespace {

constexpr int kWidth = 53;
constexpr int kHeight = 31;
constexpr int kFrames = 4;

struct DeviceRelease {
  void operator()(stillray_device* d) const { stillray_device_release(d); }
};
using DeviceHandle = std::unique_ptr<stillray_device, DeviceRelease>;

DenoiserHandle MakeDenoiserOn(stillray_device* device) {
  stillray_denoiser* denoiser = nullptr;
  EXPECT_EQ(stillray_denoiser_create(device, "default", &denoiser), STILLRAY_OK);
  return DenoiserHandle(denoiser);
}

CallerFrame Denoise(stillray_denoiser* denoiser, int index) {
  CallerFrame caller(MakeBusyFrame(kWidth, kHeight, index));
  caller.Run(denoiser);
  return caller;
}

class CapiDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    stillray_device* device = nullptr;
    if (stillray_device_create_on(STILLRAY_ABI_VERSION, 2, "vulkan", &device) != STILLRAY_OK) {
      GTEST_SKIP() << stillray_error_message(nullptr);
    }
    device_.reset(device);
  }
  DeviceHandle device_;
};

TEST_F(CapiDevice, GivesThePicturesOfTheCpu) {
  EXPECT_EQ(std::string(stillray_device_description(device_.get())).find("vulkan:"), 0u);
  const DenoiserHandle tested = MakeDenoiserOn(device_.get());
  const DenoiserHandle expected = MakeDenoiser("default");
  for (int i = 0; i < kFrames; ++i) {
    const CallerFrame got = Denoise(tested.get(), i);
    const CallerFrame want = Denoise(expected.get(), i);
    Image1 a(kWidth, kHeight);
    Image1 b(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        a(x, y) = got.colour.Get(x, y, 1);
        b(x, y) = want.colour.Get(x, y, 1);
      }
    }
    EXPECT_LT(Compare(a, b, kHalf.rms).rms, 0.03) << i;
  }
}

TEST_F(CapiDevice, SavedHistoryContinuesWithTheSameBits) {
  const DenoiserHandle whole = MakeDenoiserOn(device_.get());
  Denoise(whole.get(), 0);
  size_t size = 0;
  ASSERT_EQ(stillray_denoiser_save_history(whole.get(), nullptr, 0, &size), STILLRAY_OK);
  std::vector<uint8_t> saved(size);
  ASSERT_EQ(stillray_denoiser_save_history(whole.get(), saved.data(), size, &size), STILLRAY_OK);
  const DenoiserHandle later = MakeDenoiserOn(device_.get());
  ASSERT_EQ(stillray_denoiser_restore_history(later.get(), saved.data(), saved.size()),
            STILLRAY_OK);
  EXPECT_EQ(Denoise(later.get(), 1).colour.bytes, Denoise(whole.get(), 1).colour.bytes);
}

TEST_F(CapiDevice, ColourAloneIsFilteredAsWithFlatGuides) {
  Frame frame = MakeBusyFrame(kWidth, kHeight, 0);
  frame.signals.resize(1);
  frame.guides = Guides();
  frame.emission = frame.background = Image3();
  frame.samples = Image1();
  CallerFrame alone(frame);
  const DenoiserHandle tested = MakeDenoiserOn(device_.get());
  alone.Run(tested.get());
  frame.guides.depth = FlatDepth(kWidth, kHeight);
  frame.guides.normal = FlatNormal(kWidth, kHeight);
  frame.guides.albedo = WhiteAlbedo(kWidth, kHeight);
  frame.guides.motion = Image2(kWidth, kHeight);
  CallerFrame flat(frame);
  flat.Run(MakeDenoiserOn(device_.get()).get());
  EXPECT_EQ(alone.colour.bytes, flat.colour.bytes);
  EXPECT_EQ(stillray_denoiser_execute(tested.get()), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(stillray_error_message(tested.get()))
                .find("frame 1: image 'motion' is missing, expected 53x31: 'temporal'"),
            std::string::npos)
      << stillray_error_message(tested.get());
}

TEST_F(CapiDevice, WarnsOfNormalsThatAreAllZero) {
  const DenoiserHandle denoiser = MakeDenoiserOn(device_.get());
  Frame frame = MakeBusyFrame(kWidth, kHeight, 0);
  frame.guides.normal = Image3(kWidth, kHeight);
  CallerFrame caller(frame);
  caller.Run(denoiser.get());
  EXPECT_NE(std::string(stillray_denoiser_warning(denoiser.get())).find("'normal' is zero"),
            std::string::npos);
  Denoise(denoiser.get(), 1);
  EXPECT_STREQ(stillray_denoiser_warning(denoiser.get()), "");
}

TEST_F(CapiDevice, ThreadsMayShareADevice) {
  const DenoiserHandle alone = MakeDenoiserOn(device_.get());
  std::vector<std::vector<char>> expected;
  for (int i = 0; i < kFrames; ++i) {
    expected.push_back(Denoise(alone.get(), i).colour.bytes);
  }
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&] {
      const DenoiserHandle own = MakeDenoiserOn(device_.get());
      for (int i = 0; i < kFrames; ++i) {
        EXPECT_EQ(Denoise(own.get(), i).colour.bytes, expected[static_cast<size_t>(i)]);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
}

}  // namespace
}  // namespace stillray::test::capi_device_test

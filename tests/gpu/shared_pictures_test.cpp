// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finished pictures that stay on the device.
#include <vector>

#include "denoise/test_frames.h"
#include "gpu/device_test.h"
#include "gpu/imported_bytes.h"
#include "stillray/shared_picture.h"

namespace stillray::shared_pictures_test {
namespace {

using test::MakeBusyFrame;
using Shared = std::shared_ptr<const SharedPicture>;

constexpr Results kShared = {.colour = false, .display = false, .shared = true};

class SharedPictures : public test::DeviceTest {
 protected:
  void SetUp() override {
    test::DeviceTest::SetUp();
    if (device_ != nullptr && !device_->context().sharing.offered) {
      GTEST_SKIP() << "the device shares no memory";
    }
  }
  /// Red, green and blue, as DenoisedFrame::display has them.
  std::vector<uint8_t> Pixels(const SharedPicture& picture) {
    const auto other = *gpu::Device::Create(instance_, device_->info());
    const auto count = static_cast<size_t>(picture.width()) * static_cast<size_t>(picture.height());
    const std::vector<uint8_t> bytes =
        test::ImportedBytes(other.get(), *picture.Export(), picture.memory_bytes(), 4 * count);
    std::vector<uint8_t> pixels;
    for (size_t i = 0; i < count; ++i) {
      pixels.insert(pixels.end(), bytes.begin() + static_cast<ptrdiff_t>(4 * i),
                    bytes.begin() + static_cast<ptrdiff_t>(4 * i + 3));
      EXPECT_EQ(bytes[4 * i + 3], 255);
    }
    return pixels;
  }
  Denoiser MakeSharing() {
    Denoiser made = MakeDenoiser(PresetSettings("default").value(), DevicePrecision::kHalf);
    made.SetResults(kShared);
    return made;
  }
};

TEST_F(SharedPictures, HoldTheDisplayWhileTheyAreHeld) {
  std::vector<Shared> held;
  std::vector<std::vector<uint8_t>> expected;
  {
    Denoiser d = MakeSharing();
    Denoiser copied = MakeDenoiser(d.settings(), DevicePrecision::kHalf);
    copied.SetResults({.colour = false, .display = true});
    DenoisedFrame out;
    for (int i = 0; i < 3; ++i) {
      const Frame frame = MakeBusyFrame(37, 21, i);
      ASSERT_TRUE(d.Denoise(frame, &out).ok());
      ASSERT_NE(out.shared, nullptr);
      EXPECT_TRUE(out.display.empty() && out.colour.empty());
      EXPECT_EQ(out.shared->width(), 37);
      EXPECT_EQ(out.shared->height(), 21);
      EXPECT_EQ(out.shared->device_uuid(), device_->info().sharing.device);
      EXPECT_EQ(out.shared->driver_uuid(), device_->info().sharing.driver);
      held.push_back(out.shared);
      ASSERT_TRUE(copied.Denoise(frame, &out).ok());
      EXPECT_EQ(out.shared, nullptr);
      expected.push_back(out.display);
    }
  }
  for (size_t i = 0; i < held.size(); ++i) {
    EXPECT_EQ(Pixels(*held[i]), expected[i]) << "frame " << i << ", after its denoiser";
  }
}

TEST_F(SharedPictures, AreWrittenToAgainOnceNobodyHoldsThem) {
  Denoiser d = MakeSharing();
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(24, 16, 0), &out).ok());
  const SharedPicture* first = out.shared.get();
  const uint64_t bytes = d.device_memory().bytes;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(24, 16, 1), &out).ok());
  EXPECT_NE(out.shared.get(), first) << "the first one was still held";
  EXPECT_GT(d.device_memory().bytes, bytes);
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(24, 16, 2), &out).ok());
  EXPECT_EQ(out.shared.get(), first);
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(30, 16, 3), &out).ok());
  EXPECT_EQ(out.shared->width(), 30);
}

TEST_F(SharedPictures, TheDisplayStandsInWhereThereIsNone) {
  Denoiser d = MakeSharing();
  DenoisedFrame out;
  std::vector<Shared> held;
  for (int i = 0; i < 20 && (i == 0 || out.shared != nullptr); ++i) {
    ASSERT_TRUE(d.Denoise(MakeBusyFrame(12, 8, i), &out).ok());
    held.push_back(out.shared);
  }
  EXPECT_LT(held.size(), 20u) << "who never lets go does not fill the device";
  EXPECT_EQ(out.display.size(), 12u * 8 * 3);
  held.clear();
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(12, 8, 20), &out).ok());
  EXPECT_NE(out.shared, nullptr);
  EXPECT_TRUE(out.display.empty());
  d.SetResults({.colour = false, .display = true, .shared = true});
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(12, 8, 21), &out).ok());
  EXPECT_EQ(Pixels(*out.shared), out.display) << "or both, if both are wanted";
}

}  // namespace
}  // namespace stillray::shared_pictures_test

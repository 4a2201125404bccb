// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// EXR files that are cut, corrupt or made to do harm.
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "io/exr_foreign.h"
#include "io/test_files.h"
#include "stillray/aov.h"
#include "stillray/io.h"

namespace stillray::exr_damage_test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

std::string SmallExr(ExrCompression compression) {
  ExrImage image;
  image.width = 40;
  image.height = 40;
  Image3 colour(40, 40);
  for (int i = 0; i < 3 * 1600; ++i) {
    colour[i / 1600](i % 40, i / 40 % 40) =
        static_cast<float>(HashU32(static_cast<uint32_t>(i)) % 97);
  }
  image.Add("", PixelType::kHalf, colour);
  image.compression = compression;
  return EncodeExr(image).value();
}

/// \param stored  also keep the pixels as they are stored, which are decompressed in another way
Result<ExrImage> Decode(const std::string& bytes, bool stored = false) {
  StoredPixels pixels;
  return stored ? DecodeExr(Data(bytes), bytes.size(), "bad.exr", &pixels)
                : DecodeExr(Data(bytes), bytes.size(), "bad.exr");
}

/// Replaces the value of an attribute of the header, whose size stays.
std::string WithAttribute(std::string bytes, const std::string& name, const std::string& type,
                          const std::vector<int32_t>& value) {
  const std::string key = name + '\0' + type + '\0';
  const size_t at = bytes.find(key);
  EXPECT_NE(at, std::string::npos) << name;
  std::memcpy(bytes.data() + at + key.size() + 4, value.data(), value.size() * sizeof(int32_t));
  return bytes;
}

TEST(ExrDamage, EveryCutIsReported) {
  for (const ExrCompression compression :
       {ExrCompression::kNone, ExrCompression::kZip, ExrCompression::kPiz}) {
    const std::string whole = SmallExr(compression);
    ASSERT_TRUE(Decode(whole).ok());
    for (size_t size = 0; size < whole.size(); size += 1 + size / 40) {
      for (const bool stored : {false, true}) {
        const Result<ExrImage> image = Decode(whole.substr(0, size), stored);
        ASSERT_FALSE(image.ok()) << size << " of " << whole.size() << " bytes";
        ASSERT_EQ(image.status().code(), StatusCode::kBadData) << image.status().message();
        ASSERT_THAT(image.status().message(), HasSubstr("bad.exr"));
        ASSERT_EQ(image.status().message().find('\n'), std::string::npos);
      }
    }
  }
}

TEST(ExrDamage, FlippedBytesNeverCrash) {
  for (const ExrCompression compression :
       {ExrCompression::kNone, ExrCompression::kZip, ExrCompression::kPiz, ExrCompression::kDwaa}) {
    const std::string whole = SmallExr(compression);
    int refused = 0;
    int refused_stored = 0;
    for (uint32_t i = 0; i < 150; ++i) {
      std::string bytes = whole;
      // Half of the damage goes into the header, where it does most.
      const size_t range = i % 2 == 0 ? std::min<size_t>(bytes.size(), 350) : bytes.size();
      bytes[HashU32(i) % range] ^= static_cast<char>(1u << (HashU32(~i) % 8));
      refused += !Decode(bytes).ok();
      refused_stored += !Decode(bytes, true).ok();
    }
    EXPECT_GT(refused, 10);
    EXPECT_GE(refused_stored, refused);
  }
}

TEST(ExrDamage, HugeWindowsAreRefusedBeforeMemoryIsTaken) {
  const std::string whole = SmallExr(ExrCompression::kZip);
  const auto with_windows = [&](int32_t x, int32_t y) {
    const std::vector<int32_t> window = {0, 0, x, y};
    return Decode(WithAttribute(WithAttribute(whole, "dataWindow", "box2i", window),
                                "displayWindow", "box2i", window));
  };
  EXPECT_EQ(with_windows(40000, 39).status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(with_windows(40000, 39).status().message(), HasSubstr("40001 x 40"));
  EXPECT_FALSE(with_windows(39, 99999).ok());
  EXPECT_THAT(with_windows(32767, 32767).status().code(),
              AnyOf(StatusCode::kBadData, StatusCode::kOutOfMemory));
  EXPECT_FALSE(with_windows(0x7ffffffe, 0x7ffffffe).ok());
  EXPECT_FALSE(with_windows(-5, -5).ok());
}

TEST(ExrDamage, ClaimsBeyondTheBytesAreRefused) {
  const std::string whole = SmallExr(ExrCompression::kNone);
  // Wider only: the table of lines stays right, and nothing but the size is wrong.
  const std::vector<int32_t> window = {0, 0, 32767, 39};
  const Result<ExrImage> image = Decode(WithAttribute(
      WithAttribute(whole, "dataWindow", "box2i", window), "displayWindow", "box2i", window));
  EXPECT_EQ(image.status().code(), StatusCode::kBadData);
  EXPECT_THAT(image.status().message(), HasSubstr("cannot hold"));
}

TEST(ExrDamage, DisplayWindowAloneCannotTakeAllMemory) {
  // Valid files may show a small part of a large canvas, so the bytes do not bound this one.
  const auto with_canvas = [](int32_t side) {
    return Decode(WithAttribute(SmallExr(ExrCompression::kZip), "displayWindow", "box2i",
                                {0, 0, side - 1, side - 1}));
  };
  EXPECT_EQ(with_canvas(32768).status().code(), StatusCode::kOutOfMemory);
  EXPECT_EQ(with_canvas(16384).status().code(), StatusCode::kBadData);
  EXPECT_THAT(with_canvas(16384).status().message(), HasSubstr("16384 x 16384"));
  EXPECT_TRUE(with_canvas(1024).ok());
}

TEST(ExrDamage, HugeTilesAreRefused) {
  const TempFolder folder;
  const Imath::Box2i window(Imath::V2i(0, 0), Imath::V2i(31, 31));
  WriteForeignTiles(folder.Path("a.exr"), ForeignHeader(window, window, {"Y"}), 16, Imf::ONE_LEVEL);
  const std::string bytes =
      WithAttribute(FileBytes(folder.Path("a.exr")), "tiles", "tiledesc", {100000, 100000});
  EXPECT_EQ(Decode(bytes).status().code(), StatusCode::kBadData);
}

TEST(ExrDamage, WhatIsNoExrIsSaidToBeNone) {
  EXPECT_THAT(Decode("").status().message(), HasSubstr("not an EXR"));
  EXPECT_THAT(Decode("hello, world").status().message(), HasSubstr("not an EXR"));
  EXPECT_EQ(Decode(std::string("\x76\x2f\x31\x01", 4)).status().code(), StatusCode::kBadData);
  EXPECT_EQ(ReadExr("/no/such.exr").status().code(), StatusCode::kNotFound);
}

}  // namespace
}  // namespace stillray::exr_damage_test

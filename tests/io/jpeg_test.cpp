// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "io/test_files.h"
#include "stillray/io.h"

namespace stillray::jpeg_test {
namespace {

using ::testing::HasSubstr;

void Append(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data),
                                             static_cast<size_t>(size));
}

/// A picture of one colour, which JPEG keeps to about one code.
std::string FlatJpeg(int width, int height, uint8_t r, uint8_t g, uint8_t b) {
  std::vector<uint8_t> pixels;
  for (int i = 0; i < width * height; ++i) {
    pixels.insert(pixels.end(), {r, g, b});
  }
  std::string jpeg;
  EXPECT_NE(stbi_write_jpg_to_func(Append, &jpeg, width, height, 3, pixels.data(), 95), 0);
  return jpeg;
}

std::string NoiseJpeg() {
  std::vector<uint8_t> pixels(64 * 64 * 3);
  for (size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = static_cast<uint8_t>(HashU32(static_cast<uint32_t>(i)));
  }
  std::string jpeg;
  stbi_write_jpg_to_func(Append, &jpeg, 64, 64, 3, pixels.data(), 90);
  return jpeg;
}

Result<Image3> Decode(const std::string& bytes) {
  return DecodeImage(Data(bytes), bytes.size(), "test.jpg");
}

TEST(Jpeg, DecodesToLinearRgb) {
  const std::string jpeg = FlatJpeg(37, 21, 200, 100, 50);
  bool linear = true;
  const Result<Image3> image = DecodeImage(Data(jpeg), jpeg.size(), "test.jpg", &linear);
  ASSERT_TRUE(image.ok()) << image.status().message();
  EXPECT_FALSE(linear);
  ASSERT_EQ(image->width(), 37);
  ASSERT_EQ(image->height(), 21);
  const double codes[] = {200, 100, 50};
  for (int c = 0; c < 3; ++c) {
    const auto decode = [&](double code) { return std::pow((code / 255 + 0.055) / 1.055, 2.4); };
    for (int y = 0; y < 21; ++y) {
      for (int x = 0; x < 37; ++x) {
        EXPECT_GE((*image)[c](x, y), decode(codes[c] - 2));
        EXPECT_LE((*image)[c](x, y), decode(codes[c] + 2));
      }
    }
  }
}

TEST(Jpeg, EveryCutIsReported) {
  const std::string whole = NoiseJpeg();
  ASSERT_TRUE(Decode(whole).ok());
  for (size_t size = 3; size < whole.size(); size += 1 + size / 30) {
    const Result<Image3> image = Decode(whole.substr(0, size));
    ASSERT_FALSE(image.ok()) << size << " of " << whole.size() << " bytes";
    ASSERT_EQ(image.status().code(), StatusCode::kBadData);
    ASSERT_THAT(image.status().message(), HasSubstr("test.jpg"));
  }
}

TEST(Jpeg, EndMarkerOfAThumbnailIsNotTheEnd) {
  const std::string whole = NoiseJpeg();
  // An application segment with an end marker inside, right after the start marker.
  const std::string segment("\xff\xe1\x00\x06\xff\xd9xx", 8);
  const std::string with_segment = whole.substr(0, 2) + segment + whole.substr(2);
  EXPECT_TRUE(Decode(with_segment).ok());
  EXPECT_FALSE(Decode(with_segment.substr(0, with_segment.size() - 2)).ok());
}

TEST(Jpeg, FlippedBytesNeverCrash) {
  const std::string whole = NoiseJpeg();
  int refused = 0;
  for (uint32_t i = 0; i < 200; ++i) {
    std::string bytes = whole;
    bytes[3 + HashU32(i) % 600] ^= static_cast<char>(1u << (i % 8));
    refused += !Decode(bytes).ok();
  }
  EXPECT_GT(refused, 20);
}

TEST(Jpeg, SizeBeyondTheBytesIsRefused) {
  std::string jpeg = FlatJpeg(16, 16, 1, 2, 3);
  const size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  for (size_t i = 5; i < 9; ++i) {
    jpeg[frame + i] = '\x40';  // 16448 x 16448
  }
  const Result<Image3> image = Decode(jpeg);
  EXPECT_EQ(image.status().code(), StatusCode::kBadData);
  EXPECT_THAT(image.status().message(), HasSubstr("cannot hold"));
}

// Stripes of one pixel keep their colours only if those have the full resolution.
TEST(Jpeg, WritesColoursInFullResolution) {
  Rgb8Image image{33, 20, {}};
  for (int i = 0; i < 33 * 20; ++i) {
    const bool even = i % 33 % 2 == 0;
    image.pixels.insert(image.pixels.end(), {static_cast<uint8_t>(even ? 150 : 90), 100,
                                             static_cast<uint8_t>(even ? 90 : 150)});
  }
  const std::string jpeg = EncodeJpeg(image).value();
  int w = 0;
  int h = 0;
  int components = 0;
  stbi_uc* pixels =
      stbi_load_from_memory(Data(jpeg), static_cast<int>(jpeg.size()), &w, &h, &components, 3);
  ASSERT_NE(pixels, nullptr);
  ASSERT_EQ(w, 33);
  ASSERT_EQ(h, 20);
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    ASSERT_NEAR(pixels[i], image.pixels[i], 12) << i;
  }
  stbi_image_free(pixels);
}

TEST(Jpeg, RefusesWhatCannotBeWritten) {
  EXPECT_EQ(EncodeJpeg(Rgb8Image{}).status().code(), StatusCode::kInvalidArgument);
  const Rgb8Image wrong{4, 4, std::vector<uint8_t>(47)};
  EXPECT_THAT(EncodeJpeg(wrong).status().message(), HasSubstr("48 bytes, not 47"));
  const Rgb8Image wide{65536, 1, std::vector<uint8_t>(65536 * 3)};
  EXPECT_THAT(EncodeJpeg(wide).status().message(), HasSubstr("1 to 65535 a side"));
  EXPECT_THAT(WriteJpeg("x/y.jpg", wrong).message(), HasSubstr("x/y.jpg"));
  const Rgb8Image right{4, 4, std::vector<uint8_t>(48)};
  EXPECT_EQ(WriteJpeg("/dev/full", right).code(), StatusCode::kIo);
}

}  // namespace
}  // namespace stillray::jpeg_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <spng.h>
#include <stb/stb_image.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "io/test_files.h"
#include "stillray/io.h"

namespace stillray::png_test {
namespace {

using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Rgb8Image Noise(int width, int height) {
  Rgb8Image image{width, height, {}};
  image.pixels.resize(static_cast<size_t>(width) * static_cast<size_t>(height) * 3);
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    image.pixels[i] = static_cast<uint8_t>(HashU32(static_cast<uint32_t>(i)));
  }
  return image;
}

/// A PNG of any kind, made by libspng.
std::string MakePng(uint32_t width, uint32_t height, uint8_t colour_type, uint8_t bit_depth,
                    const void* pixels, size_t bytes, bool interlaced = false) {
  spng_ctx* context = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
  spng_ihdr header{};
  header.width = width;
  header.height = height;
  header.color_type = colour_type;
  header.bit_depth = bit_depth;
  header.interlace_method = interlaced ? SPNG_INTERLACE_ADAM7 : SPNG_INTERLACE_NONE;
  spng_set_ihdr(context, &header);
  if (colour_type == SPNG_COLOR_TYPE_INDEXED) {
    spng_plte palette{};
    palette.n_entries = 2;
    palette.entries[0] = {10, 20, 30, 255};
    palette.entries[1] = {200, 100, 50, 255};
    spng_set_plte(context, &palette);
  }
  EXPECT_EQ(spng_encode_image(context, pixels, bytes, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
  size_t size = 0;
  int error = 0;
  void* buffer = spng_get_png_buffer(context, &size, &error);
  std::string png(static_cast<const char*>(buffer), size);
  std::free(buffer);
  spng_ctx_free(context);
  return png;
}

double SrgbDecode(double v) {
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

Result<Image3> Decode(const std::string& bytes) {
  return DecodeImage(Data(bytes), bytes.size(), "test.png");
}
Result<Rgb8Image> Decode8(const std::string& bytes) {
  return DecodePng8(Data(bytes), bytes.size(), "test.png");
}

TEST(Png, AnotherDecoderReadsWhatWasWritten) {
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(17, 5), std::pair(64, 64)}) {
    const Rgb8Image image = Noise(width, height);
    const Result<std::string> png = EncodePng(image);
    ASSERT_TRUE(png.ok()) << png.status().message();
    int w = 0;
    int h = 0;
    int components = 0;
    stbi_uc* pixels =
        stbi_load_from_memory(Data(*png), static_cast<int>(png->size()), &w, &h, &components, 0);
    ASSERT_NE(pixels, nullptr);
    EXPECT_EQ(w, width);
    EXPECT_EQ(h, height);
    EXPECT_EQ(components, 3);
    EXPECT_TRUE(std::equal(image.pixels.begin(), image.pixels.end(), pixels));
    stbi_image_free(pixels);
  }
}

// Rows of several tasks, and every case of the predictor: flat, gradients along and across rows.
TEST(Png, SmoothPicturesAreSmallAndExact) {
  Rgb8Image image{200, 150, {}};
  for (int y = 0; y < 150; ++y) {
    for (int x = 0; x < 200; ++x) {
      image.pixels.insert(image.pixels.end(),
                          {static_cast<uint8_t>(x), static_cast<uint8_t>(255 - y),
                           static_cast<uint8_t>(x < 100 ? (x * y) >> 6 : 7)});
    }
  }
  const std::string png = EncodePng(image).value();
  EXPECT_LT(png.size(), image.pixels.size() / 20);
  EXPECT_EQ(Decode8(png).value().pixels, image.pixels);
}

TEST(Png, FileGivesBackWhatWasWritten) {
  const TempFolder folder;
  const Rgb8Image image = Noise(31, 12);
  const Status status = WritePng(folder.Path("a.png"), image);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_THAT(folder.List(), ElementsAre("a.png"));
  const Result<Rgb8Image> read = ReadPng8(folder.Path("a.png"));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->width, 31);
  EXPECT_EQ(read->height, 12);
  EXPECT_EQ(read->pixels, image.pixels);
}

TEST(Png, IsMarkedAsSrgb) {
  EXPECT_THAT(EncodePng(Noise(2, 2)).value(), HasSubstr("sRGB"));
}

TEST(Png, ReadImageDecodesSrgb) {
  Rgb8Image image{256, 1, {}};
  for (int i = 0; i < 256; ++i) {
    const auto code = static_cast<uint8_t>(i);
    image.pixels.insert(image.pixels.end(), {code, static_cast<uint8_t>(255 - i), 0});
  }
  const std::string png = EncodePng(image).value();
  bool linear = true;
  const Result<Image3> read = DecodeImage(Data(png), png.size(), "a.png", &linear);
  ASSERT_TRUE(read.ok());
  EXPECT_FALSE(linear);
  for (int i = 0; i < 256; ++i) {
    const auto expected = static_cast<float>(SrgbDecode(i / 255.0));
    EXPECT_FLOAT_EQ((*read)[0](i, 0), expected);
    EXPECT_FLOAT_EQ((*read)[1](255 - i, 0), expected);
    EXPECT_EQ((*read)[2](i, 0), 0.0f);
  }
  EXPECT_EQ((*read)[0](255, 0), 1.0f);
}

TEST(Png, SixteenBitsKeepTheirPrecision) {
  const std::vector<uint16_t> pixels = {0,    1,     257,   30000, 30001, 65535,  // row 0
                                        1000, 20000, 40000, 12,    34567, 54321};
  for (const bool interlaced : {false, true}) {
    const std::string png =
        MakePng(2, 2, SPNG_COLOR_TYPE_TRUECOLOR, 16, pixels.data(), pixels.size() * 2, interlaced);
    const Result<Image3> read = Decode(png);
    ASSERT_TRUE(read.ok()) << read.status().message();
    for (int i = 0; i < 12; ++i) {
      EXPECT_FLOAT_EQ((*read)[i % 3](i / 3 % 2, i / 6),
                      static_cast<float>(SrgbDecode(pixels[static_cast<size_t>(i)] / 65535.0)));
    }
    const Result<Rgb8Image> read8 = Decode8(png);
    ASSERT_TRUE(read8.ok()) << read8.status().message();
    for (size_t i = 0; i < 12; ++i) {
      EXPECT_EQ(read8->pixels[i], pixels[i] >> 8);
    }
  }
}

TEST(Png, OtherKindsBecomeRgb) {
  const uint8_t grey[] = {0, 128, 255, 7};
  Result<Rgb8Image> read = Decode8(MakePng(2, 2, SPNG_COLOR_TYPE_GRAYSCALE, 8, grey, 4));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_THAT(read->pixels, ElementsAre(0, 0, 0, 128, 128, 128, 255, 255, 255, 7, 7, 7));

  const uint8_t bits[] = {0x80, 0x40};  // pixels 1 0 / 0 1
  read = Decode8(MakePng(2, 2, SPNG_COLOR_TYPE_GRAYSCALE, 1, bits, 2));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_THAT(read->pixels, ElementsAre(255, 255, 255, 0, 0, 0, 0, 0, 0, 255, 255, 255));

  read = Decode8(MakePng(2, 2, SPNG_COLOR_TYPE_INDEXED, 1, bits, 2));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_THAT(read->pixels, ElementsAre(200, 100, 50, 10, 20, 30, 10, 20, 30, 200, 100, 50));

  const uint8_t rgba[] = {1, 2, 3, 0, 4, 5, 6, 255};
  read = Decode8(MakePng(2, 1, SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, 8, rgba, 8));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_THAT(read->pixels, ElementsAre(1, 2, 3, 4, 5, 6));

  const uint16_t grey_alpha[] = {65535, 0, 32896, 65535};
  const Result<Image3> linear =
      Decode(MakePng(2, 1, SPNG_COLOR_TYPE_GRAYSCALE_ALPHA, 16, grey_alpha, 8));
  ASSERT_TRUE(linear.ok()) << linear.status().message();
  for (int c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ((*linear)[c](0, 0), 1.0f);
    EXPECT_FLOAT_EQ((*linear)[c](1, 0), static_cast<float>(SrgbDecode(32896 / 65535.0)));
  }
}

TEST(Png, EveryCutIsReported) {
  const std::string whole = EncodePng(Noise(20, 20)).value();
  // The last 12 bytes are the end chunk, which adds nothing to the picture.
  for (size_t size = 0; size < whole.size() - 12; size += 1 + size / 50) {
    const Result<Rgb8Image> read = Decode8(whole.substr(0, size));
    ASSERT_FALSE(read.ok()) << size << " of " << whole.size() << " bytes";
    ASSERT_EQ(read.status().code(), StatusCode::kBadData);
    ASSERT_THAT(read.status().message(), HasSubstr("test.png"));
    ASSERT_FALSE(Decode(whole.substr(0, size)).ok());
  }
}

TEST(Png, FlippedBytesAreFoundByTheirChecksum) {
  const std::string whole = EncodePng(Noise(20, 20)).value();
  for (size_t i = 0; i < whole.size() - 12; i += 7) {
    std::string bytes = whole;
    bytes[i] ^= 0x10;
    const Result<Rgb8Image> read = Decode8(bytes);
    if (read.ok()) {  // only the sRGB chunk, which has no effect, may change
      EXPECT_EQ(read->pixels, Noise(20, 20).pixels) << "byte " << i;
    }
  }
}

uint32_t Crc32(std::string_view bytes) {
  uint32_t crc = 0xffffffffu;
  for (const char c : bytes) {
    crc ^= static_cast<uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) {
      crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
    }
  }
  return ~crc;
}

/// The PNG with another size in its header, checksum included.
std::string WithSize(std::string png, uint32_t width, uint32_t height) {
  const auto put = [&](size_t at, uint32_t value) {
    for (size_t i = 0; i < 4; ++i) {
      png[at + i] = static_cast<char>(value >> (24 - 8 * i));
    }
  };
  put(16, width);
  put(20, height);
  put(29, Crc32(std::string_view(png).substr(12, 17)));
  return png;
}

TEST(Png, HugeSizesAreRefusedBeforeMemoryIsTaken) {
  const std::string png = EncodePng(Noise(4, 4)).value();
  ASSERT_TRUE(Decode8(WithSize(png, 4, 4)).ok());  // the checksum above is right
  EXPECT_EQ(Decode8(WithSize(png, 40000, 4)).status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(Decode8(WithSize(png, 40000, 4)).status().message(), HasSubstr("40000 x 4"));
  EXPECT_EQ(Decode8(WithSize(png, 32768, 32768)).status().code(), StatusCode::kBadData);
  EXPECT_THAT(Decode(WithSize(png, 32768, 32768)).status().code(),
              AnyOf(StatusCode::kBadData, StatusCode::kOutOfMemory));
  EXPECT_EQ(Decode8(WithSize(png, 0, 4)).status().code(), StatusCode::kBadData);
}

TEST(Png, RefusesWhatCannotBeWritten) {
  EXPECT_EQ(EncodePng(Rgb8Image{}).status().code(), StatusCode::kInvalidArgument);
  const Rgb8Image wrong{4, 4, std::vector<uint8_t>(47)};
  EXPECT_THAT(EncodePng(wrong).status().message(), HasSubstr("48 bytes, not 47"));
  EXPECT_THAT(WritePng("x/y.png", wrong).message(), HasSubstr("x/y.png"));
  EXPECT_EQ(WritePng("/dev/full", Noise(4, 4)).code(), StatusCode::kIo);
}

TEST(Png, WhatIsNoPngIsRefused) {
  EXPECT_EQ(Decode8("").status().code(), StatusCode::kBadData);
  EXPECT_EQ(Decode8("hello").status().code(), StatusCode::kBadData);
  EXPECT_EQ(ReadPng8("/no/such.png").status().code(), StatusCode::kNotFound);
}

}  // namespace
}  // namespace stillray::png_test

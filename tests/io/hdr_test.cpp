// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "io/test_files.h"
#include "stillray/io.h"

namespace stillray::hdr_test {
namespace {

using ::testing::HasSubstr;

constexpr const char* kHeader = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";

Result<Image3> Decode(const std::string& bytes, bool* linear = nullptr) {
  return DecodeImage(Data(bytes), bytes.size(), "test.hdr", linear);
}

std::string Pixel(int r, int g, int b, int e) {
  return {static_cast<char>(r), static_cast<char>(g), static_cast<char>(b), static_cast<char>(e)};
}

TEST(Hdr, FlatPixelsByHand) {
  bool linear = false;
  // 128 * 2^(129 - 136) = 1; 64 -> 0.5; 255 * 2^(137 - 136) = 510; exponent 0 is black.
  const Result<Image3> image =
      Decode(std::string(kHeader) + "-Y 2 +X 2\n" + Pixel(128, 64, 32, 129) +
                 Pixel(255, 0, 1, 137) + Pixel(9, 9, 9, 0) + Pixel(128, 128, 128, 128),
             &linear);
  ASSERT_TRUE(image.ok()) << image.status().message();
  EXPECT_TRUE(linear);
  EXPECT_EQ((*image)[0](0, 0), 1.0f);
  EXPECT_EQ((*image)[1](0, 0), 0.5f);
  EXPECT_EQ((*image)[2](0, 0), 0.25f);
  EXPECT_EQ((*image)[0](1, 0), 510.0f);
  EXPECT_EQ((*image)[1](1, 0), 0.0f);
  EXPECT_EQ((*image)[2](1, 0), 2.0f);
  EXPECT_EQ((*image)[0](0, 1), 0.0f);
  EXPECT_EQ((*image)[2](1, 1), 0.5f);
}

TEST(Hdr, OldRunsRepeatThePixelBefore) {
  const Result<Image3> image =
      Decode(std::string(kHeader) + "-Y 1 +X 264\n" + Pixel(128, 0, 0, 129) + Pixel(1, 1, 1, 6) +
             Pixel(1, 1, 1, 1) + Pixel(0, 128, 0, 129));
  ASSERT_TRUE(image.ok()) << image.status().message();
  for (int x = 0; x < 263; ++x) {
    ASSERT_EQ((*image)[0](x, 0), 1.0f) << x;
  }
  EXPECT_EQ((*image)[0](263, 0), 0.0f);
  EXPECT_EQ((*image)[1](263, 0), 1.0f);
}

TEST(Hdr, NewRunsHoldComponentsApart) {
  std::string row = {2, 2, 0, 8};
  row += std::string("\x88\x80", 2);              // red: 8 times 128
  row += std::string("\x08\0\1\2\3\4\5\6\7", 9);  // green: 0..7
  row += std::string("\x83\0", 2);                // blue: 3 times 0,
  row += std::string("\x85\x40", 2);              // 5 times 64
  row += std::string("\x88\x81", 2);              // exponent: 129
  const Result<Image3> image = Decode(std::string(kHeader) + "-Y 1 +X 8\n" + row);
  ASSERT_TRUE(image.ok()) << image.status().message();
  for (int x = 0; x < 8; ++x) {
    EXPECT_EQ((*image)[0](x, 0), 1.0f);
    EXPECT_EQ((*image)[1](x, 0), static_cast<float>(x) / 128.0f);
    EXPECT_EQ((*image)[2](x, 0), x < 3 ? 0.0f : 0.5f);
  }
}

TEST(Hdr, OrderOfRowsAndPixels) {
  const std::string pixels =
      Pixel(1, 0, 0, 136) + Pixel(2, 0, 0, 136) + Pixel(3, 0, 0, 136) + Pixel(4, 0, 0, 136);
  const auto first = [&](const std::string& size) {
    const Result<Image3> image = Decode(std::string(kHeader) + size + "\n" + pixels);
    EXPECT_TRUE(image.ok()) << image.status().message();
    return (*image)[0](0, 0);
  };
  EXPECT_EQ(first("-Y 2 +X 2"), 1.0f);
  EXPECT_EQ(first("+Y 2 +X 2"), 3.0f);
  EXPECT_EQ(first("-Y 2 -X 2"), 2.0f);
  EXPECT_EQ(first("+Y 2 -X 2"), 4.0f);
  const Status turned = Decode(std::string(kHeader) + "+X 2 -Y 2\n" + pixels).status();
  EXPECT_EQ(turned.code(), StatusCode::kUnsupported);
}

TEST(Hdr, ExposureIsTakenBackOut) {
  const Result<Image3> image =
      Decode("#?RADIANCE\nEXPOSURE=2\nEXPOSURE= 4.0\n\n-Y 1 +X 1\n" + Pixel(128, 0, 0, 129));
  ASSERT_TRUE(image.ok()) << image.status().message();
  EXPECT_EQ((*image)[0](0, 0), 0.125f);
  EXPECT_EQ(Decode("#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\nabcd").status().code(),
            StatusCode::kBadData);
  EXPECT_EQ(Decode("#?RADIANCE\nEXPOSURE=x\n\n-Y 1 +X 1\nabcd").status().code(),
            StatusCode::kBadData);
}

void Append(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data),
                                             static_cast<size_t>(size));
}

std::string ForeignHdr(int width, int height, std::vector<float>* values) {
  for (int i = 0; i < width * height * 3; ++i) {
    // Runs and literals both occur.
    const bool flat = i / 300 % 2 == 0;
    values->push_back(flat ? 1.5f : UniformFloat(HashU32(static_cast<uint32_t>(i))) * 1000.0f);
  }
  std::string hdr;
  EXPECT_NE(stbi_write_hdr_to_func(Append, &hdr, width, height, 3, values->data()), 0);
  return hdr;
}

TEST(Hdr, ReadsWhatAnotherProgramWrote) {
  for (const int width : {5, 300}) {
    std::vector<float> values;
    const std::string hdr = ForeignHdr(width, 7, &values);
    const Result<Image3> image = Decode(hdr);
    ASSERT_TRUE(image.ok()) << image.status().message();
    for (int i = 0; i < width * 7 * 3; ++i) {
      const int pixel = i / 3;
      float largest = 0;
      for (int c = 0; c < 3; ++c) {
        largest = std::max(largest, values[static_cast<size_t>(pixel * 3 + c)]);
      }
      // A mantissa has 8 bits, the largest component at least 128.
      ASSERT_NEAR((*image)[i % 3](pixel % width, pixel / width), values[static_cast<size_t>(i)],
                  largest / 127);
    }
  }
}

TEST(Hdr, EveryCutIsReported) {
  std::vector<float> values;
  const std::string whole = ForeignHdr(100, 9, &values);
  for (size_t size = 2; size < whole.size(); size += 1 + size / 60) {
    const Result<Image3> image = Decode(whole.substr(0, size));
    ASSERT_FALSE(image.ok()) << size << " of " << whole.size() << " bytes";
    ASSERT_EQ(image.status().code(), StatusCode::kBadData);
    ASSERT_THAT(image.status().message(), HasSubstr("test.hdr"));
  }
}

TEST(Hdr, DamageIsNamed) {
  const auto message = [](const std::string& bytes) { return Decode(bytes).status().message(); };
  const std::string header = kHeader;
  EXPECT_THAT(message("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd"), HasSubstr("xyze"));
  EXPECT_THAT(message(header + "-Y 1 +Z 1\nabcd"), HasSubstr("-Y 1 +Z 1"));
  EXPECT_THAT(message(header + "-Y one +X 1\nabcd"), HasSubstr("-Y one"));
  EXPECT_THAT(message(header + "-Y 0 +X 1\nabcd"), HasSubstr("1 x 0"));
  EXPECT_THAT(message(header + "-Y 99999 +X 1\nabcd"), HasSubstr("1 x 99999"));
  EXPECT_THAT(message(header + "-Y 30000 +X 30000\nabcd"),
              ::testing::AnyOf(HasSubstr("cannot hold"), HasSubstr("MiB")));
  EXPECT_THAT(message(header + "-Y 1 +X 8\n" + Pixel(2, 2, 0, 9) + "\x88\x01"),
              HasSubstr("another width"));
  EXPECT_THAT(message(header + "-Y 1 +X 8\n" + Pixel(2, 2, 0, 8) + "\x89\x01"),
              HasSubstr("longer than its row"));
  EXPECT_THAT(message(header + "-Y 1 +X 2\n" + Pixel(1, 1, 1, 1)), HasSubstr("nothing to repeat"));
}

Image3 HdrPicture(int width, int height) {
  Image3 image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      // Long runs in the left half, noise in the right one.
      const auto i = static_cast<uint32_t>(y * width + x);
      for (int c = 0; c < 3; ++c) {
        const float noise = static_cast<float>(HashU32(i + 1000u * static_cast<uint32_t>(c)));
        image[c](x, y) = x < width / 2 ? 0.25f * static_cast<float>(c)
                                       : std::exp2(noise / 4294967296.0f * 40 - 20);
      }
    }
  }
  return image;
}

// 1.5 = 192/256 * 2^1, 0.75 = 96/256 * 2^1: the largest channel determines the exponent 1 + 128.
TEST(Hdr, WritesPixelsByHand) {
  Image3 image(2, 1);
  image[0](0, 0) = 1.5f;
  image[1](0, 0) = 0.75f;
  image[2](0, 0) = -3.0f;
  const std::string file = EncodeHdr(image).value();
  EXPECT_EQ(file,
            std::string(kHeader) + "-Y 1 +X 2\n" + Pixel(192, 96, 0, 129) + Pixel(0, 0, 0, 0));
}

TEST(Hdr, WritesRunsByHand) {
  Image3 image(8, 1);
  for (int x = 0; x < 8; ++x) {
    image[0](x, 0) = x < 6 ? 1.0f : 1.5f;
    image[1](x, 0) = 0.5f;
  }
  // Red: six times 128, then 192 twice as literals; green and blue: one run; exponent: one run.
  const std::string expected = Pixel(2, 2, 0, 8) + std::string("\x86\x80\x02\xc0\xc0", 5) +
                               std::string("\x88\x40\x88\x00\x88\x81", 6);
  EXPECT_EQ(EncodeHdr(image).value(), std::string(kHeader) + "-Y 1 +X 8\n" + expected);
}

TEST(Hdr, AnotherDecoderReadsWhatWasWritten) {
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(7, 3), std::pair(300, 9)}) {
    const Image3 image = HdrPicture(width, height);
    const std::string file = EncodeHdr(image).value();
    int w = 0;
    int h = 0;
    int components = 0;
    float* pixels =
        stbi_loadf_from_memory(Data(file), static_cast<int>(file.size()), &w, &h, &components, 3);
    ASSERT_NE(pixels, nullptr);
    ASSERT_EQ(w, width);
    ASSERT_EQ(h, height);
    const Image3 own = Decode(file).value();
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const float largest = std::max({image[0](x, y), image[1](x, y), image[2](x, y)});
        for (int c = 0; c < 3; ++c) {
          // Half a step of the common exponent, whose mantissa is at least 128.
          ASSERT_NEAR(pixels[3 * (y * width + x) + c], image[c](x, y), largest / 256);
          ASSERT_EQ(own[c](x, y), pixels[3 * (y * width + x) + c]);
        }
      }
    }
    stbi_image_free(pixels);
  }
}

TEST(Hdr, WritesWhatIsNotFiniteOrBeyondItsRange) {
  Image3 image(4, 1);
  image[0](0, 0) = std::nanf("");
  image[0](1, 0) = INFINITY;
  image[0](2, 0) = 1e-42f;                      // below the least exponent
  image[0](3, 0) = std::nextafter(1.0f, 0.0f);  // its mantissa rounds up to 256
  const Image3 read = Decode(EncodeHdr(image).value()).value();
  EXPECT_EQ(read[0](0, 0), 0.0f);
  EXPECT_EQ(read[0](1, 0), std::ldexp(255.0f / 256.0f, 127));
  EXPECT_EQ(read[0](2, 0), 0.0f);
  EXPECT_EQ(read[0](3, 0), 1.0f);
  EXPECT_EQ(EncodeHdr(Image3()).status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(WriteHdr("x/y.hdr", image).message(), HasSubstr("x/y.hdr"));
}

}  // namespace
}  // namespace stillray::hdr_test

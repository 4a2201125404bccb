// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "core/random.h"
#include "io/test_files.h"
#include "stillray/io.h"

namespace stillray::exr_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Values that a half holds exactly, so that every lossless type gives them back bit by bit.
Image1 HalfExact(int width, int height, uint32_t seed) {
  Image1 plane(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const uint32_t hash =
          HashCombine(seed, HashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y)));
      plane(x, y) = static_cast<float>(static_cast<int>(hash % 2048) - 1024) / 64.0f;
    }
  }
  return plane;
}

Image3 HalfExact3(int width, int height, uint32_t seed) {
  Image3 image;
  for (int c = 0; c < 3; ++c) {
    image[c] = HalfExact(width, height, seed + static_cast<uint32_t>(c));
  }
  return image;
}

template <typename T>
void ExpectSame(const Plane<T>& a, const Plane<T>& b) {
  ASSERT_EQ(a.width(), b.width());
  ASSERT_EQ(a.height(), b.height());
  for (int y = 0; y < a.height(); ++y) {
    ASSERT_EQ(std::memcmp(a.Row(y), b.Row(y), sizeof(T) * static_cast<size_t>(a.width())), 0)
        << "row " << y;
  }
}

ExrImage Sample(int width, int height) {
  ExrImage image;
  image.width = width;
  image.height = height;
  image.Add("", PixelType::kHalf, HalfExact3(width, height, 1));
  image.Add("normal.", PixelType::kHalf, HalfExact3(width, height, 4), true);
  image.Add("depth.Z", PixelType::kFloat, HalfExact(width, height, 7));
  Plane<uint32_t> id(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      id(x, y) = HashU32(static_cast<uint32_t>(y * width + x));  // all 32 bits
    }
  }
  image.Add("id", id);
  image.attributes["comment"] = "two\nlines \xc3\xa9";
  return image;
}

void ExpectSamePixels(const ExrImage& a, const ExrImage& b) {
  ASSERT_EQ(a.width, b.width);
  ASSERT_EQ(a.height, b.height);
  ASSERT_EQ(a.channels.size(), b.channels.size());
  for (const Channel& channel : a.channels) {
    SCOPED_TRACE(channel.name);
    const Channel* other = b.Find(channel.name);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(channel.type, other->type);
    ExpectSame(channel.values, other->values);
    ExpectSame(channel.integers, other->integers);
  }
}

Result<ExrImage> RoundTrip(const ExrImage& image) {
  const Result<std::string> bytes = EncodeExr(image);
  return bytes.ok() ? DecodeExr(Data(*bytes), bytes->size(), "test.exr") : bytes.status();
}

TEST(Exr, FileGivesBackWhatWasWritten) {
  const TempFolder folder;
  const ExrImage image = Sample(37, 21);
  const std::string path = folder.Path("a.exr");
  const Status status = WriteExr(path, image);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_THAT(folder.List(), ElementsAre("a.exr"));
  const Result<ExrImage> read = ReadExr(path);
  ASSERT_TRUE(read.ok()) << read.status().message();
  ExpectSamePixels(image, *read);
  EXPECT_EQ(read->attributes.at("comment"), image.attributes.at("comment"));
  EXPECT_EQ(read->compression, ExrCompression::kZip);
  EXPECT_FALSE(read->tiled);
  EXPECT_EQ(read->data_window.x_max, 36);
}

class ExrLossless : public ::testing::TestWithParam<ExrCompression> {};

TEST_P(ExrLossless, KeepsEveryBit) {
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(1, 33), std::pair(67, 1), std::pair(130, 70)}) {
    ExrImage image = Sample(width, height);
    image.compression = GetParam();
    const Result<ExrImage> read = RoundTrip(image);
    ASSERT_TRUE(read.ok()) << read.status().message();
    ExpectSamePixels(image, *read);
    EXPECT_EQ(read->compression, GetParam());
  }
}

INSTANTIATE_TEST_SUITE_P(All, ExrLossless,
                         ::testing::Values(ExrCompression::kNone, ExrCompression::kZip,
                                           ExrCompression::kZips, ExrCompression::kPiz));

/// Lines that compression would make larger are stored as they are, beside others that it does not.
TEST(Exr, NoiseIsNoLargerThanItself) {
  for (const ExrCompression compression : {ExrCompression::kZip, ExrCompression::kZips}) {
    ExrImage image;
    image.width = 301;
    image.height = 50;
    image.compression = compression;
    image.channels.push_back({"id", PixelType::kUint32, {}, Plane<uint32_t>(301, 50)});
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width && y < 32; ++x) {
        image.channels[0].integers(x, y) =
            HashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y));
      }
    }
    const Result<std::string> bytes = EncodeExr(image);
    ASSERT_TRUE(bytes.ok());
    const size_t noise = 301 * 32 * sizeof(uint32_t);
    EXPECT_GT(bytes->size(), noise);
    EXPECT_LT(bytes->size(), noise + 3000);
    const Result<ExrImage> read = DecodeExr(Data(*bytes), bytes->size(), "test.exr");
    ASSERT_TRUE(read.ok()) << read.status().message();
    ExpectSamePixels(image, *read);
  }
}

TEST(Exr, OtherCompressionWritesZip) {
  ExrImage image = Sample(5, 5);
  image.compression = ExrCompression::kOther;
  const Result<ExrImage> read = RoundTrip(image);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->compression_name, "zip");
}

TEST(Exr, DwaaKeepsColoursRoughlyAndRefusesToDamageData) {
  ExrImage image;
  image.width = 64;
  image.height = 64;
  Image3 smooth(64, 64);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        smooth[c](x, y) = 0.5f + 0.004f * static_cast<float>(x + y * c);
      }
    }
  }
  image.Add("", PixelType::kHalf, smooth);
  image.compression = ExrCompression::kDwaa;
  const Result<ExrImage> read = RoundTrip(image);
  ASSERT_TRUE(read.ok()) << read.status().message();
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      EXPECT_NEAR(read->Find("G")->values(x, y), smooth[1](x, y), 0.02f);
    }
  }
  image.Add("motion.Y", PixelType::kHalf, HalfExact(64, 64, 3));
  const Status status = EncodeExr(image).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("motion.Y"));
}

TEST(Exr, HalvesKeepFinitePicturesFinite) {
  ExrImage image;
  image.width = 6;
  image.height = 1;
  Image1 values(6, 1);
  const float inf = std::numeric_limits<float>::infinity();
  const float inputs[] = {1e30f, -1e30f, 65519.0f, inf, -inf, std::nanf("")};
  std::copy(std::begin(inputs), std::end(inputs), values.Row(0));
  image.Add("Y", PixelType::kHalf, values);
  const Result<ExrImage> read = RoundTrip(image);
  ASSERT_TRUE(read.ok());
  const float* row = read->channels[0].values.Row(0);
  EXPECT_EQ(row[0], 65504.0f);
  EXPECT_EQ(row[1], -65504.0f);
  EXPECT_EQ(row[2], 65504.0f);
  EXPECT_EQ(row[3], inf);
  EXPECT_EQ(row[4], -inf);
  EXPECT_TRUE(std::isnan(row[5]));
}

TEST(Exr, HalvesRoundToNearest) {
  ExrImage image;
  image.width = 3;
  image.height = 1;
  Image1 values(3, 1);
  values(0, 0) = 1.0f + 0.4f / 1024;
  values(1, 0) = 1.0f + 0.6f / 1024;
  values(2, 0) = 0x1p-25f;  // exactly between zero and the least half: to even
  image.Add("Y", PixelType::kHalf, values);
  const Result<ExrImage> read = RoundTrip(image);
  ASSERT_TRUE(read.ok());
  const float* row = read->channels[0].values.Row(0);
  EXPECT_EQ(row[0], 1.0f);
  EXPECT_EQ(row[1], 1.0f + 1.0f / 1024);
  EXPECT_EQ(row[2], 0.0f);
}

TEST(Exr, SameBytesForAnyNumberOfThreads) {
  const ExrImage image = Sample(150, 90);
  const auto encode_on = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    SetExrThreads(static_cast<int>(threads) - 1);
    return EncodeExr(image);
  };
  const Result<std::string> alone = encode_on(1);
  const Result<std::string> four = encode_on(4);
  ASSERT_TRUE(alone.ok() && four.ok());
  EXPECT_EQ(*alone, *four);
}

TEST(Exr, RefusesWhatCannotBeWritten) {
  const auto message = [](const ExrImage& image) {
    const Result<std::string> bytes = EncodeExr(image);
    EXPECT_EQ(bytes.status().code(), StatusCode::kInvalidArgument);
    return bytes.status().message();
  };
  ExrImage image;
  EXPECT_THAT(message(image), HasSubstr("0 x 0"));
  image.width = 4;
  image.height = 3;
  EXPECT_THAT(message(image), HasSubstr("without channels"));
  image.Add("R", PixelType::kHalf, Image1(4, 2));
  EXPECT_THAT(message(image), HasSubstr("channel R"));
  image.channels[0].values = Image1(4, 3);
  image.Add("R", PixelType::kHalf, Image1(4, 3));
  EXPECT_THAT(message(image), HasSubstr("two channels named R"));
  image.channels[1].name = "";
  EXPECT_THAT(message(image), HasSubstr("no name"));
  image.channels.pop_back();
  image.attributes["type"] = "deepscanline";
  EXPECT_THAT(message(image), HasSubstr("type"));
  image.attributes = {{"pixelAspectRatio", "1"}};
  EXPECT_THAT(message(image), HasSubstr("pixelAspectRatio"));
  image.attributes = {{"", "1"}};
  message(image);
  image.attributes.clear();
  image.width = 40000;
  EXPECT_THAT(message(image), HasSubstr("40000"));
}

TEST(Exr, WriteErrorsNameTheFile) {
  const TempFolder folder;
  const std::string path = folder.Path("none/a.exr");
  const Status missing = WriteExr(path, Sample(4, 4));
  EXPECT_EQ(missing.code(), StatusCode::kNotFound);
  EXPECT_THAT(missing.message(), HasSubstr(path));
  EXPECT_THAT(WriteExr(path, ExrImage()).message(), HasSubstr(path));
  const Status full = WriteExr("/dev/full", Sample(4, 4));
  EXPECT_EQ(full.code(), StatusCode::kIo);
  EXPECT_THAT(full.message(), HasSubstr("No space left on device"));
}

TEST(Exr, ReadWritesAgainWhatWasRead) {
  const Result<ExrImage> once = RoundTrip(Sample(16, 9));
  ASSERT_TRUE(once.ok());
  const Result<ExrImage> twice = RoundTrip(*once);
  ASSERT_TRUE(twice.ok()) << twice.status().message();
  ExpectSamePixels(*once, *twice);
  EXPECT_EQ(once->attributes, twice->attributes);
}

TEST(ExrLayer, FindsItsChannels) {
  const ExrImage image = Sample(8, 4);
  const Result<Image3> normal = ExrLayer(image, "normal.", true);
  ASSERT_TRUE(normal.ok());
  ExpectSame((*normal)[2], image.Find("normal.Z")->values);
  const Result<Image3> none = ExrLayer(image, "albedo.");
  EXPECT_EQ(none.status().code(), StatusCode::kNotFound);
  EXPECT_THAT(none.status().message(), HasSubstr("albedo.R"));
}

TEST(ExrColour, PicksTheMainPictureFirst) {
  ExrImage image = Sample(8, 4);
  image.Add("View.Combined.", PixelType::kHalf, HalfExact3(8, 4, 30));
  const Result<Image3> colour = ExrColour(image, "a.exr");
  ASSERT_TRUE(colour.ok());
  ExpectSame((*colour)[0], image.Find("R")->values);
}

TEST(ExrColour, ThenBlendersCombined) {
  ExrImage image;
  image.width = 8;
  image.height = 4;
  image.Add("View.DiffCol.", PixelType::kHalf, HalfExact3(8, 4, 10));
  image.Add("View.Combined.", PixelType::kHalf, HalfExact3(8, 4, 20));
  const Result<Image3> colour = ExrColour(image, "a.exr");
  ASSERT_TRUE(colour.ok());
  ExpectSame((*colour)[1], image.Find("View.Combined.G")->values);
}

TEST(ExrColour, ThenTheOnlyLayer) {
  ExrImage image;
  image.width = 8;
  image.height = 4;
  image.Add("beauty.", PixelType::kHalf, HalfExact3(8, 4, 10));
  image.Add("depth.Z", PixelType::kFloat, HalfExact(8, 4, 20));
  const Result<Image3> colour = ExrColour(image, "a.exr");
  ASSERT_TRUE(colour.ok());
  ExpectSame((*colour)[2], image.Find("beauty.B")->values);
}

TEST(ExrColour, ThenGrey) {
  ExrImage image;
  image.width = 8;
  image.height = 4;
  image.Add("Y", PixelType::kHalf, HalfExact(8, 4, 10));
  const Result<Image3> colour = ExrColour(image, "a.exr");
  ASSERT_TRUE(colour.ok());
  for (int c = 0; c < 3; ++c) {
    ExpectSame((*colour)[c], image.Find("Y")->values);
  }
}

TEST(ExrColour, NamesFromFilesCannotSteerTheTerminal) {
  ExrImage image;
  image.width = 8;
  image.height = 4;
  image.Add("a\x1b[2J\nb", PixelType::kFloat, HalfExact(8, 4, 10));
  EXPECT_THAT(ExrColour(image, "a.exr").status().message(), HasSubstr("a [2J b"));
}

TEST(ExrColour, SaysWhatThereIsWhereNothingIsClear) {
  ExrImage image;
  image.width = 8;
  image.height = 4;
  image.Add("depth.Z", PixelType::kFloat, HalfExact(8, 4, 10));
  EXPECT_THAT(ExrColour(image, "a.exr").status().message(),
              ::testing::AllOf(HasSubstr("a.exr"), HasSubstr("depth.Z")));
  image.Add("left.", PixelType::kHalf, HalfExact3(8, 4, 10));
  image.Add("right.", PixelType::kHalf, HalfExact3(8, 4, 20));
  const Status status = ExrColour(image, "a.exr").status();
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_THAT(status.message(), ::testing::AllOf(HasSubstr("left"), HasSubstr("right")));
}

}  // namespace
}  // namespace stillray::exr_test

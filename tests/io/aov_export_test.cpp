// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/test_files.h"
#include "stillray/aov.h"

namespace stillray::aov_export_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 7;
constexpr int kHeight = 5;

Image3 Ramp(float offset) {
  Image3 image(kWidth, kHeight);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        image[c](x, y) =
            offset + static_cast<float>(c) + 0.25f * static_cast<float>(x + kWidth * y);
      }
    }
  }
  return image;
}

/// A plain file of WriteExr: Combined, alpha, depth, an unknown layer.
std::string PlainFile(ExrCompression compression) {
  ExrImage image;
  image.width = kWidth;
  image.height = kHeight;
  image.compression = compression;
  image.attributes["owner"] = "somebody";
  image.Add("L.Combined.", PixelType::kHalf, Ramp(0));
  image.Add("L.Combined.A", PixelType::kHalf, Ramp(5)[0]);
  Image1 odd = Ramp(0.1f)[0];
  odd(2, 2) = std::nanf("");
  odd(3, 2) = 1e10f;
  image.Add("L.Depth.Z", PixelType::kFloat, odd);
  Plane<uint32_t> id(kWidth, kHeight);
  id.Fill(4'000'000'001u);
  image.Add("L.Something.X", id);
  return EncodeExr(image).value();
}

Result<ExrImage> Decode(const std::string& bytes) {
  return DecodeExr(Data(bytes), bytes.size(), "file");
}

bool SameBits(const Image1& a, const Image1& b) {
  for (int y = 0; y < a.height(); ++y) {
    if (std::memcmp(a.Row(y), b.Row(y), sizeof(float) * static_cast<size_t>(a.width())) != 0) {
      return false;
    }
  }
  return a.width() == b.width() && a.height() == b.height();
}

/// Pixels that are kept as they are stored must lead to the same image and the same file.
void ExpectSameFromStoredPixels(const std::string& original, const ExrImage& image,
                                const AovLayout& layout, const Image3& colour,
                                const std::string& replaced) {
  StoredPixels stored;
  const Result<ExrImage> again = DecodeExr(Data(original), original.size(), "file", &stored);
  ASSERT_TRUE(again.ok()) << again.status().message();
  ASSERT_EQ(again->channels.size(), image.channels.size());
  for (size_t i = 0; i < image.channels.size(); ++i) {
    const Channel& a = again->channels[i];
    const Channel& b = image.channels[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_TRUE(SameBits(a.values, b.values)) << a.name;
    ASSERT_EQ(a.integers.width(), b.integers.width());
    for (int y = 0; y < a.integers.height(); ++y) {
      EXPECT_TRUE(
          std::equal(a.integers.Row(y), a.integers.Row(y) + a.integers.width(), b.integers.Row(y)))
          << a.name;
    }
  }
  EXPECT_FALSE(stored.empty());
  const Result<std::string> bytes =
      ReplaceLight(original, layout, colour, "file", {}, std::move(stored));
  ASSERT_TRUE(bytes.ok()) << bytes.status().message();
  EXPECT_TRUE(*bytes == replaced);
}

/// The file with new light, read again.
Result<ExrImage> Rewritten(const std::string& original, const Image3& colour,
                           std::string* bytes = nullptr) {
  const Result<ExrImage> image = Decode(original);
  if (!image.ok()) {
    return image.status();
  }
  const Result<AovLayout> layout = UnderstandAovs(*image, {"blender", {}}, "file");
  if (!layout.ok()) {
    return layout.status();
  }
  Result<std::string> replaced = ReplaceLight(original, *layout, colour, "file");
  if (!replaced.ok()) {
    return replaced.status();
  }
  ExpectSameFromStoredPixels(original, *image, *layout, colour, *replaced);
  if (bytes != nullptr) {
    *bytes = *replaced;
  }
  return Decode(*replaced);
}

TEST(AovExport, OnlyTheLightChanges) {
  for (const ExrCompression compression :
       {ExrCompression::kNone, ExrCompression::kZip, ExrCompression::kZips, ExrCompression::kPiz}) {
    const std::string original = PlainFile(compression);
    const Result<ExrImage> before = Decode(original);
    const Result<ExrImage> after = Rewritten(original, Ramp(100));
    ASSERT_TRUE(after.ok()) << after.status().message();
    EXPECT_EQ(after->compression_name, before->compression_name);
    EXPECT_EQ(after->attributes, before->attributes);
    EXPECT_EQ(after->other_attributes, before->other_attributes);
    ASSERT_EQ(after->channels.size(), before->channels.size());
    for (size_t i = 0; i < after->channels.size(); ++i) {
      const Channel& a = after->channels[i];
      const Channel& b = before->channels[i];
      EXPECT_EQ(a.name, b.name);
      EXPECT_EQ(a.type, b.type);
      const bool light = a.name.starts_with("L.Combined.") && a.name != "L.Combined.A";
      if (a.type == PixelType::kUint32) {
        EXPECT_EQ(a.integers(3, 3), 4'000'000'001u);
      } else {
        EXPECT_EQ(SameBits(a.values, b.values), !light) << a.name;
      }
    }
    EXPECT_EQ(after->Find("L.Combined.G")->values(1, 0), 101.25f);
  }
}

TEST(AovExport, TooMuchForAHalfIsTheLargestHalf) {
  Image3 colour = Ramp(0);
  colour[0](0, 0) = 1e6f;
  const Result<ExrImage> after = Rewritten(PlainFile(ExrCompression::kZip), colour);
  ASSERT_TRUE(after.ok());
  EXPECT_EQ(after->Find("L.Combined.R")->values(0, 0), 65504.0f);
}

TEST(AovExport, LightIsAddedWhereThereIsNoColour) {
  ExrImage image;
  image.width = kWidth;
  image.height = kHeight;
  image.Add("V.DiffDir.", PixelType::kHalf, Ramp(0));
  image.Add("V.DiffCol.", PixelType::kHalf, Ramp(0));
  const Result<ExrImage> after = Rewritten(EncodeExr(image).value(), Ramp(7));
  ASSERT_TRUE(after.ok()) << after.status().message();
  ASSERT_NE(after->Find("V.Combined.B"), nullptr);
  EXPECT_EQ(after->Find("V.Combined.B")->values(0, 0), 9.0f);
  EXPECT_EQ(after->channels.size(), 9u);
}

/// Channels R, G, B (half) and Depth.Z (float) of the value 1 in the window.
Imf::FrameBuffer Ones(const Imath::Box2i& window, std::vector<half>* halves,
                      std::vector<float>* floats) {
  const size_t width = static_cast<size_t>(window.max.x - window.min.x + 1);
  const size_t count = width * static_cast<size_t>(window.max.y - window.min.y + 1);
  halves->assign(count, half(1.0f));
  floats->assign(count, 1.0f);
  Imf::FrameBuffer buffer;
  for (const char* name : {"R", "G", "B"}) {
    buffer.insert(name, Imf::Slice::Make(Imf::HALF, halves->data(), window, sizeof(half),
                                         width * sizeof(half)));
  }
  buffer.insert("Depth.Z", Imf::Slice::Make(Imf::FLOAT, floats->data(), window, sizeof(float),
                                            width * sizeof(float)));
  return buffer;
}

Imf::Header ForeignHeader(const Imath::Box2i& data) {
  Imf::Header header(Imath::Box2i({0, 0}, {kWidth - 1, kHeight - 1}), data);
  for (const char* name : {"R", "G", "B"}) {
    header.channels().insert(name, Imf::Channel(Imf::HALF));
  }
  header.channels().insert("Depth.Z", Imf::Channel(Imf::FLOAT));
  header.insert("shutter", Imf::FloatAttribute(0.5f));
  return header;
}

class AovExportCompression : public ::testing::TestWithParam<Imf::Compression> {};

TEST_P(AovExportCompression, WindowsAndNumbersStay) {
  const TempFolder folder;
  const std::string path = folder.Path("a.exr");
  const Imath::Box2i data({-2, 1}, {4, 8});
  std::vector<half> halves;
  std::vector<float> floats;
  {
    Imf::Header header = ForeignHeader(data);
    header.compression() = GetParam();
    header.lineOrder() = Imf::DECREASING_Y;
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(Ones(data, &halves, &floats));
    file.writePixels(8);
  }
  const Result<ExrImage> after = Rewritten(FileBytes(path), Ramp(10));
  ASSERT_TRUE(after.ok()) << after.status().message();
  EXPECT_EQ(after->data_window.x_min, -2);
  EXPECT_EQ(after->data_window.y_max, 8);
  const std::string expected = GetParam() == Imf::ZIP_COMPRESSION    ? "zip"
                               : GetParam() == Imf::ZIPS_COMPRESSION ? "zips"
                                                                     : "pxr24";
  EXPECT_EQ(after->compression_name, expected);
  EXPECT_EQ(after->other_attributes.at("shutter"), "0.5");
  EXPECT_EQ(after->Find("R")->values(0, 0), 0.0f);  // outside of the data window
  EXPECT_EQ(after->Find("R")->values(2, 1), Ramp(10)[0](2, 1));
  EXPECT_EQ(after->Find("Depth.Z")->values(2, 1), 1.0f);
}

INSTANTIATE_TEST_SUITE_P(All, AovExportCompression,
                         ::testing::Values(Imf::PXR24_COMPRESSION, Imf::ZIP_COMPRESSION,
                                           Imf::ZIPS_COMPRESSION));

TEST(AovExport, TilesStayTiles) {
  const TempFolder folder;
  const std::string path = folder.Path("a.exr");
  const Imath::Box2i data({0, 0}, {kWidth - 1, kHeight - 1});
  std::vector<half> halves;
  std::vector<float> floats;
  {
    Imf::Header header = ForeignHeader(data);
    header.setTileDescription(Imf::TileDescription(4, 2, Imf::ONE_LEVEL));
    Imf::TiledOutputFile file(path.c_str(), header);
    file.setFrameBuffer(Ones(data, &halves, &floats));
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  }
  const Result<ExrImage> after = Rewritten(FileBytes(path), Ramp(10));
  ASSERT_TRUE(after.ok()) << after.status().message();
  EXPECT_TRUE(after->tiled);
  EXPECT_TRUE(SameBits(after->Find("G")->values, Ramp(10)[1]));
  EXPECT_EQ(after->Find("Depth.Z")->values(6, 4), 1.0f);
}

TEST(AovExport, PartsStayParts) {
  const TempFolder folder;
  const std::string path = folder.Path("a.exr");
  const Imath::Box2i data({0, 0}, {kWidth - 1, kHeight - 1});
  std::vector<half> halves;
  std::vector<float> floats;
  std::vector<Imf::Header> headers(2, ForeignHeader(data));
  headers[0].setName("first");
  headers[1].setName("second");
  headers[1].insert("comment", Imf::StringAttribute("of the second"));
  for (Imf::Header& header : headers) {
    header.setType(Imf::SCANLINEIMAGE);
  }
  {
    Imf::MultiPartOutputFile file(path.c_str(), headers.data(), 2);
    for (int i = 0; i < 2; ++i) {
      Imf::OutputPart part(file, i);
      part.setFrameBuffer(Ones(data, &halves, &floats));
      part.writePixels(kHeight);
    }
  }
  std::string bytes;
  const Result<ExrImage> after = Rewritten(FileBytes(path), Ramp(10), &bytes);
  ASSERT_TRUE(after.ok()) << after.status().message();
  ASSERT_EQ(after->channels.size(), 8u);
  EXPECT_TRUE(SameBits(after->Find("B")->values, Ramp(10)[2]));
  EXPECT_EQ(after->Find("second.B")->values(3, 3), 1.0f);
  EXPECT_THAT(bytes, HasSubstr("of the second"));
}

TEST(AovExport, DamageAndOtherSizesAreRefused) {
  const std::string original = PlainFile(ExrCompression::kZip);
  const Result<AovLayout> layout = UnderstandAovs(*Decode(original), {"blender", {}}, "file");
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(ReplaceLight(original.substr(0, original.size() / 2), *layout, Ramp(0), "a.exr")
                .status()
                .code(),
            StatusCode::kBadData);
  const Result<std::string> size = ReplaceLight(original, *layout, Image3(3, 2), "a.exr");
  EXPECT_EQ(size.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(size.status().message(), HasSubstr("a.exr: has 7 x 5 pixels, the new light 3 x 2"));
}

}  // namespace
}  // namespace stillray::aov_export_test

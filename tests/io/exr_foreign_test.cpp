// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// EXR files that others write.
#include "io/exr_foreign.h"

#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <array>
#include <cmath>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/test_files.h"
#include "stillray/aov.h"
#include "stillray/io.h"

namespace stillray::exr_foreign_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

Imath::Box2i Box(int x0, int y0, int x1, int y1) {
  return {Imath::V2i(x0, y0), Imath::V2i(x1, y1)};
}

std::vector<std::string> Names(const ExrImage& image) {
  std::vector<std::string> names;
  for (const Channel& channel : image.channels) {
    names.push_back(channel.name);
  }
  return names;
}

/// The picture has the display window's size, the file's values inside the data window and zero
/// elsewhere.
void ExpectForeign(const ExrImage& image, const Imath::Box2i& display, const Imath::Box2i& data,
                   float tolerance = 0) {
  ASSERT_EQ(image.width, display.max.x - display.min.x + 1);
  ASSERT_EQ(image.height, display.max.y - display.min.y + 1);
  for (const Channel& channel : image.channels) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const Imath::V2i p(x + display.min.x, y + display.min.y);
        const float expected = data.intersects(p) ? ForeignValue(p.x, p.y) : 0.0f;
        ASSERT_NEAR(channel.values(x, y), expected, tolerance)
            << channel.name << " at " << x << ", " << y;
      }
    }
  }
}

/// Reads a file, and once more with its pixels as they are stored, as `stillray denoise` does.
std::array<Result<ExrImage>, 2> ReadBothWays(const std::string& path) {
  const std::string bytes = FileBytes(path);
  StoredPixels stored;
  return {ReadExr(path), DecodeExr(Data(bytes), bytes.size(), path, &stored)};
}

struct Windows {
  const char* what;
  Imath::Box2i display;
  Imath::Box2i data;
};

class ExrWindows : public ::testing::TestWithParam<Windows> {};

TEST_P(ExrWindows, ScanlinesAndTilesLandWhereTheyBelong) {
  const TempFolder folder;
  const Windows& w = GetParam();
  const Imf::Header header = ForeignHeader(w.display, w.data, {"R", "G", "B"});
  WriteForeignScanlines(folder.Path("lines.exr"), header);
  WriteForeignTiles(folder.Path("tiles.exr"), header, 16, Imf::ONE_LEVEL);
  for (const char* name : {"lines.exr", "tiles.exr"}) {
    SCOPED_TRACE(name);
    for (const Result<ExrImage>& image : ReadBothWays(folder.Path(name))) {
      ASSERT_TRUE(image.ok()) << image.status().message();
      ExpectForeign(*image, w.display, w.data);
      EXPECT_EQ(image->data_window.x_min, w.data.min.x);
      EXPECT_EQ(image->data_window.y_max, w.data.max.y);
      EXPECT_EQ(image->display_window.x_max, w.display.max.x);
      EXPECT_EQ(image->tiled, std::string(name) == "tiles.exr");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, ExrWindows,
    ::testing::Values(Windows{"same", Box(0, 0, 36, 20), Box(0, 0, 36, 20)},
                      Windows{"crop", Box(0, 0, 36, 20), Box(5, 7, 20, 15)},
                      Windows{"overscan", Box(0, 0, 36, 20), Box(-10, -4, 50, 30)},
                      Windows{"moved", Box(100, 200, 120, 210), Box(110, 190, 140, 205)},
                      Windows{"negative", Box(-50, -40, -20, -10), Box(-60, -45, -30, -20)},
                      Windows{"apart", Box(0, 0, 9, 9), Box(20, 20, 29, 29)}),
    [](const auto& info) { return info.param.what; });

class ExrAnyCompression : public ::testing::TestWithParam<Imf::Compression> {};

TEST_P(ExrAnyCompression, ScanlinesAndTilesAreRead) {
  const TempFolder folder;
  const Imath::Box2i window = Box(0, 0, 79, 69);
  // Not "Y", "R", ...: DWA must treat them as data here.
  const Imf::Header header = ForeignHeader(window, window, {"depth.Z", "mask.V"}, GetParam());
  WriteForeignScanlines(folder.Path("lines.exr"), header);
  WriteForeignTiles(folder.Path("tiles.exr"), header, 32, Imf::ONE_LEVEL);
  // PXR24 keeps 24 bits of a float.
  const float tolerance = GetParam() == Imf::PXR24_COMPRESSION ? 0.01f : 0.0f;
  for (const char* name : {"lines.exr", "tiles.exr"}) {
    for (const Result<ExrImage>& image : ReadBothWays(folder.Path(name))) {
      ASSERT_TRUE(image.ok()) << image.status().message();
      ExpectForeign(*image, window, window, tolerance);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ExrAnyCompression,
                         ::testing::Values(Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION,
                                           Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION,
                                           Imf::PIZ_COMPRESSION, Imf::PXR24_COMPRESSION,
                                           Imf::B44_COMPRESSION, Imf::B44A_COMPRESSION,
                                           Imf::DWAA_COMPRESSION, Imf::DWAB_COMPRESSION));

TEST(ExrForeign, MipMapsGiveTheirLargestLevel) {
  const TempFolder folder;
  const Imath::Box2i window = Box(0, 0, 63, 63);
  const Imf::Header header = ForeignHeader(window, window, {"Y"});
  WriteForeignTiles(folder.Path("a.exr"), header, 16, Imf::MIPMAP_LEVELS);
  const Result<ExrImage> image = ReadExr(folder.Path("a.exr"));
  ASSERT_TRUE(image.ok()) << image.status().message();
  ExpectForeign(*image, window, window);
}

TEST(ExrForeign, PartsAddTheirChannels) {
  const TempFolder folder;
  const Imath::Box2i window = Box(0, 0, 19, 9);
  WriteForeignParts(folder.Path("a.exr"), {ForeignHeader(window, window, {"R", "G", "B"}),
                                           ForeignHeader(window, window, {"depth.Z"}),
                                           ForeignHeader(window, window, {"R", "A"})});
  const Result<ExrImage> image = ReadExr(folder.Path("a.exr"));
  ASSERT_TRUE(image.ok()) << image.status().message();
  EXPECT_THAT(Names(*image), UnorderedElementsAre("R", "G", "B", "depth.Z", "part2.R", "part2.A"));
  ExpectForeign(*image, window, window);
  EXPECT_TRUE(image->notes.empty());
}

TEST(ExrForeign, HeaderAttributesAreKeptAsText) {
  const TempFolder folder;
  const Imath::Box2i window = Box(0, 0, 3, 3);
  Imf::Header header = ForeignHeader(window, window, {"Y"});
  Imf::addOwner(header, "somebody");
  Imf::addFocus(header, 2.5f);
  Imf::addWorldToCamera(header, Imath::M44f());
  WriteForeignScanlines(folder.Path("a.exr"), header);
  const Result<ExrImage> image = ReadExr(folder.Path("a.exr"));
  ASSERT_TRUE(image.ok()) << image.status().message();
  EXPECT_EQ(image->attributes.at("owner"), "somebody");
  EXPECT_EQ(image->other_attributes.at("focus"), "2.5");
  EXPECT_THAT(image->other_attributes.at("worldToCamera"), HasSubstr("1 0 0 0 0 1"));
}

TEST(ExrForeign, SubsampledChannelsAreRefusedByName) {
  const TempFolder folder;
  const Imath::Box2i window = Box(0, 0, 7, 7);
  Imf::Header header = ForeignHeader(window, window, {"Y"});
  header.channels().insert("RY", Imf::Channel(Imf::HALF, 2, 2));
  {
    const ForeignPlane plane(window);
    std::vector<half> chroma(16);
    Imf::FrameBuffer buffer;
    buffer.insert("Y", plane.Slice());
    buffer.insert("RY", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(chroma.data()), sizeof(half),
                                   4 * sizeof(half), 2, 2));
    Imf::OutputFile file(folder.Path("a.exr").c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(8);
  }
  const Result<ExrImage> image = ReadExr(folder.Path("a.exr"));
  EXPECT_EQ(image.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(image.status().message(), HasSubstr("RY"));
}

TEST(ExrForeign, DeepDataIsRefused) {
  const TempFolder folder;
  const Imath::Box2i window = Box(0, 0, 3, 3);
  Imf::Header header = ForeignHeader(window, window, {"Z"}, Imf::ZIPS_COMPRESSION);
  header.setType(Imf::DEEPSCANLINE);
  {
    float sample = 1;
    std::vector<unsigned> counts(16, 1);
    std::vector<float*> pointers(16, &sample);
    Imf::DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()),
                                             sizeof(unsigned), 4 * sizeof(unsigned)));
    buffer.insert("Z", Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers.data()),
                                      sizeof(float*), 4 * sizeof(float*), sizeof(float)));
    Imf::DeepScanLineOutputFile file(folder.Path("a.exr").c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(4);
  }
  const Result<ExrImage> image = ReadExr(folder.Path("a.exr"));
  EXPECT_EQ(image.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(image.status().message(), HasSubstr("deep"));
}

std::string TestData() {
  const char* folder = std::getenv("STILLRAY_TEST_DATA");
  return folder != nullptr ? folder : STILLRAY_DEFAULT_TEST_DATA;
}

TEST(ExrForeign, BlendersFramesAreRead) {
  const std::string path = TestData() + "/sequences/blender_box/native_0008.exr";
  if (!std::filesystem::exists(path)) {
    GTEST_SKIP() << path << " is not there; set STILLRAY_TEST_DATA";
  }
  const Result<ExrImage> image = ReadExr(path);
  ASSERT_TRUE(image.ok()) << image.status().message();
  EXPECT_EQ(image->width, 192);
  EXPECT_EQ(image->height, 108);
  ASSERT_NE(image->Find("ViewLayer.Depth.Z"), nullptr);
  EXPECT_EQ(image->Find("ViewLayer.Depth.Z")->type, PixelType::kFloat);
  const Result<Image3> colour = ExrColour(*image, path);
  ASSERT_TRUE(colour.ok()) << colour.status().message();
  ASSERT_NE(image->Find("ViewLayer.Combined.R"), nullptr);
  EXPECT_EQ((*colour)[0](96, 54), image->Find("ViewLayer.Combined.R")->values(96, 54));
}

}  // namespace
}  // namespace stillray::exr_foreign_test

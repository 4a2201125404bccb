// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Numbers of samples in files, and second moments.
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/one_pixel.h"
#include "stillray/aov.h"
#include "stillray/io.h"

namespace stillray::aov_samples_test {
namespace {

using test::BlenderLayers;
using test::Import;
using test::OnePixel;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr float kInf = std::numeric_limits<float>::infinity();

/// The count that a pixel of the pass Debug Sample Count stands for.
float CountOf(float fraction, const char* samples) {
  std::map<std::string, std::vector<float>> layers;
  for (const auto& [name, values] : BlenderLayers()) {
    layers[name.starts_with(":") ? name : "V." + name] = values;
  }
  layers["V.Debug Sample Count:X"] = {fraction};
  ExrImage image = OnePixel(layers);
  image.attributes["cycles.V.samples"] = samples;
  const Result<Frame> frame = Import(image);
  EXPECT_TRUE(frame.ok()) << frame.status().message();
  return frame->samples.empty() ? -1.0f : frame->samples(0, 0);
}

TEST(AovSamples, CountsOfCyclesAreFractions) {
  EXPECT_EQ(CountOf(1, "64"), 64);
  EXPECT_EQ(CountOf(0.25f, "64"), 16);
  EXPECT_EQ(CountOf(0.79999995f, "5"), 4);  // as Blender 3.4.1 writes 4 of 5
  EXPECT_EQ(CountOf(0.7998f, "64"), 51);    // 51 of 64 as a half
  EXPECT_EQ(CountOf(1e-6f, "64"), 1);
  EXPECT_EQ(CountOf(0, "64"), 0);
  EXPECT_EQ(CountOf(-1, "64"), 0);
  EXPECT_EQ(CountOf(NAN, "64"), 0);
  EXPECT_EQ(CountOf(kInf, "64"), 0);
  EXPECT_EQ(CountOf(0.5f, ""), -1);
}

TEST(AovSamples, WithoutALayerAllPixelsHaveTheLayoutsSamples) {
  const ExrImage image = OnePixel(BlenderLayers());
  AovLayout layout = UnderstandAovs(image, {}, "file").value();
  EXPECT_TRUE(ImportFrame(image, layout, {0, 0}, "file")->samples.empty());
  layout.samples = 16;
  const Result<Frame> frame = ImportFrame(image, layout, {0, 0}, "file");
  EXPECT_EQ(frame->samples(0, 0), 16);
  EXPECT_FALSE(frame->signals[0].second_moment.empty());
}

TEST(AovSamples, OtherLayersOfSamplesAreCounts) {
  std::map<std::string, std::vector<float>> layers = BlenderLayers();
  layers["counts:X"] = {12};
  ExrImage image = OnePixel(layers);
  image.attributes["cycles.ViewLayer.samples"] = "64";
  EXPECT_TRUE(Import(image)->samples.empty());
  EXPECT_EQ(Import(image, {"auto", {"samples=counts"}})->samples(0, 0), 12);
}

TEST(AovSamples, AFrameThatDoesNotStateItsSamplesIsRefused) {
  std::map<std::string, std::vector<float>> layers = BlenderLayers();
  layers["Debug Sample Count:X"] = {0.5f};
  ExrImage image = OnePixel(layers);
  image.attributes["cycles.ViewLayer.samples"] = "64";
  const Result<AovLayout> layout = UnderstandAovs(image, {}, "first");
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(ImportFrame(image, *layout, {0, 0}, "first")->samples(0, 0), 32);
  image.attributes.clear();
  const Result<Frame> frame = ImportFrame(image, *layout, {0, 0}, "second.exr");
  EXPECT_EQ(frame.status().code(), StatusCode::kBadData);
  EXPECT_THAT(frame.status().message(),
              HasSubstr("second.exr: has no usable attribute cycles.ViewLayer.samples"));
}

TEST(AovSamples, MeansOfSeveralSamplesGetSecondMoments) {
  std::map<std::string, std::vector<float>> layers = BlenderLayers();
  layers["counts:X"] = {1};
  EXPECT_TRUE(
      Import(OnePixel(layers), {"auto", {"samples=counts"}})->signals[0].second_moment.empty());
  layers["counts:X"] = {2};
  const Result<Frame> frame = Import(OnePixel(layers), {"auto", {"samples=counts"}});
  ASSERT_TRUE(frame.ok());
  // One pixel has no neighbours and so no variance: squared light before it meets the albedo.
  const Signal& diffuse = *frame->Find(SignalKind::kDirectDiffuse);
  EXPECT_NEAR(diffuse.second_moment(0, 0), std::pow(0.2126 * 1 + 0.7152 * 2 + 0.0722 * 3, 2), 1e-4);
  for (const Signal& signal : frame->signals) {
    EXPECT_FALSE(signal.second_moment.empty()) << SignalName(signal.kind);
  }
}

TEST(AovSamples, SecondMomentsWithoutCountsAreIgnored) {
  const ExrImage image = OnePixel({{":RGB", {3, 3, 3}},
                                   {"direct_diffuse:RGB", {1, 1, 1}},
                                   {"indirect_specular:RGB", {2, 2, 2}},
                                   {"albedo:RGB", {0.5f, 0.5f, 0.5f}},
                                   {"specular_albedo:RGB", {0.5f, 0.5f, 0.5f}},
                                   {"normal:XYZ", {0, 0, 1}},
                                   {"motion:XY", {0, 0}},
                                   {"depth:Z", {2}},
                                   {"samples:X", {4}},
                                   {"direct_diffuse.second_moment:X", {7}}});
  const Result<Frame> counted = Import(image, {"stillray", {}});
  ASSERT_TRUE(counted.ok()) << counted.status().message();
  EXPECT_EQ(counted->Find(SignalKind::kDirectDiffuse)->second_moment(0, 0), 7);
  const Result<Frame> alone = Import(image, {"stillray", {"samples=none"}});
  ASSERT_TRUE(alone.ok()) << alone.status().message();
  EXPECT_TRUE(alone->Find(SignalKind::kDirectDiffuse)->second_moment.empty());
  // What is read is not listed as carried through, and the reverse.
  const AovLayout read = UnderstandAovs(image, {"stillray", {}}, "file").value();
  EXPECT_THAT(read.carried, IsEmpty());
  EXPECT_THAT(AovTable(read), HasSubstr("  second_moment           direct_diffuse.second_moment"));
  const AovLayout ignored = UnderstandAovs(image, {"stillray", {"samples=none"}}, "file").value();
  EXPECT_THAT(ignored.carried, ElementsAre("direct_diffuse.second_moment", "samples"));
}

}  // namespace
}  // namespace stillray::aov_samples_test

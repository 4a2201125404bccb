// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The settings that a sequence gets from its files.
#include "sequence/settings.h"

#include <gtest/gtest.h>

namespace stillray::settings_test {
namespace {

struct Given {
  SequenceOptions options;
  AovLayout layout;
  ExrImage first;
};

/// Frames of Blender of `samples` per pixel, through a filter as wide as a pixel.
Given Mixed(const char* samples) {
  Given given;
  given.options.settings = PresetSettings("default").value();
  given.layout.soft_guides = true;
  given.first.attributes["cycles.ViewLayer.samples"] = samples;
  return given;
}

Settings Chosen(const Given& given, bool has_motion = true) {
  return SettingsFor(given.options, given.layout, given.first, has_motion);
}

TEST(SequenceSettings, SamplesCountAlikeInAntialiasing) {
  EXPECT_FLOAT_EQ(AntialiasingWeight(0.12f, 1), 0.12f);
  // 0.12 / 0.88 of the past is one sample, so four are 0.48 / 0.88: 0.48 / 1.36.
  EXPECT_NEAR(AntialiasingWeight(0.12f, 4), 0.48 / 1.36, 1e-6);
  EXPECT_NEAR(AntialiasingWeight(0.12f, 16), 1.92 / 2.8, 1e-6);
  EXPECT_FLOAT_EQ(AntialiasingWeight(0, 16), 0);
  EXPECT_FLOAT_EQ(AntialiasingWeight(1, 16), 1);
}

TEST(SequenceSettings, FramesWithMixedGuidesAreAntialiased) {
  const Settings settings = Chosen(Mixed("16"));
  EXPECT_EQ(settings.antialias, Antialias::kTaa);
  EXPECT_FLOAT_EQ(settings.taa_alpha, AntialiasingWeight(0.12f, 16));
}

TEST(SequenceSettings, TheViewLayerOfMostSamplesCounts) {
  Given given = Mixed("4");
  given.first.attributes["cycles.Shadows.samples"] = "64";
  EXPECT_FLOAT_EQ(Chosen(given).taa_alpha, AntialiasingWeight(0.12f, 64));
}

int StatedIn(const Given& given) {
  return SamplesFor(given.options, given.layout, given.first, given.options.settings).value();
}

TEST(SequenceSettings, SamplesAreThoseThatTheFileStates) {
  EXPECT_EQ(StatedIn(Mixed("16")), 16);
  EXPECT_EQ(StatedIn(Mixed("1")), 1);
  for (const char* samples : {"", "many", "0", "-4", "16x"}) {
    EXPECT_EQ(StatedIn(Mixed(samples)), 0) << samples;
  }
  Given sharp = Mixed("16");
  sharp.layout.soft_guides = false;
  EXPECT_EQ(StatedIn(sharp), 16);
  Given refused = Mixed("16");
  refused.options.aovs.mappings = {"id=none", "samples=none"};
  EXPECT_EQ(StatedIn(refused), 1);
  Given layer = Mixed("16");
  layer.layout.sources.push_back({Aov::kSamples, "counts", {"counts.X"}});
  EXPECT_EQ(StatedIn(layer), 1);
  Given published = Mixed("16");
  published.options.settings = PresetSettings("svgf").value();
  EXPECT_EQ(StatedIn(published), 1);
}

TEST(SequenceSettings, TheUserMayStateSamples) {
  Given given = Mixed("");
  given.options.spp = 8;
  EXPECT_EQ(StatedIn(given), 8);
  EXPECT_FLOAT_EQ(Chosen(given).taa_alpha, AntialiasingWeight(0.12f, 8));
  Given published = given;
  published.options.settings = PresetSettings("svgf").value();
  EXPECT_EQ(StatedIn(published), 8);
  Given stated = Mixed("16");
  stated.options.spp = 8;
  stated.options.aovs.mappings = {"samples=none"};
  EXPECT_EQ(StatedIn(stated), 8);
  given.layout.sources.push_back({Aov::kSamples, "counts", {"counts.X"}});
  const Result<int> both =
      SamplesFor(given.options, given.layout, given.first, given.options.settings);
  EXPECT_EQ(both.status().code(), StatusCode::kInvalidArgument);
  EXPECT_NE(both.status().message().find("layer counts"), std::string::npos);
}

TEST(SequenceSettings, OthersAreNot) {
  Given sharp = Mixed("16");
  sharp.layout.soft_guides = false;
  EXPECT_EQ(Chosen(sharp).antialias, Antialias::kOff);
  for (const char* samples : {"", "many", "0", "-4", "16x"}) {
    EXPECT_EQ(Chosen(Mixed(samples)).antialias, Antialias::kOff) << samples;
  }
  EXPECT_EQ(Chosen(Mixed("16"), /*has_motion=*/false).antialias, Antialias::kOff);
  Given passes = Mixed("16");
  passes.options.passes = true;
  EXPECT_EQ(Chosen(passes).antialias, Antialias::kOff);
  Given published = Mixed("16");
  published.options.settings = PresetSettings("svgf").value();
  EXPECT_EQ(Chosen(published).antialias, Antialias::kOff);
}

/// One sample through the centre of each pixel.
Given Centred(const std::string& renderer) {
  Given given = Mixed("1");
  given.layout.soft_guides = false;
  given.layout.renderer = renderer;
  given.options.files.resize(2);
  return given;
}

bool IsJagged(const Given& given, bool has_motion = true) {
  return HasJaggedEdges(given.options, given.layout, given.first, has_motion);
}

TEST(SequenceSettings, FramesThroughTheCentresAreAntialiasedIfTheUserWants) {
  Given given = Centred("blender");
  EXPECT_EQ(Chosen(given).antialias, Antialias::kOff);
  given.options.settings.antialias = Antialias::kTaa;
  given.options.fixed_parameters = {"antialias"};
  EXPECT_EQ(Chosen(given).antialias, Antialias::kTaa);
  EXPECT_FLOAT_EQ(Chosen(given).taa_alpha, 0.3f);
  EXPECT_EQ(Chosen(given, /*has_motion=*/false).antialias, Antialias::kOff);
  Given mixed = given;
  mixed.layout.soft_guides = true;
  mixed.first.attributes["cycles.ViewLayer.samples"] = "16";
  EXPECT_FLOAT_EQ(Chosen(mixed).taa_alpha, AntialiasingWeight(0.12f, 16));
  Given unknown = mixed;
  unknown.first.attributes.clear();
  EXPECT_FLOAT_EQ(Chosen(unknown).taa_alpha, 0.12f);
  Given larger = given;
  larger.options.settings.taa_alpha = 0.05f;
  larger.options.fixed_parameters.push_back("taa_alpha");
  EXPECT_FLOAT_EQ(Chosen(larger).taa_alpha, 0.05f);
  Given published = given;
  published.options.settings = PresetSettings("svgf").value();
  published.options.settings.antialias = Antialias::kTaa;
  EXPECT_FLOAT_EQ(Chosen(published).taa_alpha, PresetSettings("svgf").value().taa_alpha);
}

TEST(SequenceSettings, JaggedEdgesAreKnownByTheGuides) {
  EXPECT_TRUE(IsJagged(Centred("blender")));
  EXPECT_TRUE(IsJagged(Centred("stillray")));
  EXPECT_FALSE(IsJagged(Centred("arnold")));
  EXPECT_FALSE(IsJagged(Centred("blender"), /*has_motion=*/false));
  EXPECT_FALSE(IsJagged(Mixed("16")));
  for (const char* preset : {"temporal", "eaw"}) {
    Given plain = Centred("blender");
    plain.options.settings = PresetSettings(preset).value();
    EXPECT_FALSE(IsJagged(plain)) << preset;
  }
  Given off = Centred("blender");
  off.options.fixed_parameters = {"antialias"};
  EXPECT_FALSE(IsJagged(off));
  Given single = Centred("blender");
  single.options.files.resize(1);
  EXPECT_FALSE(IsJagged(single));
  Given jittered = Centred("stillray");
  jittered.first.attributes["jitter"] = "0.25 -0.125";
  EXPECT_FALSE(IsJagged(jittered));
}

TEST(SequenceSettings, WhatIsSetStays) {
  Given off = Mixed("16");
  off.options.settings.antialias = Antialias::kOff;
  off.options.fixed_parameters = {"antialias"};
  EXPECT_EQ(Chosen(off).antialias, Antialias::kOff);
  Given alpha = Mixed("16");
  alpha.options.settings.taa_alpha = 0.3f;
  alpha.options.fixed_parameters = {"taa_alpha"};
  EXPECT_EQ(Chosen(alpha).antialias, Antialias::kTaa);
  EXPECT_FLOAT_EQ(Chosen(alpha).taa_alpha, 0.3f);
}

TEST(SequenceSettings, JitteredFramesAreAntialiasedAsTheyWere) {
  Given given = Mixed("16");
  given.first.attributes["jitter"] = "0.25 -0.125";
  const Settings settings = Chosen(given);
  EXPECT_EQ(settings.antialias, Antialias::kAuto);
  EXPECT_FLOAT_EQ(settings.taa_alpha, 0.12f);
}

}  // namespace
}  // namespace stillray::settings_test

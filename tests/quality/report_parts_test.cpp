// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "core/colour.h"
#include "quality/heat_map.h"
#include "quality/render_log.h"
#include "quality/report_files.h"
#include "quality/report_page.h"
#include "quality/report_times.h"

namespace stillray::report::report_parts_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Pair;

TEST(SpreadEvenly, KeepsBothEndsAndEvenSteps) {
  EXPECT_THAT(SpreadEvenly(5, 12), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(SpreadEvenly(9, 3), ElementsAre(0, 4, 8));
  EXPECT_THAT(SpreadEvenly(100, 2), ElementsAre(0, 99));
  EXPECT_THAT(SpreadEvenly(1, 1), ElementsAre(0));
  EXPECT_THAT(SpreadEvenly(7, 1), ElementsAre(6));
  for (int total = 2; total < 60; ++total) {
    for (int count = 2; count <= total; ++count) {
      const std::vector<int> chosen = SpreadEvenly(total, count);
      ASSERT_EQ(chosen.size(), static_cast<size_t>(count));
      EXPECT_EQ(chosen.front(), 0);
      EXPECT_EQ(chosen.back(), total - 1);
      const double step = static_cast<double>(total - 1) / (count - 1);
      for (size_t i = 0; i < chosen.size(); ++i) {
        EXPECT_LE(std::abs(chosen[i] - static_cast<double>(i) * step), 0.5 + 1e-9)
            << total << " " << count;
      }
    }
  }
}

TEST(JoinNames, ReadsAsASentence) {
  EXPECT_EQ(JoinNames({}), "");
  EXPECT_EQ(JoinNames({"a"}), "a");
  EXPECT_EQ(JoinNames({"a", "b"}), "a and b");
  EXPECT_EQ(JoinNames({"a", "b", "c"}), "a, b and c");
}

TEST(EscapeHtml, LeavesNoMarkup) {
  EXPECT_EQ(EscapeHtml("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
  EXPECT_EQ(EscapeHtml("\xc3\xbc\xff"), "\xc3\xbc\uFFFD");
}

// Heat map

TEST(HeatMap, RampGrowsLighter) {
  float last = -1;
  for (int i = 0; i < kNotFiniteIndex; ++i) {
    const Rgb8& c = HeatPalette()[static_cast<size_t>(i)];
    const float luminance = Luminance709(SrgbDecode(c[0] / 255.0f), SrgbDecode(c[1] / 255.0f),
                                         SrgbDecode(c[2] / 255.0f));
    EXPECT_GT(luminance, last) << i;
    last = luminance;
  }
}

TEST(HeatMap, LinearScale) {
  EXPECT_EQ(HeatIndex(0.0f, kFlipScale), 0);
  EXPECT_EQ(HeatIndex(0.5f, kFlipScale), 127);
  EXPECT_EQ(HeatIndex(1.0f, kFlipScale), 254);
  EXPECT_EQ(HeatIndex(7.0f, kFlipScale), 254);
  EXPECT_EQ(HeatIndex(-1.0f, kFlipScale), 0);
}

TEST(HeatMap, LogarithmicScaleGivesEachPowerOfTenTheSameRoom) {
  const float errors[] = {1e-4f, 1e-3f, 1e-2f, 1e-1f, 1.0f, 10.0f};
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(HeatIndex(errors[i], kRelativeSquaredErrorScale), 254 * i / 5.0, 0.51) << i;
  }
  EXPECT_EQ(HeatIndex(0.0f, kRelativeSquaredErrorScale), 0);
  EXPECT_EQ(HeatIndex(1e30f, kRelativeSquaredErrorScale), 254);
}

TEST(HeatMap, WhatIsNotFiniteHasItsOwnColour) {
  EXPECT_EQ(HeatIndex(std::nanf(""), kFlipScale), kNotFiniteIndex);
  EXPECT_EQ(HeatIndex(std::numeric_limits<float>::infinity(), kRelativeSquaredErrorScale),
            kNotFiniteIndex);
  for (int i = 0; i < kNotFiniteIndex; ++i) {
    EXPECT_NE(HeatPalette()[static_cast<size_t>(i)], HeatPalette()[kNotFiniteIndex]);
  }
}

TEST(HeatMap, EncodesEveryPixelInItsPlace) {
  Image1 errors(3, 2);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      errors(x, y) = 0.1f * static_cast<float>(x + 3 * y);
    }
  }
  const Result<std::string> png = EncodeHeatMap(errors, kFlipScale);
  ASSERT_TRUE(png.ok()) << png.status().message();
  const Result<Rgb8Image> image =
      DecodePng8(reinterpret_cast<const uint8_t*>(png->data()), png->size(), "map");
  ASSERT_TRUE(image.ok()) << image.status().message();
  ASSERT_EQ(image->pixels.size(), 18u);
  for (int i = 0; i < 6; ++i) {
    const Rgb8& expected = HeatPalette()[HeatIndex(errors(i % 3, i / 3), kFlipScale)];
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(image->pixels[3 * static_cast<size_t>(i) + c], expected[c]) << i;
    }
  }
}

// Times

TEST(TimeTable, MedianRangeAndShare) {
  std::vector<RenderLogFrame> frames(3);
  frames[0].stages_ms = {{"late", 1.0}, {"early", 6.0}};
  frames[1].stages_ms = {{"late", 3.0}, {"early", 6.0}};
  frames[2].stages_ms = {{"late", 8.0}};
  frames[0].denoise_ms = 5.0;
  frames[2].denoise_ms = 8.0;
  const TimeTable table = MakeTimeTable(frames);
  ASSERT_EQ(table.stages.size(), 2u);
  const StepTimes& late = table.stages[0];
  EXPECT_EQ(late.name, "late");
  EXPECT_EQ(late.frames, 3);
  EXPECT_EQ(late.median_ms, 3.0);
  EXPECT_EQ(late.min_ms, 1.0);
  EXPECT_EQ(late.max_ms, 8.0);
  EXPECT_EQ(late.share, 0.5);
  EXPECT_EQ(table.stages[1].share, 0.5);
  ASSERT_TRUE(table.denoise.has_value());
  EXPECT_EQ(table.denoise->median_ms, 6.5);
  EXPECT_FALSE(table.render.has_value());
}

TEST(TimeTable, StagesThatComeLaterStandWhereTheyRun) {
  std::vector<RenderLogFrame> frames(2);
  frames[0].stages_ms = {{"b", 1.0}, {"d", 1.0}};
  frames[1].stages_ms = {{"a", 1.0}, {"b", 1.0}, {"c", 1.0}, {"d", 1.0}, {"e", 1.0}};
  std::string order;
  for (const StepTimes& stage : MakeTimeTable(frames).stages) {
    order += stage.name;
  }
  EXPECT_EQ(order, "abcde");
}

TEST(TimeTable, StagesThatTakeNoTimeHaveNoShare) {
  std::vector<RenderLogFrame> frames(1);
  frames[0].stages_ms = {{"nothing", 0.0}};
  EXPECT_EQ(MakeTimeTable(frames).stages[0].share, 0.0);
  EXPECT_TRUE(MakeTimeTable({}).stages.empty());
}

// render.json

RenderLog Parse(const std::string& text) {
  const Result<RenderLog> log = ParseRenderLog(text, "render.json");
  EXPECT_TRUE(log.ok()) << log.status().message();
  return log.ok() ? *log : RenderLog{};
}

TEST(RenderLog, ReadsEveryKey) {
  const RenderLog log = Parse(R"({
    "stillray": "0.1.0", "scene": "builtin:cornell", "width": 640, "height": 360, "fps": 29.97,
    "spp": 1, "bounces": 4, "preset": "default", "seed": 18446744073709551615, "sampler": "sobol",
    "threads": 2, "machine": "a processor", "date": "2026-03-01T12:00:00Z", "exposure": -0.5,
    "tonemap": "aces",
    "parameters": {"kernel": "5x5", "sigma_l": 4.0, "steps": [1, 2, 4], "temporal": true},
    "frames": [{"frame": 1, "seconds": 0.0, "render_ms": 120.0, "denoise_ms": 30.1,
                "write_ms": 12.5, "stages_ms": {"demodulate": 1.2, "accumulate": 3.0}}],
    "memory": {"denoiser_bytes": 123, "renderer_bytes": 456}})");
  EXPECT_EQ(log.version, "0.1.0");
  EXPECT_EQ(log.scene, "builtin:cornell");
  EXPECT_EQ(log.preset, "default");
  EXPECT_EQ(log.tonemap, "aces");
  EXPECT_EQ(log.exposure, -0.5);
  EXPECT_EQ(log.width, 640);
  EXPECT_EQ(log.height, 360);
  EXPECT_EQ(log.fps, 29.97);
  EXPECT_EQ(log.settings.size(), 15u);
  EXPECT_THAT(log.settings, ::testing::Contains(Pair("seed", "18446744073709551615")));
  EXPECT_THAT(log.parameters, ElementsAre(Pair("kernel", "5x5"), Pair("sigma_l", "4.0"),
                                          Pair("steps", "1, 2, 4"), Pair("temporal", "true")));
  ASSERT_EQ(log.frames.size(), 1u);
  EXPECT_EQ(log.frames[0].render_ms, 120.0);
  EXPECT_EQ(log.frames[0].write_ms, 12.5);
  EXPECT_THAT(log.frames[0].stages_ms,
              ElementsAre(Pair("demodulate", 1.2), Pair("accumulate", 3.0)));
  EXPECT_THAT(log.memory, ElementsAre(Pair("denoiser_bytes", 123), Pair("renderer_bytes", 456)));
}

TEST(RenderLog, NamesTheSceneWithoutItsFolders) {
  const RenderLog log = Parse(R"({"scene": "/home/me/secret/lamp.GLB"})");
  EXPECT_EQ(log.scene, "lamp.GLB");
  EXPECT_THAT(log.settings, ElementsAre(Pair("scene", "lamp.GLB")));
}

TEST(RenderLog, TakesTheFrameRatesThatRenderTakes) {
  EXPECT_EQ(Parse(R"({"fps": 0.001})").fps, 0.001);
  EXPECT_FALSE(ParseRenderLog(R"({"fps": 0.0001})", "render.json").ok());
}

TEST(RenderLog, ReadsWhatChangesThePictures) {
  const RenderLog log = Parse(R"({
    "command": "stillray render room.glb -o out --still", "scene": "room.glb",
    "scene_content": "0123456789abcdef", "environment": "sky.hdr", "camera": "top", "still": true,
    "first_frame": 3, "regularise": false, "jitter": true, "device": "CPU", "tracer": "CPU",
    "traces_ahead": false, "ray_tracing": "auto", "first_hits": "auto", "textures": "auto", "reference": 0, "reference_frames": "",
    "aov": "temporal",
    "format": "exr,png", "float": false,
    "memory": {"denoiser_bytes": 123,
               "device": {"allocations": 2, "bytes": 100, "largest_bytes": 60}}})");
  EXPECT_THAT(log.settings, ::testing::Contains(Pair("still", "true")));
  EXPECT_THAT(log.settings, ::testing::Contains(Pair("environment", "sky.hdr")));
  EXPECT_EQ(log.settings.size(), 20u);
  EXPECT_THAT(log.memory, ElementsAre(Pair("denoiser_bytes", 123)));
}

TEST(RenderLog, EverythingIsOptional) {
  const RenderLog log = Parse("{}");
  EXPECT_TRUE(log.settings.empty());
  EXPECT_FALSE(log.width.has_value());
}

struct BadLog {
  const char* text;
  const char* message;  ///< part of it
};

TEST(RenderLog, NamesWhatIsWrong) {
  const BadLog logs[] = {
      {"", "line 1"},
      {"{\"spp\": 1,\n\"fps\": }", "line 2"},
      {"{\"scene\": \"\xff\"}", "line 1"},
      {"[]", "top level: found an array, expected an object"},
      {"{\"still\": 1}", "still: found 1, expected true or false"},
      {"{\"memory\": {\"device\": {\"bytes\": -1}}}", "memory.device.bytes: found -1"},
      {"{\"sppp\": 1}", "unknown key \"sppp\"; expected stillray, scene,"},
      {"{\"spp\": 1, \"spp\": 2}", "the key \"spp\" stands twice"},
      {"{\"scene\": 1}", "scene: found 1, expected text"},
      {"{\"width\": 640.5}", "width: found 640.5, expected a whole number in 1..32768"},
      {"{\"width\": 0}", "width: found 0"},
      {"{\"fps\": 0}", "fps: found 0"},
      {"{\"fps\": \"24\"}", "fps: found the text \"24\", expected a number"},
      {"{\"seed\": -1}", "seed: found -1"},
      {"{\"spp\": 1e999}", "render.json"},
      {"{\"parameters\": []}", "parameters: found an array, expected an object"},
      {"{\"parameters\": {\"a\": {}}}", "parameters.a: found an object"},
      {"{\"parameters\": {\"a\": [[1]]}}", "parameters.a: found an array"},
      {"{\"parameters\": {\"a\": null}}", "parameters.a: found null"},
      {"{\"memory\": {\"a\": 1.5}}", "memory.a: found 1.5, expected a whole number"},
      {"{\"memory\": {\"a\": -1}}", "memory.a: found -1"},
      {"{\"frames\": {}}", "frames: found an object, expected an array"},
      {"{\"frames\": [1]}", "frames[0]: found 1, expected an object"},
      {"{\"frames\": [{}]}", "frames[0]: no key \"frame\""},
      {"{\"frames\": [{\"frame\": 1}, {\"frame\": 1}]}", "frames[1]: frame 1 stands there twice"},
      {"{\"frames\": [{\"frame\": 1, \"ms\": 1}]}", "frames[0]: unknown key \"ms\""},
      {"{\"frames\": [{\"frame\": 1, \"render_ms\": -1}]}", "frames[0].render_ms: found -1"},
      {"{\"frames\": [{\"frame\": 1, \"stages_ms\": {\"a\": \"b\"}}]}",
       "frames[0].stages_ms.a: found the text \"b\", expected a number"},
  };
  for (const BadLog& bad : logs) {
    const Result<RenderLog> log = ParseRenderLog(bad.text, "render.json");
    ASSERT_FALSE(log.ok()) << bad.text;
    EXPECT_EQ(log.status().code(), StatusCode::kBadData) << bad.text;
    EXPECT_THAT(log.status().message(), HasSubstr(bad.message));
    EXPECT_THAT(log.status().message(), ::testing::StartsWith("render.json: "));
    EXPECT_THAT(log.status().message(), Not(HasSubstr("\n")));
  }
}

TEST(RenderLog, HostileShapesAreRefusedQuickly) {
  std::string deep = "{\"parameters\": ";
  deep += std::string(100'000, '[');
  EXPECT_THAT(ParseRenderLog(deep, "render.json").status().message(), HasSubstr("nested deeper"));
  std::string wide = "{\"parameters\": {";
  for (int i = 0; i < 100'000; ++i) {
    wide += fmt::format("\"{}\": 1, ", i);
  }
  EXPECT_THAT(ParseRenderLog(wide, "render.json").status().message(),
              HasSubstr("more than 1000 keys"));
  const std::string key(1'000'000, 'k');
  const Result<RenderLog> log = ParseRenderLog("{\"" + key + "\": 1}", "render.json");
  ASSERT_FALSE(log.ok());
  EXPECT_LT(log.status().message().size(), 700u);
}

}  // namespace
}  // namespace stillray::report::report_parts_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The table of the path tracer's settings.
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/other_value.h"
#include "stillray/render.h"

namespace stillray {
namespace {

using test::OtherValue;
using ::testing::HasSubstr;

std::string Value(const RenderSettings& settings, const char* name) {
  return GetRenderParameter(settings, name).value();
}

TEST(RenderParameters, EveryValueReadsBack) {
  RenderSettings settings;
  for (const Parameter& p : RenderParameters()) {
    const std::string other = OtherValue(p);
    EXPECT_NE(Value(settings, p.name), other);
    ASSERT_TRUE(SetRenderParameter(&settings, p.name, other).ok()) << p.name;
    EXPECT_EQ(Value(settings, p.name), other);
    EXPECT_TRUE(ValidateRenderSettings(settings).ok()) << p.name;
  }
}

TEST(RenderParameters, RowsSetTheirMembers) {
  RenderSettings settings;
  const auto set = [&](const char* name, const char* value) {
    EXPECT_TRUE(SetRenderParameter(&settings, name, value).ok()) << name;
  };
  set("spp", "1/8");
  set("guides", "sparse");
  set("seed", "18446744073709551615");
  set("sampler", "halton16");
  set("jitter", "off");
  set("bounces", "7");
  set("regularise", "on");
  set("light_sampling", "bsdf");
  set("light_candidates", "3");
  set("clamp_radiance", "2.5");
  EXPECT_EQ(settings.spp, 1);
  EXPECT_EQ(settings.cycle, 8);
  EXPECT_EQ(settings.guides, GuideCoverage::kSparse);
  EXPECT_EQ(settings.seed, ~uint64_t{0});
  EXPECT_EQ(settings.sampler, SamplerKind::kHalton16);
  EXPECT_FALSE(settings.jitter);
  EXPECT_EQ(settings.bounces, 7);
  EXPECT_TRUE(settings.regularise);
  EXPECT_EQ(settings.light_sampling, LightSampling::kBsdf);
  EXPECT_EQ(settings.light_candidates, 3);
  EXPECT_EQ(settings.clamp_radiance, 2.5f);
}

TEST(RenderParameters, RowsAreComplete) {
  for (const Parameter& p : RenderParameters()) {
    EXPECT_NE(*p.group, '\0') << p.name;
    const std::string help = p.help;
    EXPECT_TRUE(help.size() > 10 && help.back() == '.') << p.name;
    const bool lists = p.type == ParameterType::kChoice || p.type == ParameterType::kText;
    EXPECT_EQ(lists, !p.choices.empty()) << p.name;
  }
}

TEST(RenderParameters, RatesAreWholeNumbersOrFractions) {
  const struct {
    const char* text;
    int spp;
    int cycle;
    const char* back;
  } kCases[] = {{"4", 4, 1, "4"},           {"65536", 65536, 1, "65536"},
                {"1/8", 1, 8, "1/8"},       {"0.125", 1, 8, "1/8"},
                {"0.333", 1, 3, "1/3"},     {"1/256", 1, 256, "1/256"},
                {"0.0039", 1, 256, "1/256"}};
  for (const auto& c : kCases) {
    RenderSettings settings;
    settings.spp = 9;
    ASSERT_TRUE(SetRenderParameter(&settings, "spp", c.text).ok()) << c.text;
    EXPECT_EQ(settings.spp, c.spp) << c.text;
    EXPECT_EQ(settings.cycle, c.cycle) << c.text;
    EXPECT_EQ(Value(settings, "spp"), c.back);
  }
}

TEST(RenderParameters, WhatIsNoRateChangesNothing) {
  for (const char* text : {"", "0", "-1", "1/1", "2/3", "1/0", "1/257", "0.4", "1/", "/2", "x",
                           "1e9", "nan", "0.000001", "65537", "1/8x", "1.5"}) {
    RenderSettings settings;
    settings.spp = 3;
    const Status status = SetRenderParameter(&settings, "spp", text);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << text;
    EXPECT_EQ(status.message(), "spp is '" + std::string(text) +
                                    "', expected 1 to 65536, or 1/2 to 1/256 for one path per "
                                    "pixel in several frames");
    EXPECT_EQ(settings.spp, 3) << text;
    EXPECT_EQ(settings.cycle, 1) << text;
  }
}

TEST(RenderParameters, ErrorsNameSettingValueAndRange) {
  const auto message = [](const char* name, const char* value) {
    RenderSettings settings;
    const Status status = SetRenderParameter(&settings, name, value);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    for (const Parameter& p : RenderParameters()) {
      EXPECT_EQ(Value(settings, p.name), Value({}, p.name)) << name << "=" << value;
    }
    return status.message();
  };
  EXPECT_EQ(message("bounces", "33"), "bounces is '33', expected a whole number from 1 to 32");
  EXPECT_THAT(message("bounces", "4x"), HasSubstr("'4x'"));
  EXPECT_EQ(message("sampler", "nope"),
            "sampler is 'nope', expected one of sobol, halton16, zsobol");
  EXPECT_EQ(message("jitter", "maybe"), "jitter is 'maybe', expected on or off");
  EXPECT_EQ(message("clamp_radiance", "-1"),
            "clamp_radiance is '-1', expected a number from 0 to 1000000");
  EXPECT_EQ(message("light_sampling", "nee"),
            "light_sampling is 'nee', expected one of none, bsdf, light, mis");
  EXPECT_EQ(message("seed", "-1"),
            "seed is '-1', expected a whole number from 0 to 18446744073709551615");
  EXPECT_EQ(message("bounce", "1"), "unknown render setting 'bounce', did you mean bounces?");
  EXPECT_EQ(message("colour", "1"),
            "unknown render setting 'colour'; settings are: spp, guides, seed, sampler, "
            "light_candidates, jitter, filter_textures, virtual_guides, bounces, regularise, "
            "light_sampling, clamp_radiance, aperture, focus, blades, blade_rotation");
  EXPECT_EQ(GetRenderParameter({}, "colour").status().code(), StatusCode::kInvalidArgument);
}

TEST(RenderParameters, LensesHaveTheirOwnNotation) {
  RenderSettings settings;
  const auto set = [&](const char* name, const char* value) {
    return SetRenderParameter(&settings, name, value).ok();
  };
  EXPECT_TRUE(set("aperture", "f/2.8") && set("focus", "3.5") && set("blades", "6"));
  EXPECT_TRUE(set("blade_rotation", "-12.5"));
  EXPECT_EQ(settings.f_number, 2.8f);
  EXPECT_FALSE(settings.aperture);
  EXPECT_EQ(Value(settings, "aperture"), "f/2.8");
  EXPECT_EQ(settings.focus, 3.5f);
  EXPECT_EQ(settings.blades, 6);
  EXPECT_EQ(settings.blade_rotation, -12.5f);
  EXPECT_TRUE(set("aperture", "0.25") && set("focus", "auto"));
  EXPECT_EQ(settings.aperture, 0.25f);
  EXPECT_FALSE(settings.f_number);
  EXPECT_EQ(Value(settings, "focus"), "auto");
  for (const auto& [name, value] : {std::pair{"aperture", "-1"},
                                    {"aperture", "nan"},
                                    {"aperture", "inf"},
                                    {"aperture", "f/0"},
                                    {"aperture", "f/-2"},
                                    {"aperture", "f/nan"},
                                    {"aperture", "f/"},
                                    {"aperture", ""},
                                    {"focus", "0"},
                                    {"focus", "-2"},
                                    {"focus", "nan"},
                                    {"focus", "near"},
                                    {"blades", "2"},
                                    {"blades", "33"},
                                    {"blades", "-1"},
                                    {"blades", "5.5"},
                                    {"blade_rotation", "nan"},
                                    {"blade_rotation", "181"}}) {
    const Status status = SetRenderParameter(&settings, name, value);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << name << "=" << value;
    EXPECT_THAT(status.message(), HasSubstr(std::string("'") + value + "', expected scene"));
  }
  for (const char* name : {"aperture", "focus", "blades", "blade_rotation"}) {
    EXPECT_TRUE(set(name, "scene"));
    EXPECT_EQ(Value(settings, name), "scene");
  }
  EXPECT_FALSE(settings.aperture || settings.focus || settings.blades || settings.blade_rotation);
}

TEST(RenderParameters, StructsOutOfRangeAreFound) {
  const auto message = [](auto change) {
    RenderSettings settings;
    change(&settings);
    return ValidateRenderSettings(settings).message();
  };
  EXPECT_EQ(message([](RenderSettings*) {}), "");
  EXPECT_EQ(message([](RenderSettings* s) { s->width = 0; }),
            "width is 0, expected 1 to 32768 pixels");
  EXPECT_THAT(message([](RenderSettings* s) { s->height = 32769; }), HasSubstr("height is 32769"));
  EXPECT_THAT(message([](RenderSettings* s) { s->spp = 0; }), HasSubstr("spp is '0'"));
  EXPECT_THAT(message([](RenderSettings* s) { s->cycle = 0; }), HasSubstr("spp is '1/0'"));
  EXPECT_THAT(message([](RenderSettings* s) { s->cycle = 257; }), HasSubstr("spp is '1/257'"));
  EXPECT_THAT(message([](RenderSettings* s) { s->spp = s->cycle = 2; }), HasSubstr("spp is '2/2'"));
  EXPECT_THAT(message([](RenderSettings* s) { s->sampler = static_cast<SamplerKind>(7); }),
              HasSubstr("sampler is '7', expected one of sobol, halton16, zsobol"));
}

TEST(RenderParameters, SamplingKeepsTheLightAndPathsDoNot) {
  for (const Parameter& p : RenderParameters()) {
    RenderSettings settings;
    ASSERT_TRUE(SetRenderParameter(&settings, p.name, OtherValue(p)).ok());
    EXPECT_EQ(SameLight({}, settings), std::string(p.group) == "sampling") << p.name;
  }
}

}  // namespace
}  // namespace stillray

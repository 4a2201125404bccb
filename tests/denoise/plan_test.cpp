// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The plan of a frame, by hand: which stages each preset runs, with what parameters, and how a
// sequence goes on from frame to frame.
#include "denoise/plan.h"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace stillray::plan_test {
namespace {

Settings Preset(const char* name) {
  return PresetSettings(name).value();
}

/// Of a frame of the tracer: all guides, lights without transmission, one sample per pixel.
FrameFacts UsualFacts() {
  FrameFacts facts;
  facts.index = 7;
  facts.lights = 0xf;
  facts.albedos = 3;
  facts.has_id = facts.has_emission = facts.has_background = facts.has_roughness = true;
  facts.jitter_x = 0.25f;
  return facts;
}

constexpr SequenceProgress kLater = {.has_history = true, .has_picture = true, .jittered = true};

std::vector<std::string> NamesOf(const StagesRun& r) {
  std::vector<std::string> names;
  const auto add = [&](bool runs, const char* name) {
    if (runs) {
      names.emplace_back(name);
    }
  };
  add(r.fill_guides, "fill_guides");
  add(r.reproject, "reproject");
  add(r.clamp_fireflies, "clamp_fireflies");
  add(r.compress_light, "compress_light");
  add(r.limit_history, "limit_history");
  add(r.merge_future, "merge_future");
  add(r.wavelet, "wavelet");
  add(r.estimate_variance, "estimate_variance");
  add(r.measure_luminance, "measure_luminance");
  add(r.clip_outliers, "clip_outliers");
  add(r.restore_energy, "restore_energy");
  add(r.keep_samples, "keep_samples");
  add(r.keep_mirrors, "keep_mirrors");
  add(r.restore_detail, "restore_detail");
  add(r.fxaa, "fxaa");
  add(r.antialias, "antialias");
  add(r.tonemap, "tonemap");
  return names;
}

using Names = std::vector<std::string>;

TEST(Plan, StagesOfEveryPreset) {
  const auto stages = [](const char* preset) {
    return NamesOf(MakePlan(Preset(preset), UsualFacts(), kLater).runs);
  };
  EXPECT_EQ(stages("default"),
            (Names{"reproject", "limit_history", "wavelet", "estimate_variance", "clip_outliers",
                   "restore_energy", "keep_mirrors", "antialias"}));
  EXPECT_EQ(stages("best"),
            (Names{"reproject", "limit_history", "wavelet", "estimate_variance", "clip_outliers",
                   "restore_energy", "keep_mirrors", "restore_detail", "antialias"}));
  EXPECT_EQ(stages("svgf"), (Names{"reproject", "wavelet", "estimate_variance", "antialias"}));
  EXPECT_EQ(stages("psvgf"), (Names{"reproject", "wavelet", "estimate_variance", "antialias"}));
  EXPECT_EQ(stages("eaw"), (Names{"wavelet", "measure_luminance"}));
  EXPECT_EQ(stages("temporal"), (Names{"reproject"}));
}

TEST(Plan, StagesThatTheFrameAsksFor) {
  FrameFacts facts = UsualFacts();
  facts.has_incomplete_guides = true;
  facts.has_future = true;
  facts.is_displayed = true;
  facts.has_roughness = false;
  facts.samples_per_pixel = 0.25f;
  Settings s;
  s.firefly = Firefly::kClamp;
  EXPECT_EQ(NamesOf(MakePlan(s, facts, SequenceProgress()).runs),
            (Names{"fill_guides", "clamp_fireflies", "merge_future", "wavelet", "estimate_variance",
                   "clip_outliers", "restore_energy", "fxaa", "antialias", "tonemap"}));
  s.fill_guides = false;
  s.firefly = Firefly::kCompress;
  s.fxaa = Fxaa::kOff;
  s.antialias = Antialias::kOff;
  EXPECT_EQ(NamesOf(MakePlan(s, facts, SequenceProgress()).runs),
            (Names{"compress_light", "merge_future", "wavelet", "estimate_variance",
                   "clip_outliers", "tonemap"}));
}

TEST(Plan, PilotsOfTheSignals) {
  const auto pilots = [](const Settings& s) {
    return MakePlan(s, UsualFacts(), kLater).pilot_signals;
  };
  Settings s;
  EXPECT_EQ(pilots(s), (std::array{7, 2})) << "direct, indirect, specular; indirect again";
  s.signals = SignalGrouping::kSingle;
  EXPECT_EQ(pilots(s), (std::array{1, 0}));
  s.pilot = false;
  EXPECT_EQ(pilots(s), (std::array{0, 0}));
  EXPECT_EQ(pilots(Preset("svgf")), (std::array{0, 0}));
}

TEST(Plan, DirectLightIsComparedWithinFewPixelsToo) {
  const auto fine = [](SignalGrouping signals, uint32_t lights) {
    Settings s;
    s.signals = signals;
    FrameFacts facts = UsualFacts();
    facts.lights = lights;
    return MakePlan(s, facts, kLater).limit_history.fine_signals;
  };
  constexpr uint32_t kAll = ~0u;
  EXPECT_EQ(fine(SignalGrouping::kSplit, kAll), 5)
      << "direct, specular; not indirect, transmission";
  EXPECT_EQ(fine(SignalGrouping::kDirectIndirect, kAll), 1);
  EXPECT_EQ(fine(SignalGrouping::kSingle, kAll), 1);
  const uint32_t indirect = 1u << static_cast<uint32_t>(SignalKind::kIndirectDiffuse) |
                            1u << static_cast<uint32_t>(SignalKind::kIndirectSpecular);
  EXPECT_EQ(fine(SignalGrouping::kSplit, indirect), 0);
  FrameFacts sparse = UsualFacts();
  sparse.samples_per_pixel = 0.25f;
  EXPECT_EQ(MakePlan(Settings(), sparse, kLater).limit_history.fine_signals, 0);
}

TEST(Plan, ShortHistoriesOfThePresets) {
  const auto of = [](const char* preset, float samples_per_pixel) {
    FrameFacts facts = UsualFacts();
    facts.samples_per_pixel = samples_per_pixel;
    return MakePlan(Preset(preset), facts, kLater).estimate_variance.short_history;
  };
  EXPECT_EQ(of("default", 1), kShortHistorySecondDifference);
  EXPECT_EQ(of("default", 0.25f), kShortHistorySpread);
  EXPECT_EQ(of("svgf", 1), kShortHistorySpread);
  const auto radius = [](float samples_per_pixel) {
    FrameFacts facts = UsualFacts();
    facts.samples_per_pixel = samples_per_pixel;
    return MakePlan(Settings(), facts, kLater).estimate_variance.short_history_radius;
  };
  EXPECT_EQ(radius(1), 2);
  EXPECT_EQ(radius(0.25f), 3);
  EXPECT_EQ(of("psvgf", 1), kShortHistoryNone);
}

TEST(Plan, LevelsOfThePresets) {
  const FramePlan psvgf = MakePlan(Preset("psvgf"), UsualFacts(), kLater);
  ASSERT_EQ(psvgf.levels, 5);
  const int steps[] = {16, 8, 4, 2, 1};
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(psvgf.level[i].step, steps[i]);
    EXPECT_EQ(psvgf.level[i].radius, 1);
    EXPECT_EQ(psvgf.level[i].weights, kAtrousSvgf);
  }
  EXPECT_EQ(psvgf.border, 16);
  EXPECT_EQ(MakePlan(Preset("default"), UsualFacts(), kLater).border, 32);  // step 16, 5x5
  const FramePlan eaw = MakePlan(Preset("eaw"), UsualFacts(), kLater);
  EXPECT_EQ(eaw.level[0].weights, kAtrousEaw);
  const FramePlan temporal = MakePlan(Preset("temporal"), UsualFacts(), kLater);
  EXPECT_EQ(temporal.levels, 0);
  EXPECT_EQ(temporal.border, 4);  // that of the wavelet in limit_history: step 4, 3x3
}

TEST(Plan, ParametersAreThoseOfTheSettingsResolved) {
  Settings s;
  s.history_normal = 60;
  s.short_history_length = 6;
  s.exposure = 3;
  s.tonemap = Tonemap::kFilmic;
  const FramePlan plan = MakePlan(s, UsualFacts(), kLater);
  EXPECT_NEAR(plan.reproject.history_normal_cosine, 0.5f, 1e-6f);
  EXPECT_EQ(plan.reproject.history_depth, 0.05f);
  EXPECT_EQ(plan.limit_history.limit_dead, 4.0f);
  EXPECT_EQ(plan.limit_history.limit_gain, 12.0f);
  EXPECT_EQ(plan.limit_history.jitter_x, 0.25f);
  FrameFacts centred = UsualFacts();
  centred.jitter_x = 0;
  EXPECT_EQ(MakePlan(s, centred, kLater).limit_history.jitter_x, 0);
  // A history of six samples is not short, whatever its sum was rounded to.
  EXPECT_NEAR(plan.estimate_variance.short_history_length, 6 - 1e-3f, 1e-6f);
  EXPECT_EQ(plan.estimate_variance.least_evidence, 0.0f);
  EXPECT_EQ(plan.prefilter_variance.short_history_blur, 0.0f);
  EXPECT_EQ(plan.prefilter_variance.sigma_l, 3.0f);
  EXPECT_EQ(plan.atrous.edges.sigma_n, 64.0f);
  EXPECT_EQ(plan.atrous.edges.depth_weight_plane, 1);
  EXPECT_EQ(plan.atrous.noise_ratio, 1.5f);
  EXPECT_EQ(plan.atrous.grows, 0);
  EXPECT_EQ(plan.tonemap.exposure_scale, 8.0f);
  EXPECT_EQ(plan.tonemap.tonemap, 2);
  EXPECT_EQ(plan.tonemap.frame, 7u);
  s.short_history = ShortHistory::kBlur;
  EXPECT_NEAR(MakePlan(s, UsualFacts(), kLater).prefilter_variance.short_history_blur, 6 - 1e-3f,
              1e-6f);
}

TEST(Plan, SparseFrames) {
  FrameFacts facts = UsualFacts();
  facts.samples_per_pixel = 1.0f - 1e-6f;  // one but for rounding
  EXPECT_FALSE(MakePlan(Settings(), facts, kLater).is_sparse);
  facts.samples_per_pixel = 0.99f;
  const FramePlan plan = MakePlan(Settings(), facts, kLater);
  EXPECT_TRUE(plan.is_sparse);
  EXPECT_TRUE(plan.runs.fxaa);
  EXPECT_EQ(plan.atrous.grows, 1);
  EXPECT_NEAR(plan.estimate_variance.least_evidence, 4 - 1e-3f, 1e-6f);
}

TEST(Plan, MovingLightIsMeasuredWhereLightIsCorrectedAndFramesAreDense) {
  FrameFacts facts = UsualFacts();
  Settings s;
  EXPECT_TRUE(MakePlan(s, facts, kLater).runs.find_moving_light);
  EXPECT_FALSE(MakePlan(s, facts, SequenceProgress()).runs.find_moving_light);
  s.correct_history = false;
  EXPECT_FALSE(MakePlan(s, facts, kLater).runs.find_moving_light);
  s = Settings();
  s.limit_history = false;
  EXPECT_FALSE(MakePlan(s, facts, kLater).runs.find_moving_light);
  facts.samples_per_pixel = 0.99f;
  EXPECT_FALSE(MakePlan(Settings(), facts, kLater).runs.find_moving_light);
}

TEST(Plan, SamplesAreKeptWhereTheirNoiseIsKnown) {
  FrameFacts facts = UsualFacts();
  facts.samples_per_pixel = 4;
  EXPECT_FALSE(MakePlan(Settings(), facts, kLater).runs.keep_samples);
  facts.second_moments = 1u << static_cast<uint32_t>(SignalKind::kDirectDiffuse) |
                         1u << static_cast<uint32_t>(SignalKind::kDirectSpecular);
  const FramePlan plan = MakePlan(Settings(), facts, kLater);
  EXPECT_TRUE(plan.runs.keep_samples);
  EXPECT_EQ(plan.keep_samples.kept_signals, 5);
  for (const char* preset : {"svgf", "psvgf", "eaw", "temporal"}) {
    EXPECT_FALSE(MakePlan(Preset(preset), facts, kLater).runs.keep_samples) << preset;
  }
  facts.samples_per_pixel = 1;
  EXPECT_FALSE(MakePlan(Settings(), facts, kLater).runs.keep_samples);
}

TEST(Plan, TheToleranceOfLuminanceFallsWithTheSamples) {
  FrameFacts facts = UsualFacts();
  const auto tolerance = [&](const Settings& s, float samples) {
    facts.samples_per_pixel = samples;
    return MakePlan(s, facts, kLater).prefilter_variance.sigma_l;
  };
  const Settings s;
  EXPECT_EQ(tolerance(s, 1), s.sigma_l);
  EXPECT_EQ(tolerance(s, 0.25f), s.sigma_l);
  EXPECT_FLOAT_EQ(tolerance(s, 8), s.sigma_l / 2);
  EXPECT_FLOAT_EQ(tolerance(s, 64), s.sigma_l / 4);
  EXPECT_EQ(tolerance(Preset("svgf"), 64), Preset("svgf").sigma_l);
  EXPECT_EQ(tolerance(Preset("psvgf"), 64), Preset("psvgf").sigma_l);
}

TEST(Plan, TheToleranceOfVolumesFallsLessWithTheSamples) {
  FrameFacts facts = UsualFacts();
  facts.lights |= 1u << static_cast<uint32_t>(SignalKind::kDirectTransmission);
  const auto of = [&](const Settings& s, float samples) {
    facts.samples_per_pixel = samples;
    return MakePlan(s, facts, kLater).prefilter_variance;
  };
  EXPECT_EQ(of(Settings(), 1).volume_signals, 8);  // after the three of the test above
  EXPECT_EQ(of(Settings(), 1).volume_widening, 1);
  EXPECT_FLOAT_EQ(of(Settings(), 64).volume_widening, 2);
  EXPECT_EQ(of(Preset("svgf"), 64).volume_widening, 1);
  EXPECT_EQ(of(Preset("psvgf"), 64).volume_signals, 0);  // one signal of all light
}

TEST(Plan, ReflectedLightKeepsItsBrightnessUnderGuidesOfImages) {
  const Settings s = Preset("default");
  FrameFacts facts = UsualFacts();
  const auto plan = [&] { return MakePlan(s, facts, kLater); };
  // Signals of default: direct diffuse, indirect diffuse, specular light.
  EXPECT_EQ(plan().restore_energy.energy_signals, 0b010);
  EXPECT_EQ(plan().restore_energy.image_signals, 0);
  facts.has_reflection = true;
  EXPECT_EQ(plan().restore_energy.energy_signals, 0b110);
  EXPECT_EQ(plan().restore_energy.image_signals, 0b100);
  const FramePlan of_layer = PlanOfLayer(plan(), plan().layers.layer[1]);
  EXPECT_EQ(of_layer.restore_energy.energy_signals, 1);
  EXPECT_EQ(of_layer.restore_energy.image_signals, 1);
  // A layer that a device denoises as a frame of its own.
  facts.has_reflection = false;
  facts.lights = 0b1100;
  const FramePlan alone = MakePlan(SettingsOfLayer(s), facts, kLater);
  EXPECT_EQ(alone.restore_energy.image_signals, 1);
  EXPECT_EQ(MakePlan(Preset("svgf"), facts, kLater).restore_energy.energy_signals, 0);
}

TEST(Plan, SignalsOfMirrors) {
  FrameFacts facts = UsualFacts();  // direct diffuse, indirect diffuse, specular
  EXPECT_EQ(MakePlan(Settings(), facts, kLater).keep_mirrors.mirror_signals, 4);
  facts.lights = 1u << static_cast<uint32_t>(SignalKind::kDirectDiffuse) |
                 1u << static_cast<uint32_t>(SignalKind::kIndirectDiffuse);
  EXPECT_EQ(MakePlan(Settings(), facts, kLater).keep_mirrors.mirror_signals, 0);
  facts.lights |= 1u << static_cast<uint32_t>(SignalKind::kDirectTransmission);
  const FramePlan plan = MakePlan(Settings(), facts, kLater);
  EXPECT_EQ(plan.signals.size(), 4u);
  EXPECT_EQ(plan.keep_mirrors.mirror_signals, 8);
}

/// Levels that are fed back, frame by frame, of frames with so many samples per pixel.
std::vector<int> FeedbackLevels(const Settings& s, float samples, int frames,
                                std::vector<float>* phases = nullptr) {
  FrameFacts facts = UsualFacts();
  facts.samples_per_pixel = samples;
  SequenceProgress progress;
  std::vector<int> levels;
  for (int i = 0; i < frames; ++i) {
    const FramePlan plan = MakePlan(s, facts, progress);
    levels.push_back(plan.feedback_level);
    EXPECT_EQ(plan.after.fed_back, plan.feedback_level != 0);
    if (phases != nullptr) {
      phases->push_back(plan.feedback_phase);
    }
    progress = plan.after;
  }
  return levels;
}

TEST(Plan, FeedbackOncePerSample) {
  Settings s = Preset("psvgf");
  EXPECT_EQ(FeedbackLevels(s, 1, 3), (std::vector<int>{5, 5, 5}));
  std::vector<float> phases;
  EXPECT_EQ(FeedbackLevels(s, 0.25f, 9, &phases), (std::vector<int>{0, 0, 0, 5, 0, 0, 0, 5, 0}));
  EXPECT_EQ(phases, (std::vector<float>{0.25f, 0.5f, 0.75f, 1, 0.25f, 0.5f, 0.75f, 1, 0.25f}));
  EXPECT_TRUE(MakePlan(s, UsualFacts(), kLater).layout.with_behind);
  s.feedback_when = FeedbackWhen::kFrame;
  EXPECT_EQ(FeedbackLevels(s, 0.25f, 3), (std::vector<int>{5, 5, 5}));
  EXPECT_FALSE(MakePlan(s, UsualFacts(), kLater).layout.with_behind);
  s.temporal = false;
  EXPECT_EQ(FeedbackLevels(s, 1, 2), (std::vector<int>{0, 0}));
}

TEST(Plan, TheFutureIsNotFedBack) {
  FrameFacts facts = UsualFacts();
  facts.samples_per_pixel = 0.5f;
  facts.has_future = true;
  const FramePlan plan = MakePlan(Preset("svgf"), facts, kLater);
  EXPECT_EQ(plan.feedback_level, 0);
  EXPECT_EQ(plan.feedback_phase, 1.0f);
  EXPECT_FALSE(plan.after.fed_back);
  EXPECT_EQ(plan.after.feedback_progress, 0.5f);
}

TEST(Plan, HowASequenceGoesOn) {
  const Settings s;
  FrameFacts facts = UsualFacts();
  facts.jitter_x = 0;
  FramePlan plan = MakePlan(s, facts, SequenceProgress());
  EXPECT_FALSE(plan.runs.reproject);
  EXPECT_FALSE(plan.runs.antialias);  // auto: nothing was jittered so far
  EXPECT_TRUE(plan.after.has_history);
  EXPECT_FALSE(plan.after.has_picture);
  facts.jitter_x = 0.25f;
  plan = MakePlan(s, facts, plan.after);
  EXPECT_TRUE(plan.runs.reproject);
  EXPECT_TRUE(plan.runs.antialias);
  EXPECT_FALSE(plan.has_picture);  // the first one
  facts.jitter_x = 0;
  plan = MakePlan(s, facts, plan.after);
  EXPECT_TRUE(plan.has_picture);
  facts.is_backward = true;
  plan = MakePlan(s, facts, plan.after);
  EXPECT_FALSE(plan.after.has_picture);
  EXPECT_TRUE(plan.after.has_history);
  EXPECT_FALSE(MakePlan(Preset("eaw"), facts, kLater).after.has_history);
}

TEST(Plan, WhichSettingsBeginTheHistoryAnew) {
  const auto resets = [](const char* name, const char* value, Settings before = Settings()) {
    Settings after = before;
    EXPECT_TRUE(SetParameter(&after, name, value).ok());
    return NeedsNewHistory(before, after);
  };
  EXPECT_TRUE(resets("normals", "octahedral"));
  EXPECT_TRUE(resets("signals", "single"));
  EXPECT_TRUE(resets("demodulate", "off"));
  EXPECT_TRUE(resets("limit_history", "off"));
  EXPECT_TRUE(resets("luminance", "rec601"));
  EXPECT_TRUE(resets("firefly", "compress"));
  EXPECT_FALSE(resets("firefly", "clamp"));
  EXPECT_TRUE(resets("feedback", "1"));
  EXPECT_FALSE(resets("feedback", "1", Preset("svgf")));
  EXPECT_TRUE(resets("feedback_when", "frame", Preset("psvgf")));
  EXPECT_FALSE(resets("feedback_when", "frame"));  // there is no feedback
  EXPECT_FALSE(resets("sigma_l", "7"));
  EXPECT_FALSE(resets("wavelet", "off"));
}

TEST(Plan, TheTableNamesEverySettingThatBeginsTheHistoryAnew) {
  for (const Parameter& p : Parameters()) {
    const std::string name = p.name;
    const bool expected = name == "normals" || name == "signals" || name == "demodulate" ||
                          name == "firefly" || name == "temporal" || name == "limit_history" ||
                          name == "wavelet" || name == "feedback" || name == "feedback_when" ||
                          name == "luminance";
    EXPECT_EQ(*p.resets_history != 0, expected) << name;
  }
}

}  // namespace
}  // namespace stillray::plan_test

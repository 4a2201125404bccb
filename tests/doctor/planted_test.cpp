// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Faults planted into frames of our own path tracer: each is named, and nothing else is.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "core/colour_shared.h"
#include "doctor/sequences.h"

namespace stillray::planted_test {
namespace {

using Names = std::set<std::string>;

struct Fault {
  const char* name;
  std::function<void(Sequence*)> plant;
  Names expected;
};

float Negated(float v, int, int) {
  return -v;
}

Change Times(float factor) {
  return [factor](float v, int, int) { return v * factor; };
}

/// In one frame.
void InFrame(Sequence* s, size_t at, const std::function<void(Sequence*)>& plant) {
  Sequence one = {std::move((*s)[at])};
  plant(&one);
  (*s)[at] = std::move(one[0]);
}

/// Guides of a place up to three pixels off, another one in every frame, as a lens or fog has them.
/// \param holes  half of the pixels show no surface at all
void RandomHits(Sequence* s, const std::function<bool(int, int)>& where, bool holes) {
  for (NumberedImage& f : *s) {
    const ExrImage original = f.image;
    for (Channel& channel : f.image.channels) {
      const bool guide = channel.name.starts_with("albedo.") ||
                         channel.name.starts_with("normal.") || channel.name == "depth.Z";
      for (int y = 0; guide && y < f.image.height; ++y) {
        for (int x = 0; x < f.image.width; ++x) {
          if (!where(x, y)) {
            continue;
          }
          const auto off = [&](int channel_of, int at, int size) {
            const float shift = 3.5f * NoiseAt(x, y, f.number, channel_of);
            return std::clamp(at + static_cast<int>(std::lround(shift)), 0, size - 1);
          };
          const bool hole = holes && NoiseAt(x, y, f.number, 9) > 0;
          channel.values(x, y) = original.Find(channel.name)
                                     ->values(off(7, x, f.image.width), off(8, y, f.image.height));
          if (hole && !channel.name.starts_with("albedo.")) {
            channel.values(x, y) = channel.name == "depth.Z" ? INFINITY : 0.0f;
          }
        }
      }
    }
  }
}

/// An object that half of the paths pass: its colour is that of the surface hit, weighted up.
void HalfTransparent(Sequence* s) {
  for (NumberedImage& f : *s) {
    for (const char* name : {"albedo.R", "albedo.G", "albedo.B"}) {
      Image1& values = ChannelOf(f.image, name).values;
      for (int y = 30; y < 80; ++y) {
        for (int x = 60; x < 120; ++x) {
          values(x, y) = NoiseAt(x, y, f.number, 3) > 0 ? 1.3f : 0.15f;
        }
      }
    }
  }
}

const Fault kFaults[] = {
    {"clean", [](Sequence*) {}, {}},
    {"motion_negated",
     [](Sequence* s) { ChangeLayer(s, "motion.", Negated); },
     {"motion_direction"}},
    {"motion_y_up",
     [](Sequence* s) { ChangeChannel(s, "motion.Y", Negated); },
     {"motion_y_flipped"}},
    {"motion_x", [](Sequence* s) { ChangeChannel(s, "motion.X", Negated); }, {"motion_x_flipped"}},
    {"motion_swapped",
     [](Sequence* s) { SwapChannels(s, "motion.X", "motion.Y"); },
     {"motion_swapped"}},
    {"motion_uv",
     [](Sequence* s) {
       ChangeChannel(s, "motion.X", Times(1.0f / 192));
       ChangeChannel(s, "motion.Y", Times(1.0f / 108));
     },
     {"motion_fraction"}},
    {"motion_half", [](Sequence* s) { ChangeLayer(s, "motion.", Times(0.5f)); }, {"motion_scaled"}},
    {"motion_double", [](Sequence* s) { ChangeLayer(s, "motion.", Times(2)); }, {"motion_scaled"}},
    {"motion_zero", [](Sequence* s) { ChangeLayer(s, "motion.", Times(0)); }, {"motion_zero"}},
    {"normal_encoded",
     [](Sequence* s) {
       ChangeLayer(s, "normal.", [](float v, int, int) { return 0.5f * v + 0.5f; });
     },
     {"normal_encoded"}},
    {"normal_zero", [](Sequence* s) { ChangeLayer(s, "normal.", Times(0)); }, {"normal_zero"}},
    {"normal_long", [](Sequence* s) { ChangeLayer(s, "normal.", Times(1.5f)); }, {"normal_length"}},
    {"depth_projected",
     [](Sequence* s) {
       ChangeLayer(s, "depth.", [](float v, int, int) { return 1.001f * (1 - 0.05f / v); });
     },
     {"depth_projected"}},
    {"depth_inverse",
     [](Sequence* s) { ChangeLayer(s, "depth.", [](float v, int, int) { return 1 / v; }); },
     {"depth_reversed"}},
    {"depth_range",
     [](Sequence* s) {
       ChangeLayer(s, "depth.", [](float v, int, int) { return (v - 0.2f) / 60; });
     },
     {"depth_normalised"}},
    {"depth_constant",
     [](Sequence* s) { ChangeLayer(s, "depth.", [](float, int, int) { return 1.0f; }); },
     {"depth_constant"}},
    {"depth_negative", [](Sequence* s) { ChangeLayer(s, "depth.", Negated); }, {"depth_negative"}},
    {"albedo_gain", [](Sequence* s) { ChangeLayer(s, "albedo.", Times(4)); }, {"albedo_above_one"}},
    {"albedo_encoded",
     [](Sequence* s) {
       ChangeLayer(s, "albedo.", [](float v, int, int) { return SrgbEncode(v); });
     },
     {"albedo_encoded"}},
    {"albedo_black", [](Sequence* s) { ChangeLayer(s, "albedo.", Times(0)); }, {"albedo_black"}},
    {"albedo_missing", [](Sequence* s) { RemoveLayer(s, "albedo."); }, {"albedo_missing"}},
    {"nan_block",
     [](Sequence* s) {
       InFrame(s, 1, [](Sequence* one) {
         ChangeLayer(one, "indirect_diffuse.", [](float v, int x, int y) {
           return x >= 40 && x < 48 && y >= 20 && y < 28 ? std::nanf("") : v;
         });
       });
     },
     {"not_finite"}},
    {"nan_depth",
     [](Sequence* s) { ChannelOf((*s)[1].image, "depth.Z").values(3, 4) = std::nanf(""); },
     {"not_finite"}},
    {"negative",
     [](Sequence* s) {
       InFrame(s, 2, [](Sequence* one) {
         ChangeLayer(one, "direct_specular.", [](float v, int x, int) { return x == 9 ? -1 : v; });
       });
     },
     {"negative_light"}},
    {"rounding_below_zero",
     [](Sequence* s) {
       for (const char* l : {"direct_specular.", "indirect_diffuse."}) {
         ChangeLayer(s, l, [](float v, int, int) { return v == 0 ? -1e-6f : v; });
       }
     },
     {}},
    {"dwaa",
     [](Sequence* s) {
       for (NumberedImage& frame : *s) {
         frame.image.compression_name = "dwaa";
       }
     },
     {"lossy_compression"}},
    {"pxr24",
     [](Sequence* s) {
       for (NumberedImage& frame : *s) {
         frame.image.compression_name = "pxr24";
       }
     },
     {}},
    {"exposure",
     [](Sequence* s) {
       for (size_t i = 1; i < s->size(); i += 2) {
         InFrame(s, i, [](Sequence* one) {
           ChangeLayer(one, "direct_", Times(1.5f));
           ChangeLayer(one, "indirect_", Times(1.5f));
           ChangeLayer(one, "emission.", Times(1.5f));
           ChangeLayer(one, "background.", Times(1.5f));
           for (const char* c : {"R", "G", "B"}) {
             ChangeChannel(one, c, Times(1.5f));
           }
         });
       }
     },
     {"exposure_changes"}},
    {"colour_encoded",
     [](Sequence* s) {
       for (const char* c : {"R", "G", "B"}) {
         ChangeChannel(s, c, [](float v, int, int) { return SrgbEncode(v); });
       }
     },
     {"light_encoded"}},
    {"pass_lost",
     [](Sequence* s) { ChangeLayer(s, "indirect_diffuse.", Times(0.1f)); },
     {"passes_do_not_add_up"}},
    {"lens",
     [](Sequence* s) {
       RandomHits(
           s, [](int x, int y) { return x < 100 && y > 30; }, false);
     },
     {"first_hits_random"}},
    {"fog",
     [](Sequence* s) {
       RandomHits(
           s, [](int, int) { return true; }, true);
     },
     {"first_hits_random"}},
    {"half_transparent", HalfTransparent, {"first_hits_random"}},
    {"frame_missing", [](Sequence* s) { s->erase(s->begin() + 2); }, {"frames_missing"}},
    {"frame_repeated", [](Sequence* s) { (*s)[2].image = (*s)[1].image; }, {"frames_repeated"}},
    {"layer_lost",
     [](Sequence* s) { InFrame(s, 2, [](Sequence* one) { RemoveLayer(one, "albedo."); }); },
     {"layers_change"}},
    {"ids",
     [](Sequence* s) {
       for (NumberedImage& f : *s) {
         Plane<uint32_t>& id = ChannelOf(f.image, "id.X").integers;
         for (int y = 0; y < id.height(); ++y) {
           for (int x = 0; x < id.width(); ++x) {
             id(x, y) += 100 * static_cast<uint32_t>(f.number);
           }
         }
       }
     },
     {"id_unstable"}},
};

class PlantedFaults : public ::testing::TestWithParam<Fault> {};

TEST_P(PlantedFaults, IsNamedAndNothingElse) {
  Sequence sequence = RenderSequence({.width = 192, .height = 108});
  GetParam().plant(&sequence);
  EXPECT_EQ(FindingsOf(sequence), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(All, PlantedFaults, ::testing::ValuesIn(kFaults),
                         [](const auto& info) { return std::string(info.param.name); });

struct CleanScene {
  const char* name;
  SceneOptions options;
};
const CleanScene kCleanScenes[] = {
    {"cornell", {.scene = "cornell"}},
    {"cornell_centred", {.scene = "cornell", .jitter = false}},
    {"spheres", {.scene = "spheres"}},
    {"spheres_slow", {.scene = "spheres", .step = 1.0 / 30}},
    {"lights_slow", {.scene = "lights", .start = 2, .step = 1.0 / 30}},
    {"lights_centred", {.scene = "lights", .jitter = false}},
    {"mirrors", {.scene = "mirrors", .step = 1.0 / 30, .virtual_guides = true}},
    {"mirrors_fast", {.scene = "mirrors", .step = 0.1, .virtual_guides = true}},
    {"rough_reflections", {.virtual_guides = true}},
    {"cornell_4_spp", {.scene = "cornell", .spp = 4}},
    // A still camera and still things: the animation has not begun to matter.
    {"still", {.scene = "spheres", .step = 0}},
    {"lights_averaged", {.scene = "lights", .averaged = true}},
    {"lights_averaged_slow", {.scene = "lights", .step = 1.0 / 24, .averaged = true}},
    {"spheres_averaged", {.scene = "spheres", .averaged = true}},
    {"cornell_averaged", {.scene = "cornell", .averaged = true}},
    {"still_averaged", {.scene = "lights", .step = 0, .averaged = true}},
    {"one_frame", {.scene = "lights", .frames = 1}},
};
class CleanScenes : public ::testing::TestWithParam<CleanScene> {};

TEST_P(CleanScenes, GiveNoFinding) {
  EXPECT_EQ(FindingsOf(RenderSequence(GetParam().options)), Names());
}

INSTANTIATE_TEST_SUITE_P(All, CleanScenes, ::testing::ValuesIn(kCleanScenes),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(ImagesInMirrors, WrongDepthAndMotionAreNamed) {
  const Sequence clean = RenderSequence(
      {.scene = "mirrors", .width = 192, .height = 108, .step = 0.1, .virtual_guides = true});
  Sequence sequence = clean;
  ChangeChannel(&sequence, "reflection_depth.Z", Times(0.5f));
  EXPECT_EQ(FindingsOf(sequence), Names{"image_depth_nearer"});
  sequence = clean;
  ChangeLayer(&sequence, "reflection_motion.", Negated);
  EXPECT_EQ(FindingsOf(sequence), Names{"image_motion_wrong"});
  // Motion that the renderer writes for reflections alone is examined, too.
  for (NumberedImage& f : sequence) {
    for (Channel& channel : f.image.channels) {
      if (channel.name.starts_with("reflection_motion.")) {
        channel.name.replace(0, std::string("reflection").size(), "specular");
      }
    }
  }
  EXPECT_EQ(FindingsOf(sequence, {"auto", {"specular_motion=specular_motion"}}),
            Names{"image_motion_wrong"});
  sequence = clean;
  for (NumberedImage& f : sequence) {
    f.image.Add("hits.Z", PixelType::kFloat, Image1(f.image.width, f.image.height));
  }
  EXPECT_EQ(FindingsOf(sequence, {"auto", {"reflection_depth=none", "hit_distance=hits"}}),
            Names{"hit_distance_zero"});
  sequence = clean;
  ChangeChannel(&sequence, "reflection_albedo.G",
                [](float v, int x, int y) { return x == 60 && y == 30 ? std::nanf("") : v; });
  EXPECT_EQ(FindingsOf(sequence), Names{"not_finite"});
}

TEST(Confidence, OutsideItsRangeIsNamed) {
  Sequence sequence =
      RenderSequence({.width = 192, .height = 108, .step = 0.1, .virtual_guides = true});
  const auto planted = [&](float value) {
    Sequence with = sequence;
    for (NumberedImage& f : with) {
      Image1 confidence(f.image.width, f.image.height);
      confidence.Fill(0.5f);
      confidence(60, 30) = value;
      f.image.Add("confidence.X", PixelType::kFloat, confidence);
    }
    return FindingsOf(with);
  };
  EXPECT_EQ(planted(0), Names{});
  EXPECT_EQ(planted(1), Names{});
  EXPECT_EQ(planted(1.5f), Names{"confidence_range"});
  EXPECT_EQ(planted(-0.25f), Names{"confidence_range"});
  EXPECT_EQ(planted(std::nanf("")), Names{"not_finite"});
}

TEST(FixedSeed, IsNamedWhereTheCameraMoves) {
  EXPECT_EQ(FindingsOf(RenderSequence(
                {.width = 192, .height = 108, .step = 0.1, .jitter = false, .fixed_seed = true})),
            Names{"fixed_seed"});
}

TEST(FirstHits, TheRegionAndTheCauseAreNamed) {
  Sequence sequence = RenderSequence({.width = 192, .height = 108});
  HalfTransparent(&sequence);
  const DoctorReport report = ReportOf(sequence);
  ASSERT_EQ(report.findings.size(), 1u);
  const std::string& what = report.findings[0].what;
  EXPECT_NE(what.find("transparency or subsurface scattering"), std::string::npos) << what;
  // x 60 to 120, y 30 to 80: 14 % of the picture, in whole blocks of it 12 to 18 %.
  EXPECT_NEAR(report.findings[0].measured, 0.15, 0.06) << what;
  int x = 0;
  int y = 0;
  ASSERT_EQ(std::sscanf(what.substr(what.find("around")).c_str(), "around x %d, y %d", &x, &y), 2);
  EXPECT_NEAR(x, 90, 12);
  EXPECT_NEAR(y, 55, 12);
}

// Means over hairs have all lengths up to 1; a faulty scale has one.
TEST(NormalLengths, OfMeansAreNoFault) {
  const auto scaled = [](float least) {
    Sequence sequence = RenderSequence({.width = 192, .height = 108});
    ChangeLayer(&sequence, "normal.", [&](float v, int x, int y) {
      return v * (least + (0.85f - least) * (0.5f + 0.5f * NoiseAt(x, y, 0, 0)));
    });
    return FindingsOf(sequence).count("normal_length");
  };
  EXPECT_EQ(scaled(0.4f), 0u);
  EXPECT_EQ(scaled(0.85f), 1u);
}

// With 16 samples, which files of Cycles state, random guides cost little (docs/inputs.md).
TEST(FirstHits, AreNotReportedWithManySamples) {
  Sequence sequence = RenderSequence({.width = 192, .height = 108});
  HalfTransparent(&sequence);
  const auto with_samples = [&](const char* samples) {
    for (NumberedImage& f : sequence) {
      f.image.attributes["cycles.ViewLayer.samples"] = samples;
    }
    return FindingsOf(sequence);
  };
  EXPECT_EQ(with_samples("15"), Names{"first_hits_random"});
  EXPECT_EQ(with_samples("16"), Names{});  // nor what follows from it
}

// A lens that zooms in by 6 % a frame while motion holds that of the camera alone.
TEST(Zoom, IsNotBlamedOnTheUnitOfMotion) {
  constexpr float kStep = 0.94f;
  Sequence sequence = RenderSequence({.width = 192, .height = 108, .step = 1.0 / 60});
  for (NumberedImage& f : sequence) {
    const ExrImage original = f.image;
    const float scale = std::pow(kStep, static_cast<float>(f.number - 1));
    for (Channel& channel : f.image.channels) {
      const Channel& from = *original.Find(channel.name);
      const bool motion = channel.name.starts_with("motion.");
      for (int y = 0; y < f.image.height; ++y) {
        for (int x = 0; x < f.image.width; ++x) {
          const int px = static_cast<int>(std::lround(95.5f + scale * (x - 95.5f)));
          const int py = static_cast<int>(std::lround(53.5f + scale * (y - 53.5f)));
          if (channel.type == PixelType::kUint32) {
            channel.integers(x, y) = from.integers(px, py);
          } else {
            channel.values(x, y) = from.values(px, py) / (motion ? scale / kStep : 1.0f);
          }
        }
      }
    }
  }
  EXPECT_EQ(FindingsOf(sequence), Names{"motion_zoom"});
}

TEST(LightLayers, TheColourAloneIsNamed) {
  Sequence sequence = RenderSequence({.frames = 3});
  RemoveLayer(&sequence, "direct_");
  RemoveLayer(&sequence, "indirect_");
  EXPECT_EQ(FindingsOf(sequence), Names{"passes_missing"});
}

TEST(LightLayers, ASingleLayerIsOneFinding) {
  Sequence sequence = RenderSequence({.frames = 3});
  for (NumberedImage& f : sequence) {
    std::erase_if(f.image.channels,
                  [](const Channel& c) { return c.name.find('.') != std::string::npos; });
  }
  EXPECT_EQ(FindingsOf(sequence), Names{"single_layer"});
}

TEST(LightLayers, AViewLayerThatStaysNoisyIsNamed) {
  Sequence sequence = RenderSequence({.frames = 3});
  for (NumberedImage& f : sequence) {
    const std::vector<Channel> channels = f.image.channels;
    f.image.channels.clear();
    for (const char* view : {"Main.", "Ball."}) {
      for (Channel channel : channels) {
        // Blender's names: stillray's own have no view layers.
        for (const auto& [own, blender] : {std::pair("direct_diffuse.", "DiffDir."),
                                           {"indirect_diffuse.", "DiffInd."},
                                           {"albedo.", "DiffCol."},
                                           {"normal.", "Normal."},
                                           {"depth.", "Depth."}}) {
          if (channel.name.starts_with(own)) {
            channel.name =
                std::string(view) + blender + channel.name.substr(channel.name.find('.') + 1);
            f.image.channels.push_back(channel);
            break;
          }
        }
        if (channel.name.size() == 1) {
          channel.name = std::string(view) + "Combined." + channel.name;
          f.image.channels.push_back(channel);
        }
      }
    }
  }
  EXPECT_TRUE(FindingsOf(sequence).count("view_layer_left"));
  EXPECT_FALSE(FindingsOf(sequence, {"auto", {}, "Ball"}).count("view_layer_left"));
}

TEST(FixedSeed, IsNamedInAStillPicture) {
  EXPECT_EQ(FindingsOf(RenderSequence({.scene = "spheres", .step = 0, .fixed_seed = true})),
            Names{"fixed_seed"});
}

}  // namespace
}  // namespace stillray::planted_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Faults planted into frames of our own path tracer: each is named, and nothing else is.
#include <cmath>
#include <functional>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "core/colour_shared.h"
#include "doctor/sequences.h"

namespace stillray {
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

TEST(FixedSeed, IsNamedWhereTheCameraMoves) {
  EXPECT_EQ(FindingsOf(RenderSequence(
                {.width = 192, .height = 108, .step = 0.1, .jitter = false, .fixed_seed = true})),
            Names{"fixed_seed"});
}

TEST(FixedSeed, IsNamedInAStillPicture) {
  EXPECT_EQ(FindingsOf(RenderSequence({.scene = "spheres", .step = 0, .fixed_seed = true})),
            Names{"fixed_seed"});
}

}  // namespace
}  // namespace stillray

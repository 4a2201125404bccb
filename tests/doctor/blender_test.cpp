// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The doctor on a sequence that Blender rendered: nothing is wrong with it until it is spoilt.
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/colour_shared.h"
#include "doctor/sequences.h"
#include "stillray/io.h"

namespace stillray::blender_test {
namespace {

using Names = std::set<std::string>;

std::string Folder() {
  const char* folder = std::getenv("STILLRAY_TEST_DATA");
  return std::string(folder != nullptr ? folder : STILLRAY_DEFAULT_TEST_DATA) +
         "/sequences/blender_box";
}

Sequence LoadFrames(int first, int last) {
  Sequence sequence;
  for (int n = first; n <= last; ++n) {
    Result<ExrImage> image = ReadExr(FrameFileName(Folder() + "/frame_####.exr", n));
    EXPECT_TRUE(image.ok()) << image.status().message();
    sequence.push_back({n, std::move(image.value())});
  }
  return sequence;
}

Sequence LoadNative() {
  Sequence sequence;
  for (int n = 7; n <= 8; ++n) {
    Result<ExrImage> image = ReadExr(FrameFileName(Folder() + "/native_####.exr", n));
    EXPECT_TRUE(image.ok()) << image.status().message();
    sequence.push_back({n, std::move(image.value())});
  }
  return sequence;
}

const std::string kView = "ViewLayer.";

struct Fault {
  const char* name;
  std::function<void(Sequence*)> plant;
  Names expected;
};

float Negated(float v, int, int) {
  return -v;
}

void AddNoise(Sequence* s, const std::string& layer, float size) {
  for (NumberedImage& frame : *s) {
    Sequence one = {{frame.number, std::move(frame.image)}};
    int channel = 0;
    for (const char* letter : {"R", "G", "B", "X", "Y", "Z"}) {
      ++channel;
      if (one[0].image.Find(layer + letter) != nullptr) {
        ChangeChannel(&one, layer + letter, [&](float v, int x, int y) {
          const float noise = size * NoiseAt(x, y, frame.number, channel);
          return layer.ends_with("Depth.") ? v * (1 + noise) : v + noise;
        });
      }
    }
    frame.image = std::move(one[0].image);
  }
}

/// World normals in the axes of the camera: x right, y up, z towards the viewer.
void ToCameraSpace(Sequence* s) {
  std::ifstream file(Folder() + "/cameras.json");
  const nlohmann::json cameras = nlohmann::json::parse(file);
  for (NumberedImage& f : *s) {
    const auto& m = cameras["camera_to_world"][std::to_string(f.number)];
    std::array<Image1*, 3> n;
    for (size_t c = 0; c < 3; ++c) {
      n[c] = &ChannelOf(f.image, kView + "Normal." + "XYZ"[c]).values;
    }
    for (int y = 0; y < f.image.height; ++y) {
      for (int x = 0; x < f.image.width; ++x) {
        const std::array<float, 3> world = {(*n[0])(x, y), (*n[1])(x, y), (*n[2])(x, y)};
        for (size_t c = 0; c < 3; ++c) {
          float sum = 0;
          for (size_t i = 0; i < 3; ++i) {
            sum += world[i] * m[i][c].get<float>();
          }
          (*n[c])(x, y) = sum;
        }
      }
    }
  }
}

const Fault kFaults[] = {
    {"clean", [](Sequence*) {}, {}},
    {"motion_negated",
     [](Sequence* s) {
       ChangeChannel(s, kView + "Vector.X", Negated);
       ChangeChannel(s, kView + "Vector.Y", Negated);
     },
     {"motion_direction"}},
    {"motion_to_next",
     [](Sequence* s) {
       ChangeChannel(s, kView + "Vector.Z", Negated);
       ChangeChannel(s, kView + "Vector.W", Negated);
       SwapChannels(s, kView + "Vector.X", kView + "Vector.Z");
       SwapChannels(s, kView + "Vector.Y", kView + "Vector.W");
     },
     {"motion_direction"}},
    {"motion_y",
     [](Sequence* s) { ChangeChannel(s, kView + "Vector.Y", Negated); },
     {"motion_y_flipped"}},
    {"motion_x",
     [](Sequence* s) { ChangeChannel(s, kView + "Vector.X", Negated); },
     {"motion_x_flipped"}},
    {"motion_swapped",
     [](Sequence* s) { SwapChannels(s, kView + "Vector.X", kView + "Vector.Y"); },
     {"motion_swapped"}},
    {"motion_uv",
     [](Sequence* s) {
       ChangeChannel(s, kView + "Vector.X", [](float v, int, int) { return v / 384; });
       ChangeChannel(s, kView + "Vector.Y", [](float v, int, int) { return v / 216; });
     },
     {"motion_fraction"}},
    {"motion_uv_down",
     [](Sequence* s) {
       ChangeChannel(s, kView + "Vector.X", [](float v, int, int) { return v / 384; });
       ChangeChannel(s, kView + "Vector.Y", [](float v, int, int) { return -v / 216; });
     },
     {"motion_fraction"}},
    {"motion_ndc",
     [](Sequence* s) {
       ChangeChannel(s, kView + "Vector.X", [](float v, int, int) { return v / 192; });
       ChangeChannel(s, kView + "Vector.Y", [](float v, int, int) { return v / 108; });
     },
     {"motion_ndc"}},
    {"motion_half",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Vector.", [](float v, int, int) { return v / 2; });
     },
     {"motion_scaled"}},
    {"motion_double",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Vector.", [](float v, int, int) { return v * 2; });
     },
     {"motion_scaled"}},
    {"motion_third",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Vector.", [](float v, int, int) { return v / 3; });
     },
     {"motion_scaled"}},
    {"motion_per_second",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Vector.", [](float v, int, int) { return v * 24; });
     },
     {"motion_wrong"}},
    {"light_of_one_frame",
     [](Sequence* s) {
       for (size_t i = 1; i < s->size(); ++i) {
         for (const Channel& c : (*s)[0].image.channels) {
           if (c.name.find("Dir.") != std::string::npos ||
               c.name.find("Ind.") != std::string::npos) {
             ChannelOf((*s)[i].image, c.name).values = c.values;
           }
         }
       }
     },
     {"fixed_seed"}},
    {"normals_of_the_camera", ToCameraSpace, {"normal_camera_space"}},
    {"motion_zero",
     [](Sequence* s) { ChangeLayer(s, kView + "Vector.", [](float, int, int) { return 0.0f; }); },
     {"motion_zero"}},
    {"motion_missing", [](Sequence* s) { RemoveLayer(s, kView + "Vector."); }, {"motion_missing"}},
    {"motion_offset",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Vector.",
                   [](float v, int, int) { return std::clamp(0.5f + v / 32, 0.0f, 1.0f); });
     },
     {"motion_wrong"}},
    {"normal_encoded",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Normal.", [](float v, int, int) { return 0.5f * v + 0.5f; });
     },
     {"normal_encoded"}},
    {"normal_zero",
     [](Sequence* s) { ChangeLayer(s, kView + "Normal.", [](float, int, int) { return 0.0f; }); },
     {"normal_zero"}},
    {"normal_long",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Normal.", [](float v, int, int) { return 2 * v; });
     },
     {"normal_length"}},
    {"normal_noise", [](Sequence* s) { AddNoise(s, kView + "Normal.", 0.2f); }, {"normal_noisy"}},
    {"albedo_noise", [](Sequence* s) { AddNoise(s, kView + "DiffCol.", 0.1f); }, {"albedo_noisy"}},
    {"depth_noise", [](Sequence* s) { AddNoise(s, kView + "Depth.", 0.05f); }, {"depth_noisy"}},
    {"depth_minmax",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Depth.", [](float v, int, int) { return (v - 1) / 9; });
     },
     {"depth_normalised"}},
    {"depth_max",
     [](Sequence* s) {
       for (NumberedImage& f : *s) {
         float most = 0;
         Sequence one = {{f.number, std::move(f.image)}};
         const Change find = [&](float v, int, int) {
           most = std::max(most, v);
           return v;
         };
         ChangeLayer(&one, kView + "Depth.", find);
         ChangeLayer(&one, kView + "Depth.", [&](float v, int, int) { return v / most; });
         f.image = std::move(one[0].image);
       }
     },
     {"depth_normalised"}},
    {"depth_projected",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Depth.",
                   [](float v, int, int) { return 100.0f / 99.9f * (1 - 0.1f / v); });
     },
     {"depth_projected"}},
    {"depth_reversed",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Depth.", [](float v, int, int) { return 0.1f / v; });
     },
     {"depth_reversed"}},
    {"depth_ray",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Depth.", [](float v, int x, int y) {
         const float dx = (static_cast<float>(x) - 191.5f) / 277.3333f;
         const float dy = (static_cast<float>(y) - 107.5f) / 277.3333f;
         return v * std::sqrt(1 + dx * dx + dy * dy);
       });
     },
     {"depth_ray"}},
    {"depth_root",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Depth.", [](float v, int, int) { return std::sqrt(v); });
     },
     {"depth_not_linear"}},
    {"depth_log",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Depth.", [](float v, int, int) { return std::log(1 + v); });
     },
     {"depth_not_linear"}},
    {"depth_constant",
     [](Sequence* s) { ChangeLayer(s, kView + "Depth.", [](float, int, int) { return 1e10f; }); },
     {"depth_constant"}},
    {"depth_negative",
     [](Sequence* s) { ChangeLayer(s, kView + "Depth.", Negated); },
     {"depth_negative"}},
    {"depth_missing", [](Sequence* s) { RemoveLayer(s, kView + "Depth."); }, {"depth_missing"}},
    {"albedo_above",
     [](Sequence* s) {
       ChangeLayer(s, kView + "DiffCol.", [](float v, int, int) { return 3 * v; });
     },
     {"albedo_above_one"}},
    {"albedo_black",
     [](Sequence* s) { ChangeLayer(s, kView + "DiffCol.", [](float, int, int) { return 0.0f; }); },
     {"albedo_black"}},
    {"albedo_missing",
     [](Sequence* s) {
       RemoveLayer(s, kView + "DiffCol.");
       RemoveLayer(s, kView + "DiffDir.");
       RemoveLayer(s, kView + "DiffInd.");
     },
     {"albedo_missing"}},
    {"nan_block",
     [](Sequence* s) {
       Sequence one = {{0, std::move((*s)[2].image)}};
       ChangeLayer(&one, kView + "DiffDir.", [](float v, int x, int y) {
         return x >= 100 && x < 116 && y >= 40 && y < 56 ? std::nanf("") : v;
       });
       (*s)[2].image = std::move(one[0].image);
     },
     {"not_finite"}},
    {"inf_pixel",
     [](Sequence* s) { ChannelOf((*s)[1].image, kView + "GlossInd.G").values(7, 9) = INFINITY; },
     {"not_finite"}},
    {"negative",
     [](Sequence* s) {
       ChangeLayer(s, kView + "DiffInd.", [](float v, int x, int) { return x % 16 == 0 ? -v : v; });
     },
     {"negative_light"}},
    {"clamped",
     [](Sequence* s) {
       for (const char* l : {"DiffDir.", "DiffInd.", "GlossDir.", "GlossInd."}) {
         ChangeLayer(s, kView + l, [](float v, int, int) { return std::min(v, 1.0f); });
       }
     },
     {"light_clamped"}},
    {"clamped_high",
     [](Sequence* s) {
       for (const char* l : {"DiffDir.", "DiffInd.", "GlossDir.", "GlossInd."}) {
         ChangeLayer(s, kView + l, [](float v, int, int) { return std::min(v, 2.0f); });
       }
     },
     {"light_clamped"}},
    {"tone_mapped",
     [](Sequence* s) {
       for (const char* l : {"DiffDir.", "DiffInd.", "GlossDir.", "GlossInd."}) {
         ChangeLayer(s, kView + l, [](float v, int, int) { return v / (1 + v); });
       }
     },
     {"light_tone_mapped"}},
    {"srgb_clipped",
     [](Sequence* s) {
       for (const char* l : {"DiffDir.", "DiffInd.", "GlossDir.", "GlossInd."}) {
         ChangeLayer(s, kView + l, [](float v, int, int) { return std::min(SrgbEncode(v), 1.0f); });
       }
     },
     {"light_clamped"}},
    {"exposure",
     [](Sequence* s) {
       for (NumberedImage& f : *s) {
         const float gain = std::exp2(0.5f * std::sin(1.7f * static_cast<float>(f.number)));
         Sequence one = {{f.number, std::move(f.image)}};
         for (const char* l : {"DiffDir.", "DiffInd.", "GlossDir.", "GlossInd."}) {
           ChangeLayer(&one, kView + l, [&](float v, int, int) { return v * gain; });
         }
         f.image = std::move(one[0].image);
       }
     },
     {"exposure_changes"}},
    {"frame_missing", [](Sequence* s) { s->erase(s->begin() + 3); }, {"frames_missing"}},
    {"frame_repeated", [](Sequence* s) { (*s)[3].image = (*s)[2].image; }, {"frames_repeated"}},
    {"size",
     [](Sequence* s) {
       Result<ExrImage> other = ReadExr(Folder() + "/native_0007.exr");
       (*s)[4].image = std::move(other.value());
     },
     {"size_changes"}},
    {"layer_lost",
     [](Sequence* s) {
       Sequence one = {{0, std::move((*s)[3].image)}};
       RemoveLayer(&one, kView + "GlossInd.");
       (*s)[3].image = std::move(one[0].image);
     },
     {"layers_change"}},
    {"ids",
     [](Sequence* s) {
       for (NumberedImage& f : *s) {
         Sequence one = {{f.number, std::move(f.image)}};
         ChangeLayer(&one, kView + "IndexOB.",
                     [&](float v, int, int) { return v + 30 * static_cast<float>(f.number % 3); });
         f.image = std::move(one[0].image);
       }
     },
     {"id_unstable"}},
};

class BlenderFaults : public ::testing::TestWithParam<Fault> {};

TEST_P(BlenderFaults, IsNamedAndNothingElse) {
  if (!std::filesystem::exists(Folder())) {
    GTEST_SKIP() << Folder()
                 << " does not exist; STILLRAY_TEST_DATA names the folder with sequences/";
  }
  Sequence sequence = LoadFrames(5, 10);
  GetParam().plant(&sequence);
  EXPECT_EQ(FindingsOf(sequence), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(All, BlenderFaults, ::testing::ValuesIn(kFaults),
                         [](const auto& info) { return std::string(info.param.name); });

struct NativeFault {
  const char* name;
  std::function<void(Sequence*)> plant;
  AovOptions options;
  Names expected;
};

const NativeFault kNativeFaults[] = {
    {"clean", [](Sequence*) {}, {}, {}},
    {"denoising_normals",
     [](Sequence*) {},
     {"auto", {"normal=Denoising Normal"}},
     {"normal_camera_space"}},
    {"denoising_depth", [](Sequence*) {}, {"auto", {"depth=Denoising Depth"}}, {"depth_ray"}},
    {"colour_encoded",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Combined.", [](float v, int, int) { return SrgbEncode(v); });
     },
     {},
     {"light_encoded"}},
    {"colour_without_passes",
     [](Sequence* s) { ChangeLayer(s, kView + "Gloss", [](float v, int, int) { return v; }); },
     {"auto", {"direct_specular=none", "indirect_specular=none", "specular_albedo=none"}},
     {"passes_missing"}},
    {"colour_tone_mapped",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Combined.", [](float v, int, int) { return v / (1 + v); });
     },
     {},
     {"light_tone_mapped"}},
    {"colour_darker",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Combined.", [](float v, int, int) { return 0.7f * v; });
     },
     {},
     {"passes_do_not_add_up"}},
    {"albedo_encoded",
     [](Sequence* s) {
       ChangeLayer(s, kView + "DiffCol.", [](float v, int, int) { return SrgbEncode(v); });
     },
     {},
     {"albedo_encoded"}},
    {"seen_depth",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Denoising Depth.", [](float v, int, int) { return 0.5f * v; });
     },
     {},
     {"seen_depth_differs"}},
    {"seen_albedo",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Denoising Albedo.", [](float v, int, int) { return 0.5f * v; });
     },
     {},
     {"seen_albedo_differs"}},
    {"seen_normal",
     [](Sequence* s) { AddNoise(s, kView + "Denoising Normal.", 0.3f); },
     {},
     {"seen_normal_differs"}},
    {"seen_nothing",
     [](Sequence* s) {
       ChangeLayer(s, kView + "Denoising Normal.", [](float, int, int) { return 0.0f; });
     },
     {},
     {"seen_zero"}},
};

class NativeFaults : public ::testing::TestWithParam<NativeFault> {};

TEST_P(NativeFaults, IsNamedAndNothingElse) {
  if (!std::filesystem::exists(Folder())) {
    GTEST_SKIP() << Folder()
                 << " does not exist; STILLRAY_TEST_DATA names the folder with sequences/";
  }
  Sequence sequence = LoadNative();
  GetParam().plant(&sequence);
  EXPECT_EQ(FindingsOf(sequence, GetParam().options), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(All, NativeFaults, ::testing::ValuesIn(kNativeFaults),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace stillray::blender_test

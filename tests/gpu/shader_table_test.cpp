// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The table of shaders against their compiled code and the pipelines of the library, and schedules
// of frames. None of it needs a device.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "denoise/shader_pack.h"
#include "denoise/vulkan/frame_shared.h"
#include "denoise/vulkan/shaders.h"
#include "gpu/spirv_interface.h"

namespace stillray::shader_table_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using vulkan::FrameParameters;
using vulkan::FrameState;

const ShaderTable& Table() {
  static const ShaderTable table = MakeShaderTable().value();
  return table;
}

const PackedShader& ShaderOf(const std::string& name) {
  const auto found = std::ranges::find(Table().shaders, name, &PackedShader::name);
  EXPECT_NE(found, Table().shaders.end()) << name;
  return *found;
}

/// The words of compiled code that this test looks at.
struct Scan {
  struct Variable {
    uint32_t storage = 0;
    uint32_t pointer = 0;
    std::string name;
    int set = -1;
    int binding = -1;
    bool is_used = false;  ///< in main, or in what it calls
  };
  std::map<uint32_t, Variable> variables;
  std::map<uint32_t, uint32_t> pointees;
  std::map<uint32_t, std::vector<uint32_t>> images;  ///< operands of OpTypeImage

  explicit Scan(std::span<const uint32_t> code) {
    std::map<uint32_t, std::set<uint32_t>> ids_of_function;  // variables, and what it calls
    uint32_t entry = 0;
    uint32_t function = 0;
    for (size_t at = 5; at < code.size(); at += code[at] >> 16) {
      const uint32_t op = code[at] & 0xffffu;
      const std::span<const uint32_t> o = code.subspan(at + 1, (code[at] >> 16) - 1);
      if (op == 15) {  // OpEntryPoint
        entry = o[1];
      } else if (op == 5) {  // OpName
        variables[o[0]].name = reinterpret_cast<const char*>(&o[1]);
      } else if (op == 71 && o[1] == 33) {  // OpDecorate Binding
        variables[o[0]].binding = static_cast<int>(o[2]);
      } else if (op == 71 && o[1] == 34) {  // OpDecorate DescriptorSet
        variables[o[0]].set = static_cast<int>(o[2]);
      } else if (op == 25) {  // OpTypeImage
        images[o[0]] = {o.begin(), o.end()};
      } else if (op == 32) {  // OpTypePointer
        pointees[o[0]] = o[2];
      } else if (op == 54) {  // OpFunction
        function = o[1];
      } else if (op == 59 && function == 0) {  // OpVariable
        variables[o[1]].storage = o[2];
        variables[o[1]].pointer = o[0];
      } else if (op == 61 || op == 65 || op == 66) {  // OpLoad, OpAccessChain
        ids_of_function[function].insert(o[2]);
      } else if (op == 57) {  // OpFunctionCall
        ids_of_function[function].insert(o.begin() + 2, o.end());
      }
    }
    std::set<uint32_t> ids = ids_of_function[entry];
    for (size_t before = 0; before != ids.size();) {
      before = ids.size();
      for (const auto& [called, of_called] : ids_of_function) {
        if (ids.contains(called)) {
          ids.insert(of_called.begin(), of_called.end());
        }
      }
    }
    for (auto& [id, variable] : variables) {
      variable.is_used = ids.contains(id);
    }
  }

  const std::vector<uint32_t>* ImageOf(const Variable& v) const {
    const auto found = images.find(pointees.at(v.pointer));
    return found != images.end() ? &found->second : nullptr;
  }
};

/// Formats of GLSL by their numbers in SPIR-V, and as formats of images.
struct Format {
  uint32_t number;
  const char* glsl;
  const char* vulkan;
};
constexpr Format kFormats[] = {{1, "rgba32f", "R32G32B32A32_SFLOAT"},
                               {2, "rgba16f", "R16G16B16A16_SFLOAT"},
                               {3, "r32f", "R32_SFLOAT"},
                               {4, "rgba8", "R8G8B8A8_UNORM"},
                               {6, "rg32f", "R32G32_SFLOAT"},
                               {9, "r16f", "R16_SFLOAT"},
                               {14, "r16", "R16_UNORM"},
                               {30, "rgba32ui", "R32G32B32A32_UINT"},
                               {33, "r32ui", "R32_UINT"},
                               {35, "rg32ui", "R32G32_UINT"}};

TEST(ShaderTable, HasEveryBindingOfTheCode) {
  size_t images = 0;
  for (const PackedShader& shader : Table().shaders) {
    const Scan scan(shader.code);
    size_t used = 0;
    for (const auto& [id, v] : scan.variables) {
      if (v.binding < 0 || !v.is_used) {
        continue;
      }
      ++used;
      const auto found = std::ranges::find_if(shader.bindings, [&](const PackBinding& b) {
        return static_cast<int>(b.set) == v.set && static_cast<int>(b.binding) == v.binding;
      });
      ASSERT_NE(found, shader.bindings.end())
          << shader.name << " " << v.set << "." << v.binding << " " << v.name;
      const std::vector<uint32_t>* image = scan.ImageOf(v);
      if (image == nullptr) {
        EXPECT_EQ(found->kind, v.storage == 2 ? "uniform_buffer" : "storage_buffer") << shader.name;
        continue;
      }
      ++images;
      const bool stored = (*image)[6] == 2;
      EXPECT_EQ(found->kind, stored ? "storage_image" : "sampled_image") << shader.name;
      EXPECT_EQ(found->is_array, (*image)[4] == 1) << shader.name << " " << found->name;
      EXPECT_EQ(found->writes, stored) << shader.name << " " << found->name;
      EXPECT_EQ(found->reads, !stored) << shader.name << " " << found->name;
      const auto* const format = std::ranges::find(kFormats, (*image)[7], &Format::number);
      EXPECT_EQ(found->format, stored ? format->glsl : "") << shader.name << " " << found->name;
      if (!v.name.empty()) {  // of code that is not optimised
        EXPECT_EQ(found->name, v.name) << shader.name;
      }
    }
    EXPECT_EQ(used, shader.bindings.size()) << shader.name;
  }
  EXPECT_GT(images, 500u);
}

/// The kind of a binding in a set, by the order of the pipelines' layouts.
std::string KindIn(const PackSet& set, uint32_t binding) {
  const std::pair<uint32_t, const char*> kinds[] = {{set.sampled_images, "sampled_image"},
                                                    {set.storage_images, "storage_image"},
                                                    {set.uniform_buffers, "uniform_buffer"},
                                                    {set.storage_buffers, "storage_buffer"}};
  for (const auto& [count, kind] : kinds) {
    if (binding < count) {
      return kind;
    }
    binding -= count;
  }
  return "none";
}

TEST(ShaderTable, HasTheLayoutsOfThePipelines) {
  for (const PackedShader& shader : Table().shaders) {
    for (const PackBinding& b : shader.bindings) {
      ASSERT_LT(b.set, shader.sets.size()) << shader.name;
      EXPECT_EQ(KindIn(shader.sets[b.set], b.binding), b.kind) << shader.name << " " << b.name;
      EXPECT_FALSE(b.name.empty()) << shader.name << " " << b.set << "." << b.binding;
    }
    uint32_t end = 0;
    for (const PackMember& m : shader.push) {
      end = std::max(end, m.offset + m.bytes);
      EXPECT_FALSE(m.name.empty()) << shader.name;
    }
    EXPECT_EQ(end, shader.push_bytes) << shader.name;
    for (const PackConstant& c : shader.constants) {
      EXPECT_FALSE(c.name.empty() || c.note.empty()) << shader.name << " " << c.id;
    }
    EXPECT_LE(shader.local_size[0] * shader.local_size[1], 256u) << shader.name;
  }
}

// Barriers follow from what the library's own table says of the frame's buffers.
TEST(ShaderTable, UsesOfTheFrameBuffersAreThoseOfTheBarriers) {
  for (size_t i = 0; i < vulkan::ShaderCount(); ++i) {
    const auto shader = static_cast<vulkan::Shader>(i);
    const vulkan::ShaderInfo& info = vulkan::InfoOf(shader);
    const PackedShader& packed = ShaderOf(vulkan::NameOf(shader) + std::string("Half"));
    EXPECT_EQ(packed.stage, info.stage);
    for (const auto& [block, use] :
         {std::pair{"FrameState", info.state}, std::pair{"Partials", info.partials}}) {
      const auto found = std::ranges::find(packed.bindings, block, &PackBinding::name);
      const bool is_used = found != packed.bindings.end();
      // What is read need not be written; the library's table may say that more happens than does.
      EXPECT_LE(is_used && found->writes, vulkan::Writes(use)) << packed.name << " " << block;
      EXPECT_LE(is_used, use != vulkan::Use::kNone) << packed.name << " " << block;
    }
  }
}

TEST(ShaderTable, HasEveryShaderOnce) {
  std::set<std::string> names;
  for (const PackedShader& shader : Table().shaders) {
    names.insert(shader.name);
  }
  constexpr size_t kSurfaceWriters = 4;  // twice more
  constexpr size_t kOfLayers = 4;        // of floats alone
  EXPECT_EQ(names.size(), 2 * vulkan::ShaderCount() + 2 * kSurfaceWriters + kOfLayers);
  EXPECT_EQ(names.size(), Table().shaders.size());
  EXPECT_EQ(ShaderOf("PrepareGuidesHalf").normals, "octahedral");
  EXPECT_EQ(ShaderOf("PrepareGuidesHalfPlain").normals, "plain");
  EXPECT_EQ(ShaderOf("PrepareGuidesFloatOctahedral").normals, "octahedral");
  EXPECT_EQ(ShaderOf("PrepareGuidesFloat").normals, "plain");
  EXPECT_EQ(ShaderOf("AccumulateFloat").normals, "any");
  EXPECT_EQ(ShaderOf("AddLayer").precision, "any");
}

TEST(ShaderTable, ParametersAreWhereTheLibraryHasThem) {
  const auto block = std::ranges::find(Table().blocks, "FrameParameters", &PackBlock::name);
  ASSERT_NE(block, Table().blocks.end());
  const auto offset_of = [&](const char* name) {
    const auto member = std::ranges::find(block->members, name, &PackMember::name);
    EXPECT_NE(member, block->members.end()) << name;
    return member != block->members.end() ? member->offset : ~0u;
  };
  EXPECT_EQ(offset_of("width"), offsetof(FrameParameters, width));
  EXPECT_EQ(offset_of("measure_stride"), offsetof(FrameParameters, measure_stride));
  EXPECT_EQ(offset_of("feedback_phase"), offsetof(FrameParameters, feedback_phase));
  EXPECT_EQ(offset_of("ghost_stamp"), offsetof(FrameParameters, ghost_stamp));
  EXPECT_EQ(offset_of("limit_history.jitter_y"),
            offsetof(FrameParameters, limit_history) + offsetof(LimitHistoryParameters, jitter_y));
  EXPECT_EQ(offset_of("compared.edges.sigma_n"), offsetof(FrameParameters, compared));
  EXPECT_EQ(offset_of("atrous.edges.centre_y"),
            offsetof(FrameParameters, atrous) + offsetof(EdgeStopping, centre_y));
  EXPECT_EQ(offset_of("atrous.reflected_signals"),
            offsetof(FrameParameters, atrous) + offsetof(AtrousParameters, reflected_signals));
  EXPECT_EQ(offset_of("tonemap.frame"),
            offsetof(FrameParameters, tonemap) + offsetof(TonemapParameters, frame));
  // Members follow each other; only structures begin at multiples of 16 bytes.
  uint32_t end = 0;
  for (const PackMember& m : block->members) {
    EXPECT_EQ(m.bytes, 4u) << m.name;
    EXPECT_TRUE(m.offset == end || (m.offset % 16 == 0 && m.offset - end < 16)) << m.name;
    end = m.offset + m.bytes;
  }
  EXPECT_EQ((end + 15) / 16 * 16, sizeof(FrameParameters));
}

TEST(ShaderTable, StateIsWhereTheLibraryHasIt) {
  const auto block = std::ranges::find(Table().blocks, "FrameState", &PackBlock::name);
  ASSERT_NE(block, Table().blocks.end());
  const PackMember& last = block->members.back();
  EXPECT_EQ(last.name, "guides_move");
  EXPECT_EQ(last.offset, offsetof(FrameState, guides_move));
  EXPECT_EQ(last.offset + last.bytes, sizeof(FrameState));
  EXPECT_EQ(block->members.front().type, "float[4]");
}

// docs/gpu.md: 20 + 12 n bytes per texel of 20x12, 4 n more with a pilot estimate.
TEST(ShaderTable, SharedMemoryOfTilesIsThatOfTheDocument) {
  const PackedShader& tile = ShaderOf("AtrousTileHalf");
  for (const uint32_t signals : {1u, 3u}) {
    const Result<gpu::ShaderInterface> read =
        gpu::ReadInterface(tile.code, {{1, signals}, {3, 2}, {4, 0}, {8, 1}});
    ASSERT_TRUE(read.ok()) << read.status().message();
    EXPECT_EQ(read->shared_bytes, 20u * 12 * (20 + 12 * signals) + 4);
    const Result<gpu::ShaderInterface> with_pilot =
        gpu::ReadInterface(tile.code, {{1, signals}, {3, 2}, {4, 1}, {8, 1}});
    ASSERT_TRUE(with_pilot.ok()) << with_pilot.status().message();
    EXPECT_EQ(with_pilot->shared_bytes, 20u * 12 * (20 + 16 * signals));
  }
}

ScheduleOptions OptionsOf(std::string_view preset) {
  ScheduleOptions o;
  o.settings = PresetSettings(preset).value();
  o.width = 61;
  o.height = 37;
  o.inputs = {"direct_diffuse",
              "indirect_diffuse",
              "direct_specular",
              "indirect_specular",
              "depth",
              "normal",
              "id",
              "motion",
              "albedo",
              "specular_albedo",
              "background",
              "samples"};
  o.outputs = {"colour"};
  return o;
}

FrameSchedule ScheduleOf(const ScheduleOptions& options) {
  Result<FrameSchedule> made = MakeFrameSchedule(options);
  EXPECT_TRUE(made.ok()) << made.status().message();
  return made.ok() ? std::move(*made) : FrameSchedule();
}

std::ptrdiff_t Count(const std::vector<ScheduleCommand>& frame, ScheduleCommand::Kind kind) {
  return std::ranges::count(frame, kind, &ScheduleCommand::kind);
}

// Those of a frame on a device, which Embedding.FramesHaveAKnownNumberOfDispatchesAndBarriers
// counts.
TEST(FrameSchedule, HasTheCommandsOfTheLibrary) {
  struct Known {
    const char* preset;
    int dispatches;
    int barriers;
  };
  for (const Known& known : {Known{"temporal", 7, 7}, Known{"svgf", 18, 18}, Known{"psvgf", 19, 19},
                             Known{"default", 47, 44}}) {
    ScheduleOptions options = OptionsOf(known.preset);
    options.inputs.emplace_back("roughness");
    options.jittered = true;
    options.samples_per_pixel = 0.97f;
    const FrameSchedule schedule = ScheduleOf(options);
    const std::vector<ScheduleCommand>& last = schedule.frames.back();
    EXPECT_EQ(Count(last, ScheduleCommand::Kind::kDispatch), known.dispatches) << known.preset;
    EXPECT_EQ(Count(last, ScheduleCommand::Kind::kBarrier), known.barriers) << known.preset;
    EXPECT_EQ(Count(last, ScheduleCommand::Kind::kTransition), 0) << known.preset;
    EXPECT_EQ(Count(schedule.frames.front(), ScheduleCommand::Kind::kTransition), 1);
  }
}

/// What an image must be like for a binding of a shader.
void ExpectImageFits(const ScheduleImage& image, const PackBinding& use, const std::string& what) {
  EXPECT_EQ(image.layers > 0, use.is_array) << what;
  if (!use.format.empty()) {
    const auto* const format = std::ranges::find(
        kFormats, use.format, [](const Format& f) { return std::string(f.glsl); });
    EXPECT_EQ(image.format, format->vulkan) << what;
  }
  if (!image.format.empty()) {
    EXPECT_EQ(image.format.ends_with("UINT"), use.texels == "uint") << what;
  }
}

TEST(FrameSchedule, ResourcesFitTheShaders) {
  for (const char* preset : {"temporal", "svgf", "psvgf", "eaw", "default"}) {
    for (const DevicePrecision precision : {DevicePrecision::kHalf, DevicePrecision::kFloat}) {
      ScheduleOptions options = OptionsOf(preset);
      options.precision = precision;
      options.jittered = true;
      options.outputs = {"colour_half", "display"};
      options.incomplete_guides = true;
      options.inputs.insert(options.inputs.end(),
                            {"roughness", "reflection.depth", "reflection.normal", "reflection.id",
                             "reflection.motion", "reflection.albedo"});
      const FrameSchedule schedule = ScheduleOf(options);
      for (const std::vector<ScheduleCommand>& frame : schedule.frames) {
        for (const ScheduleCommand& c : frame) {
          if (c.kind != ScheduleCommand::Kind::kDispatch) {
            continue;
          }
          const PackedShader& shader = ShaderOf(c.shader);
          EXPECT_LE(c.bytes.size(), shader.push_bytes);
          for (const PackBinding& use : shader.bindings) {
            const auto bound = std::ranges::find_if(c.bindings, [&](const ScheduleBinding& b) {
              return b.set == use.set && b.binding == use.binding;
            });
            ASSERT_NE(bound, c.bindings.end()) << c.shader << " " << use.name;
            EXPECT_EQ(bound->kind, use.kind) << c.shader << " " << use.name;
            const auto image =
                std::ranges::find(schedule.images, bound->resource, &ScheduleImage::name);
            const bool is_image = use.kind.ends_with("_image");
            EXPECT_EQ(image != schedule.images.end(), is_image) << bound->resource;
            if (is_image) {
              ExpectImageFits(*image, use, c.shader + " " + use.name + " " + bound->resource);
            }
          }
        }
      }
    }
  }
}

TEST(FrameSchedule, NamesHistoryAndSizes) {
  const FrameSchedule schedule = ScheduleOf(OptionsOf("default"));
  EXPECT_EQ(schedule.repeats_from, 1u);
  EXPECT_EQ(schedule.period, 2u);
  std::map<std::string, ScheduleImage> images;
  for (const ScheduleImage& image : schedule.images) {
    EXPECT_TRUE(images.emplace(image.name, image).second) << image.name << " is there twice";
  }
  for (const char* history : {"history.colour", "history.moments", "history.compressed",
                              "guides_0.surface", "guides_1.detail", "shown"}) {
    EXPECT_TRUE(images.at(history).is_history) << history;
  }
  for (const char* within :
       {"noisy", "fetched.colour", "coarse.surface", "depth", "colour", "no_input"}) {
    EXPECT_FALSE(images.at(within).is_history) << within;
  }
  EXPECT_EQ(images.at("coarse.surface").width, 31u);  // half of 61, rounded up
  EXPECT_EQ(images.at("coarse.surface").height, 19u);
  EXPECT_EQ(images.at("history.colour").layers, 3u);
  EXPECT_EQ(images.at("history.colour").format, "R16G16B16A16_SFLOAT");
  EXPECT_EQ(images.at("colour").role, "output");
  EXPECT_EQ(images.at("depth").role, "input");
  EXPECT_EQ(images.at("nothing").role, "placeholder");
  const auto state = std::ranges::find(schedule.buffers, "state", &ScheduleBuffer::name);
  ASSERT_NE(state, schedule.buffers.end());
  EXPECT_EQ(state->bytes, sizeof(FrameState));
  EXPECT_TRUE(state->is_history);
}

TEST(FrameSchedule, HasTheParametersOfTheFrame) {
  ScheduleOptions options = OptionsOf("default");
  options.jittered = true;
  const FrameSchedule schedule = ScheduleOf(options);
  const auto update =
      std::ranges::find(schedule.frames[1], ScheduleCommand::Kind::kUpdate, &ScheduleCommand::kind);
  ASSERT_NE(update, schedule.frames[1].end());
  EXPECT_EQ(update->buffer, "parameters");
  FrameParameters parameters = {};
  ASSERT_EQ(update->bytes.size(), sizeof(parameters));
  std::memcpy(&parameters, update->bytes.data(), sizeof(parameters));
  EXPECT_EQ(parameters.width, 61);
  EXPECT_EQ(parameters.height, 37);
  EXPECT_EQ(parameters.has_history, 1);
  EXPECT_EQ(parameters.lights, 15);
  EXPECT_EQ(parameters.albedos, 3);
  EXPECT_EQ(parameters.has_emission, 0);
  const auto members_of = [&](const char* property) {
    return schedule.members_of.at(property).at("parameters");
  };
  EXPECT_THAT(members_of("jitter_x"), ElementsAre("limit_history.jitter_x"));
  EXPECT_THAT(members_of("jitter_y"), ElementsAre("limit_history.jitter_y"));
  EXPECT_THAT(members_of("index"), ElementsAre("tonemap.frame"));
  EXPECT_THAT(members_of("focal_pixels"), Contains("atrous.edges.focal_pixels"));
  EXPECT_THAT(schedule.members_of.at("number"), IsEmpty());
}

// A quarter of a sample per pixel: whole samples, and with them the feedback, come in every fourth
// frame.
TEST(FrameSchedule, SparseFramesRepeatWithTheirSamples) {
  ScheduleOptions options = OptionsOf("psvgf");
  options.samples_per_pixel = 0.25f;
  const FrameSchedule schedule = ScheduleOf(options);
  EXPECT_EQ(schedule.period % 4, 0u);
}

TEST(FrameSchedule, SharedMemoryChoosesTheWavelet) {
  ScheduleOptions options = OptionsOf("svgf");
  const auto shaders = [&] {
    std::set<std::string> names;
    for (const ScheduleCommand& c : ScheduleOf(options).frames.back()) {
      names.insert(c.shader);
    }
    return names;
  };
  EXPECT_THAT(shaders(), Contains("AtrousTileHalf"));
  options.shared_memory = 0;
  EXPECT_THAT(shaders(), Contains("AtrousHalf"));
  options.precision = DevicePrecision::kFloat;
  EXPECT_THAT(shaders(), Contains("AtrousFloat"));
}

// Its light may be of every kind, and none of it has virtual guides.
TEST(FrameSchedule, FramesOfOneSignalHaveItsOutput) {
  ScheduleOptions options = OptionsOf("svgf");
  options.settings.signals = SignalGrouping::kSingle;
  options.outputs = {"colour", "filtered_0"};
  const std::vector<ScheduleCommand> last = ScheduleOf(options).frames.back();
  const auto store = std::ranges::find(last, "StoreSignalHalf", &ScheduleCommand::shader);
  ASSERT_NE(store, last.end());
  EXPECT_EQ(store->bindings.at(store->bindings.size() - 2).resource, "filtered_0");
}

TEST(FrameSchedule, SaysWhatIsWrong) {
  const auto message = [](const ScheduleOptions& options) {
    const Result<FrameSchedule> made = MakeFrameSchedule(options);
    EXPECT_EQ(made.status().code(), StatusCode::kInvalidArgument);
    return made.status().message();
  };
  ScheduleOptions options = OptionsOf("svgf");
  options.inputs.emplace_back("dept");
  EXPECT_THAT(message(options), HasSubstr("'dept' is no input image, did you mean depth?"));
  options = OptionsOf("svgf");
  options.inputs.emplace_back("depth");
  EXPECT_THAT(message(options), HasSubstr("the input image 'depth' is given twice"));
  options = OptionsOf("svgf");
  options.outputs = {"color"};
  EXPECT_THAT(message(options), HasSubstr("'color' is no output image, did you mean colour?"));
  options.outputs = {"colour", "colour_half"};
  EXPECT_THAT(message(options), HasSubstr("expected one of them"));
  options.outputs = {"display"};
  EXPECT_THAT(message(options), HasSubstr("image 'colour' is not given"));
  options = OptionsOf("svgf");
  std::erase(options.inputs, "motion");
  EXPECT_THAT(message(options), HasSubstr("image 'motion' is not given"));
  options = OptionsOf("default");
  options.inputs.emplace_back("reflection.normal");
  EXPECT_THAT(message(options), HasSubstr("the input image 'reflection.depth' is not given"));
  options.inputs.emplace_back("reflection.depth");
  EXPECT_THAT(message(options), HasSubstr("image 'reflection.motion' is not given"));
  options = OptionsOf("svgf");
  options.width = 0;
  EXPECT_THAT(message(options), HasSubstr("frames are 0x37, expected 1x1 to"));
  options = OptionsOf("best");
  EXPECT_THAT(message(options), HasSubstr("restore_detail"));
}

}  // namespace
}  // namespace stillray::shader_table_test

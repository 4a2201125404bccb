// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames of the filter from the files of `stillray shaders` alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "apps/program.h"
#include "denoise/test_frames.h"
#include "gpu/device_test.h"
#include "gpu/embedded_frame.h"
#include "gpu/frame_run.h"
#include "gpu/mirror_frames.h"
#include "gpu/packed_filter.h"
#include "gpu/put_on_device.h"
#include "stillray/vulkan.hpp"

namespace stillray::shader_pack_test {
namespace {

using test::MakeBusyFrame;
using test::MakeGlass;
using test::PackedFilter;
using test::PackImages;
using test::PlanesOf;
using test::PutOnDevice;
using test::RunFrame;
using test::Upload;
using ::testing::HasSubstr;

constexpr int kWidth = 61;
constexpr int kHeight = 37;
/// More than the frames of a pack, which then repeat.
constexpr int kFrames = 8;

constexpr const char* kInputs =
    "direct_diffuse,indirect_diffuse,direct_specular,indirect_specular,depth,normal,id,motion,"
    "albedo,specular_albedo,background,samples,roughness";

/// The wavelet's variant of the library's denoiser, which packs of other memory do not have.
class ChosenVariant {
 public:
  explicit ChosenVariant(const char* name) { setenv("STILLRAY_ATROUS", name, 1); }
  ~ChosenVariant() { unsetenv("STILLRAY_ATROUS"); }
};

/// What a test writes to a pack, and the same for the library.
struct Case {
  const char* preset;
  const char* precision;
  bool tiles;
  bool jittered;
  bool fills_guides = false;
};

class ShaderPack : public test::DeviceTest {
 protected:
  static VulkanImage ImageOf(const vulkan::ImageRef& ref) { return {ref.view, ref.layout}; }

  /// Images of a frame by their names in packs.
  static PackImages NamedImages(const vulkan::FrameInputs& in) {
    return {{"direct_diffuse", in.lights[0].view},
            {"indirect_diffuse", in.lights[1].view},
            {"direct_specular", in.lights[2].view},
            {"indirect_specular", in.lights[3].view},
            {"depth", in.depth.view},
            {"normal", in.normal.view},
            {"id", in.id.view},
            {"motion", in.motion.view},
            {"albedo", in.albedos[0].view},
            {"specular_albedo", in.albedos[1].view},
            {"background", in.background.view},
            {"samples", in.samples.view},
            {"roughness", in.roughness.view},
            {"colour", in.colour.view}};
  }

  static VulkanFrame FrameOf(const vulkan::FrameInputs& in, const Frame& frame, bool jittered) {
    VulkanFrame f;
    f.index = frame.index;
    f.jitter_x = jittered ? frame.jitter_x : 0;
    f.jitter_y = jittered ? frame.jitter_y : 0;
    for (size_t k = 0; k < 4; ++k) {
      f.lights[k] = ImageOf(in.lights[k]);
    }
    f.depth = ImageOf(in.depth);
    f.normal = ImageOf(in.normal);
    f.id = ImageOf(in.id);
    f.motion = ImageOf(in.motion);
    f.albedo = ImageOf(in.albedos[0]);
    f.specular_albedo = ImageOf(in.albedos[1]);
    f.background = ImageOf(in.background);
    f.samples = ImageOf(in.samples);
    f.roughness = ImageOf(in.roughness);
    f.colour = ImageOf(in.colour);
    return f;
  }

  VulkanContext Context() const {
    return {instance_->handle(), device_->context().physical, device_->context().device,
            instance_->get_instance_proc_addr()};
  }

  static void WritePack(const std::string& folder, const Case& of,
                        const std::string& inputs = kInputs) {
    std::vector<std::string> arguments = {"shaders",
                                          "-o",
                                          folder,
                                          "--preset",
                                          of.preset,
                                          "--precision",
                                          of.precision,
                                          "--size",
                                          std::to_string(kWidth) + "x" + std::to_string(kHeight),
                                          "--inputs",
                                          inputs,
                                          "--shared-memory",
                                          of.tiles ? "65536" : "0"};
    if (of.jittered) {
      arguments.emplace_back("--jitter");
    }
    if (of.fills_guides) {
      arguments.emplace_back("--incomplete-guides");
    }
    const ProgramRun run = RunProgram(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.errors;
  }

  std::vector<Image3> PicturesOfLibrary(const Case& of) {
    const ChosenVariant variant(of.tiles ? "tile" : "plain");
    VulkanOptions options;
    options.settings = PresetSettings(of.preset).value();
    options.width = kWidth;
    options.height = kHeight;
    options.incomplete_guides = of.fills_guides;
    options.precision =
        std::string(of.precision) == "float" ? DevicePrecision::kFloat : DevicePrecision::kHalf;
    Result<VulkanDenoiser> denoiser =
        VulkanDenoiser::Create({instance_->handle(), device_->context().physical,
                                device_->context().device, instance_->get_instance_proc_addr()},
                               options);
    EXPECT_TRUE(denoiser.ok()) << denoiser.status().message();
    return Pictures(
        of, [&](VkCommandBuffer commands, const vulkan::FrameInputs& in, const Frame& f) {
          const Status recorded = denoiser->Record(commands, FrameOf(in, f, of.jittered));
          ASSERT_TRUE(recorded.ok()) << recorded.message();
        });
  }

  /// Members of the parameters that the properties of the frame decide, as README.md of a pack
  /// says.
  static PackedFilter::Values ParametersOf(const PackedFilter& filter, const Case& of,
                                           const Frame& f) {
    PackedFilter::Values values;
    const auto set = [&](const char* property, auto value) {
      for (const auto& [buffer, members] : filter.frames()["members_of"][property].items()) {
        for (const std::string member : members) {
          values[buffer][member] = std::bit_cast<uint32_t>(value);
        }
      }
    };
    set("jitter_x", of.jittered ? f.jitter_x : 0.0f);
    set("jitter_y", of.jittered ? f.jitter_y : 0.0f);
    const auto number = static_cast<uint32_t>(f.index);
    if (of.fills_guides) {
      set("number", number + 1);  // ghost_stamp
      const auto fraction = [&](double step) {
        return std::bit_cast<uint32_t>(static_cast<float>(std::fmod(number * step, 1.0)));
      };
      values["parameters"]["shift_x"] = fraction(0.7548776662466927);
      values["parameters"]["shift_y"] = fraction(0.5698402909980532);
    } else {
      EXPECT_TRUE(filter.frames()["members_of"]["number"].empty());
    }
    return values;
  }

  std::vector<Image3> PicturesOfPack(PackedFilter* filter, const Case& of) {
    return Pictures(of,
                    [&](VkCommandBuffer commands, const vulkan::FrameInputs& in, const Frame& f) {
                      filter->Record(commands, static_cast<size_t>(f.index), NamedImages(in),
                                     ParametersOf(*filter, of, f));
                    });
  }

  /// Where no path was traced.
  static void ForgetGuides(Frame* f) {
    for (int y = 0; y < f->height; ++y) {
      for (int x = 0; x < f->width; ++x) {
        if (f->samples(x, y) == 0) {
          f->guides.depth(x, y) = 0;
        }
      }
    }
  }

  template <typename Record>
  std::vector<Image3> Pictures(const Case& of, const Record& record) {
    std::vector<Image3> pictures;
    const auto on_device = Upload(device_->context(), MakeBusyFrame(kWidth, kHeight, 0));
    for (int i = 0; i < kFrames; ++i) {
      Frame f = MakeBusyFrame(kWidth, kHeight, i);
      if (of.fills_guides) {
        ForgetGuides(&f);
      }
      pictures.emplace_back(kWidth, kHeight);
      RunFrame(device_.get(), on_device.get(), f, &pictures.back(),
               [&](VkCommandBuffer commands) { record(commands, on_device->inputs(), f); });
    }
    return pictures;
  }

  static void ExpectSamePictures(const std::vector<Image3>& found,
                                 const std::vector<Image3>& expected) {
    for (size_t i = 0; i < expected.size(); ++i) {
      int different = 0;
      double sum = 0;
      for (int c = 0; c < 3; ++c) {
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            different += expected[i][c](x, y) != found[i][c](x, y) ? 1 : 0;
            sum += static_cast<double>(expected[i][c](x, y));
          }
        }
      }
      EXPECT_EQ(different, 0) << "values of frame " << i;
      EXPECT_GT(sum, 100) << "frame " << i << " is black";
    }
  }

  void ExpectPicturesOfLibrary(const Case& of) {
    const TemporaryFolder folder;
    WritePack(folder / "pack", of);
    if (HasFatalFailure()) {
      return;
    }
    const std::vector<Image3> expected = PicturesOfLibrary(of);
    PackedFilter filter(&device_->context(), folder / "pack");
    EXPECT_LT(filter.frames()["frames"].size(), static_cast<size_t>(kFrames));
    ExpectSamePictures(PicturesOfPack(&filter, of), expected);
    EXPECT_GT(filter.pipelines(), 5u);
    SCOPED_TRACE("begun anew, as after a cut");
    ExpectSamePictures(PicturesOfPack(&filter, of), expected);
  }
};

// Of the program itself; no device is needed.
TEST(ShaderPackFiles, AreThoseOfTheTable) {
  const TemporaryFolder folder;
  const ProgramRun run = RunProgram({"shaders", "-o", folder / "new/pack", "--preset", "svgf"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr(" shaders, 7 frames; "));
  const std::filesystem::path pack = folder / "new/pack";
  const auto table = nlohmann::json::parse(std::ifstream(pack / "shaders.json"));
  size_t files = 0;
  for (const auto& file : std::filesystem::directory_iterator(pack)) {
    files += file.path().extension() == ".spv" ? 1 : 0;
  }
  EXPECT_EQ(table["shaders"].size(), files);
  for (const auto& shader : table["shaders"]) {
    const std::string code = ReadText(pack / shader["file"].get<std::string>());
    ASSERT_GT(code.size(), 100u) << shader["file"];
    EXPECT_EQ(code.substr(0, 4), "\x03\x02\x23\x07") << shader["file"];
  }
  const std::string text = ReadText(pack / "README.md");
  EXPECT_THAT(text, HasSubstr("| atrous5 | `AtrousTileHalf` |"));
  EXPECT_THAT(text, HasSubstr("| `history.colour` | internal | R16G16B16A16_SFLOAT | "));
  // The same command writes the same bytes.
  const std::string frames = ReadText(pack / "frames.json");
  RunProgram({"shaders", "-o", folder / "new/pack", "--preset", "svgf"});
  EXPECT_EQ(ReadText(pack / "frames.json"), frames);
}

TEST(ShaderPackFiles, WrongOptionsAreErrorsAndWriteNothing) {
  const TemporaryFolder folder;
  const auto error = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"shaders", "-o", folder / "pack"});
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_FALSE(std::filesystem::exists(folder / "pack"));
    return run.errors;
  };
  EXPECT_THAT(error({"--size", "640"}), HasSubstr("--size is '640', expected WIDTHxHEIGHT"));
  EXPECT_THAT(error({"--size", "0x4"}), HasSubstr("with 1 to 16384 pixels a side"));
  EXPECT_THAT(error({"--inputs", "depth,norml"}), HasSubstr("did you mean normal?"));
  EXPECT_THAT(error({"--inputs", "depth"}), HasSubstr("there are no lights to denoise"));
  EXPECT_THAT(error({"--outputs", "display"}), HasSubstr("image 'colour' is not given"));
  EXPECT_THAT(error({"--precision", "double"}), HasSubstr("expected half or float"));
  EXPECT_THAT(error({"--spp", "0"}), HasSubstr("--spp is 0, expected above 0"));
  EXPECT_THAT(error({"--preset", "fast"}), HasSubstr("unknown preset 'fast'"));
  EXPECT_THAT(error({"--set", "depth_weight=position"}), HasSubstr("needs --focal-pixels"));
  setenv("STILLRAY_SHADER_DIR", folder.path().c_str(), 1);
  std::ofstream(folder / "AtrousHalf.spv") << "text";
  EXPECT_THAT(error({}), HasSubstr("STILLRAY_SHADER_DIR replaces shaders (AtrousHalf)"));
  unsetenv("STILLRAY_SHADER_DIR");
}

TEST_F(ShaderPack, TemporalHasTheBitsOfTheLibrary) {
  ExpectPicturesOfLibrary({"temporal", "half", false, false});
}

TEST_F(ShaderPack, SvgfHasTheBitsOfTheLibrary) {
  ExpectPicturesOfLibrary({"svgf", "half", false, false});
}

TEST_F(ShaderPack, SvgfInFloatsByTilesHasTheBitsOfTheLibrary) {
  ExpectPicturesOfLibrary({"svgf", "float", true, false});
}

TEST_F(ShaderPack, DefaultWithJitterHasTheBitsOfTheLibrary) {
  ExpectPicturesOfLibrary({"default", "half", false, true});
}

/// The images of a frame that its renderer left on the device, by their names in packs.
PackImages ImagesOnDevice(const gpu::FrameImages& images, const gpu::Image& colour) {
  PackImages named = {{"depth", images.depth->view},
                      {"normal", images.normal->view},
                      {"id", images.id->view},
                      {"motion", images.motion->view},
                      {"albedo", images.albedo->view},
                      {"specular_albedo", images.specular_albedo->view},
                      {"transmission_albedo", images.transmission_albedo->view},
                      {"background", images.background->view},
                      {"samples", images.samples->view},
                      {"roughness", images.roughness->view},
                      {"previous_normal", images.previous_normal->view},
                      {"colour", colour.view}};
  const char* const lights[] = {"direct_diffuse",      "indirect_diffuse",
                                "direct_specular",     "indirect_specular",
                                "direct_transmission", "indirect_transmission"};
  for (size_t k = 0; k < std::size(lights); ++k) {
    named[lights[k]] = images.lights[k]->view;
  }
  for (const auto& [prefix, seen] : {std::pair{std::string("reflection."), &images.reflection},
                                     std::pair{std::string("refraction."), &images.refraction}}) {
    named[prefix + "depth"] = seen->depth->view;
    named[prefix + "normal"] = seen->normal->view;
    named[prefix + "motion"] = seen->motion->view;
    named[prefix + "id"] = seen->id->view;
    named[prefix + "albedo"] = seen->albedo->view;
  }
  return named;
}

// Reflected and transmitted light, each filtered by what it shows, and jitter in every filter.
TEST_F(ShaderPack, VirtualGuidesHaveTheBitsOfTheLibrary) {
  const Case of = {"default", "half", false, true};
  gpu::Arena arena(&device_->context());
  const gpu::Image* const colours[] = {
      arena.AddImage(VK_FORMAT_R32G32B32A32_SFLOAT, kWidth, kHeight, 0).value(),
      arena.AddImage(VK_FORMAT_R32G32B32A32_SFLOAT, kWidth, kHeight, 0).value()};
  ASSERT_TRUE(arena.Allocate().ok());
  const auto run = [&](const auto& record) {
    const gpu::FairLock lock = device_->Lock();
    const Result<VkCommandBuffer> commands = device_->Begin();
    ASSERT_TRUE(commands.ok());
    record(*commands);
    const Status ran = device_->Run();
    ASSERT_TRUE(ran.ok()) << ran.message();
  };
  run([&](VkCommandBuffer commands) {
    arena.RecordFirstUse(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                         VK_ACCESS_SHADER_WRITE_BIT);
  });
  const TemporaryFolder folder;
  std::string names;
  const Frame first = PutOnDevice(device_, MakeGlass(kWidth, kHeight, 0, false));
  for (const auto& [name, view] :
       ImagesOnDevice(gpu::FrameOn(*device_, first)->images(), *colours[0])) {
    names += name == "colour" ? "" : name + ",";
  }
  names.pop_back();
  WritePack(folder / "pack", of, names);
  PackedFilter filter(&device_->context(), folder / "pack");
  const ChosenVariant variant("plain");
  VulkanOptions options;
  options.settings = PresetSettings(of.preset).value();
  options.width = kWidth;
  options.height = kHeight;
  options.transmission = true;
  options.virtual_guides = true;
  Result<VulkanDenoiser> denoiser = VulkanDenoiser::Create(Context(), options);
  ASSERT_TRUE(denoiser.ok()) << denoiser.status().message();
  for (int i = 0; i < kFrames; ++i) {
    const Frame f = MakeGlass(kWidth, kHeight, i, false);
    const Frame on_device = PutOnDevice(device_, f);
    const gpu::DeviceFrame& pixels = *gpu::FrameOn(*device_, on_device);
    VulkanFrame frame = test::EmbeddedFrame(f, pixels, [](const gpu::Image& image) {
      return VulkanImage{image.view, VK_IMAGE_LAYOUT_GENERAL};
    });
    frame.samples_per_pixel = 1;
    frame.emission = {};
    frame.colour = {colours[0]->view, VK_IMAGE_LAYOUT_GENERAL};
    run([&](VkCommandBuffer commands) {
      const Status recorded = denoiser->Record(commands, frame);
      ASSERT_TRUE(recorded.ok()) << recorded.message();
    });
    run([&](VkCommandBuffer commands) {
      filter.Record(commands, static_cast<size_t>(i), ImagesOnDevice(pixels.images(), *colours[1]),
                    ParametersOf(filter, of, f));
    });
    const auto expected = PlanesOf<float, 3>(device_.get(), *colours[0]);
    const auto found = PlanesOf<float, 3>(device_.get(), *colours[1]);
    int different = 0;
    for (size_t c = 0; c < expected.size(); ++c) {
      for (int y = 0; y < kHeight; ++y) {
        different +=
            std::equal(expected[c].Row(y), expected[c].Row(y) + kWidth, found[c].Row(y)) ? 0 : 1;
      }
    }
    EXPECT_EQ(different, 0) << "rows of frame " << i;
    ASSERT_TRUE(denoiser->ForgetImages().ok());
  }
}

TEST_F(ShaderPack, UnknownGuidesHaveTheBitsOfTheLibrary) {
  ExpectPicturesOfLibrary({"default", "half", false, false, true});
}

}  // namespace
}  // namespace stillray::shader_pack_test

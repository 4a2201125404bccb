// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Guides completed on Vulkan against the scalar reference.
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/half.h"
#include "denoise/fill_guides/fill_guides.h"
#include "denoise/sparse_frames.h"
#include "denoise/vulkan/frame_pipeline.h"
#include "gpu/device_test.h"
#include "gpu/frame_run.h"

namespace stillray::fill_guides_test {
namespace {

using test::MakeSparseFrame;
using test::SparseCase;
using test::SparseCases;
using vulkan::FillGuidesPass;
using vulkan::Storage;

/// An image of the device, read back as floats of 32 bits (ids: their bits).
struct Texels {
  int width = 0;
  int channels = 0;
  std::vector<float> values;

  float At(int x, int y, int c) const {
    return values[static_cast<size_t>((y * width + x) * channels + c)];
  }
};

/// Tolerances: relative, for values; and the share of pixels that may be a surface in one result
/// alone, because their part rounds to either side of one half.
struct Room {
  double relative;
  double decided_otherwise = 0.002;
};

constexpr Room kFloats = {1e-5};
/// Eleven bits, rounded again in every frame in which they are held; depth and light have all 32.
constexpr Room kHalves = {2e-3};

class FillGuides : public test::DeviceTest {
 protected:
  void Start(int width, int height, Storage storage) {
    vulkan::PipelineOptions o;
    o.settings = PresetSettings("default").value();
    o.width = width;
    o.height = height;
    o.storage = storage;
    o.timed = false;
    auto made = vulkan::FramePipeline::Create(&device_->context(), o);
    ASSERT_TRUE(made.ok()) << made.status().message();
    pipeline_ = std::move(made.value());
    storage_ = storage;
    held_ = HeldGuides();
    upload_.reset();
  }

  void TearDown() override {
    upload_.reset();
    pipeline_.reset();
    test::DeviceTest::TearDown();
  }

  /// Runs the frame on both and compares.
  void Check(const Frame& f, const Room& room, const std::string& what);
  Texels Read(const gpu::Image& image, const gpu::Buffer& from, VkDeviceSize* offset) const;

  Storage storage_ = Storage::kFloat;
  std::unique_ptr<vulkan::FramePipeline> pipeline_;
  std::unique_ptr<test::FrameOnDevice> upload_;
  HeldGuides held_;
  FillGuidesWork work_;
};

/// Channels of a format of held images, and whether they are halves.
std::pair<int, bool> LayoutOf(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_R32_UINT:
      return {1, false};
    case VK_FORMAT_R32G32_SFLOAT:
      return {2, false};
    case VK_FORMAT_R16G16B16A16_SFLOAT:
      return {4, true};
    default:
      return {4, false};
  }
}

/// Of an image in a buffer, up to where any other may begin.
VkDeviceSize AlignedBytesOf(const gpu::Image& image) {
  return (VkDeviceSize{gpu::BytesOf(image)} + 15) / 16 * 16;
}

Texels FillGuides::Read(const gpu::Image& image, const gpu::Buffer& from,
                        VkDeviceSize* offset) const {
  const auto [channels, half] = LayoutOf(image.format);
  const auto* bytes = static_cast<const char*>(from.mapped) + *offset;
  *offset += AlignedBytesOf(image);
  Texels t = {image.width, channels, {}};
  t.values.resize(static_cast<size_t>(image.width * image.height * channels));
  for (size_t i = 0; i < t.values.size(); ++i) {
    if (half) {
      uint16_t bits = 0;
      std::memcpy(&bits, bytes + 2 * i, 2);
      t.values[i] = FloatFromHalf(bits);
    } else {
      std::memcpy(&t.values[i], bytes + 4 * i, 4);
    }
  }
  return t;
}

bool Near(float a, float b, double relative) {
  return a == b || (std::isnan(a) && std::isnan(b)) ||
         std::abs(static_cast<double>(a) - static_cast<double>(b)) <=
             relative * (std::abs(static_cast<double>(b)) + 0.1);
}

void FillGuides::Check(const Frame& f, const Room& room, const std::string& what) {
  reference::FillGuides(f, &held_, &work_);
  FrameFacts facts = FactsOf(f);
  facts.has_incomplete_guides = true;
  if (upload_ == nullptr || !upload_->upload->Fits(f.width, f.height, facts)) {
    ASSERT_TRUE(pipeline_->ForgetInputs().ok());
    upload_ = test::Upload(device_->context(), f);
  }
  const Status prepared = pipeline_->PrepareFilling(facts);
  ASSERT_TRUE(prepared.ok()) << prepared.message();
  std::vector<const gpu::Image*> images;
  gpu::Arena arena(&device_->context());
  const gpu::Buffer* down = nullptr;
  Image3 colour;
  test::RunFrame(device_.get(), upload_.get(), f, &colour, [&](VkCommandBuffer commands) {
    const FramePlan plan =
        MakePlan(PresetSettings("default").value(), facts, pipeline_->progress());
    gpu::CommandList list(&device_->context());
    const Status recorded = pipeline_->Record(&list, plan, facts, upload_->inputs(), nullptr);
    ASSERT_TRUE(recorded.ok()) << recorded.message();
    list.Record(commands);
    const FillGuidesPass& fill_guides = *pipeline_->fill_guides();
    const FillGuidesPass::Held& h = fill_guides.held();
    images = {h.depth, h.normal, &fill_guides.motion(), h.id};
    images.insert(images.end(), h.colour.begin(), h.colour.end());
    VkDeviceSize bytes = 0;
    for (const gpu::Image* image : images) {
      bytes += AlignedBytesOf(*image);
    }
    down = *arena.AddBuffer(bytes, 0, gpu::BufferPlace::kDownload);
    ASSERT_TRUE(arena.Allocate().ok());
    test::Barrier(device_->context(), commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                  VK_ACCESS_SHADER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                  VK_ACCESS_TRANSFER_READ_BIT);
    VkBufferImageCopy region = {};
    for (const gpu::Image* image : images) {
      region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
      region.imageExtent = {static_cast<uint32_t>(image->width),
                            static_cast<uint32_t>(image->height), 1};
      device_->context().vk.CmdCopyImageToBuffer(commands, image->image, VK_IMAGE_LAYOUT_GENERAL,
                                                 down->buffer, 1, &region);
      region.bufferOffset += AlignedBytesOf(*image);
    }
  });
  ASSERT_FALSE(HasFatalFailure());
  ASSERT_TRUE(arena.Invalidate().ok());
  VkDeviceSize offset = 0;
  std::vector<Texels> texels;
  for (const gpu::Image* image : images) {
    texels.push_back(Read(*image, *down, &offset));
  }
  const Texels& depth = texels[0];
  const Texels& normal = texels[1];
  const Guides& g = held_.guides;
  const double packed = storage_ == Storage::kHalf ? room.relative : kFloats.relative;
  int otherwise = 0;
  for (int y = 0; y < f.height; ++y) {
    for (int x = 0; x < f.width; ++x) {
      const std::string where = what + " at " + std::to_string(x) + "," + std::to_string(y);
      ASSERT_EQ(normal.At(x, y, 3) > 0, held_.known(x, y) > 0) << where;
      if (std::isinf(depth.At(x, y, 0)) != std::isinf(g.depth(x, y))) {
        ++otherwise;
        continue;
      }
      ASSERT_TRUE(Near(depth.At(x, y, 0), g.depth(x, y), kFloats.relative))
          << where << ": depth " << depth.At(x, y, 0) << ", expected " << g.depth(x, y);
      for (int c = 0; c < 3; ++c) {
        ASSERT_TRUE(Near(normal.At(x, y, c), g.normal[c](x, y), packed))
            << where << ": normal " << normal.At(x, y, c) << ", expected " << g.normal[c](x, y);
      }
      for (int c = 0; c < 2; ++c) {
        ASSERT_TRUE(Near(texels[2].At(x, y, c), g.motion[c](x, y), kFloats.relative)) << where;
      }
      if (!g.id.empty()) {
        ASSERT_EQ(std::bit_cast<uint32_t>(texels[3].At(x, y, 0)), g.id(x, y)) << where;
      }
      const Image3* colours[] = {&g.albedo, &g.specular_albedo, &g.transmission_albedo,
                                 &held_.emission, &held_.background};
      for (size_t k = 0; k < 5; ++k) {
        for (int c = 0; c < 3 && (facts.albedos | 24u) >> k & 1u; ++c) {
          const float expected = colours[k]->empty() ? 0.0f : (*colours[k])[c](x, y);
          const double relative = k < 3 ? packed : kFloats.relative;
          ASSERT_TRUE(Near(texels[4 + k].At(x, y, c), expected, relative))
              << where << ": colour " << k << " " << texels[4 + k].At(x, y, c) << ", expected "
              << expected;
        }
      }
    }
  }
  EXPECT_LE(otherwise, room.decided_otherwise * f.width * f.height) << what;
}

TEST_F(FillGuides, EqualsTheReferenceOverFrames) {
  for (const SparseCase& c : SparseCases()) {
    Start(c.width, c.height, Storage::kFloat);
    for (int i = 0; i < 8; ++i) {
      Check(MakeSparseFrame(c, i), kFloats,
            std::to_string(c.width) + "x" + std::to_string(c.height) + " 1/" +
                std::to_string(c.one_of) + " frame " + std::to_string(i));
      ASSERT_FALSE(HasFatalFailure());
    }
  }
}

TEST_F(FillGuides, LargePicturesHaveLevelsOfManyWorkgroups) {
  const SparseCase c = {400, 300, 150, 0.8f, true};
  Start(c.width, c.height, Storage::kFloat);
  for (int i = 0; i < 2; ++i) {
    Check(MakeSparseFrame(c, i), kFloats, "frame " + std::to_string(i));
    ASSERT_FALSE(HasFatalFailure());
  }
}

TEST_F(FillGuides, HalvesHoldNormalsAndAlbedos) {
  const SparseCase c = {100, 50, 6, 0.6f, true};
  Start(c.width, c.height, Storage::kHalf);
  for (int i = 0; i < 8; ++i) {
    Check(MakeSparseFrame(c, i), kHalves, "frame " + std::to_string(i));
    ASSERT_FALSE(HasFatalFailure());
  }
}

TEST_F(FillGuides, NothingKnownAtAllIsSky) {
  for (const auto& [width, height] : {std::pair{1, 1}, std::pair{40, 23}}) {
    Start(width, height, Storage::kFloat);
    Frame f = MakeSparseFrame({width, height, 10, 0.5f, true}, 0);
    test::ForgetUnless([](int, int) { return false; }, &f);
    for (int i = 0; i < 2; ++i) {
      f.index = i;
      Check(f, kFloats, "nothing known");
      ASSERT_FALSE(HasFatalFailure());
    }
    Check(MakeSparseFrame({width, height, 10, 0.5f, true}, 2), kFloats, "something known");
  }
}

TEST_F(FillGuides, BrokenValuesAreThoseOfTheReference) {
  Start(50, 40, Storage::kFloat);
  for (int i = 0; i < 6; ++i) {
    Frame f = MakeSparseFrame({50, 40, 5, 0.7f, true}, i);
    for (int k = 0; k < 40; ++k) {
      f.samples(k, 5) = NAN;
      f.samples(k, 8) = INFINITY;
      f.guides.depth(k, 11) = NAN;
      f.guides.depth(k, 14) = -3.0f;
      if (f.guides.depth(k, 20) > 0) {
        f.guides.motion[i % 2](k, 20) = NAN;
        f.guides.motion[1 - i % 2](k, 20) = i % 3 == 0 ? INFINITY : -1e30f;
      }
    }
    Check(f, kFloats, "frame " + std::to_string(i));
    ASSERT_FALSE(HasFatalFailure());
  }
}

TEST_F(FillGuides, FramesWithOtherImagesHoldNothing) {
  const SparseCase c = {60, 40, 10, 0.4f, true};
  Start(c.width, c.height, Storage::kFloat);
  for (int i = 0; i < 6; ++i) {
    Frame f = MakeSparseFrame(c, i);
    if (i >= 2) {
      f.guides.specular_albedo = Image3();
    }
    if (i >= 4) {
      f.guides.id = Plane<uint32_t>();
    }
    Check(f, kFloats, "frame " + std::to_string(i));
    ASSERT_FALSE(HasFatalFailure());
  }
}

TEST_F(FillGuides, SequencesThatKnowAllNowAndThenGiveTheReferencesPictures) {
  // limit_history divides by variances, which of few samples may be zero but for rounding.
  const Settings settings = test::With("default", {{"fxaa", "off"}, {"limit_history", "off"}});
  Denoiser reference = std::move(Denoiser::Create(settings, Backend::kReference).value());
  Denoiser tested = MakeDenoiser(settings, DevicePrecision::kFloat);
  const SparseCase c = {61, 45, 6, 0.8f, true};
  for (int i = 0; i < 10; ++i) {
    const Frame f = i % 4 == 3 ? test::MakeBusyFrame(c.width, c.height, i) : MakeSparseFrame(c, i);
    DenoisedFrame expected;
    DenoisedFrame got;
    ASSERT_TRUE(reference.Denoise(f, &expected).ok());
    const Status status = tested.Denoise(f, &got);
    ASSERT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(got.bad_guides, expected.bad_guides);
    const test::Difference d = test::Compare(got.colour[1], expected.colour[1], 5e-3);
    EXPECT_LT(d.rms, 1e-4) << i;
    bool timed = !device_->has_timestamps() || i % 4 == 3;
    for (const StageTime& time : got.timings) {
      timed = timed || time.name == "fill_guides";
    }
    EXPECT_TRUE(timed) << i;
  }
}

}  // namespace
}  // namespace stillray::fill_guides_test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames with virtual guides whose pixels a renderer left on the device: their parts are those that
// the host makes, and so are their pictures.
#include "denoise/vulkan/layer_split.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "denoise/picture_motion.h"
#include "denoise/stage_test.h"
#include "denoise/stages/select_guides.h"
#include "denoise/test_frames.h"
#include "gpu/device_test.h"
#include "gpu/mirror_frames.h"
#include "gpu/put_on_device.h"

namespace stillray::layer_split_test {
namespace {

using test::Ids;
using test::MakeGlass;
using test::MakeMirrors;
using test::MakePlane;
using test::PlanesOf;
using test::PutOnDevice;
using test::RandomAt;
using test::RandomImage;
using test::RandomPlane;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

constexpr float kShowsUpTo = 0.4f;

/// Some pixels show an image, rougher ones move with it.
Settings SelectSettings() {
  Settings settings;
  settings.virtual_roughness = kShowsUpTo;
  settings.virtual_motion_roughness = 1.0f;
  return settings;
}

Image2 RandomMotion(int width, int height, uint32_t seed) {
  Image2 motion;
  motion[0] = RandomPlane(width, height, seed, 3);
  motion[1] = RandomPlane(width, height, seed + 1, 3);
  return motion;
}

/// \param first  id
VirtualGuides RandomImages(int width, int height, uint32_t first) {
  VirtualGuides v;
  v.depth = MakePlane(width, height, [&](int x, int y) {
    const float u = RandomAt(x / 7, y / 7, first / 1000 + 4);
    return u < 0.1f ? kInfinity : u < 0.2f ? 0.0f : 8 * u;
  });
  v.normal = RandomImage<Image3>(width, height, first + 6);
  v.albedo = RandomImage<Image3>(width, height, first + 7);
  v.motion = RandomMotion(width, height, first + 80);
  v.id = Ids(width, height, first, 5);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float u = RandomAt(x, y, first + 40);
      if (u < 0.02f) {
        v.depth(x, y) = kNan;
        v.motion[0](x, y) = kNan;
      } else if (u < 0.1f) {
        v.normal[1](x, y) = kNan;
        v.albedo[2](x, y) = kInfinity;
      } else if (u < 0.15f) {
        v.motion[0](x, y) = 1e4f;
        for (int c = 0; c < 3; ++c) {
          v.normal[c](x, y) = 0;
        }
      }
    }
  }
  return v;
}

/// Turns all normals to one side, and lets images in rough surfaces move almost alike.
void MoveRoughImages(Frame* f) {
  const Guides& g = f->guides;
  for (int y = 0; y < f->height; ++y) {
    for (int x = 0; x < f->width; ++x) {
      f->guides.normal[2](x, y) += 1.5f;
      Image2& motion = f->reflection.motion;
      if (g.roughness(x, y) > kShowsUpTo && motion[0](x, y) < 1e3f) {
        motion[0](x, y) = g.motion[0](x, y) + 1.5f + 0.2f * RandomAt(x, y, 70);
        motion[1](x, y) = g.motion[1](x, y) - 1.0f;
      }
    }
  }
}

/// A frame of random values, with invalid ones, without images, skies and rough surfaces in
/// between; mirrors of 9 x 9 pixels have little diffuse light.
Frame RandomFrame(int width, int height) {
  Frame f;
  f.width = width;
  f.height = height;
  uint32_t seed = 100;
  for (int kind = 0; kind < kSignalKindCount; ++kind) {
    f.signals.push_back({static_cast<SignalKind>(kind), RandomImage<Image3>(width, height, seed, 4),
                         RandomPlane(width, height, seed + 10, 9)});
    seed += 20;
  }
  f.emission = RandomImage<Image3>(width, height, 11);
  f.background = Image3(width, height);
  Guides& g = f.guides;
  g.depth = MakePlane(width, height, [](int x, int y) {
    const float u = RandomAt(x / 9, y / 9, 1);
    return u < 0.1f ? kInfinity : u < 0.2f ? 0.0f : 1 + u + 0.1f * RandomAt(x, y, 12);
  });
  g.normal = RandomImage<Image3>(width, height, 2);
  g.motion = RandomMotion(width, height, 30);
  g.albedo = test::MakeImage(width, height, [](int x, int y, int c) {
    return RandomAt(x / 9, y / 9, 13) < 0.7f ? 0.01f
                                             : RandomAt(x, y, 14 + static_cast<uint32_t>(c));
  });
  g.specular_albedo = test::MakeImage(width, height, [](int x, int y, int c) {
    return 0.3f + 0.5f * RandomAt(x, y, 4 + static_cast<uint32_t>(c));
  });
  g.transmission_albedo = test::MakeImage(width, height, [](int x, int y, int c) {
    const float cell = RandomAt(x / 9, y / 9, 21) < 0.6f ? 0.2f : 0.9f;
    return cell + 0.1f * RandomAt(x, y, 22 + static_cast<uint32_t>(c));
  });
  g.id = Ids(width, height, 1, 11);
  g.roughness = MakePlane(width, height, [](int x, int y) {
    const float u = RandomAt(x / 9, y / 9, 9);
    return u < 0.1f ? kNan : u < 0.8f ? 0.5f * u : u;
  });
  g.previous_normal = RandomImage<Image3>(width, height, 60);
  f.reflection = RandomImages(width, height, 1000);
  f.refraction = RandomImages(width, height, 2000);
  MoveRoughImages(&f);
  return f;
}

/// Up to the rounding of devices that fuse a product and a sum; values that are not numbers equal
/// each other.
void ExpectSamePlane(const Image1& found, const Image1& expected) {
  ASSERT_EQ(found.width(), expected.width());
  ASSERT_EQ(found.height(), expected.height());
  for (int y = 0; y < expected.height(); ++y) {
    for (int x = 0; x < expected.width(); ++x) {
      const float room = 1e-6f * std::max(std::abs(expected(x, y)), 1.0f);
      const bool same = found(x, y) == expected(x, y) ||
                        std::abs(found(x, y) - expected(x, y)) <= room ||
                        (std::isnan(found(x, y)) && std::isnan(expected(x, y)));
      ASSERT_TRUE(same) << found(x, y) << " in place of " << expected(x, y) << " at " << x << ", "
                        << y;
    }
  }
}

/// What the host selects for a layer of a frame.
struct Selected {
  Guides guides;
  Image3 albedo;

  Selected(const Frame& f, GuideSource source) {
    const Guides& g = f.guides;
    reference::SelectGuides(
        {&g, &ImageOf(f, source), &g.roughness, &SurfaceAlbedoOf(g, source), &g.previous_normal},
        SelectGuidesOf(SelectSettings(), source), &guides, &albedo);
  }
};

/// The images that pixels of a layer show.
Image1 ImagesOf(const Frame& f, const Guides& selected, GuideSource source) {
  Image1 images;
  FindImages(f.guides, selected, SurfaceAlbedoOf(f.guides, source), OtherAlbedoOf(f.guides, source),
             &images);
  return images;
}

constexpr GuideSource kSources[] = {GuideSource::kReflection, GuideSource::kRefraction};

class LayerSplitTest : public test::DeviceTest {
 protected:
  void RunPart(const Frame& part) {
    const auto* found = dynamic_cast<const vulkan::FramePart*>(part.on_device.get());
    ASSERT_NE(found, nullptr);
    const gpu::FairLock lock = device_->Lock();
    const Result<VkCommandBuffer> commands = device_->Begin();
    ASSERT_TRUE(commands.ok());
    gpu::CommandList list(&device_->context());
    const Status recorded = found->record(&list);
    ASSERT_TRUE(recorded.ok()) << recorded.message();
    list.Record(*commands);
    ASSERT_TRUE(device_->Run().ok());
  }

  void ExpectPlane(const gpu::Image* found, const Image1& expected) {
    ASSERT_NE(found, nullptr);
    ExpectSamePlane(PlanesOf<float, 1>(device_.get(), *found)[0], expected);
  }
  template <int N>
  void ExpectPlanes(const gpu::Image* found, const Planes<float, N>& expected) {
    ASSERT_NE(found, nullptr);
    const auto planes = PlanesOf<float, N>(device_.get(), *found);
    for (int c = 0; c < N; ++c) {
      SCOPED_TRACE(c);
      ASSERT_NO_FATAL_FAILURE(ExpectSamePlane(planes[static_cast<size_t>(c)], expected[c]));
    }
  }

  /// \param images  of FindImages
  void ExpectLayer(const vulkan::LayerImages& found, const Selected& expected,
                   const Image1& images) {
    const Guides& g = expected.guides;
    ExpectPlane(found.depth, g.depth);
    ExpectPlane(found.roughness, g.roughness);
    ExpectPlanes(found.normal, g.normal);
    ExpectPlanes(found.motion, g.motion);
    ExpectPlanes(found.albedo, expected.albedo);
    ExpectSamePlane(PlanesOf<float, 4>(device_.get(), *found.albedo)[3], images);
    ExpectPlanes(found.previous_normal, g.previous_normal);
    test::ExpectEqual(PlanesOf<uint32_t, 1>(device_.get(), *found.id)[0], g.id);
  }

  // Against the formula in double precision.
  void ExpectMoments(const gpu::Image* found, const Signal& signal, const Frame& f,
                     const Image3& own, const Selected& selected) {
    const Image1 moments = PlanesOf<float, 1>(device_.get(), *found)[0];
    const auto divided = [](const Image3& light, const Image3& albedo, int x, int y) {
      const double weights[] = {0.2126, 0.7152, 0.0722};
      double sum = 0;
      for (int c = 0; c < 3; ++c) {
        sum += weights[c] * static_cast<double>(light[c](x, y)) /
               std::max(static_cast<double>(albedo[c](x, y)), 0.01);
      }
      return sum;
    };
    const auto luminance = [](const Image3& albedo, int x, int y) {
      return std::max(0.2126 * static_cast<double>(albedo[0](x, y)) +
                          0.7152 * static_cast<double>(albedo[1](x, y)) +
                          0.0722 * static_cast<double>(albedo[2](x, y)),
                      0.01);
    };
    for (int y = 0; y < f.height; ++y) {
      for (int x = 0; x < f.width; ++x) {
        const double mean = divided(signal.radiance, own, x, y);
        const double new_mean = divided(signal.radiance, selected.albedo, x, y);
        const double ratio = luminance(own, x, y) / luminance(selected.albedo, x, y);
        const double variance =
            std::max(static_cast<double>(signal.second_moment(x, y)) - mean * mean, 0.0);
        const double expected = variance * ratio * ratio + new_mean * new_mean;
        ASSERT_NEAR(moments(x, y), expected, 1e-5 * expected) << x << " " << y;
      }
    }
  }

  // A layer of a frame, with its albedo in place of its picture: the alpha is the images' depth.
  Frame MakeExpectedLayer(const Frame& f, const Frame& stays, GuideSource source,
                          vulkan::LayerSplit* split) {
    const Result<Frame> layer = split->MakeLayer(stays, source, SelectSettings());
    EXPECT_TRUE(layer.ok()) << layer.status().message();
    EXPECT_NO_FATAL_FAILURE(RunPart(*layer));
    const vulkan::LayerImages& images = *split->images(source);
    const Selected expected(f, source);
    const Image3& own = SurfaceAlbedoOf(f.guides, source);
    const size_t light = source == GuideSource::kReflection ? 2 : 4;
    EXPECT_NO_FATAL_FAILURE(ExpectLayer(images, expected, ImagesOf(f, expected.guides, source)));
    EXPECT_NO_FATAL_FAILURE(
        ExpectMoments(images.direct_moment, f.signals[light], f, own, expected));
    EXPECT_NO_FATAL_FAILURE(
        ExpectMoments(images.indirect_moment, f.signals[light + 1], f, own, expected));
    auto* part = dynamic_cast<vulkan::FramePart*>(layer->on_device.get());
    part->picture = vulkan::RefTo(images.albedo);
    return *layer;
  }

  // The layers and the rest of a frame. \param with_glass  it has transmitted light
  void ExpectParts(const Frame& f, bool with_glass, vulkan::LayerSplit* split) {
    const Frame stays = PutOnDevice(device_, f);
    std::vector<Frame> layers;
    Image2 motion = f.guides.motion;
    Image3 emission = f.emission;
    Image1 length(f.width, f.height);
    for (const GuideSource source : kSources) {
      if (source == GuideSource::kRefraction && !with_glass) {
        continue;
      }
      SCOPED_TRACE(source == GuideSource::kReflection ? "reflection" : "refraction");
      layers.push_back(MakeExpectedLayer(f, stays, source, split));
      const Selected selected(f, source);
      const Image1 shown = ImagesOf(f, selected.guides, source);
      FollowImages(shown, f.guides, selected.guides.motion, &motion);
      TakeLengths(shown, shown, &length);
      for (int c = 0; c < 3; ++c) {
        for (int y = 0; y < f.height; ++y) {
          for (int x = 0; x < f.width; ++x) {
            emission[c](x, y) += selected.albedo[c](x, y);
          }
        }
      }
    }
    const Result<Frame> rest = split->MakeRest(stays);
    ASSERT_TRUE(rest.ok()) << rest.status().message();
    ASSERT_NO_FATAL_FAILURE(RunPart(*rest));
    const vulkan::LayerImages& images =
        *split->images(with_glass ? GuideSource::kRefraction : GuideSource::kReflection);
    ASSERT_NO_FATAL_FAILURE(ExpectPlanes(images.picture_motion, motion));
    ASSERT_NO_FATAL_FAILURE(ExpectPlanes(images.emission, emission));
    ExpectSamePlane(PlanesOf<float, 4>(device_.get(), *images.emission)[3], length);
    const auto* part = dynamic_cast<const vulkan::FramePart*>(rest->on_device.get());
    EXPECT_EQ(part->facts.black_lights, with_glass ? 0b111100u : 0b1100u);
    EXPECT_FALSE(part->facts.has_reflection);
    EXPECT_FALSE(part->facts.has_refraction);
  }
};

/// Without transmitted light.
Frame WithoutGlass(Frame f) {
  f.signals.resize(4);
  f.guides.transmission_albedo = Image3();
  f.refraction = VirtualGuides();
  return f;
}

// The same object for all sizes, as for frames of a window whose size changes.
TEST_F(LayerSplitTest, PartsAreThoseOfTheHost) {
  const auto split = vulkan::LayerSplit::Create(device_);
  ASSERT_TRUE(split.ok()) << split.status().message();
  for (const test::PictureSize& size : test::kPictureSizes) {
    SCOPED_TRACE(std::to_string(size.width) + "x" + std::to_string(size.height));
    const Frame f = RandomFrame(size.width, size.height);
    ASSERT_NO_FATAL_FAILURE(ExpectParts(f, true, split->get()));
    ASSERT_NO_FATAL_FAILURE(ExpectParts(WithoutGlass(f), false, split->get()));
  }
}

// As docs/gpu.md states it, beside alignment.
TEST_F(LayerSplitTest, TakesTheMemoryThatIsStated) {
  const auto bytes_per_pixel = [&](const Frame& f) {
    const auto split = vulkan::LayerSplit::Create(device_);
    EXPECT_TRUE(split.ok());
    EXPECT_EQ((*split)->memory().bytes, 0u);
    EXPECT_TRUE((*split)
                    ->MakeLayer(PutOnDevice(device_, f), GuideSource::kReflection, SelectSettings())
                    .ok());
    return static_cast<double>((*split)->memory().bytes) / (f.width * f.height);
  };
  Frame f = RandomFrame(256, 128);
  EXPECT_NEAR(bytes_per_pixel(f), 100, 1);
  f.guides.previous_normal = Image3();
  EXPECT_NEAR(bytes_per_pixel(f), 84, 1);
  for (Signal& signal : f.signals) {
    signal.second_moment = Image1();
  }
  EXPECT_NEAR(bytes_per_pixel(f), 76, 1);
}

// What the first test compares has all cases in it.
TEST(LayerSplit, TheRandomFrameShowsImagesAndFollowsThem) {
  const Frame f = RandomFrame(67, 21);
  const Selected selected(f, GuideSource::kReflection);
  const Selected through(f, GuideSource::kRefraction);
  Image2 motion = f.guides.motion;
  FollowImages(ImagesOf(f, selected.guides, GuideSource::kReflection), f.guides,
               selected.guides.motion, &motion);
  int others = 0;
  int followed_others = 0;
  Image2 motion_through = f.guides.motion;
  FollowImages(ImagesOf(f, through.guides, GuideSource::kRefraction), f.guides,
               through.guides.motion, &motion_through);
  int images = 0;
  int followed = 0;
  int skies = 0;
  int moved_on_surface = 0;
  for (int y = 0; y < f.height; ++y) {
    for (int x = 0; x < f.width; ++x) {
      images += selected.guides.id(x, y) >= 1000 ? 1 : 0;
      moved_on_surface += selected.guides.depth(x, y) == f.guides.depth(x, y) &&
                                  selected.guides.motion[0](x, y) != f.guides.motion[0](x, y)
                              ? 1
                              : 0;
      skies += selected.guides.depth(x, y) == kImageOfSky ? 1 : 0;
      followed += motion[0](x, y) != f.guides.motion[0](x, y) ? 1 : 0;
      others += through.guides.id(x, y) >= 2000 ? 1 : 0;
      followed_others += motion_through[0](x, y) != f.guides.motion[0](x, y) ? 1 : 0;
    }
  }
  EXPECT_GT(images, 300);
  EXPECT_LT(images, 1100);
  EXPECT_GT(skies, 10);
  EXPECT_GT(moved_on_surface, 10);
  EXPECT_GT(followed, 10);
  EXPECT_GT(others, images / 2);
  EXPECT_GT(followed_others, 0);
}

using MakeFrame = Frame(int width, int height, int index, bool second_moments);

/// Pictures of frames on the device and of the same frames on the host.
class LayersOnDevice : public test::DeviceTest {
 protected:
  void ExpectSamePictures(const Settings& settings, DevicePrecision precision, bool second_moments,
                          const std::vector<std::string>& outputs, MakeFrame* make = MakeMirrors) {
    Denoiser from_host = MakeDenoiser(settings, precision);
    Denoiser stays = MakeDenoiser(settings, precision);
    ASSERT_TRUE(from_host.SetOutputs(outputs).ok());
    ASSERT_TRUE(stays.SetOutputs(outputs).ok());
    const test::Tolerance tolerance =
        second_moments ? test::RescaledMoments(*device_) : test::Tolerance{1e-5, 0.0};
    for (int index = 0; index < 5; ++index) {
      SCOPED_TRACE(index);
      const Frame f = make(51, 37, index, second_moments);
      const Frame on_device = PutOnDevice(device_, f);
      DenoisedFrame expected;
      DenoisedFrame found;
      Status status = from_host.Denoise(f, &expected);
      ASSERT_TRUE(status.ok()) << status.message();
      status = stays.Denoise(on_device, &found);
      ASSERT_TRUE(status.ok()) << status.message();
      // A renderer reuses images without other references.
      EXPECT_EQ(on_device.on_device.use_count(), 1);
      EXPECT_EQ(found.non_finite, expected.non_finite);
      EXPECT_EQ(found.negative, expected.negative);
      EXPECT_GT(found.non_finite, 0u);
      if (!second_moments) {
        EXPECT_TRUE(test::SameBits(found.colour, expected.colour));
      }
      test::ExpectImage({"colour", {found.colour[0], found.colour[1], found.colour[2]}},
                        {"colour", {expected.colour[0], expected.colour[1], expected.colour[2]}},
                        tolerance, "on the device");
      ASSERT_EQ(found.images.size(), expected.images.size());
      for (size_t i = 0; i < found.images.size(); ++i) {
        test::ExpectImage(found.images[i], expected.images[i], tolerance, found.images[i].name);
      }
    }
    EXPECT_THAT(StageNames(&stays, make(51, 37, 5, second_moments)),
                ::testing::IsSupersetOf({"select_guides", "add_layer", "atrous1"}));
    EXPECT_LT(stays.device_memory().bytes, from_host.device_memory().bytes);
    EXPECT_EQ(stays.device_memory().bytes, stays.memory_bytes());
  }

  /// The stages that a frame on the device lists in its timings.
  std::vector<std::string> StageNames(Denoiser* denoiser, const Frame& frame) const {
    DenoisedFrame out;
    EXPECT_TRUE(denoiser->Denoise(PutOnDevice(device_, frame), &out).ok());
    std::vector<std::string> names;
    for (const StageTime& time : out.timings) {
      names.emplace_back(time.name);
    }
    return names;
  }
};

TEST_F(LayersOnDevice, PicturesAreThoseOfTheHost) {
  ExpectSamePictures(Settings(), DevicePrecision::kHalf, false, {});
}

TEST_F(LayersOnDevice, PicturesOfGlassAreThoseOfTheHost) {
  ExpectSamePictures(Settings(), DevicePrecision::kHalf, false, {}, MakeGlass);
  ExpectSamePictures(Settings(), DevicePrecision::kFloat, true,
                     {"temporal", "noisy.transmission", "filtered.transmission"}, MakeGlass);
}

TEST_F(LayersOnDevice, PicturesOfSeveralSamplesAreThoseOfTheHost) {
  ExpectSamePictures(Settings(), DevicePrecision::kFloat, true, {});
}

TEST_F(LayersOnDevice, OutputsAreThoseOfTheHost) {
  ExpectSamePictures(
      Settings(), DevicePrecision::kFloat, false,
      {"temporal", "atrous2", "noisy.specular", "filtered.specular", "filtered.direct"});
}

// A sequence whose frames change place has one history, and that of another size a new one.
TEST_F(LayersOnDevice, FramesOfBothPlacesContinueOneHistory) {
  Denoiser from_host = MakeDenoiser(Settings(), DevicePrecision::kHalf);
  Denoiser mixed = MakeDenoiser(Settings(), DevicePrecision::kHalf);
  for (int index = 0; index < 7; ++index) {
    SCOPED_TRACE(index);
    const int width = index < 5 ? 40 : 33;
    Frame f = index < 5 ? MakeGlass(width, 24, index, false) : MakeMirrors(width, 24, index, false);
    if (index == 3) {
      f.reflection = VirtualGuides();
    }
    DenoisedFrame expected;
    DenoisedFrame found;
    ASSERT_TRUE(from_host.Denoise(f, &expected).ok());
    ASSERT_TRUE(mixed.Denoise(index % 2 == 0 ? f : PutOnDevice(device_, f), &found).ok());
    EXPECT_TRUE(test::SameBits(found.colour, expected.colour));
  }
}

TEST_F(LayersOnDevice, FutureLightIsThatOfTheHost) {
  Settings settings;
  DenoisedFrame expected;
  DenoisedFrame found;
  for (DenoisedFrame* out : {&expected, &found}) {
    Denoiser denoiser = MakeDenoiser(settings, DevicePrecision::kHalf);
    const auto place = [&](int index) {
      const Frame f = MakeGlass(40, 24, index, false);
      return out == &found ? PutOnDevice(device_, f) : f;
    };
    FutureLight future;
    for (int index = 4; index-- > 0;) {
      ASSERT_TRUE(denoiser.Accumulate(place(index), &future).ok());
    }
    denoiser.Reset();
    ASSERT_TRUE(denoiser.Denoise(place(0), future, out).ok());
  }
  EXPECT_TRUE(test::SameBits(found.colour, expected.colour));
}

// Frames of another device and denoisers on the CPU take the images over the host.
TEST_F(LayersOnDevice, OtherPlacesBringThemToTheHost) {
  Result<std::shared_ptr<gpu::Device>> other = gpu::Device::Create(instance_, device_->info());
  ASSERT_TRUE(other.ok()) << other.status().message();
  const Frame f = MakeMirrors(40, 24, 1, false);
  const Frame elsewhere = PutOnDevice(*other, f);
  DenoisedFrame expected;
  DenoisedFrame found;
  ASSERT_TRUE(MakeDenoiser(Settings(), DevicePrecision::kHalf).Denoise(f, &expected).ok());
  ASSERT_TRUE(MakeDenoiser(Settings(), DevicePrecision::kHalf).Denoise(elsewhere, &found).ok());
  EXPECT_TRUE(test::SameBits(found.colour, expected.colour));
  ASSERT_TRUE(Denoiser::Create(Settings())->Denoise(f, &expected).ok());
  ASSERT_TRUE(Denoiser::Create(Settings())->Denoise(elsewhere, &found).ok());
  EXPECT_TRUE(test::SameBits(found.colour, expected.colour));
}

TEST_F(LayersOnDevice, AFrameOfAnotherSizeIsRefused) {
  Frame lies = PutOnDevice(device_, MakeMirrors(8, 8, 0, false));
  lies.width = 9;
  DenoisedFrame out;
  const Status status = MakeDenoiser(Settings(), DevicePrecision::kHalf).Denoise(lies, &out);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("size is 9x8, its images on the device are 8x8"),
            std::string::npos)
      << status.message();
}

}  // namespace
}  // namespace stillray::layer_split_test

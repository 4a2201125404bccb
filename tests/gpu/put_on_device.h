// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of tests in the images that a renderer leaves on its device, and images read from there.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/plan.h"
#include "gpu/device_frame.h"

namespace stillray::test {

inline int ChannelsOf(const gpu::Image& image) {
  return image.format == VK_FORMAT_R32G32B32A32_SFLOAT ? 4
         : image.format == VK_FORMAT_R32G32_SFLOAT     ? 2
                                                       : 1;
}

inline VkBufferImageCopy WholeImage(const gpu::Image& image) {
  VkBufferImageCopy region = {};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {static_cast<uint32_t>(image.width), static_cast<uint32_t>(image.height), 1};
  return region;
}

/// Runs commands on a device with a buffer of the host for the pixels of an image.
inline void RunWithPixels(gpu::Device* device, const gpu::Image& image, gpu::BufferPlace place,
                          const std::function<void(uint32_t* pixels)>& before,
                          const std::function<void(VkCommandBuffer, VkBuffer)>& record,
                          const std::function<void(const uint32_t* pixels)>& after) {
  gpu::Arena arena(&device->context());
  const VkDeviceSize bytes = VkDeviceSize{4} * static_cast<VkDeviceSize>(ChannelsOf(image)) *
                             static_cast<VkDeviceSize>(image.width) *
                             static_cast<VkDeviceSize>(image.height);
  const Result<const gpu::Buffer*> buffer = arena.AddBuffer(bytes, 0, place);
  ASSERT_TRUE(buffer.ok() && arena.Allocate().ok());
  auto* pixels = static_cast<uint32_t*>((*buffer)->mapped);
  before(pixels);
  ASSERT_TRUE(arena.Flush().ok());
  {
    const gpu::FairLock lock = device->Lock();
    const Result<VkCommandBuffer> commands = device->Begin();
    ASSERT_TRUE(commands.ok());
    record(*commands, (*buffer)->buffer);
    const Status run = device->Run();
    ASSERT_TRUE(run.ok()) << run.message();
  }
  ASSERT_TRUE(arena.Invalidate().ok());
  after(pixels);
}

/// Copies planes to the first channels of an image in VK_IMAGE_LAYOUT_GENERAL; planes that are
/// empty are zero there.
template <typename T>
void PutPlanes(gpu::Device* device, const gpu::Image* image, std::span<const Plane<T>> planes) {
  if (image == nullptr) {
    return;
  }
  const auto channels = static_cast<size_t>(ChannelsOf(*image));
  const auto width = static_cast<size_t>(image->width);
  RunWithPixels(
      device, *image, gpu::BufferPlace::kUpload,
      [&](uint32_t* pixels) {
        std::fill_n(pixels, channels * width * static_cast<size_t>(image->height), 0u);
        for (size_t c = 0; c < planes.size(); ++c) {
          for (int y = 0; y < planes[c].height(); ++y) {
            for (size_t x = 0; x < width; ++x) {
              std::memcpy(pixels + (static_cast<size_t>(y) * width + x) * channels + c,
                          planes[c].Row(y) + x, sizeof(T));
            }
          }
        }
      },
      [&](VkCommandBuffer commands, VkBuffer buffer) {
        const VkBufferImageCopy region = WholeImage(*image);
        device->context().vk.CmdCopyBufferToImage(commands, buffer, image->image,
                                                  VK_IMAGE_LAYOUT_GENERAL, 1, &region);
        gpu::MemoryBarrier(device->context(), commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                           VK_ACCESS_TRANSFER_WRITE_BIT,
                           VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                           VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT);
      },
      [](const uint32_t*) {});
}

/// The first `N` channels of an image that shaders have written.
template <typename T, size_t N>
std::array<Plane<T>, N> PlanesOf(gpu::Device* device, const gpu::Image& image) {
  std::array<Plane<T>, N> planes;
  const auto channels = static_cast<size_t>(ChannelsOf(image));
  RunWithPixels(
      device, image, gpu::BufferPlace::kDownload, [](uint32_t*) {},
      [&](VkCommandBuffer commands, VkBuffer buffer) {
        const gpu::DeviceContext& c = device->context();
        const VkBufferImageCopy region = WholeImage(image);
        gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                           VK_ACCESS_SHADER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                           VK_ACCESS_TRANSFER_READ_BIT);
        c.vk.CmdCopyImageToBuffer(commands, image.image, VK_IMAGE_LAYOUT_GENERAL, buffer, 1,
                                  &region);
        gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                           VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                           VK_ACCESS_HOST_READ_BIT);
      },
      [&](const uint32_t* pixels) {
        for (size_t n = 0; n < N; ++n) {
          planes[n] = Plane<T>(image.width, image.height);
          for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < image.width; ++x) {
              std::memcpy(&planes[n](x, y), pixels + (y * image.width + x) * channels + n,
                          sizeof(T));
            }
          }
        }
      });
  return planes;
}

/// The frame with its pixels on the device. It has direct and indirect, diffuse and specular light,
/// perhaps transmitted light too; guides that it lacks are zero.
inline Frame PutOnDevice(const std::shared_ptr<gpu::Device>& device, const Frame& f) {
  gpu::FrameShape shape;
  shape.width = f.width;
  shape.height = f.height;
  shape.second_moments = !f.signals.front().second_moment.empty();
  shape.samples = !f.samples.empty();
  shape.previous_normals = !f.guides.previous_normal.empty();
  shape.reflection = !f.reflection.empty();
  shape.transmission = HasTransmission(f);
  Result<std::shared_ptr<gpu::DeviceFrame>> made = gpu::DeviceFrame::Create(device, shape);
  EXPECT_TRUE(made.ok()) << made.status().message();
  {
    const gpu::FairLock lock = device->Lock();
    const Result<VkCommandBuffer> commands = device->Begin();
    EXPECT_TRUE(commands.ok());
    (*made)->RecordBegin(*commands);
    EXPECT_TRUE(device->Run().ok());
  }
  std::vector<double> row_sums;
  (*made)->samples_per_pixel = SamplesPerPixel(f, &row_sums);
  (*made)->has_incomplete_guides = HasIncompleteGuides(f);
  const gpu::FrameImages& to = (*made)->images();
  const auto put = [&](const gpu::Image* image, const auto& plane) {
    PutPlanes(device.get(), image, std::span(&plane, 1));
  };
  const auto put_all = [&](const gpu::Image* image, const auto& planes) {
    PutPlanes(device.get(), image, std::span<const Image1>(planes.channel));
  };
  EXPECT_EQ(f.signals.size(), (*made)->lights().size());
  for (size_t k = 0; k < f.signals.size(); ++k) {
    put_all(to.lights[k], f.signals[k].radiance);
    put(to.second_moments[k], f.signals[k].second_moment);
  }
  const Guides& g = f.guides;
  put(to.samples, f.samples);
  put_all(to.emission, f.emission);
  put_all(to.background, f.background);
  put(to.depth, g.depth);
  put_all(to.normal, g.normal);
  put_all(to.albedo, g.albedo);
  put_all(to.specular_albedo, g.specular_albedo);
  put_all(to.transmission_albedo, g.transmission_albedo);
  put_all(to.motion, g.motion);
  put(to.id, g.id);
  put(to.roughness, g.roughness);
  put_all(to.previous_normal, g.previous_normal);
  for (const auto& [seen, image] :
       {std::pair{&f.reflection, &to.reflection}, std::pair{&f.refraction, &to.refraction}}) {
    put(image->depth, seen->depth);
    put_all(image->normal, seen->normal);
    put_all(image->albedo, seen->albedo);
    put_all(image->motion, seen->motion);
    put(image->id, seen->id);
  }
  Frame out;
  out.width = f.width;
  out.height = f.height;
  out.index = f.index;
  out.jitter_x = f.jitter_x;
  out.jitter_y = f.jitter_y;
  out.focal_pixels = f.focal_pixels;
  for (const Signal& signal : f.signals) {
    out.signals.push_back({signal.kind, Image3(), Image1()});
  }
  out.on_device = std::move(*made);
  return out;
}

}  // namespace stillray::test

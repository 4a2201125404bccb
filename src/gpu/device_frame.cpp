// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/device_frame.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "core/parallel.h"

namespace stillray::gpu {
namespace {

constexpr VkPipelineStageFlags kStages =
    VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
constexpr VkAccessFlags kWrites = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;

/// Number of 32-bit channels.
int ChannelsOf(const Image& image) {
  return image.format == VK_FORMAT_R32G32B32A32_SFLOAT ? 4
         : image.format == VK_FORMAT_R32G32_SFLOAT     ? 2
                                                       : 1;
}

/// Bytes of an image, rounded up so that the next copy in the buffer is aligned for any format.
VkDeviceSize AlignedBytesOf(const Image& image) {
  return (VkDeviceSize{BytesOf(image)} + 15) / 16 * 16;
}

template <typename Visit>
void ForEachVirtualImage(const VirtualImages& images, VirtualGuides* guides, const Visit& visit) {
  visit(images.depth, std::span(&guides->depth, 1));
  visit(images.normal, std::span(guides->normal.channel));
  visit(images.albedo, std::span(guides->albedo.channel));
  visit(images.motion, std::span(guides->motion.channel));
  visit(images.id, std::span(&guides->id, 1));
}

/// Calls visit(image, destination planes of the frame) for the selected `planes`. The image is
/// nullptr for planes that become empty.
template <typename Visit>
void ForEachImage(const FrameImages& images, uint32_t planes, Frame* frame, const Visit& visit) {
  if ((planes & kLightPlanes) != 0) {
    for (size_t k = 0; k < frame->signals.size(); ++k) {
      visit(images.lights[k], std::span(frame->signals[k].radiance.channel));
      visit(images.second_moments[k], std::span(&frame->signals[k].second_moment, 1));
    }
    visit(images.samples, std::span(&frame->samples, 1));
    visit(images.emission, std::span(frame->emission.channel));
    visit(images.background, std::span(frame->background.channel));
  }
  if ((planes & kGuidePlanes) != 0) {
    Guides& g = frame->guides;
    visit(images.depth, std::span(&g.depth, 1));
    visit(images.normal, std::span(g.normal.channel));
    visit(images.albedo, std::span(g.albedo.channel));
    visit(images.specular_albedo, std::span(g.specular_albedo.channel));
    visit(images.transmission_albedo, std::span(g.transmission_albedo.channel));
    visit(images.motion, std::span(g.motion.channel));
    visit(images.id, std::span(&g.id, 1));
    visit(images.roughness, std::span(&g.roughness, 1));
    visit(images.previous_normal, std::span(g.previous_normal.channel));
    visit(nullptr, std::span(&frame->confidence, 1));
    ForEachVirtualImage(images.reflection, &frame->reflection, visit);
    ForEachVirtualImage(images.refraction, &frame->refraction, visit);
  }
}

/// Converts interleaved channels to planes.
template <typename T, size_t N>
void TakePixels(const Image& image, const void* from, std::span<Plane<T>, N> planes) {
  const auto channels = static_cast<size_t>(ChannelsOf(image));
  for (Plane<T>& plane : planes) {
    if (plane.width() != image.width || plane.height() != image.height) {
      plane = Plane<T>(image.width, image.height);
    }
  }
  ParallelRows(image.height, 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const T* row = static_cast<const T*>(from) +
                     static_cast<size_t>(y) * static_cast<size_t>(image.width) * channels;
      for (size_t c = 0; c < planes.size(); ++c) {
        T* to = planes[c].Row(y);
        for (int x = 0; x < image.width; ++x) {
          to[x] = row[static_cast<size_t>(x) * channels + c];
        }
      }
    }
  });
}

}  // namespace

Status DeviceFrame::AddImages() {
  Status status;
  const auto add = [&](VkFormat format, const Image** to) {
    if (!status.ok()) {
      return;
    }
    const Result<const Image*> added = arena_.AddImage(format, shape_.width, shape_.height, 0);
    status = added.status();
    *to = added.ok() ? *added : nullptr;
  };
  constexpr VkFormat kColour = VK_FORMAT_R32G32B32A32_SFLOAT;
  constexpr VkFormat kScalar = VK_FORMAT_R32_SFLOAT;
  constexpr VkFormat kMotion = VK_FORMAT_R32G32_SFLOAT;
  constexpr VkFormat kId = VK_FORMAT_R32_UINT;
  for (size_t k = 0; k < lights().size(); ++k) {
    add(kColour, &images_.lights[k]);
    if (shape_.second_moments) {
      add(kScalar, &images_.second_moments[k]);
    }
  }
  if (shape_.samples) {
    add(kScalar, &images_.samples);
  }
  for (const Image** image : {&images_.emission, &images_.background, &images_.normal,
                              &images_.albedo, &images_.specular_albedo}) {
    add(kColour, image);
  }
  if (shape_.previous_normals) {
    add(kColour, &images_.previous_normal);
  }
  add(kScalar, &images_.depth);
  add(kScalar, &images_.roughness);
  add(kMotion, &images_.motion);
  add(kId, &images_.id);
  if (shape_.transmission) {
    add(kColour, &images_.transmission_albedo);
  }
  for (const auto& [wanted, image] : {std::pair{shape_.reflection, &images_.reflection},
                                      std::pair{shape_.transmission, &images_.refraction}}) {
    if (wanted) {
      add(kScalar, &image->depth);
      add(kColour, &image->normal);
      add(kColour, &image->albedo);
      add(kMotion, &image->motion);
      add(kId, &image->id);
    }
  }
  return status;
}

Result<std::shared_ptr<DeviceFrame>> DeviceFrame::Create(std::shared_ptr<Device> device,
                                                         const FrameShape& shape) {
  const auto most =
      static_cast<int>(std::min<uint32_t>(device->context().limits.maxImageDimension2D, 1u << 30));
  if (shape.width < 1 || shape.height < 1 || std::max(shape.width, shape.height) > most) {
    return Status::InvalidArgument(
        fmt::format("a frame on the device is {}x{}, expected 1x1 to {}x{}", shape.width,
                    shape.height, most, most));
  }
  std::shared_ptr<DeviceFrame> made(new DeviceFrame(std::move(device), shape));
  STILLRAY_RETURN_IF_ERROR(made->AddImages());
  STILLRAY_RETURN_IF_ERROR(made->arena_.Allocate());
  return made;
}

uint64_t DeviceFrame::bytes() const {
  const std::lock_guard lock(download_);
  return arena_.Need().bytes + (staging_ != nullptr ? staging_->arena.Need().bytes : 0);
}

void DeviceFrame::RecordBegin(VkCommandBuffer commands) const {
  arena_.RecordFirstUse(commands, kStages, kWrites);
}

void DeviceFrame::RecordEnd(VkCommandBuffer commands) const {
  MemoryBarrier(device_->context(), commands, kStages, kWrites, kStages,
                VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT);
}

Status DeviceFrame::MakeStaging() const {
  if (staging_ != nullptr) {
    return Status::Ok();
  }
  Frame layout;
  layout.signals.resize(lights().size());
  VkDeviceSize bytes = 0;
  ForEachImage(images_, kAllPlanes, &layout, [&](const Image* image, const auto&) {
    bytes += image != nullptr ? AlignedBytesOf(*image) : 0;
  });
  auto staging = std::make_unique<Staging>(&device_->context());
  const Result<const Buffer*> buffer = staging->arena.AddBuffer(bytes, 0, BufferPlace::kDownload);
  STILLRAY_RETURN_IF_ERROR(buffer.status());
  STILLRAY_RETURN_IF_ERROR(staging->arena.Allocate());
  staging->buffer = *buffer;
  staging_ = std::move(staging);
  return Status::Ok();
}

Status DeviceFrame::Download(uint32_t planes, Frame* host) const {
  const std::lock_guard one_at_a_time(download_);
  try {
    STILLRAY_RETURN_IF_ERROR(MakeStaging());
    host->signals.resize(lights().size());
    for (size_t k = 0; k < host->signals.size(); ++k) {
      host->signals[k].kind = static_cast<SignalKind>(k);
    }
    {
      const DeviceContext& c = device_->context();
      const FairLock lock = device_->Lock();
      const Result<VkCommandBuffer> commands = device_->Begin();
      STILLRAY_RETURN_IF_ERROR(commands.status());
      VkBufferImageCopy region = {};
      region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
      region.imageExtent = {static_cast<uint32_t>(shape_.width),
                            static_cast<uint32_t>(shape_.height), 1};
      ForEachImage(images_, planes, host, [&](const Image* image, const auto&) {
        if (image != nullptr) {
          c.vk.CmdCopyImageToBuffer(*commands, image->image, VK_IMAGE_LAYOUT_GENERAL,
                                    staging_->buffer->buffer, 1, &region);
          region.bufferOffset += AlignedBytesOf(*image);
        }
      });
      MemoryBarrier(c, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                    VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
      STILLRAY_RETURN_IF_ERROR(device_->Run());
    }
    STILLRAY_RETURN_IF_ERROR(staging_->arena.Invalidate());
    const auto* from = static_cast<const char*>(staging_->buffer->mapped);
    ForEachImage(images_, planes, host, [&](const Image* image, const auto& of_frame) {
      if (image != nullptr) {
        TakePixels(*image, from, of_frame);
        from += AlignedBytesOf(*image);
        return;
      }
      for (auto& plane : of_frame) {
        plane = {};
      }
    });
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("bringing a frame to the host: out of memory");
  }
  return Status::Ok();
}

const DeviceFrame* FrameOn(const Device& device, const Frame& frame) {
  const auto* found = dynamic_cast<const DeviceFrame*>(frame.on_device.get());
  return found != nullptr && found->device().get() == &device ? found : nullptr;
}

}  // namespace stillray::gpu

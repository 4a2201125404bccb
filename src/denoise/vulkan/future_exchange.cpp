// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/future_exchange.h"

#include <array>
#include <utility>

#include "core/parallel.h"

namespace stillray::vulkan {
namespace {

constexpr int kTexel = 4;   ///< floats per texel
constexpr int kImages = 2;  ///< colour and moments

/// The planes that the channels of an image store, in order; nullptr: unused channel.
template <typename History>
auto PlanesOf(History& h, int which) {
  using Plane = decltype(&h.mean);
  return which == 0 ? std::array<Plane, kTexel>{&h.colour[0], &h.colour[1], &h.colour[2], &h.length}
                    : std::array<Plane, kTexel>{&h.mean, &h.variance, &h.weights2, nullptr};
}

/// Position of an image in staging memory.
VkBufferImageCopy PlaceOf(const gpu::Image& image, VkDeviceSize which) {
  VkBufferImageCopy region = {};
  const auto layers = static_cast<uint32_t>(image.layers);
  const auto width = static_cast<uint32_t>(image.width);
  const auto height = static_cast<uint32_t>(image.height);
  region.bufferOffset = which * layers * kTexel * sizeof(float) * width * height;
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, layers};
  region.imageExtent = {width, height, 1};
  return region;
}

}  // namespace

Result<std::unique_ptr<FutureExchange>> FutureExchange::Create(const gpu::DeviceContext* context,
                                                               int width, int height, int signals) {
  std::unique_ptr<FutureExchange> made(new FutureExchange(context));
  made->width_ = width;
  made->height_ = height;
  made->signals_ = signals;
  for (const gpu::Image** image : {&made->images_.light, &made->images_.moments}) {
    const Result<const gpu::Image*> added =
        made->arena_.AddImage(VK_FORMAT_R32G32B32A32_SFLOAT, width, height, signals);
    STILLRAY_RETURN_IF_ERROR(added.status());
    *image = *added;
  }
  // The host reads the buffer in one of the two directions, which requires cached memory.
  const VkDeviceSize bytes = VkDeviceSize{kImages} * kTexel * sizeof(float) *
                             static_cast<VkDeviceSize>(width) * static_cast<VkDeviceSize>(height) *
                             static_cast<VkDeviceSize>(signals);
  const Result<const gpu::Buffer*> staging =
      made->arena_.AddBuffer(bytes, 0, gpu::BufferPlace::kDownload);
  STILLRAY_RETURN_IF_ERROR(staging.status());
  made->staging_ = *staging;
  STILLRAY_RETURN_IF_ERROR(made->arena_.Allocate());
  return made;
}

float* FutureExchange::Row(int which, int signal, int y) const {
  const int row = (which * signals_ + signal) * height_ + y;
  return static_cast<float*>(staging_->mapped) + static_cast<ptrdiff_t>(row) * width_ * kTexel;
}

void FutureExchange::Prepare(VkCommandBuffer commands) {
  if (!prepared_) {
    prepared_ = true;
    arena_.RecordFirstUse(commands,
                          VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                          VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_SHADER_WRITE_BIT);
  }
}

Status FutureExchange::Write(std::span<const SignalHistory> future) {
  ParallelRows(height_, kRowsPerTask, [&](int y0, int y1) {
    for (int which = 0; which < kImages; ++which) {
      for (int s = 0; s < signals_; ++s) {
        const auto planes = PlanesOf(future[static_cast<size_t>(s)], which);
        for (int y = y0; y < y1; ++y) {
          float* to = Row(which, s, y);
          for (int c = 0; c < kTexel; ++c) {
            const Image1* plane = planes[static_cast<size_t>(c)];
            for (int x = 0; x < width_; ++x) {
              to[x * kTexel + c] = plane != nullptr ? plane->Row(y)[x] : 0.0f;
            }
          }
        }
      }
    }
  });
  return arena_.Flush();
}

Status FutureExchange::Read(std::vector<SignalHistory>* future) const {
  STILLRAY_RETURN_IF_ERROR(arena_.Invalidate());
  future->assign(static_cast<size_t>(signals_), SignalHistory(width_, height_));
  ParallelRows(height_, kRowsPerTask, [&](int y0, int y1) {
    for (int which = 0; which < kImages; ++which) {
      for (int s = 0; s < signals_; ++s) {
        const auto planes = PlanesOf((*future)[static_cast<size_t>(s)], which);
        for (int y = y0; y < y1; ++y) {
          const float* from = Row(which, s, y);
          for (int c = 0; c < kTexel && planes[static_cast<size_t>(c)] != nullptr; ++c) {
            float* to = planes[static_cast<size_t>(c)]->Row(y);
            for (int x = 0; x < width_; ++x) {
              to[x] = from[x * kTexel + c];
            }
          }
        }
      }
    }
  });
  return Status::Ok();
}

void FutureExchange::RecordUpload(VkCommandBuffer commands) {
  VkDeviceSize which = 0;
  for (const gpu::Image* image : {images_.light, images_.moments}) {
    const VkBufferImageCopy region = PlaceOf(*image, which++);
    context_->vk.CmdCopyBufferToImage(commands, staging_->buffer, image->image,
                                      VK_IMAGE_LAYOUT_GENERAL, 1, &region);
  }
}

void FutureExchange::RecordDownload(VkCommandBuffer commands) {
  gpu::MemoryBarrier(*context_, commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                     VK_ACCESS_SHADER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                     VK_ACCESS_TRANSFER_READ_BIT);
  VkDeviceSize which = 0;
  for (const gpu::Image* image : {images_.light, images_.moments}) {
    const VkBufferImageCopy region = PlaceOf(*image, which++);
    context_->vk.CmdCopyImageToBuffer(commands, image->image, VK_IMAGE_LAYOUT_GENERAL,
                                      staging_->buffer, 1, &region);
  }
  gpu::MemoryBarrier(*context_, commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                     VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                     VK_ACCESS_HOST_READ_BIT);
}

}  // namespace stillray::vulkan

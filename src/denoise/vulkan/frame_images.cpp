// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/frame_images.h"

#include <initializer_list>

#include "core/negative_limit_shared.h"
#include "denoise/stages/follow_light_shared.h"
#include "denoise/stages/sum_albedo_shared.h"
#include "denoise/vulkan/frame_shared.h"

namespace stillray::vulkan {
namespace {

/// Adds images until the first error, so that callers check only once.
class Adder {
 public:
  Adder(const Shape& shape, gpu::Arena* arena) : shape_(shape), arena_(arena) {}

  const gpu::Image* Add(VkFormat format, int width, int height, int layers) {
    return status_.ok() ? Take(arena_->AddImage(format, width, height, layers)) : nullptr;
  }
  const gpu::Image* Picture(VkFormat format, int layers) {
    return Add(format, shape_.width, shape_.height, layers);
  }
  const gpu::Buffer* AddBuffer(VkDeviceSize size, VkBufferUsageFlags usage) {
    return status_.ok() ? Take(arena_->AddBuffer(size, usage, gpu::BufferPlace::kDevice)) : nullptr;
  }
  const Status& status() const { return status_; }

 private:
  template <typename T>
  const T* Take(Result<const T*> added) {
    if (!added.ok()) {
      status_ = added.status();
      return nullptr;
    }
    return *added;
  }

  const Shape& shape_;
  gpu::Arena* arena_;
  Status status_;
};

}  // namespace

Result<FrameImages> AddImages(const Shape& shape, gpu::Arena* arena) {
  const bool half = shape.storage == Storage::kHalf;
  const VkFormat light = half ? VK_FORMAT_R16G16B16A16_SFLOAT : VK_FORMAT_R32G32B32A32_SFLOAT;
  const VkFormat scalar = half ? VK_FORMAT_R16_SFLOAT : VK_FORMAT_R32_SFLOAT;
  const VkFormat fraction = half ? VK_FORMAT_R16_UNORM : VK_FORMAT_R32_SFLOAT;
  const VkFormat surface = shape.octahedral ? VK_FORMAT_R32G32_UINT : VK_FORMAT_R32G32B32A32_UINT;
  const VkFormat detail = half ? VK_FORMAT_R32G32_UINT : VK_FORMAT_R32G32B32A32_UINT;
  const int n = shape.signals;
  Adder adder(shape, arena);
  FrameImages images;
  images.nothing = adder.Add(light, 1, 1, 1);
  images.nothing_scalar = adder.Add(scalar, 1, 1, 1);
  images.nothing_fraction = adder.Add(fraction, 1, 1, 1);
  images.no_input = adder.Add(VK_FORMAT_R32_SFLOAT, 1, 1, 0);
  images.no_ids = adder.Add(VK_FORMAT_R32_UINT, 1, 1, 0);
  images.no_float_output = adder.Add(VK_FORMAT_R32G32B32A32_SFLOAT, 1, 1, 0);
  images.no_half_output = adder.Add(VK_FORMAT_R16G16B16A16_SFLOAT, 1, 1, 0);
  images.no_display = adder.Add(VK_FORMAT_R8G8B8A8_UNORM, 1, 1, 0);
  for (HistoryImages* history : {&images.history, &images.fetched}) {
    history->colour = adder.Picture(light, n);
    history->behind = shape.with_behind ? adder.Picture(light, n) : images.nothing;
    history->moments = adder.Picture(light, n);
    history->compressed =
        shape.with_compressed ? adder.Picture(fraction, n) : images.nothing_fraction;
  }
  images.noisy = adder.Picture(light, n);
  images.unclamped = shape.clamps_fireflies ? adder.Picture(light, n) : images.nothing;
  images.within = shape.with_within ? adder.Picture(scalar, n) : images.nothing_scalar;
  images.wavelet[0] = adder.Picture(light, n);
  images.wavelet[1] = adder.Picture(light, n);
  images.luminance_factor =
      shape.luminance_factors ? adder.Picture(scalar, n) : images.nothing_scalar;
  for (GuideImages* guides : {&images.guides, &images.previous_guides}) {
    guides->surface = adder.Picture(surface, 0);
    guides->detail = adder.Picture(detail, 0);
  }
  images.turn2 = adder.Picture(scalar, 1);
  if (shape.with_coarse) {
    const int width = (shape.width + 1) / 2;
    const int height = (shape.height + 1) / 2;
    images.coarse.surface = adder.Add(surface, width, height, 0);
    images.coarse.detail = adder.Add(detail, width, height, 0);
    images.compared[0] = adder.Add(light, width, height, n);
    images.compared[1] = adder.Add(light, width, height, n);
    if (shape.with_compressed) {
      images.compressed_light = adder.Add(light, width, height, n);
      images.wide = adder.Add(light, width, height, n);
      images.ratio = adder.Add(scalar, width, height, n);
    }
  }
  images.picture = adder.Picture(light, 0);
  images.scratch = adder.Picture(light, 0);
  images.shown = adder.Picture(light, 0);
  if (shape.with_albedo) {
    images.albedo = adder.Picture(light, 0);
    images.albedo_range =
        adder.Add(light, AlbedoBlocks(shape.width), AlbedoBlocks(shape.height), 2);
    images.albedo_before = adder.Picture(light, 0);
    images.albedo_out = adder.Picture(light, 0);
  } else {
    images.albedo = images.albedo_before = images.no_input;
    images.albedo_range = images.nothing;
    images.albedo_out = half ? images.no_half_output : images.no_float_output;
  }
  const int blocks_x = FollowSize(shape.width);
  const int blocks_y = FollowSize(shape.height);
  images.changes = adder.Add(VK_FORMAT_R32G32B32A32_SFLOAT, blocks_x, blocks_y, 0);
  for (const gpu::Image** image :
       {&images.followed, &images.followed_before, &images.followed_ratio}) {
    *image = adder.Add(VK_FORMAT_R32_SFLOAT, blocks_x, blocks_y, 0);
  }
  images.parameters = adder.AddBuffer(sizeof(FrameParameters), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
  images.state = adder.AddBuffer(sizeof(FrameState), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  constexpr VkDeviceSize kBytesPerGroup = 2 * 4 * sizeof(float);
  constexpr VkDeviceSize kBytesBeforeGroups = (STILLRAY_LIGHT_BINS + 12) * sizeof(float);
  images.partials = adder.AddBuffer(
      kBytesBeforeGroups + GroupsFor(shape.width, shape.height).count() * kBytesPerGroup,
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  images.history_sums =
      adder.AddBuffer(GroupsFor(shape.width, shape.height).count() * 4 * sizeof(float),
                      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  return adder.status().ok() ? Result<FrameImages>(images) : Result<FrameImages>(adder.status());
}

}  // namespace stillray::vulkan

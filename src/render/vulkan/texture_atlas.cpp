// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/texture_atlas.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "render/texture_shared.h"

namespace stillray::render {
namespace {

constexpr int kBorder = 1;
/// Usual size of a layer, exceeded only if a texture requires it: large layers waste texels, since
/// the last layer is rarely full.
constexpr int kUsualSize = 4096;
constexpr int kMostMultiples = 8;
/// Textures are uploaded in pieces, of whole rows.
constexpr size_t kPieceBytes = size_t{32} << 20;

int WidthOf(const Texture& texture) {
  return texture.width + 2 * kBorder;
}
int HeightOf(const Texture& texture) {
  return texture.height + 2 * kBorder;
}

/// \param order  texture indices, tallest texture first
TextureAtlas Place(const std::vector<Texture>& textures, const std::vector<size_t>& order,
                   int width, int height) {
  TextureAtlas atlas;
  atlas.width = width;
  atlas.height = height;
  atlas.places.resize(textures.size());
  int x = 0;
  int y = 0;
  int row = 0;  // height of the current row
  for (const size_t i : order) {
    const int w = WidthOf(textures[i]);
    const int h = HeightOf(textures[i]);
    if (x + w > width) {
      x = 0;
      y += row;
      row = 0;
    }
    if (y + h > height) {
      x = 0;
      y = 0;
      row = 0;
      ++atlas.layers;
    }
    atlas.places[i] = {static_cast<uint32_t>(x + kBorder), static_cast<uint32_t>(y + kBorder),
                       static_cast<uint32_t>(atlas.layers - 1)};
    x += w;
    row = std::max(row, h);
  }
  if (atlas.layers == 1) {
    atlas.height = y + row;
  }
  return atlas;
}

double TexelsOf(const TextureAtlas& atlas) {
  return static_cast<double>(atlas.width) * atlas.height * atlas.layers;
}

void Transition(const gpu::DeviceContext& c, VkCommandBuffer commands, const gpu::Image& image,
                VkImageLayout from, VkImageLayout to) {
  const bool first = from == VK_IMAGE_LAYOUT_UNDEFINED;
  VkImageMemoryBarrier barrier = {};
  barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
  barrier.srcAccessMask = first ? 0 : VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.dstAccessMask = first ? VK_ACCESS_TRANSFER_WRITE_BIT : VK_ACCESS_SHADER_READ_BIT;
  barrier.oldLayout = from;
  barrier.newLayout = to;
  barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image.image;
  barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0,
                              static_cast<uint32_t>(image.layers)};
  constexpr VkPipelineStageFlags kCopy = VK_PIPELINE_STAGE_TRANSFER_BIT;
  c.vk.CmdPipelineBarrier(commands, first ? c.shader_stages : kCopy,
                          first ? kCopy : c.shader_stages, 0, 0, nullptr, 0, nullptr, 1, &barrier);
}

/// Collects rows of textures in a buffer, and copies them when it is full.
class Uploader {
 public:
  Uploader(gpu::Device* device, const gpu::Image& image)
      : device_(device), image_(image), arena_(&device->context()) {}

  Status Create(size_t bytes) {
    const Result<const gpu::Buffer*> buffer = arena_.AddBuffer(bytes, 0, gpu::BufferPlace::kUpload);
    STILLRAY_RETURN_IF_ERROR(buffer.status());
    buffer_ = *buffer;
    STILLRAY_RETURN_IF_ERROR(arena_.Allocate());
    return Submit(VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  }

  Status Add(const Texture& texture, const AtlasPlace& place) {
    const size_t row_bytes = static_cast<size_t>(WidthOf(texture)) * sizeof(uint32_t);
    for (int y = 0; y < HeightOf(texture); ++y) {
      if (used_ + row_bytes > buffer_->size) {
        STILLRAY_RETURN_IF_ERROR(Submit());
      }
      auto* row =
          static_cast<uint32_t*>(static_cast<void*>(static_cast<char*>(buffer_->mapped) + used_));
      for (int x = 0; x < WidthOf(texture); ++x) {
        row[x] = BorderedTexel(texture, x - kBorder, y - kBorder);
      }
      AddRow(texture, place, y);
      used_ += row_bytes;
    }
    return Status::Ok();
  }

  Status Finish() {
    STILLRAY_RETURN_IF_ERROR(Submit());
    return Submit(VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  }

 private:
  /// Adds a row of a texture; consecutive rows are copied together.
  void AddRow(const Texture& texture, const AtlasPlace& place, int y) {
    if (!regions_.empty() && y > 0) {
      ++regions_.back().imageExtent.height;
      return;
    }
    VkBufferImageCopy region = {};
    region.bufferOffset = used_;
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, place.layer, 1};
    region.imageOffset = {static_cast<int>(place.x) - kBorder,
                          static_cast<int>(place.y) - kBorder + y, 0};
    region.imageExtent = {static_cast<uint32_t>(WidthOf(texture)), 1, 1};
    regions_.push_back(region);
  }

  Status Submit(VkImageLayout from = VK_IMAGE_LAYOUT_UNDEFINED,
                VkImageLayout to = VK_IMAGE_LAYOUT_UNDEFINED) {
    const gpu::DeviceContext& c = device_->context();
    STILLRAY_RETURN_IF_ERROR(arena_.Flush());
    const gpu::FairLock lock = device_->Lock();
    const Result<VkCommandBuffer> commands = device_->Begin();
    STILLRAY_RETURN_IF_ERROR(commands.status());
    if (from != to) {
      Transition(c, *commands, image_, from, to);
    }
    if (!regions_.empty()) {
      c.vk.CmdCopyBufferToImage(*commands, buffer_->buffer, image_.image,
                                VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                static_cast<uint32_t>(regions_.size()), regions_.data());
    }
    regions_.clear();
    used_ = 0;
    return device_->Run();
  }

  gpu::Device* device_;
  const gpu::Image& image_;
  gpu::Arena arena_;
  const gpu::Buffer* buffer_ = nullptr;
  size_t used_ = 0;  // used bytes of the buffer
  std::vector<VkBufferImageCopy> regions_;
};

}  // namespace

Result<TextureAtlas> PlanAtlas(const std::vector<Texture>& textures, int most_size,
                               int most_layers) {
  if (textures.empty()) {
    return TextureAtlas();
  }
  std::vector<size_t> order(textures.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return textures[a].height > textures[b].height; });
  int width = 0;
  int height = 0;
  for (const Texture& texture : textures) {
    width = std::max(width, WidthOf(texture));
    height = std::max(height, HeightOf(texture));
  }
  const auto usual = [&](int size) { return std::min(std::max(size, kUsualSize), most_size); };
  TextureAtlas best;
  for (int i = 1; i <= kMostMultiples; ++i) {
    for (int k = 1; k <= kMostMultiples; ++k) {
      if (i * width > usual(width) || k * height > usual(height)) {
        continue;
      }
      TextureAtlas atlas = Place(textures, order, i * width, k * height);
      if (atlas.layers <= most_layers &&
          (best.places.empty() || TexelsOf(atlas) < TexelsOf(best))) {
        best = std::move(atlas);
      }
    }
  }
  if (best.places.empty()) {
    return Status::Unsupported(fmt::format(
        "the {} textures of the scene, of up to {}x{} texels, do not fit into images of {}x{} "
        "with {} layers",
        textures.size(), width - 2 * kBorder, height - 2 * kBorder, most_size, most_size,
        most_layers));
  }
  return best;
}

uint32_t BorderedTexel(const Texture& texture, int x, int y) {
  const int u = WrapTexel(x, texture.width, static_cast<int>(texture.wrap_u));
  const int v = WrapTexel(y, texture.height, static_cast<int>(texture.wrap_v));
  const uint8_t* t =
      texture.texels.data() +
      4 * (static_cast<size_t>(v) * static_cast<size_t>(texture.width) + static_cast<size_t>(u));
  return t[0] | uint32_t{t[1]} << 8 | uint32_t{t[2]} << 16 | uint32_t{t[3]} << 24;
}

Status UploadAtlas(gpu::Device* device, const std::vector<Texture>& textures,
                   const TextureAtlas& atlas, const gpu::Image& image) {
  size_t row = sizeof(uint32_t);
  size_t all = 0;
  for (size_t i = 0; i < atlas.places.size(); ++i) {
    const size_t bytes = static_cast<size_t>(WidthOf(textures[i])) * sizeof(uint32_t);
    row = std::max(row, bytes);
    all += bytes * static_cast<size_t>(HeightOf(textures[i]));
  }
  Uploader uploader(device, image);
  STILLRAY_RETURN_IF_ERROR(uploader.Create(std::max(row, std::min(all, kPieceBytes))));
  for (size_t i = 0; i < atlas.places.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(uploader.Add(textures[i], atlas.places[i]));
  }
  return uploader.Finish();
}

}  // namespace stillray::render

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "benchmarks/packed_inputs.h"

#include <cstring>
#include <utility>

#include <glm/packing.hpp>

namespace stillray::vulkan {
namespace {

/// Packs the texels of an image, row by row; `texel` appends the words of one texel.
template <typename Texel>
std::vector<uint32_t> Pack(const Frame& f, const Texel& texel) {
  std::vector<uint32_t> words;
  for (int y = 0; y < f.height; ++y) {
    for (int x = 0; x < f.width; ++x) {
      texel(x, y, &words);
    }
  }
  return words;
}

std::vector<uint32_t> PackHalves(const Frame& f, const Image3& image) {
  return Pack(f, [&](int x, int y, std::vector<uint32_t>* words) {
    words->push_back(glm::packHalf2x16({image[0](x, y), image[1](x, y)}));
    words->push_back(glm::packHalf2x16({image[2](x, y), 0.0f}));
  });
}

std::vector<uint32_t> PackBytes(const Frame& f, const Image3& image) {
  return Pack(f, [&](int x, int y, std::vector<uint32_t>* words) {
    words->push_back(glm::packUnorm4x8({image[0](x, y), image[1](x, y), image[2](x, y), 1.0f}));
  });
}

}  // namespace

Status PackedInputs::Add(VkFormat format, std::vector<uint32_t> words, ImageRef* input) {
  const Result<const gpu::Image*> image = arena_.AddImage(format, width_, height_, 0);
  STILLRAY_RETURN_IF_ERROR(image.status());
  const VkDeviceSize bytes = words.size() * sizeof(uint32_t);
  entries_.push_back({*image, staged_, std::move(words), input});
  staged_ += (bytes + 15) / 16 * 16;
  return Status::Ok();
}

Status PackedInputs::AddAll(const Frame& f) {
  const Guides& g = f.guides;
  for (const Signal& signal : f.signals) {
    STILLRAY_RETURN_IF_ERROR(Add(VK_FORMAT_R16G16B16A16_SFLOAT, PackHalves(f, signal.radiance),
                                 &inputs_.lights[static_cast<size_t>(signal.kind)]));
  }
  STILLRAY_RETURN_IF_ERROR(
      Add(VK_FORMAT_R16G16B16A16_SFLOAT, PackHalves(f, g.normal), &inputs_.normal));
  STILLRAY_RETURN_IF_ERROR(
      Add(VK_FORMAT_R8G8B8A8_UNORM, PackBytes(f, g.albedo), &inputs_.albedos[0]));
  STILLRAY_RETURN_IF_ERROR(
      Add(VK_FORMAT_R8G8B8A8_UNORM, PackBytes(f, g.specular_albedo), &inputs_.albedos[1]));
  const auto motion = [&](int x, int y, std::vector<uint32_t>* words) {
    words->push_back(glm::packHalf2x16({g.motion[0](x, y), g.motion[1](x, y)}));
  };
  STILLRAY_RETURN_IF_ERROR(Add(VK_FORMAT_R16G16_SFLOAT, Pack(f, motion), &inputs_.motion));
  const auto depth = [&](int x, int y, std::vector<uint32_t>* words) {
    words->push_back(glm::floatBitsToUint(g.depth(x, y)));
  };
  STILLRAY_RETURN_IF_ERROR(Add(VK_FORMAT_R32_SFLOAT, Pack(f, depth), &inputs_.depth));
  const auto id = [&](int x, int y, std::vector<uint32_t>* words) { words->push_back(g.id(x, y)); };
  return Add(VK_FORMAT_R32_UINT, Pack(f, id), &inputs_.id);
}

Status PackedInputs::Stage() {
  const Result<const gpu::Buffer*> staging =
      arena_.AddBuffer(staged_, 0, gpu::BufferPlace::kUpload);
  STILLRAY_RETURN_IF_ERROR(staging.status());
  staging_ = *staging;
  STILLRAY_RETURN_IF_ERROR(arena_.Allocate());
  for (Entry& entry : entries_) {
    std::memcpy(static_cast<char*>(staging_->mapped) + entry.offset, entry.words.data(),
                entry.words.size() * sizeof(uint32_t));
    entry.words = {};
    *entry.input = {entry.image->view, VK_IMAGE_LAYOUT_GENERAL};
  }
  return arena_.Flush();
}

Result<std::unique_ptr<PackedInputs>> PackedInputs::Create(const gpu::DeviceContext* context,
                                                           const Frame& frame) {
  std::unique_ptr<PackedInputs> made(new PackedInputs(context));
  made->width_ = frame.width;
  made->height_ = frame.height;
  STILLRAY_RETURN_IF_ERROR(made->AddAll(frame));
  STILLRAY_RETURN_IF_ERROR(made->Stage());
  STILLRAY_RETURN_IF_ERROR(made->colour_.Make(frame.width, frame.height));
  made->inputs_.colour = made->colour_.ref();
  made->inputs_.colour_is_half = true;
  return made;
}

void PackedInputs::Record(VkCommandBuffer commands) {
  arena_.RecordFirstUse(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT);
  for (const Entry& entry : entries_) {
    VkBufferImageCopy region = {};
    region.bufferOffset = entry.offset;
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {static_cast<uint32_t>(width_), static_cast<uint32_t>(height_), 1};
    context_->vk.CmdCopyBufferToImage(commands, staging_->buffer, entry.image->image,
                                      VK_IMAGE_LAYOUT_GENERAL, 1, &region);
  }
  colour_.RecordUse(commands);
}

}  // namespace stillray::vulkan

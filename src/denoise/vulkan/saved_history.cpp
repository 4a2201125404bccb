// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/saved_history.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "core/check.h"
#include "core/checksum.h"
#include "denoise/cpu/history_bytes.h"
#include "denoise/stages/follow_light_shared.h"

namespace stillray::vulkan {
namespace {

enum Flag : uint32_t {
  kHasHistory = 1,
  kHasPicture = 2,
  kHasCompressed = 4,
  kHasBehind = 8,
  kHasTransmission = 16,
  kIsHalf = 32,
  kHasHeld = 64,
  kHasHeldId = 128,
  kJittered = 256,
  kHasFollowed = 512,
  kByChannel = 1024,
  kOtherNormals = 2048,  ///< normals are not stored as with normals=auto
  kHasAlbedo = 4096,
};

struct Header {
  char magic[8] = {};
  uint32_t version = 4;
  uint32_t byte_order = kHistoryByteOrder;
  int32_t width = 0;
  int32_t height = 0;
  uint32_t signals = 0;
  uint32_t flags = 0;
  uint32_t held_colours = 0;
  float feedback_progress = 0;
  uint64_t checksum = 0;  ///< of all bytes, with this set to 0

  bool Has(Flag flag) const { return (flags & flag) != 0; }
  bool HasOctahedral() const { return Has(kIsHalf) != Has(kOtherNormals); }
};
static_assert(sizeof(Header) == 48, "no bytes between members");

constexpr uint32_t kAllColours = (1u << kGuideColours) - 1;
constexpr uint32_t kAlbedoColours = 7;

uint64_t Checksum(Header header, std::span<const uint8_t> behind) {
  header.checksum = 0;
  const std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(&header), sizeof(Header));
  return AddToChecksum(behind, AddToChecksum(bytes));
}

/// Bytes of all images in a header.
size_t TexelBytesOf(const Header& h) {
  const bool half = h.Has(kIsHalf);
  const size_t light = half ? 8 : 16;
  const size_t guides = (h.HasOctahedral() ? 8 : 16) + (half ? 8 : 16);
  size_t bytes = (h.Has(kHasPicture) ? light : 0) + (h.Has(kHasAlbedo) ? light : 0);
  if (h.Has(kHasHistory)) {
    const size_t of_signal =
        2 * light + (h.Has(kHasBehind) ? light : 0) + (h.Has(kHasCompressed) ? light / 4 : 0);
    bytes += h.signals * of_signal + guides;
  }
  if (h.Has(kHasHeld)) {
    const auto albedos = static_cast<size_t>(std::popcount(h.held_colours & kAlbedoColours));
    const auto lights = static_cast<size_t>(std::popcount(h.held_colours & ~kAlbedoColours));
    bytes += 4 + light + (h.Has(kHasHeldId) ? 4 : 0) + albedos * light + lights * 16;
  }
  const size_t blocks =
      static_cast<size_t>(FollowSize(h.width)) * static_cast<size_t>(FollowSize(h.height));
  return (h.Has(kHasFollowed) ? 4 * blocks : 0) +
         bytes * static_cast<size_t>(h.width) * static_cast<size_t>(h.height);
}

/// The images of a pipeline that the next frame reads, in the order of the bytes.
std::vector<const gpu::Image*> RememberedImages(const FramePipeline& pipeline,
                                                const SequenceProgress& progress,
                                                const FillGuidesPass::Kinds& held) {
  std::vector<const gpu::Image*> images;
  const auto keep = [&](bool wanted, const gpu::Image* image) {
    if (wanted) {
      images.push_back(image);
    }
  };
  const FrameImages& all = pipeline.images();
  const bool history = progress.has_history;
  keep(history, all.history.colour);
  keep(history && pipeline.shape().with_behind, all.history.behind);
  keep(history, all.history.moments);
  keep(history && pipeline.shape().with_compressed, all.history.compressed);
  keep(history, all.guides.surface);
  keep(history, all.guides.detail);
  keep(progress.has_picture, all.shown);
  keep(progress.has_albedo, all.albedo_before);
  keep(progress.has_followed, all.followed);
  if (held.any) {
    const FillGuidesPass::Held& guides = pipeline.fill_guides()->held();
    keep(true, guides.depth);
    keep(true, guides.normal);
    keep(held.id, guides.id);
    for (size_t k = 0; k < kGuideColours; ++k) {
      keep((held.colours >> k & 1u) != 0, guides.colour[k]);
    }
  }
  return images;
}

Header HeaderOf(const FramePipeline& pipeline, const FillGuidesPass::Kinds& held) {
  const Shape& shape = pipeline.shape();
  const SequenceProgress& progress = pipeline.progress();
  const auto flag = [](bool is_set, Flag bit) { return is_set ? uint32_t{bit} : 0u; };
  Header h;
  h.width = shape.width;
  h.height = shape.height;
  h.signals = static_cast<uint32_t>(shape.signals);
  h.flags = flag(progress.has_history, kHasHistory) | flag(progress.has_picture, kHasPicture) |
            flag(shape.with_compressed, kHasCompressed) | flag(shape.with_behind, kHasBehind) |
            flag(pipeline.has_transmission(), kHasTransmission) |
            flag(shape.storage == Storage::kHalf, kIsHalf) | flag(held.any, kHasHeld) |
            flag(held.any && held.id, kHasHeldId) | flag(progress.jittered, kJittered) |
            flag(progress.has_followed, kHasFollowed) | flag(progress.has_albedo, kHasAlbedo) |
            flag(pipeline.by_channel(), kByChannel) |
            flag(shape.octahedral != PacksNormalsByDefault(shape.storage), kOtherNormals);
  h.held_colours = held.any ? held.colours : 0;
  h.feedback_progress = progress.feedback_progress;
  return h;
}

/// Staging memory for images and the state, and their offsets in it.
class Staging {
 public:
  Staging(gpu::Device* device, std::vector<const gpu::Image*> images, const gpu::Buffer* state)
      : device_(device), images_(std::move(images)), state_(state), arena_(&device->context()) {}

  Status Allocate(gpu::BufferPlace place) {
    VkDeviceSize size = Aligned(sizeof(FrameState));
    for (const gpu::Image* image : images_) {
      size += Aligned(gpu::BytesOf(*image));
    }
    const Result<const gpu::Buffer*> added = arena_.AddBuffer(size, 0, place);
    STILLRAY_RETURN_IF_ERROR(added.status());
    buffer_ = *added;
    return arena_.Allocate();
  }

  /// Calls visit(place, bytes) for the state and every image, in order.
  template <typename Visit>
  void VisitBytes(const Visit& visit) const {
    auto* at = static_cast<uint8_t*>(buffer_->mapped);
    visit(at, sizeof(FrameState));
    at += Aligned(sizeof(FrameState));
    for (const gpu::Image* image : images_) {
      visit(at, gpu::BytesOf(*image));
      at += Aligned(gpu::BytesOf(*image));
    }
  }

  void Record(VkCommandBuffer commands, bool to_device) const {
    const gpu::DeviceFunctions& vk = device_->context().vk;
    const VkBufferCopy state = {0, 0, sizeof(FrameState)};
    vk.CmdCopyBuffer(commands, to_device ? buffer_->buffer : state_->buffer,
                     to_device ? state_->buffer : buffer_->buffer, 1, &state);
    VkDeviceSize at = Aligned(sizeof(FrameState));
    for (const gpu::Image* image : images_) {
      VkBufferImageCopy region = {};
      region.bufferOffset = at;
      region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0,
                                 static_cast<uint32_t>(std::max(image->layers, 1))};
      region.imageExtent = {static_cast<uint32_t>(image->width),
                            static_cast<uint32_t>(image->height), 1};
      if (to_device) {
        vk.CmdCopyBufferToImage(commands, buffer_->buffer, image->image, VK_IMAGE_LAYOUT_GENERAL, 1,
                                &region);
      } else {
        vk.CmdCopyImageToBuffer(commands, image->image, VK_IMAGE_LAYOUT_GENERAL, buffer_->buffer, 1,
                                &region);
      }
      at += Aligned(gpu::BytesOf(*image));
    }
  }

  Status Flush() const { return arena_.Flush(); }
  Status Invalidate() const { return arena_.Invalidate(); }

 private:
  /// Rounds up to the alignment of copies, the largest texel.
  static size_t Aligned(size_t bytes) { return (bytes + 15) / 16 * 16; }

  gpu::Device* device_;
  std::vector<const gpu::Image*> images_;
  const gpu::Buffer* state_;
  gpu::Arena arena_;
  const gpu::Buffer* buffer_ = nullptr;
};

/// Runs copies between the pipeline's images and staging memory.
Status Copy(gpu::Device* device, FramePipeline* pipeline, const Staging& staging, bool to_device) {
  constexpr VkPipelineStageFlags kWork =
      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
  constexpr VkAccessFlags kTransfer = VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
  const gpu::DeviceContext& context = device->context();
  const gpu::FairLock lock = device->Lock();
  const Result<VkCommandBuffer> commands = device->Begin();
  STILLRAY_RETURN_IF_ERROR(commands.status());
  pipeline->PrepareImages(*commands);
  if (pipeline->fill_guides() != nullptr) {
    pipeline->fill_guides()->PrepareImages(*commands);
  }
  gpu::MemoryBarrier(context, *commands, kWork,
                     VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT,
                     VK_PIPELINE_STAGE_TRANSFER_BIT, kTransfer);
  staging.Record(*commands, to_device);
  gpu::MemoryBarrier(context, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                     VK_ACCESS_TRANSFER_WRITE_BIT, kWork | VK_PIPELINE_STAGE_HOST_BIT,
                     VK_ACCESS_SHADER_READ_BIT | kTransfer | VK_ACCESS_HOST_READ_BIT);
  return device->Run();
}

/// Writes the header to the front of the bytes, which is reserved for it.
void WriteHeader(Header header, std::vector<uint8_t>* bytes) {
  std::memcpy(header.magic, kDeviceHistoryMagic, sizeof(kDeviceHistoryMagic));
  header.checksum = Checksum(header, std::span(*bytes).subspan(sizeof(Header)));
  std::memcpy(bytes->data(), &header, sizeof(Header));
}

/// Facts of a frame that needs guides of these kinds.
FrameFacts FactsOf(const FillGuidesPass::Kinds& held) {
  FrameFacts facts;
  facts.has_incomplete_guides = held.any;
  facts.has_id = held.id;
  facts.albedos = held.colours & kAlbedoColours;
  facts.has_emission = (held.colours & 8u) != 0;
  facts.has_background = (held.colours & 16u) != 0;
  return facts;
}

}  // namespace

Result<std::vector<uint8_t>> SaveHistory(gpu::Device* device, FramePipeline* pipeline) {
  std::vector<uint8_t> bytes(sizeof(Header));
  if (pipeline == nullptr) {
    WriteHeader(Header(), &bytes);
    return bytes;
  }
  const FillGuidesPass::Kinds held = pipeline->fill_guides() != nullptr
                                         ? pipeline->fill_guides()->kinds()
                                         : FillGuidesPass::Kinds();
  Staging staging(device, RememberedImages(*pipeline, pipeline->progress(), held),
                  pipeline->images().state);
  STILLRAY_RETURN_IF_ERROR(staging.Allocate(gpu::BufferPlace::kDownload));
  STILLRAY_RETURN_IF_ERROR(Copy(device, pipeline, staging, false));
  STILLRAY_RETURN_IF_ERROR(staging.Invalidate());
  const Header header = HeaderOf(*pipeline, held);
  bytes.reserve(sizeof(Header) + sizeof(FrameState) + TexelBytesOf(header));
  staging.VisitBytes(
      [&](const uint8_t* place, size_t size) { bytes.insert(bytes.end(), place, place + size); });
  STILLRAY_CHECK_EQ(bytes.size(), sizeof(Header) + sizeof(FrameState) + TexelBytesOf(header));
  WriteHeader(header, &bytes);
  return bytes;
}

Result<SavedHistory> ReadSavedHistory(std::span<const uint8_t> bytes, const Settings& settings,
                                      Storage storage) {
  if (IsHistoryOfCpu(bytes)) {
    return Status::BadData("saved history was made on the CPU, this denoiser works on a device");
  }
  Header h;
  const Header expected;
  if (bytes.size() < sizeof(Header)) {
    return Status::BadData(fmt::format("saved history has {} bytes, expected at least {}",
                                       bytes.size(), sizeof(Header)));
  }
  std::memcpy(&h, bytes.data(), sizeof(Header));
  if (std::memcmp(h.magic, kDeviceHistoryMagic, sizeof(h.magic)) != 0 ||
      h.version != expected.version || h.byte_order != expected.byte_order) {
    return Status::BadData(
        "saved history was not written by this version of stillray on such a machine");
  }
  STILLRAY_RETURN_IF_ERROR(CheckClaims({h.width,
                                        h.height,
                                        h.signals,
                                        {h.Has(kHasCompressed), h.Has(kHasBehind)},
                                        h.feedback_progress,
                                        h.Has(kByChannel)},
                                       KeptBy(settings)));
  if (h.Has(kIsHalf) != (storage == Storage::kHalf)) {
    return Status::BadData(fmt::format("saved history is of {} bits, this denoiser keeps {}",
                                       h.Has(kIsHalf) ? 16 : 32, h.Has(kIsHalf) ? 32 : 16));
  }
  STILLRAY_RETURN_IF_ERROR(CheckNormals(
      h.HasOctahedral(), PacksNormals(settings.normals, PacksNormalsByDefault(storage))));
  if ((h.held_colours & ~kAllColours) != 0 ||
      GroupsOf(settings.signals, h.Has(kHasTransmission)).size() != h.signals) {
    return Status::BadData("saved history contradicts itself");
  }
  const size_t size = sizeof(Header) + sizeof(FrameState) + TexelBytesOf(h);
  if (bytes.size() != size) {
    return Status::BadData(
        fmt::format("saved history has {} bytes, expected {}", bytes.size(), size));
  }
  if (Checksum(h, bytes.subspan(sizeof(Header))) != h.checksum) {
    return Status::BadData("saved history is damaged: its checksum is another");
  }
  SavedHistory saved;
  saved.width = h.width;
  saved.height = h.height;
  saved.transmission = h.Has(kHasTransmission);
  saved.progress.has_history = h.Has(kHasHistory);
  saved.progress.has_picture = h.Has(kHasPicture);
  saved.progress.has_followed = h.Has(kHasFollowed);
  saved.progress.has_albedo = h.Has(kHasAlbedo);
  saved.progress.jittered = h.Has(kJittered);
  saved.progress.feedback_progress = h.feedback_progress;
  saved.held = {h.Has(kHasHeld), h.Has(kHasHeldId), h.held_colours};
  saved.state_and_texels = bytes.subspan(sizeof(Header));
  return saved;
}

Status RestoreHistory(gpu::Device* device, const SavedHistory& saved, FramePipeline* pipeline) {
  pipeline->Reset();
  STILLRAY_RETURN_IF_ERROR(pipeline->PrepareFilling(FactsOf(saved.held)));
  Staging staging(device, RememberedImages(*pipeline, saved.progress, saved.held),
                  pipeline->images().state);
  STILLRAY_RETURN_IF_ERROR(staging.Allocate(gpu::BufferPlace::kUpload));
  const uint8_t* from = saved.state_and_texels.data();
  staging.VisitBytes([&](uint8_t* place, size_t size) {
    std::memcpy(place, from, size);
    from += size;
  });
  STILLRAY_RETURN_IF_ERROR(staging.Flush());
  STILLRAY_RETURN_IF_ERROR(Copy(device, pipeline, staging, true));
  if (saved.held.any) {
    pipeline->fill_guides()->Restore(saved.held);
  }
  pipeline->GoOnFrom(saved.progress);
  return Status::Ok();
}

}  // namespace stillray::vulkan

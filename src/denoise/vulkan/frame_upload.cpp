// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/frame_upload.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/parallel.h"

namespace stillray::vulkan {
namespace {

VkBufferImageCopy WholeImage(VkDeviceSize offset, int width, int height) {
  VkBufferImageCopy region = {};
  region.bufferOffset = offset;
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {static_cast<uint32_t>(width), static_cast<uint32_t>(height), 1};
  return region;
}

}  // namespace

Status FrameUpload::Add(VkFormat format, int channels, Entry* entry, ImageRef* input) {
  Result<const gpu::Image*> image = arena_.AddImage(format, width_, height_, 0);
  if (!image.ok()) {
    return image.status();
  }
  entry->image = *image;
  entry->channels = channels;
  entry->offset = staged_;
  const VkDeviceSize bytes = VkDeviceSize{4} * static_cast<VkDeviceSize>(channels) *
                             static_cast<VkDeviceSize>(width_) * static_cast<VkDeviceSize>(height_);
  staged_ += (bytes + 15) / 16 * 16;
  input->layout = VK_IMAGE_LAYOUT_GENERAL;
  return Status::Ok();
}

Result<std::unique_ptr<FrameUpload>> FrameUpload::Create(const gpu::DeviceContext* context,
                                                         int width, int height,
                                                         const FrameFacts& facts) {
  std::unique_ptr<FrameUpload> made(new FrameUpload(context));
  FrameUpload& u = *made;
  u.width_ = width;
  u.height_ = height;
  u.facts_ = facts;
  Status status;
  const auto add = [&](bool wanted, VkFormat format, int channels, Entry* entry, ImageRef* input) {
    if (wanted && status.ok()) {
      status = u.Add(format, channels, entry, input);
    }
  };
  constexpr VkFormat kColour = VK_FORMAT_R32G32B32A32_SFLOAT;
  constexpr VkFormat kScalar = VK_FORMAT_R32_SFLOAT;
  for (uint32_t k = 0; k < 6; ++k) {
    add((facts.lights >> k & 1u) != 0, kColour, 4, &u.lights_[k], &u.inputs_.lights[k]);
    add((facts.second_moments >> k & 1u) != 0, kScalar, 1, &u.second_moments_[k],
        &u.inputs_.second_moments[k]);
  }
  add(true, kScalar, 1, &u.depth_, &u.inputs_.depth);
  add(true, kColour, 4, &u.normal_, &u.inputs_.normal);
  add(facts.has_id, VK_FORMAT_R32_UINT, 1, &u.id_, &u.inputs_.id);
  add(true, VK_FORMAT_R32G32_SFLOAT, 2, &u.motion_, &u.inputs_.motion);
  for (uint32_t i = 0; i < 3; ++i) {
    add((facts.albedos >> i & 1u) != 0, kColour, 4, &u.albedos_[i], &u.inputs_.albedos[i]);
  }
  add(facts.has_emission, kColour, 4, &u.emission_, &u.inputs_.emission);
  add(facts.has_background, kColour, 4, &u.background_, &u.inputs_.background);
  add(facts.has_samples, kScalar, 1, &u.samples_, &u.inputs_.samples);
  add(facts.has_roughness, kScalar, 1, &u.roughness_, &u.inputs_.roughness);
  add(facts.has_confidence, kScalar, 1, &u.confidence_, &u.inputs_.confidence);
  add(facts.has_previous_normal, kColour, 4, &u.previous_normal_, &u.inputs_.previous_normal);
  STILLRAY_RETURN_IF_ERROR(status);
  const Result<const gpu::Buffer*> staging =
      u.arena_.AddBuffer(u.staged_, 0, gpu::BufferPlace::kUpload);
  STILLRAY_RETURN_IF_ERROR(staging.status());
  u.staging_ = *staging;
  STILLRAY_RETURN_IF_ERROR(u.arena_.Allocate());
  const auto show = [](const Entry& entry, ImageRef* input) {
    input->view = entry.image != nullptr ? entry.image->view : VK_NULL_HANDLE;
  };
  for (uint32_t k = 0; k < 6; ++k) {
    show(u.lights_[k], &u.inputs_.lights[k]);
    show(u.second_moments_[k], &u.inputs_.second_moments[k]);
  }
  show(u.depth_, &u.inputs_.depth);
  show(u.normal_, &u.inputs_.normal);
  show(u.id_, &u.inputs_.id);
  show(u.motion_, &u.inputs_.motion);
  for (uint32_t i = 0; i < 3; ++i) {
    show(u.albedos_[i], &u.inputs_.albedos[i]);
  }
  show(u.emission_, &u.inputs_.emission);
  show(u.background_, &u.inputs_.background);
  show(u.samples_, &u.inputs_.samples);
  show(u.roughness_, &u.inputs_.roughness);
  show(u.confidence_, &u.inputs_.confidence);
  show(u.previous_normal_, &u.inputs_.previous_normal);
  return made;
}

bool FrameUpload::Fits(int width, int height, const FrameFacts& facts) const {
  return width == width_ && height == height_ && facts.lights == facts_.lights &&
         facts.second_moments == facts_.second_moments && facts.albedos == facts_.albedos &&
         facts.has_samples == facts_.has_samples && facts.has_id == facts_.has_id &&
         facts.has_emission == facts_.has_emission &&
         facts.has_background == facts_.has_background &&
         facts.has_roughness == facts_.has_roughness &&
         facts.has_confidence == facts_.has_confidence &&
         facts.has_previous_normal == facts_.has_previous_normal;
}

/// Interleaves channels; a fourth channel is not written.
template <int N>
void FrameUpload::WritePlanes(const Entry& entry, const Planes<float, N>& planes) {
  auto* const start = reinterpret_cast<float*>(static_cast<char*>(staging_->mapped) + entry.offset);
  const int channels = entry.channels;
  if (planes.empty()) {
    std::fill_n(
        start,
        static_cast<size_t>(channels) * static_cast<size_t>(width_) * static_cast<size_t>(height_),
        0.0f);
    return;
  }
  ParallelRows(height_, 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      float* to = start + static_cast<ptrdiff_t>(y) * width_ * channels;
      for (int c = 0; c < N; ++c) {
        const float* from = planes[c].Row(y);
        for (int x = 0; x < width_; ++x) {
          to[x * channels + c] = from[x];
        }
      }
    }
  });
}

void FrameUpload::WriteFourth(const Entry& entry, const Image1& plane) {
  auto* const start = reinterpret_cast<float*>(static_cast<char*>(staging_->mapped) + entry.offset);
  for (int y = 0; y < height_; ++y) {
    float* to = start + static_cast<ptrdiff_t>(y) * width_ * 4 + 3;
    const float* from = plane.Row(y);
    for (int x = 0; x < width_; ++x) {
      to[x * 4] = from[x];
    }
  }
}

template <typename T>
void FrameUpload::WritePlane(const Entry& entry, const Plane<T>& plane) {
  auto* const start = static_cast<char*>(staging_->mapped) + entry.offset;
  const size_t row = static_cast<size_t>(width_) * sizeof(T);
  for (int y = 0; y < height_; ++y) {
    std::memcpy(start + static_cast<size_t>(y) * row, plane.Row(y), row);
  }
}

Status FrameUpload::Write(const Frame& f, const ShownImages& images) {
  const Guides& g = f.guides;
  for (const Signal& signal : f.signals) {
    const auto k = static_cast<size_t>(signal.kind);
    WritePlanes(lights_[k], signal.radiance);
    if (!signal.second_moment.empty()) {
      WritePlane(second_moments_[k], signal.second_moment);
    }
  }
  WritePlane(depth_, g.depth);
  WritePlanes(normal_, g.normal);
  WritePlanes(motion_, g.motion);
  if (!g.id.empty()) {
    WritePlane(id_, g.id);
  }
  const auto albedos = AlbedosOf(g);
  for (size_t i = 0; i < albedos.size(); ++i) {
    if (!albedos[i]->empty()) {
      WritePlanes(albedos_[i], *albedos[i]);
    }
  }
  if (!f.emission.empty()) {
    WritePlanes(emission_, f.emission);
  }
  if (!f.background.empty()) {
    WritePlanes(background_, f.background);
  }
  if (!f.samples.empty()) {
    WritePlane(samples_, f.samples);
  }
  if (facts_.has_roughness) {
    WritePlane(roughness_, g.roughness);
  }
  if (!f.confidence.empty()) {
    WritePlane(confidence_, f.confidence);
  }
  if (!g.previous_normal.empty()) {
    WritePlanes(previous_normal_, g.previous_normal);
  }
  if (images.depth != nullptr) {
    WriteFourth(albedos_[1], *images.depth);
  }
  if (images.length != nullptr) {
    WriteFourth(emission_, *images.length);
  }
  return arena_.Flush();
}

void FrameUpload::Record(VkCommandBuffer commands) {
  const gpu::DeviceFunctions& vk = context_->vk;
  if (!prepared_) {
    prepared_ = true;
    arena_.RecordFirstUse(commands,
                          VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                          VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_SHADER_WRITE_BIT);
  }
  const auto copy = [&](const Entry& entry) {
    if (entry.image != nullptr) {
      const VkBufferImageCopy region = WholeImage(entry.offset, width_, height_);
      vk.CmdCopyBufferToImage(commands, staging_->buffer, entry.image->image,
                              VK_IMAGE_LAYOUT_GENERAL, 1, &region);
    }
  };
  for (uint32_t k = 0; k < 6; ++k) {
    copy(lights_[k]);
    copy(second_moments_[k]);
  }
  for (const Entry* entry :
       {&depth_, &normal_, &id_, &motion_, &albedos_[0], &albedos_[1], &albedos_[2], &emission_,
        &background_, &samples_, &roughness_, &confidence_, &previous_normal_}) {
    copy(*entry);
  }
}

}  // namespace stillray::vulkan

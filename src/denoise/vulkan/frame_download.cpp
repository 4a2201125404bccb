// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/frame_download.h"

#include <utility>

#include "core/parallel.h"

namespace stillray::vulkan {
namespace {

constexpr int kBand = 32;  // rows per task of a thread

void UnpackColour(const float* from, int width, int height, Image3* to) {
  if (to->width() != width || to->height() != height) {
    *to = Image3(width, height);
  }
  ParallelRows(height, kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float* row = from + static_cast<ptrdiff_t>(y) * width * 4;
      for (int c = 0; c < 3; ++c) {
        float* out = (*to)[c].Row(y);
        for (int x = 0; x < width; ++x) {
          out[x] = row[x * 4 + c];
        }
      }
    }
  });
}

void UnpackAlpha(const float* from, Image1* to) {
  for (int y = 0; y < to->height(); ++y) {
    const float* row = from + static_cast<ptrdiff_t>(y) * to->width() * 4;
    float* out = to->Row(y);
    for (int x = 0; x < to->width(); ++x) {
      out[x] = row[x * 4 + 3];
    }
  }
}

/// Converts RGBA to RGB.
void UnpackDisplay(const uint8_t* from, int width, int height, std::vector<uint8_t>* to) {
  to->resize(static_cast<size_t>(width) * static_cast<size_t>(height) * 3);
  ParallelRows(height, kBand, [&](int y0, int y1) {
    const uint8_t* in = from + static_cast<ptrdiff_t>(y0) * width * 4;
    uint8_t* out = to->data() + static_cast<ptrdiff_t>(y0) * width * 3;
    const uint8_t* const end = from + static_cast<ptrdiff_t>(y1) * width * 4;
    for (; in != end; in += 4, out += 3) {
      out[0] = in[0];
      out[1] = in[1];
      out[2] = in[2];
    }
  });
}

}  // namespace

Status OutputImage::Make(int width, int height) {
  auto memory = std::make_unique<gpu::Arena>(context_);
  const Result<const gpu::Image*> image = memory->AddImage(format_, width, height, 0);
  STILLRAY_RETURN_IF_ERROR(image.status());
  STILLRAY_RETURN_IF_ERROR(memory->Allocate());
  image_memory_ = std::move(memory);
  image_ = *image;
  return Status::Ok();
}

Status OutputImage::PrepareCopy() {
  if (host_ != nullptr) {
    return Status::Ok();
  }
  const VkDeviceSize bytes = static_cast<VkDeviceSize>(texel_bytes_) *
                             static_cast<VkDeviceSize>(image_->width) *
                             static_cast<VkDeviceSize>(image_->height);
  auto memory = std::make_unique<gpu::Arena>(context_);
  const Result<const gpu::Buffer*> buffer =
      memory->AddBuffer(bytes, 0, gpu::BufferPlace::kDownload);
  STILLRAY_RETURN_IF_ERROR(buffer.status());
  STILLRAY_RETURN_IF_ERROR(memory->Allocate());
  host_memory_ = std::move(memory);
  host_ = *buffer;
  return Status::Ok();
}

void OutputImage::RecordUse(VkCommandBuffer commands) {
  if (!used_) {
    used_ = true;
    image_memory_->RecordFirstUse(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                  VK_ACCESS_SHADER_WRITE_BIT);
  }
}

void OutputImage::RecordCopyTo(VkBuffer buffer, VkCommandBuffer commands) const {
  VkBufferImageCopy region = {};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {static_cast<uint32_t>(image_->width), static_cast<uint32_t>(image_->height),
                        1};
  context_->vk.CmdCopyImageToBuffer(commands, image_->image, kLayout, buffer, 1, &region);
}

Result<const void*> OutputImage::Texels() const {
  STILLRAY_RETURN_IF_ERROR(host_memory_->Invalidate());
  return static_cast<const void*>(host_->mapped);
}

gpu::MemoryUse OutputImage::memory() const {
  gpu::MemoryUse sum;
  for (const gpu::Arena* arena : {image_memory_.get(), host_memory_.get()}) {
    sum += arena != nullptr ? arena->Need() : gpu::MemoryUse();
  }
  return sum;
}

Result<std::unique_ptr<FrameDownload>> FrameDownload::Create(const gpu::DeviceContext* context,
                                                             int width, int height) {
  std::unique_ptr<FrameDownload> made(new FrameDownload(context, width, height));
  STILLRAY_RETURN_IF_ERROR(made->colour_.Make(width, height));
  return made;
}

Status FrameDownload::Prepare(const Results& wanted) {
  if (wanted.colour) {
    STILLRAY_RETURN_IF_ERROR(colour_.PrepareCopy());
  }
  if ((wanted.display || wanted.shared) && !display_.is_made()) {
    STILLRAY_RETURN_IF_ERROR(display_.Make(width_, height_));
  }
  return wanted.display ? display_.PrepareCopy() : Status::Ok();
}

void FrameDownload::RecordUse(VkCommandBuffer commands) {
  colour_.RecordUse(commands);
  if (display_.is_made()) {
    display_.RecordUse(commands);
  }
}

void FrameDownload::ShowTo(FrameInputs* images) const {
  images->colour = colour_.ref();
  images->display = display_.ref();
}

void FrameDownload::Record(VkCommandBuffer commands, const Results& wanted) const {
  if (wanted.colour) {
    colour_.RecordCopy(commands);
  }
  if (wanted.display) {
    display_.RecordCopy(commands);
  }
}

void FrameDownload::RecordShared(VkCommandBuffer commands, uint32_t queue_family,
                                 const gpu::SharedBuffer& buffer) const {
  display_.RecordCopyTo(buffer.buffer(), commands);
  gpu::RecordRelease(*context_, commands, queue_family, buffer);
}

Status FrameDownload::ReadColour(Image3* colour) const {
  const Result<const void*> texels = colour_.Texels();
  STILLRAY_RETURN_IF_ERROR(texels.status());
  UnpackColour(static_cast<const float*>(*texels), width_, height_, colour);
  return Status::Ok();
}

Status FrameDownload::ReadLength(Image1* length) const {
  const Result<const void*> texels = colour_.Texels();
  STILLRAY_RETURN_IF_ERROR(texels.status());
  *length = Image1(width_, height_);
  UnpackAlpha(static_cast<const float*>(*texels), length);
  return Status::Ok();
}

Status FrameDownload::Read(const Results& wanted, DenoisedFrame* out) const {
  if (!wanted.colour) {
    out->colour = Image3();
  } else {
    STILLRAY_RETURN_IF_ERROR(ReadColour(&out->colour));
  }
  if (!wanted.display) {
    out->display.clear();
  } else {
    const Result<const void*> texels = display_.Texels();
    STILLRAY_RETURN_IF_ERROR(texels.status());
    UnpackDisplay(static_cast<const uint8_t*>(*texels), width_, height_, &out->display);
  }
  return Status::Ok();
}

gpu::MemoryUse FrameDownload::memory() const {
  gpu::MemoryUse sum = colour_.memory();
  sum += display_.memory();
  return sum;
}

}  // namespace stillray::vulkan

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/visibility.h"

#include <fmt/format.h>

namespace stillray::render {
namespace shaders {
extern const std::uint32_t kVisibilityVertex[];
extern const std::size_t kVisibilityVertexWords;
extern const std::uint32_t kVisibilityFragment[];
extern const std::size_t kVisibilityFragmentWords;
}  // namespace shaders

namespace {

constexpr VkFormat kTriangleFormat = VK_FORMAT_R32G32_UINT;

}  // namespace

Status Visibility::CheckSize(int width, int height) const {
  if (!device_->can_draw()) {
    return Status::Unsupported(fmt::format("{}: the device does not draw", device_->info().name));
  }
  const VkPhysicalDeviceLimits& limits = device_->context().limits;
  const auto w = static_cast<uint32_t>(width);
  const auto h = static_cast<uint32_t>(height);
  if (w > limits.maxFramebufferWidth || h > limits.maxFramebufferHeight ||
      uint64_t{w} * h * 2 * sizeof(uint32_t) > limits.maxStorageBufferRange) {
    return Status::Unsupported(fmt::format("{}: the device draws no pictures of {}x{} pixels",
                                           device_->info().name, width, height));
  }
  return Status::Ok();
}

Status Visibility::Build(const SceneState& state, int width, int height) {
  for (size_t i = 0; i < state.instances().size(); ++i) {
    const auto corners = static_cast<uint32_t>(state.instances()[i].mesh->indices.size());
    if (corners >= 3) {
      draws_.push_back({static_cast<uint32_t>(i), corners / 3 * 3});
    }
  }
  const Result<const gpu::Image*> picture = arena_.AddAttachment(kTriangleFormat, width, height);
  STILLRAY_RETURN_IF_ERROR(picture.status());
  const Result<const gpu::Image*> depth =
      arena_.AddAttachment(gpu::Raster::kDepthFormat, width, height);
  STILLRAY_RETURN_IF_ERROR(depth.status());
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  const Result<const gpu::Buffer*> triangles = arena_.AddBuffer(
      pixels * 2 * sizeof(uint32_t), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::BufferPlace::kDevice);
  STILLRAY_RETURN_IF_ERROR(triangles.status());
  picture_ = *picture;
  triangles_ = *triangles;
  STILLRAY_RETURN_IF_ERROR(arena_.Allocate());
  const Result<VkDescriptorSetLayout> layout = sets_.Layout(GpuAccel::kSceneShape);
  STILLRAY_RETURN_IF_ERROR(layout.status());
  return raster_.Create({"visibility",
                         {shaders::kVisibilityVertex, shaders::kVisibilityVertexWords},
                         {shaders::kVisibilityFragment, shaders::kVisibilityFragmentWords},
                         {&*layout, 1},
                         sizeof(RasterView)},
                        *picture_, **depth);
}

Result<std::unique_ptr<Visibility>> Visibility::Create(gpu::Device* device, const GpuAccel* accel,
                                                       const SceneState& state, int width,
                                                       int height) {
  std::unique_ptr<Visibility> made(new Visibility(device, accel));
  STILLRAY_RETURN_IF_ERROR(made->CheckSize(width, height));
  STILLRAY_RETURN_IF_ERROR(made->Build(state, width, height));
  return made;
}

void Visibility::Record(VkCommandBuffer commands, const RasterView& view) const {
  const gpu::DeviceContext& c = device_->context();
  // Waits for the copies of moved instances, and for reads by the previous frame.
  gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_TRANSFER_BIT | c.shader_stages,
                     VK_ACCESS_TRANSFER_WRITE_BIT,
                     VK_PIPELINE_STAGE_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                     VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT);
  VkClearColorValue nothing = {};
  nothing.uint32[0] = kNoInstance;
  const VkExtent2D size = {static_cast<uint32_t>(view.view.width),
                           static_cast<uint32_t>(view.view.height)};
  raster_.RecordBegin(commands, size, nothing);
  const VkDescriptorSet scene = accel_->scene_set();
  c.vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, raster_.layout(), 0, 1,
                             &scene, 0, nullptr);
  c.vk.CmdPushConstants(commands, raster_.layout(), VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(view),
                        &view);
  for (const Draw& draw : draws_) {
    c.vk.CmdDraw(commands, draw.vertices, 1, 0, draw.instance);
  }
  raster_.RecordEnd(commands);
  VkBufferImageCopy region = {};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {size.width, size.height, 1};
  c.vk.CmdCopyImageToBuffer(commands, picture_->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                            triangles_->buffer, 1, &region);
  gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                     c.shader_stages, VK_ACCESS_SHADER_READ_BIT);
}

}  // namespace stillray::render

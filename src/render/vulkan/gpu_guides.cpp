// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/gpu_guides.h"

#include <array>

#include <fmt/format.h>

namespace stillray::render {
namespace shaders {
extern const std::uint32_t kFindGuides[];
extern const std::size_t kFindGuidesWords;
}  // namespace shaders

namespace {

constexpr uint32_t kGroupWidth = 8;  // local_size_x and _y of the shader
constexpr gpu::SetShape kGuideShape = {0, 0, 0, 2};
/// Buffers that guides may be written to.
constexpr uint32_t kMostTargets = 16;

GpuView MakeGpuView(const CameraView& view) {
  return {view.position, view.half_width, view.right,   view.half_height,
          view.up,       view.width,      view.forward, view.height};
}

Status CheckSizes(const CameraView& view, const CameraView& previous, const gpu::Buffer& guides) {
  if (!(view.width >= 1) || !(view.height >= 1) || view.width != previous.width ||
      view.height != previous.height) {
    return Status::InvalidArgument(
        fmt::format("finding guides: the picture has {}x{} pixels and the last one {}x{}, expected "
                    "the same sizes, at least 1x1",
                    view.width, view.height, previous.width, previous.height));
  }
  const auto pixels = static_cast<uint64_t>(view.width) * static_cast<uint64_t>(view.height);
  if (guides.size < pixels * sizeof(GpuGuides)) {
    return Status::InvalidArgument(
        fmt::format("finding guides of {}x{} pixels: the buffer has {} bytes, expected {}",
                    view.width, view.height, guides.size, pixels * sizeof(GpuGuides)));
  }
  return Status::Ok();
}

}  // namespace

Status GpuGuideFinder::Make() {
  const gpu::DeviceContext& c = device_->context();
  const Result<const gpu::Buffer*> frame = arena_.AddBuffer(
      sizeof(GpuFrame), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::BufferPlace::kDevice);
  if (!frame.ok()) {
    return frame.status();
  }
  frame_ = *frame;
  STILLRAY_RETURN_IF_ERROR(arena_.Allocate());
  STILLRAY_RETURN_IF_ERROR(
      sets_.CreatePool(kMostTargets, {0, 0, 0, kMostTargets * kGuideShape.buffers}));
  const Result<VkDescriptorSetLayout> scene = sets_.Layout(GpuAccel::kSceneShape);
  const Result<VkDescriptorSetLayout> own = sets_.Layout(kGuideShape);
  if (!scene.ok() || !own.ok()) {
    return scene.ok() ? own.status() : scene.status();
  }
  const std::array<VkDescriptorSetLayout, 2> layouts = {*scene, *own};
  Result<gpu::Pipeline> pipeline = gpu::Pipeline::Create(
      &c, {"find_guides", {shaders::kFindGuides, shaders::kFindGuidesWords}, layouts, 0, {}});
  if (pipeline.ok()) {
    pipeline_ = std::move(*pipeline);
  }
  return pipeline.status();
}

Status GpuGuideFinder::Record(VkCommandBuffer commands, const CameraView& view,
                              const CameraView& previous, vec2 jitter, const gpu::Buffer& guides) {
  STILLRAY_RETURN_IF_ERROR(CheckSizes(view, previous, guides));
  const Result<VkDescriptorSet> set =
      sets_.Find(kGuideShape, {{}, {}, {frame_->buffer, guides.buffer}});
  if (!set.ok()) {
    return set.status();
  }
  GpuFrame frame;
  frame.view = MakeGpuView(view);
  frame.previous = MakeGpuView(previous);
  frame.point = vec2(0.5f) + jitter;
  frame.width = static_cast<uint32_t>(view.width);
  frame.height = static_cast<uint32_t>(view.height);
  const gpu::DeviceContext& c = device_->context();
  gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0,
                     VK_PIPELINE_STAGE_TRANSFER_BIT, 0);
  c.vk.CmdUpdateBuffer(commands, frame_->buffer, 0, sizeof(frame), &frame);
  gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                     VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT);
  const std::array<VkDescriptorSet, 2> bound = {accel_->scene_set(), *set};
  c.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.handle());
  c.vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.layout(), 0,
                             static_cast<uint32_t>(bound.size()), bound.data(), 0, nullptr);
  c.vk.CmdDispatch(commands, (frame.width + kGroupWidth - 1) / kGroupWidth,
                   (frame.height + kGroupWidth - 1) / kGroupWidth, 1);
  return Status::Ok();
}

Result<std::unique_ptr<GpuGuideFinder>> GpuGuideFinder::Create(gpu::Device* device,
                                                               const GpuAccel* accel) {
  std::unique_ptr<GpuGuideFinder> finder(new GpuGuideFinder(device, accel));
  STILLRAY_RETURN_IF_ERROR(finder->Make());
  return finder;
}

}  // namespace stillray::render

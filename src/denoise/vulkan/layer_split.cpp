// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/vulkan/layer_split.h"

#include <utility>

#include "core/check.h"

namespace stillray::vulkan {
namespace {

VirtualInputs VirtualInputsOf(const gpu::DeviceFrame& pixels) {
  const gpu::VirtualImages& seen = pixels.images().reflection;
  return {RefTo(seen.depth), RefTo(seen.normal), RefTo(seen.motion), RefTo(seen.id),
          RefTo(seen.albedo)};
}

LayerShape ShapeOf(const gpu::FrameShape& frame) {
  return {.width = frame.width,
          .height = frame.height,
          .previous_normals = frame.previous_normals,
          .second_moments = frame.second_moments};
}

}  // namespace

Status FramePart::Download(uint32_t, Frame*) const {
  return Status::Unsupported("a part of a frame stays on its device");
}

Result<std::unique_ptr<LayerSplit>> LayerSplit::Create(std::shared_ptr<gpu::Device> device) {
  Result<std::unique_ptr<LayerPasses>> passes =
      LayerPasses::Create(&device->context(), device->has_timestamps(), 1);
  STILLRAY_RETURN_IF_ERROR(passes.status());
  return std::unique_ptr<LayerSplit>(new LayerSplit(std::move(device), std::move(*passes)));
}

Result<Frame> LayerSplit::MakeLayer(const Frame& frame, float virtual_roughness) {
  const gpu::DeviceFrame& pixels = *gpu::FrameOn(*device_, frame);
  STILLRAY_RETURN_IF_ERROR(CheckSize(frame, pixels));
  STILLRAY_RETURN_IF_ERROR(passes_->Prepare(ShapeOf(pixels.shape())));
  // Other images may have come under the handles of those of the last frame.
  STILLRAY_RETURN_IF_ERROR(passes_->ForgetInputs());
  const FrameFacts facts = FactsOf(frame, pixels);
  const FrameInputs inputs = InputsOf(pixels);
  auto layer = std::make_shared<FramePart>();
  layer->owners = {frame.on_device, passes_->images()};
  layer->facts = passes_->FactsOfLayer(facts);
  layer->inputs = passes_->InputsOfLayer(inputs);
  layer->record = [this, facts, inputs, seen = VirtualInputsOf(pixels),
                   virtual_roughness](VkCommandBuffer commands) {
    return passes_->RecordLayer(commands, facts, inputs, seen, virtual_roughness);
  };
  Frame part = frame;
  layer_ = layer;
  part.on_device = std::move(layer);
  return part;
}

Result<Frame> LayerSplit::MakeRest(const Frame& frame) {
  const gpu::DeviceFrame& pixels = *gpu::FrameOn(*device_, frame);
  const FrameFacts facts = FactsOf(frame, pixels);
  const FrameInputs inputs = InputsOf(pixels);
  auto rest = std::make_shared<FramePart>();
  rest->owners = {frame.on_device, passes_->images()};
  rest->facts = passes_->FactsOfRest(facts);
  rest->inputs = passes_->InputsOfRest(inputs);
  rest->record = [this, facts, inputs](VkCommandBuffer commands) {
    const std::shared_ptr<FramePart> layer = layer_.lock();
    STILLRAY_CHECK(layer != nullptr);
    return passes_->RecordRest(commands, facts, inputs, layer->picture);
  };
  Frame part = frame;
  part.on_device = std::move(rest);
  return part;
}

DeviceMemory LayerSplit::memory() const {
  const gpu::MemoryUse use = passes_->memory();
  return {use.allocations, use.resources, use.bytes, use.largest};
}

}  // namespace stillray::vulkan

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/vulkan/layer_split.h"

#include <utility>

#include "core/check.h"

namespace stillray::vulkan {
namespace {

VirtualInputs VirtualInputsOf(const gpu::DeviceFrame& pixels, GuideSource source) {
  const gpu::VirtualImages& seen =
      source == GuideSource::kReflection ? pixels.images().reflection : pixels.images().refraction;
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
  return std::unique_ptr<LayerSplit>(new LayerSplit(std::move(device)));
}

Result<Frame> LayerSplit::MakeLayer(const Frame& frame, GuideSource source,
                                    const Settings& settings) {
  const gpu::DeviceFrame& pixels = *gpu::FrameOn(*device_, frame);
  STILLRAY_RETURN_IF_ERROR(CheckSize(frame, pixels));
  Layer& layer = LayerOf(source);
  if (layer.passes == nullptr) {
    Result<std::unique_ptr<LayerPasses>> made =
        LayerPasses::Create(&device_->context(), source, device_->has_timestamps(), 0);
    STILLRAY_RETURN_IF_ERROR(made.status());
    layer.passes = std::move(*made);
  }
  LayerPasses* const passes = layer.passes.get();
  STILLRAY_RETURN_IF_ERROR(passes->Prepare(ShapeOf(pixels.shape())));
  // New images may have the handles of the last frame's images.
  STILLRAY_RETURN_IF_ERROR(passes->ForgetInputs());
  const FrameFacts facts = FactsOf(frame, pixels);
  const FrameInputs inputs = InputsOf(pixels);
  auto of_layer = std::make_shared<FramePart>();
  of_layer->owners = {frame.on_device, passes->images()};
  of_layer->facts = passes->FactsOfLayer(facts);
  of_layer->inputs = passes->InputsOfLayer(inputs);
  of_layer->record = [passes, facts, inputs, seen = VirtualInputsOf(pixels, source),
                      select = SelectGuidesOf(settings, source)](gpu::CommandList* commands) {
    return passes->RecordLayer(commands, facts, inputs, seen, select);
  };
  Frame part = frame;
  std::erase_if(part.signals,
                [&](const Signal& signal) { return !IsLightOf(source, signal.kind); });
  layer.part = of_layer;
  part.on_device = std::move(of_layer);
  return part;
}

Result<Frame> LayerSplit::MakeRest(const Frame& frame) {
  const gpu::DeviceFrame& pixels = *gpu::FrameOn(*device_, frame);
  auto rest = std::make_shared<FramePart>();
  rest->owners = {frame.on_device};
  rest->facts = FactsOf(frame, pixels);
  rest->inputs = InputsOf(pixels);
  std::vector<std::function<Status(gpu::CommandList*)>> records;
  for (const Layer* layer : {&reflection_, &refraction_}) {
    if (layer->part.expired()) {
      continue;
    }
    LayerPasses* const passes = layer->passes.get();
    records.emplace_back([passes, facts = rest->facts, inputs = rest->inputs,
                          part = layer->part](gpu::CommandList* commands) {
      const std::shared_ptr<FramePart> of_layer = part.lock();
      STILLRAY_CHECK(of_layer != nullptr);
      return passes->RecordRest(commands, facts, inputs, of_layer->picture);
    });
    rest->owners.push_back(passes->images());
    rest->inputs = passes->InputsOfRest(rest->facts, rest->inputs);
    rest->facts = passes->FactsOfRest(rest->facts);
  }
  rest->record = [records = std::move(records)](gpu::CommandList* commands) {
    for (const auto& record : records) {
      STILLRAY_RETURN_IF_ERROR(record(commands));
    }
    return Status::Ok();
  };
  Frame part = frame;
  part.on_device = std::move(rest);
  return part;
}

const LayerImages* LayerSplit::images(GuideSource source) const {
  const Layer& layer = source == GuideSource::kReflection ? reflection_ : refraction_;
  return layer.passes != nullptr ? layer.passes->images().get() : nullptr;
}

void LayerSplit::AddTimes(std::vector<StageTime>* times) const {
  for (const Layer* layer : {&reflection_, &refraction_}) {
    if (!layer->part.expired()) {
      layer->passes->AddTimes(times);
    }
  }
}

DeviceMemory LayerSplit::memory() const {
  gpu::MemoryUse use;
  for (const Layer* layer : {&reflection_, &refraction_}) {
    if (layer->passes != nullptr) {
      use += layer->passes->memory();
    }
  }
  return {use.allocations, use.resources, use.bytes, use.largest};
}

}  // namespace stillray::vulkan

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/vulkan/layer_split.h"

#include <utility>

#include "core/check.h"
#include "denoise/vulkan/frame_images.h"

namespace stillray::vulkan {

namespace shaders {
#define STILLRAY_SHADER(name)           \
  extern const std::uint32_t k##name[]; \
  extern const std::size_t k##name##Words;
STILLRAY_SHADER(SelectGuides)
STILLRAY_SHADER(RescaleMoments)
STILLRAY_SHADER(AddLayer)
#undef STILLRAY_SHADER
}  // namespace shaders

namespace {

/// The kinds of light of the layer.
constexpr auto kDirect = static_cast<size_t>(SignalKind::kDirectSpecular);
constexpr auto kIndirect = static_cast<size_t>(SignalKind::kIndirectSpecular);
constexpr uint32_t kLights = 1u << kDirect | 1u << kIndirect;

/// Of select_guides.comp.
struct SelectPush {
  float virtual_roughness = 0;
  int32_t has_previous_normal = 0;
};

struct PassInfo {
  const char* stage;  ///< in timings
  std::span<const uint32_t> code;
  uint32_t reads;
  uint32_t writes;
  uint32_t push_bytes;
};

/// In the order of LayerSplit::Pass.
PassInfo InfoOf(size_t pass) {
  const PassInfo infos[] = {
      {"select_guides",
       {shaders::kSelectGuides, shaders::kSelectGuidesWords},
       13,
       7,
       sizeof(SelectPush)},
      {"select_guides", {shaders::kRescaleMoments, shaders::kRescaleMomentsWords}, 6, 2, 0},
      {"add_layer", {shaders::kAddLayer, shaders::kAddLayerWords}, 7, 2, 0},
  };
  return infos[pass];
}

constexpr gpu::SetShape kMostDescriptors = {13 + 6 + 7, 7 + 2 + 2, 0, 0};
constexpr uint32_t kMostMarks = 4;

constexpr VkPipelineStageFlags kCompute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;

void WaitForWrites(const gpu::DeviceContext& context, VkCommandBuffer commands) {
  gpu::MemoryBarrier(context, commands, kCompute, VK_ACCESS_SHADER_WRITE_BIT, kCompute,
                     VK_ACCESS_SHADER_READ_BIT);
}

}  // namespace

Status FramePart::Download(uint32_t, Frame*) const {
  return Status::Unsupported("a part of a frame stays on its device");
}

Result<std::unique_ptr<LayerSplit>> LayerSplit::Create(std::shared_ptr<gpu::Device> device) {
  std::unique_ptr<LayerSplit> made(new LayerSplit(std::move(device)));
  STILLRAY_RETURN_IF_ERROR(made->sets_.CreatePool(kPassCount, kMostDescriptors));
  if (made->device_->has_timestamps()) {
    STILLRAY_RETURN_IF_ERROR(made->layer_times_.Create(kMostMarks));
    STILLRAY_RETURN_IF_ERROR(made->rest_times_.Create(kMostMarks));
  }
  return made;
}

Status LayerSplit::MakeImages(const gpu::FrameShape& shape) {
  auto made = std::make_shared<LayerImages>(&device_->context());
  Status status;
  const auto add = [&](VkFormat format, const gpu::Image** to) {
    if (status.ok()) {
      const Result<const gpu::Image*> added =
          made->arena.AddImage(format, shape.width, shape.height, 0);
      status = added.status();
      *to = added.ok() ? *added : nullptr;
    }
  };
  constexpr VkFormat kColour = VK_FORMAT_R32G32B32A32_SFLOAT;
  constexpr VkFormat kScalar = VK_FORMAT_R32_SFLOAT;
  constexpr VkFormat kMotion = VK_FORMAT_R32G32_SFLOAT;
  add(kScalar, &made->depth);
  add(kColour, &made->normal);
  add(kMotion, &made->motion);
  add(VK_FORMAT_R32_UINT, &made->id);
  add(kScalar, &made->roughness);
  add(kColour, &made->albedo);
  if (shape.previous_normals) {
    add(kColour, &made->previous_normal);
  }
  if (shape.second_moments) {
    add(kScalar, &made->direct_moment);
    add(kScalar, &made->indirect_moment);
  }
  add(kMotion, &made->picture_motion);
  add(kColour, &made->emission);
  STILLRAY_RETURN_IF_ERROR(status);
  STILLRAY_RETURN_IF_ERROR(made->arena.Allocate());
  images_ = std::move(made);
  shape_ = shape;
  return Status::Ok();
}

/// Makes images for frames of this shape, if necessary, and forgets the sets of the last frame.
Status LayerSplit::Prepare(const gpu::FrameShape& shape) {
  if (images_ == nullptr || shape_ != shape) {
    images_.reset();  // first, since both may not fit into memory
    STILLRAY_RETURN_IF_ERROR(MakeImages(shape));
  }
  return sets_.Clear();  // other images may have come under the same handles
}

void LayerSplit::Mark(VkCommandBuffer commands, const char* name, gpu::Timestamps* times) {
  if (device_->has_timestamps()) {
    times->Begin(commands);
    times->Mark(commands, name);
  }
}

void LayerSplit::End(VkCommandBuffer commands, gpu::Timestamps* times) {
  if (device_->has_timestamps()) {
    times->End(commands);
  }
}

/// One thread for each pixel. \param images  those that the shader reads, then those that it writes
Status LayerSplit::Run(VkCommandBuffer commands, Pass pass, std::span<const ImageRef> images,
                       std::span<const std::byte> push) {
  const gpu::DeviceContext& c = device_->context();
  const PassInfo info = InfoOf(pass);
  const gpu::SetShape shape = {info.reads, info.writes, 0, 0};
  std::optional<gpu::Pipeline>& pipeline = pipelines_[pass];
  if (!pipeline) {
    const Result<VkDescriptorSetLayout> layout = sets_.Layout(shape);
    STILLRAY_RETURN_IF_ERROR(layout.status());
    Result<gpu::Pipeline> made =
        gpu::Pipeline::Create(&c, {info.stage, info.code, {&*layout, 1}, info.push_bytes, {}});
    STILLRAY_RETURN_IF_ERROR(made.status());
    pipeline = *made;
  }
  gpu::SetContent content;
  for (const ImageRef& image : images) {
    content.images.push_back(image.view);
    content.layouts.push_back(image.layout);
  }
  const Result<VkDescriptorSet> set = sets_.Find(shape, content);
  STILLRAY_RETURN_IF_ERROR(set.status());
  c.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->handle());
  c.vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->layout(), 0, 1,
                             &*set, 0, nullptr);
  if (!push.empty()) {
    c.vk.CmdPushConstants(commands, pipeline->layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                          info.push_bytes, push.data());
  }
  const Groups groups = GroupsFor(shape_.width, shape_.height);
  c.vk.CmdDispatch(commands, groups.x, groups.y, 1);
  return Status::Ok();
}

Status LayerSplit::RecordLayer(VkCommandBuffer commands, const gpu::FrameImages& from,
                               float virtual_roughness) {
  const gpu::DeviceContext& c = device_->context();
  LayerImages& to = *images_;
  if (!to.used) {
    to.used = true;
    to.arena.RecordFirstUse(commands, kCompute, VK_ACCESS_SHADER_WRITE_BIT);
  }
  const bool has_previous = to.previous_normal != nullptr;
  // The shader needs images of the right format in place of those that are not given.
  const gpu::Image* previous_from = has_previous ? from.previous_normal : from.normal;
  const gpu::Image* previous_to = has_previous ? to.previous_normal : to.normal;
  const gpu::VirtualImages& seen = from.reflection;
  const ImageRef images[] = {
      RefTo(from.depth),     RefTo(from.normal),   RefTo(from.motion), RefTo(from.id),
      RefTo(from.roughness), RefTo(previous_from), RefTo(from.albedo), RefTo(from.specular_albedo),
      RefTo(seen.depth),     RefTo(seen.normal),   RefTo(seen.motion), RefTo(seen.id),
      RefTo(seen.albedo),    RefTo(to.depth),      RefTo(to.normal),   RefTo(to.motion),
      RefTo(to.id),          RefTo(to.roughness),  RefTo(to.albedo),   RefTo(previous_to)};
  const SelectPush push = {virtual_roughness, has_previous ? 1 : 0};
  Mark(commands, InfoOf(kSelectGuides).stage, &layer_times_);
  STILLRAY_RETURN_IF_ERROR(
      Run(commands, kSelectGuides, images, std::as_bytes(std::span(&push, 1))));
  WaitForWrites(c, commands);
  if (to.direct_moment != nullptr) {
    const ImageRef moments[] = {RefTo(from.lights[kDirect]),
                                RefTo(from.lights[kIndirect]),
                                RefTo(from.second_moments[kDirect]),
                                RefTo(from.second_moments[kIndirect]),
                                RefTo(from.specular_albedo),
                                RefTo(to.albedo),
                                RefTo(to.direct_moment),
                                RefTo(to.indirect_moment)};
    STILLRAY_RETURN_IF_ERROR(Run(commands, kRescaleMoments, moments, {}));
    WaitForWrites(c, commands);
  }
  End(commands, &layer_times_);
  return Status::Ok();
}

Status LayerSplit::RecordRest(VkCommandBuffer commands, const gpu::FrameImages& from) {
  const std::shared_ptr<FramePart> layer = layer_.lock();
  STILLRAY_CHECK(layer != nullptr);
  const gpu::DeviceContext& c = device_->context();
  const LayerImages& own = *images_;
  const ImageRef images[] = {RefTo(from.depth),    RefTo(from.motion),        RefTo(from.id),
                             RefTo(from.emission), RefTo(own.motion),         RefTo(own.albedo),
                             layer->picture,       RefTo(own.picture_motion), RefTo(own.emission)};
  WaitForWrites(c, commands);  // of the layer's picture
  Mark(commands, InfoOf(kAddLayer).stage, &rest_times_);
  STILLRAY_RETURN_IF_ERROR(Run(commands, kAddLayer, images, {}));
  WaitForWrites(c, commands);
  End(commands, &rest_times_);
  return Status::Ok();
}

Result<Frame> LayerSplit::MakeLayer(const Frame& frame, float virtual_roughness) {
  const gpu::DeviceFrame& pixels = *gpu::FrameOn(*device_, frame);
  STILLRAY_RETURN_IF_ERROR(CheckSize(frame, pixels));
  STILLRAY_RETURN_IF_ERROR(Prepare(pixels.shape()));
  const LayerImages& own = *images_;
  auto layer = std::make_shared<FramePart>();
  layer->owners = {frame.on_device, images_};
  FrameFacts& facts = layer->facts;
  facts = FactsOf(frame, pixels);
  facts.lights &= kLights;
  facts.second_moments &= kLights;
  facts.albedos = 1u << 1;
  facts.has_emission = false;
  facts.has_background = false;
  FrameInputs& inputs = layer->inputs;
  inputs = InputsOf(pixels);
  inputs.depth = RefTo(own.depth);
  inputs.normal = RefTo(own.normal);
  inputs.motion = RefTo(own.motion);
  inputs.id = RefTo(own.id);
  inputs.roughness = RefTo(own.roughness);
  inputs.albedos[1] = RefTo(own.albedo);
  inputs.previous_normal = RefTo(own.previous_normal);
  inputs.second_moments[kDirect] = RefTo(own.direct_moment);
  inputs.second_moments[kIndirect] = RefTo(own.indirect_moment);
  layer->record = [this, &pixels, virtual_roughness](VkCommandBuffer commands) {
    return RecordLayer(commands, pixels.images(), virtual_roughness);
  };
  Frame part = frame;
  layer_ = layer;
  part.on_device = std::move(layer);
  return part;
}

Result<Frame> LayerSplit::MakeRest(const Frame& frame) {
  const gpu::DeviceFrame& pixels = *gpu::FrameOn(*device_, frame);
  auto rest = std::make_shared<FramePart>();
  rest->owners = {frame.on_device, images_};
  rest->facts = FactsOf(frame, pixels);
  rest->facts.black_lights = kLights;
  rest->facts.second_moments &= ~kLights;
  rest->inputs = InputsOf(pixels);
  rest->inputs.motion = RefTo(images_->picture_motion);
  rest->inputs.emission = RefTo(images_->emission);
  rest->record = [this, &pixels](VkCommandBuffer commands) {
    return RecordRest(commands, pixels.images());
  };
  Frame part = frame;
  part.on_device = std::move(rest);
  return part;
}

void LayerSplit::AddTimes(std::vector<StageTime>* times) const {
  for (const gpu::Timestamps* of_part : {&layer_times_, &rest_times_}) {
    for (const gpu::DeviceTime& time : of_part->Read()) {
      times->push_back({time.name, time.milliseconds});
    }
  }
}

DeviceMemory LayerSplit::memory() const {
  const gpu::MemoryUse use = images_ != nullptr ? images_->arena.Need() : gpu::MemoryUse();
  return {use.allocations, use.resources, use.bytes, use.largest};
}

}  // namespace stillray::vulkan

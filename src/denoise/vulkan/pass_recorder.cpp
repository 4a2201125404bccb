// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/pass_recorder.h"

#include <algorithm>
#include <utility>

namespace stillray::vulkan {
namespace {

/// The content of set 0, in the order of the bindings of common.glsl.
gpu::SetContent FrameContent(const FrameInputs& in, const FrameImages& images) {
  gpu::SetContent content;
  const auto add = [&](const ImageRef& given, const gpu::Image* otherwise) {
    const bool is_given = given.view != VK_NULL_HANDLE;
    content.images.push_back(is_given ? given.view : otherwise->view);
    content.layouts.push_back(is_given ? given.layout : VK_IMAGE_LAYOUT_GENERAL);
  };
  for (const ImageRef& light : in.lights) {
    add(light, images.no_input);
  }
  for (const ImageRef& moment : in.second_moments) {
    add(moment, images.no_input);
  }
  add(in.depth, images.no_input);
  add(in.normal, images.no_input);
  add(in.id, images.no_ids);
  add(in.motion, images.no_input);
  for (const ImageRef& albedo : in.albedos) {
    add(albedo, images.no_input);
  }
  add(in.emission, images.no_input);
  add(in.background, images.no_input);
  add(in.samples, images.no_input);
  add(in.roughness, images.no_input);
  add(in.confidence, images.no_input);
  add(in.previous_normal, images.no_input);
  add(in.colour_is_half ? ImageRef() : in.colour, images.no_float_output);
  add(in.colour_is_half ? in.colour : ImageRef(), images.no_half_output);
  add(in.display, images.no_display);
  content.buffers = {images.parameters->buffer, images.state->buffer, images.partials->buffer};
  return content;
}

/// Their addresses represent the frame's buffers, which every pass may use.
constexpr char kState = 0;
constexpr char kPartials = 0;

/// Calls use(resource, writes) for all resources of a pass except the frame's inputs, parameters
/// and outputs. Each output is written by one pass only.
template <typename Function>
void ForEachUse(const ShaderInfo& info, std::span<const gpu::Image* const> images,
                std::span<const gpu::Buffer* const> buffers, const Function& use) {
  for (size_t i = 0; i < images.size(); ++i) {
    use(images[i], i >= info.reads);
  }
  for (uint32_t i = 0; i < info.buffers; ++i) {
    use(buffers[i], true);
  }
  const std::pair<Use, const void*> of_frame[] = {{info.state, &kState},
                                                  {info.partials, &kPartials}};
  for (const auto& [how, resource] : of_frame) {
    if (how != Use::kNone) {
      use(resource, Writes(how));
    }
  }
}

}  // namespace

void PassRecorder::UseFrame(const FrameInputs& inputs, const FrameImages& images) {
  const gpu::SetContent content = FrameContent(inputs, images);
  const Result<VkDescriptorSet> set = sets_->FindForFrame(kFrameSet, content);
  if (!set.ok()) {
    status_ = set.status();
    return;
  }
  frame_set_ = *set;
  always_waits_ = true;  // passes may have written the inputs
}

void PassRecorder::Barrier() {
  EmitBarrier();
  always_waits_ = true;
}

void PassRecorder::EmitBarrier() {
  always_waits_ = false;
  read_.clear();
  written_.clear();
  constexpr VkPipelineStageFlags kStages =
      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
  commands_->Barrier(kStages, VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT, kStages,
                     VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT |
                         VK_ACCESS_UNIFORM_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                         VK_ACCESS_TRANSFER_WRITE_BIT);
}

bool PassRecorder::Waits(const ShaderInfo& info, std::span<const gpu::Image* const> images) const {
  bool waits = always_waits_;
  ForEachUse(info, images, buffers_, [&](const void* resource, bool writes) {
    waits = waits || std::ranges::find(written_, resource) != written_.end() ||
            (writes && std::ranges::find(read_, resource) != read_.end());
  });
  return waits;
}

void PassRecorder::NoteUses(const ShaderInfo& info, std::span<const gpu::Image* const> images) {
  ForEachUse(info, images, buffers_, [&](const void* resource, bool writes) {
    (writes ? written_ : read_).push_back(resource);
  });
}

void PassRecorder::RunBytes(Shader shader, Groups groups, std::span<const gpu::Image* const> images,
                            const void* push, std::span<const uint32_t> constants) {
  if (!status_.ok()) {
    return;
  }
  const ShaderInfo& info = InfoOf(shader);
  const Result<const gpu::Pipeline*> pipeline = pipelines_->Find(shader, constants);
  if (!pipeline.ok()) {
    status_ = pipeline.status();
    return;
  }
  gpu::SetContent content;
  for (const gpu::Image* image : images) {
    content.images.push_back(image->view);
    bytes_ += gpu::BytesOf(*image);
  }
  for (uint32_t i = 0; i < info.buffers; ++i) {
    content.buffers.push_back(buffers_[i]->buffer);
  }
  // Other shaders use only the denoiser's own images, which recur.
  const bool for_frame = shader == Shader::kStoreSignal;
  const Result<VkDescriptorSet> own =
      for_frame ? sets_->FindForFrame(OwnSet(info), content) : sets_->Find(OwnSet(info), content);
  if (!own.ok()) {
    status_ = own.status();
    return;
  }
  if (Waits(info, images)) {
    EmitBarrier();
  }
  NoteUses(info, images);
  const std::string_view part = next_part_.empty() ? std::string_view(info.stage) : next_part_;
  next_part_ = {};
  if (part_ != part) {
    part_ = part;
    commands_->BeginPart(part_, times_);
  }
  const gpu::DispatchCommand dispatch = {
      (*pipeline)->handle(), (*pipeline)->layout(), {frame_set_, *own}, 2, groups.x, groups.y};
  const size_t push_bytes = push != nullptr ? info.push_bytes : 0;
  commands_->Dispatch(dispatch, {static_cast<const std::byte*>(push), push_bytes});
}

void PassRecorder::EndParts() {
  commands_->BeginPart({}, times_);
}

}  // namespace stillray::vulkan

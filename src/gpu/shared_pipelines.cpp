// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/shared_pipelines.h"

#include <algorithm>
#include <string>

#include "gpu/shader_folder.h"

namespace stillray::gpu {

SharedPipelines::~SharedPipelines() {
  const DeviceFunctions& vk = context_->vk;
  for (const std::unique_ptr<Entry>& entry : entries_) {
    vk.DestroyPipeline(context_->device, entry->pipeline.handle(), nullptr);
    vk.DestroyPipelineLayout(context_->device, entry->pipeline.layout(), nullptr);
  }
  for (const auto& [shape, layout] : layouts_) {
    vk.DestroyDescriptorSetLayout(context_->device, layout, nullptr);
  }
  vk.DestroySampler(context_->device, sampler_, nullptr);
}

/// Creates the bilinear sampler; wrapping is resolved by the textures' borders.
Status SharedPipelines::MakeSampler() {
  VkSamplerCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO;
  info.magFilter = VK_FILTER_LINEAR;
  info.minFilter = VK_FILTER_LINEAR;
  info.addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  info.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  return ToStatus(context_->vk.CreateSampler(context_->device, &info, nullptr, &sampler_),
                  "creating a sampler");
}

Result<VkDescriptorSetLayout> SharedPipelines::Layout(const SetShape& shape) {
  const std::lock_guard lock(mutex_);
  for (const auto& [known, layout] : layouts_) {
    if (known == shape) {
      return layout;
    }
  }
  if (shape.textures > 0 && sampler_ == VK_NULL_HANDLE) {
    STILLRAY_RETURN_IF_ERROR(MakeSampler());
  }
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  STILLRAY_RETURN_IF_ERROR(MakeSetLayout(*context_, shape, sampler_, &layout));
  layouts_.emplace_back(shape, layout);
  return layout;
}

SharedPipelines::Entry* SharedPipelines::EntryOf(std::span<const uint32_t> code,
                                                 const PipelineInfo& info) {
  const std::lock_guard lock(mutex_);
  for (const std::unique_ptr<Entry>& entry : entries_) {
    if (entry->push_bytes == info.push_bytes && std::ranges::equal(entry->sets, info.sets) &&
        std::ranges::equal(entry->constants, info.constants) &&
        std::ranges::equal(entry->code, code)) {
      return entry.get();
    }
  }
  auto entry = std::make_unique<Entry>();
  entry->code.assign(code.begin(), code.end());
  entry->sets.assign(info.sets.begin(), info.sets.end());
  entry->push_bytes = info.push_bytes;
  entry->constants.assign(info.constants.begin(), info.constants.end());
  entries_.push_back(std::move(entry));
  return entries_.back().get();
}

Result<Pipeline> SharedPipelines::Find(const PipelineInfo& info) {
  const Result<std::vector<uint32_t>> replacement = ReplacementOf(info.code);
  STILLRAY_RETURN_IF_ERROR(replacement.status());
  Entry* entry = EntryOf(replacement->empty() ? info.code : *replacement, info);
  const std::lock_guard lock(entry->compiling);
  if (entry->pipeline.handle() == VK_NULL_HANDLE) {
    STILLRAY_RETURN_IF_ERROR(Compile(info.name, entry));
  }
  return entry->pipeline;
}

Status SharedPipelines::Compile(const char* name, Entry* entry) {
  const PipelineInfo info = {name, entry->code, entry->sets, entry->push_bytes, entry->constants};
  VkPipelineLayout layout = VK_NULL_HANDLE;
  STILLRAY_RETURN_IF_ERROR(MakePipelineLayout(*context_, info.sets, VK_SHADER_STAGE_COMPUTE_BIT,
                                              info.push_bytes, &layout));
  VkPipeline pipeline = VK_NULL_HANDLE;
  const Status made = MakeComputePipeline(*context_, info, layout, &pipeline);
  if (!made.ok()) {
    context_->vk.DestroyPipelineLayout(context_->device, layout, nullptr);
    return made;
  }
  entry->pipeline = Pipeline(pipeline, layout);
  const std::lock_guard lock(mutex_);
  ++created_;
  return Status::Ok();
}

size_t SharedPipelines::created() const {
  const std::lock_guard lock(mutex_);
  return created_;
}

}  // namespace stillray::gpu

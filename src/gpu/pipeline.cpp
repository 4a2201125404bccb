// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/pipeline.h"

#include <algorithm>
#include <string>
#include <utility>

#include "gpu/pipeline_statistics.h"
#include "gpu/shader_folder.h"
#include "gpu/shared_pipelines.h"
#include "gpu/uniform_blocks.h"

namespace stillray::gpu {
namespace {

/// Descriptor type of bindings that are uniform blocks in GLSL.
VkDescriptorType UniformType(const DeviceContext& context) {
  return context.is_software ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER
                             : VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
}

VkDescriptorType TypeOf(const DeviceContext& context, const SetShape& shape, uint32_t binding) {
  if (binding < shape.sampled) {
    return VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
  }
  if (binding < shape.sampled + shape.stored) {
    return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  }
  if (binding < shape.sampled + shape.stored + shape.uniforms) {
    return UniformType(context);
  }
  if (binding >= shape.count() - shape.textures) {
    return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  }
  return binding < shape.count() - shape.textures - shape.accelerations
             ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER
             : VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
}

Status MakeModule(const DeviceContext& context, std::span<const uint32_t> code, const char* action,
                  VkShaderModule* out) {
  std::vector<uint32_t> with_storage;
  if (context.is_software) {
    with_storage = WithStorageBlocks(code);
    code = with_storage;
  }
  VkShaderModuleCreateInfo module = {};
  module.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  module.codeSize = code.size_bytes();
  module.pCode = code.data();
  return ToStatus(context.vk.CreateShaderModule(context.device, &module, nullptr, out), action);
}

}  // namespace

uint32_t StorageBuffersOf(const DeviceContext& context, const SetShape& shape) {
  return shape.buffers + (context.is_software ? shape.uniforms : 0);
}

DescriptorSets::~DescriptorSets() {
  for (const VkDescriptorPool pool : pools_) {
    context_->vk.DestroyDescriptorPool(context_->device, pool, nullptr);
  }
}

Status DescriptorSets::CreatePool(uint32_t most, const SetShape& all, uint32_t in_flight) {
  most_ = most;
  in_flight_ = in_flight;
  all_ = all;
  entries_.reserve(most);
  return AddPool();
}

Status DescriptorSets::AddPool() {
  std::vector<VkDescriptorPoolSize> sizes;
  for (const auto& [type, count] :
       {std::pair{VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, all_.sampled},
        std::pair{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, all_.stored},
        std::pair{UniformType(*context_), all_.uniforms},
        std::pair{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, all_.buffers},
        std::pair{VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, all_.accelerations},
        std::pair{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, all_.textures}}) {
    if (count > 0) {
      sizes.push_back({type, count});
    }
  }
  VkDescriptorPoolCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
  info.maxSets = most_;
  info.poolSizeCount = static_cast<uint32_t>(sizes.size());
  info.pPoolSizes = sizes.data();
  VkDescriptorPool pool = VK_NULL_HANDLE;
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(context_->vk.CreateDescriptorPool(context_->device, &info, nullptr, &pool),
               "creating a descriptor pool"));
  pools_.push_back(pool);
  taken_ = 0;
  return Status::Ok();
}

Result<VkDescriptorSetLayout> DescriptorSets::Layout(const SetShape& shape) const {
  return context_->pipelines->Layout(shape);
}

/// Resets the first pool and destroys all others.
Status DescriptorSets::Clear() {
  entries_.clear();
  frames_.clear();
  taken_ = 0;
  while (pools_.size() > 1) {
    context_->vk.DestroyDescriptorPool(context_->device, pools_.back(), nullptr);
    pools_.pop_back();
  }
  return pools_.empty()
             ? AddPool()
             : ToStatus(context_->vk.ResetDescriptorPool(context_->device, pools_.front(), 0),
                        "resetting a descriptor pool");
}

VkResult DescriptorSets::AllocateFromLast(VkDescriptorSetLayout layout,
                                          VkDescriptorSet* set) const {
  VkDescriptorSetAllocateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
  info.descriptorPool = pools_.back();
  info.descriptorSetCount = 1;
  info.pSetLayouts = &layout;
  return context_->vk.AllocateDescriptorSets(context_->device, &info, set);
}

Result<VkDescriptorSet> DescriptorSets::Allocate(const SetShape& shape) {
  const Result<VkDescriptorSetLayout> layout = Layout(shape);
  STILLRAY_RETURN_IF_ERROR(layout.status());
  if (taken_ == most_) {
    STILLRAY_RETURN_IF_ERROR(AddPool());
  }
  VkDescriptorSet set = VK_NULL_HANDLE;
  VkResult result = AllocateFromLast(*layout, &set);
  const bool exhausted =
      result == VK_ERROR_OUT_OF_POOL_MEMORY || result == VK_ERROR_FRAGMENTED_POOL;
  if (exhausted && taken_ > 0) {
    STILLRAY_RETURN_IF_ERROR(AddPool());
    result = AllocateFromLast(*layout, &set);
  }
  STILLRAY_RETURN_IF_ERROR(ToStatus(result, "allocating a descriptor set"));
  ++taken_;
  return set;
}

Result<VkDescriptorSet> DescriptorSets::Find(const SetShape& shape, const SetContent& content) {
  for (const Entry& entry : entries_) {
    if (entry.content == content && entry.shape == shape) {
      return entry.set;
    }
  }
  const Result<VkDescriptorSet> set = Allocate(shape);
  STILLRAY_RETURN_IF_ERROR(set.status());
  Write(shape, content, *set);
  entries_.push_back({shape, content, *set});
  return set;
}

void DescriptorSets::BeginFrame(uint32_t number) {
  if (in_flight_ == 0) {
    return;
  }
  frames_.resize(in_flight_);
  frame_ = number % in_flight_;
  for (FrameEntry& entry : frames_[frame_]) {
    entry.used = false;
  }
}

Result<VkDescriptorSet> DescriptorSets::FindForFrame(const SetShape& shape,
                                                     const SetContent& content) {
  if (in_flight_ == 0) {
    return Find(shape, content);
  }
  std::vector<FrameEntry>& own = frames_[frame_];
  auto free = std::find_if(own.begin(), own.end(), [&](const FrameEntry& entry) {
    return !entry.used && entry.shape == shape;
  });
  if (free == own.end()) {
    const Result<VkDescriptorSet> set = Allocate(shape);
    STILLRAY_RETURN_IF_ERROR(set.status());
    free = own.insert(own.end(), {shape, *set, false});
  }
  free->used = true;
  Write(shape, content, free->set);
  return free->set;
}

Result<VkDescriptorSet> DescriptorSets::CreateSingle(const SetShape& shape,
                                                     std::span<const Buffer* const> buffers) {
  STILLRAY_RETURN_IF_ERROR(CreatePool(1, shape));
  SetContent content;
  for (const Buffer* buffer : buffers) {
    content.buffers.push_back(buffer->buffer);
  }
  return Find(shape, content);
}

void DescriptorSets::Write(const SetShape& shape, const SetContent& content,
                           VkDescriptorSet set) const {
  std::vector<VkDescriptorImageInfo> images(content.images.size());
  std::vector<VkDescriptorBufferInfo> buffers(content.buffers.size());
  std::vector<VkDescriptorImageInfo> textures(content.textures.size());
  std::vector<VkWriteDescriptorSet> writes(shape.count());
  std::vector<VkWriteDescriptorSetAccelerationStructureKHR> accelerations(shape.accelerations);
  VkWriteDescriptorSetAccelerationStructureKHR acceleration = {};
  acceleration.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR;
  acceleration.accelerationStructureCount = 1;
  for (uint32_t i = 0; i < shape.count(); ++i) {
    VkWriteDescriptorSet& write = writes[i];
    write = {};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set;
    write.dstBinding = i;
    write.descriptorCount = 1;
    write.descriptorType = TypeOf(*context_, shape, i);
    if (i < images.size()) {
      const VkImageLayout layout =
          content.layouts.empty() ? VK_IMAGE_LAYOUT_GENERAL : content.layouts[i];
      images[i] = {VK_NULL_HANDLE, content.images[i], layout};
      write.pImageInfo = &images[i];
    } else if (i >= shape.count() - shape.textures) {
      const size_t k = i - (shape.count() - shape.textures);
      // The sampler is immutable, in the layout.
      textures[k] = {VK_NULL_HANDLE, content.textures[k], VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
      write.pImageInfo = &textures[k];
    } else if (i >= shape.count() - shape.textures - shape.accelerations) {
      const size_t k = i - images.size() - buffers.size();
      accelerations[k] = acceleration;
      accelerations[k].pAccelerationStructures = &content.accelerations[k];
      write.pNext = &accelerations[k];
    } else {
      const size_t k = i - images.size();
      buffers[k] = {content.buffers[k], 0, VK_WHOLE_SIZE};
      write.pBufferInfo = &buffers[k];
    }
  }
  context_->vk.UpdateDescriptorSets(context_->device, static_cast<uint32_t>(writes.size()),
                                    writes.data(), 0, nullptr);
}

Status MakeSetLayout(const DeviceContext& context, const SetShape& shape, VkSampler sampler,
                     VkDescriptorSetLayout* out) {
  std::vector<VkDescriptorSetLayoutBinding> bindings(shape.count());
  // One layout with all stages, so that different pipelines can share sets.
  VkShaderStageFlags stages = VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT;
  if (context.ray_tracing.offered) {
    stages |= VK_SHADER_STAGE_RAYGEN_BIT_KHR | VK_SHADER_STAGE_ANY_HIT_BIT_KHR;
  }
  for (uint32_t i = 0; i < shape.count(); ++i) {
    const bool texture = i >= shape.count() - shape.textures;
    bindings[i] = {i, TypeOf(context, shape, i), 1, stages, texture ? &sampler : nullptr};
  }
  VkDescriptorSetLayoutCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  info.bindingCount = shape.count();
  info.pBindings = bindings.data();
  return ToStatus(context.vk.CreateDescriptorSetLayout(context.device, &info, nullptr, out),
                  "creating a descriptor layout");
}

Status MakePipelineLayout(const DeviceContext& context, std::span<const VkDescriptorSetLayout> sets,
                          VkShaderStageFlags push_stage, uint32_t push_bytes,
                          VkPipelineLayout* out) {
  const VkPushConstantRange push = {push_stage, 0, push_bytes};
  VkPipelineLayoutCreateInfo layout = {};
  layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  layout.setLayoutCount = static_cast<uint32_t>(sets.size());
  layout.pSetLayouts = sets.data();
  layout.pushConstantRangeCount = push_bytes > 0 ? 1 : 0;
  layout.pPushConstantRanges = &push;
  return ToStatus(context.vk.CreatePipelineLayout(context.device, &layout, nullptr, out),
                  "creating a pipeline layout");
}

Status MakeShaderModule(const DeviceContext& context, std::span<const uint32_t> code,
                        const char* action, VkShaderModule* out) {
  const Result<std::vector<uint32_t>> replacement = ReplacementOf(code);
  STILLRAY_RETURN_IF_ERROR(replacement.status());
  return MakeModule(context, replacement->empty() ? code : *replacement, action, out);
}

Status MakeComputePipeline(const DeviceContext& context, const PipelineInfo& info,
                           VkPipelineLayout layout, VkPipeline* out) {
  const std::string action = std::string("compiling the shader ") + info.name;
  VkShaderModule shader = VK_NULL_HANDLE;
  STILLRAY_RETURN_IF_ERROR(MakeModule(context, info.code, action.c_str(), &shader));
  std::vector<VkSpecializationMapEntry> entries;
  for (uint32_t i = 0; i < info.constants.size(); ++i) {
    entries.push_back({i, i * static_cast<uint32_t>(sizeof(uint32_t)), sizeof(uint32_t)});
  }
  const VkSpecializationInfo constants = {static_cast<uint32_t>(entries.size()), entries.data(),
                                          info.constants.size_bytes(), info.constants.data()};
  VkComputePipelineCreateInfo create = {};
  create.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  create.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  create.stage.module = shader;
  create.stage.pName = "main";
  create.stage.pSpecializationInfo = &constants;
  create.layout = layout;
  create.flags = StatisticsFlags(context);
  const VkResult result = context.vk.CreateComputePipelines(context.device, context.pipeline_cache,
                                                            1, &create, nullptr, out);
  context.vk.DestroyShaderModule(context.device, shader, nullptr);
  PrintStatistics(context, info.name, info.constants, *out);
  return ToStatus(result, action.c_str());
}

Result<Pipeline> Pipeline::Create(const DeviceContext* context, const PipelineInfo& info) {
  return context->pipelines->Find(info);
}

}  // namespace stillray::gpu

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/ray_pipeline.h"

#include <cstring>
#include <string>
#include <vector>

#include "gpu/pipeline.h"
#include "gpu/pipeline_statistics.h"

namespace stillray::gpu {
namespace {

/// Shader groups of a pipeline, with one record each in the shader binding table.
enum Group : uint32_t { kGeneration, kMiss, kHit, kGroupCount };

/// Owns the shader modules of a pipeline's stages.
class Stages {
 public:
  Stages(const DeviceContext* context, std::span<const uint32_t> constants) : context_(context) {
    for (uint32_t i = 0; i < constants.size(); ++i) {
      entries_.push_back({i, i * static_cast<uint32_t>(sizeof(uint32_t)), sizeof(uint32_t)});
    }
    constants_ = {static_cast<uint32_t>(entries_.size()), entries_.data(), constants.size_bytes(),
                  constants.data()};
  }
  Stages(const Stages&) = delete;
  Stages& operator=(const Stages&) = delete;
  ~Stages() {
    for (const VkPipelineShaderStageCreateInfo& stage : list_) {
      context_->vk.DestroyShaderModule(context_->device, stage.module, nullptr);
    }
  }

  /// Sets `number` to the index of the stage, or to VK_SHADER_UNUSED_KHR if there is no code.
  Status Add(VkShaderStageFlagBits stage, std::span<const uint32_t> code, const char* action,
             uint32_t* number) {
    *number = VK_SHADER_UNUSED_KHR;
    if (code.empty()) {
      return Status::Ok();
    }
    VkPipelineShaderStageCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage = stage;
    info.pName = "main";
    info.pSpecializationInfo = &constants_;
    STILLRAY_RETURN_IF_ERROR(MakeShaderModule(*context_, code, action, &info.module));
    *number = static_cast<uint32_t>(list_.size());
    list_.push_back(info);
    return Status::Ok();
  }

  const std::vector<VkPipelineShaderStageCreateInfo>& list() const { return list_; }

 private:
  const DeviceContext* context_;
  std::vector<VkSpecializationMapEntry> entries_;
  VkSpecializationInfo constants_ = {};
  std::vector<VkPipelineShaderStageCreateInfo> list_;
};

VkRayTracingShaderGroupCreateInfoKHR EmptyGroup(VkRayTracingShaderGroupTypeKHR type) {
  VkRayTracingShaderGroupCreateInfoKHR group = {};
  group.sType = VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR;
  group.type = type;
  group.generalShader = VK_SHADER_UNUSED_KHR;
  group.closestHitShader = VK_SHADER_UNUSED_KHR;
  group.anyHitShader = VK_SHADER_UNUSED_KHR;
  group.intersectionShader = VK_SHADER_UNUSED_KHR;
  return group;
}

}  // namespace

Status RayPipeline::MakePipeline(const RayPipelineInfo& info) {
  const DeviceContext& c = device_->context();
  STILLRAY_RETURN_IF_ERROR(
      MakePipelineLayout(c, info.sets, VK_SHADER_STAGE_RAYGEN_BIT_KHR, info.push_bytes, &layout_));
  const std::string action = std::string("compiling the ray tracing shaders of ") + info.name;
  Stages stages(&c, info.constants);
  VkRayTracingShaderGroupCreateInfoKHR groups[kGroupCount] = {
      EmptyGroup(VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR),
      EmptyGroup(VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR),
      EmptyGroup(VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR)};
  STILLRAY_RETURN_IF_ERROR(stages.Add(VK_SHADER_STAGE_RAYGEN_BIT_KHR, info.generation,
                                      action.c_str(), &groups[kGeneration].generalShader));
  STILLRAY_RETURN_IF_ERROR(stages.Add(VK_SHADER_STAGE_MISS_BIT_KHR, info.miss, action.c_str(),
                                      &groups[kMiss].generalShader));
  STILLRAY_RETURN_IF_ERROR(stages.Add(VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, info.closest_hit,
                                      action.c_str(), &groups[kHit].closestHitShader));
  STILLRAY_RETURN_IF_ERROR(stages.Add(VK_SHADER_STAGE_ANY_HIT_BIT_KHR, info.any_hit, action.c_str(),
                                      &groups[kHit].anyHitShader));
  VkRayTracingPipelineCreateInfoKHR create = {};
  create.sType = VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR;
  create.stageCount = static_cast<uint32_t>(stages.list().size());
  create.pStages = stages.list().data();
  create.groupCount = kGroupCount;
  create.pGroups = groups;
  create.maxPipelineRayRecursionDepth = 1;
  create.layout = layout_;
  create.flags = StatisticsFlags(c);
  const VkResult result = c.vk.CreateRayTracingPipelinesKHR(
      c.device, VK_NULL_HANDLE, c.pipeline_cache, 1, &create, nullptr, &pipeline_);
  PrintStatistics(c, info.name, info.constants, pipeline_);
  return ToStatus(result, action.c_str());
}

/// Creates the shader binding table in device memory: one record per group.
Status RayPipeline::MakeTable(const char* name) {
  const DeviceContext& c = device_->context();
  const VkDeviceSize stride = c.ray_tracing.record_stride;
  const size_t handle = c.ray_tracing.handle_size;
  // Extra space for the alignment of the first record.
  const Result<const Buffer*> buffer = arena_.AddBuffer(
      (kGroupCount + 1) * stride,
      VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
      BufferPlace::kDevice);
  STILLRAY_RETURN_IF_ERROR(buffer.status());
  STILLRAY_RETURN_IF_ERROR(arena_.Allocate());
  std::vector<char> handles(kGroupCount * handle);
  const std::string action = std::string("reading the ray tracing shaders of ") + name;
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(c.vk.GetRayTracingShaderGroupHandlesKHR(c.device, pipeline_, 0, kGroupCount,
                                                       handles.size(), handles.data()),
               action.c_str()));
  std::vector<char> table(kGroupCount * stride);
  for (size_t i = 0; i < kGroupCount; ++i) {
    std::memcpy(table.data() + i * stride, handles.data() + i * handle, handle);
  }
  const VkDeviceAddress first = ((*buffer)->address + stride - 1) / stride * stride;
  const FairLock lock = device_->Lock();
  const Result<VkCommandBuffer> commands = device_->Begin();
  STILLRAY_RETURN_IF_ERROR(commands.status());
  c.vk.CmdUpdateBuffer(*commands, (*buffer)->buffer, first - (*buffer)->address, table.size(),
                       table.data());
  MemoryBarrier(c, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                VK_PIPELINE_STAGE_RAY_TRACING_SHADER_BIT_KHR, VK_ACCESS_SHADER_READ_BIT);
  STILLRAY_RETURN_IF_ERROR(device_->Run());
  generation_ = {first + kGeneration * stride, stride, stride};
  miss_ = {first + kMiss * stride, stride, stride};
  hit_ = {first + kHit * stride, stride, stride};
  return Status::Ok();
}

Result<std::unique_ptr<RayPipeline>> RayPipeline::Create(Device* device,
                                                         const RayPipelineInfo& info) {
  std::unique_ptr<RayPipeline> made(new RayPipeline(device));
  STILLRAY_RETURN_IF_ERROR(made->MakePipeline(info));
  STILLRAY_RETURN_IF_ERROR(made->MakeTable(info.name));
  return made;
}

RayPipeline::~RayPipeline() {
  const DeviceContext& c = device_->context();
  c.vk.DestroyPipeline(c.device, pipeline_, nullptr);
  c.vk.DestroyPipelineLayout(c.device, layout_, nullptr);
}

void RayPipeline::Bind(VkCommandBuffer commands, std::span<const VkDescriptorSet> sets,
                       const void* push, uint32_t push_bytes) const {
  const DeviceFunctions& vk = device_->context().vk;
  vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, pipeline_);
  vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, layout_, 0,
                           static_cast<uint32_t>(sets.size()), sets.data(), 0, nullptr);
  vk.CmdPushConstants(commands, layout_, VK_SHADER_STAGE_RAYGEN_BIT_KHR, 0, push_bytes, push);
}

void RayPipeline::Trace(VkCommandBuffer commands, uint32_t count) const {
  device_->context().vk.CmdTraceRaysKHR(commands, &generation_, &miss_, &hit_, &callable_, count, 1,
                                        1);
}

void RayPipeline::TraceIndirect(VkCommandBuffer commands, VkDeviceAddress count) const {
  device_->context().vk.CmdTraceRaysIndirectKHR(commands, &generation_, &miss_, &hit_, &callable_,
                                                count);
}

}  // namespace stillray::gpu

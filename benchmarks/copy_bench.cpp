// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "benchmarks/copy_bench.h"

#include <algorithm>

namespace stillray::vulkan {
namespace shaders {
extern const std::uint32_t kCopy[];
extern const std::size_t kCopyWords;
}  // namespace shaders

namespace {

constexpr gpu::SetShape kShape = {0, 0, 0, 2};
constexpr VkDeviceSize kTexel = 16;
constexpr VkDeviceSize kLargestPart = VkDeviceSize{1} << 30;
constexpr uint32_t kGroupSize = 128;
constexpr uint32_t kMostGroupsX = 32768;
constexpr const char* kTransfer = "transfer";
constexpr const char* kCompute = "compute";

}  // namespace

Status CopyBench::AddParts(VkDeviceSize bytes) {
  const VkDeviceSize most =
      std::min<VkDeviceSize>(context_->limits.maxStorageBufferRange, kLargestPart) / kTexel *
      kTexel;
  const auto add = [&](VkDeviceSize size, const gpu::Buffer** buffer) {
    const Result<const gpu::Buffer*> added =
        arena_.AddBuffer(size, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::BufferPlace::kDevice);
    STILLRAY_RETURN_IF_ERROR(added.status());
    *buffer = *added;
    return Status::Ok();
  };
  for (VkDeviceSize left = bytes / kTexel * kTexel; left > 0;) {
    const VkDeviceSize size = std::min(left, most);
    Part part;
    STILLRAY_RETURN_IF_ERROR(add(size, &part.from));
    STILLRAY_RETURN_IF_ERROR(add(size, &part.to));
    parts_.push_back(part);
    left -= size;
  }
  return arena_.Allocate();
}

Status CopyBench::MakePipeline() {
  const auto count = static_cast<uint32_t>(parts_.size());
  STILLRAY_RETURN_IF_ERROR(sets_.CreatePool(count, {0, 0, 0, 2 * count}));
  const Result<VkDescriptorSetLayout> layout = sets_.Layout(kShape);
  STILLRAY_RETURN_IF_ERROR(layout.status());
  for (Part& part : parts_) {
    const Result<VkDescriptorSet> set =
        sets_.Find(kShape, {{}, {}, {part.from->buffer, part.to->buffer}});
    STILLRAY_RETURN_IF_ERROR(set.status());
    part.set = *set;
  }
  const std::span<const uint32_t> code(shaders::kCopy, shaders::kCopyWords);
  Result<gpu::Pipeline> made =
      gpu::Pipeline::Create(context_, {"copy", code, {&*layout, 1}, sizeof(uint32_t), {}});
  STILLRAY_RETURN_IF_ERROR(made.status());
  pipeline_ = std::move(*made);
  return Status::Ok();
}

Status CopyBench::Create(uint64_t bytes) {
  STILLRAY_RETURN_IF_ERROR(AddParts(std::max<VkDeviceSize>(bytes / 2, kTexel)));
  STILLRAY_RETURN_IF_ERROR(MakePipeline());
  return times_.Create(3);
}

void CopyBench::RecordCompute(VkCommandBuffer commands, const Part& part) const {
  const auto texels = static_cast<uint32_t>(part.from->size / kTexel);
  const uint32_t groups = (texels + kGroupSize - 1) / kGroupSize;
  const uint32_t x = std::min(groups, kMostGroupsX);
  const gpu::DeviceFunctions& vk = context_->vk;
  vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.layout(), 0, 1,
                           &part.set, 0, nullptr);
  vk.CmdPushConstants(commands, pipeline_.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(texels),
                      &texels);
  vk.CmdDispatch(commands, x, (groups + x - 1) / x, 1);
}

void CopyBench::Record(VkCommandBuffer commands, int count) {
  constexpr VkPipelineStageFlags kTransferStage = VK_PIPELINE_STAGE_TRANSFER_BIT;
  constexpr VkPipelineStageFlags kComputeStage = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
  const gpu::DeviceFunctions& vk = context_->vk;
  count_ = count;
  times_.Begin(commands);
  times_.Mark(commands, kTransfer);
  for (int i = 0; i < count; ++i) {
    for (const Part& part : parts_) {
      const VkBufferCopy region = {0, 0, part.from->size};
      vk.CmdCopyBuffer(commands, part.from->buffer, part.to->buffer, 1, &region);
    }
    const bool last = i + 1 == count;
    gpu::MemoryBarrier(*context_, commands, kTransferStage, VK_ACCESS_TRANSFER_WRITE_BIT,
                       last ? kComputeStage : kTransferStage,
                       last ? VK_ACCESS_SHADER_WRITE_BIT : VK_ACCESS_TRANSFER_WRITE_BIT);
  }
  times_.Mark(commands, kCompute);
  vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.handle());
  for (int i = 0; i < count; ++i) {
    for (const Part& part : parts_) {
      RecordCompute(commands, part);
    }
    const bool last = i + 1 == count;
    gpu::MemoryBarrier(*context_, commands, kComputeStage, VK_ACCESS_SHADER_WRITE_BIT,
                       last ? kTransferStage : kComputeStage,
                       last ? VK_ACCESS_TRANSFER_WRITE_BIT : VK_ACCESS_SHADER_WRITE_BIT);
  }
  times_.End(commands);
}

CopyTimes CopyBench::Read() const {
  CopyTimes result;
  for (const gpu::DeviceTime& time : times_.Read()) {
    (time.name == kTransfer ? result.transfer : result.compute) = time.milliseconds / count_;
  }
  return result;
}

}  // namespace stillray::vulkan

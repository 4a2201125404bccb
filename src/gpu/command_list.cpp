// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/command_list.h"

#include <string>
#include <utility>

namespace stillray::gpu {

CommandList::Bytes CommandList::Keep(std::span<const std::byte> bytes) {
  const Bytes kept = {bytes_.size(), static_cast<uint32_t>(bytes.size())};
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  return kept;
}

void CommandList::Dispatch(const DispatchCommand& command, std::span<const std::byte> push) {
  entries_.emplace_back(DispatchEntry{command, Keep(push)});
}

void CommandList::Barrier(VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
                          VkAccessFlags used) {
  entries_.emplace_back(BarrierEntry{from, written, to, used});
}

void CommandList::Fill(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size, uint32_t value) {
  entries_.emplace_back(FillEntry{buffer, offset, size, value});
}

void CommandList::Update(VkBuffer buffer, VkDeviceSize offset, std::span<const std::byte> bytes) {
  entries_.emplace_back(UpdateEntry{buffer, offset, Keep(bytes)});
}

void CommandList::BeginTimes(Timestamps* times, uint32_t frame) {
  entries_.emplace_back(TimesEntry{times, frame});
}

void CommandList::BeginPart(std::string_view name, Timestamps* times) {
  entries_.emplace_back(PartEntry{name, times});
}

void CommandList::Call(std::function<void(VkCommandBuffer)> call) {
  entries_.emplace_back(CallEntry{std::move(call)});
}

void CommandList::Record(VkCommandBuffer commands) {
  in_label_ = false;
  for (const Entry& entry : entries_) {
    std::visit([&](const auto& e) { Emit(commands, e); }, entry);
  }
  Emit(commands, PartEntry{{}, nullptr});
  Clear();
}

void CommandList::Clear() {
  entries_.clear();
  bytes_.clear();
}

void CommandList::Emit(VkCommandBuffer commands, const DispatchEntry& entry) const {
  const DeviceFunctions& vk = context_->vk;
  const DispatchCommand& c = entry.command;
  vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, c.pipeline);
  vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, c.layout, 0, c.set_count,
                           c.sets.data(), 0, nullptr);
  if (entry.push.size > 0) {
    vk.CmdPushConstants(commands, c.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, entry.push.size,
                        bytes_.data() + entry.push.offset);
  }
  vk.CmdDispatch(commands, c.x, c.y, 1);
}

void CommandList::Emit(VkCommandBuffer commands, const BarrierEntry& entry) const {
  MemoryBarrier(*context_, commands, entry.from, entry.written, entry.to, entry.used);
}

void CommandList::Emit(VkCommandBuffer commands, const FillEntry& entry) const {
  context_->vk.CmdFillBuffer(commands, entry.buffer, entry.offset, entry.size, entry.value);
}

void CommandList::Emit(VkCommandBuffer commands, const UpdateEntry& entry) const {
  context_->vk.CmdUpdateBuffer(commands, entry.buffer, entry.offset, entry.bytes.size,
                               bytes_.data() + entry.bytes.offset);
}

void CommandList::Emit(VkCommandBuffer commands, const TimesEntry& entry) const {
  entry.times->Begin(commands, entry.frame);
}

void CommandList::Emit(VkCommandBuffer commands, const PartEntry& entry) {
  if (entry.times != nullptr) {
    entry.times->Mark(commands, entry.name);
  }
  if (!labels_) {
    return;
  }
  if (in_label_) {
    context_->vk.CmdEndDebugUtilsLabelEXT(commands);
  }
  in_label_ = !entry.name.empty();
  if (in_label_) {
    const std::string text = "stillray: " + std::string(entry.name);
    VkDebugUtilsLabelEXT label = {};
    label.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT;
    label.pLabelName = text.c_str();
    context_->vk.CmdBeginDebugUtilsLabelEXT(commands, &label);
  }
}

void CommandList::Emit(VkCommandBuffer commands, const CallEntry& entry) const {
  entry.call(commands);
}

}  // namespace stillray::gpu

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/timestamps.h"

#include <algorithm>

namespace stillray::gpu {

uint64_t TicksBetween(uint64_t begin, uint64_t end, uint32_t bits) {
  return (end - begin) & (bits < 64 ? (uint64_t{1} << bits) - 1 : ~uint64_t{0});
}

Timestamps::~Timestamps() {
  if (pool_ != VK_NULL_HANDLE) {
    context_->vk.DestroyQueryPool(context_->device, pool_, nullptr);
  }
}

Status Timestamps::Create(uint32_t most_marks, uint32_t frames) {
  VkQueryPoolCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = most_marks * frames;
  most_ = most_marks;
  names_.resize(frames);
  for (Names& names : names_) {
    names.reserve(most_marks);
  }
  return ToStatus(context_->vk.CreateQueryPool(context_->device, &info, nullptr, &pool_),
                  "creating a query pool");
}

void Timestamps::Begin(VkCommandBuffer commands, uint32_t number) {
  if (pool_ == VK_NULL_HANDLE) {
    return;
  }
  frame_ = number % names_.size();
  names_[frame_].clear();
  context_->vk.CmdResetQueryPool(commands, pool_, static_cast<uint32_t>(frame_) * most_, most_);
}

void Timestamps::Mark(VkCommandBuffer commands, std::string_view name) {
  if (pool_ == VK_NULL_HANDLE || names_[frame_].size() >= most_) {
    return;
  }
  const auto first = static_cast<uint32_t>(frame_) * most_;
  context_->vk.CmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool_,
                                 first + static_cast<uint32_t>(names_[frame_].size()));
  names_[frame_].push_back(name);
  if (context_->is_software) {
    // After the first draw on a device, Mesa's llvmpipe writes timestamps only when its rasteriser
    // runs next, after the part begun by the mark. A barrier makes it run immediately.
    context_->vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT,
                                    VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, 0, 0, nullptr, 0, nullptr, 0,
                                    nullptr);
  }
}

std::vector<DeviceTime> Timestamps::Read() const {
  const size_t frames = names_.size();
  for (size_t age = 0; age < frames; ++age) {
    std::vector<DeviceTime> times = ReadFrame((frame_ + frames - age) % frames);
    if (!times.empty()) {
      return times;
    }
  }
  return {};
}

/// Durations of a frame; empty unless the device has finished the frame.
std::vector<DeviceTime> Timestamps::ReadFrame(size_t frame) const {
  const Names& names = names_[frame];
  std::vector<DeviceTime> times;
  if (names.size() < 2) {
    return times;
  }
  std::vector<uint64_t> ticks(names.size());
  const VkResult result = context_->vk.GetQueryPoolResults(
      context_->device, pool_, static_cast<uint32_t>(frame) * most_,
      static_cast<uint32_t>(names.size()), ticks.size() * sizeof(uint64_t), ticks.data(),
      sizeof(uint64_t), VK_QUERY_RESULT_64_BIT);
  if (result != VK_SUCCESS) {
    return times;
  }
  const double per_tick = static_cast<double>(context_->limits.timestampPeriod) * 1e-6;
  for (size_t i = 0; i + 1 < names.size(); ++i) {
    if (names[i].empty()) {
      continue;
    }
    const double ms =
        static_cast<double>(TicksBetween(ticks[i], ticks[i + 1], context_->timestamp_bits)) *
        per_tick;
    const auto at = std::find_if(times.begin(), times.end(),
                                 [&](const DeviceTime& t) { return t.name == names[i]; });
    if (at == times.end()) {
      times.push_back({names[i], ms});
    } else {
      at->milliseconds += ms;
    }
  }
  return times;
}

}  // namespace stillray::gpu

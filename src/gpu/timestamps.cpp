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

Status Timestamps::Create(uint32_t most_marks) {
  VkQueryPoolCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = most_marks;
  most_ = most_marks;
  names_.reserve(most_marks);
  return ToStatus(context_->vk.CreateQueryPool(context_->device, &info, nullptr, &pool_),
                  "creating a query pool");
}

void Timestamps::Begin(VkCommandBuffer commands) {
  names_.clear();
  if (pool_ != VK_NULL_HANDLE) {
    context_->vk.CmdResetQueryPool(commands, pool_, 0, most_);
  }
}

void Timestamps::Mark(VkCommandBuffer commands, std::string_view name) {
  if (pool_ == VK_NULL_HANDLE || names_.size() >= most_) {
    return;
  }
  context_->vk.CmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool_,
                                 static_cast<uint32_t>(names_.size()));
  names_.push_back(name);
}

std::vector<DeviceTime> Timestamps::Read() const {
  std::vector<DeviceTime> times;
  if (names_.size() < 2) {
    return times;
  }
  std::vector<uint64_t> ticks(names_.size());
  const VkResult result = context_->vk.GetQueryPoolResults(
      context_->device, pool_, 0, static_cast<uint32_t>(names_.size()),
      ticks.size() * sizeof(uint64_t), ticks.data(), sizeof(uint64_t), VK_QUERY_RESULT_64_BIT);
  if (result != VK_SUCCESS) {
    return times;
  }
  const double per_tick = static_cast<double>(context_->limits.timestampPeriod) * 1e-6;
  for (size_t i = 0; i + 1 < names_.size(); ++i) {
    if (names_[i].empty()) {
      continue;
    }
    const double ms =
        static_cast<double>(TicksBetween(ticks[i], ticks[i + 1], context_->timestamp_bits)) *
        per_tick;
    const auto at = std::find_if(times.begin(), times.end(),
                                 [&](const DeviceTime& t) { return t.name == names_[i]; });
    if (at == times.end()) {
      times.push_back({names_[i], ms});
    } else {
      at->milliseconds += ms;
    }
  }
  return times;
}

}  // namespace stillray::gpu

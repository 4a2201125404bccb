// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Times of named parts of a command buffer, from timestamp queries.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "gpu/device.h"

namespace stillray::gpu {

struct DeviceTime {
  std::string_view name;  ///< of static storage
  double milliseconds = 0;
};

/// Ticks from one timestamp to a later one. Counters with fewer bits than 64 begin again at zero,
/// some every hour; the difference is right unless they did so twice. \param bits  that are valid:
/// VkQueueFamilyProperties::timestampValidBits
uint64_t TicksBetween(uint64_t begin, uint64_t end, uint32_t bits);

/// Every Mark takes a time; the part between two marks has the name of the earlier one.
class Timestamps {
 public:
  explicit Timestamps(const DeviceContext* context) : context_(context) {}
  Timestamps(const Timestamps&) = delete;
  Timestamps& operator=(const Timestamps&) = delete;
  ~Timestamps();

  Status Create(uint32_t most_marks);
  /// Resets all marks; record it before the first one.
  void Begin(VkCommandBuffer commands);
  /// Begins a part. Marks beyond the maximum are not measured.
  void Mark(VkCommandBuffer commands, std::string_view name);
  /// Ends the last part.
  void End(VkCommandBuffer commands) { Mark(commands, {}); }
  /// The sums of all parts with the same name, in the order of their first marks.
  /// \return empty until the device has finished
  std::vector<DeviceTime> Read() const;

 private:
  const DeviceContext* context_;
  VkQueryPool pool_ = VK_NULL_HANDLE;
  uint32_t most_ = 0;
  std::vector<std::string_view> names_;
};

}  // namespace stillray::gpu

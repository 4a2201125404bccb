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

/// Every Mark takes a time; the part between two marks has the name of the earlier one. Frames that
/// the device has not finished keep their times while others are recorded.
class Timestamps {
 public:
  explicit Timestamps(const DeviceContext* context) : context_(context) {}
  Timestamps(const Timestamps&) = delete;
  Timestamps& operator=(const Timestamps&) = delete;
  ~Timestamps();

  /// \param most_marks  of a frame
  /// \param frames      that keep their times, at least 1
  Status Create(uint32_t most_marks, uint32_t frames = 1);
  /// Resets the marks of a frame; record it before its first one. \param number  of the frame; the
  ///     device has finished the frame that is `frames` frames older
  void Begin(VkCommandBuffer commands, uint32_t number = 0);
  /// Begins a part of that frame; outside render passes. Marks beyond the maximum are not measured.
  void Mark(VkCommandBuffer commands, std::string_view name);
  /// Ends the last part.
  void End(VkCommandBuffer commands) { Mark(commands, {}); }
  /// Of the newest frame that the device has finished: the sums of all parts with the same name, in
  /// the order of their first marks.
  /// \return empty if there is none
  std::vector<DeviceTime> Read() const;

 private:
  using Names = std::vector<std::string_view>;
  std::vector<DeviceTime> ReadFrame(size_t frame) const;

  const DeviceContext* context_;
  VkQueryPool pool_ = VK_NULL_HANDLE;
  uint32_t most_ = 0;
  std::vector<Names> names_;  ///< by frame
  size_t frame_ = 0;          ///< that of the last Begin
};

}  // namespace stillray::gpu

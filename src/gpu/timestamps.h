// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Durations of named parts of a command buffer, from timestamp queries.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "gpu/device.h"

namespace stillray::gpu {

struct DeviceTime {
  std::string_view name;  ///< static string
  double milliseconds = 0;
};

/// Ticks between two timestamps. Counters with fewer than 64 bits wrap around, some every hour; the
/// difference is correct for at most one wrap. \param bits valid bits:
/// VkQueueFamilyProperties::timestampValidBits
uint64_t TicksBetween(uint64_t begin, uint64_t end, uint32_t bits);

/// Each Mark writes a timestamp; the part between two marks has the name of the earlier mark.
/// Timestamps of unfinished frames are kept while later frames are recorded.
class Timestamps {
 public:
  explicit Timestamps(const DeviceContext* context) : context_(context) {}
  Timestamps(const Timestamps&) = delete;
  Timestamps& operator=(const Timestamps&) = delete;
  ~Timestamps();

  /// \param most_marks  maximum marks per frame
  /// \param frames      number of frames whose timestamps are kept, at least 1
  Status Create(uint32_t most_marks, uint32_t frames = 1);
  /// Resets the marks of a frame; record it before the first mark. \param number index of the
  /// frame; the device must have finished the frame `frames` frames earlier
  void Begin(VkCommandBuffer commands, uint32_t number = 0);
  /// Begins a part of the current frame; call outside render passes. Marks beyond the maximum are
  /// not measured.
  void Mark(VkCommandBuffer commands, std::string_view name);
  /// Ends the last part.
  void End(VkCommandBuffer commands) { Mark(commands, {}); }
  /// Durations of the latest finished frame: the sums over parts of equal name, in the order of
  /// their first marks.
  /// \return empty without a finished frame
  std::vector<DeviceTime> Read() const;

 private:
  using Names = std::vector<std::string_view>;
  std::vector<DeviceTime> ReadFrame(size_t frame) const;

  const DeviceContext* context_;
  VkQueryPool pool_ = VK_NULL_HANDLE;
  uint32_t most_ = 0;
  std::vector<Names> names_;  ///< per frame in flight
  size_t frame_ = 0;          ///< frame of the last Begin
};

}  // namespace stillray::gpu

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Commands that are collected first and recorded at once: if the creation of a descriptor set or
/// pipeline fails during a frame, the command buffer is unchanged.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "gpu/device.h"
#include "gpu/timestamps.h"

namespace stillray::gpu {

/// A dispatch with its pipeline and descriptor sets.
struct DispatchCommand {
  static constexpr size_t kMostSets = 2;

  VkPipeline pipeline = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  std::array<VkDescriptorSet, kMostSets> sets = {};
  uint32_t set_count = 0;
  uint32_t x = 1;  ///< workgroup counts
  uint32_t y = 1;
};

/// Keeps its memory between frames, so that recording a frame of constant length does not allocate.
class CommandList {
 public:
  /// \param labels  emit debug labels around the parts; requires the functions of
  ///     VK_EXT_debug_utils
  explicit CommandList(const DeviceContext* context, bool labels = false)
      : context_(context), labels_(labels) {}
  CommandList(const CommandList&) = delete;
  CommandList& operator=(const CommandList&) = delete;

  /// \param push  push constants; copied
  void Dispatch(const DispatchCommand& command, std::span<const std::byte> push);
  /// See MemoryBarrier.
  void Barrier(VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
               VkAccessFlags used);
  void Fill(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size, uint32_t value);
  /// \param bytes  copied; at most 65536, a multiple of 4
  void Update(VkBuffer buffer, VkDeviceSize offset, std::span<const std::byte> bytes);
  /// Resets the timestamps of a frame; see Timestamps::Begin.
  void BeginTimes(Timestamps* times, uint32_t frame);
  /// Ends the current part, and begins a new one. \param name static string; empty: begins no part
  /// \param times  measures the part; nullptr: not measured
  void BeginPart(std::string_view name, Timestamps* times);
  /// Adds a callback that records other commands; called when the list is recorded.
  void Call(std::function<void(VkCommandBuffer)> call);

  /// Records all commands in order, and clears the list.
  void Record(VkCommandBuffer commands);
  void Clear();

 private:
  struct Bytes {
    size_t offset = 0;  ///< in bytes_
    uint32_t size = 0;
  };
  struct DispatchEntry {
    DispatchCommand command;
    Bytes push;
  };
  struct BarrierEntry {
    VkPipelineStageFlags from;
    VkAccessFlags written;
    VkPipelineStageFlags to;
    VkAccessFlags used;
  };
  struct FillEntry {
    VkBuffer buffer;
    VkDeviceSize offset;
    VkDeviceSize size;
    uint32_t value;
  };
  struct UpdateEntry {
    VkBuffer buffer;
    VkDeviceSize offset;
    Bytes bytes;
  };
  struct TimesEntry {
    Timestamps* times;
    uint32_t frame;
  };
  struct PartEntry {
    std::string_view name;
    Timestamps* times;
  };
  struct CallEntry {
    std::function<void(VkCommandBuffer)> call;
  };
  using Entry = std::variant<DispatchEntry, BarrierEntry, FillEntry, UpdateEntry, TimesEntry,
                             PartEntry, CallEntry>;

  Bytes Keep(std::span<const std::byte> bytes);
  void Emit(VkCommandBuffer commands, const DispatchEntry& entry) const;
  void Emit(VkCommandBuffer commands, const BarrierEntry& entry) const;
  void Emit(VkCommandBuffer commands, const FillEntry& entry) const;
  void Emit(VkCommandBuffer commands, const UpdateEntry& entry) const;
  void Emit(VkCommandBuffer commands, const TimesEntry& entry) const;
  void Emit(VkCommandBuffer commands, const PartEntry& entry);
  void Emit(VkCommandBuffer commands, const CallEntry& entry) const;

  const DeviceContext* context_;
  bool labels_;
  bool in_label_ = false;  ///< whether a debug label is open during Record
  std::vector<Entry> entries_;
  std::vector<std::byte> bytes_;
};

}  // namespace stillray::gpu

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Counts the calls of a device that a test has for itself.
#pragma once

#include <utility>

#include "gpu/device.h"

namespace stillray::test {

struct CallCounts {
  int submissions = 0;
  int waits = 0;
  int dispatches = 0;  ///< direct and indirect
  int barriers = 0;    ///< of memory: Timestamps have others, on software drivers
};

/// One at a time. Rays traced by hardware are not counted.
class CountedCalls {
 public:
  explicit CountedCalls(gpu::Device* device) {
    auto& vk = const_cast<gpu::DeviceContext&>(device->context()).vk;
    real_ = vk;
    counts_ = {};
    vk.QueueSubmit = &Submit;
    vk.WaitForFences = &Wait;
    vk.CmdDispatch = &Dispatch;
    vk.CmdDispatchIndirect = &DispatchIndirect;
    vk.CmdPipelineBarrier = &Barrier;
  }

  /// Since the last call of this.
  static CallCounts Take() { return std::exchange(counts_, {}); }

 private:
  static VKAPI_ATTR VkResult VKAPI_CALL Submit(VkQueue q, uint32_t n, const VkSubmitInfo* s,
                                               VkFence f) {
    ++counts_.submissions;
    return real_.QueueSubmit(q, n, s, f);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL Wait(VkDevice d, uint32_t n, const VkFence* f, VkBool32 all,
                                             uint64_t ns) {
    ++counts_.waits;
    return real_.WaitForFences(d, n, f, all, ns);
  }
  static VKAPI_ATTR void VKAPI_CALL Dispatch(VkCommandBuffer c, uint32_t x, uint32_t y,
                                             uint32_t z) {
    ++counts_.dispatches;
    real_.CmdDispatch(c, x, y, z);
  }
  static VKAPI_ATTR void VKAPI_CALL DispatchIndirect(VkCommandBuffer c, VkBuffer buffer,
                                                     VkDeviceSize offset) {
    ++counts_.dispatches;
    real_.CmdDispatchIndirect(c, buffer, offset);
  }
  static VKAPI_ATTR void VKAPI_CALL Barrier(VkCommandBuffer c, VkPipelineStageFlags from,
                                            VkPipelineStageFlags to, VkDependencyFlags flags,
                                            uint32_t memory_count, const VkMemoryBarrier* memory,
                                            uint32_t buffer_count,
                                            const VkBufferMemoryBarrier* buffers,
                                            uint32_t image_count,
                                            const VkImageMemoryBarrier* images) {
    counts_.barriers += memory_count + buffer_count + image_count > 0 ? 1 : 0;
    real_.CmdPipelineBarrier(c, from, to, flags, memory_count, memory, buffer_count, buffers,
                             image_count, images);
  }

  inline static gpu::DeviceFunctions real_;
  inline static CallCounts counts_;
};

}  // namespace stillray::test

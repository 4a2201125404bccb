// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Measures copies between device buffers by the driver and by a compute shader.
#pragma once

#include <vector>

#include "gpu/pipeline.h"
#include "gpu/timestamps.h"

namespace stillray::vulkan {

/// Milliseconds of one copy.
struct CopyTimes {
  double transfer = 0;  ///< vkCmdCopyBuffer
  double compute = 0;   ///< copy.comp
};

class CopyBench {
 public:
  explicit CopyBench(const gpu::DeviceContext* context)
      : context_(context), arena_(context), sets_(context), times_(context) {}

  /// \param bytes  total bytes read and written by one copy
  Status Create(uint64_t bytes);
  /// Records `count` copies of each kind, one after the other.
  void Record(VkCommandBuffer commands, int count);
  /// Means over the last recorded copies, which the device must have finished.
  CopyTimes Read() const;

 private:
  /// A part of a copy, which is split due to the size limit of storage buffers.
  struct Part {
    const gpu::Buffer* from = nullptr;
    const gpu::Buffer* to = nullptr;
    VkDescriptorSet set = VK_NULL_HANDLE;
  };
  Status AddParts(VkDeviceSize bytes);
  Status MakePipeline();
  void RecordCompute(VkCommandBuffer commands, const Part& part) const;

  const gpu::DeviceContext* context_;
  gpu::Arena arena_;
  gpu::DescriptorSets sets_;
  gpu::Pipeline pipeline_;
  gpu::Timestamps times_;
  std::vector<Part> parts_;
  int count_ = 1;
};

}  // namespace stillray::vulkan

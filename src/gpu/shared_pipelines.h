// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Compute pipelines and descriptor set layouts shared by all users of a device.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "gpu/pipeline.h"

namespace stillray::gpu {

/// Owned by Device, or by a denoiser on a caller's VkDevice. Pipelines and layouts live as long as
/// this object and outlive their users: compilation may take seconds, and the viewer destroys a
/// renderer before it creates the next one. Their number is bounded by the number of shaders and
/// specialisation constants. Thread-safe.
class SharedPipelines {
 public:
  /// \param context  must outlive this
  explicit SharedPipelines(const DeviceContext* context) : context_(context) {}
  SharedPipelines(const SharedPipelines&) = delete;
  SharedPipelines& operator=(const SharedPipelines&) = delete;
  /// No pending work of the device may use the pipelines.
  ~SharedPipelines();

  /// \return one handle per shape
  Result<VkDescriptorSetLayout> Layout(const SetShape& shape);
  /// Creates the pipeline unless one exists with equal code (after replacement by shader_folder.h),
  /// layout and constants. Concurrent calls for one pipeline wait for the compiling thread; calls
  /// for other pipelines do not wait. After a failure the next call compiles again.
  Result<Pipeline> Find(const PipelineInfo& info);

  /// Number of pipelines created so far.
  size_t created() const;

 private:
  struct Entry {
    std::vector<uint32_t> code;
    std::vector<VkDescriptorSetLayout> sets;
    uint32_t push_bytes = 0;
    std::vector<uint32_t> constants;
    std::mutex compiling;  ///< protects the pipeline
    Pipeline pipeline;
  };
  Entry* EntryOf(std::span<const uint32_t> code, const PipelineInfo& info);
  Status Compile(const char* name, Entry* entry);
  Status MakeSampler();

  const DeviceContext* context_;
  mutable std::mutex mutex_;  // protects the members below
  size_t created_ = 0;
  // Sampler of textures; created with the first layout that has textures.
  VkSampler sampler_ = VK_NULL_HANDLE;
  std::vector<std::pair<SetShape, VkDescriptorSetLayout>> layouts_;
  std::vector<std::unique_ptr<Entry>> entries_;
};

}  // namespace stillray::gpu

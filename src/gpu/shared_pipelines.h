// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Compute pipelines and layouts of descriptor sets that all users of a device share.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "gpu/pipeline.h"

namespace stillray::gpu {

/// Owned by Device, or by a denoiser that runs in a renderer's VkDevice. Pipelines and layouts live
/// as long as this object, not as long as their users: a driver may take seconds to compile, and
/// the viewer destroys a renderer before it creates the next one. Their number is limited by that
/// of the shaders and specialisation constants. Thread-safe.
class SharedPipelines {
 public:
  /// \param context  must outlive this
  explicit SharedPipelines(const DeviceContext* context) : context_(context) {}
  SharedPipelines(const SharedPipelines&) = delete;
  SharedPipelines& operator=(const SharedPipelines&) = delete;
  /// No work of the device may be using the pipelines.
  ~SharedPipelines();

  /// \return the same handle for the same shape
  Result<VkDescriptorSetLayout> Layout(const SetShape& shape);
  /// Creates the pipeline unless there is one of the same code (that of shader_folder.h, if it
  /// replaces the shader's), layout and constants. Calls for the same pipeline wait for the thread
  /// that compiles it; calls for others do not. After a failure the next call compiles again.
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
  mutable std::mutex mutex_;  // protects what follows
  size_t created_ = 0;
  VkSampler sampler_ = VK_NULL_HANDLE;  // of textures, once a layout has any
  std::vector<std::pair<SetShape, VkDescriptorSetLayout>> layouts_;
  std::vector<std::unique_ptr<Entry>> entries_;
};

}  // namespace stillray::gpu

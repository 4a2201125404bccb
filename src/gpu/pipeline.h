// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Compute pipelines and their descriptor sets.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/memory.h"

namespace stillray::gpu {

/// A descriptor set layout with consecutive bindings from 0: sampled images, storage images,
/// uniform buffers, storage buffers, acceleration structures, then textures (combined with the
/// sampler of SharedPipelines). A set may bind an image twice, for reading and for writing.
struct SetShape {
  uint32_t sampled = 0;
  uint32_t stored = 0;
  uint32_t uniforms = 0;
  uint32_t buffers = 0;
  uint32_t accelerations = 0;
  uint32_t textures = 0;

  uint32_t count() const {
    return sampled + stored + uniforms + buffers + accelerations + textures;
  }
  friend bool operator==(const SetShape&, const SetShape&) = default;
};

/// Number of storage buffers of a set on the device, including uniform buffers that are bound as
/// storage buffers (uniform_blocks.h).
uint32_t StorageBuffersOf(const DeviceContext& context, const SetShape& shape);

/// The resources bound by a descriptor set, in the order of its shape.
struct SetContent {
  std::vector<VkImageView> images;     ///< sampled images, then storage images
  std::vector<VkImageLayout> layouts;  ///< layout of each image; empty: all VK_IMAGE_LAYOUT_GENERAL
  std::vector<VkBuffer> buffers;       ///< uniform buffers, then storage buffers
  std::vector<VkAccelerationStructureKHR> accelerations = {};
  std::vector<VkImageView> textures = {};  ///< views in VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL

  friend bool operator==(const SetContent&, const SetContent&) = default;
};

/// Descriptor sets, cached by content: a set is written once and reused for equal content, so that
/// recording a frame allocates nothing once all sets exist. Sets whose content lives for a single
/// frame are rewritten every frame, from a ring of frames in flight.
class DescriptorSets {
 public:
  explicit DescriptorSets(const DeviceContext* context) : context_(context) {}
  DescriptorSets(const DescriptorSets&) = delete;
  DescriptorSets& operator=(const DescriptorSets&) = delete;
  ~DescriptorSets();

  /// Creates the first pool; more follow when it is exhausted.
  /// \param most  maximum number of sets per pool
  /// \param all   total number of descriptors per pool
  /// \param in_flight  maximum number of unfinished frames with per-frame content; 0: content
  ///     recurs in later frames
  Status CreatePool(uint32_t most, const SetShape& all, uint32_t in_flight = 0);
  /// The layout of a shape, shared by all users of the device.
  Result<VkDescriptorSetLayout> Layout(const SetShape& shape) const;
  /// Frees all sets, which must not be in use.
  Status Clear();
  Result<VkDescriptorSet> Find(const SetShape& shape, const SetContent& content);
  /// Begins a frame of FindForFrame. \param number index of the frame; the device must have
  /// finished the frame `in_flight` frames earlier
  void BeginFrame(uint32_t number);
  /// A set for a single use in the frame of BeginFrame; equivalent to Find if in_flight is 0.
  Result<VkDescriptorSet> FindForFrame(const SetShape& shape, const SetContent& content);
  /// Creates a pool with a single set, and the set, which contains only buffers.
  Result<VkDescriptorSet> CreateSingle(const SetShape& shape,
                                       std::span<const Buffer* const> buffers);

 private:
  struct Entry {
    SetShape shape;
    SetContent content;
    VkDescriptorSet set;
  };
  struct FrameEntry {
    SetShape shape;
    VkDescriptorSet set;
    bool used;  ///< whether used in the current frame
  };
  Status AddPool();
  Result<VkDescriptorSet> Allocate(const SetShape& shape);
  VkResult AllocateFromLast(VkDescriptorSetLayout layout, VkDescriptorSet* set) const;
  void Write(const SetShape& shape, const SetContent& content, VkDescriptorSet set) const;

  const DeviceContext* context_;
  uint32_t most_ = 0;
  uint32_t in_flight_ = 0;
  SetShape all_;
  std::vector<VkDescriptorPool> pools_;
  uint32_t taken_ = 0;  ///< sets allocated from the last pool
  std::vector<Entry> entries_;
  std::vector<std::vector<FrameEntry>> frames_;
  size_t frame_ = 0;
};

/// Creates a descriptor set layout, for all stages that use stillray's sets.
/// \param sampler  immutable sampler of the textures
Status MakeSetLayout(const DeviceContext& context, const SetShape& shape, VkSampler sampler,
                     VkDescriptorSetLayout* out);
/// Creates the layout of a compute, graphics or ray tracing pipeline.
/// \param push_stage  the stage that reads the `push_bytes` of push constants; ignored if
///     `push_bytes` is 0
Status MakePipelineLayout(const DeviceContext& context, std::span<const VkDescriptorSetLayout> sets,
                          VkShaderStageFlags push_stage, uint32_t push_bytes,
                          VkPipelineLayout* out);
/// \param code    SPIR-V of an embedded shader; shader_folder.h may replace it
/// \param action  for error messages: "compiling the shader atrous"
Status MakeShaderModule(const DeviceContext& context, std::span<const uint32_t> code,
                        const char* action, VkShaderModule* out);

/// A compute shader with its layout.
struct PipelineInfo {
  const char* name = "";                        ///< for error messages
  std::span<const uint32_t> code;               ///< SPIR-V
  std::span<const VkDescriptorSetLayout> sets;  ///< layouts from DescriptorSets::Layout
  uint32_t push_bytes = 0;
  std::span<const uint32_t> constants;  ///< specialisation constants 0, 1, ...
};

/// Compiles the code as given, without replacement from the shader folder.
Status MakeComputePipeline(const DeviceContext& context, const PipelineInfo& info,
                           VkPipelineLayout layout, VkPipeline* out);

/// A compute pipeline shared by all users of the device (shared_pipelines.h): valid as long as the
/// device, or as long as the denoiser on a caller's device.
class Pipeline {
 public:
  /// Returns the cached pipeline, or creates it.
  static Result<Pipeline> Create(const DeviceContext* context, const PipelineInfo& info);
  Pipeline() = default;
  Pipeline(VkPipeline pipeline, VkPipelineLayout layout) : pipeline_(pipeline), layout_(layout) {}

  VkPipeline handle() const { return pipeline_; }
  VkPipelineLayout layout() const { return layout_; }

 private:
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
};

}  // namespace stillray::gpu

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

/// A layout of descriptors: sampled images, then storage images, then uniform and storage buffers,
/// then acceleration structures, then textures (images with the sampler of SharedPipelines), with
/// consecutive bindings from 0. A set may bind an image twice,
/// for reading and for writing.
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

/// Storage buffers of a set on the device, which may have uniform ones as such (uniform_blocks.h).
uint32_t StorageBuffersOf(const DeviceContext& context, const SetShape& shape);

/// The resources bound by a descriptor set, in the order of its shape.
struct SetContent {
  std::vector<VkImageView> images;     ///< sampled ones, then storage ones
  std::vector<VkImageLayout> layouts;  ///< of each image; empty: VK_IMAGE_LAYOUT_GENERAL
  std::vector<VkBuffer> buffers;       ///< uniform ones, then storage ones
  std::vector<VkAccelerationStructureKHR> accelerations = {};
  std::vector<VkImageView> textures = {};  ///< in VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL

  friend bool operator==(const SetContent&, const SetContent&) = default;
};

/// Descriptor sets, cached by content: the same content is written once and reused, so that
/// recording a frame allocates nothing once all sets exist. Sets of content that lives for a frame
/// only are written anew for each frame, in turn.
class DescriptorSets {
 public:
  explicit DescriptorSets(const DeviceContext* context) : context_(context) {}
  DescriptorSets(const DescriptorSets&) = delete;
  DescriptorSets& operator=(const DescriptorSets&) = delete;
  ~DescriptorSets();

  /// Creates the first pool; more follow when it is exhausted.
  /// \param most  number of sets of a pool
  /// \param all   number of descriptors of all sets of a pool together
  /// \param in_flight  frames that the device may not have finished, each with content of its own;
  ///     0: the content of frames comes again
  Status CreatePool(uint32_t most, const SetShape& all, uint32_t in_flight = 0);
  /// The device's own layout: all users of the device share it.
  Result<VkDescriptorSetLayout> Layout(const SetShape& shape) const;
  /// Frees all sets; none may be in use.
  Status Clear();
  Result<VkDescriptorSet> Find(const SetShape& shape, const SetContent& content);
  /// Sets of FindForFrame belong to this frame from now on. \param number  of the frame; the device
  ///     has finished the frame that is `in_flight` frames older
  void BeginFrame(uint32_t number);
  /// A set for one use in the frame of BeginFrame; that of Find without frames in flight.
  Result<VkDescriptorSet> FindForFrame(const SetShape& shape, const SetContent& content);
  /// Creates the pool of a single set, and the set: of buffers alone.
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
    bool used;  ///< in the frame
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
  uint32_t taken_ = 0;  ///< sets of the last pool
  std::vector<Entry> entries_;
  std::vector<std::vector<FrameEntry>> frames_;
  size_t frame_ = 0;
};

/// Creates the layout of descriptor sets, for all stages that use stillray's sets.
/// \param sampler  of the textures
Status MakeSetLayout(const DeviceContext& context, const SetShape& shape, VkSampler sampler,
                     VkDescriptorSetLayout* out);
/// Creates the layout of a pipeline of any kind.
/// \param push_stage  the stage that reads the `push_bytes` of push constants; unused if they are 0
Status MakePipelineLayout(const DeviceContext& context, std::span<const VkDescriptorSetLayout> sets,
                          VkShaderStageFlags push_stage, uint32_t push_bytes,
                          VkPipelineLayout* out);
/// \param code    of a shader in the program; shader_folder.h may replace it
/// \param action  for messages: "compiling the shader atrous"
Status MakeShaderModule(const DeviceContext& context, std::span<const uint32_t> code,
                        const char* action, VkShaderModule* out);

/// A compute shader with its layout.
struct PipelineInfo {
  const char* name = "";                        ///< for messages
  std::span<const uint32_t> code;               ///< SPIR-V
  std::span<const VkDescriptorSetLayout> sets;  ///< of DescriptorSets::Layout
  uint32_t push_bytes = 0;
  std::span<const uint32_t> constants;  ///< specialisation constants 0, 1, ...
};

/// Compiles the code as it is given.
Status MakeComputePipeline(const DeviceContext& context, const PipelineInfo& info,
                           VkPipelineLayout layout, VkPipeline* out);

/// A compute pipeline of the device, which all its users share (shared_pipelines.h): valid as long
/// as the device, or the denoiser in a renderer's own device.
class Pipeline {
 public:
  /// Finds the pipeline, or creates it.
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

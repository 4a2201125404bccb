// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Triangles drawn with a depth test into a picture of numbers, which is then read by others.
#pragma once

#include <span>

#include "gpu/memory.h"

namespace stillray::gpu {

struct RasterInfo {
  const char* name = "";               ///< for messages
  std::span<const uint32_t> vertex;    ///< SPIR-V; makes its vertices from their numbers
  std::span<const uint32_t> fragment;  ///< SPIR-V; writes the picture at location 0
  std::span<const VkDescriptorSetLayout> sets;
  uint32_t push_bytes = 0;  ///< of the vertex shader
};

/// A render pass, its picture and its pipeline. Nearer is a larger depth: with z = near / w as a
/// float, depths keep their relative precision at any distance. Both sides of triangles are drawn.
/// Not copied or moved.
class Raster {
 public:
  static constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

  explicit Raster(const DeviceContext* context) : context_(context) {}
  Raster(const Raster&) = delete;
  Raster& operator=(const Raster&) = delete;
  ~Raster();

  /// \param picture, depth  attachments of one size that outlive this, of an arena with memory
  Status Create(const RasterInfo& info, const Image& picture, const Image& depth);

  /// Begins the pass with `clear` in the upper left `size` pixels of the picture, which all that
  /// follows is drawn into, and binds the pipeline.
  void RecordBegin(VkCommandBuffer commands, VkExtent2D size, VkClearColorValue clear) const;
  /// Ends it; the picture is ready to be copied (VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL).
  void RecordEnd(VkCommandBuffer commands) const;

  VkPipelineLayout layout() const { return layout_; }

 private:
  Status MakePass(VkFormat format);
  Status MakeFramebuffer(const Image& picture, const Image& depth);
  Status MakePipeline(const RasterInfo& info);

  const DeviceContext* context_;
  VkRenderPass pass_ = VK_NULL_HANDLE;
  VkFramebuffer framebuffer_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

}  // namespace stillray::gpu

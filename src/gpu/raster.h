// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Rasterises triangles with a depth test to an integer image that other passes read.
#pragma once

#include <span>

#include "gpu/memory.h"

namespace stillray::gpu {

struct RasterInfo {
  const char* name = "";               ///< for error messages
  std::span<const uint32_t> vertex;    ///< SPIR-V; computes vertices from gl_VertexIndex
  std::span<const uint32_t> fragment;  ///< SPIR-V; writes location 0
  std::span<const VkDescriptorSetLayout> sets;
  uint32_t push_bytes = 0;  ///< push constants of the vertex shader
};

/// A render pass with its framebuffer and pipeline. Depth is reversed (nearer is larger): with z =
/// near / w as a float, the relative precision is uniform over distance. No face culling. Not
/// copied or moved.
class Raster {
 public:
  static constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

  explicit Raster(const DeviceContext* context) : context_(context) {}
  Raster(const Raster&) = delete;
  Raster& operator=(const Raster&) = delete;
  ~Raster();

  /// \param picture, depth  attachments of equal size from an allocated arena; must outlive this
  Status Create(const RasterInfo& info, const Image& picture, const Image& depth);

  /// Begins the pass, clears the upper left `size` pixels of the image, to which later draws are
  /// limited, and binds the pipeline.
  void RecordBegin(VkCommandBuffer commands, VkExtent2D size, VkClearColorValue clear) const;
  /// Ends the pass; the image is ready to be copied (VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL).
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

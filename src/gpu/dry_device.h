// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A mock Vulkan device that captures commands without executing them, to describe the commands of
/// a frame without a driver.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "gpu/functions.h"

namespace stillray::gpu {

/// The resource of a descriptor.
struct DryDescriptor {
  uint32_t binding = 0;
  VkDescriptorType type = VK_DESCRIPTOR_TYPE_MAX_ENUM;
  size_t resource = 0;  ///< index into DryDevice::images or DryDevice::buffers
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;  ///< layout of an image
};

/// A recorded command.
struct DryCommand {
  enum class Kind : uint8_t { kDispatch, kBarrier, kTransition, kFill, kUpdate };
  Kind kind = Kind::kDispatch;
  std::string part;  ///< text of the enclosing debug label
  // Members of a dispatch:
  size_t pipeline = 0;  ///< index into DryDevice::pipelines
  std::vector<std::vector<DryDescriptor>> sets;
  uint32_t groups[3] = {};
  // Members of a memory barrier, or of an image barrier that discards the content (kTransition):
  VkPipelineStageFlags from = 0, to = 0;
  VkAccessFlags written = 0, used = 0;
  size_t image = 0;
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;  ///< new layout
  // Members of a buffer fill or update:
  size_t buffer = 0;
  uint64_t offset = 0;
  uint64_t size = 0;
  uint32_t value = 0;
  /// Data of an update; push constants of a dispatch.
  std::vector<std::byte> bytes;
};

/// Handles of this device are valid only with its functions. Not thread-safe.
class DryDevice {
 public:
  struct Image {
    VkFormat format = VK_FORMAT_UNDEFINED;
    VkImageUsageFlags usage = 0;
    uint32_t width = 0;
    uint32_t height = 0;
    uint32_t layers = 1;
    bool is_array = false;  ///< its view is an array view, possibly with a single layer
  };
  struct Buffer {
    uint64_t size = 0;
    VkBufferUsageFlags usage = 0;
  };
  struct Pipeline {
    std::vector<uint32_t> code;
    std::map<uint32_t, uint32_t> constants;
    std::vector<std::vector<VkDescriptorType>> sets;  ///< types of the bindings 0, 1, ...
    uint32_t push_bytes = 0;
  };

  /// \param shared_memory  the device's limit on shared memory per workgroup, in bytes
  explicit DryDevice(uint32_t shared_memory) : shared_memory_(shared_memory) {}
  DryDevice(const DryDevice&) = delete;
  DryDevice& operator=(const DryDevice&) = delete;

  static PFN_vkGetInstanceProcAddr get_instance_proc_addr();
  VkInstance instance() { return Pointer<VkInstance>(); }
  VkPhysicalDevice physical() { return Pointer<VkPhysicalDevice>(); }
  VkDevice device() { return Pointer<VkDevice>(); }
  VkCommandBuffer commands() { return Pointer<VkCommandBuffer>(); }

  /// Adds a caller's image, and returns a view of it.
  VkImageView AddImage(const Image& image);

  const std::vector<Image>& images() const { return images_; }
  const std::vector<Buffer>& buffers() const { return buffers_; }
  const std::vector<Pipeline>& pipelines() const { return pipelines_; }
  /// Index of the image of a view.
  size_t ImageOf(VkImageView view) const;
  static size_t IndexOf(VkBuffer buffer);
  /// Returns the commands recorded since the last call.
  std::vector<DryCommand> TakeCommands() { return std::exchange(recorded_, {}); }

 private:
  friend struct DryFunctions;

  struct SetLayout {
    std::vector<VkDescriptorType> types;
  };
  struct PipelineLayout {
    std::vector<size_t> sets;
    uint32_t push_bytes = 0;
  };

  template <typename Handle>
  Handle Pointer() {
    return reinterpret_cast<Handle>(this);
  }

  uint32_t shared_memory_;
  std::vector<Image> images_;
  std::vector<size_t> views_;  ///< image indices of the views
  std::vector<Buffer> buffers_;
  std::vector<std::vector<uint32_t>> modules_;
  std::vector<SetLayout> set_layouts_;
  std::vector<PipelineLayout> layouts_;
  std::vector<Pipeline> pipelines_;
  std::vector<std::vector<DryDescriptor>> sets_;
  std::vector<DryCommand> recorded_;
  // State of the command buffer.
  std::string part_;
  size_t bound_pipeline_ = 0;
  std::vector<size_t> bound_sets_;
  std::vector<std::byte> push_;
};

}  // namespace stillray::gpu

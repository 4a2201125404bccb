// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The driver's cache of compiled shaders, one per device, and its file between runs of a program.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "gpu/functions.h"

namespace stillray::gpu {

struct DeviceContext;

/// The folder of the caches of devices that are created from now on; empty (the default): they are
/// not kept between runs. A program calls it once, before its first device. It is created when
/// there is a cache to be kept.
void SetPipelineCacheFolder(std::filesystem::path folder);
/// $XDG_CACHE_HOME/stillray or $HOME/.cache/stillray; empty if neither variable is set.
std::filesystem::path UserCacheFolder();

/// A cache only saves time: where it cannot be read, used or written, shaders are compiled, and
/// nothing fails. Not copied or moved.
class PipelineCache {
 public:
  PipelineCache() = default;
  PipelineCache(const PipelineCache&) = delete;
  PipelineCache& operator=(const PipelineCache&) = delete;

  /// Begins with the content of the folder's file, if that is of this device and driver.
  void Create(const DeviceContext& context, const VkPhysicalDeviceProperties& device);
  /// Writes the file, if the cache has changed, and destroys the cache. No pipeline may be made
  /// afterwards.
  void SaveAndDestroy(const DeviceContext& context);

  VkPipelineCache handle() const { return handle_; }
  /// Bytes that were read from the file; 0: there was none that could be used.
  size_t loaded_bytes() const { return loaded_.size(); }

 private:
  VkPipelineCache handle_ = VK_NULL_HANDLE;
  std::filesystem::path file_;
  std::vector<uint8_t> loaded_;
};

/// The file's bytes: a header with size and checksum, then the driver's data.
std::vector<uint8_t> PackPipelineCache(std::span<const uint8_t> data);
/// The driver's data in a file.
/// \return empty if the file is damaged, or of another device or driver
std::vector<uint8_t> UnpackPipelineCache(std::span<const uint8_t> file,
                                         const VkPhysicalDeviceProperties& device);

}  // namespace stillray::gpu

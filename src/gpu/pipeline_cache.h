// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The driver's cache of compiled shaders (VkPipelineCache), one per device, persisted in a file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "gpu/functions.h"

namespace stillray::gpu {

struct DeviceContext;

/// Sets the folder of cache files for devices created later; empty (the default): caches are not
/// persisted. Call once, before the first device is created. The folder is created when the first
/// cache is saved.
void SetPipelineCacheFolder(std::filesystem::path folder);
/// $XDG_CACHE_HOME/stillray or $HOME/.cache/stillray; empty if neither variable is set.
std::filesystem::path UserCacheFolder();

/// Failures to read, use or write the cache are not errors: shaders are then compiled. Not copied
/// or moved.
class PipelineCache {
 public:
  PipelineCache() = default;
  PipelineCache(const PipelineCache&) = delete;
  PipelineCache& operator=(const PipelineCache&) = delete;

  /// Creates the cache, initialised from the file in the folder if it matches device and driver.
  void Create(const DeviceContext& context, const VkPhysicalDeviceProperties& device);
  /// Writes the file if the cache has changed, and destroys the cache. No pipeline may be created
  /// afterwards.
  void SaveAndDestroy(const DeviceContext& context);

  VkPipelineCache handle() const { return handle_; }
  /// Bytes loaded from the file; 0 without a usable file.
  size_t loaded_bytes() const { return loaded_.size(); }

 private:
  VkPipelineCache handle_ = VK_NULL_HANDLE;
  std::filesystem::path file_;
  std::vector<uint8_t> loaded_;
};

/// Serialises the file: a header with size and checksum, then the driver's data.
std::vector<uint8_t> PackPipelineCache(std::span<const uint8_t> data);
/// Extracts the driver's data from a file.
/// \return empty if the file is damaged or belongs to another device or driver
std::vector<uint8_t> UnpackPipelineCache(std::span<const uint8_t> file,
                                         const VkPhysicalDeviceProperties& device);

}  // namespace stillray::gpu

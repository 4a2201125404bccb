// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/pipeline_cache.h"

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/checksum.h"
#include "gpu/device.h"

namespace stillray::gpu {
namespace {

struct FileHeader {
  char magic[8] = {'S', 'T', 'I', 'L', 'L', 'P', 'C', '1'};
  uint64_t bytes = 0;     ///< size of the driver's data
  uint64_t checksum = 0;  ///< checksum of the driver's data
};

/// The header of the driver's data, defined by Vulkan.
struct DataHeader {
  uint32_t bytes = 0;
  uint32_t version = 0;
  uint32_t vendor = 0;
  uint32_t device = 0;
  uint8_t uuid[VK_UUID_SIZE] = {};
};

constexpr size_t kMostBytes = size_t{256} << 20;

std::filesystem::path& CacheFolder() {
  static std::filesystem::path folder;
  return folder;
}

std::string NameOf(const VkPhysicalDeviceProperties& device) {
  std::string name = fmt::format("pipelines-{:04x}-{:04x}-", device.vendorID, device.deviceID);
  for (const uint8_t byte : device.pipelineCacheUUID) {
    name += fmt::format("{:02x}", byte);
  }
  return name + ".bin";
}

std::vector<uint8_t> ReadBytes(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (error || bytes > kMostBytes) {
    return {};
  }
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Replaces the file atomically: other processes that read or write it see either the old or the
/// new bytes.
void WriteBytes(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  std::filesystem::path part = path;
  part += fmt::format(".{:08x}.part", std::random_device()());
  std::ofstream file(part, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file.good()) {
    std::filesystem::rename(part, path, error);
  }
  if (!file.good() || error) {
    std::filesystem::remove(part, error);
  }
}

}  // namespace

void SetPipelineCacheFolder(std::filesystem::path folder) {
  CacheFolder() = std::move(folder);
}

std::filesystem::path UserCacheFolder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && cache[0] == '/') {  // relative paths must be ignored (XDG)
    return std::filesystem::path(cache) / "stillray";
  }
  const char* home = std::getenv("HOME");
  return home != nullptr && home[0] == '/' ? std::filesystem::path(home) / ".cache" / "stillray"
                                           : std::filesystem::path();
}

std::vector<uint8_t> PackPipelineCache(std::span<const uint8_t> data) {
  FileHeader header;
  header.bytes = data.size();
  header.checksum = AddToChecksum(data);
  std::vector<uint8_t> file(sizeof(header) + data.size());
  std::memcpy(file.data(), &header, sizeof(header));
  std::memcpy(file.data() + sizeof(header), data.data(), data.size());
  return file;
}

std::vector<uint8_t> UnpackPipelineCache(std::span<const uint8_t> file,
                                         const VkPhysicalDeviceProperties& device) {
  FileHeader header;
  DataHeader of_data;
  if (file.size() < sizeof(header) + sizeof(of_data)) {
    return {};
  }
  std::memcpy(&header, file.data(), sizeof(header));
  const std::span<const uint8_t> data = file.subspan(sizeof(header));
  std::memcpy(&of_data, data.data(), sizeof(of_data));
  const bool whole = std::memcmp(header.magic, FileHeader().magic, sizeof(header.magic)) == 0 &&
                     header.bytes == data.size() && header.checksum == AddToChecksum(data);
  const bool same_driver = of_data.bytes >= sizeof(of_data) &&
                           of_data.version == VK_PIPELINE_CACHE_HEADER_VERSION_ONE &&
                           of_data.vendor == device.vendorID && of_data.device == device.deviceID &&
                           std::memcmp(of_data.uuid, device.pipelineCacheUUID, VK_UUID_SIZE) == 0;
  return whole && same_driver ? std::vector<uint8_t>(data.begin(), data.end())
                              : std::vector<uint8_t>();
}

void PipelineCache::Create(const DeviceContext& context, const VkPhysicalDeviceProperties& device) {
  if (!CacheFolder().empty()) {
    file_ = CacheFolder() / NameOf(device);
    loaded_ = UnpackPipelineCache(ReadBytes(file_), device);
  }
  VkPipelineCacheCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
  info.initialDataSize = loaded_.size();
  info.pInitialData = loaded_.data();
  if (context.vk.CreatePipelineCache(context.device, &info, nullptr, &handle_) != VK_SUCCESS) {
    handle_ = VK_NULL_HANDLE;
    loaded_.clear();
  }
}

void PipelineCache::SaveAndDestroy(const DeviceContext& context) {
  if (handle_ == VK_NULL_HANDLE) {
    return;
  }
  size_t size = 0;
  if (!file_.empty() &&
      context.vk.GetPipelineCacheData(context.device, handle_, &size, nullptr) == VK_SUCCESS &&
      size <= kMostBytes) {
    std::vector<uint8_t> data(size);
    const VkResult read =
        context.vk.GetPipelineCacheData(context.device, handle_, &size, data.data());
    data.resize(size);
    if (read == VK_SUCCESS && data != loaded_) {
      WriteBytes(file_, PackPipelineCache(data));
    }
  }
  context.vk.DestroyPipelineCache(context.device, handle_, nullptr);
  handle_ = VK_NULL_HANDLE;
}

}  // namespace stillray::gpu

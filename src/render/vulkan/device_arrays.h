// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Uploads host arrays to storage buffers.
#pragma once

#include <span>
#include <vector>

#include "gpu/device.h"
#include "gpu/memory.h"

namespace stillray::render {

struct HostArray {
  const char* what;  ///< for messages: "the scene has 3 MiB of `what`"
  const void* data;
  size_t bytes;
};

template <typename T>
HostArray MakeArray(const char* what, const std::vector<T>& values) {
  return {what, values.data(), values.size() * sizeof(T)};
}

/// \return kUnsupported: an array is larger than the device's storage buffers
Status CheckArraySizes(const gpu::Device& device, std::span<const HostArray> arrays);

/// Copies array i to the beginning of buffer i, in pieces; waits for completion.
Status UploadArrays(gpu::Device* device, std::span<const HostArray> arrays,
                    std::span<const gpu::Buffer* const> buffers);

}  // namespace stillray::render

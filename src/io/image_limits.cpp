// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/image_limits.h"

#include <fmt/format.h>

namespace stillray::io {

namespace {

/// Sizes below this many bytes are harmless, and their ratio is dominated by the header.
constexpr uint64_t kHarmlessBytes = uint64_t{1} << 20;

}  // namespace

Status CheckImageSize(const std::string& name, int64_t width, int64_t height) {
  if (width < 1 || height < 1) {
    return Status::BadData(fmt::format("{}: the size is {} x {} pixels", name, width, height));
  }
  if (width > kMaxSide || height > kMaxSide) {
    return Status::Unsupported(
        fmt::format("{}: the size is {} x {} pixels; at most {} a side are supported", name, width,
                    height, kMaxSide));
  }
  return Status::Ok();
}

Status CheckDecodedSize(const std::string& name, uint64_t decoded_bytes, uint64_t file_bytes,
                        uint64_t max_ratio) {
  if (decoded_bytes > kMaxDecodedBytes) {
    return Status::OutOfMemory(
        fmt::format("{}: its pixels would take {} MiB of memory; at most {} MiB are allowed", name,
                    decoded_bytes >> 20, kMaxDecodedBytes >> 20));
  }
  if (decoded_bytes > kHarmlessBytes && decoded_bytes / max_ratio > file_bytes) {
    return Status::BadData(fmt::format("{}: claims {} MiB of pixels, but {} bytes cannot hold them",
                                       name, decoded_bytes >> 20, file_bytes));
  }
  return Status::Ok();
}

}  // namespace stillray::io

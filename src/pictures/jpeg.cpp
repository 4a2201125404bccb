// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "pictures/jpeg.h"

#include <stb/stb_image.h>
#include <stb/stb_image_write.h>

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include <fmt/format.h>

namespace stillray::pictures {

namespace {

/// JPEG (ITU-T T.81), B.1.1.3: the markers that matter for finding the end.
constexpr uint8_t kMarker = 0xff;
constexpr uint8_t kStartOfScan = 0xda;
constexpr uint8_t kEndOfImage = 0xd9;

Status Damaged(const char* reason) {
  return Status::BadData(fmt::format("is a damaged JPEG file: {}", reason));
}

/// Whether the data after the first scan's header contains the end marker. Versions of stb_image
/// differ: some reject truncated files, some fill the missing part with grey and report success.
/// Segments before the scan are skipped, since a thumbnail in them has its own end marker.
bool IsComplete(std::span<const uint8_t> file) {
  size_t at = 2;
  while (at + 4 <= file.size()) {
    if (file[at] != kMarker) {
      return false;
    }
    const uint8_t marker = file[at + 1];
    if (marker == kMarker) {  // a fill byte
      ++at;
      continue;
    }
    const size_t length = static_cast<size_t>(file[at + 2]) << 8 | file[at + 3];
    at += 2 + length;
    if (marker == kStartOfScan) {
      break;
    }
  }
  if (at >= file.size()) {
    return false;
  }
  constexpr uint8_t kEnd[] = {kMarker, kEndOfImage};
  const std::span<const uint8_t> scan = file.subspan(at);
  return std::search(scan.begin(), scan.end(), kEnd, kEnd + 2) != scan.end();
}

}  // namespace

Result<JpegHeader> ReadJpegHeader(std::span<const uint8_t> file) {
  if (file.size() > static_cast<size_t>(std::numeric_limits<int>::max())) {
    return Status::Unsupported(
        fmt::format("a JPEG file of {} bytes is not supported", file.size()));
  }
  JpegHeader header;
  int components = 0;
  if (stbi_info_from_memory(file.data(), static_cast<int>(file.size()), &header.width,
                            &header.height, &components) == 0) {
    return Damaged(stbi_failure_reason());
  }
  return header;
}

Result<JpegPixels> DecodeJpeg(std::span<const uint8_t> file, const JpegHeader& header,
                              int channels) {
  if (!IsComplete(file)) {
    return Damaged("it ends too early");
  }
  int width = 0;
  int height = 0;
  int components = 0;
  JpegPixels pixels(stbi_load_from_memory(file.data(), static_cast<int>(file.size()), &width,
                                          &height, &components, channels),
                    stbi_image_free);
  if (pixels == nullptr) {
    return Damaged(stbi_failure_reason());
  }
  if (width != header.width || height != header.height) {
    return Damaged("it changes its size");
  }
  return pixels;
}

Result<std::string> EncodeJpeg(int width, int height, std::span<const uint8_t> rgb, int quality) {
  // Called from C: must not throw.
  struct Output {
    std::string bytes;
    bool out_of_memory = false;
  } output;
  const auto append = [](void* to, void* data, int size) {
    auto* out = static_cast<Output*>(to);
    try {
      out->bytes.append(static_cast<const char*>(data), static_cast<size_t>(size));
    } catch (const std::bad_alloc&) {
      out->out_of_memory = true;
    }
  };
  constexpr int kRgb = 3;
  const int ok = stbi_write_jpg_to_func(append, &output, width, height, kRgb, rgb.data(), quality);
  if (output.out_of_memory) {
    return Status::OutOfMemory("not enough memory to encode a JPEG picture");
  }
  if (ok == 0) {
    return Status::Internal("a JPEG picture was not encoded");
  }
  return std::move(output.bytes);
}

}  // namespace stillray::pictures

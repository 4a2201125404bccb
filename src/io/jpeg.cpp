// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <stb/stb_image.h>

#include <algorithm>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "core/parallel.h"
#include "io/decoders.h"
#include "io/image_limits.h"

namespace stillray::io {

namespace {

/// JPEG (ITU-T T.81), B.1.1.3: the markers that matter for finding the end.
constexpr uint8_t kMarker = 0xff;
constexpr uint8_t kStartOfScan = 0xda;
constexpr uint8_t kEndOfImage = 0xd9;
/// An MCU of 16 x 16 pixels takes at least 6 bits: 341 pixels a byte.
constexpr uint64_t kMaxPixelsPerByte = 342;
constexpr int kRowsPerTask = 64;

struct StbDelete {
  void operator()(stbi_uc* pixels) const { stbi_image_free(pixels); }
};

/// Whether the data after the first scan's header contains the end marker. Versions of stb_image
/// differ: some reject truncated files, some fill the missing part with grey and report success.
/// Segments before the scan are skipped, as a thumbnail in one of them has an end marker of its
/// own.
bool IsComplete(const uint8_t* data, size_t size) {
  size_t at = 2;
  while (at + 4 <= size) {
    if (data[at] != kMarker) {
      return false;
    }
    const uint8_t marker = data[at + 1];
    if (marker == kMarker) {  // a fill byte
      ++at;
      continue;
    }
    const size_t length = static_cast<size_t>(data[at + 2]) << 8 | data[at + 3];
    at += 2 + length;
    if (marker == kStartOfScan) {
      break;
    }
  }
  constexpr uint8_t kEnd[] = {kMarker, kEndOfImage};
  return at < size && std::search(data + at, data + size, kEnd, kEnd + 2) != data + size;
}

}  // namespace

Result<Image3> DecodeJpeg(const uint8_t* data, size_t size, const std::string& name) {
  if (size > static_cast<size_t>(std::numeric_limits<int>::max())) {
    return Status::Unsupported(
        fmt::format("{}: a JPEG file of {} bytes is not supported", name, size));
  }
  const int bytes = static_cast<int>(size);
  int width = 0;
  int height = 0;
  int components = 0;
  if (stbi_info_from_memory(data, bytes, &width, &height, &components) == 0) {
    return Status::BadData(
        fmt::format("{}: is a damaged JPEG file: {}", name, stbi_failure_reason()));
  }
  STILLRAY_RETURN_IF_ERROR(CheckImageSize(name, width, height));
  constexpr uint64_t kPixelBytes = 3 * (sizeof(float) + sizeof(uint8_t));
  const uint64_t pixel_count = static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  STILLRAY_RETURN_IF_ERROR(
      CheckDecodedSize(name, pixel_count * kPixelBytes, size, kPixelBytes * kMaxPixelsPerByte));
  if (!IsComplete(data, size)) {
    return Status::BadData(fmt::format("{}: is a damaged JPEG file: it ends too early", name));
  }
  const std::unique_ptr<stbi_uc, StbDelete> pixels(
      stbi_load_from_memory(data, bytes, &width, &height, &components, 3));
  if (pixels == nullptr) {
    return Status::BadData(
        fmt::format("{}: is a damaged JPEG file: {}", name, stbi_failure_reason()));
  }
  Image3 image(width, height);
  const std::array<float, 256>& table = SrgbTable8();
  ParallelRows(height, kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const stbi_uc* row = pixels.get() + static_cast<size_t>(y) * static_cast<size_t>(width) * 3;
      for (int c = 0; c < 3; ++c) {
        float* out = image[c].Row(y);
        for (int x = 0; x < width; ++x) {
          out[x] = table[row[x * 3 + c]];
        }
      }
    }
  });
  return image;
}

}  // namespace stillray::io

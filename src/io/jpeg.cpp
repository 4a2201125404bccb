// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <span>

#include <fmt/format.h>

#include "core/parallel.h"
#include "core/status_prefix.h"
#include "io/decoders.h"
#include "io/image_limits.h"
#include "pictures/jpeg.h"
#include "stillray/io.h"

namespace stillray {

namespace io {

namespace {

/// An MCU of 16 x 16 pixels takes at least 6 bits: 341 pixels a byte.
constexpr uint64_t kMaxPixelsPerByte = 342;

}  // namespace

Result<Image3> DecodeJpeg(const uint8_t* data, size_t size, const std::string& name) {
  const std::span<const uint8_t> file(data, size);
  const Result<pictures::JpegHeader> header = pictures::ReadJpegHeader(file);
  if (!header.ok()) {
    return PrefixStatus(name, header.status());
  }
  const int width = header->width;
  const int height = header->height;
  STILLRAY_RETURN_IF_ERROR(CheckImageSize(name, width, height));
  constexpr uint64_t kPixelBytes = 3 * (sizeof(float) + sizeof(uint8_t));
  const uint64_t pixel_count = static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  STILLRAY_RETURN_IF_ERROR(
      CheckDecodedSize(name, pixel_count * kPixelBytes, size, kPixelBytes * kMaxPixelsPerByte));
  const Result<pictures::JpegPixels> pixels = pictures::DecodeJpeg(file, *header, 3);
  if (!pixels.ok()) {
    return PrefixStatus(name, pixels.status());
  }
  Image3 image(width, height);
  const std::array<float, 256>& table = SrgbTable8();
  ParallelRows(height, kDecodedRows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const uint8_t* row = pixels->get() + static_cast<size_t>(y) * static_cast<size_t>(width) * 3;
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

}  // namespace io

Result<std::string> EncodeJpeg(const Rgb8Image& image) {
  // Above 90, where the encoder does not subsample chroma.
  constexpr int kQuality = 95;
  constexpr int kMost = pictures::kMaxJpegSide;
  if (image.width < 1 || image.height < 1 || image.width > kMost || image.height > kMost) {
    return Status::InvalidArgument(
        fmt::format("a JPEG picture of {} x {} pixels cannot be written; 1 to {} a side can",
                    image.width, image.height, kMost));
  }
  const size_t expected = static_cast<size_t>(image.width) * static_cast<size_t>(image.height) * 3;
  if (image.pixels.size() != expected) {
    return Status::InvalidArgument(
        fmt::format("a JPEG picture of {} x {} pixels needs {} bytes, not {}", image.width,
                    image.height, expected, image.pixels.size()));
  }
  return pictures::EncodeJpeg(image.width, image.height, image.pixels, kQuality);
}

Status WriteJpeg(const std::string& path, const Rgb8Image& image) {
  const Result<std::string> bytes = EncodeJpeg(image);
  if (!bytes.ok()) {
    return PrefixStatus(path, bytes.status());
  }
  return WriteFileAtomically(path, bytes->data(), bytes->size());
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <new>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "core/parallel.h"
#include "core/status_prefix.h"
#include "io/decoders.h"
#include "io/image_limits.h"
#include "pictures/png.h"
#include "stillray/io.h"

namespace stillray {

namespace io {

namespace {

/// The header of a PNG file, with a plausible size.
Result<pictures::PngHeader> CheckedHeader(std::span<const uint8_t> file, const std::string& name,
                                          uint64_t bytes_per_pixel) {
  const Result<pictures::PngHeader> header = pictures::ReadPngHeader(file);
  if (!header.ok()) {
    return PrefixStatus(name, header.status());
  }
  STILLRAY_RETURN_IF_ERROR(CheckImageSize(name, header->width, header->height));
  const uint64_t pixels = uint64_t{header->width} * header->height;
  // One-bit images pack eight pixels into a byte before compression.
  STILLRAY_RETURN_IF_ERROR(CheckDecodedSize(name, pixels * bytes_per_pixel, file.size(),
                                            8 * bytes_per_pixel * kMaxDeflateRatio));
  return header;
}

template <typename T>
Status DecodeInto(std::span<const uint8_t> file, const std::string& name,
                  pictures::PngPixels layout, std::vector<T>* pixels) {
  const Status status =
      pictures::DecodePng(file, layout, pixels->data(), pixels->size() * sizeof(T));
  return status.ok() ? status : PrefixStatus(name, status);
}

/// IEC 61966-2-1 in double precision, for tables.
double SrgbToLinear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

template <size_t kCodes>
std::array<float, kCodes> MakeSrgbTable() {
  std::array<float, kCodes> table;
  for (size_t i = 0; i < kCodes; ++i) {
    table[i] = static_cast<float>(SrgbToLinear(static_cast<double>(i) / (kCodes - 1)));
  }
  return table;
}

const std::array<float, 65536>& SrgbTable16() {
  static const std::array<float, 65536> table = MakeSrgbTable<65536>();
  return table;
}

/// Three planes from interleaved pixels of `kStep` codes each.
template <int kStep, typename T, size_t kCodes>
Image3 ToPlanes(const std::vector<T>& pixels, int width, int height,
                const std::array<float, kCodes>& table) {
  Image3 image(width, height);
  ParallelRows(height, kDecodedRows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const T* row = pixels.data() + static_cast<size_t>(y) * static_cast<size_t>(width) * kStep;
      for (int c = 0; c < 3; ++c) {
        float* out = image[c].Row(y);
        for (int x = 0; x < width; ++x) {
          out[x] = table[row[x * kStep + c]];
        }
      }
    }
  });
  return image;
}

}  // namespace

const std::array<float, 256>& SrgbTable8() {
  static const std::array<float, 256> table = MakeSrgbTable<256>();
  return table;
}

Result<Image3> DecodePng(const uint8_t* data, size_t size, const std::string& name) {
  constexpr uint64_t kLargestPixel = 4 * sizeof(uint16_t) + 3 * sizeof(float);
  const std::span<const uint8_t> file(data, size);
  const Result<pictures::PngHeader> header = CheckedHeader(file, name, kLargestPixel);
  if (!header.ok()) {
    return header.status();
  }
  const int width = static_cast<int>(header->width);
  const int height = static_cast<int>(header->height);
  const size_t pixel_count = size_t{header->width} * header->height;
  if (header->bit_depth == 16) {
    std::vector<uint16_t> pixels(pixel_count * 4);
    STILLRAY_RETURN_IF_ERROR(DecodeInto(file, name, pictures::PngPixels::kRgba16, &pixels));
    return ToPlanes<4>(pixels, width, height, SrgbTable16());
  }
  std::vector<uint8_t> pixels(pixel_count * 3);
  STILLRAY_RETURN_IF_ERROR(DecodeInto(file, name, pictures::PngPixels::kRgb8, &pixels));
  return ToPlanes<3>(pixels, width, height, SrgbTable8());
}

}  // namespace io

Result<Rgb8Image> DecodePng8(const uint8_t* data, size_t size, const std::string& name) {
  try {
    const std::span<const uint8_t> file(data, size);
    const Result<pictures::PngHeader> header = io::CheckedHeader(file, name, 3);
    if (!header.ok()) {
      return header.status();
    }
    Rgb8Image image;
    image.width = static_cast<int>(header->width);
    image.height = static_cast<int>(header->height);
    image.pixels.resize(size_t{header->width} * header->height * 3);
    STILLRAY_RETURN_IF_ERROR(io::DecodeInto(file, name, pictures::PngPixels::kRgb8, &image.pixels));
    return image;
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format("{}: not enough memory for its pixels", name));
  }
}

Result<Rgb8Image> ReadPng8(const std::string& path) {
  const Result<std::string> bytes = ReadWholeFile(path, io::kMaxFileBytes);
  if (!bytes.ok()) {
    return bytes.status();
  }
  return DecodePng8(reinterpret_cast<const uint8_t*>(bytes->data()), bytes->size(), path);
}

Result<std::string> EncodePng(const Rgb8Image& image) {
  if (image.width < 1 || image.height < 1 || image.width > io::kMaxSide ||
      image.height > io::kMaxSide) {
    return Status::InvalidArgument(
        fmt::format("a PNG picture of {} x {} pixels cannot be written; 1 to {} a side can",
                    image.width, image.height, io::kMaxSide));
  }
  const size_t expected = static_cast<size_t>(image.width) * static_cast<size_t>(image.height) * 3;
  if (image.pixels.size() != expected) {
    return Status::InvalidArgument(
        fmt::format("a PNG picture of {} x {} pixels needs {} bytes, not {}", image.width,
                    image.height, expected, image.pixels.size()));
  }
  return pictures::EncodePng(image.width, image.height, image.pixels);
}

Status WritePng(const std::string& path, const Rgb8Image& image) {
  const Result<std::string> bytes = EncodePng(image);
  if (!bytes.ok()) {
    return PrefixStatus(path, bytes.status());
  }
  return WriteFileAtomically(path, bytes->data(), bytes->size());
}

}  // namespace stillray

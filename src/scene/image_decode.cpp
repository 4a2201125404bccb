// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/image_decode.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include <fmt/format.h>
#include <webp/decode.h>

#include "pictures/jpeg.h"
#include "pictures/png.h"

namespace stillray {

namespace {

using Bytes = std::span<const uint8_t>;

/// Maximum texels per encoded byte, so that a small file cannot allocate gigabytes. PNG: deflate
/// packs 1032 bytes into one (RFC 1951: 258 bytes per 2 bits) and a byte holds up to 8 texels.
/// JPEG: an MCU of 16x16 texels takes at least 6 bits. WebP has no such bound.
constexpr uint64_t kMaxPngTexelsPerByte = 1032 * 8;
constexpr uint64_t kMaxJpegTexelsPerByte = 2048;

bool StartsWith(Bytes bytes, const void* signature, size_t length) {
  return bytes.size() >= length && std::memcmp(bytes.data(), signature, length) == 0;
}

int ToInt(uint32_t side) {
  return static_cast<int>(std::min<uint32_t>(side, std::numeric_limits<int>::max()));
}

Status InspectPng(Bytes bytes, ImageInfo* info) {
  const Result<pictures::PngHeader> header = pictures::ReadPngHeader(bytes);
  if (header.ok()) {
    info->width = ToInt(header->width);
    info->height = ToInt(header->height);
  }
  return header.status();
}

Status InspectJpeg(Bytes bytes, ImageInfo* info) {
  const Result<pictures::JpegHeader> header = pictures::ReadJpegHeader(bytes);
  if (header.ok()) {
    info->width = header->width;
    info->height = header->height;
  }
  return header.status();
}

Status DecodeJpeg(Bytes bytes, const ImageInfo& info, std::vector<uint8_t>* texels) {
  const Result<pictures::JpegPixels> pixels =
      pictures::DecodeJpeg(bytes, {info.width, info.height}, 4);
  if (pixels.ok()) {
    std::memcpy(texels->data(), pixels->get(), texels->size());
  }
  return pixels.status();
}

Status DecodeWebp(Bytes bytes, const ImageInfo& info, std::vector<uint8_t>* texels) {
  if (WebPDecodeRGBAInto(bytes.data(), bytes.size(), texels->data(), texels->size(),
                         info.width * 4) == nullptr) {
    return Status::BadData("is a damaged WebP file");
  }
  return Status::Ok();
}

}  // namespace

Result<ImageInfo> InspectImage(Bytes bytes) {
  static constexpr std::array<uint8_t, 8> kPng = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  static constexpr std::array<uint8_t, 3> kJpeg = {0xff, 0xd8, 0xff};
  if (bytes.empty()) {
    return Status::BadData("the picture is empty");
  }
  if (bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max())) {
    return Status::Unsupported("the picture takes more than 2 GiB");
  }
  ImageInfo info;
  uint64_t texels_per_byte = std::numeric_limits<uint64_t>::max() / bytes.size();
  if (StartsWith(bytes, kPng.data(), kPng.size())) {
    info.format = ImageInfo::Format::kPng;
    texels_per_byte = kMaxPngTexelsPerByte;
    STILLRAY_RETURN_IF_ERROR(InspectPng(bytes, &info));
  } else if (StartsWith(bytes, kJpeg.data(), kJpeg.size())) {
    info.format = ImageInfo::Format::kJpeg;
    texels_per_byte = kMaxJpegTexelsPerByte;
    STILLRAY_RETURN_IF_ERROR(InspectJpeg(bytes, &info));
  } else if (bytes.size() >= 12 && StartsWith(bytes, "RIFF", 4) &&
             StartsWith(bytes.subspan(8), "WEBP", 4)) {
    info.format = ImageInfo::Format::kWebp;
    if (WebPGetInfo(bytes.data(), bytes.size(), &info.width, &info.height) == 0) {
      return Status::BadData("is a damaged WebP file");
    }
  } else {
    return Status::BadData("not a PNG, JPEG or WebP picture");
  }
  if (info.width < 1 || info.height < 1) {
    return Status::BadData(
        fmt::format("the picture claims a size of {}x{}", info.width, info.height));
  }
  if (info.width > kMaxTextureSide || info.height > kMaxTextureSide) {
    return Status::Unsupported(fmt::format("the picture has {}x{} texels, at most {}x{} are read",
                                           info.width, info.height, kMaxTextureSide,
                                           kMaxTextureSide));
  }
  const uint64_t texels = static_cast<uint64_t>(info.width) * static_cast<uint64_t>(info.height);
  if (texels > texels_per_byte * bytes.size()) {
    return Status::BadData(fmt::format("the picture claims {}x{} texels but has only {} bytes",
                                       info.width, info.height, bytes.size()));
  }
  return info;
}

Result<std::vector<uint8_t>> DecodeImage(Bytes bytes, const ImageInfo& info) {
  std::vector<uint8_t> texels(static_cast<size_t>(info.width) * static_cast<size_t>(info.height) *
                              4);
  switch (info.format) {
    case ImageInfo::Format::kPng:
      STILLRAY_RETURN_IF_ERROR(
          pictures::DecodePng(bytes, pictures::PngPixels::kRgba8, texels.data(), texels.size()));
      break;
    case ImageInfo::Format::kJpeg:
      STILLRAY_RETURN_IF_ERROR(DecodeJpeg(bytes, info, &texels));
      break;
    case ImageInfo::Format::kWebp:
      STILLRAY_RETURN_IF_ERROR(DecodeWebp(bytes, info, &texels));
      break;
  }
  return texels;
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/image_decode.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <spng.h>
#include <stb/stb_image.h>
#include <webp/decode.h>

namespace stillray {

namespace {

using Bytes = std::span<const uint8_t>;

/// Maximum texels per byte, so that a few bytes cannot claim gigabytes. PNG: deflate packs 1032
/// bytes into one (RFC 1951: 258 bytes per 2 bits) and a byte holds up to 8 texels. JPEG: an MCU of
/// 16x16 texels takes at least 6 bits. WebP has no such bound.
constexpr uint64_t kMaxPngTexelsPerByte = 1032 * 8;
constexpr uint64_t kMaxJpegTexelsPerByte = 2048;

bool StartsWith(Bytes bytes, const void* signature, size_t length) {
  return bytes.size() >= length && std::memcmp(bytes.data(), signature, length) == 0;
}

struct PngContext {
  explicit PngContext(Bytes bytes) : ctx(spng_ctx_new(0)) {
    if (ctx != nullptr) {
      spng_set_image_limits(ctx, kMaxTextureSide, kMaxTextureSide);
      // Texts and profiles are skipped; no chunk needs more than this.
      spng_set_chunk_limits(ctx, size_t{1} << 24, size_t{1} << 26);
      spng_set_crc_action(ctx, SPNG_CRC_ERROR, SPNG_CRC_DISCARD);
      spng_set_png_buffer(ctx, bytes.data(), bytes.size());
    }
  }
  ~PngContext() { spng_ctx_free(ctx); }
  PngContext(const PngContext&) = delete;
  PngContext& operator=(const PngContext&) = delete;
  spng_ctx* ctx;
};

/// Width and height are at a fixed position in the first chunk (PNG, 11.2.2).
Status InspectPng(Bytes bytes, ImageInfo* info) {
  constexpr size_t kHeaderEnd = 24;
  if (bytes.size() < kHeaderEnd) {
    return Status::BadData("the PNG picture is cut short");
  }
  const auto read = [&](size_t at) {
    return static_cast<uint32_t>(bytes[at]) << 24 | static_cast<uint32_t>(bytes[at + 1]) << 16 |
           static_cast<uint32_t>(bytes[at + 2]) << 8 | static_cast<uint32_t>(bytes[at + 3]);
  };
  info->width = static_cast<int>(std::min<uint32_t>(read(16), std::numeric_limits<int>::max()));
  info->height = static_cast<int>(std::min<uint32_t>(read(20), std::numeric_limits<int>::max()));
  return Status::Ok();
}

Status DecodePng(Bytes bytes, std::vector<uint8_t>* texels) {
  PngContext png(bytes);
  if (png.ctx == nullptr) {
    return Status::OutOfMemory("no memory to decode a PNG picture");
  }
  const int error =
      spng_decode_image(png.ctx, texels->data(), texels->size(), SPNG_FMT_RGBA8, SPNG_DECODE_TRNS);
  if (error != 0) {
    return Status::BadData(fmt::format("damaged PNG picture: {}", spng_strerror(error)));
  }
  return Status::Ok();
}

Status DecodeJpeg(Bytes bytes, const ImageInfo& info, std::vector<uint8_t>* texels) {
  int width = 0;
  int height = 0;
  int channels = 0;
  const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
      stbi_load_from_memory(bytes.data(), static_cast<int>(bytes.size()), &width, &height,
                            &channels, 4),
      stbi_image_free);
  if (pixels == nullptr) {
    return Status::BadData(fmt::format("damaged JPEG picture: {}", stbi_failure_reason()));
  }
  if (width != info.width || height != info.height) {
    return Status::BadData("damaged JPEG picture: it changes its size");
  }
  std::memcpy(texels->data(), pixels.get(), texels->size());
  return Status::Ok();
}

Status DecodeWebp(Bytes bytes, const ImageInfo& info, std::vector<uint8_t>* texels) {
  if (WebPDecodeRGBAInto(bytes.data(), bytes.size(), texels->data(), texels->size(),
                         info.width * 4) == nullptr) {
    return Status::BadData("damaged WebP picture");
  }
  return Status::Ok();
}

/// The last marker of a JPEG file is EOI. The decoder fills missing data with grey, and a half grey
/// picture must not be accepted as a texture.
bool JpegEndsEarly(Bytes bytes) {
  // Some writers pad the end with zeros or append data, so EOI need not be last.
  for (size_t i = bytes.size(); i >= 2; --i) {
    if (bytes[i - 2] == 0xff && bytes[i - 1] == 0xd9) {
      return false;
    }
  }
  return true;
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
    int channels = 0;
    if (stbi_info_from_memory(bytes.data(), static_cast<int>(bytes.size()), &info.width,
                              &info.height, &channels) == 0) {
      return Status::BadData(fmt::format("damaged JPEG picture: {}", stbi_failure_reason()));
    }
    if (JpegEndsEarly(bytes)) {
      return Status::BadData("damaged JPEG picture: it has no end");
    }
  } else if (bytes.size() >= 12 && StartsWith(bytes, "RIFF", 4) &&
             StartsWith(bytes.subspan(8), "WEBP", 4)) {
    info.format = ImageInfo::Format::kWebp;
    if (WebPGetInfo(bytes.data(), bytes.size(), &info.width, &info.height) == 0) {
      return Status::BadData("damaged WebP picture");
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
      STILLRAY_RETURN_IF_ERROR(DecodePng(bytes, &texels));
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

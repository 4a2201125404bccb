// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <new>
#include <string_view>

#include <fmt/format.h>

#include "io/decoders.h"
#include "io/image_limits.h"
#include "stillray/io.h"

namespace stillray {

namespace {

using namespace std::string_view_literals;

constexpr std::string_view kExrSignature = "\x76\x2f\x31\x01"sv;
constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n"sv;
constexpr std::string_view kJpegSignature = "\xff\xd8\xff"sv;
constexpr std::string_view kHdrSignature = "#?"sv;

Result<Image3> Decode(const uint8_t* data, size_t size, const std::string& name, bool* linear) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  *linear = false;
  if (bytes.starts_with(kPngSignature)) {
    return io::DecodePng(data, size, name);
  }
  if (bytes.starts_with(kJpegSignature)) {
    return io::DecodeJpeg(data, size, name);
  }
  *linear = true;
  if (bytes.starts_with(kExrSignature)) {
    const Result<ExrImage> exr = DecodeExr(data, size, name);
    return exr.ok() ? ExrColour(*exr, name) : exr.status();
  }
  if (bytes.starts_with(kHdrSignature)) {
    return io::DecodeHdr(data, size, name);
  }
  if (bytes.empty()) {
    return Status::BadData(fmt::format("{}: is empty", name));
  }
  return Status::Unsupported(
      fmt::format("{}: is not a picture in a format that is read (EXR, HDR, PNG, JPEG)", name));
}

}  // namespace

Result<Image3> DecodeImage(const uint8_t* data, size_t size, const std::string& name,
                           bool* linear_source) {
  bool linear = false;
  try {
    Result<Image3> image = Decode(data, size, name, &linear);
    if (linear_source != nullptr) {
      *linear_source = linear;
    }
    return image;
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format("{}: not enough memory for its pixels", name));
  }
}

Result<Image3> ReadImage(const std::string& path, bool* linear_source) {
  const Result<std::string> bytes = ReadWholeFile(path, io::kMaxFileBytes);
  if (!bytes.ok()) {
    return bytes.status();
  }
  return DecodeImage(reinterpret_cast<const uint8_t*>(bytes->data()), bytes->size(), path,
                     linear_source);
}

}  // namespace stillray

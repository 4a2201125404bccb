// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Recognises files of other formats than EXR.
#include <string_view>

#include <fmt/format.h>

#include "io/exr_stream.h"

namespace stillray::io {
namespace {

using namespace std::string_view_literals;

struct Format {
  std::string_view signature;
  const char* name;
};
constexpr Format kOtherFormats[] = {{"\x89PNG"sv, "a PNG"},      {"\xff\xd8\xff"sv, "a JPEG"},
                                    {"#?"sv, "a Radiance HDR"},  {"II*\0"sv, "a TIFF"},
                                    {"MM\0*"sv, "a TIFF"},       {"BM"sv, "a BMP"},
                                    {"SDPX"sv, "a DPX"},         {"XPDS"sv, "a DPX"},
                                    {"RIFF"sv, "a WebP or AVI"}, {"BLENDER"sv, "a .blend"}};

}  // namespace

Status CheckExrSignature(const uint8_t* data, size_t size, const std::string& name) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (bytes.starts_with("\x76\x2f\x31\x01"sv)) {
    return Status::Ok();
  }
  for (const Format& format : kOtherFormats) {
    if (bytes.starts_with(format.signature)) {
      return Status::BadData(fmt::format(
          "{}: is {} file, expected EXR, which alone holds linear light and passes (Blender: "
          "choose "
          "OpenEXR MultiLayer in Output Properties > Output > File Format, and render again)",
          name, format.name));
    }
  }
  return Status::BadData(fmt::format("{}: is not an EXR file", name));
}

}  // namespace stillray::io

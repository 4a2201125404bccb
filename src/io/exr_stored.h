// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Pixels of EXR parts exactly as stored, so that copied channels keep their bits.
#pragma once

#include <Imath/ImathBox.h>
#include <Imath/half.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfPixelType.h>

#include <cstddef>
#include <map>
#include <memory>
#include <string>

#include "stillray/aov.h"

namespace stillray {

namespace io {

inline size_t BytesOf(Imf::PixelType type) {
  return type == Imf::HALF ? sizeof(half) : sizeof(float);
}

/// One channel's pixels of a data window, packed, in the file's pixel type; initially zero.
struct StoredPlane {
  Imf::PixelType type;
  size_t width;
  size_t size;  ///< bytes
  std::unique_ptr<char[]> bytes;

  StoredPlane(Imf::PixelType t, const Imath::Box2i& window)
      : type(t),
        width(static_cast<size_t>(window.max.x - window.min.x + 1)),
        size(width * static_cast<size_t>(window.max.y - window.min.y + 1) * BytesOf(t)),
        bytes(std::make_unique<char[]>(size)) {}
  char* Row(int y) { return bytes.get() + static_cast<size_t>(y) * width * BytesOf(type); }
  const char* Row(int y) const {
    return bytes.get() + static_cast<size_t>(y) * width * BytesOf(type);
  }
  Imf::Slice Slice(const Imath::Box2i& window) {
    return Imf::Slice::Make(type, bytes.get(), window, BytesOf(type), BytesOf(type) * width);
  }
};

/// Keyed by the channel's name in the file.
using StoredPart = std::map<std::string, StoredPlane>;

}  // namespace io

struct StoredPixels::Impl {
  std::map<int, io::StoredPart> parts;  ///< by part number; only parts that were decoded
};

}  // namespace stillray

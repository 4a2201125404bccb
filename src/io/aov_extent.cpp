// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The image size of a file, read from its header. Exceptions of OpenEXR are caught in this file.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>

#include <algorithm>
#include <new>

#include <fmt/format.h>

#include "io/exr_stream.h"
#include "io/text.h"
#include "stillray/aov.h"

namespace stillray {
namespace {

int64_t Width(const Imath::Box2i& box) {
  return int64_t{box.max.x} - box.min.x + 1;
}
int64_t Height(const Imath::Box2i& box) {
  return int64_t{box.max.y} - box.min.y + 1;
}

}  // namespace

Result<ExrExtent> MeasureExr(const uint8_t* data, size_t size, const std::string& name) {
  STILLRAY_RETURN_IF_ERROR(io::CheckExrSignature(data, size, name));
  try {
    io::PrepareOpenExr();
    io::ExrMemoryInput stream(data, size, name);
    Imf::MultiPartInputFile file(stream);
    const Imath::Box2i display = file.header(0).displayWindow();
    ExrExtent extent;
    extent.width = Width(display);
    extent.height = Height(display);
    extent.pixels = extent.width * extent.height;
    for (int i = 0; i < file.parts(); ++i) {
      const Imf::Header& header = file.header(i);
      const Imath::Box2i& own = header.displayWindow();
      const bool deep = header.hasType() && Imf::isDeepData(header.type());
      if (deep || Width(own) != extent.width || Height(own) != extent.height) {
        continue;  // not decoded
      }
      const Imath::Box2i& window = header.dataWindow();
      extent.pixels = std::max(extent.pixels, Width(window) * Height(window));
      for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
        extent.channels += 1;
      }
    }
    return extent;
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format("{}: not enough memory for its header", name));
  } catch (const std::exception& error) {
    return Status::BadData(
        fmt::format("{}: is a damaged EXR file: {}", name, io::OneLine(error.what())));
  }
}

}  // namespace stillray

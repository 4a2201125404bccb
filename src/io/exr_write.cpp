// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Writes OpenEXR files. Exceptions of OpenEXR are caught in this file.
#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <set>

#include <fmt/format.h>

#include "core/parallel.h"
#include "core/status_prefix.h"
#include "io/exr_stream.h"
#include "io/exr_zip.h"
#include "io/image_limits.h"
#include "io/text.h"
#include "stillray/io.h"

namespace stillray {

namespace io {

namespace {

constexpr float kHalfMax = 65504.0f;

Imf::Compression ToOpenExr(ExrCompression compression) {
  switch (compression) {
    case ExrCompression::kNone:
      return Imf::NO_COMPRESSION;
    case ExrCompression::kZips:
      return Imf::ZIPS_COMPRESSION;
    case ExrCompression::kPiz:
      return Imf::PIZ_COMPRESSION;
    case ExrCompression::kDwaa:
      return Imf::DWAA_COMPRESSION;
    case ExrCompression::kZip:
    case ExrCompression::kOther:
      return Imf::ZIP_COMPRESSION;
  }
  return Imf::ZIP_COMPRESSION;
}

Status CheckChannel(const ExrImage& image, const Channel& channel) {
  if (channel.name.empty()) {
    return Status::InvalidArgument("a channel of an EXR picture has no name");
  }
  const bool integers = channel.type == PixelType::kUint32;
  const int width = integers ? channel.integers.width() : channel.values.width();
  const int height = integers ? channel.integers.height() : channel.values.height();
  if (width != image.width || height != image.height) {
    return Status::InvalidArgument(fmt::format(
        "channel {} of an EXR picture has {} x {} pixels of type {}; the picture has "
        "{} x {}",
        channel.name, width, height, integers ? "uint32" : "float", image.width, image.height));
  }
  // DWA recognises luminance by the last letter of a name and compresses it with loss; it affects
  // only floats and halves.
  if (image.compression == ExrCompression::kDwaa && !integers && channel.name.ends_with(".Y")) {
    return Status::InvalidArgument(
        fmt::format("DWAA compression would damage channel {}: it takes every .Y for luminance; "
                    "use ZIP for pictures with motion, normals or positions",
                    channel.name));
  }
  return Status::Ok();
}

Status CheckImage(const ExrImage& image) {
  if (image.width < 1 || image.height < 1 || image.width > kMaxSide || image.height > kMaxSide) {
    return Status::InvalidArgument(
        fmt::format("an EXR picture of {} x {} pixels cannot be written; 1 to {} a side can",
                    image.width, image.height, kMaxSide));
  }
  if (image.channels.empty()) {
    return Status::InvalidArgument("an EXR picture without channels cannot be written");
  }
  std::set<std::string> names;
  for (const Channel& channel : image.channels) {
    STILLRAY_RETURN_IF_ERROR(CheckChannel(image, channel));
    if (!names.insert(channel.name).second) {
      return Status::InvalidArgument(
          fmt::format("an EXR picture has two channels named {}", channel.name));
    }
  }
  for (const auto& [name, value] : image.attributes) {
    if (name == "type" || name == "chunkCount" || name == "version") {
      return Status::InvalidArgument(
          fmt::format("the attribute {} of an EXR picture is not free to be set", name));
    }
  }
  return Status::Ok();
}

half ToHalf(float value) {
  if (std::isfinite(value)) {
    value = std::clamp(value, -kHalfMax, kHalfMax);
  }
  return half(value);
}

/// Packed rows of the plane as halves.
std::vector<half> ToHalves(const Image1& plane) {
  const size_t width = static_cast<size_t>(plane.width());
  std::vector<half> halves(width * static_cast<size_t>(plane.height()));
  ParallelRows(plane.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      std::transform(plane.Row(y), plane.Row(y) + width,
                     halves.begin() + static_cast<ptrdiff_t>(static_cast<size_t>(y) * width),
                     ToHalf);
    }
  });
  return halves;
}

Imf::Slice SliceOf(Imf::PixelType type, const void* data, int width, int height, size_t x_stride,
                   size_t y_stride) {
  return Imf::Slice::Make(type, data, Imath::V2i(0, 0), width, height, x_stride, y_stride);
}

Imf::Header MakeHeader(const ExrImage& image) {
  Imf::Header header(image.width, image.height);
  header.compression() = ToOpenExr(image.compression);
  for (const Channel& channel : image.channels) {
    const Imf::PixelType type = channel.type == PixelType::kHalf    ? Imf::HALF
                                : channel.type == PixelType::kFloat ? Imf::FLOAT
                                                                    : Imf::UINT;
    header.channels().insert(channel.name, Imf::Channel(type));
  }
  for (const auto& [name, value] : image.attributes) {
    header.insert(name, Imf::StringAttribute(value));
  }
  return header;
}

std::string Encode(const ExrImage& image) {
  const Imf::Header header = MakeHeader(image);
  std::vector<std::vector<half>> halves;
  halves.reserve(image.channels.size());
  Imf::FrameBuffer frame_buffer;
  for (const Channel& channel : image.channels) {
    const int w = image.width;
    const int h = image.height;
    Imf::Slice slice;
    if (channel.type == PixelType::kHalf) {
      halves.push_back(ToHalves(channel.values));
      slice = SliceOf(Imf::HALF, halves.back().data(), w, h, sizeof(half),
                      static_cast<size_t>(w) * sizeof(half));
    } else if (channel.type == PixelType::kFloat) {
      slice = SliceOf(Imf::FLOAT, channel.values.Row(0), w, h, sizeof(float),
                      static_cast<size_t>(channel.values.stride()) * sizeof(float));
    } else {
      slice = SliceOf(Imf::UINT, channel.integers.Row(0), w, h, sizeof(uint32_t),
                      static_cast<size_t>(channel.integers.stride()) * sizeof(uint32_t));
    }
    frame_buffer.insert(channel.name, slice);
  }
  if (CanEncodeZip(header)) {
    return EncodeZip(header, frame_buffer);
  }
  ExrMemoryOutput stream;
  {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(frame_buffer);
    file.writePixels(image.height);
  }  // the destructor writes the line table
  return stream.Take();
}

}  // namespace

}  // namespace io

Result<std::string> EncodeExr(const ExrImage& image) {
  STILLRAY_RETURN_IF_ERROR(io::CheckImage(image));
  try {
    io::PrepareOpenExr();
    return io::Encode(image);
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format(
        "not enough memory to encode an EXR picture of {} x {} pixels", image.width, image.height));
  } catch (const std::exception& error) {
    return Status::InvalidArgument(
        fmt::format("an EXR picture cannot be written: {}", io::OneLine(error.what())));
  }
}

Status WriteExr(const std::string& path, const ExrImage& image) {
  const Result<std::string> bytes = EncodeExr(image);
  if (!bytes.ok()) {
    return PrefixStatus(path, bytes.status());
  }
  return WriteFileAtomically(path, bytes->data(), bytes->size());
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Reads OpenEXR files. Exceptions of OpenEXR are caught in this file.
#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfVecAttribute.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <new>
#include <set>

#include <fmt/format.h>

#include "core/parallel.h"
#include "io/exr_stored.h"
#include "io/exr_stream.h"
#include "io/exr_zip.h"
#include "io/image_limits.h"
#include "io/text.h"
#include "stillray/io.h"

namespace stillray {

namespace io {

namespace {

struct CompressionTraits {
  ExrCompression compression;
  const char* name;
  /// largest number of decoded bytes, in the file's pixel type, per stored byte
  uint64_t max_ratio;
};

/// Bounds of the expansion. PIZ: Huffman codes of a run of 256 values need 10 bits (410). DWA: a
/// flat 8 x 8 block is one zero coefficient, which deflate stores once more in 1/1032.
CompressionTraits TraitsOf(Imf::Compression compression) {
  switch (compression) {
    case Imf::NO_COMPRESSION:
      return {ExrCompression::kNone, "none", 1};
    case Imf::RLE_COMPRESSION:
      return {ExrCompression::kOther, "rle", 64};
    case Imf::ZIPS_COMPRESSION:
      return {ExrCompression::kZips, "zips", kMaxDeflateRatio};
    case Imf::ZIP_COMPRESSION:
      return {ExrCompression::kZip, "zip", kMaxDeflateRatio};
    case Imf::PIZ_COMPRESSION:
      return {ExrCompression::kPiz, "piz", 512};
    case Imf::PXR24_COMPRESSION:
      return {ExrCompression::kOther, "pxr24", 2 * kMaxDeflateRatio};
    case Imf::B44_COMPRESSION:
      return {ExrCompression::kOther, "b44", 16};
    case Imf::B44A_COMPRESSION:
      return {ExrCompression::kOther, "b44a", 16};
    case Imf::DWAA_COMPRESSION:
      return {ExrCompression::kDwaa, "dwaa", 64 * kMaxDeflateRatio};
    case Imf::DWAB_COMPRESSION:
      return {ExrCompression::kOther, "dwab", 64 * kMaxDeflateRatio};
    default:
      return {ExrCompression::kOther, "unknown", 64 * kMaxDeflateRatio};
  }
}

ExrWindow ToWindow(const Imath::Box2i& box) {
  return {box.min.x, box.min.y, box.max.x, box.max.y};
}
/// 64 bits: a hostile window may span all of int.
int64_t WidthOf(const ExrWindow& w) {
  return int64_t{w.x_max} - w.x_min + 1;
}
int64_t HeightOf(const ExrWindow& w) {
  return int64_t{w.y_max} - w.y_min + 1;
}
bool Same(const ExrWindow& a, const ExrWindow& b) {
  return a.x_min == b.x_min && a.y_min == b.y_min && a.x_max == b.x_max && a.y_max == b.y_max;
}

bool IsDeep(const Imf::Header& header) {
  return header.hasType() && Imf::isDeepData(header.type());
}

uint64_t ChannelCount(const Imf::Header& header) {
  uint64_t count = 0;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    ++count;
  }
  return count;
}

/// Checks of a part that need its header only.
Status CheckPart(const std::string& name, const Imf::Header& header, size_t file_bytes) {
  if (IsDeep(header)) {
    return Status::Unsupported(fmt::format("{}: holds deep data, which is not supported", name));
  }
  const ExrWindow data = ToWindow(header.dataWindow());
  const ExrWindow display = ToWindow(header.displayWindow());
  STILLRAY_RETURN_IF_ERROR(CheckImageSize(name, WidthOf(display), HeightOf(display)));
  STILLRAY_RETURN_IF_ERROR(CheckImageSize(name + " (data window)", WidthOf(data), HeightOf(data)));
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1) {
      return Status::Unsupported(
          fmt::format("{}: channel {} is subsampled by {} x {}; only full resolution is supported",
                      name, OneLine(it.name()), it.channel().xSampling, it.channel().ySampling));
    }
  }
  const uint64_t channels = ChannelCount(header);
  if (channels == 0) {
    return Status::BadData(fmt::format("{}: has no channels", name));
  }
  const auto pixels = [](const ExrWindow& w) {
    return static_cast<uint64_t>(WidthOf(w)) * static_cast<uint64_t>(HeightOf(w));
  };
  const uint64_t decoded = pixels(data) * channels * sizeof(float);
  // Halves take twice their size in memory.
  const uint64_t ratio = 2 * TraitsOf(header.compression()).max_ratio;
  STILLRAY_RETURN_IF_ERROR(CheckDecodedSize(name, decoded, file_bytes, ratio));
  // A small crop of a large canvas is common, so the file's size cannot bound the canvas.
  constexpr uint64_t kHarmlessCanvas = uint64_t{1} << 30;
  constexpr uint64_t kMaxCanvasRatio = 64;
  const uint64_t canvas = pixels(display) * channels * sizeof(float);
  STILLRAY_RETURN_IF_ERROR(CheckDecodedSize(name, canvas, UINT64_MAX, ratio));
  if (canvas > std::max(kHarmlessCanvas, kMaxCanvasRatio * decoded)) {
    return Status::BadData(
        fmt::format("{}: claims a display window of {} x {} pixels for a data window of {} x {}",
                    name, WidthOf(display), HeightOf(display), WidthOf(data), HeightOf(data)));
  }
  if (header.hasTileDescription()) {
    // OpenEXR keeps a whole row of tiles in memory; tiles far larger than the image are rejected.
    const Imf::TileDescription& tile = header.tileDescription();
    const uint64_t tile_bytes = uint64_t{tile.xSize} * tile.ySize * channels * sizeof(float);
    constexpr uint64_t kHarmlessTile = uint64_t{64} << 20;
    if (tile.xSize > kMaxSide || tile.ySize > kMaxSide ||
        tile_bytes > std::max(kHarmlessTile, 4 * decoded)) {
      return Status::BadData(fmt::format("{}: claims tiles of {} x {} pixels for {} x {} pixels",
                                         name, tile.xSize, tile.ySize, WidthOf(data),
                                         HeightOf(data)));
    }
  }
  return Status::Ok();
}

template <typename T>
Imf::Slice SliceOf(Imf::PixelType type, Plane<T>& plane, const ExrWindow& window) {
  return Imf::Slice::Make(type, plane.Row(0), Imath::V2i(window.x_min, window.y_min), plane.width(),
                          plane.height(), sizeof(T),
                          static_cast<size_t>(plane.stride()) * sizeof(T));
}

/// The plane, moved from the data window to the display window; zero where there is no data.
template <typename T>
Plane<T> Place(const Plane<T>& plane, const ExrWindow& data, const ExrWindow& display) {
  Plane<T> placed(static_cast<int>(WidthOf(display)), static_cast<int>(HeightOf(display)));
  const int x_begin = std::max(data.x_min, display.x_min);
  const int x_end = std::min(data.x_max, display.x_max);  // inclusive
  const int y_begin = std::max(data.y_min, display.y_min);
  const int y_end = std::min(data.y_max, display.y_max);
  for (int64_t y = y_begin; y <= y_end && x_begin <= x_end; ++y) {
    const T* from = plane.Row(static_cast<int>(y - data.y_min)) + (int64_t{x_begin} - data.x_min);
    T* to = placed.Row(static_cast<int>(y - display.y_min)) + (int64_t{x_begin} - display.x_min);
    std::copy_n(from, int64_t{x_end} - x_begin + 1, to);
  }
  return placed;
}

void CopyRow(const char* from, Imf::PixelType type, size_t width, float* to) {
  if (type == Imf::HALF) {
    const half* halves = reinterpret_cast<const half*>(from);
    std::transform(halves, halves + width, to, [](half h) { return static_cast<float>(h); });
  } else {
    std::memcpy(to, from, width * sizeof(float));
  }
}

/// Reads the part's pixels once, as stored, and converts them to planes.
StoredPart ReadStored(Imf::InputPart& part, const Imath::Box2i& window,
                      std::vector<Channel>* channels) {
  StoredPart stored;
  Imf::FrameBuffer frame_buffer;
  const Imf::ChannelList& list = part.header().channels();
  for (auto it = list.begin(); it != list.end(); ++it) {
    StoredPlane& plane = stored.try_emplace(it.name(), it.channel().type, window).first->second;
    frame_buffer.insert(it.name(), plane.Slice(window));
  }
  if (CanDecodeZip(part.header())) {
    DecodeZip(part, frame_buffer);
  } else {
    part.setFrameBuffer(frame_buffer);
    part.readPixels(window.min.y, window.max.y);
  }
  for (Channel& channel : *channels) {
    const StoredPlane& plane = stored.at(channel.name);
    const size_t width = plane.width;
    ParallelRows(window.max.y - window.min.y + 1, kRowsPerTask, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        if (channel.type == PixelType::kUint32) {
          std::memcpy(channel.integers.Row(y), plane.Row(y), width * sizeof(uint32_t));
        } else {
          CopyRow(plane.Row(y), plane.type, width, channel.values.Row(y));
        }
      }
    });
  }
  return stored;
}

/// \param stored  set to the pixels as stored, or nullptr
std::vector<Channel> ReadPart(Imf::MultiPartInputFile& file, int part_number, StoredPart* stored) {
  Imf::InputPart part(file, part_number);
  const ExrWindow data = ToWindow(part.header().dataWindow());
  const ExrWindow display = ToWindow(part.header().displayWindow());
  const int width = static_cast<int>(WidthOf(data));
  const int height = static_cast<int>(HeightOf(data));
  std::vector<Channel> channels;
  const Imf::ChannelList& list = part.header().channels();
  for (auto it = list.begin(); it != list.end(); ++it) {
    Channel channel;
    channel.name = it.name();
    if (it.channel().type == Imf::UINT) {
      channel.type = PixelType::kUint32;
      channel.integers = Plane<uint32_t>(width, height);
    } else {
      channel.type = it.channel().type == Imf::HALF ? PixelType::kHalf : PixelType::kFloat;
      channel.values = Image1(width, height);
    }
    channels.push_back(std::move(channel));
  }
  if (stored != nullptr) {
    *stored = ReadStored(part, part.header().dataWindow(), &channels);
  } else {
    Imf::FrameBuffer frame_buffer;
    for (Channel& channel : channels) {
      frame_buffer.insert(channel.name, channel.type == PixelType::kUint32
                                            ? SliceOf(Imf::UINT, channel.integers, data)
                                            : SliceOf(Imf::FLOAT, channel.values, data));
    }
    part.setFrameBuffer(frame_buffer);
    part.readPixels(data.y_min, data.y_max);
  }
  if (!Same(data, display)) {
    for (Channel& channel : channels) {
      if (channel.type == PixelType::kUint32) {
        channel.integers = Place(channel.integers, data, display);
      } else {
        channel.values = Place(channel.values, data, display);
      }
    }
  }
  return channels;
}

/// Appends the channels of a part, with the part's name as prefix where a name is taken.
Status AddChannels(const std::string& name, const std::string& part_name,
                   std::vector<Channel> channels, ExrImage* image) {
  std::set<std::string> taken;
  for (const Channel& channel : image->channels) {
    taken.insert(channel.name);
  }
  const bool clash = std::any_of(channels.begin(), channels.end(), [&](const Channel& channel) {
    return taken.count(channel.name) != 0;
  });
  for (Channel& channel : channels) {
    if (clash) {
      channel.name = part_name + "." + channel.name;
    }
    if (!taken.insert(channel.name).second) {
      return Status::BadData(
          fmt::format("{}: two of its parts hold a channel {}", name, OneLine(channel.name)));
    }
    image->channels.push_back(std::move(channel));
  }
  return Status::Ok();
}

template <typename Matrix>
std::string MatrixText(const Matrix& m, unsigned size) {
  std::string text;
  for (unsigned row = 0; row < size; ++row) {
    for (unsigned column = 0; column < size; ++column) {
      text += fmt::format("{}{}", text.empty() ? "" : " ", m[row][column]);
    }
  }
  return text;
}

/// The value of a numeric attribute as text; empty if its type is not a simple one.
std::string AttributeText(const Imf::Attribute& attribute) {
  if (const auto* a = dynamic_cast<const Imf::IntAttribute*>(&attribute)) {
    return fmt::format("{}", a->value());
  }
  if (const auto* a = dynamic_cast<const Imf::FloatAttribute*>(&attribute)) {
    return fmt::format("{}", a->value());
  }
  if (const auto* a = dynamic_cast<const Imf::DoubleAttribute*>(&attribute)) {
    return fmt::format("{}", a->value());
  }
  if (const auto* a = dynamic_cast<const Imf::RationalAttribute*>(&attribute)) {
    return fmt::format("{}/{}", a->value().n, a->value().d);
  }
  if (const auto* a = dynamic_cast<const Imf::V2fAttribute*>(&attribute)) {
    return fmt::format("{} {}", a->value().x, a->value().y);
  }
  if (const auto* a = dynamic_cast<const Imf::V3fAttribute*>(&attribute)) {
    return fmt::format("{} {} {}", a->value().x, a->value().y, a->value().z);
  }
  if (const auto* a = dynamic_cast<const Imf::M44fAttribute*>(&attribute)) {
    return MatrixText(a->value(), 4);
  }
  if (const auto* a = dynamic_cast<const Imf::M33fAttribute*>(&attribute)) {
    return MatrixText(a->value(), 3);
  }
  return {};
}

void ReadAttributes(const Imf::Header& header, ExrImage* image) {
  for (auto it = header.begin(); it != header.end(); ++it) {
    const std::string name = it.name();
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute())) {
      // "type" describes the structure of the file; the writer sets its own.
      if (name != "type") {
        image->attributes[name] = text->value();
      }
    } else if (std::string value = AttributeText(it.attribute()); !value.empty()) {
      image->other_attributes[name] = std::move(value);
    }
  }
}

/// \param stored  the pixels of all parts as stored, or nullptr
Result<ExrImage> DecodeParts(Imf::MultiPartInputFile& file, size_t size, const std::string& name,
                             std::map<int, StoredPart>* stored) {
  const Imf::Header& first = file.header(0);
  STILLRAY_RETURN_IF_ERROR(CheckPart(name, first, size));
  ExrImage image;
  image.data_window = ToWindow(first.dataWindow());
  image.display_window = ToWindow(first.displayWindow());
  image.width = static_cast<int>(WidthOf(image.display_window));
  image.height = static_cast<int>(HeightOf(image.display_window));
  image.compression = TraitsOf(first.compression()).compression;
  image.compression_name = TraitsOf(first.compression()).name;
  image.tiled = first.hasTileDescription();
  ReadAttributes(first, &image);
  const auto stored_of = [&](int part) { return stored != nullptr ? &(*stored)[part] : nullptr; };
  image.channels = ReadPart(file, 0, stored_of(0));
  uint64_t channel_count = image.channels.size();
  for (int i = 1; i < file.parts(); ++i) {
    const Imf::Header& header = file.header(i);
    const std::string part_name = header.hasName() ? header.name() : fmt::format("part{}", i);
    const ExrWindow display = ToWindow(header.displayWindow());
    if (IsDeep(header) || WidthOf(display) != image.width || HeightOf(display) != image.height) {
      image.notes.push_back(fmt::format(
          "part {} ({}) is left out: {}", i, OneLine(part_name),
          IsDeep(header) ? std::string("deep data")
                         : fmt::format("{} x {} pixels", WidthOf(display), HeightOf(display))));
      continue;
    }
    STILLRAY_RETURN_IF_ERROR(CheckPart(fmt::format("{}, part {}", name, i), header, size));
    channel_count += ChannelCount(header);
    STILLRAY_RETURN_IF_ERROR(
        CheckDecodedSize(name,
                         channel_count * sizeof(float) * static_cast<uint64_t>(image.width) *
                             static_cast<uint64_t>(image.height),
                         UINT64_MAX, 1));
    STILLRAY_RETURN_IF_ERROR(AddChannels(name, part_name, ReadPart(file, i, stored_of(i)), &image));
  }
  return image;
}

}  // namespace

}  // namespace io

Result<ExrImage> DecodeExr(const uint8_t* data, size_t size, const std::string& name) {
  return DecodeExr(data, size, name, nullptr);
}

Result<ExrImage> DecodeExr(const uint8_t* data, size_t size, const std::string& name,
                           StoredPixels* stored) {
  STILLRAY_RETURN_IF_ERROR(io::CheckExrSignature(data, size, name));
  try {
    io::PrepareOpenExr();
    io::ExrMemoryInput stream(data, size, name);
    Imf::MultiPartInputFile file(stream);
    if (stored == nullptr) {
      return io::DecodeParts(file, size, name, nullptr);
    }
    stored->impl_ = std::make_unique<StoredPixels::Impl>();
    return io::DecodeParts(file, size, name, &stored->impl_->parts);
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format("{}: not enough memory for its pixels", name));
  } catch (const std::exception& error) {
    return Status::BadData(
        fmt::format("{}: is a damaged EXR file: {}", name, io::OneLine(error.what())));
  }
}

Result<ExrImage> ReadExr(const std::string& path) {
  const Result<std::string> bytes = ReadWholeFile(path, io::kMaxFileBytes);
  if (!bytes.ok()) {
    return bytes.status();
  }
  return DecodeExr(reinterpret_cast<const uint8_t*>(bytes->data()), bytes->size(), path);
}

}  // namespace stillray

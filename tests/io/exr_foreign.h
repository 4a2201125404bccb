// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// EXR files of kinds that stillray reads but does not write, made with OpenEXR itself.
#pragma once

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledOutputFile.h>

#include <string>
#include <vector>

namespace stillray {

/// The value of every test picture at x, y of the data window's coordinates.
inline float ForeignValue(int x, int y) {
  return static_cast<float>(x) + 0.5f * static_cast<float>(y);
}

struct ForeignPlane {
  explicit ForeignPlane(const Imath::Box2i& w) : window(w) {
    for (int y = w.min.y; y <= w.max.y; ++y) {
      for (int x = w.min.x; x <= w.max.x; ++x) {
        values.push_back(ForeignValue(x, y));
      }
    }
  }
  Imf::Slice Slice() const {
    return Imf::Slice::Make(Imf::FLOAT, values.data(), window, sizeof(float),
                            sizeof(float) * static_cast<size_t>(window.max.x - window.min.x + 1));
  }
  Imath::Box2i window;
  std::vector<float> values;
};

inline Imf::Header ForeignHeader(const Imath::Box2i& display, const Imath::Box2i& data,
                                 const std::vector<std::string>& channels,
                                 Imf::Compression compression = Imf::ZIP_COMPRESSION) {
  Imf::Header header(display, data);
  header.compression() = compression;
  for (const std::string& channel : channels) {
    header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
  }
  return header;
}

inline Imf::FrameBuffer ForeignBuffer(const Imf::Header& header, const ForeignPlane& plane) {
  Imf::FrameBuffer buffer;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    buffer.insert(it.name(), plane.Slice());
  }
  return buffer;
}

inline void WriteForeignScanlines(const std::string& path, const Imf::Header& header) {
  const ForeignPlane plane(header.dataWindow());
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(ForeignBuffer(header, plane));
  file.writePixels(header.dataWindow().max.y - header.dataWindow().min.y + 1);
}

inline void WriteForeignTiles(const std::string& path, Imf::Header header, int tile,
                              Imf::LevelMode mode) {
  header.setTileDescription(
      Imf::TileDescription(static_cast<unsigned>(tile), static_cast<unsigned>(tile), mode));
  const ForeignPlane plane(header.dataWindow());
  Imf::TiledOutputFile file(path.c_str(), header);
  file.setFrameBuffer(ForeignBuffer(header, plane));
  for (int level = 0; level < file.numLevels(); ++level) {
    file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
  }
}

inline void WriteForeignParts(const std::string& path, std::vector<Imf::Header> headers) {
  for (size_t i = 0; i < headers.size(); ++i) {
    headers[i].setName("part" + std::to_string(i));
    headers[i].setType(Imf::SCANLINEIMAGE);
  }
  Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()));
  for (size_t i = 0; i < headers.size(); ++i) {
    const ForeignPlane plane(headers[i].dataWindow());
    Imf::OutputPart part(file, static_cast<int>(i));
    part.setFrameBuffer(ForeignBuffer(headers[i], plane));
    part.writePixels(headers[i].dataWindow().max.y - headers[i].dataWindow().min.y + 1);
  }
}

}  // namespace stillray

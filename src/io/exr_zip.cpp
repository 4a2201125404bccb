// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The layout of a file is that of "OpenEXR File Layout" (openexr.com): OpenEXR writes the header,
// and the table of chunks and the chunks follow it. A chunk of ZIP holds 16 lines, one of ZIPS a
// single one; a line holds its channels in the order of their names.
#include "io/exr_zip.h"

#include <libdeflate.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfOutputFile.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <new>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

#include "core/parallel.h"
#include "io/exr_stored.h"
#include "io/exr_stream.h"

namespace stillray::io {
namespace {

/// Files are a little smaller than those of OpenEXR's own level, 4 of zlib, in half of its time.
constexpr int kLevel = 4;

struct FreeCompressor {
  void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
};
using Compressor = std::unique_ptr<libdeflate_compressor, FreeCompressor>;

Compressor MakeCompressor() {
  Compressor made(libdeflate_alloc_compressor(kLevel));
  if (made == nullptr) {
    throw std::bad_alloc();
  }
  return made;
}

/// A channel's pixels.
struct Source {
  const char* base;  ///< of pixel (0, 0)
  size_t x_stride;
  size_t y_stride;
  size_t bytes;  ///< of a value
};

std::vector<Source> SourcesOf(const Imf::Header& header, const Imf::FrameBuffer& pixels) {
  std::vector<Source> sources;
  const Imf::ChannelList& list = header.channels();
  for (auto it = list.begin(); it != list.end(); ++it) {
    const Imf::Slice& slice = pixels[it.name()];
    sources.push_back({slice.base, slice.xStride, slice.yStride, BytesOf(it.channel().type)});
  }
  return sources;
}

/// The lines first..last as they are before compression.
void Gather(const std::vector<Source>& sources, const Imath::Box2i& window, int first, int last,
            std::vector<char>* out) {
  out->clear();
  const auto width = static_cast<size_t>(window.max.x - window.min.x + 1);
  for (int y = first; y <= last; ++y) {
    for (const Source& s : sources) {
      const char* from = s.base + static_cast<ptrdiff_t>(s.y_stride) * y +
                         static_cast<ptrdiff_t>(s.x_stride) * window.min.x;
      const size_t at = out->size();
      out->resize(at + width * s.bytes);
      char* to = out->data() + at;
      if (s.x_stride == s.bytes) {
        std::memcpy(to, from, width * s.bytes);
        continue;
      }
      for (size_t x = 0; x < width; ++x) {
        std::memcpy(to + x * s.bytes, from + x * s.x_stride, s.bytes);
      }
    }
  }
}

/// Bytes at even places, then those at odd ones.
void Split(const std::vector<char>& raw, std::vector<unsigned char>* out) {
  out->resize(raw.size());
  const size_t odd = raw.size() / 2;
  const size_t even = raw.size() - odd;
  const auto* from = reinterpret_cast<const unsigned char*>(raw.data());
  unsigned char* to = out->data();
  for (size_t i = 0; i < odd; ++i) {
    to[i] = from[2 * i];
    to[even + i] = from[2 * i + 1];
  }
  if (even > odd) {
    to[odd] = from[2 * odd];
  }
}

/// Each byte as its difference from the one before.
void Differences(const std::vector<unsigned char>& bytes, std::vector<unsigned char>* out) {
  out->resize(bytes.size());
  const unsigned char* from = bytes.data();
  unsigned char* to = out->data();
  to[0] = from[0];
  for (size_t i = 1; i < bytes.size(); ++i) {
    to[i] = static_cast<unsigned char>(from[i] - from[i - 1] + 128);
  }
}

template <typename T>
void AppendLittleEndian(T value, std::string* to) {
  static_assert(std::endian::native == std::endian::little);
  to->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// What one thread works with.
struct Workshop {
  Compressor compressor = MakeCompressor();
  std::vector<char> raw;
  std::vector<unsigned char> split;
  std::vector<unsigned char> differences;
  std::vector<char> packed;
};

/// One chunk as it stands in the file. What compression would make larger is stored as it is.
std::string MakeChunk(const std::vector<Source>& sources, const Imath::Box2i& window, int first,
                      int last, Workshop* w) {
  Gather(sources, window, first, last, &w->raw);
  Split(w->raw, &w->split);
  Differences(w->split, &w->differences);
  const size_t size = w->raw.size();
  w->packed.resize(libdeflate_zlib_compress_bound(w->compressor.get(), size));
  const size_t packed = libdeflate_zlib_compress(w->compressor.get(), w->differences.data(), size,
                                                 w->packed.data(), w->packed.size());
  const bool smaller = packed > 0 && packed < size;
  std::string chunk;
  AppendLittleEndian(static_cast<int32_t>(first), &chunk);
  AppendLittleEndian(static_cast<int32_t>(smaller ? packed : size), &chunk);
  chunk.append(smaller ? w->packed.data() : w->raw.data(), smaller ? packed : size);
  return chunk;
}

/// The header, and room for the table of chunks.
std::string HeaderBytes(const Imf::Header& header) {
  ExrMemoryOutput stream;
  { const Imf::OutputFile file(stream, header); }
  return stream.Take();
}

}  // namespace

bool CanEncodeZip(const Imf::Header& header) {
  const Imf::ChannelList& list = header.channels();
  for (auto it = list.begin(); it != list.end(); ++it) {
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1) {
      return false;
    }
  }
  return std::endian::native == std::endian::little && !header.hasTileDescription() &&
         header.lineOrder() == Imf::INCREASING_Y &&
         (header.compression() == Imf::ZIP_COMPRESSION ||
          header.compression() == Imf::ZIPS_COMPRESSION);
}

std::string EncodeZip(const Imf::Header& header, const Imf::FrameBuffer& pixels) {
  const int lines = header.compression() == Imf::ZIP_COMPRESSION ? 16 : 1;
  const Imath::Box2i window = header.dataWindow();
  const int count = (window.max.y - window.min.y) / lines + 1;
  const std::vector<Source> sources = SourcesOf(header, pixels);
  std::vector<std::string> chunks(static_cast<size_t>(count));
  tbb::enumerable_thread_specific<Workshop> workshops;
  ParallelRows(count, 1, [&](int i, int) {
    const int first = window.min.y + i * lines;
    const int last = std::min(first + lines - 1, window.max.y);
    chunks[static_cast<size_t>(i)] = MakeChunk(sources, window, first, last, &workshops.local());
  });
  std::string file = HeaderBytes(header);
  const size_t table_at = file.size() - chunks.size() * sizeof(uint64_t);
  size_t total = file.size();
  std::string table;
  for (const std::string& chunk : chunks) {
    AppendLittleEndian(static_cast<uint64_t>(total), &table);
    total += chunk.size();
  }
  file.replace(table_at, table.size(), table);
  file.reserve(total);
  for (std::string& chunk : chunks) {
    file += chunk;
    chunk = std::string();
  }
  return file;
}

}  // namespace stillray::io

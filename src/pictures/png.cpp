// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "pictures/png.h"

#include <libdeflate.h>
#include <spng.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <new>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "core/parallel.h"

namespace stillray::pictures {

namespace {

using namespace std::string_view_literals;

/// PNG, 5.2 and 11.2.2: the signature, then the header chunk, whose bytes have fixed positions.
constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR"sv;
constexpr size_t kSignatureBytes = 8;
constexpr size_t kWidthAt = 16;
constexpr size_t kHeightAt = 20;
constexpr size_t kBitDepthAt = 24;
constexpr size_t kHeaderBytes = 33;
/// Compression level of libdeflate. Higher levels hardly reduce dithered images: level 3 takes 2.5
/// times as long for files that are 3.5 % smaller, level 6 five times for 6 %.
constexpr int kCompressionLevel = 1;
/// PNG, 9.2: each byte is predicted from its left, upper and upper left neighbours. Files are 4 to
/// 13 % smaller than with any other single filter; a filter for each row of its own gains less
/// than 1 %.
constexpr uint8_t kPaethFilter = 4;
constexpr int kEncodedRows = 32;
constexpr size_t kRgb = 3;
/// PNG, 7.1: the length of a chunk is below 2^31.
constexpr size_t kLargestChunk = size_t{1} << 30;
/// Bytes for the signature and the chunks besides the pixels.
constexpr size_t kOtherBytes = 128;
/// Texts and colour profiles are not used; larger chunks are discarded.
constexpr size_t kMaxChunkBytes = size_t{1} << 26;

struct ContextDelete {
  void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
using Context = std::unique_ptr<spng_ctx, ContextDelete>;

struct FreeDelete {
  void operator()(void* memory) const { std::free(memory); }
};

Status Damaged(int error) {
  if (error == SPNG_EMEM) {
    return Status::OutOfMemory("not enough memory for its pixels");
  }
  return Status::BadData(fmt::format("is a damaged PNG file: {}", spng_strerror(error)));
}

Status NotEncoded(int error) {
  if (error == SPNG_EMEM) {
    return Status::OutOfMemory("not enough memory to encode a PNG picture");
  }
  return Status::Internal(fmt::format("a PNG picture was not encoded: {}", spng_strerror(error)));
}

uint32_t BigEndian(std::span<const uint8_t, 4> bytes) {
  return uint32_t{bytes[0]} << 24 | uint32_t{bytes[1]} << 16 | uint32_t{bytes[2]} << 8 |
         uint32_t{bytes[3]};
}

struct CompressorDelete {
  void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
};

/// PNG, 9.4: the neighbour that is closest to left + up - corner.
inline int PaethPredictor(int left, int up, int corner) {
  const int from_left = std::abs(up - corner);
  const int from_up = std::abs(left - corner);
  const int from_corner = std::abs(left + up - 2 * corner);
  const int other = from_up <= from_corner ? up : corner;
  return from_left <= from_up && from_left <= from_corner ? left : other;
}

/// \param above  the row above; zeros above the first one
void FilterRow(const uint8_t* row, const uint8_t* above, size_t bytes, uint8_t* out) {
  for (size_t i = 0; i < kRgb; ++i) {
    out[i] = static_cast<uint8_t>(row[i] - above[i]);
  }
  for (size_t i = kRgb; i < bytes; ++i) {
    out[i] =
        static_cast<uint8_t>(row[i] - PaethPredictor(row[i - kRgb], above[i], above[i - kRgb]));
  }
}

/// Rows as PNG compresses them: the number of the filter, then the filtered bytes.
std::vector<uint8_t> FilterRows(int width, int height, std::span<const uint8_t> rgb) {
  const size_t bytes = static_cast<size_t>(width) * kRgb;
  const std::vector<uint8_t> zeros(bytes);
  std::vector<uint8_t> rows((bytes + 1) * static_cast<size_t>(height));
  ParallelRows(height, kEncodedRows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const uint8_t* row = rgb.data() + static_cast<size_t>(y) * bytes;
      uint8_t* out = rows.data() + static_cast<size_t>(y) * (bytes + 1);
      out[0] = kPaethFilter;
      FilterRow(row, y > 0 ? row - bytes : zeros.data(), bytes, out + 1);
    }
  });
  return rows;
}

void AppendBigEndian(uint32_t value, std::string* to) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    to->push_back(static_cast<char>(value >> shift & 0xff));
  }
}

/// PNG, 5.3: length, type, data, and the checksum of type and data.
void AppendChunk(std::string_view type, std::string_view data, std::string* file) {
  AppendBigEndian(static_cast<uint32_t>(data.size()), file);
  const size_t begin = file->size();
  file->append(type).append(data);
  AppendBigEndian(libdeflate_crc32(0, file->data() + begin, file->size() - begin), file);
}

/// The zlib stream of the bytes.
std::string Compress(const std::vector<uint8_t>& bytes) {
  const std::unique_ptr<libdeflate_compressor, CompressorDelete> compressor(
      libdeflate_alloc_compressor(kCompressionLevel));
  if (compressor == nullptr) {
    throw std::bad_alloc();
  }
  std::string stream(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()), '\0');
  stream.resize(libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(),
                                         stream.data(), stream.size()));
  return stream;
}

/// The finished file of an encoder that has all its chunks.
Result<std::string> Encode(spng_ctx* context, std::span<const uint8_t> pixels) {
  int error =
      spng_encode_image(context, pixels.data(), pixels.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
  size_t size = 0;
  const std::unique_ptr<void, FreeDelete> bytes(
      error ? nullptr : spng_get_png_buffer(context, &size, &error));
  if (bytes == nullptr || error != 0) {
    return NotEncoded(error);
  }
  return std::string(static_cast<const char*>(bytes.get()), size);
}

/// An encoder into memory, with the header of 8-bit pixels and the mark of sRGB.
Result<Context> MakeEncoder(int width, int height, uint8_t color_type) {
  Context context(spng_ctx_new(SPNG_CTX_ENCODER));
  if (context == nullptr) {
    return NotEncoded(SPNG_EMEM);
  }
  spng_ihdr header{};
  header.width = static_cast<uint32_t>(width);
  header.height = static_cast<uint32_t>(height);
  header.bit_depth = 8;
  header.color_type = color_type;
  constexpr uint8_t kPerceptual = 0;
  int error = spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
  error = error ? error : spng_set_ihdr(context.get(), &header);
  error = error ? error : spng_set_srgb(context.get(), kPerceptual);
  if (error != 0) {
    return NotEncoded(error);
  }
  return context;
}

}  // namespace

Result<PngHeader> ReadPngHeader(std::span<const uint8_t> file) {
  const size_t compared = std::min(file.size(), kSignature.size());
  if (!std::equal(file.begin(), file.begin() + static_cast<ptrdiff_t>(compared), kSignature.begin(),
                  [](uint8_t a, char b) { return a == static_cast<uint8_t>(b); })) {
    return Status::BadData("is not a PNG file, or its header is damaged");
  }
  if (file.size() < kHeaderBytes) {
    return Status::BadData("is a damaged PNG file: it ends within the header");
  }
  return PngHeader{BigEndian(file.subspan<kWidthAt, 4>()), BigEndian(file.subspan<kHeightAt, 4>()),
                   file[kBitDepthAt]};
}

Status DecodePng(std::span<const uint8_t> file, PngPixels layout, void* pixels, size_t size) {
  const Context context(spng_ctx_new(0));
  if (context == nullptr) {
    return Damaged(SPNG_EMEM);
  }
  const int format = layout == PngPixels::kRgb8    ? SPNG_FMT_RGB8
                     : layout == PngPixels::kRgba8 ? SPNG_FMT_RGBA8
                                                   : SPNG_FMT_RGBA16;
  size_t needed = 0;
  int error = spng_set_chunk_limits(context.get(), kMaxChunkBytes, kMaxChunkBytes);
  error = error ? error : spng_set_crc_action(context.get(), SPNG_CRC_ERROR, SPNG_CRC_DISCARD);
  error = error ? error : spng_set_png_buffer(context.get(), file.data(), file.size());
  error = error ? error : spng_decoded_image_size(context.get(), format, &needed);
  if (error != 0) {
    return Damaged(error);
  }
  if (needed != size) {
    return Status::BadData(
        fmt::format("its pixels take {} bytes, not the {} that its size asks for", needed, size));
  }
  const int flags = layout == PngPixels::kRgba8 ? SPNG_DECODE_TRNS : 0;
  error = spng_decode_image(context.get(), pixels, size, format, flags);
  return error == 0 ? Status::Ok() : Damaged(error);
}

Result<std::string> EncodePng(int width, int height, std::span<const uint8_t> rgb) {
  try {
    const std::string stream = Compress(FilterRows(width, height, rgb));
    std::string file(kSignature.substr(0, kSignatureBytes));
    file.reserve(stream.size() + kOtherBytes);
    std::string header;
    AppendBigEndian(static_cast<uint32_t>(width), &header);
    AppendBigEndian(static_cast<uint32_t>(height), &header);
    // Bit depth 8, RGB; the only compression and filter method, not interlaced.
    header += "\x08\x02\0\0\0"sv;
    AppendChunk("IHDR", header, &file);
    AppendChunk("sRGB", "\0"sv, &file);  // perceptual intent
    for (size_t at = 0; at < stream.size(); at += kLargestChunk) {
      AppendChunk("IDAT", std::string_view(stream).substr(at, kLargestChunk), &file);
    }
    AppendChunk("IEND", "", &file);
    return file;
  } catch (const std::bad_alloc&) {
    return NotEncoded(SPNG_EMEM);
  }
}

Result<std::string> EncodePalettePng(int width, int height, std::span<const uint8_t> indices,
                                     std::span<const std::array<uint8_t, 3>, 256> palette) {
  const Result<Context> context = MakeEncoder(width, height, SPNG_COLOR_TYPE_INDEXED);
  if (!context.ok()) {
    return context.status();
  }
  spng_plte chunk{};
  chunk.n_entries = 256;
  for (size_t i = 0; i < 256; ++i) {
    chunk.entries[i] = {palette[i][0], palette[i][1], palette[i][2], 0};
  }
  const int error = spng_set_plte(context->get(), &chunk);
  return error ? NotEncoded(error) : Encode(context->get(), indices);
}

}  // namespace stillray::pictures

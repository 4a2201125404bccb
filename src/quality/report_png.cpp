// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/report_png.h"

#include <cstdlib>
#include <memory>

#include <fmt/core.h>
#include <spng.h>

namespace stillray::report {
namespace {

struct FreeContext {
  void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
struct FreeBuffer {
  void operator()(void* bytes) const { std::free(bytes); }
};

Result<std::string> Encode(int width, int height, const std::vector<uint8_t>& indices,
                           spng_plte* palette) {
  const std::unique_ptr<spng_ctx, FreeContext> context(spng_ctx_new(SPNG_CTX_ENCODER));
  if (context == nullptr) {
    return Status::OutOfMemory("PNG encoder");
  }
  spng_ihdr header = {};
  header.width = static_cast<uint32_t>(width);
  header.height = static_cast<uint32_t>(height);
  header.bit_depth = 8;
  header.color_type = SPNG_COLOR_TYPE_INDEXED;
  int error = spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
  error = error != 0 ? error : spng_set_ihdr(context.get(), &header);
  error = error != 0 ? error : spng_set_srgb(context.get(), 0);
  error = error != 0 ? error : spng_set_plte(context.get(), palette);
  error = error != 0 ? error
                     : spng_encode_image(context.get(), indices.data(), indices.size(),
                                         SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
  if (error != 0) {
    return Status::Internal(
        fmt::format("PNG of {}x{} pixels: {}", width, height, spng_strerror(error)));
  }
  size_t size = 0;
  const std::unique_ptr<void, FreeBuffer> bytes(spng_get_png_buffer(context.get(), &size, &error));
  if (bytes == nullptr) {
    return Status::Internal(
        fmt::format("PNG of {}x{} pixels: {}", width, height, spng_strerror(error)));
  }
  return std::string(static_cast<const char*>(bytes.get()), size);
}

}  // namespace

Result<std::string> EncodePalettePng(int width, int height, const std::vector<uint8_t>& indices,
                                     const std::array<Rgb8, 256>& palette) {
  spng_plte chunk = {};
  chunk.n_entries = 256;
  for (size_t i = 0; i < 256; ++i) {
    chunk.entries[i] = {palette[i][0], palette[i][1], palette[i][2], 0};
  }
  return Encode(width, height, indices, &chunk);
}

}  // namespace stillray::report

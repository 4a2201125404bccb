// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/test_pictures.h"

#include <cstdlib>

#include <gtest/gtest.h>
#include <spng.h>
#include <stb/stb_image_write.h>
#include <webp/encode.h>

namespace stillray::test {

std::vector<uint8_t> TestTexels(int width, int height) {
  std::vector<uint8_t> texels;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      texels.push_back(static_cast<uint8_t>(40 * x + 3));
      texels.push_back(static_cast<uint8_t>(50 * y + 7));
      texels.push_back(static_cast<uint8_t>(30 * (x + y)));
      texels.push_back(static_cast<uint8_t>(255 - 20 * x));
    }
  }
  return texels;
}

std::vector<uint8_t> EncodePng(const std::vector<uint8_t>& rgba, int width, int height) {
  spng_ctx* ctx = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_set_option(ctx, SPNG_ENCODE_TO_BUFFER, 1);
  spng_ihdr header{};
  header.width = static_cast<uint32_t>(width);
  header.height = static_cast<uint32_t>(height);
  header.color_type = SPNG_COLOR_TYPE_TRUECOLOR_ALPHA;
  header.bit_depth = 8;
  spng_set_ihdr(ctx, &header);
  EXPECT_EQ(spng_encode_image(ctx, rgba.data(), rgba.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE),
            0);
  size_t size = 0;
  int error = 0;
  void* data = spng_get_png_buffer(ctx, &size, &error);
  EXPECT_EQ(error, 0);
  const uint8_t* bytes = static_cast<const uint8_t*>(data);
  std::vector<uint8_t> png(bytes, bytes + size);
  std::free(data);
  spng_ctx_free(ctx);
  return png;
}

std::vector<uint8_t> EncodeWebp(const std::vector<uint8_t>& rgba, int width, int height) {
  uint8_t* data = nullptr;
  const size_t size = WebPEncodeLosslessRGBA(rgba.data(), width, height, 4 * width, &data);
  EXPECT_NE(size, 0u);
  std::vector<uint8_t> webp(data, data + size);
  WebPFree(data);
  return webp;
}

std::vector<uint8_t> EncodeJpeg(const std::vector<uint8_t>& rgba, int width, int height) {
  std::vector<uint8_t> jpeg;
  const auto append = [](void* context, void* data, int size) {
    const uint8_t* bytes = static_cast<const uint8_t*>(data);
    std::vector<uint8_t>* out = static_cast<std::vector<uint8_t>*>(context);
    out->insert(out->end(), bytes, bytes + size);
  };
  EXPECT_NE(stbi_write_jpg_to_func(append, &jpeg, width, height, 4, rgba.data(), 100), 0);
  return jpeg;
}

}  // namespace stillray::test

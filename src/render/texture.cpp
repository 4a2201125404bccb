// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/texture.h"

#include <array>

#include "core/colour.h"
#include "render/texture_shared.h"

namespace stillray::render {
namespace {

using DecodeTable = std::array<float, 256>;

const DecodeTable& TableOf(TexelEncoding encoding) {
  static const std::array<DecodeTable, 2> kTables = [] {
    std::array<DecodeTable, 2> tables{};
    for (int i = 0; i < 256; ++i) {
      const float value = static_cast<float>(i) / 255.0f;
      tables[0][static_cast<size_t>(i)] = value;
      tables[1][static_cast<size_t>(i)] = SrgbDecode(value);
    }
    return tables;
  }();
  return kTables[encoding == TexelEncoding::kSrgb ? 1 : 0];
}

vec4 Decode(const uint8_t* texel, const DecodeTable& rgb) {
  return {rgb[texel[0]], rgb[texel[1]], rgb[texel[2]], static_cast<float>(texel[3]) / 255.0f};
}

static_assert(static_cast<int>(Wrap::kRepeat) == kWrapRepeat &&
              static_cast<int>(Wrap::kMirror) == kWrapMirror &&
              static_cast<int>(Wrap::kClamp) == kWrapClamp);

}  // namespace

vec4 SampleTexture(const Texture& texture, vec2 uv, TexelEncoding encoding) {
  const DecodeTable& rgb = TableOf(encoding);
  const float x = SafeCoordinate(uv.x * static_cast<float>(texture.width));
  const float y = SafeCoordinate(uv.y * static_cast<float>(texture.height));
  const auto column = [&](int i) {
    return WrapTexel(i, texture.width, static_cast<int>(texture.wrap_u));
  };
  const auto row = [&](int i) {
    return WrapTexel(i, texture.height, static_cast<int>(texture.wrap_v));
  };
  const auto texel = [&](int tx, int ty) {
    const size_t offset =
        static_cast<size_t>(ty) * static_cast<size_t>(texture.width) + static_cast<size_t>(tx);
    return Decode(texture.texels.data() + 4 * offset, rgb);
  };
  if (texture.nearest) {
    return texel(column(FloorToInt(x)), row(FloorToInt(y)));
  }
  const int left = FloorToInt(x - 0.5f);
  const int top = FloorToInt(y - 0.5f);
  const float fx = x - 0.5f - static_cast<float>(left);
  const float fy = y - 0.5f - static_cast<float>(top);
  const int x0 = column(left);
  const int x1 = column(left + 1);
  const int y0 = row(top);
  const int y1 = row(top + 1);
  const vec4 upper = texel(x0, y0) * (1.0f - fx) + texel(x1, y0) * fx;
  const vec4 lower = texel(x0, y1) * (1.0f - fx) + texel(x1, y1) * fx;
  return upper * (1.0f - fy) + lower * fy;
}

}  // namespace stillray::render

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/colour_shared.h"
#include "core/parallel.h"
#include "core/random.h"
#include "scene/builtin.h"

namespace stillray {

namespace {

float Hash01(int x, int y, uint32_t seed) {
  return UniformFloat(
      HashCombine(seed, HashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y))));
}

float Smooth(float t) {
  return t * t * (3.0f - 2.0f * t);
}

/// Value noise in 0..1 on a lattice of `nx` x `ny` cells over the unit square, which repeats.
float Noise(float u, float v, int nx, int ny, uint32_t seed) {
  const float x = u * static_cast<float>(nx);
  const float y = v * static_cast<float>(ny);
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = static_cast<int>(std::floor(y));
  const float fx = Smooth(x - static_cast<float>(x0));
  const float fy = Smooth(y - static_cast<float>(y0));
  const auto at = [&](int i, int j) {
    return Hash01((i % nx + nx) % nx, (j % ny + ny) % ny, seed);
  };
  const float top = glm::mix(at(x0, y0), at(x0 + 1, y0), fx);
  const float bottom = glm::mix(at(x0, y0 + 1), at(x0 + 1, y0 + 1), fx);
  return glm::mix(top, bottom, fy);
}

/// 1 well inside a cell, 0 at its edges, over `width` (all in units of the cell).
float InsideCell(float x, float width) {
  const float edge = std::min(x, 1.0f - x);
  return Smooth(std::clamp((edge - 0.5f * width) / width, 0.0f, 1.0f));
}

uint8_t EncodeTexel(float linear_value) {
  const float encoded = SrgbEncode(std::clamp(linear_value, 0.0f, 1.0f));
  return static_cast<uint8_t>(std::lround(encoded * 255.0f));
}

/// Fills a texture with colour(u, v), linear, at the texels' centres.
template <typename Colour>
Texture MakeTexture(const std::string& name, int size, const Colour& colour) {
  Texture texture;
  texture.name = name;
  texture.width = size;
  texture.height = size;
  texture.texels.resize(static_cast<size_t>(size) * static_cast<size_t>(size) * 4);
  constexpr int kBand = 32;
  ParallelRows(size, kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      uint8_t* row = texture.texels.data() + static_cast<size_t>(y) * static_cast<size_t>(size) * 4;
      for (int x = 0; x < size; ++x) {
        const vec3 c = colour((static_cast<float>(x) + 0.5f) / static_cast<float>(size),
                              (static_cast<float>(y) + 0.5f) / static_cast<float>(size));
        row[4 * x] = EncodeTexel(c.x);
        row[4 * x + 1] = EncodeTexel(c.y);
        row[4 * x + 2] = EncodeTexel(c.z);
        row[4 * x + 3] = 255;
      }
    }
  });
  return texture;
}

float Fraction(float x) {
  return x - std::floor(x);
}

}  // namespace

Texture MakePlanks(const std::string& name, int size, int columns, vec3 light, vec3 dark,
                   uint32_t seed) {
  constexpr int kPlanksPerColumn = 2;
  constexpr float kJoint = 0.02f;  // of a plank's width
  return MakeTexture(name, size, [=](float u, float v) {
    const float x = u * static_cast<float>(columns);
    const int column = static_cast<int>(x);
    const float shift = Hash01(column, 7, seed);
    const float y = (v + shift) * kPlanksPerColumn;
    const int plank = static_cast<int>(std::floor(y)) % kPlanksPerColumn;
    const float shade = Hash01(column, plank, seed + 1);
    const float grain = Noise(u, v, columns * 12, 8, seed + 2) * 0.5f +
                        Noise(u, v, columns * 32, 16, seed + 3) * 0.3f +
                        Noise(u, v, columns * 4, 32, seed + 4) * 0.2f;
    const vec3 wood = glm::mix(
        dark, light, std::clamp(0.15f + 0.45f * shade + 0.55f * (grain - 0.25f), 0.0f, 1.0f));
    const float stretch = static_cast<float>(columns) / kPlanksPerColumn;
    const float inside =
        InsideCell(Fraction(x), kJoint) * InsideCell(Fraction(y), kJoint / stretch);
    return glm::mix(0.25f * dark, wood, inside);
  });
}

Texture MakeTiles(const std::string& name, int size, int tiles, vec3 tile, vec3 other, vec3 joint,
                  uint32_t seed) {
  constexpr float kJoint = 0.025f;  // of a tile
  return MakeTexture(name, size, [=](float u, float v) {
    const float x = u * static_cast<float>(tiles);
    const float y = v * static_cast<float>(tiles);
    const int i = static_cast<int>(x);
    const int j = static_cast<int>(y);
    const vec3 base = (i + j) % 2 == 0 ? tile : other;
    const float mottle = 0.6f * Noise(u, v, tiles * 6, tiles * 6, seed) +
                         0.4f * Noise(u, v, tiles * 20, tiles * 20, seed + 1);
    const float shade = 0.8f + 0.2f * Hash01(i, j, seed + 2) + 0.3f * (mottle - 0.5f);
    const float inside = InsideCell(Fraction(x), kJoint) * InsideCell(Fraction(y), kJoint);
    return glm::mix(joint, base * shade, inside);
  });
}

Texture MakeBricks(const std::string& name, int size, int rows, vec3 brick, vec3 mortar,
                   uint32_t seed) {
  constexpr float kJoint = 0.06f;  // of a brick's height
  return MakeTexture(name, size, [=](float u, float v) {
    const float y = v * static_cast<float>(rows);
    const int row = static_cast<int>(y);
    const int per_row = rows / 2;
    const float x = u * static_cast<float>(per_row) + (row % 2 == 0 ? 0.0f : 0.5f);
    const int column = static_cast<int>(x) % per_row;
    const float rough = 0.5f * Noise(u, v, 48, 48, seed) + 0.5f * Noise(u, v, 200, 200, seed + 1);
    const float shade = 0.7f + 0.35f * Hash01(column, row, seed + 2) + 0.3f * (rough - 0.5f);
    const float warm = 0.15f * (Hash01(column, row, seed + 3) - 0.5f);
    const vec3 face = brick * shade * vec3(1.0f + warm, 1.0f, 1.0f - warm);
    const float inside = InsideCell(Fraction(x), 0.5f * kJoint) * InsideCell(Fraction(y), kJoint);
    return glm::mix(mortar * (0.9f + 0.2f * rough), face, inside);
  });
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

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

/// Periodic value noise in 0..1 on a lattice of nx x ny cells over the unit square.
class NoiseLattice {
 public:
  NoiseLattice(int nx, int ny, uint32_t seed) : nx_(nx), ny_(ny) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        values_.push_back(Hash01(i, j, seed));
      }
    }
  }

  /// At u, v in 0..1.
  float operator()(float u, float v) const {
    const float x = u * static_cast<float>(nx_);
    const float y = v * static_cast<float>(ny_);
    const int x0 = std::min(static_cast<int>(x), nx_ - 1);
    const int y0 = std::min(static_cast<int>(y), ny_ - 1);
    const int x1 = (x0 + 1) % nx_;
    const int y1 = (y0 + 1) % ny_;
    const float fx = Smooth(x - static_cast<float>(x0));
    const float fy = Smooth(y - static_cast<float>(y0));
    return glm::mix(glm::mix(At(x0, y0), At(x1, y0), fx), glm::mix(At(x0, y1), At(x1, y1), fx), fy);
  }

 private:
  float At(int i, int j) const { return values_[static_cast<size_t>(j * nx_ + i)]; }
  int nx_;
  int ny_;
  std::vector<float> values_;
};

/// 1 inside a cell, falling to 0 at its edges over `width` (in units of the cell).
float InsideCell(float x, float width) {
  const float edge = std::min(x, 1.0f - x);
  return Smooth(std::clamp((edge - 0.5f * width) / width, 0.0f, 1.0f));
}

/// Lookup table of sRGB codes for linear values 0..1, with steps fine enough for the steepest part
/// of the curve, where one code is 1/3295 wide.
std::vector<uint8_t> MakeEncodeTable() {
  constexpr int kSteps = 8192;
  std::vector<uint8_t> table;
  for (int i = 0; i <= kSteps; ++i) {
    const float encoded = SrgbEncode(static_cast<float>(i) / kSteps);
    table.push_back(static_cast<uint8_t>(std::lround(encoded * 255.0f)));
  }
  return table;
}

/// Fills a texture with colour(u, v), linear, evaluated at the texels' centres.
template <typename Colour>
Texture MakeTexture(const std::string& name, int size, const Colour& colour) {
  Texture texture;
  texture.name = name;
  texture.width = size;
  texture.height = size;
  texture.texels.resize(static_cast<size_t>(size) * static_cast<size_t>(size) * 4);
  const std::vector<uint8_t> codes = MakeEncodeTable();
  const float last = static_cast<float>(codes.size() - 1);
  const auto encode = [&](float value) {
    return codes[static_cast<size_t>(std::clamp(value, 0.0f, 1.0f) * last + 0.5f)];
  };
  constexpr int kBand = 32;
  ParallelRows(size, kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      uint8_t* row = texture.texels.data() + static_cast<size_t>(y) * static_cast<size_t>(size) * 4;
      for (int x = 0; x < size; ++x) {
        const vec3 c = colour((static_cast<float>(x) + 0.5f) / static_cast<float>(size),
                              (static_cast<float>(y) + 0.5f) / static_cast<float>(size));
        row[4 * x] = encode(c.x);
        row[4 * x + 1] = encode(c.y);
        row[4 * x + 2] = encode(c.z);
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
  constexpr float kJoint = 0.02f;  // fraction of a plank's width
  const NoiseLattice broad(columns * 12, 8, seed + 2);
  const NoiseLattice fine(columns * 32, 16, seed + 3);
  const NoiseLattice knots(columns * 4, 32, seed + 4);
  return MakeTexture(name, size, [&](float u, float v) {
    const float x = u * static_cast<float>(columns);
    const int column = static_cast<int>(x);
    const float shift = Hash01(column, 7, seed);
    const float y = (v + shift) * kPlanksPerColumn;
    const int plank = static_cast<int>(std::floor(y)) % kPlanksPerColumn;
    const float shade = Hash01(column, plank, seed + 1);
    const float grain = broad(u, v) * 0.5f + fine(u, v) * 0.3f + knots(u, v) * 0.2f;
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
  constexpr float kJoint = 0.025f;  // fraction of a tile
  const NoiseLattice broad(tiles * 6, tiles * 6, seed);
  const NoiseLattice fine(tiles * 20, tiles * 20, seed + 1);
  return MakeTexture(name, size, [&](float u, float v) {
    const float x = u * static_cast<float>(tiles);
    const float y = v * static_cast<float>(tiles);
    const int i = static_cast<int>(x);
    const int j = static_cast<int>(y);
    const vec3 base = (i + j) % 2 == 0 ? tile : other;
    const float mottle = 0.6f * broad(u, v) + 0.4f * fine(u, v);
    const float shade = 0.8f + 0.2f * Hash01(i, j, seed + 2) + 0.3f * (mottle - 0.5f);
    const float inside = InsideCell(Fraction(x), kJoint) * InsideCell(Fraction(y), kJoint);
    return glm::mix(joint, base * shade, inside);
  });
}

Texture MakeBricks(const std::string& name, int size, int rows, vec3 brick, vec3 mortar,
                   uint32_t seed) {
  constexpr float kJoint = 0.06f;  // fraction of a brick's height
  const NoiseLattice broad(48, 48, seed);
  const NoiseLattice fine(200, 200, seed + 1);
  return MakeTexture(name, size, [&](float u, float v) {
    const float y = v * static_cast<float>(rows);
    const int row = static_cast<int>(y);
    const int per_row = rows / 2;
    const float x = u * static_cast<float>(per_row) + (row % 2 == 0 ? 0.0f : 0.5f);
    const int column = static_cast<int>(x) % per_row;
    const float rough = 0.5f * broad(u, v) + 0.5f * fine(u, v);
    const float shade = 0.7f + 0.35f * Hash01(column, row, seed + 2) + 0.3f * (rough - 0.5f);
    const float warm = 0.15f * (Hash01(column, row, seed + 3) - 0.5f);
    const vec3 face = brick * shade * vec3(1.0f + warm, 1.0f, 1.0f - warm);
    const float inside = InsideCell(Fraction(x), 0.5f * kJoint) * InsideCell(Fraction(y), kJoint);
    return glm::mix(mortar * (0.9f + 0.2f * rough), face, inside);
  });
}

Texture MakeMottled(const std::string& name, int size, int patches, vec3 light, vec3 dark,
                    uint32_t seed) {
  const NoiseLattice broad(patches, patches, seed);
  const NoiseLattice middle(patches * 3, patches * 3, seed + 1);
  const NoiseLattice small(patches * 9, patches * 9, seed + 2);
  const NoiseLattice grain(patches * 40, patches * 40, seed + 3);
  return MakeTexture(name, size, [&](float u, float v) {
    const float patch = 0.5f * broad(u, v) + 0.3f * middle(u, v) + 0.2f * small(u, v);
    const float contrast = Smooth(std::clamp(1.6f * (patch - 0.5f) + 0.5f, 0.0f, 1.0f));
    return glm::mix(dark, light, contrast) * (0.88f + 0.24f * grain(u, v));
  });
}

}  // namespace stillray

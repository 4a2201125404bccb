// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The pyramid of fill_guides, see denoise/fill_guides/pyramid.h: cells of 3x3 pixels, cells of 3x3
// cells, and so on up to a single cell. CELLS_BINDING is its binding in set 1.
#include "denoise/fill_guides/fill_guides_shared.h"

#ifndef CELLS_QUALIFIER
#define CELLS_QUALIFIER
#endif
layout(set = 1, binding = CELLS_BINDING, std430) CELLS_QUALIFIER buffer Cells {
  uvec4 cells[];  // ordered by layer, level, row; mostly floats
};

// Contents of the layers. One per colour of the frame follows.
const int kMotionLayer = 0;   // x, y, -, kinds
const int kSurfaceLayer = 1;  // fraction that is surface, inverse depth, id, kinds
const int kNormalLayer = 2;   // x, y, z
const int kFirstColourLayer = 3;

// Kinds of known pixels that a cell may cover. The motion layer has only kNew.
const uint kAny = 1u;
const uint kOfSurface = 2u;
const uint kOfSky = 4u;
const uint kNew = 8u;

// Colours, by the bits of guide_colours.
const int kEmission = 3;
const int kBackground = 4;
const int kColourCount = 5;

struct Level {
  ivec2 size;
  int start;
};

Level FirstLevel() {
  return Level(ivec2(CellsOf(width), CellsOf(height)), 0);
}
Level Above(Level l) {
  return Level(ivec2(CellsOf(l.size.x), CellsOf(l.size.y)), l.start + l.size.x * l.size.y);
}

bool Covers(Level l, ivec2 p) {
  return p.x < l.size.x && p.y < l.size.y;
}
int PlaceOf(Level l, int layer, ivec2 p) {
  return layer * pyramid_cells + l.start + p.y * l.size.x + p.x;
}
uvec4 LoadCell(Level l, int layer, ivec2 p) {
  return cells[PlaceOf(l, layer, p)];
}
vec3 LoadValue(Level l, int layer, ivec2 p) {
  return uintBitsToFloat(LoadCell(l, layer, p).xyz);
}
void StoreCell(Level l, int layer, ivec2 p, vec3 value, uint other) {
  cells[PlaceOf(l, layer, p)] = uvec4(floatBitsToUint(value), other);
}

bool HasColour(int k) {
  return (guide_colours >> k & 1) != 0;
}
int ColourLayer(int k) {
  return kFirstColourLayer + bitCount(guide_colours & ((1 << k) - 1));
}
uint KindOfColour(int k) {
  return k == kBackground ? kOfSky : kOfSurface;
}

// Mean of the known ones of nine children: first the sum of each column, then of the columns.
struct Mean {
  vec3 column[kPyramidFactor];
  int count;
};
Mean NoMean() {
  return Mean(vec3[](vec3(0.0f), vec3(0.0f), vec3(0.0f)), 0);
}
void Add(inout Mean m, int column, vec3 value) {
  m.column[column] += value;
  ++m.count;
}
vec3 ValueOf(Mean m) {
  const float kInverse[10] = float[](0.0f, 1.0f, 1.0f / 2.0f, 1.0f / 3.0f, 1.0f / 4.0f, 1.0f / 5.0f,
                                     1.0f / 6.0f, 1.0f / 7.0f, 1.0f / 8.0f, 1.0f / 9.0f);
  vec3 sum = m.column[0] + m.column[1] + m.column[2];
  return m.count > 0 ? sum * kInverse[m.count] : vec3(0.0f);
}

// Surface fraction, inverse depth, id and kinds of a cell, from its children.
struct SurfaceMean {
  Mean part;
  Mean inverse_depth;
  uint id;
  uint kinds;
};
SurfaceMean NoSurfaceMean() {
  return SurfaceMean(NoMean(), NoMean(), 0u, 0u);
}
void Add(inout SurfaceMean m, int column, float part, float inverse_depth, uint id, uint kinds) {
  if ((kinds & kAny) != 0u) {
    Add(m.part, column, vec3(part));
  }
  if ((kinds & kOfSurface) != 0u) {
    Add(m.inverse_depth, column, vec3(inverse_depth));
    m.id = (m.kinds & kOfSurface) == 0u ? id : m.id;
  }
  m.kinds |= kinds;
}
void StoreSurface(Level l, ivec2 p, SurfaceMean m) {
  cells[PlaceOf(l, kSurfaceLayer, p)] =
      uvec4(floatBitsToUint(ValueOf(m.part).x), floatBitsToUint(ValueOf(m.inverse_depth).x), m.id,
            m.kinds);
}

float MixFour(vec4 corners, float weight_x, float weight_y) {
  return LerpParents(LerpParents(corners.x, corners.y, weight_y),
                     LerpParents(corners.z, corners.w, weight_y), weight_x);
}

// The level above, interpolated at a pixel of the level below.
vec3 Upsample(Level above, int layer, ivec2 p) {
  ivec2 first = ivec2(FirstParent(p.x), FirstParent(p.y));
  ivec2 q0 = max(first, ivec2(0));
  ivec2 q1 = min(first + 1, above.size - 1);
  vec3 a = LoadValue(above, layer, q0);
  vec3 b = LoadValue(above, layer, ivec2(q0.x, q1.y));
  vec3 c = LoadValue(above, layer, ivec2(q1.x, q0.y));
  vec3 d = LoadValue(above, layer, q1);
  float wx = SecondParentWeight(p.x);
  float wy = SecondParentWeight(p.y);
  return vec3(MixFour(vec4(a.x, b.x, c.x, d.x), wx, wy), MixFour(vec4(a.y, b.y, c.y, d.y), wx, wy),
              MixFour(vec4(a.z, b.z, c.z, d.z), wx, wy));
}

// Surface or sky at a hole of the image, from the first level.
struct Hole {
  bool is_surface;
  float inverse_depth;
};

Hole HoleAt(ivec2 p) {
  vec2 v = Upsample(FirstLevel(), kSurfaceLayer, p).xy;
  return Hole(v.x >= 0.5f && v.y > 0.0f, v.y);
}

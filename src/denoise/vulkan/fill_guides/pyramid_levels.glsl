// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Steps from level to level of the pyramid of fill_guides: up (downsampling) and down (filling).
#include "denoise/vulkan/fill_guides/pyramid.glsl"

layout(push_constant) uniform Push {
  int of_motion;  // 1: motion, 0: all other layers
  int level_width;
  int level_height;
  int level_start;
};

Level PushedLevel() {
  return Level(ivec2(level_width, level_height), level_start);
}

// Whether the pass runs: motion is filled only if held guides are fetched along it.
bool HasWork() {
  return of_motion == 0 || (has_held != 0 && guides_move != 0u);
}

void DownsampleValues(Level below, Level above, ivec2 p, int layer, int kinds_layer, uint kind) {
  Mean mean = NoMean();
  for (int dy = 0; dy < kPyramidFactor; ++dy) {
    for (int dx = 0; dx < kPyramidFactor; ++dx) {
      ivec2 q = p * kPyramidFactor + ivec2(dx, dy);
      if (Covers(below, q) && (LoadCell(below, kinds_layer, q).w & kind) != 0u) {
        Add(mean, dx, LoadValue(below, layer, q));
      }
    }
  }
  StoreCell(above, layer, p, ValueOf(mean), mean.count > 0 ? kind : 0u);
}

void DownsampleSurface(Level below, Level above, ivec2 p) {
  SurfaceMean mean = NoSurfaceMean();
  for (int dy = 0; dy < kPyramidFactor; ++dy) {
    for (int dx = 0; dx < kPyramidFactor; ++dx) {
      ivec2 q = p * kPyramidFactor + ivec2(dx, dy);
      if (Covers(below, q)) {
        uvec4 cell = LoadCell(below, kSurfaceLayer, q);
        Add(mean, dx, uintBitsToFloat(cell.x), uintBitsToFloat(cell.y), cell.z, cell.w);
      }
    }
  }
  StoreSurface(above, p, mean);
}

void DownsampleCell(Level below, Level above, ivec2 p) {
  if (of_motion != 0) {
    DownsampleValues(below, above, p, kMotionLayer, kMotionLayer, kNew);
    return;
  }
  DownsampleSurface(below, above, p);
  DownsampleValues(below, above, p, kNormalLayer, kSurfaceLayer, kOfSurface);
  for (int k = 0; k < kColourCount; ++k) {
    if (HasColour(k)) {
      DownsampleValues(below, above, p, ColourLayer(k), kSurfaceLayer, KindOfColour(k));
    }
  }
}

void FillValues(Level level, Level above, ivec2 p, int layer, int kinds_layer, uint kind) {
  if ((LoadCell(level, kinds_layer, p).w & kind) == 0u) {
    StoreCell(level, layer, p, Upsample(above, layer, p), 0u);
  }
}

void FillSurface(Level level, Level above, ivec2 p) {
  uvec4 cell = LoadCell(level, kSurfaceLayer, p);
  vec3 spread = Upsample(above, kSurfaceLayer, p);
  if ((cell.w & kAny) == 0u) {
    cell.x = floatBitsToUint(spread.x);
  }
  if ((cell.w & kOfSurface) == 0u) {
    cell.y = floatBitsToUint(spread.y);
    cell.z = LoadCell(above, kSurfaceLayer, p / kPyramidFactor).z;
  }
  cells[PlaceOf(level, kSurfaceLayer, p)] = cell;
}

// Fills a hole from the level above; known cells are unchanged.
void FillCell(Level level, Level above, ivec2 p) {
  if (of_motion != 0) {
    FillValues(level, above, p, kMotionLayer, kMotionLayer, kNew);
    return;
  }
  FillSurface(level, above, p);
  FillValues(level, above, p, kNormalLayer, kSurfaceLayer, kOfSurface);
  for (int k = 0; k < kColourCount; ++k) {
    if (HasColour(k)) {
      FillValues(level, above, p, ColourLayer(k), kSurfaceLayer, KindOfColour(k));
    }
  }
}

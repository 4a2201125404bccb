// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Positions of pixels in the last frame, which has another size.
layout(push_constant) uniform Push {
  ivec2 size_before;
};

// The position of a pixel in the last frame, in pixels from the centre of its first pixel.
// \param p pixel of this frame
vec2 PlaceBefore(ivec2 p) {
  return (vec2(p) + 0.5f) * vec2(size_before) / vec2(Size()) - 0.5f;
}
ivec2 ClampBefore(ivec2 q) {
  return clamp(q, ivec2(0), size_before - 1);
}
ivec2 NearestBefore(ivec2 p) {
  return ClampBefore(ivec2(floor(PlaceBefore(p) + 0.5f)));
}

// The four pixels around a position, with their bilinear weights.
struct PixelsBefore {
  ivec2 at[4];
  float weight[4];
};
PixelsBefore AroundBefore(ivec2 p) {
  vec2 place = PlaceBefore(p);
  ivec2 origin = ivec2(floor(place));
  vec2 t = place - vec2(origin);
  PixelsBefore pixels;
  for (int i = 0; i < 4; ++i) {
    ivec2 to = ivec2(i & 1, i >> 1);
    pixels.at[i] = ClampBefore(origin + to);
    pixels.weight[i] = (to.x == 1 ? t.x : 1.0f - t.x) * (to.y == 1 ? t.y : 1.0f - t.y);
  }
  return pixels;
}

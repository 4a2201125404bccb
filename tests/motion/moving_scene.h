// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Guides of a textured wall and a textured box before it, both moving, sampled once per pixel.
#pragma once

#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray {

struct MovingScene {
  int width = 192;
  int height = 120;
  vec2 wall_speed{0.0f};  ///< pixels per frame, right and down
  vec2 box_speed{0.0f};
  float box_turn = 0;  ///< radians per frame
  bool box = true;
  bool textured = true;  ///< the wall
  bool ids = true;
  uint32_t seed = 1;  ///< of the textures: another one is another scene

  Guides At(float frame, vec2 jitter = vec2(0.0f)) const;
  /// Whether a pixel of that frame shows the box.
  bool ShowsBox(int x, int y, float frame) const;
  /// Where the surface of a pixel was one frame ago, relative to it.
  vec2 TrueMotion(int x, int y, float frame) const;
  /// Whether it was in view then.
  bool WasSeen(int x, int y, float frame) const;

 private:
  vec2 InBox(vec2 p, float frame) const;
};

}  // namespace stillray

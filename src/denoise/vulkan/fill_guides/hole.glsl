// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What a hole of the picture shows, from the first level of the pyramid.
struct Guess {
  bool is_surface;
  float inverse_depth;
};

Guess GuessAt(ivec2 p) {
  vec2 spread = Spread(FirstLevel(), kSurfaceLayer, p).xy;
  return Guess(spread.x >= 0.5f && spread.y > 0.0f, spread.y);
}

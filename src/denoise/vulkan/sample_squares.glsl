// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The inputs of the wavelet levels of keep_samples and keep_mirrors.

// Stored radiance has a mean near 1/8; this factor, squared, preserves the precision of its squares
// in half precision.
const float kDifferenceScale = 8.0f;
const float kSquareScale = kDifferenceScale * kDifferenceScale;

// A pixel's squared difference and noise, times kSquareScale. Large values are both reduced by one
// factor: their ratio is unchanged, and ShareOfFiltered limits neighbouring pixels more.
vec4 SampleSquares(float difference2, float noise) {
  vec2 squares = kSquareScale * vec2(difference2, noise);
  squares /= max(1.0f, max(squares.x, squares.y) / kMostLight);
  return vec4(squares, 0.0f, PackDeviation(0.0f, true));
}

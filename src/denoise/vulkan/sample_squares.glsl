// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What the wavelet levels of keep_samples and keep_mirrors average.

// Light has its mean near 1/8; the square of this factor keeps the precision of its squares in
// halves.
const float kDifferenceScale = 8.0f;
const float kSquareScale = kDifferenceScale * kDifferenceScale;

// A pixel's squared difference and noise, in the unit of (kDifferenceScale light)^2. Large ones are
// both reduced: their ratio stays, and ShareOfFiltered limits the pixels around them more.
vec4 SampleSquares(float difference2, float noise) {
  vec2 squares = kSquareScale * vec2(difference2, noise);
  squares /= max(1.0f, max(squares.x, squares.y) / kMostLight);
  return vec4(squares, 0.0f, PackDeviation(0.0f, true));
}

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Motion of frames without motion vectors: estimated from the guides of two frames, and from their
/// cameras if known.
#pragma once

#include <optional>

#include "stillray/frame.h"
#include "stillray/image.h"
#include "stillray/vec.h"

namespace stillray::motion {

struct EstimateInput {
  const Guides* now = nullptr;     ///< with depth and normal
  const Guides* before = nullptr;  ///< of the same size
  /// The motion of static surfaces, from the cameras; empty if these are unknown.
  Image2 camera;
  /// Guides are means over several samples per pixel: edges are antialiased.
  bool antialiased = false;
  /// The jitter of the frames, pixels.
  vec2 jitter{0.0f};
  vec2 jitter_before{0.0f};
};

struct EstimatedMotion {
  /// As Guides::motion. At pixels without a known motion, the most likely motion; without a camera,
  /// given or estimated, it is UnknownMotion there (outside the image).
  Image2 motion;
  /// Confidence in the motion of each pixel, 0 to 1; 0 where it is unknown.
  Image1 confidence;
  /// Fractions of the surface pixels: with motion from matching, with rigid motion of an object,
  /// and without a motion that matches their guides.
  double matched = 0;
  double of_objects = 0;
  double unknown = 0;
  /// Fraction of the surface pixels with motion other than the camera's.
  double estimated() const { return matched + of_objects; }
  /// Without given cameras: whether most of the image moves like a static scene under a moving
  /// camera.
  bool found_camera = false;
};

/// Static surfaces move with the camera: the given camera, else the camera fitted to most of the
/// matched motion. Where guides differ under that motion, and matching finds their previous
/// position, the pixel gets the matched motion; a moving object (by its id) gets a rigid motion if
/// that fits its guides. Elsewhere motion is unknown; without a camera it is unknown everywhere if
/// guides have too little structure. Results do not depend on the number of threads.
EstimatedMotion EstimateMotion(const EstimateInput& input);

/// Bytes that EstimateMotion needs at most besides its input, per pixel.
inline constexpr int kEstimateBytesPerPixel = 260;

}  // namespace stillray::motion

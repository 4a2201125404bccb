// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Motion of frames whose renderer gives none: from the guides of two frames, and from their
/// cameras where those are known.
#pragma once

#include <optional>

#include "stillray/frame.h"
#include "stillray/image.h"
#include "stillray/vec.h"

namespace stillray::motion {

struct EstimateInput {
  const Guides* now = nullptr;     ///< with depth and normal
  const Guides* before = nullptr;  ///< of the same size
  /// The motion of a still scene, from the cameras; empty if they are unknown.
  Image2 camera;
  /// Guides are means over several samples per pixel, and edges are smooth.
  bool antialiased = false;
  /// The jitter of the frames, pixels.
  vec2 jitter{0.0f};
  vec2 jitter_before{0.0f};
};

struct EstimatedMotion {
  /// As Guides::motion. Where it is unknown it is the likeliest; without a camera, known or found,
  /// it leads out of the picture there (UnknownMotion).
  Image2 motion;
  /// 0 to 1: how certain the motion of each pixel is; 0 where it is unknown.
  Image1 confidence;
  /// Parts of the pixels with a surface: with the motion of matching, of an object as a whole, and
  /// without one that explains their guides.
  double matched = 0;
  double of_objects = 0;
  double unknown = 0;
  /// ... with motion that is not the camera's.
  double estimated() const { return matched + of_objects; }
  /// Without cameras: whether most of the picture moves like a still scene before one.
  bool found_camera = false;
};

/// Still surfaces move with the camera: with the given one, else with the one that most of the
/// matched motion reveals. Where guides differ under that motion and matching finds where they
/// were, the pixel moves as matching says; and an object (by its id) that moves by itself moves
/// rigidly if that explains its guides. Where nothing explains them, motion is unknown; without a
/// camera it is unknown everywhere if guides are so plain that they would not show it. The same
/// bits for any number of threads.
EstimatedMotion EstimateMotion(const EstimateInput& input);

/// Bytes that EstimateMotion needs at most besides its input, per pixel.
inline constexpr int kEstimateBytesPerPixel = 260;

}  // namespace stillray::motion

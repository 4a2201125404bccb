// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// An open room with mirrors, traced in double precision: the layers that Cycles would write for
/// it, and what its mirrors show: planar ones from points reflected at their planes, balls from the
/// point of the ball that shows a point of the room to the camera of the previous frame.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "io/seen_guides.h"
#include "stillray/aov.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray {

/// A pinhole camera. The world has x right, y up, z forward where pan and tilt are 0.
struct RoomCamera {
  glm::dvec3 position{0.0, 1.5, -4.0};
  double pan = 0;  ///< radians, to the right
  double tilt = 0;
  double tangent = 0.6;        ///< of half the horizontal field of view
  glm::dvec2 shift{0.0, 0.0};  ///< of the centre of projection in the picture (PicturePoint)

  glm::dvec3 Ray(glm::dvec2 p) const;           ///< world space, view-space z is 1
  glm::dvec3 InCamera(glm::dvec3 point) const;  ///< right, up, forward
  glm::dvec2 Project(glm::dvec3 point) const;
};

/// kRough: half of the pixels see something random, the others what a mirror would show.
enum class RoomSurface : uint8_t { kMatt, kMirror, kPane, kRough };

/// corner + s a + t b, with s and t in 0..1.
struct RoomRectangle {
  glm::dvec3 corner{0.0};
  glm::dvec3 a{0.0};
  glm::dvec3 b{0.0};
  RoomSurface surface = RoomSurface::kMatt;
  glm::dvec3 colour{0.8};
  glm::dvec3 velocity{0.0};  ///< per frame
};

struct RoomBall {
  glm::dvec3 centre{0.0};
  double radius = 1;
  RoomSurface surface = RoomSurface::kMirror;
};

struct Room {
  std::vector<RoomRectangle> rectangles;
  std::vector<RoomBall> balls;
};

/// Floor, four walls and two boards at different depths, without a ceiling.
Room EmptyRoom();
/// With a mirror that shows board, floor, wall and sky, of the colour (0.9, 0.8, 0.7).
Room RoomWithMirror();
/// A board in front of the camera, over a quarter of the picture, that moves.
RoomRectangle MovingBoard();

struct RoomPicture {
  Frame frame;             ///< guides, without light
  io::SeenLayers seen;     ///< as stored
  VirtualGuides expected;  ///< of planar mirrors and panes
  VirtualGuides curved;    ///< of balls; motion is that of reflections
  Plane<uint32_t> what;    ///< RoomSurface of what is hit first, plus 1; 0: sky
};

struct RoomOptions {
  int width = 160;
  int height = 120;
  double clip_start = 0.1;
  bool halves = true;      ///< round all layers to halves
  double outliers = 0.01;  ///< part of the mirrors' pixels that see something random
};

RoomPicture Trace(const Room& room, const RoomCamera& now, const RoomCamera& before,
                  const RoomOptions& options = {});

/// The camera's matrices for pictures of this size, in the standard's convention.
CameraMatrices MatricesOf(const RoomCamera& camera, int width, int height);
/// The same as programs write them whose cameras look along -z, with y up and from -1 to 1.
CameraMatrices MatricesOfOpenGl(const RoomCamera& camera, int width, int height);

/// Rounds to the 11 bits of a half.
float RoundToHalf(double value);
glm::dvec2 PointOfPixel(int width, int height, int x, int y);

}  // namespace stillray

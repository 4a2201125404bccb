// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A shot for tests of `stillray denoise` with known true light: a wall under noisy light in a
/// pattern, past which the camera moves, in files with Blender's layers.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "stillray/io.h"

namespace stillray {

struct Shot {
  static constexpr int kWidth = 48;
  static constexpr int kHeight = 24;
  static constexpr float kColour = 0.5f;

  int speed = 1;          ///< pixels per frame by which the wall goes to the left
  bool noisy = true;      ///< one sample per pixel, else the true light
  float contrast = 0.8f;  ///< of the pattern of light
  bool forward = true;    ///< Vector.ZW beside Vector.XY
  float depth = 4;        ///< of the wall
  float colour = kColour;
  int normal_axis = 2;
};

/// The true light that the wall gets at column u of its own.
inline float TrueLight(const Shot& shot, int u) {
  return 1.0f + shot.contrast * std::sin(0.9f * static_cast<float>(u));
}

/// 0..1, the same for the same arguments.
inline float ShotNoise(int x, int y, int64_t frame) {
  uint32_t h = static_cast<uint32_t>(x) * 73856093u ^ static_cast<uint32_t>(y) * 19349663u ^
               static_cast<uint32_t>(frame) * 83492791u;
  h = (h ^ (h >> 13)) * 1274126177u;
  return static_cast<float>((h ^ (h >> 16)) & 0xffff) / 65535.0f;
}

inline Image1 ConstantPlane(float value) {
  Image1 plane(Shot::kWidth, Shot::kHeight);
  plane.Fill(value);
  return plane;
}
inline Image3 ConstantImage(float x, float y, float z) {
  Image3 image;
  image[0] = ConstantPlane(x);
  image[1] = ConstantPlane(y);
  image[2] = ConstantPlane(z);
  return image;
}

inline ExrImage ShotFrame(const Shot& shot, int64_t frame) {
  ExrImage image;
  image.width = Shot::kWidth;
  image.height = Shot::kHeight;
  Image3 light(Shot::kWidth, Shot::kHeight);
  Image3 combined(Shot::kWidth, Shot::kHeight);
  for (int y = 0; y < Shot::kHeight; ++y) {
    for (int x = 0; x < Shot::kWidth; ++x) {
      const float truth = TrueLight(shot, x + shot.speed * static_cast<int>(frame));
      const float noise = shot.noisy ? 2 * ShotNoise(x, y, frame) : 1.0f;
      for (int c = 0; c < 3; ++c) {
        light[c](x, y) = truth * noise;
        combined[c](x, y) = light[c](x, y) * shot.colour;
      }
    }
  }
  const float speed = static_cast<float>(shot.speed);
  image.Add("ViewLayer.Combined.", PixelType::kFloat, combined);
  image.Add("ViewLayer.DiffDir.", PixelType::kFloat, light);
  image.Add("ViewLayer.DiffInd.", PixelType::kFloat, ConstantImage(0, 0, 0));
  image.Add("ViewLayer.DiffCol.", PixelType::kFloat,
            ConstantImage(shot.colour, shot.colour, shot.colour));
  Image3 normal = ConstantImage(0, 0, 0);
  normal[shot.normal_axis].Fill(1);
  image.Add("ViewLayer.Normal.", PixelType::kFloat, normal, true);
  image.Add("ViewLayer.Depth.Z", PixelType::kFloat, ConstantPlane(shot.depth));
  image.Add("ViewLayer.Vector.X", PixelType::kFloat, ConstantPlane(speed));
  image.Add("ViewLayer.Vector.Y", PixelType::kFloat, ConstantPlane(0));
  if (shot.forward) {
    image.Add("ViewLayer.Vector.Z", PixelType::kFloat, ConstantPlane(speed));
    image.Add("ViewLayer.Vector.W", PixelType::kFloat, ConstantPlane(0));
  }
  return image;
}

inline void WriteShot(const std::string& pattern, const Shot& shot, int64_t first, int64_t last) {
  for (int64_t frame = first; frame <= last; ++frame) {
    const Status written = WriteExr(FrameFileName(pattern, frame), ShotFrame(shot, frame));
    ASSERT_TRUE(written.ok()) << written.message();
  }
}

/// Mean squared difference of a written frame from the true picture, where the wall was in view in
/// all of the last `margin` frames and is in the next ones.
inline double ShotError(const std::string& pattern, const Shot& shot, int64_t frame,
                        int margin = 0) {
  const Result<ExrImage> image = ReadExr(FrameFileName(pattern, frame));
  if (!image.ok()) {
    ADD_FAILURE() << image.status().message();
    return 1e9;
  }
  const Image1& green = image->Find("ViewLayer.Combined.G")->values;
  double sum = 0;
  int count = 0;
  for (int y = 0; y < Shot::kHeight; ++y) {
    for (int x = margin; x < Shot::kWidth - margin; ++x, ++count) {
      const double truth =
          double{shot.colour} * TrueLight(shot, x + shot.speed * static_cast<int>(frame));
      sum += (green(x, y) - truth) * (green(x, y) - truth);
    }
  }
  return sum / count;
}

}  // namespace stillray

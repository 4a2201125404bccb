// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Normals in camera space, made of planes whose normals are known.
#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "doctor/sequences.h"
#include "stillray/vec.h"

namespace stillray::camera_space_test {
namespace {

using Names = std::set<std::string>;

/// A room seen by a camera in its middle that turns about the vertical axis: five walls, y upwards,
/// two units in each direction.
struct Room {
  int width = 192;
  int height = 108;
  float focal = 130;

  vec3 Ray(int x, int y) const {
    return glm::normalize(vec3((static_cast<float>(x) + 0.5f - 0.5f * width) / focal,
                               (0.5f * height - static_cast<float>(y) - 0.5f) / focal, -1.0f));
  }
};

mat3 Turned(float angle) {
  const float c = std::cos(angle);
  const float s = std::sin(angle);
  return mat3(c, 0, -s, 0, 1, 0, s, 0, c);  // columns: camera axes in the world
}

enum class Space { kWorld, kCamera };

NumberedImage MakeFrame(int number, float angle, float previous_angle, Space space) {
  const Room room;
  const mat3 to_world = Turned(angle);
  const mat3 previous = Turned(previous_angle);
  ExrImage image;
  image.width = room.width;
  image.height = room.height;
  Image3 colour(room.width, room.height);
  Image3 normal(room.width, room.height);
  Image3 albedo(room.width, room.height);
  Image1 depth(room.width, room.height);
  Image2 motion(room.width, room.height);
  for (int y = 0; y < room.height; ++y) {
    for (int x = 0; x < room.width; ++x) {
      const vec3 ray = room.Ray(x, y);
      const vec3 d = to_world * ray;
      // The wall that is hit first.
      int axis = 0;
      float distance = 1e9f;
      for (int i = 0; i < 3; ++i) {
        const float wall = 2.0f / std::max(std::fabs(d[i]), 1e-9f);
        if (wall < distance) {
          distance = wall;
          axis = i;
        }
      }
      vec3 n(0.0f);
      n[axis] = d[axis] > 0 ? -1.0f : 1.0f;
      const vec3 hit = distance * d;
      const vec3 before = glm::transpose(previous) * hit;
      motion[0](x, y) = room.focal * before.x / -before.z + 0.5f * room.width - 0.5f - x;
      motion[1](x, y) = -room.focal * before.y / -before.z + 0.5f * room.height - 0.5f - y;
      depth(x, y) = distance * -ray.z;
      const vec3 stored = space == Space::kCamera ? glm::transpose(to_world) * n : n;
      // Tiles, so that there is something to follow.
      const int tile = static_cast<int>(std::floor(3 * hit.x + 0.01f)) +
                       static_cast<int>(std::floor(3 * hit.y + 0.01f)) +
                       static_cast<int>(std::floor(3 * hit.z + 0.01f));
      for (int c = 0; c < 3; ++c) {
        normal[c](x, y) = stored[c];
        albedo[c](x, y) = (tile & 1) != 0 ? 0.7f : 0.2f;
        const float noise = 1 + 0.9f * NoiseAt(x, y, number, c);
        colour[c](x, y) = albedo[c](x, y) * noise * noise;
      }
    }
  }
  image.Add("", PixelType::kFloat, colour);
  image.Add("direct_diffuse.", PixelType::kFloat, colour);
  image.Add("motion.X", PixelType::kFloat, motion[0]);
  image.Add("motion.Y", PixelType::kFloat, motion[1]);
  image.Add("depth.Z", PixelType::kFloat, depth);
  image.Add("normal.", PixelType::kHalf, normal, true);
  image.Add("albedo.", PixelType::kHalf, albedo);
  return {number, std::move(image)};
}

/// \param start, step  angles of the camera, radians
Sequence MakeSequence(float start, float step, Space space) {
  Sequence sequence;
  for (int i = 0; i < 4; ++i) {
    const float angle = start + step * static_cast<float>(i);
    sequence.push_back(MakeFrame(i + 1, angle, i == 0 ? angle : angle - step, space));
  }
  return sequence;
}

TEST(CameraSpace, WorldNormalsOfATurningCameraAreClean) {
  EXPECT_EQ(FindingsOf(MakeSequence(0.4f, 0.02f, Space::kWorld)), Names());
}

// At the angle zero both spaces are one: such a camera may stand or turn.
TEST(CameraSpace, WorldNormalsNearTheWorldsAxesAreClean) {
  EXPECT_EQ(FindingsOf(MakeSequence(-0.02f, 0.01f, Space::kWorld)), Names());
}

TEST(CameraSpace, NormalsThatTurnWithTheCameraAreNamed) {
  const DoctorReport report = ReportOf(MakeSequence(0.4f, 0.02f, Space::kCamera));
  ASSERT_EQ(report.findings.size(), 1u);
  EXPECT_EQ(report.findings[0].name, "normal_camera_space");
  EXPECT_EQ(
      FindingsOf(MakeSequence(0.4f, 0.02f, Space::kCamera), {"auto", {report.findings[0].aov}}),
      Names());
}

// The spaces are equivalent under a static camera, so nothing is reported.
TEST(CameraSpace, ACameraThatStandsIsClean) {
  EXPECT_EQ(FindingsOf(MakeSequence(0.4f, 0, Space::kCamera)), Names());
}

// Without perspective z itself is linear on flat surfaces, as 1 / z is with it: no fault.
TEST(Orthographic, LinearDepthIsClean) {
  Sequence sequence = MakeSequence(0.4f, 0.0f, Space::kWorld);
  for (NumberedImage& frame : sequence) {
    for (int y = 0; y < frame.image.height; ++y) {
      const bool ground = y >= 30;
      for (int x = 0; x < frame.image.width; ++x) {
        const auto set = [&](const char* name, float v) {
          ChannelOf(frame.image, name).values(x, y) = v;
        };
        set("depth.Z", ground ? 14 - 0.1f * static_cast<float>(y) : 11);
        set("normal.X", 0);
        set("normal.Y", ground ? 1 : 0);
        set("normal.Z", ground ? 0 : 1);
      }
    }
  }
  EXPECT_EQ(FindingsOf(sequence), Names());
}

}  // namespace
}  // namespace stillray::camera_space_test

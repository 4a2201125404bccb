// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Motion of static surfaces under a moving camera, from the camera's matrices.
#include "core/cameras.h"

#include <cmath>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "core/parallel.h"

namespace stillray {
namespace {

/// The stored matrices are for row vectors; the transpose is for column vectors.
glm::dmat4 ForColumns(const std::array<double, 16>& m) {
  glm::dmat4 result;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      result[i][j] = m[static_cast<size_t>(4 * i + j)];
    }
  }
  return result;
}

/// The inverse of ForColumns.
std::array<double, 16> ForRows(const glm::dmat4& matrix) {
  std::array<double, 16> entries{};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      entries[static_cast<size_t>(4 * i + j)] = matrix[i][j];
    }
  }
  return entries;
}

/// The projection from camera space to pixels.
struct Projection {
  glm::dmat4 matrix;      ///< camera space to device coordinates
  double z_sign = 1;      ///< sign of z in front of the camera
  glm::dvec2 scale{1.0};  ///< pixels = device * scale + offset
  glm::dvec2 offset{0.0};
};

glm::dvec2 Device(const glm::dmat4& matrix, const glm::dvec4& point) {
  const glm::dvec4 p = matrix * point;
  return glm::dvec2(p) / p.w;
}

/// OpenEXR defines coordinates 0 to 1 from the upper left corner and a camera that looks along +z.
/// Renderers also write -1 to 1 with y up, and cameras that look along -z. The viewing axis, which
/// projects near the image centre, distinguishes these conventions.
Projection Understand(const glm::dmat4& matrix, bool is_standard, int width, int height) {
  Projection p;
  p.matrix = matrix;
  // Without perspective the sign is that of the depth row.
  const double along = matrix[2][3] != 0 ? matrix[2][3] : matrix[2][2];
  p.z_sign = along < 0 ? -1.0 : 1.0;
  const glm::dvec2 middle = Device(matrix, {0, 0, p.z_sign, 1});
  const glm::dvec2 above = Device(matrix, {0, 1, p.z_sign, 1});
  const glm::dvec2 from_half = glm::abs(middle - glm::dvec2(0.5));
  const bool from_corner =
      is_standard || from_half.x + from_half.y <= std::abs(middle.x) + std::abs(middle.y);
  p.scale = glm::dvec2(width, height) * (from_corner ? 1.0 : 0.5);
  p.offset = from_corner ? glm::dvec2(0.0) : 0.5 * glm::dvec2(width, height);
  if (!is_standard && above.y > middle.y) {  // y up
    p.scale.y = -p.scale.y;
    p.offset.y = height - p.offset.y;
  }
  return p;
}

/// The point in camera space at depth z that projects to these device coordinates.
glm::dvec4 Unproject(const Projection& p, const glm::dvec2& device, double z) {
  const glm::dmat4& m = p.matrix;
  // Row r of the matrix minus `device[r]` times its last row must yield zero.
  const auto entry = [&](int r, int column) { return m[column][r] - device[r] * m[column][3]; };
  const double a = entry(0, 0);
  const double b = entry(0, 1);
  const double c = entry(1, 0);
  const double d = entry(1, 1);
  const double e = -(entry(0, 2) * z + entry(0, 3));
  const double f = -(entry(1, 2) * z + entry(1, 3));
  const double determinant = a * d - b * c;
  return {(e * d - b * f) / determinant, (a * f - e * c) / determinant, z, 1};
}

glm::dmat4 CameraToDevice(const CameraMatrices& camera) {
  return ForColumns(camera.world_to_ndc) * glm::inverse(ForColumns(camera.world_to_camera));
}

/// Whether w depends only on the distance along the viewing axis.
bool DividesByDepth(const glm::dmat4& to_device) {
  constexpr double kRounding = 1e-6;
  const double by_depth = kRounding * std::abs(to_device[2][3]);
  return by_depth > 0 && std::abs(to_device[0][3]) < by_depth &&
         std::abs(to_device[1][3]) < by_depth && std::abs(to_device[3][3]) < by_depth;
}

/// Rows x, y and w.
glm::dmat4x3 WithoutZ(const glm::dmat4& m) {
  glm::dmat4x3 rows(0.0);
  for (int column = 0; column < 4; ++column) {
    rows[column] = {m[column][0], m[column][1], m[column][3]};
  }
  return rows;
}

/// From device coordinates to the positions of CameraMotion.
glm::dmat3 ToPicture(const Projection& p, int width, int height) {
  const double unit = 2.0 / width;
  glm::dmat3 m(1.0);
  m[0][0] = unit * p.scale.x;
  m[1][1] = unit * p.scale.y;
  m[2][0] = unit * (p.offset.x - 0.5 * width);
  m[2][1] = unit * (p.offset.y - 0.5 * height);
  return m;
}

}  // namespace

vec2 PicturePoint(int width, int height, float x, float y) {
  const float scale = 2.0f / static_cast<float>(width);
  return {(x - 0.5f * static_cast<float>(width)) * scale,
          (y - 0.5f * static_cast<float>(height)) * scale};
}

vec2 PixelPoint(const Image1& plane, int x, int y) {
  return PicturePoint(plane.width(), plane.height(), static_cast<float>(x) + 0.5f,
                      static_cast<float>(y) + 0.5f);
}

vec2 CameraMotion::MotionOf(vec2 p, double z, int width) const {
  const glm::dvec3 moved = map * glm::dvec4(glm::dvec2(p), 1.0, depth_unit / z);
  const glm::dvec2 before = glm::dvec2(moved) / moved.z;
  return vec2((before - glm::dvec2(p)) * (0.5 * width));
}

bool HasInverse(const CameraMatrices& camera) {
  return glm::determinant(ForColumns(camera.world_to_camera)) != 0;
}

bool HasPerspective(const CameraMatrices& camera, int width, int height) {
  return width > 0 && height > 0 && DividesByDepth(CameraToDevice(camera));
}

std::optional<glm::dmat4> FromPicture(const CameraMatrices& camera, int width, int height) {
  if (!HasPerspective(camera, width, height)) {
    return std::nullopt;
  }
  const glm::dmat4 to_device = CameraToDevice(camera);
  const Projection here = Understand(to_device, camera.is_standard, width, height);
  // The rows x, y and w of a projection map the point P at depth z to w (d, 1), for the device
  // coordinates d, and w is f z. So P / z is the inverse of these rows and of (0, 0, 0, 1), times
  // (f d, f, 1 / z).
  const double f = std::abs(to_device[2][3]);
  const glm::dmat3 to_device_here = f * glm::inverse(ToPicture(here, width, height));
  const glm::dmat4x3 rows = WithoutZ(to_device);
  glm::dmat4 projection(0.0);
  glm::dmat4 from_picture(0.0);
  for (int column = 0; column < 4; ++column) {
    projection[column] = glm::dvec4(rows[column], column == 3 ? 1.0 : 0.0);
    from_picture[column] =
        column == 3 ? glm::dvec4(0.0, 0.0, 0.0, 1.0) : glm::dvec4(to_device_here[column], 0.0);
  }
  const glm::dmat4 inverse = glm::inverse(projection) * from_picture;
  const double determinant = glm::determinant(inverse);
  return std::isfinite(determinant) && determinant != 0 ? std::optional<glm::dmat4>(inverse)
                                                        : std::nullopt;
}

std::optional<CameraMotion> MotionOfCamera(const CameraMatrices& now, const CameraMatrices& before,
                                           int width, int height) {
  const std::optional<glm::dmat4> from_picture = FromPicture(now, width, height);
  if (!from_picture || !HasPerspective(before, width, height)) {
    return std::nullopt;
  }
  const Projection there = Understand(CameraToDevice(before), before.is_standard, width, height);
  const glm::dmat4 to_world = glm::inverse(ForColumns(now.world_to_camera));
  const glm::dmat4x3 to_other = WithoutZ(ForColumns(before.world_to_ndc) * to_world);
  CameraMotion motion;
  motion.map = ToPicture(there, width, height) * to_other * *from_picture;
  const double determinant = glm::determinant(
      glm::dmat3(glm::dvec3(motion.map[0]), glm::dvec3(motion.map[1]), glm::dvec3(motion.map[2])));
  return std::isfinite(determinant) && determinant != 0 ? std::optional<CameraMotion>(motion)
                                                        : std::nullopt;
}

CameraMatrices MatricesOf(const std::array<double, 16>& world_to_camera,
                          const std::array<double, 16>& projection) {
  const glm::dmat4 to_camera = glm::transpose(ForColumns(world_to_camera));
  const glm::dmat4 to_clip = glm::transpose(ForColumns(projection));
  // From clip space to OpenEXR's coordinates, 0 to 1 from the upper left corner.
  const bool y_down = to_clip[1][1] < 0;
  glm::dmat4 to_standard(1.0);
  to_standard[0][0] = 0.5;
  to_standard[3][0] = 0.5;
  to_standard[1][1] = y_down ? 0.5 : -0.5;
  to_standard[3][1] = 0.5;
  return {ForRows(to_camera), ForRows(to_standard * to_clip * to_camera), true};
}

double FocalPixels(const CameraMatrices& camera, int width, int height) {
  const glm::dmat4 to_device = CameraToDevice(camera);
  const Projection p = Understand(to_device, camera.is_standard, width, height);
  if (std::abs(to_device[2][3]) < 1e-9) {
    return 0;
  }
  // Projects a point one unit up at a distance of one unit.
  const glm::dvec2 middle = Device(p.matrix, {0, 0, p.z_sign, 1});
  const glm::dvec2 above = Device(p.matrix, {0, 1, p.z_sign, 1});
  const double pixels = std::abs((above.y - middle.y) * p.scale.y);
  return std::isfinite(pixels) ? pixels : 0;
}

double CentredFocalPixels(const CameraMatrices& camera, int width, int height) {
  constexpr double kTolerance = 0.02;
  const double focal = FocalPixels(camera, width, height);
  if (!(focal > 0)) {
    return 0;
  }
  const glm::dmat4 to_device = CameraToDevice(camera);
  const Projection p = Understand(to_device, camera.is_standard, width, height);
  const auto pixel = [&](double x, double y) {
    return Device(p.matrix, {x, y, p.z_sign, 1}) * p.scale + p.offset;
  };
  const glm::dvec2 axis = pixel(0, 0);
  const glm::dvec2 shift = glm::abs(axis - 0.5 * glm::dvec2(width, height));
  const double across = std::abs(pixel(1, 0).x - axis.x);
  const bool centred = shift.x + shift.y <= kTolerance * width;
  return centred && std::abs(across - focal) <= kTolerance * focal ? focal : 0;
}

Image2 MotionFromCameras(const Image1& depth, const CameraMatrices& now,
                         const CameraMatrices& other) {
  const int width = depth.width();
  const int height = depth.height();
  const glm::dmat4 to_world = glm::inverse(ForColumns(now.world_to_camera));
  const Projection here =
      Understand(ForColumns(now.world_to_ndc) * to_world, now.is_standard, width, height);
  const Projection there =
      Understand(ForColumns(other.world_to_ndc) * glm::inverse(ForColumns(other.world_to_camera)),
                 other.is_standard, width, height);
  const glm::dmat4 to_other = ForColumns(other.world_to_ndc) * to_world;
  Image2 motion(width, height);
  ParallelRows(height, kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < width; ++x) {
        const double z = depth(x, y);
        if (!std::isfinite(z)) {
          continue;  // no surface, so no history
        }
        const glm::dvec2 pixel(x + 0.5, y + 0.5);
        const glm::dvec4 point =
            Unproject(here, (pixel - here.offset) / here.scale, here.z_sign * z);
        const glm::dvec4 seen = to_other * point;
        const glm::dvec2 moved = glm::dvec2(seen) / seen.w * there.scale + there.offset - pixel;
        // Behind the other camera, or invalid matrices: outside the image.
        constexpr double kFar = 1e6;
        const bool in_front = seen.w > 0 && std::fabs(moved.x) < kFar && std::fabs(moved.y) < kFar;
        motion[0](x, y) = in_front ? static_cast<float>(moved.x) : 2.0f * static_cast<float>(width);
        motion[1](x, y) =
            in_front ? static_cast<float>(moved.y) : 2.0f * static_cast<float>(height);
      }
    }
  });
  return motion;
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/lens.h"

#include <algorithm>
#include <cmath>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "core/colour.h"
#include "render/cumulative_sums.h"

namespace stillray::render {
namespace {

/// Half the longer side of the 36 mm x 24 mm sensor of a full-frame camera, in metres.
constexpr float kHalfSensor = 0.018f;

double TexelBrightness(const Texture& mask, size_t texel) {
  const uint8_t* rgba = mask.texels.data() + 4 * texel;
  const auto decoded = [&](int c) { return SrgbDecode(static_cast<float>(rgba[c]) / 255.0f); };
  return static_cast<double>(Luminance709(decoded(0), decoded(1), decoded(2))) * rgba[3] / 255.0;
}

LensMask MakeMask(const Texture& texture, int index) {
  LensMask mask;
  mask.texture = index;
  mask.width = texture.width;
  mask.height = texture.height;
  const auto width = static_cast<size_t>(texture.width);
  const auto height = static_cast<size_t>(texture.height);
  mask.sums.resize(height + 1 + height * (width + 1));
  std::vector<double> rows(height + 1, 0.0);
  std::vector<double> columns(width + 1, 0.0);
  for (size_t y = 0; y < height; ++y) {
    for (size_t x = 0; x < width; ++x) {
      columns[x + 1] = columns[x] + TexelBrightness(texture, y * width + x);
    }
    rows[y + 1] = rows[y] + columns.back();
    NormaliseSums(columns, mask.sums.data() + height + 1 + y * (width + 1));
  }
  NormaliseSums(rows, mask.sums.data());
  return mask;
}

/// Moeller and Trumbore (1997), "Fast, Minimum Storage Ray/Triangle Intersection", in double
/// precision. Hit::instance is unchanged.
bool MeetTriangle(const glm::dvec3& origin, const glm::dvec3& direction, const Mesh& mesh,
                  const vec3* positions, uint32_t primitive, Hit* hit) {
  const uint32_t* corner = mesh.indices.data() + 3 * static_cast<size_t>(primitive);
  const glm::dvec3 p0(positions[corner[0]]);
  const glm::dvec3 e1 = glm::dvec3(positions[corner[1]]) - p0;
  const glm::dvec3 e2 = glm::dvec3(positions[corner[2]]) - p0;
  const glm::dvec3 across = glm::cross(direction, e2);
  const double determinant = glm::dot(e1, across);
  if (determinant == 0.0) {
    return false;
  }
  const glm::dvec3 offset = origin - p0;
  const double u = glm::dot(offset, across) / determinant;
  const glm::dvec3 around = glm::cross(offset, e1);
  const double v = glm::dot(direction, around) / determinant;
  const double t = glm::dot(e2, around) / determinant;
  if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0)) {
    return false;
  }
  hit->t = static_cast<float>(t);
  hit->u = static_cast<float>(u);
  hit->v = static_cast<float>(v);
  hit->primitive = primitive;
  return true;
}

/// Distance to the nearest surface of an instance along a world-space ray. Tests all triangles: a
/// single ray needs no BVH, and Vulkan renderers have no host BVH.
float NearestOf(const SceneState& state, uint32_t instance, const mat4& world,
                const vec3* positions, vec3 origin, vec3 direction) {
  constexpr uint32_t kTriangles = 4096;  // triangles per task
  const Mesh& mesh = *state.instance(instance).mesh;
  const glm::dmat4 exact(world);
  if (glm::determinant(glm::dmat3(exact)) == 0.0) {
    return kInfinity;
  }
  const glm::dmat4 to_mesh = glm::inverse(exact);
  const glm::dvec3 o(to_mesh * glm::dvec4(glm::dvec3(origin), 1.0));
  const glm::dvec3 d(to_mesh * glm::dvec4(glm::dvec3(direction), 0.0));
  return tbb::parallel_reduce(
      tbb::blocked_range<uint32_t>(0, static_cast<uint32_t>(mesh.indices.size() / 3), kTriangles),
      kInfinity,
      [&](const tbb::blocked_range<uint32_t>& range, float nearest) {
        Hit hit;
        hit.instance = instance;
        for (uint32_t i = range.begin(); i < range.end(); ++i) {
          if (MeetTriangle(o, d, mesh, positions, i, &hit) && hit.t < nearest &&
              state.Opacity(hit) >= 0.5f) {
            nearest = hit.t;
          }
        }
        return nearest;
      },
      [](float a, float b) { return std::min(a, b); });
}

}  // namespace

double MaskBrightness(const Texture& mask) {
  const size_t count = static_cast<size_t>(mask.width) * static_cast<size_t>(mask.height);
  double sum = 0;
  for (size_t i = 0; i < count; ++i) {
    sum += TexelBrightness(mask, i);
  }
  return sum / static_cast<double>(count);
}

LensMasks::LensMasks(const Scene& scene) {
  for (const Camera& camera : scene.cameras) {
    const int texture = camera.lens.mask;
    if (texture >= 0 && Find(texture) == nullptr) {
      masks_.push_back(MakeMask(scene.textures[static_cast<size_t>(texture)], texture));
    }
  }
}

const LensMask* LensMasks::Find(int texture) const {
  const auto found = std::find_if(masks_.begin(), masks_.end(),
                                  [&](const LensMask& mask) { return mask.texture == texture; });
  return found == masks_.end() ? nullptr : &*found;
}

Lens LensOf(const Scene& scene, const RenderSettings& settings, int camera) {
  Lens lens;
  if (camera >= 0 && static_cast<size_t>(camera) < scene.cameras.size()) {
    lens = scene.cameras[static_cast<size_t>(camera)].lens;
  }
  if (settings.aperture || settings.f_number) {
    lens.radius = settings.aperture.value_or(0.0f);
    lens.f_number = settings.f_number.value_or(0.0f);
  }
  lens.focus = settings.focus.value_or(lens.focus);
  if (settings.blades) {
    lens.blades = *settings.blades;
    lens.mask = -1;
  }
  lens.rotation = settings.blade_rotation.value_or(lens.rotation);
  return lens;
}

bool MayHaveLens(const Scene& scene, const RenderSettings& settings) {
  for (size_t i = 0; i <= scene.cameras.size(); ++i) {  // the last index: no camera of the scene
    const Lens lens = LensOf(scene, settings, static_cast<int>(i));
    if (lens.radius > 0.0f || lens.f_number > 0.0f) {
      return true;
    }
  }
  return false;
}

float LensRadius(const Lens& lens, const CameraView& view) {
  if (!(lens.f_number > 0.0f)) {
    return lens.radius;
  }
  const float focal_length = kHalfSensor / std::max(view.half_width, view.half_height);
  return 0.5f * focal_length / lens.f_number;
}

float FindFocus(const SceneState& state, const CameraView& view, bool previous) {
  float nearest = kInfinity;
  for (uint32_t i = 0; i < state.instances().size(); ++i) {
    const PlacedInstance& instance = state.instance(i);
    const mat4& world = previous ? instance.previous_world : instance.world;
    const VertexArrays& vertices = previous ? instance.previous_vertices : instance.vertices;
    nearest = std::min(nearest,
                       NearestOf(state, i, world, vertices.positions, view.position, view.forward));
  }
  return nearest;
}

LensArrays MakeLensArrays(const Lens& lens, const LensMasks& masks) {
  LensArrays arrays{};
  arrays.blades = lens.blades;
  const float turns = lens.rotation / 360.0f;
  arrays.rotation = min(turns - std::floor(turns), kBelowOne);
  if (const LensMask* mask = masks.Find(lens.mask); mask != nullptr) {
    arrays.mask_width = mask->width;
    arrays.mask_height = mask->height;
    arrays.sums = mask->sums.data();
  }
  return arrays;
}

}  // namespace stillray::render

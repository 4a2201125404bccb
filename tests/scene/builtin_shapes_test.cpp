// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "scene/builtin.h"

namespace stillray::builtin_shapes_test {
namespace {

float Volume(const Mesh& mesh) {
  double volume = 0;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const vec3 a = mesh.positions[mesh.indices[i]];
    const vec3 b = mesh.positions[mesh.indices[i + 1]];
    const vec3 c = mesh.positions[mesh.indices[i + 2]];
    volume += static_cast<double>(glm::dot(a, glm::cross(b, c))) / 6.0;
  }
  return static_cast<float>(volume);
}

TEST(Lathe, AConeHasItsVolumeAndNormals) {
  const Mesh cone = MakeLathe({{1.0f, 0.0f}, {0.0f, 2.0f}}, 256, vec2(1.0f), 0);
  // The base is open, and it lies in a plane through the origin: it adds no volume.
  EXPECT_NEAR(Volume(cone), 3.14159265f * 2.0f / 3.0f, 2e-3f);
  for (const vec3& normal : cone.normals) {
    EXPECT_NEAR(normal.y, 1.0f / std::sqrt(5.0f), 1e-5f);
  }
}

TEST(Lathe, CornersAreRoundedUpToForty) {
  // 30 degrees at y = 1, 60 degrees more at y = 2.
  const vec2 up(0.0f, 1.0f);
  const vec2 tilted(-0.5f, std::sqrt(0.75f));
  const vec2 inward(-1.0f, 0.0f);
  const vec2 p0(2.0f, 0.0f);
  const std::vector<vec2> curve = {p0, p0 + up, p0 + up + tilted, p0 + up + tilted + 0.5f * inward};
  const Mesh mesh = MakeLathe(curve, 8, vec2(1.0f), 0);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const float y = mesh.positions[i].y;
    if (std::abs(y - 1.0f) < 1e-5f) {
      EXPECT_NEAR(mesh.normals[i].y, std::sin(0.2617994f), 1e-5f) << "the mean of both sides";
    } else if (y > 1.5f) {
      const float n = mesh.normals[i].y;
      EXPECT_TRUE(std::abs(n - 0.5f) < 1e-5f || std::abs(n - 1.0f) < 1e-5f) << n;
    }
  }
}

TEST(Isosurface, ASphereIsExactClosedAndOutward) {
  Aabb bounds;
  bounds.min = vec3(-1.3f);
  bounds.max = vec3(1.35f);
  const vec3 centre(0.02f, -0.03f, 0.05f);
  const Mesh mesh = MakeIsosurface(
      bounds, 0.05f, [&](vec3 p) { return glm::length(p - centre) - 1.0f; }, 3);
  EXPECT_EQ(mesh.material, 3);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const vec3 from_centre = mesh.positions[i] - centre;
    ASSERT_NEAR(glm::length(from_centre), 1.0f, 1e-4f);
    ASSERT_GT(glm::dot(glm::normalize(from_centre), mesh.normals[i]), 0.9999f);
  }
  // Inscribed: less than the sphere's by the square of the cells.
  EXPECT_NEAR(Volume(mesh), 4.0f / 3.0f * 3.14159265f, 0.01f);
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    for (size_t c = 0; c < 3; ++c) {
      ++edges[{mesh.indices[i + c], mesh.indices[i + (c + 1) % 3]}];
    }
  }
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_EQ(edges.count({edge.second, edge.first}), 1u)
        << "every edge has a triangle on both sides";
  }
}

TEST(Isosurface, EdgesOfABoxGetNormalsOfTheirOwn) {
  Aabb bounds;
  bounds.min = vec3(-0.7f);
  bounds.max = vec3(0.7f);
  const Mesh mesh = MakeIsosurface(
      bounds, 0.053f,
      [](vec3 p) {
        return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) - 0.5f;
      },
      0);
  EXPECT_NEAR(Volume(mesh), 1.0f, 0.02f);
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const uint32_t* c = &mesh.indices[i];
    const vec3 face = glm::normalize(glm::cross(mesh.positions[c[1]] - mesh.positions[c[0]],
                                                mesh.positions[c[2]] - mesh.positions[c[0]]));
    for (int corner = 0; corner < 3; ++corner) {
      ASSERT_GT(glm::dot(face, mesh.normals[c[corner]]), 0.9f);
    }
  }
}

TEST(Isosurface, BlocksFarAwayLoseNothing) {
  // A distance that is twice too large, as it may be: small spheres far apart.
  Aabb bounds;
  bounds.min = vec3(-1.0f);
  bounds.max = vec3(1.0f);
  const auto spheres = [](vec3 p) {
    return 2.0f * std::min(glm::length(p - vec3(0.8f)), glm::length(p + vec3(0.8f))) - 0.2f;
  };
  const Mesh mesh = MakeIsosurface(bounds, 0.02f, spheres, 0);
  EXPECT_NEAR(Volume(mesh), 2.0f * 4.0f / 3.0f * 3.14159265f * 1e-3f, 2e-4f);
}

}  // namespace
}  // namespace stillray::builtin_shapes_test

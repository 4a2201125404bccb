// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/mesh_tools.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::mesh_tools_test {
namespace {

using ::testing::ElementsAre;

/// The unit square in the plane z = 0, facing +z, with v running down as in glTF.
Mesh Square() {
  Mesh mesh;
  mesh.positions = {vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 1, 0), vec3(0, 1, 0)};
  mesh.normals.assign(4, vec3(0, 0, 1));
  mesh.uv[0] = {vec2(0, 1), vec2(1, 1), vec2(1, 0), vec2(0, 0)};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

TEST(CompactIndices, KeepsTheOrderOfVertices) {
  std::vector<uint32_t> indices = {7, 2, 9, 2, 7, 4};
  EXPECT_THAT(CompactIndices(10, &indices), ElementsAre(2, 4, 7, 9));
  EXPECT_THAT(indices, ElementsAre(2, 0, 3, 0, 2, 1));
}

TEST(CompactIndices, SparseUseOfAHugeArrayGivesTheSame) {
  std::vector<uint32_t> indices = {7, 2, 9, 2, 7, 4};
  EXPECT_THAT(CompactIndices(1000000, &indices), ElementsAre(2, 4, 7, 9));
  EXPECT_THAT(indices, ElementsAre(2, 0, 3, 0, 2, 1));
}

TEST(ComputeTangents, AnUprightPictureHasPlainTangents) {
  Mesh mesh = Square();
  ComputeTangents(TextureRef(), &mesh);
  // u grows along +x; cross(normal, tangent) = +y is up in the picture, so w = 1.
  EXPECT_THAT(mesh.tangents,
              ElementsAre(vec4(1, 0, 0, 1), vec4(1, 0, 0, 1), vec4(1, 0, 0, 1), vec4(1, 0, 0, 1)));
}

TEST(ComputeTangents, AMirroredPictureHasTheOtherHand) {
  Mesh mesh = Square();
  for (vec2& uv : mesh.uv[0]) {
    uv.x = 1.0f - uv.x;
  }
  ComputeTangents(TextureRef(), &mesh);
  for (const vec4& tangent : mesh.tangents) {
    EXPECT_EQ(tangent, vec4(-1, 0, 0, -1));
  }
}

TEST(ComputeTangents, FollowsTheTextureTransform) {
  Mesh mesh = Square();
  TextureRef ref;
  // (u, v) -> (v, -u): the picture's u runs along the mesh's v, which points to -y.
  ref.transform = mat3(vec3(0, -1, 0), vec3(1, 0, 0), vec3(0, 0, 1));
  ComputeTangents(ref, &mesh);
  for (const vec4& tangent : mesh.tangents) {
    EXPECT_EQ(tangent, vec4(0, -1, 0, 1));
  }
}

TEST(ComputeTangents, IsOrthogonalToBentNormals) {
  Mesh mesh = Square();
  for (size_t i = 0; i < 4; ++i) {
    mesh.normals[i] =
        glm::normalize(vec3(mesh.positions[i].x - 0.5f, 0.3f * mesh.positions[i].y, 1));
  }
  ComputeTangents(TextureRef(), &mesh);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(glm::dot(vec3(mesh.tangents[i]), mesh.normals[i]), 0.0f, 1e-6f);
    EXPECT_NEAR(glm::length(vec3(mesh.tangents[i])), 1.0f, 1e-6f);
    EXPECT_GT(mesh.tangents[i].x, 0.8f);
  }
}

TEST(ComputeTangents, VerticesBetweenMirroredHalvesAreSplit) {
  // Two squares side by side; u runs towards the shared edge from both sides.
  Mesh mesh;
  mesh.positions = {vec3(0, 0, 0), vec3(1, 0, 0), vec3(2, 0, 0),
                    vec3(0, 1, 0), vec3(1, 1, 0), vec3(2, 1, 0)};
  mesh.normals.assign(6, vec3(0, 0, 1));
  mesh.uv[0] = {vec2(0, 1), vec2(1, 1), vec2(0, 1), vec2(0, 0), vec2(1, 0), vec2(0, 0)};
  mesh.indices = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4};
  ComputeTangents(TextureRef(), &mesh);
  EXPECT_EQ(mesh.positions.size(), 8u);
  EXPECT_EQ(mesh.uv[0].size(), 8u);
  for (size_t i = 0; i < mesh.indices.size(); ++i) {
    const bool left = i < 6;
    EXPECT_EQ(mesh.tangents[mesh.indices[i]], left ? vec4(1, 0, 0, 1) : vec4(-1, 0, 0, -1))
        << "corner " << i;
  }
}

TEST(ComputeTangents, WithoutCoordinatesAnyDirectionInThePlaneWillDo) {
  Mesh mesh = Square();
  mesh.uv[0].clear();
  ComputeTangents(TextureRef(), &mesh);
  for (const vec4& tangent : mesh.tangents) {
    EXPECT_NEAR(glm::length(vec3(tangent)), 1.0f, 1e-6f);
    EXPECT_EQ(tangent.z, 0.0f);
  }
}

TEST(NormalizeNormals, WhereNormalsCancelOneOfThemIsTaken) {
  // Both sides of one triangle.
  Mesh mesh;
  mesh.positions = {vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0)};
  mesh.normals.assign(3, vec3(0.0f));
  mesh.indices = {0, 1, 2, 0, 2, 1};
  EXPECT_EQ(NormalizeNormals(&mesh), 3u);
  EXPECT_EQ(mesh.normals[0], vec3(0, 0, -1));
}

TEST(RemoveBadTriangles, KeepsVeryThinOnes) {
  const std::vector<vec3> positions = {vec3(0, 0, 0), vec3(1, 0, 0), vec3(0.5f, 1e-30f, 0)};
  std::vector<uint32_t> indices = {0, 1, 2};
  const BadTriangles bad = RemoveBadTriangles(positions, &indices);
  EXPECT_EQ(bad.no_area, 0u);
  EXPECT_EQ(indices.size(), 3u);
}

}  // namespace
}  // namespace stillray::mesh_tools_test

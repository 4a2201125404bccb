// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Prepares triangle meshes of files for rendering.
#pragma once

#include <cstdint>
#include <vector>

#include "stillray/scene.h"

namespace stillray {

/// Largest magnitude of a position's component: beyond it ray tracing has no precision left, and
/// products of differences overflow.
inline constexpr float kMaxCoordinate = 1e18f;

/// Whether no component of a transform to the world is NaN, infinite or beyond kMaxCoordinate.
bool IsTraceable(const mat4& world);

/// Renumbers `indices` to the vertices in use, in their old order.
/// \param vertex_count  all indices are below it
/// \return old number of every new vertex
std::vector<uint32_t> CompactIndices(size_t vertex_count, std::vector<uint32_t>* indices);

/// Why no ray can hit a triangle.
enum class TriangleFault : uint8_t {
  kNone,
  kNotFinite,  ///< a position is NaN, infinite or beyond kMaxCoordinate
  kNoArea
};
TriangleFault FaultOf(const std::vector<vec3>& positions, const uint32_t* corners);

struct BadTriangles {
  size_t not_finite = 0;  ///< a position is NaN, infinite or beyond kMaxCoordinate
  size_t no_area = 0;
};
/// Removes triangles that no ray can hit.
/// \param deforms  those without area may get one, and stay
BadTriangles RemoveBadTriangles(const std::vector<vec3>& positions, std::vector<uint32_t>* indices,
                                bool deforms = false);

/// Flat normals; no two triangles may share a vertex.
void ComputeFlatNormals(Mesh* mesh);

/// Normalises all normals. Zero or invalid normals are replaced by the area-weighted mean of their
/// triangles' normals.
/// \return number of replaced normals
size_t NormalizeNormals(Mesh* mesh);

/// Computes tangents for a normal map, as glTF 2.0 (3.7.2.1) requires when a file has none: per
/// corner the direction of increasing u in the plane of the vertex normal, averaged over the
/// corners of a vertex weighted by their angles, made orthogonal to the normal; w so that
/// cross(normal, tangent) * w points to decreasing v (up in the picture). Vertices at which
/// mirrored and unmirrored triangles meet are split. Without usable texture coordinates any
/// direction in the plane is chosen.
/// Departs from MikkTSpace in not splitting vertices by connectivity.
/// \param map  the normal map's use: coordinate set and transform
void ComputeTangents(const TextureRef& map, Mesh* mesh);

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Prepares imported triangle meshes for rendering.
#pragma once

#include <cstdint>
#include <vector>

#include "stillray/scene.h"

namespace stillray {

/// Maximum magnitude of a position's component: beyond it ray tracing has no precision, and
/// products of differences overflow.
inline constexpr float kMaxCoordinate = 1e18f;

/// Whether all components of an object-to-world transform are finite and within kMaxCoordinate.
bool IsTraceable(const mat4& world);

/// Renumbers `indices` to the used vertices, preserving their order.
/// \param vertex_count  all indices are below it
/// \return old index of every new vertex
std::vector<uint32_t> CompactIndices(size_t vertex_count, std::vector<uint32_t>* indices);

/// The reason why no ray can hit a triangle.
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
/// \param deforms  the mesh deforms: triangles without area are kept, since deformation may give
///     them one
BadTriangles RemoveBadTriangles(const std::vector<vec3>& positions, std::vector<uint32_t>* indices,
                                bool deforms = false);

/// Computes flat normals; no two triangles may share a vertex.
void ComputeFlatNormals(Mesh* mesh);

/// Normalises all normals. Zero or invalid normals are replaced by the area-weighted mean of their
/// triangles' normals.
/// \return number of replaced normals
size_t NormalizeNormals(Mesh* mesh);

/// Computes tangents for a normal map, as glTF 2.0 (3.7.2.1) requires if the file has none: per
/// corner the direction of increasing u in the plane of the vertex normal, averaged over the
/// corners of a vertex with their angles as weights, and orthogonalised to the normal; w is the
/// sign for which cross(normal, tangent) * w points to decreasing v (up in the texture). Vertices
/// shared by mirrored and unmirrored triangles are split. Without usable texture coordinates the
/// tangent is an arbitrary direction in the plane. Departs from MikkTSpace in not splitting
/// vertices by connectivity.
/// \param map  reference to the normal map: coordinate set and transform
void ComputeTangents(const TextureRef& map, Mesh* mesh);

}  // namespace stillray

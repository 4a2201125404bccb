// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/mesh_tools.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/vec3.hpp>

namespace stillray {

namespace {

using glm::dvec3;

constexpr uint32_t kUnused = std::numeric_limits<uint32_t>::max();

/// Normal of a triangle, with twice its area as length. In double precision, since the edges of
/// thin triangles differ by less than the resolution of float.
dvec3 AreaNormal(const std::vector<vec3>& positions, const uint32_t* corners) {
  const dvec3 a = positions[corners[0]];
  const dvec3 b = positions[corners[1]];
  const dvec3 c = positions[corners[2]];
  return glm::cross(b - a, c - a);
}

bool IsPoint(vec3 p) {
  return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
         std::abs(p.z) <= kMaxCoordinate;
}

/// `v` with length 1; zero if `v` is zero or not finite.
dvec3 Unit(dvec3 v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0) || !std::isfinite(largest)) {
    return dvec3(0.0);
  }
  v /= largest;
  return v / std::sqrt(glm::dot(v, v));
}

bool IsZero(dvec3 v) {
  return v.x == 0 && v.y == 0 && v.z == 0;
}

/// `v` normalised; up if `v` is zero, as for triangles without area in deforming meshes.
dvec3 UnitOrUp(dvec3 v) {
  const dvec3 unit = Unit(v);
  return IsZero(unit) ? dvec3(0.0, 1.0, 0.0) : unit;
}

dvec3 AnyPerpendicular(dvec3 n) {
  const dvec3 axis = std::abs(n.x) < 0.5 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  return Unit(glm::cross(n, axis));
}

/// Tangents of the corners of one vertex, summed separately by handedness.
struct TangentSums {
  std::array<dvec3, 2> sum = {dvec3(0.0), dvec3(0.0)};
  std::array<bool, 2> used = {false, false};
};

struct CornerTangent {
  int hand = -1;  ///< 0: w = 1, 1: w = -1, -1: degenerate texture coordinates
  dvec3 weighted = dvec3(0.0);
};

/// Direction of increasing u over a triangle (any length) and the sign of its uv area with v up;
/// sign 0 if the texture coordinates span no area.
dvec3 TriangleTangent(const Mesh& mesh, const std::vector<vec2>& uv, const uint32_t* corners,
                      double* sign) {
  const dvec3 e1 = dvec3(mesh.positions[corners[1]]) - dvec3(mesh.positions[corners[0]]);
  const dvec3 e2 = dvec3(mesh.positions[corners[2]]) - dvec3(mesh.positions[corners[0]]);
  const vec2 a = uv[corners[0]];
  const vec2 b = uv[corners[1]];
  const vec2 c = uv[corners[2]];
  const double u1 = static_cast<double>(b.x) - a.x;
  const double u2 = static_cast<double>(c.x) - a.x;
  const double v1 = static_cast<double>(a.y) - b.y;
  const double v2 = static_cast<double>(a.y) - c.y;
  const double area = u1 * v2 - u2 * v1;
  *sign = area > 0 ? 1 : area < 0 ? -1 : 0;
  return (e1 * v2 - e2 * v1) * *sign;
}

CornerTangent TangentOfCorner(const Mesh& mesh, const uint32_t* corners, int corner,
                              dvec3 direction, double sign) {
  const dvec3 n = mesh.normals[corners[corner]];
  const dvec3 p = mesh.positions[corners[corner]];
  const dvec3 next = Unit(dvec3(mesh.positions[corners[(corner + 1) % 3]]) - p);
  const dvec3 last = Unit(dvec3(mesh.positions[corners[(corner + 2) % 3]]) - p);
  const dvec3 tangent = Unit(direction - n * glm::dot(n, direction));
  if (IsZero(tangent)) {
    return {};
  }
  const double facing = glm::dot(n, glm::cross(next, last)) < 0 ? -1 : 1;
  const double angle = std::acos(std::clamp(glm::dot(next, last), -1.0, 1.0));
  return {sign * facing > 0 ? 0 : 1, tangent * angle};
}

void AppendVertexCopy(Mesh* mesh, uint32_t vertex) {
  mesh->positions.push_back(vec3(mesh->positions[vertex]));
  mesh->normals.push_back(vec3(mesh->normals[vertex]));
  for (std::vector<vec2>& uv : mesh->uv) {
    if (!uv.empty()) {
      uv.push_back(vec2(uv[vertex]));
    }
  }
  if (!mesh->colors.empty()) {
    mesh->colors.push_back(vec4(mesh->colors[vertex]));
  }
  for (size_t k = 0; k < static_cast<size_t>(mesh->influences); ++k) {
    const size_t from = vertex * static_cast<size_t>(mesh->influences) + k;
    mesh->joints.push_back(uint16_t{mesh->joints[from]});
    mesh->weights.push_back(float{mesh->weights[from]});
  }
  const auto copy = static_cast<uint32_t>(mesh->positions.size()) - 1;
  for (MorphTarget& target : mesh->targets) {
    const auto at = std::lower_bound(target.vertices.begin(), target.vertices.end(), vertex);
    if (at == target.vertices.end() || *at != vertex) {
      continue;
    }
    const auto from = static_cast<size_t>(at - target.vertices.begin());
    target.vertices.push_back(copy);
    for (std::vector<vec3>* deltas : {&target.positions, &target.normals, &target.tangents}) {
      if (!deltas->empty()) {
        deltas->push_back(vec3((*deltas)[from]));
      }
    }
  }
}

std::vector<vec2> TransformedUvs(const TextureRef& map, const Mesh& mesh) {
  const std::vector<vec2>& source = mesh.uv[map.uv_set];
  std::vector<vec2> uv(mesh.positions.size(), vec2(0.0f));
  for (size_t i = 0; i < source.size(); ++i) {
    uv[i] = vec2(map.transform * vec3(source[i], 1.0f));
  }
  return uv;
}

}  // namespace

bool IsTraceable(const mat4& world) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!(std::abs(world[column][row]) <= kMaxCoordinate)) {
        return false;
      }
    }
  }
  return true;
}

std::vector<uint32_t> CompactIndices(size_t vertex_count, std::vector<uint32_t>* indices) {
  std::vector<uint32_t> used;
  // Primitives may use few vertices of a huge shared array.
  if (vertex_count / 4 > indices->size()) {
    used = *indices;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (uint32_t& index : *indices) {
      index =
          static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), index) - used.begin());
    }
    return used;
  }
  std::vector<uint32_t> renumbered(vertex_count, kUnused);
  for (const uint32_t index : *indices) {
    renumbered[index] = 0;
  }
  for (size_t i = 0; i < vertex_count; ++i) {
    if (renumbered[i] != kUnused) {
      renumbered[i] = static_cast<uint32_t>(used.size());
      used.push_back(static_cast<uint32_t>(i));
    }
  }
  for (uint32_t& index : *indices) {
    index = renumbered[index];
  }
  return used;
}

TriangleFault FaultOf(const std::vector<vec3>& positions, const uint32_t* corners) {
  if (!IsPoint(positions[corners[0]]) || !IsPoint(positions[corners[1]]) ||
      !IsPoint(positions[corners[2]])) {
    return TriangleFault::kNotFinite;
  }
  return IsZero(AreaNormal(positions, corners)) ? TriangleFault::kNoArea : TriangleFault::kNone;
}

BadTriangles RemoveBadTriangles(const std::vector<vec3>& positions, std::vector<uint32_t>* indices,
                                bool deforms) {
  BadTriangles bad;
  size_t kept = 0;
  for (size_t i = 0; i + 2 < indices->size(); i += 3) {
    const uint32_t* corners = indices->data() + i;
    TriangleFault fault = FaultOf(positions, corners);
    if (deforms && fault == TriangleFault::kNoArea) {
      fault = TriangleFault::kNone;
    }
    bad.not_finite += fault == TriangleFault::kNotFinite ? 1 : 0;
    bad.no_area += fault == TriangleFault::kNoArea ? 1 : 0;
    if (fault == TriangleFault::kNone) {
      std::copy_n(corners, 3, indices->data() + kept);
      kept += 3;
    }
  }
  indices->resize(kept);
  return bad;
}

void ComputeFlatNormals(Mesh* mesh) {
  mesh->normals.assign(mesh->positions.size(), vec3(0.0f));
  for (size_t i = 0; i + 2 < mesh->indices.size(); i += 3) {
    const vec3 normal(UnitOrUp(AreaNormal(mesh->positions, &mesh->indices[i])));
    for (size_t corner = 0; corner < 3; ++corner) {
      mesh->normals[mesh->indices[i + corner]] = normal;
    }
  }
}

size_t NormalizeNormals(Mesh* mesh) {
  constexpr double kShortest = 1e-6;
  std::vector<uint32_t> missing;
  for (size_t i = 0; i < mesh->normals.size(); ++i) {
    const dvec3 normal = mesh->normals[i];
    const double length2 = glm::dot(normal, normal);
    if (!(length2 > kShortest * kShortest) || !std::isfinite(length2)) {
      missing.push_back(static_cast<uint32_t>(i));
    } else {
      mesh->normals[i] = vec3(Unit(normal));
    }
  }
  if (missing.empty()) {
    return 0;
  }
  std::vector<dvec3> sums(mesh->positions.size(), dvec3(0.0));
  std::vector<dvec3> any(mesh->positions.size(), dvec3(0.0));
  for (size_t i = 0; i + 2 < mesh->indices.size(); i += 3) {
    const dvec3 normal = AreaNormal(mesh->positions, &mesh->indices[i]);
    for (size_t corner = 0; corner < 3; ++corner) {
      sums[mesh->indices[i + corner]] += normal;
      any[mesh->indices[i + corner]] = normal;
    }
  }
  for (const uint32_t i : missing) {
    dvec3 normal = Unit(sums[i]);
    if (IsZero(normal)) {
      normal = UnitOrUp(any[i]);  // the normals of adjacent triangles cancel out
    }
    mesh->normals[i] = vec3(normal);
  }
  return missing.size();
}

void ComputeTangents(const TextureRef& map, Mesh* mesh) {
  const std::vector<vec2> uv = TransformedUvs(map, *mesh);
  std::vector<TangentSums> sums(mesh->positions.size());
  std::vector<int8_t> hands(mesh->indices.size(), -1);
  for (size_t i = 0; i + 2 < mesh->indices.size(); i += 3) {
    double sign = 0;
    const dvec3 direction = TriangleTangent(*mesh, uv, &mesh->indices[i], &sign);
    for (int corner = 0; corner < 3 && sign != 0; ++corner) {
      const CornerTangent tangent =
          TangentOfCorner(*mesh, &mesh->indices[i], corner, direction, sign);
      if (tangent.hand >= 0) {
        TangentSums& vertex = sums[mesh->indices[i + static_cast<size_t>(corner)]];
        vertex.sum[static_cast<size_t>(tangent.hand)] += tangent.weighted;
        vertex.used[static_cast<size_t>(tangent.hand)] = true;
        hands[i + static_cast<size_t>(corner)] = static_cast<int8_t>(tangent.hand);
      }
    }
  }
  mesh->tangents.resize(mesh->positions.size());
  std::vector<uint32_t> mirrored_copy(mesh->positions.size(), kUnused);
  const auto finish = [&](size_t vertex, dvec3 sum, float hand) {
    const dvec3 n = mesh->normals[vertex];
    const dvec3 tangent = Unit(sum - n * glm::dot(n, sum));
    mesh->tangents[vertex] = vec4(vec3(IsZero(tangent) ? AnyPerpendicular(n) : tangent), hand);
  };
  for (size_t i = 0; i < sums.size(); ++i) {
    const bool mirrored_only = sums[i].used[1] && !sums[i].used[0];
    finish(i, sums[i].sum[mirrored_only ? 1 : 0], mirrored_only ? -1.0f : 1.0f);
    if (sums[i].used[0] && sums[i].used[1]) {
      mirrored_copy[i] = static_cast<uint32_t>(mesh->positions.size());
      AppendVertexCopy(mesh, static_cast<uint32_t>(i));
      mesh->tangents.emplace_back();
      finish(mirrored_copy[i], sums[i].sum[1], -1.0f);
    }
  }
  for (size_t i = 0; i < mesh->indices.size(); ++i) {
    if (hands[i] == 1 && mirrored_copy[mesh->indices[i]] != kUnused) {
      mesh->indices[i] = mirrored_copy[mesh->indices[i]];
    }
  }
}

}  // namespace stillray

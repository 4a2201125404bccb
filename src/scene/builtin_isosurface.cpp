// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Surface nets (Gibson 1998): one vertex in every cell that intersects the surface, one
/// quadrilateral per grid edge that crosses it. The vertices are then projected onto the surface.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/parallel.h"
#include "scene/builtin.h"

namespace stillray {

namespace {

using Distance = std::function<float(vec3)>;

constexpr uint32_t kNoVertex = std::numeric_limits<uint32_t>::max();

/// Samples at the corners of nx x ny x nz cells.
struct Grid {
  vec3 origin;
  float cell = 0.0f;
  int nx = 0;
  int ny = 0;
  int nz = 0;
  std::vector<float> values;

  size_t At(int x, int y, int z) const {
    return (static_cast<size_t>(z) * static_cast<size_t>(ny + 1) + static_cast<size_t>(y)) *
               static_cast<size_t>(nx + 1) +
           static_cast<size_t>(x);
  }
  vec3 Point(int x, int y, int z) const {
    return origin +
           cell * vec3(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
  }
};

/// Recursively fills a block of samples; blocks that cannot contain the surface get the value at
/// their centre.
void FillBlock(const Distance& distance, int x0, int y0, int z0, int side, Grid* grid) {
  if (x0 > grid->nx || y0 > grid->ny || z0 > grid->nz) {
    return;
  }
  if (side == 1) {
    grid->values[grid->At(x0, y0, z0)] = distance(grid->Point(x0, y0, z0));
    return;
  }
  const float half = 0.5f * static_cast<float>(side) * grid->cell;
  const float centre = distance(grid->Point(x0, y0, z0) + vec3(half));
  constexpr float kDiagonal = 1.7321f;
  constexpr float kDistanceError = 2.0f;
  if (std::abs(centre) <= kDistanceError * kDiagonal * half) {
    const int step = side / 2;
    for (int i = 0; i < 8; ++i) {
      FillBlock(distance, x0 + step * (i & 1), y0 + step * (i >> 1 & 1), z0 + step * (i >> 2), step,
                grid);
    }
    return;
  }
  const int x1 = std::min(x0 + side, grid->nx + 1);
  for (int z = z0; z < std::min(z0 + side, grid->nz + 1); ++z) {
    for (int y = y0; y < std::min(y0 + side, grid->ny + 1); ++y) {
      std::fill(&grid->values[grid->At(x0, y, z)], &grid->values[grid->At(x1 - 1, y, z)] + 1,
                centre);
    }
  }
}

Grid Sample(const Aabb& bounds, float cell, const Distance& distance) {
  constexpr int kBlock = 8;
  const vec3 cells = (bounds.max - bounds.min) / cell;
  Grid grid;
  grid.origin = bounds.min;
  grid.cell = cell;
  grid.nx = static_cast<int>(std::ceil(cells.x));
  grid.ny = static_cast<int>(std::ceil(cells.y));
  grid.nz = static_cast<int>(std::ceil(cells.z));
  grid.values.resize(grid.At(grid.nx, grid.ny, grid.nz) + 1);
  ParallelRows(grid.nz + 1, kBlock, [&](int z0, int /*z1*/) {
    for (int y0 = 0; y0 <= grid.ny; y0 += kBlock) {
      for (int x0 = 0; x0 <= grid.nx; x0 += kBlock) {
        FillBlock(distance, x0, y0, z0, kBlock, &grid);
      }
    }
  });
  return grid;
}

/// The mean of the points at which the surface crosses the edges of a cell; false if none does.
bool CrossingOf(const Grid& grid, int x, int y, int z, vec3* mean) {
  std::array<float, 8> corner{};
  int inside = 0;
  for (int i = 0; i < 8; ++i) {
    corner[static_cast<size_t>(i)] =
        grid.values[grid.At(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2 & 1))];
    inside += corner[static_cast<size_t>(i)] < 0.0f ? 1 : 0;
  }
  if (inside == 0 || inside == 8) {
    return false;
  }
  vec3 sum(0.0f);
  float count = 0.0f;
  for (int i = 0; i < 8; ++i) {
    for (const int axis : {1, 2, 4}) {
      const float a = corner[static_cast<size_t>(i)];
      const float b = corner[static_cast<size_t>(i | axis)];
      if ((i & axis) == 0 && (a < 0.0f) != (b < 0.0f)) {
        const vec3 p(static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1),
                     static_cast<float>(i >> 2 & 1));
        const vec3 step(axis == 1 ? 1.0f : 0.0f, axis == 2 ? 1.0f : 0.0f, axis == 4 ? 1.0f : 0.0f);
        sum += p + step * (a / (a - b));
        count += 1.0f;
      }
    }
  }
  *mean = grid.Point(x, y, z) + grid.cell * sum / count;
  return true;
}

vec3 Gradient(const Distance& distance, vec3 p, float step) {
  const vec3 x(step, 0.0f, 0.0f);
  const vec3 y(0.0f, step, 0.0f);
  const vec3 z(0.0f, 0.0f, step);
  return vec3(distance(p + x) - distance(p - x), distance(p + y) - distance(p - y),
              distance(p + z) - distance(p - z)) /
         (2.0f * step);
}

/// Projects a vertex onto the surface by Newton steps, by at most half a cell so that triangles do
/// not fold.
void MoveToSurface(const Distance& distance, float cell, vec3* position, vec3* normal) {
  constexpr int kSteps = 2;
  const vec3 start = *position;
  vec3 p = start;
  for (int i = 0; i < kSteps; ++i) {
    const vec3 gradient = Gradient(distance, p, 0.25f * cell);
    p -= gradient * (distance(p) / std::max(glm::dot(gradient, gradient), 1e-6f));
    p = glm::clamp(p, start - 0.5f * cell, start + 0.5f * cell);
  }
  *position = p;
  *normal = glm::normalize(Gradient(distance, p, 0.5f * cell));
}

void AddTriangle(Mesh* mesh, uint32_t a, uint32_t b, uint32_t c) {
  const vec3 side =
      glm::cross(mesh->positions[b] - mesh->positions[a], mesh->positions[c] - mesh->positions[a]);
  if (glm::length(side) > 0.0f) {
    mesh->indices.insert(mesh->indices.end(), {a, b, c});
  }
}

/// Adds a quadrilateral, split along the shorter diagonal.
void AddQuad(Mesh* mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  const auto length = [&](uint32_t p, uint32_t q) {
    return glm::length(mesh->positions[p] - mesh->positions[q]);
  };
  if (length(a, c) < length(b, d)) {
    AddTriangle(mesh, a, b, c);
    AddTriangle(mesh, a, c, d);
  } else {
    AddTriangle(mesh, b, c, d);
    AddTriangle(mesh, b, d, a);
  }
}

/// Adds a quadrilateral per crossed edge, between the four cells around the edge.
void AddQuads(const Grid& grid, const std::vector<uint32_t>& vertex, Mesh* mesh) {
  for (int z = 1; z < grid.nz; ++z) {
    for (int y = 1; y < grid.ny; ++y) {
      for (int x = 1; x < grid.nx; ++x) {
        const bool inside = grid.values[grid.At(x, y, z)] < 0.0f;
        for (int axis = 0; axis < 3; ++axis) {
          const std::array<int, 3> next = {x + (axis == 0), y + (axis == 1), z + (axis == 2)};
          if (inside == (grid.values[grid.At(next[0], next[1], next[2])] < 0.0f)) {
            continue;
          }
          // The two other axes, such that their cross product is this one.
          const auto cell = [&](int back_u, int back_v) {
            const int u = (axis + 1) % 3;
            const int v = (axis + 2) % 3;
            std::array<int, 3> at = {x, y, z};
            at[static_cast<size_t>(u)] -= back_u;
            at[static_cast<size_t>(v)] -= back_v;
            return vertex[grid.At(at[0], at[1], at[2])];
          };
          if (inside) {
            AddQuad(mesh, cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0));
          } else {
            AddQuad(mesh, cell(1, 0), cell(0, 0), cell(0, 1), cell(1, 1));
          }
        }
      }
    }
  }
}

/// Triangles that deviate too far from their vertex normals, at edges sharper than the grid
/// resolution, get separate vertices with the triangle's normal.
void FlattenSharpTriangles(Mesh* mesh) {
  constexpr float kCosOfSharp = 0.91f;
  for (size_t i = 0; i < mesh->indices.size(); i += 3) {
    const std::array<uint32_t, 3> corners = {mesh->indices[i], mesh->indices[i + 1],
                                             mesh->indices[i + 2]};
    const vec3 a = mesh->positions[corners[0]];
    const vec3 face = glm::normalize(
        glm::cross(mesh->positions[corners[1]] - a, mesh->positions[corners[2]] - a));
    if (std::all_of(corners.begin(), corners.end(), [&](uint32_t corner) {
          return glm::dot(face, mesh->normals[corner]) > kCosOfSharp;
        })) {
      continue;
    }
    for (size_t c = 0; c < 3; ++c) {
      mesh->indices[i + c] = static_cast<uint32_t>(mesh->positions.size());
      mesh->positions.push_back(vec3(mesh->positions[corners[c]]));
      mesh->uv[0].push_back(vec2(mesh->uv[0][corners[c]]));
      mesh->normals.push_back(face);
    }
  }
}

}  // namespace

Mesh MakeIsosurface(const Aabb& bounds, float cell, const Distance& distance, int material) {
  const Grid grid = Sample(bounds, cell, distance);
  Mesh mesh;
  mesh.material = material;
  std::vector<uint32_t> vertex(grid.values.size(), kNoVertex);
  for (int z = 0; z < grid.nz; ++z) {
    for (int y = 0; y < grid.ny; ++y) {
      for (int x = 0; x < grid.nx; ++x) {
        vec3 mean;
        if (CrossingOf(grid, x, y, z, &mean)) {
          vertex[grid.At(x, y, z)] = static_cast<uint32_t>(mesh.positions.size());
          mesh.positions.push_back(mean);
        }
      }
    }
  }
  mesh.normals.resize(mesh.positions.size());
  constexpr int kBand = 1024;
  ParallelRows(static_cast<int>(mesh.positions.size()), kBand, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto at = static_cast<size_t>(i);
      MoveToSurface(distance, cell, &mesh.positions[at], &mesh.normals[at]);
    }
  });
  for (const vec3& p : mesh.positions) {
    mesh.uv[0].emplace_back(p.x, p.z);
  }
  AddQuads(grid, vertex, &mesh);
  FlattenSharpTriangles(&mesh);
  return mesh;
}

}  // namespace stillray

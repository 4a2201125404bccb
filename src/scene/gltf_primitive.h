// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A primitive of a glTF mesh during its conversion to a Mesh.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scene/gltf_accessor.h"
#include "scene/json_view.h"
#include "stillray/scene.h"

namespace stillray {

/// Accessors of a morph target; -1: none.
struct TargetAccessors {
  int position = -1;
  int normal = -1;
  int tangent = -1;
};

/// The checked references of a primitive, before any data is read, and its mesh.
struct Primitive {
  JsonView view;
  std::string mesh_name;
  uint64_t mode = 4;
  int material = -1;
  int indices = -1;
  int position = -1;
  int normal = -1;
  int tangent = -1;
  int color = -1;
  std::array<int, 2> uv = {-1, -1};
  std::array<int, 2> joints = {-1, -1};
  std::array<int, 2> weights = {-1, -1};
  std::vector<TargetAccessors> targets;
  ImportLog log;  ///< messages of the parallel part
  Mesh mesh;

  bool deforms() const { return joints[0] >= 0 || !targets.empty(); }
};

/// Opens an accessor and checks its shape.
bool OpenAttribute(const GltfDocument& document, Primitive* primitive, int index, const char* name,
                   int min_components, int max_components, Accessor* accessor);

/// OpenAttribute for attributes other than POSITION, which must have as many elements as POSITION.
bool OpenVertexAttribute(const GltfDocument& document, Primitive* primitive, int index,
                         const char* name, int min_components, int max_components, size_t vertices,
                         Accessor* accessor);

/// Number of sparse elements of `accessor`, which is the cost of opening it.
uint64_t SparseCount(const JsonView& root, int accessor);

/// Sets the accessors of joints, weights and morph targets.
/// \param cost  [in,out] number of elements to read, is increased
/// \return false after a failure, which is logged by the view
bool PlanDeformation(const JsonView& root, const JsonView& view, uint64_t vertices, Primitive* plan,
                     uint64_t* cost);

/// ReadJoints and ReadTargets read joints and weights, and morph targets. Invalid weights, and
/// weights that do not sum to 1, are repaired with a warning.
/// \param vertices  number of elements of POSITION
/// \param used      file index of every vertex of the mesh
void ReadJoints(const GltfDocument& document, Primitive* primitive, size_t vertices,
                const std::vector<uint32_t>& used);
void ReadTargets(const GltfDocument& document, Primitive* primitive, size_t vertices,
                 const std::vector<uint32_t>& used);

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Deforms meshes by morph targets, then by skins (glTF 2.0, 3.7.2.2 and 3.7.3).
#pragma once

#include <vector>

#include "stillray/scene.h"

namespace stillray {

/// What deforms the mesh of an instance at one moment.
struct Pose {
  std::vector<mat4> joints;    ///< of its skin: from the rest pose to the world; empty: no skin
  std::vector<float> weights;  ///< of the mesh's morph targets; empty: none acts

  bool empty() const { return joints.empty() && weights.empty(); }
  bool operator==(const Pose& other) const {
    return joints == other.joints && weights == other.weights;
  }
};

/// The vertices of a mesh in a pose: in the world if it has a skin, else in the mesh's space.
struct DeformedMesh {
  std::vector<vec3> positions;
  std::vector<vec3> normals;   ///< unit length; zero where the deformation leaves no direction
  std::vector<vec4> tangents;  ///< empty if the mesh has none
};

/// Whether the mesh of an instance may differ from its rest pose at any time.
bool MayDeform(const Scene& scene, const Instance& instance);

/// Whether its pose, apart from the transforms of joints, is animated.
bool HasAnimatedWeights(const Scene& scene, const Instance& instance);

/// \param instance  MayDeform
/// \param nodes     NodeTransforms at `seconds`
Pose PoseOf(const Scene& scene, const Instance& instance, const std::vector<mat4>& nodes,
            double seconds);

/// Sets all vertices of a mesh: positions and tangents by the weighted sum of the joints' matrices,
/// normals by its cofactors. The result does not depend on the number of threads.
void Deform(const Mesh& mesh, const Pose& pose, DeformedMesh* out);

/// -1 if most joints of the pose mirror: then the front is where triangles are clockwise; else 1.
float PoseOrientation(const Pose& pose);

/// The cofactor matrix: determinant times inverse transpose, defined for singular matrices too.
inline mat3 CofactorMatrix(const mat3& m) {
  return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

}  // namespace stillray

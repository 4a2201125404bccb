// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Deforms meshes by morph targets, then by skins (glTF 2.0, 3.7.2.2 and 3.7.3).
#pragma once

#include <vector>

#include "stillray/scene.h"

namespace stillray {

/// Joint matrices and morph weights of an instance at one moment.
struct Pose {
  std::vector<mat4> joints;    ///< skinning matrices, rest pose to world; empty: no skin
  std::vector<float> weights;  ///< morph target weights; empty: no active target

  bool empty() const { return joints.empty() && weights.empty(); }
  bool operator==(const Pose& other) const {
    return joints == other.joints && weights == other.weights;
  }
};

/// The deformed vertices of a mesh: in world space if it has a skin, else in object space.
struct DeformedMesh {
  std::vector<vec3> positions;
  std::vector<vec3> normals;   ///< unit length; zero where the deformation is degenerate
  std::vector<vec4> tangents;  ///< empty if the mesh has none
};

/// Whether the mesh of an instance may differ from its rest pose at any time.
bool MayDeform(const Scene& scene, const Instance& instance);

/// Whether the morph weights of an instance are animated.
bool HasAnimatedWeights(const Scene& scene, const Instance& instance);

/// \param instance  must satisfy MayDeform
/// \param nodes     result of NodeTransforms at `seconds`
Pose PoseOf(const Scene& scene, const Instance& instance, const std::vector<mat4>& nodes,
            double seconds);

/// Linear blend skinning and morphing of all vertices of a mesh: positions and tangents are
/// transformed by the weighted sum of the joint matrices, normals by its cofactor matrix. The
/// result is independent of the number of threads.
void Deform(const Mesh& mesh, const Pose& pose, DeformedMesh* out);

/// -1 if most joint matrices of the pose mirror, so that front faces have clockwise winding; else
/// 1.
float PoseOrientation(const Pose& pose);

/// The cofactor matrix: determinant times inverse transpose, also defined for singular matrices.
inline mat3 CofactorMatrix(const mat3& m) {
  return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

}  // namespace stillray

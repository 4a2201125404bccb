// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "scene/gltf_primitive.h"
#include "scene/mesh_tools.h"

namespace stillray {

namespace {

constexpr size_t kMaxTargets = 1024;
constexpr std::array<const char*, 2> kJointNames = {"JOINTS_0", "JOINTS_1"};
constexpr std::array<const char*, 2> kWeightNames = {"WEIGHTS_0", "WEIGHTS_1"};

bool PlanJoints(const JsonView& view, size_t accessors, Primitive* plan) {
  const JsonView attributes = view.Object("attributes");
  for (size_t set = 0; set < 2; ++set) {
    plan->joints[set] = attributes.Index(kJointNames[set], accessors, "accessors");
    plan->weights[set] = attributes.Index(kWeightNames[set], accessors, "accessors");
    if (!view.log()->ok()) {
      return false;
    }
    if ((plan->joints[set] < 0) != (plan->weights[set] < 0)) {
      const bool no_joints = plan->joints[set] < 0;
      attributes.Fail(no_joints ? kJointNames[set] : kWeightNames[set],
                      fmt::format("missing, but there is {}",
                                  no_joints ? kWeightNames[set] : kJointNames[set]));
      return false;
    }
  }
  if (plan->joints[0] < 0 && plan->joints[1] >= 0) {
    attributes.Fail("JOINTS_0", "missing, but there is JOINTS_1");
    return false;
  }
  if (attributes.Has("JOINTS_2")) {
    attributes.Warn("JOINTS_2",
                    "more than 8 joints per vertex are not supported: the others were "
                    "left out");
  }
  return true;
}

/// The component types of glTF 2.0, 3.7.3.1.
bool CheckJointType(const Accessor& accessor, Primitive* primitive, const char* name) {
  if (accessor.is_unsigned() && accessor.component_bytes() <= 2 && !accessor.normalized()) {
    return true;
  }
  primitive->log.Fail(Status::BadData(
      fmt::format("{}.{}: is not of unsigned bytes or shorts", primitive->view.path(), name)));
  return false;
}

bool CheckWeightType(const Accessor& accessor, Primitive* primitive, const char* name) {
  if (accessor.is_float() ||
      (accessor.is_unsigned() && accessor.component_bytes() <= 2 && accessor.normalized())) {
    return true;
  }
  primitive->log.Fail(
      Status::BadData(fmt::format("{}.{}: is not of floats or normalised unsigned bytes or shorts",
                                  primitive->view.path(), name)));
  return false;
}

/// Numbers of vertices with repaired weights in a mesh.
struct MendedWeights {
  size_t no_weight = 0;  ///< negative or not finite
  size_t other_sum = 0;
  size_t no_sum = 0;
};

/// Scales the weights of a vertex to the sum 1.
void NormaliseWeights(float* weights, uint16_t* joints, size_t count, MendedWeights* mended) {
  // Larger than the rounding error of a sum of eight 8-bit weights.
  constexpr double kTolerance = 0.02;
  double sum = 0;
  bool good = true;
  for (size_t k = 0; k < count; ++k) {
    if (!(weights[k] >= 0.0f) || !std::isfinite(weights[k])) {
      weights[k] = 0.0f;
      good = false;
    }
    sum += static_cast<double>(weights[k]);
  }
  mended->no_weight += good ? 0 : 1;
  if (!(sum > 0.0)) {
    ++mended->no_sum;
    weights[0] = 1.0f;
    sum = 1.0;
  }
  mended->other_sum += std::abs(sum - 1.0) > kTolerance ? 1 : 0;
  for (size_t k = 0; k < count; ++k) {
    weights[k] = static_cast<float>(static_cast<double>(weights[k]) / sum);
    if (weights[k] == 0.0f) {
      joints[k] = 0;  // may be an arbitrary number in the file
    }
  }
}

void WarnAboutWeights(const MendedWeights& mended, Primitive* primitive) {
  const auto warn = [&](size_t count, const char* what) {
    if (count != 0) {
      primitive->log.Warn(fmt::format("{}.WEIGHTS_0: the weights of {} vertices {}",
                                      primitive->view.path(), count, what));
    }
  };
  warn(mended.no_weight, "are negative, NaN or infinite in part: those became 0");
  warn(mended.no_sum, "are all 0: they follow their first joint");
  warn(mended.other_sum, "do not add up to 1 and were scaled");
}

/// Reads the deltas of one attribute; false after a failure.
bool ReadDeltas(const GltfDocument& document, Primitive* primitive, int index,
                const std::string& name, size_t vertices, const std::vector<uint32_t>& used,
                std::vector<vec3>* out) {
  if (index < 0) {
    return true;
  }
  Accessor accessor;
  if (!OpenVertexAttribute(document, primitive, index, name.c_str(), 3, 3, vertices, &accessor)) {
    return false;
  }
  out->resize(used.size());
  size_t mended = 0;
  for (size_t i = 0; i < used.size(); ++i) {
    vec3& delta = (*out)[i];
    accessor.Read(used[i], &delta.x);
    if (!(std::abs(delta.x) <= kMaxCoordinate && std::abs(delta.y) <= kMaxCoordinate &&
          std::abs(delta.z) <= kMaxCoordinate)) {
      delta = vec3(0.0f);
      ++mended;
    }
  }
  if (mended != 0) {
    primitive->log.Warn(
        fmt::format("{}.{}: {} changes that are NaN, infinite or beyond {:g} became 0",
                    primitive->view.path(), name, mended, kMaxCoordinate));
  }
  return true;
}

/// Makes a sparse morph target of the vertices with nonzero deltas.
/// \param deltas  deltas of positions, normals and tangents; empty: none
MorphTarget MakeTarget(size_t vertices, const std::array<std::vector<vec3>, 3>& deltas) {
  MorphTarget target;
  for (size_t i = 0; i < vertices; ++i) {
    const bool moves = std::any_of(deltas.begin(), deltas.end(), [i](const std::vector<vec3>& all) {
      return !all.empty() && all[i] != vec3(0.0f);
    });
    if (moves) {
      target.vertices.push_back(static_cast<uint32_t>(i));
    }
  }
  const std::array<std::vector<vec3>*, 3> kept = {&target.positions, &target.normals,
                                                  &target.tangents};
  for (size_t k = 0; k < kept.size(); ++k) {
    for (const uint32_t vertex : target.vertices) {
      if (!deltas[k].empty()) {
        kept[k]->push_back(vec3(deltas[k][vertex]));
      }
    }
  }
  return target;
}

}  // namespace

bool PlanDeformation(const JsonView& root, const JsonView& view, uint64_t vertices, Primitive* plan,
                     uint64_t* cost) {
  const size_t accessors = root.Size("accessors");
  if (!PlanJoints(view, accessors, plan)) {
    return false;
  }
  for (size_t set = 0; set < 2; ++set) {
    *cost += plan->joints[set] < 0 ? 0 : vertices;
    *cost += SparseCount(root, plan->joints[set]) + SparseCount(root, plan->weights[set]);
  }
  const size_t count = view.Size("targets");
  if (count > kMaxTargets) {
    view.Fail("targets",
              fmt::format("has {} morph targets, expected at most {}", count, kMaxTargets));
    return false;
  }
  for (size_t i = 0; i < count && view.log()->ok(); ++i) {
    const JsonView target = view.Item("targets", i);
    TargetAccessors of;
    of.position = target.Index("POSITION", accessors, "accessors");
    of.normal = target.Index("NORMAL", accessors, "accessors");
    of.tangent = target.Index("TANGENT", accessors, "accessors");
    for (const int accessor : {of.position, of.normal, of.tangent}) {
      *cost += accessor < 0 ? 0 : vertices;
      *cost += SparseCount(root, accessor);
    }
    plan->targets.push_back(of);
  }
  return view.log()->ok();
}

void ReadJoints(const GltfDocument& document, Primitive* primitive, size_t vertices,
                const std::vector<uint32_t>& used) {
  if (primitive->joints[0] < 0) {
    return;
  }
  Mesh& mesh = primitive->mesh;
  const size_t sets = primitive->joints[1] < 0 ? 1 : 2;
  const size_t influences = 4 * sets;
  mesh.joints.resize(used.size() * influences);
  mesh.weights.resize(used.size() * influences);
  for (size_t set = 0; set < sets; ++set) {
    Accessor joints;
    Accessor weights;
    if (!OpenVertexAttribute(document, primitive, primitive->joints[set], kJointNames[set], 4, 4,
                             vertices, &joints) ||
        !OpenVertexAttribute(document, primitive, primitive->weights[set], kWeightNames[set], 4, 4,
                             vertices, &weights) ||
        !CheckJointType(joints, primitive, kJointNames[set]) ||
        !CheckWeightType(weights, primitive, kWeightNames[set])) {
      return;
    }
    for (size_t i = 0; i < used.size(); ++i) {
      const size_t first = i * influences + 4 * set;
      std::array<float, 4> numbers{};
      joints.Read(used[i], numbers.data());
      std::transform(numbers.begin(), numbers.end(), mesh.joints.begin() + static_cast<long>(first),
                     [](float number) { return static_cast<uint16_t>(number); });
      weights.Read(used[i], mesh.weights.data() + first);
    }
  }
  mesh.influences = static_cast<int>(influences);
  MendedWeights mended;
  for (size_t i = 0; i < used.size(); ++i) {
    NormaliseWeights(mesh.weights.data() + i * influences, mesh.joints.data() + i * influences,
                     influences, &mended);
  }
  WarnAboutWeights(mended, primitive);
}

void ReadTargets(const GltfDocument& document, Primitive* primitive, size_t vertices,
                 const std::vector<uint32_t>& used) {
  for (size_t i = 0; i < primitive->targets.size(); ++i) {
    const TargetAccessors& of = primitive->targets[i];
    const std::string prefix = fmt::format("targets[{}].", i);
    std::array<std::vector<vec3>, 3> deltas;
    if (!ReadDeltas(document, primitive, of.position, prefix + "POSITION", vertices, used,
                    &deltas[0]) ||
        !ReadDeltas(document, primitive, of.normal, prefix + "NORMAL", vertices, used,
                    &deltas[1]) ||
        !ReadDeltas(document, primitive, of.tangent, prefix + "TANGENT", vertices, used,
                    &deltas[2])) {
      return;
    }
    if (primitive->normal < 0) {
      deltas[1].clear();  // flat normals are recomputed from the deformed triangles
    }
    primitive->mesh.targets.push_back(MakeTarget(used.size(), deltas));
  }
}

}  // namespace stillray

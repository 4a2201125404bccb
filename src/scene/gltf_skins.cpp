// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <set>

#include <fmt/format.h>

#include "scene/gltf_accessor.h"
#include "scene/gltf_import.h"
#include "scene/mesh_tools.h"

namespace stillray {

namespace {

constexpr size_t kMaxJoints = 65536;

/// The joints as nodes of the scene; empty after a failure.
std::vector<int> ReadJointNodes(GltfImport* import, const JsonView& view) {
  const std::vector<int> nodes = view.Indices("joints", import->node_of_gltf.size(), "nodes");
  if (!import->log.ok()) {
    return {};
  }
  if (nodes.empty() || nodes.size() > kMaxJoints) {
    view.Fail("joints", fmt::format("has {} joints, expected 1 to {}", nodes.size(), kMaxJoints));
    return {};
  }
  std::vector<int> joints;
  std::set<int> seen;
  for (const int node : nodes) {
    joints.push_back(import->node_of_gltf[static_cast<size_t>(node)]);
    if (joints.back() < 0) {
      view.Fail("joints", fmt::format("node {} is not part of the scene", node));
      return {};
    }
    if (!seen.insert(node).second) {
      view.Fail("joints", fmt::format("names node {} twice", node));
      return {};
    }
  }
  return joints;
}

bool ReadInverseBind(GltfImport* import, const JsonView& view, Skin* skin) {
  skin->inverse_bind.assign(skin->joints.size(), mat4(1.0f));
  const int index =
      view.Index("inverseBindMatrices", import->Root().Size("accessors"), "accessors");
  if (index < 0) {
    return import->log.ok();
  }
  Accessor accessor;
  const std::string user = view.path() + ".inverseBindMatrices";
  if (!OpenAccessor(import->document, &import->log, index, user, &accessor)) {
    return false;
  }
  if (accessor.components() != 16 || !accessor.is_float()) {
    view.Fail("inverseBindMatrices",
              fmt::format("accessors[{}] does not hold 4x4 matrices of floats", index));
    return false;
  }
  if (accessor.count() < skin->joints.size()) {
    view.Fail("inverseBindMatrices", fmt::format("accessors[{}] has {} matrices for {} joints",
                                                 index, accessor.count(), skin->joints.size()));
    return false;
  }
  for (size_t i = 0; i < skin->joints.size(); ++i) {
    mat4& matrix = skin->inverse_bind[i];
    accessor.Read(i, &matrix[0][0]);
    if (!IsTraceable(matrix)) {
      view.Fail("inverseBindMatrices",
                fmt::format("matrix {} has components that are not finite or beyond {:g}", i,
                            kMaxCoordinate));
      return false;
    }
  }
  return true;
}

Skin ReadSkin(GltfImport* import, const JsonView& view) {
  Skin skin;
  skin.name = view.String("name");
  // Only validated: the joints suffice.
  view.Index("skeleton", import->node_of_gltf.size(), "nodes");
  skin.joints = ReadJointNodes(import, view);
  if (import->log.ok() && import->Charge(view.path(), 4 * skin.joints.size())) {
    ReadInverseBind(import, view, &skin);
  }
  return skin;
}

}  // namespace

void ImportSkins(GltfImport* import) {
  const JsonView root = import->Root();
  import->skin_of_gltf.assign(root.Size("skins"), -1);
  for (const GltfMeshUse& use : import->mesh_uses) {
    if (use.gltf_skin < 0 || !import->log.ok()) {
      continue;
    }
    const auto i = static_cast<size_t>(use.gltf_skin);
    if (import->skin_of_gltf[i] < 0) {
      import->skin_of_gltf[i] = static_cast<int>(import->scene.skins.size());
      import->scene.skins.push_back(ReadSkin(import, root.Item("skins", i)));
    }
  }
}

}  // namespace stillray

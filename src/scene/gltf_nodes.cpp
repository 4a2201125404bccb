// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "scene/gltf_import.h"

namespace stillray {

namespace {

constexpr int kNoParent = -1;

/// The parent of every glTF node. Reports nodes with two parents (glTF 2.0, 3.5.2: nodes form a
/// forest).
std::vector<int> ReadParents(GltfImport* import, std::vector<std::vector<int>>* children_of_node) {
  const JsonView root = import->Root();
  const size_t count = root.Size("nodes");
  std::vector<int> parents(count, kNoParent);
  children_of_node->resize(count);
  for (size_t i = 0; i < count && import->log.ok(); ++i) {
    const JsonView node = root.Item("nodes", i);
    std::vector<int> children = node.Indices("children", count, "nodes");
    for (size_t c = 0; c < children.size() && import->log.ok(); ++c) {
      int& parent = parents[static_cast<size_t>(children[c])];
      if (parent != kNoParent) {
        node.Fail("children",
                  fmt::format("node {} already is a child of node {}", children[c], parent));
        break;
      }
      parent = static_cast<int>(i);
    }
    (*children_of_node)[i] = std::move(children);
  }
  return parents;
}

/// Checks that every node reaches a root, by walking up from each node and marking visited nodes.
void CheckNoCycles(GltfImport* import, const std::vector<int>& parents) {
  std::vector<char> reaches_root(parents.size(), 0);
  for (size_t start = 0; start < parents.size(); ++start) {
    std::vector<size_t> trail;
    size_t node = start;
    while (reaches_root[node] == 0 && parents[node] != kNoParent) {
      trail.push_back(node);
      if (trail.size() > parents.size()) {
        import->log.Fail(
            Status::BadData(fmt::format("nodes[{}]: is its own ancestor (a cycle)", start)));
        return;
      }
      node = static_cast<size_t>(parents[node]);
    }
    reaches_root[node] = 1;
    for (const size_t passed : trail) {
      reaches_root[passed] = 1;
    }
  }
}

vec4 UnitQuaternion(const JsonView& node, vec4 q) {
  const double x = q.x;
  const double y = q.y;
  const double z = q.z;
  const double w = q.w;
  const double length = std::sqrt(x * x + y * y + z * z + w * w);
  if (length < 1e-6) {
    node.Warn("rotation", "has no length, so the node is not rotated");
    return {0.0f, 0.0f, 0.0f, 1.0f};
  }
  return {static_cast<float>(x / length), static_cast<float>(y / length),
          static_cast<float>(z / length), static_cast<float>(w / length)};
}

Node ReadNode(const JsonView& view) {
  Node node;
  node.name = view.String("name");
  const bool has_parts = view.Has("translation") || view.Has("rotation") || view.Has("scale");
  node.has_matrix = view.Numbers("matrix", &node.matrix[0][0], 16);
  if (node.has_matrix) {
    if (has_parts) {
      view.Warn("matrix", "used in place of translation, rotation and scale");
    }
    return node;
  }
  view.Numbers("translation", &node.local.translation.x, 3);
  view.Numbers("scale", &node.local.scale.x, 3);
  if (view.Numbers("rotation", &node.local.rotation.x, 4)) {
    node.local.rotation = UnitQuaternion(view, node.local.rotation);
  }
  return node;
}

void ReadEnvironment(GltfImport* import, const JsonView& scene) {
  // Extras may hold arbitrary data: only stillray's format is read.
  if (!scene.IsObject("extras") || !scene.Object("extras").IsObject("environment")) {
    return;
  }
  const JsonView environment = scene.Object("extras").Object("environment");
  const std::string type = environment.String("type");
  if (type != "constant") {
    environment.Warn("type", fmt::format("'{}' is unknown, so the environment is left out "
                                         "(known: constant)",
                                         Printable(type)));
    return;
  }
  vec3 radiance(0.0f);
  environment.Numbers("radiance", &radiance.x, 3);
  if (radiance.x < 0 || radiance.y < 0 || radiance.z < 0) {
    environment.Fail("radiance", "is negative");
    return;
  }
  import->scene.environment.radiance = radiance;
  import->has_environment = true;
}

/// The roots of the traversal: nodes of the default scene, else of the first scene, else all root
/// nodes.
std::vector<int> SceneRoots(GltfImport* import, const std::vector<int>& parents) {
  const JsonView root = import->Root();
  const size_t scenes = root.Size("scenes");
  std::vector<int> roots;
  if (scenes == 0) {
    for (size_t i = 0; i < parents.size(); ++i) {
      if (parents[i] == kNoParent) {
        roots.push_back(static_cast<int>(i));
      }
    }
    return roots;
  }
  const int chosen = root.Index("scene", scenes, "scenes");
  const JsonView scene = root.Item("scenes", chosen < 0 ? 0 : static_cast<size_t>(chosen));
  import->scene.name = scene.String("name");
  ReadEnvironment(import, scene);
  roots = scene.Indices("nodes", parents.size(), "nodes");
  if (!import->log.ok()) {
    return {};
  }
  std::vector<char> seen(parents.size(), 0);
  for (const int node : roots) {
    const size_t i = static_cast<size_t>(node);
    if (parents[i] != kNoParent) {
      scene.Fail("nodes",
                 fmt::format("node {} is no root but a child of node {}", node, parents[i]));
      return {};
    }
    if (seen[i] != 0) {
      scene.Fail("nodes", fmt::format("names node {} twice", node));
      return {};
    }
    seen[i] = 1;
  }
  return roots;
}

void ReadNodeContents(GltfImport* import, const JsonView& view, int gltf_node, int scene_node) {
  const JsonView root = import->Root();
  const int mesh = view.Index("mesh", root.Size("meshes"), "meshes");
  const int skin = view.Index("skin", root.Size("skins"), "skins");
  if (mesh >= 0) {
    import->mesh_uses.push_back({mesh, scene_node, gltf_node, skin});
  } else if (skin >= 0) {
    view.Warn("skin", "is of no use without a mesh");
  }
  if (view.Extension("EXT_mesh_gpu_instancing").exists()) {
    view.Warn("extensions.EXT_mesh_gpu_instancing", "only one of the instances is shown");
  }
  ImportNodeCamera(import, view, scene_node);
  ImportNodeLight(import, view, scene_node);
}

}  // namespace

void ImportNodes(GltfImport* import) {
  std::vector<std::vector<int>> children;
  const std::vector<int> parents = ReadParents(import, &children);
  import->node_of_gltf.assign(parents.size(), -1);
  if (!import->log.ok()) {
    return;
  }
  CheckNoCycles(import, parents);
  if (!import->log.ok()) {
    return;
  }
  // Breadth first, so that parents precede children without recursion.
  std::vector<int> queue = SceneRoots(import, parents);
  const JsonView root = import->Root();
  for (size_t head = 0; head < queue.size() && import->log.ok(); ++head) {
    const size_t gltf_node = static_cast<size_t>(queue[head]);
    const JsonView view = root.Item("nodes", gltf_node);
    Node node = ReadNode(view);
    if (parents[gltf_node] != kNoParent) {
      node.parent = import->node_of_gltf[static_cast<size_t>(parents[gltf_node])];
    }
    const int scene_node = static_cast<int>(head);
    import->node_of_gltf[gltf_node] = scene_node;
    import->scene.nodes.push_back(std::move(node));
    ReadNodeContents(import, view, queue[head], scene_node);
    queue.insert(queue.end(), children[gltf_node].begin(), children[gltf_node].end());
  }
}

}  // namespace stillray

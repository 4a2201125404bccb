// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The steps of a glTF import, one file each. They share one state and run in the order in which
/// they are declared; after each the log says whether to go on.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "scene/gltf_document.h"
#include "stillray/scene.h"

namespace stillray {

/// A mesh on a node, found while walking the nodes.
struct GltfMeshUse {
  int gltf_mesh = -1;
  int node = -1;  ///< in Scene::nodes
};

struct GltfImport {
  GltfDocument document;
  ImportLog log;
  Scene scene;
  std::vector<int> node_of_gltf;       ///< glTF node -> Scene::nodes, -1 if not part of the scene
  std::vector<GltfMeshUse> mesh_uses;  ///< in the order of Scene::nodes
  std::vector<int> image_of_texture;   ///< Scene::textures -> glTF image
  bool has_environment = false;        ///< the file says what surrounds the scene, be it darkness
  /// Picture, wrap modes and filter -> index into Scene::textures.
  std::map<std::tuple<int, Wrap, Wrap, bool>, int> texture_of_use;
  /// Elements (vertices, triangle corners, keyframe values) that may still be read: accessors can
  /// be named any number of times, so a small file could otherwise fill any memory.
  uint64_t elements_left = 0;

  KeepGoing keep_going;  ///< may be empty
  std::atomic<bool> cancelled{false};

  /// Whether work is to go on; any thread may ask. Once not, never again.
  bool GoesOn();

  JsonView Root() { return document.Root(&log); }
  /// Takes `count` elements off the budget; false, with a failure in the log, if it is used up.
  bool Charge(const std::string& user, uint64_t count);
};

/// Refuses required extensions that stillray lacks, and warns about optional ones.
void CheckExtensions(GltfImport* import);

/// Nodes of the file's scene, parents first, with their cameras, punctual lights and meshes; also
/// the environment, which is a property of the scene.
void ImportNodes(GltfImport* import);

/// All materials, in the file's order, and stubs of the textures that they use.
void ImportMaterials(GltfImport* import);

/// Reads and decodes the textures whose stubs ImportMaterials made.
void ImportTextures(GltfImport* import);

/// The primitives of all meshes in use, and their instances.
void ImportMeshes(GltfImport* import);

void ImportAnimations(GltfImport* import);

/// What a node refers to, read while its place in Scene::nodes is known.
void ImportNodeCamera(GltfImport* import, const JsonView& node, int scene_node);
void ImportNodeLight(GltfImport* import, const JsonView& node, int scene_node);

}  // namespace stillray

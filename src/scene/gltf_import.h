// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The steps of a glTF import, one file each. They share one state and run in order of declaration,
/// until an error is logged.
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

/// A mesh on a node, in the order of the nodes.
struct GltfMeshUse {
  int gltf_mesh = -1;
  int node = -1;  ///< index into Scene::nodes
  int gltf_node = -1;
  int gltf_skin = -1;
};

struct GltfImport {
  GltfDocument document;
  ImportLog log;
  Scene scene;
  std::vector<int> node_of_gltf;       ///< glTF node -> Scene::nodes, -1 if not part of the scene
  std::vector<GltfMeshUse> mesh_uses;  ///< in the order of Scene::nodes
  std::vector<int> skin_of_gltf;       ///< glTF skin -> Scene::skins, -1 if unused
  std::vector<int> image_of_texture;   ///< Scene::textures -> glTF image
  bool has_environment = false;        ///< the file defines an environment, which may be black
  /// Image, wrap modes and filter -> index into Scene::textures.
  std::map<std::tuple<int, Wrap, Wrap, bool>, int> texture_of_use;
  /// Budget of elements (vertices, triangle corners, keyframe values) to read: without it, a small
  /// file that references accessors many times could exhaust memory.
  uint64_t elements_left = 0;

  KeepGoing keep_going;  ///< may be empty
  std::atomic<bool> cancelled{false};

  /// Whether the import should continue; thread-safe. Remains false after cancellation.
  bool GoesOn();

  JsonView Root() { return document.Root(&log); }
  /// Subtracts `count` elements from the budget; logs a failure and returns false if it is
  /// exceeded.
  bool Charge(const std::string& user, uint64_t count);
};

/// Rejects unsupported required extensions, and warns about unsupported optional extensions.
void CheckExtensions(GltfImport* import);

/// Imports the nodes of the file's scene, parents first, with their cameras, punctual lights and
/// meshes; also the environment, which is a property of the scene.
void ImportNodes(GltfImport* import);

/// Imports the skins that are used.
void ImportSkins(GltfImport* import);

/// Imports all materials, in file order, and stubs of the referenced textures.
void ImportMaterials(GltfImport* import);

/// Index into Scene::textures of a stub for the glTF texture; textures with equal image and sampler
/// share a stub. -1 after a failure. Call before ImportTextures.
int UseTexture(GltfImport* import, int gltf_texture);

/// Reads and decodes the textures that have stubs.
void ImportTextures(GltfImport* import);

/// Imports the primitives of all used meshes, their instances, and the weights of morph targets.
void ImportMeshes(GltfImport* import);

void ImportAnimations(GltfImport* import);

/// Imports objects referenced by a node, whose index in Scene::nodes is known.
void ImportNodeCamera(GltfImport* import, const JsonView& node, int scene_node);
void ImportNodeLight(GltfImport* import, const JsonView& node, int scene_node);

}  // namespace stillray

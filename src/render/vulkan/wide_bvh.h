// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The tree that compute shaders walk: four children per node on a grid of 8 bits, in 64 bytes.
///
/// Four wide and quantised, since what a GPU's traversal waits for is memory: a node is one cache
/// line, half of what float boxes would take; eight children (Ylitie et al. 2017, "Efficient
/// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs") fit into 80 bytes, but cost
/// twice the arithmetic per step, which is what software drivers wait for.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "render/vulkan/scene_shared.h"
#include "stillray/scene.h"

namespace stillray::render {

struct WideBvh {
  std::vector<BvhNode> nodes;   ///< the root first; at least that
  std::vector<uint32_t> order;  ///< numbers of the boxes; leaves count positions in this list
  Aabb bounds;
  int stack = 0;  ///< entries that walking it can take at once
};

/// Builds trees with Embree's builder (surface area heuristic, binned). Always the same tree for
/// the same boxes: it works on one thread, since the order that several leave items in differs.
class WideBvhBuilder {
 public:
  static Result<std::unique_ptr<WideBvhBuilder>> Create();
  virtual ~WideBvhBuilder() = default;

  /// \param boxes       finite; may be empty
  /// \param leaf_items  at most so many in a leaf, 1 to kMostLeafItems
  /// \param stack       what the tree's walk may take; it is built flatter where it would take more
  /// \param what        for messages
  /// \return kOutOfMemory; kUnsupported: more boxes than a leaf can number (2^28), or no tree of
  ///         that stack
  virtual Result<WideBvh> Build(const std::vector<Aabb>& boxes, int leaf_items, int stack,
                                const std::string& what) = 0;
};

/// The box of a node's child, as shaders compute it; undefined where there is none.
Aabb ChildBox(const BvhNode& node, int child);

}  // namespace stillray::render

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The BVH of compute shaders: four children per node on a grid of 8 bits, in 64 bytes.
///
/// Four wide and quantised, since traversal on a GPU is limited by memory: a node is one cache
/// line, half the size of float boxes; eight children (Ylitie et al. 2017, "Efficient Incoherent
/// Ray Traversal on GPUs Through Compressed Wide BVHs") fit into 80 bytes, but take twice the
/// arithmetic per step, which limits software drivers.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/vulkan/scene_shared.h"
#include "stillray/scene.h"

namespace stillray::render {

struct WideBvh {
  std::vector<BvhNode> nodes;   ///< the root first; at least the root
  std::vector<uint32_t> order;  ///< indices of the boxes; leaves refer to positions in this list
  Aabb bounds;
  int stack = 0;  ///< maximum number of stack entries during traversal
};

/// Builds trees with Embree's builder (surface area heuristic, binned). Deterministic: it uses one
/// thread, since with several the order of leaves varies.
class WideBvhBuilder {
 public:
  static Result<std::unique_ptr<WideBvhBuilder>> Create();
  virtual ~WideBvhBuilder() = default;

  /// \param boxes       finite; may be empty
  /// \param leaf_items  maximum number of items in a leaf, 1 to kMostLeafItems
  /// \param stack       limit for traversal; the tree is built flatter to meet it
  /// \param what        for messages
  /// \return kOutOfMemory; kUnsupported: more boxes than a leaf can index (2^28), or no tree within
  ///     that stack
  virtual Result<WideBvh> Build(const std::vector<Aabb>& boxes, int leaf_items, int stack,
                                const std::string& what) = 0;
};

/// Adapts a tree to items that have moved; its shape stays.
/// \param nodes  of the tree: children refer to `first_node` plus the index in this list, and to
///     items from `first_item` on
/// \param boxes  of the items, in the order of the tree; finite
/// \return the bounds of all
Aabb RefitBvh(std::span<BvhNode> nodes, uint32_t first_node, uint32_t first_item,
              std::span<const Aabb> boxes);

/// The box of a node's child, its planes rounded to floats; undefined if there is none.
Aabb ChildBox(const BvhNode& node, int child);

}  // namespace stillray::render

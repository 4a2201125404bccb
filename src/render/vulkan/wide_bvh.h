// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The BVH of compute shaders: four children per node on a grid of 8 bits, in 64 bytes.
///
/// Four wide and quantised, since traversal on a GPU is limited by memory bandwidth: a node is one
/// cache line, half the size of float boxes. Eight children (Ylitie et al. 2017, "Efficient
/// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs") fit into 80 bytes, but double
/// the arithmetic per step, which limits software drivers.
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
  std::vector<BvhNode> nodes;   ///< starts with the root; never empty
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
  /// \param stack       maximum stack entries of traversal; limits the depth of the tree
  /// \param what        name for error messages
  /// \return kOutOfMemory; kUnsupported: more boxes than a leaf can index (2^28), or no tree within
  ///     that stack
  virtual Result<WideBvh> Build(const std::vector<Aabb>& boxes, int leaf_items, int stack,
                                const std::string& what) = 0;
};

/// Refits a tree to moved items, keeping its topology.
/// \param nodes  nodes of the tree; child indices are offset by `first_node`, item indices by
///     `first_item`
/// \param boxes  boxes of the items, in the order of the tree; finite
/// \return the bounding box of all items
Aabb RefitBvh(std::span<BvhNode> nodes, uint32_t first_node, uint32_t first_item,
              std::span<const Aabb> boxes);

/// The box of a node's child, with planes rounded to floats; undefined without a child.
Aabb ChildBox(const BvhNode& node, int child);

}  // namespace stillray::render

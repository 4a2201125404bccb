// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/wide_bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <new>

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "render/embree_handles.h"

namespace stillray::render {
namespace {

constexpr int kWidth = 4;
constexpr size_t kBuilderAlignment = 16;

/// A node allocated by Embree's builder: an inner node or a leaf.
struct BuiltNode {
  bool leaf = false;
  uint32_t count = 0;           // number of children or items
  BuiltNode* children[kWidth];  // children of inner nodes
  Aabb boxes[kWidth];           // bounding boxes of the children
  uint32_t items[kMostLeafItems];
};

void* CreateNode(RTCThreadLocalAllocator allocator, unsigned count, void* /*user*/) {
  void* memory = rtcThreadLocalAlloc(allocator, sizeof(BuiltNode), kBuilderAlignment);
  auto* node = new (memory) BuiltNode;
  node->count = count;
  return node;
}

void SetChildren(void* node, void** children, unsigned count, void* /*user*/) {
  std::transform(children, children + count, static_cast<BuiltNode*>(node)->children,
                 [](void* child) { return static_cast<BuiltNode*>(child); });
}

void SetBounds(void* node, const RTCBounds** bounds, unsigned count, void* /*user*/) {
  for (unsigned i = 0; i < count; ++i) {
    const RTCBounds& b = *bounds[i];
    static_cast<BuiltNode*>(node)->boxes[i] = {vec3(b.lower_x, b.lower_y, b.lower_z),
                                               vec3(b.upper_x, b.upper_y, b.upper_z)};
  }
}

void* CreateLeaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* items, size_t count,
                 void* /*user*/) {
  void* memory = rtcThreadLocalAlloc(allocator, sizeof(BuiltNode), kBuilderAlignment);
  auto* leaf = new (memory) BuiltNode;
  leaf->leaf = true;
  leaf->count = static_cast<uint32_t>(count);
  for (size_t i = 0; i < count; ++i) {
    leaf->items[i] = items[i].primID;
  }
  return leaf;
}

Aabb Union(const Aabb& a, const Aabb& b) {
  return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

/// One axis of a node: the grid, and the bounds of its children on it.
struct AxisGrid {
  uint32_t exponent = 1;  // float exponent of the scale; 1 is the smallest normal number
  std::array<uint32_t, kWidth> low{};
  std::array<uint32_t, kWidth> high{};
};

/// Position of a grid plane. The product is exact, hence a fused multiply-add gives an equal
/// result.
float OnGrid(float origin, uint32_t step, float scale) {
  return origin + static_cast<float>(step) * scale;
}

/// Quantises the interval [low, high] conservatively to steps 0 to 255; false if it does not fit.
bool Quantise(float origin, float scale, float low, float high, uint32_t* low_step,
              uint32_t* high_step) {
  const auto steps = [&](float x) {
    return std::clamp((static_cast<double>(x) - origin) / scale, 0.0, 255.0);
  };
  auto down = static_cast<uint32_t>(steps(low));
  auto up = static_cast<uint32_t>(steps(high));
  // Rounding of the sum may violate the bound.
  while (down > 0 && OnGrid(origin, down, scale) > low) {
    --down;
  }
  while (up < 255 && OnGrid(origin, up, scale) < high) {
    ++up;
  }
  *low_step = down;
  *high_step = up;
  return OnGrid(origin, up, scale) >= high;
}

AxisGrid MakeGrid(const Aabb* boxes, uint32_t count, int axis, float origin) {
  float high = origin;
  for (uint32_t i = 0; i < count; ++i) {
    high = std::max(high, boxes[i].max[axis]);
  }
  AxisGrid grid;
  const double extent = static_cast<double>(high) - origin;
  if (extent > 0) {
    const int power = static_cast<int>(std::floor(std::log2(extent / 255.0)));
    grid.exponent = static_cast<uint32_t>(std::clamp(power + 127, 1, 254));
  }
  for (;; ++grid.exponent) {
    const float scale = std::bit_cast<float>(grid.exponent << 23);
    bool fits = true;
    for (uint32_t i = 0; i < count; ++i) {
      fits &= Quantise(origin, scale, boxes[i].min[axis], boxes[i].max[axis], &grid.low[i],
                       &grid.high[i]);
    }
    if (fits || grid.exponent == 254) {  // a scale of 10^38 fits every finite box
      return grid;
    }
  }
}

uint32_t Pack(const std::array<uint32_t, kWidth>& bytes) {
  return bytes[0] | bytes[1] << 8 | bytes[2] << 16 | bytes[3] << 24;
}

/// A ray along a face of a box must hit the box, but shaders multiply the distance to its planes by
/// up to 1e18, and a distance of zero would fail. Boxes are therefore enlarged by a few units in
/// the last place of the node's largest coordinate. That exceeds the rounding error of the planes,
/// so that exact and rounded planes enclose the content.
constexpr float kMargin = 0x1p-22f;

BvhNode PackNode(const Aabb* tight, uint32_t count) {
  Aabb all;
  for (uint32_t i = 0; i < count; ++i) {
    all = Union(all, tight[i]);
  }
  const vec3 far = glm::max(glm::abs(all.min), glm::abs(all.max));
  const vec3 margin(kMargin * std::max(far.x, std::max(far.y, far.z)));
  std::array<Aabb, kWidth> boxes;
  std::transform(tight, tight + count, boxes.begin(), [&](const Aabb& box) {
    return Aabb{box.min - margin, box.max + margin};
  });
  all = {all.min - margin, all.max + margin};
  const AxisGrid x = MakeGrid(boxes.data(), count, 0, all.min.x);
  const AxisGrid y = MakeGrid(boxes.data(), count, 1, all.min.y);
  const AxisGrid z = MakeGrid(boxes.data(), count, 2, all.min.z);
  BvhNode node = {};
  node.origin = all.min;
  node.exponents = x.exponent | y.exponent << 8 | z.exponent << 16;
  node.low_x = Pack(x.low);
  node.low_y = Pack(y.low);
  node.low_z = Pack(z.low);
  node.high_x = Pack(x.high);
  node.high_y = Pack(y.high);
  node.high_z = Pack(z.high);
  return node;
}

/// Writes the nodes of a tree, parents before children.
class Flattener {
 public:
  explicit Flattener(WideBvh* out) : out_(out) {}

  // Returns the parent's reference to the subtree. `stack`: [out] entries needed for its traversal.
  uint32_t Add(const BuiltNode& built, int* stack) {
    *stack = 0;
    if (built.leaf) {
      return AddLeaf(built);
    }
    const size_t index = out_->nodes.size();
    out_->nodes.push_back(PackNode(built.boxes, built.count));
    const int children = static_cast<int>(built.count);
    for (int i = 0; i < children; ++i) {
      int below = 0;
      const uint32_t child = Add(*built.children[i], &below);
      out_->nodes[index].children[i] = child;
      *stack = std::max(*stack, below);
    }
    // During the traversal of a child, one entry holds its siblings.
    *stack += children > 1 ? 1 : 0;
    return static_cast<uint32_t>(index);
  }

 private:
  uint32_t AddLeaf(const BuiltNode& leaf) {
    const auto first = static_cast<uint32_t>(out_->order.size());
    out_->order.insert(out_->order.end(), leaf.items, leaf.items + leaf.count);
    return kLeafBit | (leaf.count - 1) << kLeafCountShift | first;
  }

  WideBvh* out_;
};

std::vector<RTCBuildPrimitive> MakePrimitives(const std::vector<Aabb>& boxes) {
  std::vector<RTCBuildPrimitive> primitives(boxes.size());
  for (size_t i = 0; i < boxes.size(); ++i) {
    const Aabb& b = boxes[i];
    primitives[i] = {b.min.x, b.min.y, b.min.z, 0,
                     b.max.x, b.max.y, b.max.z, static_cast<unsigned>(i)};
  }
  return primitives;
}

class EmbreeWideBvhBuilder final : public WideBvhBuilder {
 public:
  explicit EmbreeWideBvhBuilder(EmbreeDevice device) : device_(std::move(device)) {}

  Result<WideBvh> Build(const std::vector<Aabb>& boxes, int leaf_items, int stack,
                        const std::string& what) override {
    if (boxes.size() > kLeafFirstMask) {
      return Status::Unsupported(
          fmt::format("the BVH of {} would have {} items, at most {} can be "
                      "numbered",
                      what, boxes.size(), kLeafFirstMask));
    }
    // Embree splits by area until 8 levels below the maximum depth, then in halves.
    for (const unsigned depth : {32u, 22u, 18u, 14u, 12u}) {
      Result<WideBvh> made = BuildOfDepth(boxes, leaf_items, depth, what);
      if (made.ok() ? made->stack <= stack : made.status().code() == StatusCode::kOutOfMemory) {
        return made;
      }
    }
    return Status::Unsupported(
        fmt::format("the BVH of {} ({} items) is deeper than shaders can walk with {} entries",
                    what, boxes.size(), stack));
  }

 private:
  Result<WideBvh> BuildOfDepth(const std::vector<Aabb>& boxes, int leaf_items, unsigned depth,
                               const std::string& what) {
    WideBvh made;
    for (const Aabb& box : boxes) {
      made.bounds = Union(made.bounds, box);
    }
    if (boxes.empty()) {
      made.nodes.push_back({});
      return made;
    }
    std::vector<RTCBuildPrimitive> primitives = MakePrimitives(boxes);
    const EmbreeBvh bvh(rtcNewBVH(device_.get()));
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.maxBranchingFactor = kWidth;
    arguments.maxDepth = depth;
    arguments.maxLeafSize = static_cast<unsigned>(leaf_items);
    arguments.bvh = bvh.get();
    arguments.primitives = primitives.data();
    arguments.primitiveCount = primitives.size();
    arguments.primitiveArrayCapacity = primitives.size();
    arguments.createNode = CreateNode;
    arguments.setNodeChildren = SetChildren;
    arguments.setNodeBounds = SetBounds;
    arguments.createLeaf = CreateLeaf;
    BuiltNode* root = nullptr;
    tbb::task_arena one_thread(1);
    one_thread.execute([&] { root = static_cast<BuiltNode*>(rtcBuildBVH(&arguments)); });
    const RTCError error = rtcGetDeviceError(device_.get());
    if (root == nullptr || error != RTC_ERROR_NONE) {
      const std::string text =
          fmt::format("building the BVH of {}: Embree error {}", what, static_cast<int>(error));
      return error == RTC_ERROR_OUT_OF_MEMORY ? Status::OutOfMemory(text) : Status::Internal(text);
    }
    BuiltNode parent;  // a single leaf needs a parent
    if (root->leaf) {
      parent.count = 1;
      parent.children[0] = root;
      parent.boxes[0] = made.bounds;
      root = &parent;
    }
    made.order.reserve(boxes.size());
    Flattener(&made).Add(*root, &made.stack);
    return made;
  }

  EmbreeDevice device_;
};

}  // namespace

Result<std::unique_ptr<WideBvhBuilder>> WideBvhBuilder::Create() {
  EmbreeDevice device(rtcNewDevice("start_threads=0,set_affinity=0"));
  if (!device) {
    return Status::Unsupported(fmt::format("Embree could not be started: error {}",
                                           static_cast<int>(rtcGetDeviceError(nullptr))));
  }
  return std::unique_ptr<WideBvhBuilder>(std::make_unique<EmbreeWideBvhBuilder>(std::move(device)));
}

Aabb RefitBvh(std::span<BvhNode> nodes, uint32_t first_node, uint32_t first_item,
              std::span<const Aabb> boxes) {
  std::vector<Aabb> of_nodes(nodes.size());
  // Writes the boxes of the node's children; returns their number.
  const auto find_children = [&](const BvhNode& node, std::array<Aabb, kWidth>* out) {
    uint32_t count = 0;
    for (; count < kWidth && node.children[static_cast<int>(count)] != 0; ++count) {
      const uint32_t child = node.children[static_cast<int>(count)];
      if ((child & kLeafBit) == 0) {
        (*out)[count] = of_nodes[child - first_node];
        continue;
      }
      const uint32_t first = (child & kLeafFirstMask) - first_item;
      const uint32_t last = first + (child >> kLeafCountShift & 7u);
      for (uint32_t i = first; i <= last; ++i) {
        (*out)[count] = Union((*out)[count], boxes[i]);
      }
    }
    return count;
  };
  for (size_t n = nodes.size(); n-- > 0;) {  // parents precede their children
    std::array<Aabb, kWidth> of_children;
    const uint32_t count = find_children(nodes[n], &of_children);
    for (uint32_t i = 0; i < count; ++i) {
      of_nodes[n] = Union(of_nodes[n], of_children[i]);
    }
  }
  // This loop takes nearly all of the time.
  constexpr size_t kGrain = 256;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, nodes.size(), kGrain),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t n = range.begin(); n < range.end(); ++n) {
                        std::array<Aabb, kWidth> of_children;
                        const uint32_t count = find_children(nodes[n], &of_children);
                        const uvec4 children = nodes[n].children;
                        nodes[n] = PackNode(of_children.data(), count);
                        nodes[n].children = children;
                      }
                    });
  return of_nodes[0];
}

Aabb ChildBox(const BvhNode& node, int child) {
  const uint32_t low[] = {node.low_x, node.low_y, node.low_z};
  const uint32_t high[] = {node.high_x, node.high_y, node.high_z};
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    const float scale = std::bit_cast<float>((node.exponents >> (8 * axis) & 255u) << 23);
    box.min[axis] = OnGrid(node.origin[axis], low[axis] >> (8 * child) & 255u, scale);
    box.max[axis] = OnGrid(node.origin[axis], high[axis] >> (8 * child) & 255u, scale);
  }
  return box;
}

}  // namespace stillray::render

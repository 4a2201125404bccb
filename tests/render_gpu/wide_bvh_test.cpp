// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The tree that shaders walk: everything lies in the boxes above it, once, and within the stack.
#include "render/vulkan/wide_bvh.h"

#include <gmock/gmock.h>

#include <cstring>

#include "core/random.h"

namespace stillray::render {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;

std::vector<Aabb> RandomBoxes(int count, float size, uint32_t seed) {
  std::vector<Aabb> boxes;
  uint32_t at = 0;
  const auto next = [&] { return UniformFloat(HashCombine(seed, at++)); };
  for (int i = 0; i < count; ++i) {
    const vec3 p(next(), next(), next());
    boxes.push_back({p, p + vec3(next(), next(), next()) * size});
  }
  return boxes;
}

bool Holds(const Aabb& outer, const Aabb& inner) {
  return glm::all(glm::lessThanEqual(outer.min, inner.min)) &&
         glm::all(glm::greaterThanEqual(outer.max, inner.max));
}

// Counts how often each box is found below the node, and checks the boxes above it.
struct Visitor {
  const WideBvh& bvh;
  const std::vector<Aabb>& boxes;
  std::vector<int> found = std::vector<int>(boxes.size(), 0);
  int escaped = 0;
  int most_stack = 0;

  // `above`: boxes of all ancestors; `waiting`: entries on the stack, of those with more children.
  void Visit(uint32_t node, std::vector<Aabb> above, int waiting) {
    int children = 0;
    for (int i = 0; i < 4; ++i) {
      children += bvh.nodes[node].children[i] != 0 ? 1 : 0;
    }
    waiting += children > 1 ? 1 : 0;
    most_stack = std::max(most_stack, waiting);
    for (int i = 0; i < 4; ++i) {
      const uint32_t child = bvh.nodes[node].children[i];
      if (child == 0) {
        continue;
      }
      above.push_back(ChildBox(bvh.nodes[node], i));
      if ((child & kLeafBit) == 0) {
        Visit(child, above, waiting);
      } else {
        const uint32_t first = child & kLeafFirstMask;
        for (uint32_t k = first; k <= first + (child >> kLeafCountShift & 7u); ++k) {
          const uint32_t item = bvh.order[k];
          ++found[item];
          for (const Aabb& box : above) {
            escaped += Holds(box, boxes[item]) ? 0 : 1;
          }
        }
      }
      above.pop_back();
    }
  }
};

void ExpectHolds(const WideBvh& bvh, const std::vector<Aabb>& boxes) {
  Visitor visitor{bvh, boxes};
  visitor.Visit(0, {}, 0);
  EXPECT_THAT(visitor.found, Each(1));
  EXPECT_EQ(visitor.escaped, 0);
}

WideBvh BuildChecked(const std::vector<Aabb>& boxes, int leaf_items = kMostLeafItems,
                     int stack = kBottomStack) {
  auto builder = WideBvhBuilder::Create();
  EXPECT_TRUE(builder.ok());
  Result<WideBvh> bvh = (*builder)->Build(boxes, leaf_items, stack, "a test");
  EXPECT_TRUE(bvh.ok()) << bvh.status().message();
  Visitor visitor{*bvh, boxes};
  visitor.Visit(0, {}, 0);
  EXPECT_THAT(visitor.found, Each(1));
  EXPECT_EQ(visitor.escaped, 0);
  EXPECT_EQ(visitor.most_stack, bvh->stack);
  EXPECT_LE(bvh->stack, stack);
  return *bvh;
}

TEST(WideBvh, HoldsRandomBoxes) {
  for (const int count : {1, 2, 3, 4, 5, 17, 1000}) {
    BuildChecked(RandomBoxes(count, 0.1f, 1));
    BuildChecked(RandomBoxes(count, 0.0f, 2));
  }
}

TEST(WideBvh, HoldsBoxesThatHaveMoved) {
  for (const int count : {1, 2, 5, 17, 1000}) {
    WideBvh bvh = BuildChecked(RandomBoxes(count, 0.1f, 1));
    const std::vector<Aabb> moved = RandomBoxes(count, 3.0f, 7);
    std::vector<Aabb> in_order;
    Aabb all;
    for (const uint32_t item : bvh.order) {
      in_order.push_back(moved[item]);
      all = {glm::min(all.min, moved[item].min), glm::max(all.max, moved[item].max)};
    }
    const Aabb bounds = RefitBvh(bvh.nodes, 0, 0, in_order);
    ExpectHolds(bvh, moved);
    EXPECT_EQ(bounds.min, all.min);
    EXPECT_EQ(bounds.max, all.max);
  }
}

TEST(WideBvh, HoldsBoxesFarFromTheOriginAndOfAllSizes) {
  std::vector<Aabb> boxes = RandomBoxes(500, 0.1f, 3);
  for (size_t i = 0; i < boxes.size(); ++i) {
    const float scale = std::ldexp(1.0f, static_cast<int>(i % 100) - 50);
    boxes[i] = {boxes[i].min * scale - vec3(scale, 1e5f, 0), boxes[i].max * scale + vec3(0, 1, 0)};
  }
  BuildChecked(boxes);
}

TEST(WideBvh, NothingIsARootWithoutChildren) {
  const WideBvh bvh = BuildChecked({});
  ASSERT_EQ(bvh.nodes.size(), 1u);
  EXPECT_EQ(bvh.nodes[0].children, glm::uvec4(0u));
}

TEST(WideBvh, CoincidentBoxesAndSingleItemsInLeaves) {
  BuildChecked(std::vector<Aabb>(3000, {vec3(1), vec3(2)}));
  const WideBvh bvh = BuildChecked(RandomBoxes(300, 0.2f, 4), 1, kTopStack);
  // Inner nodes have at least two children: the memory that GpuScene reserves for the top level
  // suffices.
  EXPECT_LT(bvh.nodes.size(), 300u);
}

TEST(WideBvh, IsFlatterWhereTheStackIsSmaller) {
  // Each box half as large as the one before: the surface area heuristic makes a chain of them.
  std::vector<Aabb> boxes;
  for (int i = 0; i < 120; ++i) {
    const float size = std::ldexp(1.0f, 60 - i);
    boxes.push_back({vec3(size), vec3(1.5f * size)});
  }
  const int usual = BuildChecked(boxes, 1, 1000).stack;
  EXPECT_GT(usual, kTopStack);
  BuildChecked(boxes, 1, kTopStack);
  auto builder = WideBvhBuilder::Create();
  const Result<WideBvh> none = (*builder)->Build(boxes, 1, 3, "a chain");
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(none.status().message(), HasSubstr("a chain (120 items) is deeper"));
}

TEST(WideBvh, TheSameBoxesMakeTheSameTree) {
  const std::vector<Aabb> boxes = RandomBoxes(20000, 0.01f, 5);
  auto builder = WideBvhBuilder::Create();
  const Result<WideBvh> a = (*builder)->Build(boxes, kMostLeafItems, kBottomStack, "a");
  const Result<WideBvh> b = (*builder)->Build(boxes, kMostLeafItems, kBottomStack, "b");
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->order, b->order);
  ASSERT_EQ(a->nodes.size(), b->nodes.size());
  EXPECT_EQ(std::memcmp(a->nodes.data(), b->nodes.data(), a->nodes.size() * sizeof(BvhNode)), 0);
}

}  // namespace
}  // namespace stillray::render

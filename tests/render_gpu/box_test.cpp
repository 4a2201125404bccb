// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Rays against the boxes of BVH nodes, beside exact rays in double precision: no box that is met is
// missed, and those far beside the ray are.
#include "render/vulkan/box_test_shared.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/random.h"
#include "render/vulkan/child_group_shared.h"

namespace stillray::render {
namespace {

using glm::dvec3;

constexpr float kInfinite = std::numeric_limits<float>::infinity();

/// A sequence of random numbers.
class Random {
 public:
  explicit Random(uint32_t seed) : seed_(seed) {}
  float Uniform(float low, float high) {
    return low + (high - low) * UniformFloat(HashCombine(seed_, at_++));
  }
  int Below(int count) { return std::min(static_cast<int>(Uniform(0, 1) * count), count - 1); }

 private:
  uint32_t seed_;
  uint32_t at_ = 0;
};

struct ExactBox {
  dvec3 low;
  dvec3 high;
};

/// Exact where the sum has no more than 53 bits.
ExactBox BoxOf(const BvhNode& node, int child) {
  const uint32_t low[] = {node.low_x, node.low_y, node.low_z};
  const uint32_t high[] = {node.high_x, node.high_y, node.high_z};
  ExactBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const double scale =
        std::ldexp(1.0, static_cast<int>(node.exponents >> (8 * axis) & 255u) - 127);
    box.low[axis] = node.origin[axis] + scale * (low[axis] >> (8 * child) & 255u);
    box.high[axis] = node.origin[axis] + scale * (high[axis] >> (8 * child) & 255u);
  }
  return box;
}

/// Distance at which the ray enters the box; negative: not up to `end`.
double EnterExactly(const ExactBox& box, vec3 origin, vec3 direction, double end) {
  double enter = 0;
  double leave = end;
  for (int axis = 0; axis < 3; ++axis) {
    const double from = origin[axis];
    const double way = direction[axis];
    if (way == 0) {
      leave = from < box.low[axis] || from > box.high[axis] ? -1 : leave;
      continue;
    }
    const double a = (box.low[axis] - from) / way;
    const double b = (box.high[axis] - from) / way;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : -1;
}

/// Reciprocals as MakeWalk computes them, moved by up to `units` in their last place: devices
/// round them by up to 2.5.
vec3 InverseOf(vec3 direction, int units, Random* random) {
  vec3 inverse;
  for (int axis = 0; axis < 3; ++axis) {
    const float size = std::max(std::abs(direction[axis]), 1e-18f);
    float x = 1.0f / size;
    const int by = random->Below(2 * units + 1) - units;
    for (int i = 0; i < std::abs(by); ++i) {
      x = std::nextafter(x, by < 0 ? 0.0f : kInfinite);
    }
    inverse[axis] = direction[axis] < 0 ? -x : x;
  }
  return inverse;
}

/// A node of four boxes, some of them flat, whose corner is up to `offset` away; steps of its grid
/// are about `step`.
BvhNode RandomNode(float offset, float step, Random* random) {
  BvhNode node = {};
  for (int axis = 0; axis < 3; ++axis) {
    node.origin[axis] = random->Uniform(-offset, offset);
    const int exponent = std::ilogb(step) + random->Below(5) - 2 + 127;
    node.exponents |= static_cast<uint32_t>(exponent) << (8 * axis);
  }
  uint32_t* const low[] = {&node.low_x, &node.low_y, &node.low_z};
  uint32_t* const high[] = {&node.high_x, &node.high_y, &node.high_z};
  for (int child = 0; child < 4; ++child) {
    node.children[child] = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const int a = random->Below(256);
      const int b = random->Below(4) == 0 ? a : random->Below(256);
      *low[axis] |= static_cast<uint32_t>(std::min(a, b)) << (8 * child);
      *high[axis] |= static_cast<uint32_t>(std::max(a, b)) << (8 * child);
    }
  }
  return node;
}

struct TestRay {
  vec3 origin;
  vec3 direction;
};

/// To a corner, an edge, a face or the inside of the box; a third along one axis or two, with
/// components that are 0, of either sign, or nearly 0.
TestRay RayTo(const ExactBox& box, float distance, Random* random) {
  vec3 target;
  for (int axis = 0; axis < 3; ++axis) {
    const float along = random->Uniform(0, 1);
    const double t = random->Below(2) == 0 ? random->Below(2) : along;
    target[axis] = static_cast<float>(box.low[axis] + t * (box.high[axis] - box.low[axis]));
  }
  TestRay ray;
  vec3 way(random->Uniform(-1, 1), random->Uniform(-1, 1), random->Uniform(-1, 1));
  if (random->Below(3) == 0) {
    const float least[] = {0.0f, -0.0f, 1e-30f, -1e-21f};
    for (int i = 1 + random->Below(2); i > 0; --i) {
      way[random->Below(3)] = least[random->Below(4)];
    }
  }
  ray.direction = glm::length(way) > 0.01f ? glm::normalize(way) : vec3(0, -1, 0);
  ray.origin = target - ray.direction * distance * random->Uniform(0, 1);
  return ray;
}

/// What happened to boxes, each with one ray.
struct Count {
  int met = 0;     // by the exact ray
  int missed = 0;  // of those
  int late = 0;    // entered behind where the exact ray enters
  int beside = 0;  // not met by the exact ray, even if the box were larger by a few roundings
  int taken = 0;   // of those
};

/// Sizes of a node and of the way to it; the length of directions, which is not 1 in the space of
/// an instance.
struct Sizes {
  float offset;
  float step;
  float distance;
  float length = 1;
};

Count TestRays(const Sizes& sizes, int nodes, int units) {
  Random random(static_cast<uint32_t>(std::ilogb(sizes.offset) * 64 + std::ilogb(sizes.step)));
  Count count;
  for (int n = 0; n < nodes; ++n) {
    const BvhNode node = RandomNode(sizes.offset, sizes.step, &random);
    for (int aim = 0; aim < 4; ++aim) {
      TestRay ray = RayTo(BoxOf(node, aim), sizes.distance, &random);
      ray.direction *= sizes.length;
      const float end = random.Below(2) == 0 ? kInfinite : sizes.distance / sizes.length;
      const vec3 inverse = InverseOf(ray.direction, units, &random);
      const uvec4 entered = EnterChildren(node, ray.origin, inverse, end);
      for (int child = 0; child < 4; ++child) {
        const ExactBox box = BoxOf(node, child);
        const double exact = EnterExactly(box, ray.origin, ray.direction, end);
        const bool hit = entered[child] != kMissed;
        if (exact >= 0) {
          ++count.met;
          count.missed += hit ? 0 : 1;
          count.late += hit && DistanceOfChild(entered[child]) > exact ? 1 : 0;
          continue;
        }
        const dvec3 scale = (box.high - box.low) + glm::abs(dvec3(node.origin - ray.origin)) +
                            dvec3(1024.0 * sizes.step);
        const ExactBox larger = {box.low - 4e-6 * scale, box.high + 4e-6 * scale};
        if (EnterExactly(larger, ray.origin, ray.direction, end * 1.00001) < 0) {
          ++count.beside;
          count.taken += hit ? 1 : 0;
        }
      }
    }
  }
  return count;
}

class RaysAgainstBoxes : public ::testing::TestWithParam<Sizes> {};

TEST_P(RaysAgainstBoxes, MissNoneThatTheExactRayMeets) {
  for (const int units : {0, 2}) {
    const Count count = TestRays(GetParam(), 20000, units);
    EXPECT_GT(count.met, 30000);
    EXPECT_GT(count.beside, 20000);
    EXPECT_EQ(count.missed, 0) << "of " << count.met;
    EXPECT_EQ(count.late, 0) << "of " << count.met;
    EXPECT_EQ(count.taken, 0) << "of " << count.beside;
  }
}

// Near the origin and up to a million away, where boxes are as small as the rounding of their
// coordinates; from as near as their size, and from far away. The last three are in the space of
// instances that are scaled.
INSTANTIATE_TEST_SUITE_P(AllSizes, RaysAgainstBoxes,
                         ::testing::Values(Sizes{1, 0.01f, 3}, Sizes{1, 1e-6f, 1e-3f},
                                           Sizes{1e4f, 0.1f, 100}, Sizes{1e4f, 1e-4f, 1},
                                           Sizes{1e5f, 0.01f, 1e5f}, Sizes{1e6f, 1e-3f, 100},
                                           Sizes{1e6f, 1.0f, 1e6f}, Sizes{1, 0.01f, 1e6f},
                                           Sizes{1e-12f, 1e-15f, 1e-11f}, Sizes{1, 0.01f, 3, 1e6f},
                                           Sizes{1e4f, 0.1f, 100, 1e-6f},
                                           Sizes{1e-6f, 1e-8f, 1e-5f, 1e-6f}));

TEST(RayAgainstBoxes, AlongAFaceIsInside) {
  BvhNode node = {};
  node.origin = vec3(2, 3, 4);
  node.exponents = 127u | 127u << 8 | 127u << 16;  // steps of 1
  node.children = uvec4(1, 1, 0, 0);
  node.low_x = 10u | 20u << 8;
  node.high_x = 20u | 30u << 8;
  node.high_y = 5u | 5u << 8;
  node.high_z = 5u | 5u << 8;
  // Both boxes share the face at x = 22.
  const vec3 ahead(0, 0, 1);
  Random random(1);
  const vec3 inverse = InverseOf(ahead, 0, &random);
  uvec4 entered = EnterChildren(node, vec3(22, 4, -100), inverse, kInfinite);
  for (const int child : {0, 1}) {
    EXPECT_NEAR(DistanceOfChild(entered[child]), 104.0f, 1e-3f);
  }
  // No child, whatever its planes.
  EXPECT_EQ(entered[2], kMissed);
  EXPECT_EQ(entered[3], kMissed);
  // In the second only, from its inside; then before both, and behind.
  entered = EnterChildren(node, vec3(25, 4, 5), inverse, kInfinite);
  EXPECT_EQ(entered[0], kMissed);
  EXPECT_EQ(entered[1], 1u);  // the number, at distance 0
  EXPECT_EQ(EnterChildren(node, vec3(25, 4, -100), inverse, 100.0f)[1], kMissed);
  EXPECT_EQ(EnterChildren(node, vec3(25, 4, 100), inverse, kInfinite)[1], kMissed);
  // Backwards, from behind the first one.
  entered = EnterChildren(node, vec3(15, 4, 29), InverseOf(-ahead, 0, &random), kInfinite);
  EXPECT_NEAR(DistanceOfChild(entered[0]), 20.0f, 1e-3f);
  EXPECT_EQ(entered[1], kMissed);
}

// Every choice of children and every order of their distances: all are visited once, the nearest
// first, at no more than their distances.
TEST(ChildGroup, HoldsTheChildrenThatAreEnteredNearestFirst) {
  constexpr uint32_t kNode = kLeafFirstMask;  // the largest index
  std::array<int, 4> rank = {0, 1, 2, 3};
  do {
    for (uint32_t mask = 0; mask < 16; ++mask) {
      uvec4 entered(kMissed);
      std::vector<uint32_t> expected(4, kMissed);
      for (int child = 0; child < 4; ++child) {
        const auto place = static_cast<size_t>(rank[static_cast<size_t>(child)]);
        if ((mask >> child & 1u) != 0) {
          const float distance = 2.5f * static_cast<float>(place);
          entered[child] = (floatBitsToUint(distance) & ~3u) | static_cast<uint32_t>(child);
          expected[place] = static_cast<uint32_t>(child);
        }
      }
      std::erase(expected, kMissed);
      uint32_t next = kMissed;
      ChildGroup others = GroupChildren(kNode, entered, next);
      std::vector<uint32_t> visited;
      while (next != kMissed) {
        const uint32_t number = NumberOfChild(next);
        EXPECT_EQ(NodeOfGroup(others), kNode);
        EXPECT_LE(DistanceOfChild(next), DistanceOfChild(entered[static_cast<int>(number)]));
        EXPECT_TRUE(visited.size() > 1 || next == entered[static_cast<int>(number)]);
        visited.push_back(number);
        next = others.next;
        others = next == kMissed ? others : WithoutNext(others);
      }
      EXPECT_EQ(visited, expected);
    }
  } while (std::next_permutation(rank.begin(), rank.end()));
}

}  // namespace
}  // namespace stillray::render

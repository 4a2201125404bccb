// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Steps of the shaders' traversal, walked on the CPU: with one entry of the stack per node, beside
// one per child with its own distance. Hits are the same, and hardly more nodes are visited.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "render/camera.h"
#include "render/geometry_shared.h"
#include "render/vulkan/child_group_shared.h"
#include "render/vulkan/gpu_scene.h"
#include "render_gpu/gpu_batch.h"

namespace stillray::render {
namespace {

constexpr float kEndOfWorld = 1e30f;

/// Sums over rays.
struct Steps {
  double nodes = 0;
  double triangles = 0;
  double pushed = 0;        // entries of the stack
  size_t most_entries = 0;  // at any time
};

struct LocalRay {
  vec3 origin;
  vec3 direction;
  vec3 inverse;
};

LocalRay MakeLocal(vec3 origin, vec3 direction) {
  LocalRay ray = {origin, direction, vec3(0)};
  for (int axis = 0; axis < 3; ++axis) {
    const float side = direction[axis] < 0 ? -1.0f : 1.0f;
    ray.inverse[axis] = side / std::max(std::abs(direction[axis]), 1e-18f);
  }
  return ray;
}

LocalRay InSpaceOf(const Placement& placement, const GpuRay& ray) {
  if (placement.instance == kNoInstance) {
    return MakeLocal(ray.origin, ray.direction);
  }
  const mat4 to_object = glm::transpose(
      mat4(placement.to_object_x, placement.to_object_y, placement.to_object_z, vec4(0, 0, 0, 1)));
  return MakeLocal(vec3(to_object * vec4(ray.origin, 1)), vec3(to_object * vec4(ray.direction, 0)));
}

/// As in Möller and Trumbore (1997). Distance of the hit, or `end`.
float MeetTriangle(const LocalRay& ray, const BvhTriangle& t, float end) {
  const vec3 a = t.p1 - t.p0;
  const vec3 b = t.p2 - t.p0;
  const vec3 p = cross(ray.direction, b);
  const float inverse = 1.0f / dot(a, p);
  const vec3 from = ray.origin - t.p0;
  const vec3 q = cross(from, a);
  const float u = dot(from, p) * inverse;
  const float v = dot(ray.direction, q) * inverse;
  const float distance = dot(b, q) * inverse;
  return u >= 0 && v >= 0 && u + v <= 1 && distance > 0 && distance < end ? distance : end;
}

/// The traversal of traversal.glsl with one of two stacks.
class Walker {
 public:
  /// \param groups  one entry per node, else one per child
  Walker(const GpuScene& scene, bool groups) : scene_(scene), groups_(groups) {}

  /// Distance of the first hit, or ray.end.
  float FindFirstHit(const GpuRay& ray) {
    stack_.clear();
    best_ = ray.end;
    local_ = MakeLocal(ray.origin, ray.direction);
    Walk(0, ray, false);
    return best_;
  }
  const Steps& steps() const { return steps_; }

 private:
  /// A child that is to be visited; `last` of its entry.
  struct Pending {
    uint32_t node;
    uint32_t entered;
    bool last;
  };

  void Walk(uint32_t root, const GpuRay& ray, bool placed) {
    const size_t bottom = stack_.size();
    Push(root);
    while (stack_.size() > bottom) {
      const Pending at = stack_.back();
      stack_.pop_back();
      if (DistanceOfChild(at.entered) > best_ * kEndScale) {
        continue;
      }
      const uint32_t child =
          scene_.nodes()[at.node].children[static_cast<int>(NumberOfChild(at.entered))];
      if ((child & kLeafBit) == 0) {
        Push(child);
      } else if (!placed) {
        const LocalRay world = local_;
        const Placement& placement = scene_.placements()[child & kLeafFirstMask];
        local_ = InSpaceOf(placement, ray);
        Walk(placement.root, ray, true);
        local_ = world;
      } else {
        const uint32_t first = child & kLeafFirstMask;
        const uint32_t count = (child >> kLeafCountShift & 7u) + 1;
        for (uint32_t i = first; i < first + count; ++i) {
          best_ = MeetTriangle(local_, scene_.triangles()[i], best_);
        }
        steps_.triangles += count;
      }
    }
  }

  /// The children of a node that the ray enters, the nearest last.
  void Push(uint32_t node) {
    ++steps_.nodes;
    const uvec4 entered = EnterChildren(scene_.nodes()[node], local_.origin, local_.inverse, best_);
    std::vector<Pending> found;
    if (groups_) {
      uint32_t next = kMissed;
      ChildGroup others = GroupChildren(node, entered, next);
      while (next != kMissed) {
        found.push_back({node, next, others.next == kMissed});
        next = others.next;
        others = next == kMissed ? others : WithoutNext(others);
      }
      steps_.pushed += found.size() > 1 ? 1 : 0;
    } else {
      for (int i = 0; i < 4; ++i) {
        if (entered[i] != kMissed) {
          found.push_back({node, entered[i], true});
        }
      }
      std::sort(found.begin(), found.end(),
                [](const Pending& a, const Pending& b) { return a.entered < b.entered; });
      steps_.pushed += static_cast<double>(found.size());
    }
    stack_.insert(stack_.end(), found.rbegin(), found.rend());
    // The first one is taken at once, so an entry exists where others follow it.
    size_t entries = 0;
    for (const Pending& pending : stack_) {
      entries += pending.last ? 1 : 0;
    }
    if (groups_ && found.size() == 1) {
      --entries;
    }
    steps_.most_entries = std::max(steps_.most_entries, entries);
  }

  const GpuScene& scene_;
  const bool groups_;
  std::vector<Pending> stack_;
  LocalRay local_;
  float best_ = 0;
  Steps steps_;
};

/// Rays of the camera, then of all directions from where those hit.
std::array<std::vector<GpuRay>, 2> RaysOf(const SceneState& state, const GpuScene& gpu) {
  constexpr int kWidth = 160;
  constexpr int kHeight = 90;
  const Camera& camera = state.scene().cameras[0];
  const CameraView view =
      MakeCameraView(camera, state.nodes()[static_cast<size_t>(camera.node)], kWidth, kHeight);
  std::array<std::vector<GpuRay>, 2> rays;
  Walker walker(gpu, false);
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) {
    const vec2 pixel(static_cast<float>(i % kWidth), static_cast<float>(i / kWidth));
    const GpuRay ray = {view.position, kEndOfWorld, view.Direction(pixel + vec2(0.5f)), 0};
    rays[0].push_back(ray);
    const float t = walker.FindFirstHit(ray);
    if (t < kEndOfWorld) {
      rays[1].push_back(
          {ray.origin + ray.direction * (t * 0.999f), kEndOfWorld, RandomDirection(i), 0});
    }
  }
  return rays;
}

TEST(TreeWalk, VisitsFewMoreNodesWithOneEntryPerNode) {
  for (const std::string name : {"cornell", "spheres", "lights", "car"}) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    SceneState state(*scene);
    state.Update(0, 0);
    const auto gpu = GpuScene::Create(state);
    ASSERT_TRUE(gpu.ok());
    const std::array<std::vector<GpuRay>, 2> kinds = RaysOf(state, **gpu);
    for (size_t kind = 0; kind < 2; ++kind) {
      Walker children(**gpu, false);
      Walker groups(**gpu, true);
      int different = 0;
      for (const GpuRay& ray : kinds[kind]) {
        different += children.FindFirstHit(ray) != groups.FindFirstHit(ray) ? 1 : 0;
      }
      EXPECT_EQ(different, 0);
      EXPECT_LT(groups.steps().nodes, 1.04 * children.steps().nodes);
      EXPECT_LT(groups.steps().triangles, 1.1 * children.steps().triangles);
      EXPECT_LT(groups.steps().pushed, 0.5 * children.steps().pushed);
      EXPECT_LE(groups.steps().most_entries, static_cast<size_t>(kStackSize));
      const auto rays = static_cast<double>(kinds[kind].size());
      for (const Walker* walker : {&children, &groups}) {
        const Steps& s = walker->steps();
        std::printf(
            "%-10s %-6s %-11s per ray: %5.2f nodes, %5.2f triangles, %5.2f entries;"
            " %zu entries at most\n",
            name.c_str(), kind == 0 ? "camera" : "bounce",
            walker == &children ? "per child" : "per node", s.nodes / rays, s.triangles / rays,
            s.pushed / rays, s.most_entries);
      }
    }
  }
}

}  // namespace
}  // namespace stillray::render

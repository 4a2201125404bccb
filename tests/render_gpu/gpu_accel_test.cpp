// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Rays on the device hit the same surfaces as Embree's, and none passes through a closed mesh.
#include "render/vulkan/gpu_accel.h"

#include <gmock/gmock.h>

#include <limits>

#include "render/deforming_scene.h"
#include "render/test_scenes.h"
#include "render_gpu/gpu_batch.h"
#include "render_gpu/tracing_ways.h"

namespace stillray::render {
namespace {

using ::testing::HasSubstr;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Distances agree to this, relative to the size of the scene: both test triangles in floats, one
// after moving them to the ray's origin.
constexpr float kDistanceTolerance = 2e-5f;
// Rays that pass an edge within rounding may meet its other side, or nothing: so many in a million.
constexpr int kPerMillion = 100;

class GpuAccelTest : public TracingWaysTest {
 protected:
  void TearDown() override {
    batch_.reset();
    accel_.reset();
    embree_.reset();
    TracingWaysTest::TearDown();
  }

  void Build(const Scene& scene, double seconds = 0) {
    batch_.reset();
    scene_ = scene;
    state_ = std::make_unique<SceneState>(scene_);
    state_->Update(seconds, seconds);
    filter_ = std::make_unique<SceneShadowFilter>(*state_);
    auto embree = Accel::Create(scene_, DescribeInstances(*state_), state_->Places(), *filter_);
    ASSERT_TRUE(embree.ok()) << embree.status().message();
    embree_ = std::move(*embree);
    auto accel = GpuAccel::Create(device_.get(), *state_, GetParam());
    ASSERT_TRUE(accel.ok()) << accel.status().message();
    accel_ = std::move(*accel);
    batch_ = std::make_unique<GpuBatch>(device_.get(), accel_.get(), 1 << 16);
    ASSERT_TRUE(batch_->status().ok()) << batch_->status().message();
  }

  void MoveTo(double seconds) {
    state_->Update(seconds, seconds);
    ASSERT_TRUE(embree_->Update(state_->Places()).ok());
    const Status status = accel_->Update();
    ASSERT_TRUE(status.ok()) << status.message();
  }

  // Compares random rays from in and around the scene; they must hit at least `least` times.
  void ExpectSameHits(double seconds, int count, int least) {
    const Aabb box = SceneBounds(scene_, seconds);
    const float size = glm::length(box.max - box.min);
    const std::vector<GpuRay> rays = RandomRays(
        {box.min - vec3(0.1f * size), box.max + vec3(0.1f * size)}, count, 1 + (seconds > 0));
    const std::vector<GpuHit> found = batch_->FirstHits(rays);
    ASSERT_TRUE(batch_->status().ok()) << batch_->status().message();
    const std::vector<GpuHit> expected = EmbreeFirstHits(*embree_, rays);
    int hits = 0;
    int different = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      const GpuHit& a = found[i];
      const GpuHit& b = expected[i];
      hits += b.instance != kNoHit ? 1 : 0;
      const bool both = a.instance != kNoInstance && b.instance != kNoHit;
      const bool neither = a.instance == kNoInstance && b.instance == kNoHit;
      different += neither || (both && Agree(a, b, size)) ? 0 : 1;
    }
    EXPECT_GE(hits, least);
    const int most = 1 + static_cast<int>(int64_t{count} * kPerMillion / 1000000);
    test::RecordLargest("different hits", different, most);
    EXPECT_LE(different, most);
  }

  bool IsSoftwareAsHardware() const {
    return GetParam() == TracingWay::kHardware && !device_->info().is_gpu;
  }

  // How many of so many rays to edges and corners may slip through. None, but for software that
  // takes the place of hardware: Mesa's tests boxes without regard to rounding.
  int Holes(size_t rays) const { return IsSoftwareAsHardware() ? static_cast<int>(rays / 200) : 0; }

  static bool Agree(const GpuHit& a, const GpuHit& b, float size) {
    if (std::abs(a.t - b.t) > kDistanceTolerance * size) {
      return false;
    }
    // The same triangle, or one that touches it there.
    const bool same = a.instance == b.instance && a.primitive == b.primitive;
    return !same || std::abs(a.u - b.u) + std::abs(a.v - b.v) < 1e-2f;
  }

  Scene scene_;
  std::unique_ptr<SceneState> state_;
  std::unique_ptr<SceneShadowFilter> filter_;
  std::unique_ptr<Accel> embree_;
  std::unique_ptr<GpuAccel> accel_;
  std::unique_ptr<GpuBatch> batch_;
};

Transform Pose(vec3 translation, vec4 rotation, vec3 scale) {
  Transform transform;
  transform.translation = translation;
  transform.rotation = rotation;
  transform.scale = scale;
  return transform;
}

// Things that move, turned, mirrored, sheared by a parent, of one mesh and of several.
Scene MovingScene() {
  SceneBuilder builder;
  const Material grey = Lambert(vec3(0.5f));
  builder.Add(Box(vec3(-4, -1.2f, -4), vec3(4, -1, 4)), grey);
  const int ball = builder.Add(FacetedSphere(vec3(0), 1, 3), grey);
  builder.Move(builder.InstanceNode(ball), vec3(0.5f, 0.3f, 0));
  const vec3 axis = glm::normalize(vec3(1, 2, 3));
  for (int i = 0; i < 6; ++i) {
    const auto angle = static_cast<float>(i);
    const int node = builder.AddNode(
        Pose(vec3(3 * std::cos(angle), 0.2f * angle, 3 * std::sin(angle)), Rotation(axis, angle),
             vec3(i % 2 == 0 ? 0.5f : -0.4f, 0.3f + 0.1f * angle, 0.6f)));
    builder.scene.instances.push_back({1, node});
    builder.Move(node, vec3(0, 0.5f, -0.2f * angle));
  }
  const int parent = builder.AddNode(Pose(vec3(0, 2, 0), Rotation(axis, 0.7f), vec3(1, 3, 0.5f)));
  const int box = builder.Add(Box(vec3(-0.5f), vec3(0.5f)), grey,
                              Pose(vec3(0), Rotation(vec3(0, 0, 1), 0.5f), vec3(1)));
  builder.scene.nodes[static_cast<size_t>(builder.InstanceNode(box))].parent = parent;
  builder.Move(builder.InstanceNode(box), vec3(1, 0, 0));
  return builder.scene;
}

TEST_P(GpuAccelTest, HitsOfTheBuiltinScenesAreEmbrees) {
  for (const std::string& name : BuiltinSceneNames()) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    ASSERT_NO_FATAL_FAILURE(Build(*scene));
    ExpectSameHits(0, 50000, 10000);
    const double seconds = 0.4 * scene->AnimationLength() + 0.1;
    ASSERT_NO_FATAL_FAILURE(MoveTo(seconds));
    ExpectSameHits(seconds, 50000, 10000);
  }
}

TEST_P(GpuAccelTest, HitsOfMovingInstancesAreEmbrees) {
  ASSERT_NO_FATAL_FAILURE(Build(MovingScene()));
  for (const double seconds : {0.0, 0.3, 1.0}) {
    ASSERT_NO_FATAL_FAILURE(MoveTo(seconds));
    ExpectSameHits(seconds, 50000, 10000);
  }
}

TEST_P(GpuAccelTest, HitsOfDeformingInstancesAreEmbrees) {
  for (const int rings : {10, 60}) {
    ASSERT_NO_FATAL_FAILURE(Build(DeformingScene(rings)));
    for (const double seconds : {0.0, 0.3, 0.1, 1.0}) {
      ASSERT_NO_FATAL_FAILURE(MoveTo(seconds));
      ExpectSameHits(seconds, 50000, 5000);
    }
  }
}

TEST_P(GpuAccelTest, TrianglesThatMoveBeyondAllLimitsAreNotThere) {
  SceneBuilder builder;
  Mesh sheet = Quad(vec3(-2, -2, -4), vec3(4, 0, 0), vec3(0, 4, 0));
  AddTarget(&sheet, [](vec3 p) { return p.x < 0 && p.y < 0 ? vec3(-1e18f, 0, 0) : vec3(0.0f); });
  const int instance = builder.Add(sheet, Lambert(vec3(0.5f)));
  AnimateWeights(&builder, builder.InstanceNode(instance), {0}, {100});
  ASSERT_NO_FATAL_FAILURE(Build(builder.scene));
  const std::vector<GpuRay> rays = {{vec3(-1, -1.1f, 0), 1e9f, vec3(0, 0, -1), 0},
                                    {vec3(1, -1.1f, 0), 1e9f, vec3(0, 0, -1), 0}};
  for (const double seconds : {0.0, 1.0, 0.0}) {
    ASSERT_NO_FATAL_FAILURE(MoveTo(seconds));
    const std::vector<GpuHit> hits = batch_->FirstHits(rays);
    ASSERT_TRUE(batch_->status().ok()) << batch_->status().message();
    const std::vector<GpuHit> expected = EmbreeFirstHits(*embree_, rays);
    for (size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(hits[i].instance, seconds == 0.0 ? 0u : kNoInstance) << i;
      EXPECT_EQ(expected[i].instance, seconds == 0.0 ? 0u : kNoHit) << i;
    }
  }
}

TEST_P(GpuAccelTest, AnInstanceWithoutExtentIsNotThereUntilItHasOne) {
  SceneBuilder builder;
  const int ball = builder.Add(FacetedSphere(vec3(0, 0, -5), 1, 2), Lambert(vec3(0.5f)));
  AnimationChannel grow;
  grow.node = builder.InstanceNode(ball);
  grow.property = AnimatedProperty::kScale;
  grow.times = {0.0f, 1.0f};
  grow.values = {vec4(0.0f), vec4(1.0f)};
  builder.scene.animation.push_back(grow);
  ASSERT_NO_FATAL_FAILURE(Build(builder.scene));
  const std::vector<GpuRay> ray = {{vec3(0.01f, 0.02f, 0), kInfinity, vec3(0, 0, -1), 0}};
  EXPECT_EQ(batch_->FirstHits(ray)[0].instance, kNoInstance);
  ASSERT_NO_FATAL_FAILURE(MoveTo(1.0));
  const GpuHit hit = batch_->FirstHits(ray)[0];
  EXPECT_EQ(hit.instance, 0u);
  EXPECT_NEAR(hit.t, 4.0f, 0.1f);
}

TEST_P(GpuAccelTest, EmptySceneOneTriangleAndRaysThatAreNone) {
  SceneBuilder builder;
  ASSERT_NO_FATAL_FAILURE(Build(builder.scene));
  const vec3 ahead(0, 0, -1);
  EXPECT_EQ(batch_->FirstHits({{vec3(0), kInfinity, ahead, 0}})[0].instance, kNoInstance);
  EXPECT_EQ(batch_->Transmittance({{vec3(0), kInfinity, ahead, 0}})[0], vec3(1.0f));
  EXPECT_TRUE(batch_->FirstHits({}).empty());

  Mesh mesh;
  AddFlatTriangle(&mesh, vec3(-1, -1, -2), vec3(1, -1, -2), vec3(-1, 1, -2));
  builder.Add(mesh, Lambert(vec3(0.5f)));
  ASSERT_NO_FATAL_FAILURE(Build(builder.scene));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<GpuHit> hits = batch_->FirstHits({
      {vec3(-0.5f, -0.25f, 0), kInfinity, ahead, 0},    // inside
      {vec3(0.5f, 0.5f, 0), kInfinity, ahead, 0},       // beside
      {vec3(-0.5f, -0.25f, 0), 1.9f, ahead, 0},         // ends before
      {vec3(-0.5f, -0.25f, 0), 2.0f, ahead, 0},         // ends there
      {vec3(-0.5f, -0.25f, 0), kInfinity, -ahead, 0},   // runs away
      {vec3(-0.5f, -0.25f, -4), kInfinity, -ahead, 0},  // sees its back
      {vec3(-0.5f, -0.25f, 0), kInfinity, vec3(0), 0},
      {vec3(-0.5f, -0.25f, 0), nan, ahead, 0},
      {vec3(nan), kInfinity, ahead, 0},
      {vec3(0), kInfinity, vec3(nan), 0},
  });
  ASSERT_TRUE(batch_->status().ok());
  EXPECT_EQ(hits[0].instance, 0u);
  EXPECT_FLOAT_EQ(hits[0].t, 2.0f);
  EXPECT_FLOAT_EQ(hits[0].u, 0.25f);
  EXPECT_FLOAT_EQ(hits[0].v, 0.375f);
  EXPECT_EQ(hits[3].instance, 0u);
  EXPECT_EQ(hits[5].instance, 0u);
  for (const size_t miss : {1, 2, 4, 6, 7, 8, 9}) {
    EXPECT_EQ(hits[miss].instance, kNoInstance) << miss;
  }
}

TEST_P(GpuAccelTest, DegenerateTrianglesAreNeverHitAndHideNothing) {
  SceneBuilder builder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Mesh mesh = Quad(vec3(-1, -1, -2), vec3(2, 0, 0), vec3(0, 2, 0));
  mesh.positions.insert(mesh.positions.end(), {vec3(0, 0, -1), vec3(0.5f, 0, -1), vec3(1, 0, -1),
                                               vec3(nan, 0, -1), vec3(1e30f, 0, -1)});
  mesh.normals.resize(mesh.positions.size(), vec3(0, 0, 1));
  mesh.uv[0].clear();
  for (const uint32_t i : {4, 4, 4, 4, 5, 6, 4, 5, 5, 4, 5, 7, 4, 5, 8}) {
    mesh.indices.push_back(i);
  }
  builder.Add(mesh, Lambert(vec3(0.5f)));
  ASSERT_NO_FATAL_FAILURE(Build(builder.scene));
  std::vector<GpuRay> rays;
  for (int i = 0; i < 1000; ++i) {
    const auto x = static_cast<float>(i) / 1000.0f;
    rays.push_back({vec3(x, 0, 0), kInfinity, vec3(0, 0, -1), 0});
  }
  for (const GpuHit& hit : batch_->FirstHits(rays)) {
    ASSERT_LT(hit.primitive, 2u);
    ASSERT_FLOAT_EQ(hit.t, 2.0f);
  }
}

// Rays to points on edges and to corners, from inside and from far outside.
std::vector<GpuRay> RaysToEdges(const Mesh& mesh, const mat4& world, vec3 centre, int per_edge) {
  std::vector<GpuRay> rays;
  uint32_t seed = 0;
  for (size_t i = 0; i < mesh.indices.size(); ++i) {
    const size_t next = i % 3 == 2 ? i - 2 : i + 1;
    const vec3 a(world * vec4(mesh.positions[mesh.indices[i]], 1.0f));
    const vec3 b(world * vec4(mesh.positions[mesh.indices[next]], 1.0f));
    for (int k = 0; k < per_edge; ++k) {
      const float along = k == 0 ? 0.0f : UniformFloat(HashU32(++seed));
      const vec3 target = a + (b - a) * along;
      const vec3 from = centre + RandomDirection(++seed) * (k % 2 == 0 ? 0.0f : 0.2f);
      rays.push_back({from, kInfinity, glm::normalize(target - from), 0});
      const vec3 far = target + (target - centre) * 50.0f;
      rays.push_back({far, kInfinity, glm::normalize(centre - far), 0});
    }
  }
  return rays;
}

TEST_P(GpuAccelTest, NoRayPassesAnEdgeOrCornerOfAClosedMesh) {
  SceneBuilder builder;
  const vec3 centre(3.3f, -1.7f, 5.1f);
  const Mesh sphere = FacetedSphere(centre, 1, 4);
  builder.Add(sphere, Lambert(vec3(0.5f)));
  ASSERT_NO_FATAL_FAILURE(Build(builder.scene));
  const std::vector<GpuRay> rays = RaysToEdges(sphere, mat4(1.0f), centre, 5);
  int missed = 0;
  for (const GpuHit& hit : batch_->FirstHits(rays)) {
    missed += hit.instance == kNoInstance ? 1 : 0;
  }
  EXPECT_GE(rays.size(), 50000u);
  test::RecordLargest("missed at edges", missed, Holes(rays.size()));
  EXPECT_LE(missed, Holes(rays.size()));
  int lit = 0;
  for (const vec3& light : batch_->Transmittance(rays)) {
    lit += light != vec3(0.0f) ? 1 : 0;
  }
  test::RecordLargest("lit through edges", lit, Holes(rays.size()));
  EXPECT_LE(lit, Holes(rays.size()));
}

TEST_P(GpuAccelTest, NoRayPassesAnEdgeOrCornerOfAMovingMesh) {
  SceneBuilder builder;
  const Mesh box = Box(vec3(-1), vec3(1));
  const int at = builder.Add(
      box, Lambert(vec3(0.5f)),
      Pose(vec3(7, 8, 9), Rotation(glm::normalize(vec3(1, 2, 3)), 0.9f), vec3(1, 2, -0.5f)));
  builder.Move(builder.InstanceNode(at), vec3(1, 0, 0));
  ASSERT_NO_FATAL_FAILURE(Build(builder.scene));
  ASSERT_NO_FATAL_FAILURE(MoveTo(0.6));
  const mat4 world = state_->instance(0).world;
  const std::vector<GpuRay> rays = RaysToEdges(box, world, vec3(world[3]), 500);
  int missed = 0;
  for (const GpuHit& hit : batch_->FirstHits(rays)) {
    missed += hit.instance == kNoInstance ? 1 : 0;
  }
  test::RecordLargest("missed at edges", missed, Holes(rays.size()));
  EXPECT_LE(missed, Holes(rays.size()));
}

TEST_P(GpuAccelTest, AxisParallelRaysHitWhereBoxesAreFlat) {
  SceneBuilder builder;
  const Mesh box = Box(vec3(0), vec3(4));
  builder.Add(box, Lambert(vec3(0.5f)));
  ASSERT_NO_FATAL_FAILURE(Build(builder.scene));
  std::vector<GpuRay> rays;
  for (int i = 0; i <= 8; ++i) {
    for (int k = 0; k <= 8; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        vec3 from(0.5f * static_cast<float>(i), 0.5f * static_cast<float>(k), 0);
        from = axis == 0   ? vec3(-1, from.x, from.y)
               : axis == 1 ? vec3(from.x, -1, from.y)
                           : vec3(from.x, from.y, -1);
        vec3 direction(0);
        direction[axis] = 1;
        rays.push_back({from, kInfinity, direction, 0});
      }
    }
  }
  int missed = 0;
  for (const GpuHit& hit : batch_->FirstHits(rays)) {
    if (hit.instance == kNoInstance) {
      ++missed;
    } else {
      ASSERT_FLOAT_EQ(hit.t, 1.0f);
    }
  }
  // A quarter of the rays runs along faces, edges and corners of the box. Ray tracing hardware may
  // miss what lies in the plane of a ray (an H200 misses 51 of 243); the traversal of stillray's
  // trees does not.
  const int most = GetParam() == TracingWay::kHardware ? static_cast<int>(rays.size()) / 4 : 0;
  test::RecordLargest("missed along faces", missed, most);
  EXPECT_LE(missed, most);
}

// A texture of random alpha and colour.
Texture Noise(int width, int height) {
  Texture texture;
  texture.width = width;
  texture.height = height;
  for (int i = 0; i < 4 * width * height; ++i) {
    texture.texels.push_back(static_cast<uint8_t>(HashU32(static_cast<uint32_t>(i)) & 255u));
  }
  return texture;
}

// Layers of every kind that shadow rays pass: cut out, blended, glass sheets, vertex colours.
Scene CurtainScene() {
  SceneBuilder builder;
  builder.scene.textures = {Noise(16, 16), Noise(5, 7), Noise(8, 3)};
  builder.scene.textures[1].wrap_u = Wrap::kMirror;
  builder.scene.textures[1].wrap_v = Wrap::kClamp;
  builder.scene.textures[2].nearest = true;
  const auto layer = [&](float z) { return Quad(vec3(-2, -2, z), vec3(4, 0, 0), vec3(0, 4, 0)); };
  for (int i = 0; i < 3; ++i) {
    Material material = Lambert(vec3(0.8f));
    material.base_color_texture.texture = i;
    material.base_color_texture.transform = mat3(3, 0.5f, 0, -0.5f, 3, 0, -0.7f, 0.2f, 1);
    material.alpha_mode = i == 0 ? AlphaMode::kMask : AlphaMode::kBlend;
    material.alpha_cutoff = 0.4f;
    builder.Add(layer(-1.0f - static_cast<float>(i)), material);
  }
  Material sheet = Glass(1.5f, 0.0f);
  sheet.solid = false;
  sheet.base_color = vec4(0.9f, 0.8f, 0.5f, 1.0f);
  sheet.transmission_texture.texture = 0;
  Mesh tilted = layer(0);
  tilted.colors = {vec4(1), vec4(1, 0.5f, 0.5f, 1), vec4(0.2f, 1, 1, 1), vec4(0.7f)};
  const int at = builder.Add(tilted, sheet,
                             Pose(vec3(0, 0, -5), Rotation(vec3(0, 1, 0), 0.6f), vec3(1.5f, 1, 1)));
  builder.Move(builder.InstanceNode(at), vec3(0, 0.1f, 0));
  builder.Add(Quad(vec3(-2, -2, -7), vec3(2, 0, 0), vec3(0, 4, 0)), Lambert(vec3(0.5f)));
  return builder.scene;
}

TEST_P(GpuAccelTest, TransmittanceIsTheCpus) {
  ASSERT_NO_FATAL_FAILURE(Build(CurtainScene()));
  ASSERT_NO_FATAL_FAILURE(MoveTo(0.5));
  const std::vector<GpuRay> rays = RandomRays({vec3(-2, -2, -9), vec3(2, 2, 1)}, 50000, 3, 8.0f);
  const std::vector<vec3> found = batch_->Transmittance(rays);
  ASSERT_TRUE(batch_->status().ok()) << batch_->status().message();
  const std::vector<vec3> expected = EmbreeTransmittance(*embree_, rays);
  int partial = 0;
  int different = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    partial += expected[i].x > 0.01f && expected[i].x < 0.99f ? 1 : 0;
    const vec3 d = glm::abs(found[i] - expected[i]);
    different += std::max(d.x, std::max(d.y, d.z)) < 1e-4f ? 0 : 1;
  }
  EXPECT_GE(partial, 5000);
  // Besides rounding at edges: alpha cutouts without interpolation of texels.
  EXPECT_LE(different, 25);
}

TEST_P(GpuAccelTest, TransmittanceOfOpaqueScenesIsWhetherSomethingStandsBetween) {
  for (const std::string& name : BuiltinSceneNames()) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    ASSERT_NO_FATAL_FAILURE(Build(*scene));
    const Aabb box = SceneBounds(scene_, 0);
    const std::vector<GpuRay> rays =
        RandomRays(box, 30000, 4, 0.3f * glm::length(box.max - box.min));
    const std::vector<vec3> found = batch_->Transmittance(rays);
    const std::vector<vec3> expected = EmbreeTransmittance(*embree_, rays);
    int different = 0;
    int lit = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      lit += expected[i].x > 0 ? 1 : 0;
      const vec3 d = glm::abs(found[i] - expected[i]);
      different += std::max(d.x, std::max(d.y, d.z)) < 1e-4f ? 0 : 1;
    }
    EXPECT_GT(lit, 1000);
    EXPECT_LT(lit, 29000);
    EXPECT_LE(different, 4);
  }
}

TEST_P(GpuAccelTest, SaysWhatIsTooLarge) {
  ASSERT_NO_FATAL_FAILURE(Build(MovingScene()));
  const std::vector<GpuRay> rays(1 + (1 << 16));
  batch_->FirstHits(rays);
  EXPECT_THAT(batch_->status().message(), HasSubstr("tracing 65537 rays: buffers of"));

  auto& limits = const_cast<VkPhysicalDeviceLimits&>(device_->context().limits);
  const VkPhysicalDeviceLimits real = limits;
  limits.maxStorageBufferRange = 1000;
  auto accel = GpuAccel::Create(device_.get(), *state_, GetParam());
  ASSERT_FALSE(accel.ok());
  EXPECT_EQ(accel.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(accel.status().message(),
              HasSubstr("MiB of BVH nodes, but a storage buffer of the device holds 0.0 MiB"));
  limits = real;
  limits.maxPerStageDescriptorStorageBuffers = 4;
  accel = GpuAccel::Create(device_.get(), *state_, GetParam());
  ASSERT_FALSE(accel.ok());
  EXPECT_THAT(accel.status().message(),
              HasSubstr("storage buffers in a shader, the device offers 4"));
  limits = real;
}

TEST_P(GpuAccelTest, TheSameRaysGiveTheSameBits) {
  ASSERT_NO_FATAL_FAILURE(Build(MovingScene()));
  const std::vector<GpuRay> rays = RandomRays(SceneBounds(scene_, 0), 20000, 5);
  const std::vector<GpuHit> once = batch_->FirstHits(rays);
  ASSERT_NO_FATAL_FAILURE(MoveTo(0.5));
  ASSERT_NO_FATAL_FAILURE(MoveTo(0.0));
  const std::vector<GpuHit> again = batch_->FirstHits(rays);
  EXPECT_EQ(std::memcmp(once.data(), again.data(), once.size() * sizeof(GpuHit)), 0);
}

STILLRAY_IN_BOTH_WAYS(GpuAccelTest);

}  // namespace
}  // namespace stillray::render

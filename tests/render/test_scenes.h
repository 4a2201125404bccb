// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Small scenes made by hand, for tests of the path tracer.
#pragma once

#include <cmath>
#include <memory>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/colour.h"
#include "render/create_renderer.h"
#include "stillray/render.h"

namespace stillray::render {

/// Pure Lambert: a refractive index of 1 has no coat.
inline Material Lambert(vec3 albedo) {
  Material material;
  material.base_color = vec4(albedo, 1.0f);
  material.metallic = 0.0f;
  material.roughness = 1.0f;
  material.ior = 1.0f;
  return material;
}

inline Material Emitter(vec3 radiance) {
  Material material = Lambert(vec3(0.0f));
  material.emission = radiance;
  return material;
}

inline Material Glass(float ior, float roughness) {
  Material material;
  material.metallic = 0.0f;
  material.roughness = roughness;
  material.transmission = 1.0f;
  material.ior = ior;
  material.solid = true;
  return material;
}

inline Material Metal(vec3 colour, float roughness) {
  Material material;
  material.base_color = vec4(colour, 1.0f);
  material.roughness = roughness;
  return material;
}

inline Material Plastic(float roughness) {
  Material material = Metal(vec3(1.0f), roughness);
  material.metallic = 0.0f;
  return material;
}

inline Transform At(vec3 translation) {
  Transform transform;
  transform.translation = translation;
  return transform;
}

/// Rotation by `angle` radians about a unit axis.
inline vec4 Rotation(vec3 axis, float angle) {
  return vec4(axis * std::sin(0.5f * angle), std::cos(0.5f * angle));
}

/// Adds a triangle with its own normal on all corners.
inline void AddFlatTriangle(Mesh* mesh, vec3 a, vec3 b, vec3 c) {
  const vec3 normal = glm::normalize(glm::cross(b - a, c - a));
  for (const vec3& p : {a, b, c}) {
    mesh->indices.push_back(static_cast<uint32_t>(mesh->positions.size()));
    mesh->positions.push_back(p);
    mesh->normals.push_back(normal);
  }
}

/// A parallelogram with corner `o`; its front is where x, y, z = cross(x, y) are right-handed. uv
/// (0,0) lies at o, (1,0) at o + x.
inline Mesh Quad(vec3 o, vec3 x, vec3 y) {
  Mesh mesh;
  mesh.positions = {o, o + x, o + x + y, o + y};
  mesh.normals.assign(4, glm::normalize(glm::cross(x, y)));
  mesh.uv[0] = {vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 1)};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

/// An axis-aligned box; normals outward, or inward.
inline Mesh Box(vec3 low, vec3 high, bool inward = false) {
  Mesh mesh;
  const vec3 s = high - low;
  const vec3 x(s.x, 0, 0);
  const vec3 y(0, s.y, 0);
  const vec3 z(0, 0, s.z);
  const auto add = [&](vec3 o, vec3 u, vec3 v) {
    if (inward) {
      std::swap(u, v);
    }
    AddFlatTriangle(&mesh, o, o + u, o + u + v);
    AddFlatTriangle(&mesh, o, o + u + v, o + v);
  };
  add(low + z, x, y);
  add(low, y, x);
  add(low + x, y, z);
  add(low, z, y);
  add(low + y, z, x);
  add(low, x, z);
  return mesh;
}

/// A sphere of flat triangles: convex, with shading normals that agree with the geometry.
inline Mesh FacetedSphere(vec3 centre, float radius, int subdivisions) {
  Mesh octahedron;
  const vec3 ends[] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  std::vector<std::array<vec3, 3>> faces;
  for (int i = 0; i < 4; ++i) {
    faces.push_back({ends[i], ends[(i + 1) % 4], vec3(0, 0, 1)});
    faces.push_back({ends[(i + 1) % 4], ends[i], vec3(0, 0, -1)});
  }
  for (int s = 0; s < subdivisions; ++s) {
    std::vector<std::array<vec3, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const vec3 ab = glm::normalize(a + b);
      const vec3 bc = glm::normalize(b + c);
      const vec3 ca = glm::normalize(c + a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  Mesh mesh;
  for (const auto& [a, b, c] : faces) {
    AddFlatTriangle(&mesh, centre + a * radius, centre + b * radius, centre + c * radius);
  }
  return mesh;
}

/// The sides of a box around the origin that face +x, -x, +z and -z.
inline Mesh BoxWithoutLids(float half) {
  Mesh box;
  for (int i = 0; i < 4; ++i) {
    const float angle = static_cast<float>(i) * 1.57079633f;
    const vec3 out(std::sin(angle), 0, std::cos(angle));
    const vec3 right(std::cos(angle), 0, -std::sin(angle));
    const vec3 corner = (out - right - vec3(0, 1, 0)) * half;
    const vec3 up(0, 2 * half, 0);
    AddFlatTriangle(&box, corner, corner + right * (2 * half), corner + right * (2 * half) + up);
    AddFlatTriangle(&box, corner, corner + right * (2 * half) + up, corner + up);
  }
  return box;
}

/// A scene with one camera at the origin that looks along -z.
struct SceneBuilder {
  Scene scene;

  SceneBuilder() { scene.cameras.push_back({"camera", AddNode({}), 0.8f, 0.0f}); }
  int AddNode(const Transform& local) {
    Node node;
    node.local = local;
    scene.nodes.push_back(node);
    return static_cast<int>(scene.nodes.size()) - 1;
  }
  /// \return the instance's index
  int Add(Mesh mesh, const Material& material, const Transform& local = {}) {
    mesh.material = static_cast<int>(scene.materials.size());
    scene.materials.push_back(material);
    scene.meshes.push_back(std::move(mesh));
    scene.instances.push_back({static_cast<int>(scene.meshes.size()) - 1, AddNode(local)});
    return static_cast<int>(scene.instances.size()) - 1;
  }
  Transform& CameraTransform() { return scene.nodes[0].local; }
  /// Moves a node in a straight line from where it stands, at `velocity` per second.
  void Move(int node, vec3 velocity) {
    AnimationChannel channel;
    channel.node = node;
    channel.times = {0.0f, 1.0f};
    const vec3 start = scene.nodes[static_cast<size_t>(node)].local.translation;
    channel.values = {vec4(start, 0.0f), vec4(start + velocity, 0.0f)};
    scene.animation.push_back(channel);
  }
  /// Turns a node about a unit axis by `angles` radians at 0, 0.1, 0.2, ... seconds.
  void Turn(int node, vec3 axis, const std::vector<float>& angles) {
    AnimationChannel channel;
    channel.node = node;
    channel.property = AnimatedProperty::kRotation;
    for (size_t i = 0; i < angles.size(); ++i) {
      channel.times.push_back(static_cast<float>(i) * 0.1f);
      channel.values.push_back(Rotation(axis, angles[i]));
    }
    scene.animation.push_back(channel);
  }
  int InstanceNode(int instance) const {
    return scene.instances[static_cast<size_t>(instance)].node;
  }
};

inline RenderSettings SmallSettings(int width, int height, int spp) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.spp = spp;
  settings.jitter = false;
  return settings;
}

inline RenderMoment MomentAt(double seconds, double previous) {
  RenderMoment moment;
  moment.seconds = seconds;
  moment.previous_seconds = previous;
  return moment;
}

inline Frame RenderOne(const Scene& scene, const RenderSettings& settings,
                       const RenderMoment& moment = {}) {
  Frame frame;
  auto renderer = CreateRenderer(scene, settings);
  EXPECT_TRUE(renderer.ok()) << renderer.status().message();
  if (renderer.ok()) {
    const Status status = (*renderer)->RenderFrame(moment, &frame);
    EXPECT_TRUE(status.ok()) << status.message();
    EXPECT_EQ((*renderer)->timings().dropped, 0u);
  }
  return frame;
}

// A glossy floor under a map with a small bright spot, and a lamp: all strategies agree.
inline Scene StrategiesScene(float roughness) {
  SceneBuilder builder;
  builder.CameraTransform() = At(vec3(0, 1, 3));
  builder.CameraTransform().rotation = Rotation(vec3(1, 0, 0), -0.4f);
  Material floor = Metal(vec3(0.9f), roughness);
  floor.metallic = 0.5f;
  builder.Add(Quad(vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)), floor);
  builder.Add(Quad(vec3(-1.5f, 0.2f, -2), vec3(3, 0, 0), vec3(0, 1.5f, 0)), Emitter(vec3(3.0f)));
  Environment& environment = builder.scene.environment;
  environment.radiance = vec3(1.0f, 0.9f, 0.8f);
  environment.map = Image3(32, 16);
  for (int c = 0; c < 3; ++c) {
    environment.map[c].Fill(0.2f);
    environment.map[c](14, 5) = 40.0f;
  }
  return builder.scene;
}

// A matte wall and a light without extent.
inline Scene WallWithLamp() {
  SceneBuilder builder;
  builder.Add(Quad(vec3(-9, -9, -2), vec3(18, 0, 0), vec3(0, 18, 0)), Lambert(vec3(0.5f)));
  PunctualLight lamp;
  lamp.type = LightType::kPoint;
  lamp.intensity = vec3(3.0f);
  lamp.node = builder.AddNode(At(vec3(1, 0, 0)));
  builder.scene.lights.push_back(lamp);
  return builder.scene;
}

inline Image3 RenderMean(const Scene& scene, const RenderSettings& settings, int spp) {
  Image3 image;
  auto renderer = CreateRenderer(scene, settings);
  EXPECT_TRUE(renderer.ok()) << renderer.status().message();
  if (renderer.ok()) {
    const Status status = (*renderer)->RenderReference({}, spp, &image);
    EXPECT_TRUE(status.ok()) << status.message();
    EXPECT_EQ((*renderer)->timings().dropped, 0u);
  }
  return image;
}

inline Image3 RenderMean(const Scene& scene, RenderSettings settings, int spp,
                         LightSampling sampling) {
  settings.light_sampling = sampling;
  return RenderMean(scene, settings, spp);
}

inline vec3 Pixel(const Image3& image, int x, int y) {
  return {image[0](x, y), image[1](x, y), image[2](x, y)};
}

/// Sum of the squared differences of luminance.
inline double SquaredError(const Image3& image, const Image3& truth) {
  double sum = 0;
  for (int y = 0; y < truth.height(); ++y) {
    for (int x = 0; x < truth.width(); ++x) {
      sum += std::pow(Luminance709(Pixel(image, x, y) - Pixel(truth, x, y)), 2.0);
    }
  }
  return sum;
}

/// Mean over the picture.
inline vec3 Mean(const Image3& image) {
  glm::dvec3 sum(0.0);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      sum += glm::dvec3(Pixel(image, x, y));
    }
  }
  return vec3(sum / (static_cast<double>(image.width()) * image.height()));
}

inline void ExpectNear(vec3 found, vec3 expected, float tolerance, const std::string& what = "") {
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(found[k], expected[k], tolerance) << what << " channel " << k;
  }
}

}  // namespace stillray::render

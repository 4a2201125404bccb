// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/gtc/quaternion.hpp>

#include "scene/builtin.h"

namespace stillray {

namespace {

constexpr float kPi = 3.14159265f;

uint32_t AddVertex(Mesh* mesh, vec3 position, vec3 normal, vec2 uv) {
  mesh->positions.push_back(position);
  mesh->normals.push_back(normal);
  mesh->uv[0].push_back(uv);
  return static_cast<uint32_t>(mesh->positions.size()) - 1;
}

void AddTriangle(Mesh* mesh, uint32_t a, uint32_t b, uint32_t c) {
  mesh->indices.insert(mesh->indices.end(), {a, b, c});
}

void AddQuad(Mesh* mesh, vec3 origin, vec3 edge_u, vec3 edge_v, vec2 uv_scale) {
  const vec3 normal = glm::normalize(glm::cross(edge_u, edge_v));
  const uint32_t a = AddVertex(mesh, origin, normal, vec2(0.0f));
  const uint32_t b = AddVertex(mesh, origin + edge_u, normal, vec2(uv_scale.x, 0.0f));
  const uint32_t c = AddVertex(mesh, origin + edge_u + edge_v, normal, uv_scale);
  const uint32_t d = AddVertex(mesh, origin + edge_v, normal, vec2(0.0f, uv_scale.y));
  AddTriangle(mesh, a, b, c);
  AddTriangle(mesh, a, c, d);
}

/// Ease-in and ease-out: the integral of a cosine bell.
float Ease(float t) {
  return t - std::sin(2.0f * kPi * t) / (2.0f * kPi);
}

}  // namespace

Mesh MakeQuad(vec3 origin, vec3 edge_u, vec3 edge_v, vec2 uv_scale, int material) {
  Mesh mesh;
  mesh.material = material;
  AddQuad(&mesh, origin, edge_u, edge_v, uv_scale);
  return mesh;
}

Mesh MakeBox(vec3 size, float repeats, int material) {
  Mesh mesh;
  mesh.material = material;
  const vec3 x(size.x, 0.0f, 0.0f);
  const vec3 y(0.0f, size.y, 0.0f);
  const vec3 z(0.0f, 0.0f, size.z);
  const vec3 low = -0.5f * (x + z);
  const vec3 high = low + x + y + z;
  const auto uv = [&](float u, float v) { return vec2(u, v) * repeats; };
  AddQuad(&mesh, low, x, z, uv(size.x, size.z));
  AddQuad(&mesh, low, y, x, uv(size.y, size.x));
  AddQuad(&mesh, low, z, y, uv(size.z, size.y));
  AddQuad(&mesh, high, -z, -x, uv(size.z, size.x));
  AddQuad(&mesh, high, -x, -y, uv(size.x, size.y));
  AddQuad(&mesh, high, -y, -z, uv(size.y, size.z));
  return mesh;
}

Mesh MakeSphere(float radius, int slices, int stacks, int material) {
  Mesh mesh;
  mesh.material = material;
  for (int j = 0; j <= stacks; ++j) {
    const float v = static_cast<float>(j) / static_cast<float>(stacks);
    for (int i = 0; i <= slices; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(slices);
      const vec3 normal(std::sin(kPi * v) * std::sin(2.0f * kPi * u), std::cos(kPi * v),
                        std::sin(kPi * v) * std::cos(2.0f * kPi * u));
      AddVertex(&mesh, radius * normal, glm::normalize(normal), vec2(u, v));
    }
  }
  const auto at = [&](int i, int j) { return static_cast<uint32_t>(j * (slices + 1) + i); };
  for (int j = 0; j < stacks; ++j) {
    for (int i = 0; i < slices; ++i) {
      if (j != stacks - 1) {
        AddTriangle(&mesh, at(i, j), at(i, j + 1), at(i + 1, j + 1));
      }
      if (j != 0) {
        AddTriangle(&mesh, at(i, j), at(i + 1, j + 1), at(i + 1, j));
      }
    }
  }
  return mesh;
}

Mesh MakeCylinder(float radius, float height, int slices, vec2 uv_scale, int material) {
  Mesh mesh;
  mesh.material = material;
  const vec3 up(0.0f, 1.0f, 0.0f);
  const auto direction = [&](int i) {
    const float angle = 2.0f * kPi * static_cast<float>(i) / static_cast<float>(slices);
    return vec3(std::sin(angle), 0.0f, std::cos(angle));
  };
  for (int i = 0; i <= slices; ++i) {
    const float u = uv_scale.x * static_cast<float>(i) / static_cast<float>(slices);
    AddVertex(&mesh, radius * direction(i) + height * up, direction(i), vec2(u, 0.0f));
    AddVertex(&mesh, radius * direction(i), direction(i), vec2(u, uv_scale.y));
  }
  for (uint32_t i = 0; i < static_cast<uint32_t>(slices); ++i) {
    AddTriangle(&mesh, 2 * i, 2 * i + 1, 2 * i + 3);
    AddTriangle(&mesh, 2 * i, 2 * i + 3, 2 * i + 2);
  }
  const uint32_t centre = AddVertex(&mesh, height * up, up, vec2(0.5f));
  for (int i = 0; i <= slices; ++i) {
    const vec3 d = direction(i);
    AddVertex(&mesh, radius * d + height * up, up, vec2(0.5f + 0.5f * d.x, 0.5f + 0.5f * d.z));
  }
  for (uint32_t i = 1; i <= static_cast<uint32_t>(slices); ++i) {
    AddTriangle(&mesh, centre, centre + i, centre + i + 1);
  }
  return mesh;
}

Mesh MakePatch(int columns, int rows, const std::function<vec3(float, float)>& point, vec2 uv_scale,
               int material) {
  // Parameter step of finite differences: far above the rounding errors of a thin tube's positions,
  // far below the size of a fold of cloth.
  constexpr float kStep = 1.0f / 512.0f;
  Mesh mesh;
  mesh.material = material;
  for (int j = 0; j <= rows; ++j) {
    const float v = static_cast<float>(j) / static_cast<float>(rows);
    for (int i = 0; i <= columns; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(columns);
      const vec3 along_u = point(u + kStep, v) - point(u - kStep, v);
      const vec3 along_v = point(u, v + kStep) - point(u, v - kStep);
      AddVertex(&mesh, point(u, v), glm::normalize(glm::cross(along_u, along_v)),
                vec2(u, v) * uv_scale);
    }
  }
  const auto at = [&](int i, int j) { return static_cast<uint32_t>(j * (columns + 1) + i); };
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      AddTriangle(&mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1));
      AddTriangle(&mesh, at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return mesh;
}

Mesh MakeTube(const std::function<vec3(float)>& centre, float radius, int sides, int segments,
              int material) {
  const auto point = [&](float u, float v) {
    constexpr float kStep = 1.0f / 64.0f;
    const vec3 along = glm::normalize(centre(v + kStep) - centre(v - kStep));
    const vec3 side = glm::normalize(glm::cross(along, vec3(0.0f, 0.0f, 1.0f)));
    const vec3 other = glm::cross(along, side);
    const float angle = 2.0f * kPi * u;
    return centre(v) + radius * (std::cos(angle) * side + std::sin(angle) * other);
  };
  return MakePatch(sides, segments, point, vec2(1.0f), material);
}

Mesh MakeLathe(const std::vector<vec2>& curve, int slices, vec2 uv_scale, int material) {
  const auto direction = [&](size_t i) { return glm::normalize(curve[i + 1] - curve[i]); };
  // Tangent of a segment at its start or end: shared with the adjacent segment unless the corner is
  // sharp.
  const auto tangent = [&](size_t segment, bool at_end) {
    constexpr float kCosOfSharp = 0.766f;
    const vec2 own = direction(segment);
    if (at_end ? segment + 2 == curve.size() : segment == 0) {
      return own;
    }
    const vec2 next = direction(at_end ? segment + 1 : segment - 1);
    return glm::dot(own, next) < kCosOfSharp ? own : glm::normalize(own + next);
  };
  Mesh mesh;
  mesh.material = material;
  float length = 0.0f;
  for (size_t segment = 0; segment + 1 < curve.size(); ++segment) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    const float along[2] = {length, length + glm::length(curve[segment + 1] - curve[segment])};
    length = along[1];
    for (int i = 0; i <= slices; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(slices);
      const vec3 outward(std::sin(2.0f * kPi * u), 0.0f, std::cos(2.0f * kPi * u));
      for (const bool end : {false, true}) {
        const vec2 at = curve[segment + (end ? 1 : 0)];
        const vec2 t = tangent(segment, end);
        AddVertex(&mesh, at.x * outward + vec3(0.0f, at.y, 0.0f),
                  t.y * outward - vec3(0.0f, t.x, 0.0f), vec2(u, along[end ? 1 : 0]) * uv_scale);
      }
    }
    for (uint32_t i = 0; i < static_cast<uint32_t>(slices); ++i) {
      const uint32_t a = first + 2 * i;
      if (curve[segment].x > 0.0f) {
        AddTriangle(&mesh, a, a + 2, a + 3);
      }
      if (curve[segment + 1].x > 0.0f) {
        AddTriangle(&mesh, a, a + 3, a + 1);
      }
    }
  }
  for (vec3& normal : mesh.normals) {
    normal = glm::normalize(normal);
  }
  return mesh;
}

void AppendMesh(Mesh* mesh, const Mesh& other, vec3 offset) {
  const auto first = static_cast<uint32_t>(mesh->positions.size());
  for (const vec3& position : other.positions) {
    mesh->positions.push_back(position + offset);
  }
  mesh->normals.insert(mesh->normals.end(), other.normals.begin(), other.normals.end());
  mesh->uv[0].insert(mesh->uv[0].end(), other.uv[0].begin(), other.uv[0].end());
  for (const uint32_t index : other.indices) {
    mesh->indices.push_back(first + index);
  }
}

int AddMaterial(Scene* scene, const std::string& name, vec3 colour, float metallic,
                float roughness) {
  Material material;
  material.name = name;
  material.base_color = vec4(colour, 1.0f);
  material.metallic = metallic;
  material.roughness = roughness;
  scene->materials.push_back(std::move(material));
  return static_cast<int>(scene->materials.size()) - 1;
}

int AddTexturedMaterial(Scene* scene, Texture texture, float roughness) {
  const int index = AddMaterial(scene, texture.name, vec3(1.0f), 0.0f, roughness);
  scene->materials.back().base_color_texture.texture = static_cast<int>(scene->textures.size());
  scene->textures.push_back(std::move(texture));
  return index;
}

int AddLightMaterial(Scene* scene, const std::string& name, vec3 radiance) {
  const int index = AddMaterial(scene, name, vec3(0.0f), 0.0f, 1.0f);
  scene->materials.back().emission = radiance;
  return index;
}

int AddNode(Scene* scene, const std::string& name, vec3 translation) {
  Node node;
  node.name = name;
  node.local.translation = translation;
  scene->nodes.push_back(std::move(node));
  return static_cast<int>(scene->nodes.size()) - 1;
}

int AddObject(Scene* scene, const std::string& name, Mesh mesh, vec3 translation) {
  const int node = AddNode(scene, name, translation);
  mesh.name = name;
  scene->instances.push_back({static_cast<int>(scene->meshes.size()), node});
  scene->meshes.push_back(std::move(mesh));
  return node;
}

int AddChild(Scene* scene, const std::string& name, Mesh mesh, vec3 translation, int parent) {
  const int node = AddObject(scene, name, std::move(mesh), translation);
  scene->nodes[static_cast<size_t>(node)].parent = parent;
  return node;
}

int AddCopy(Scene* scene, const std::string& name, int object, vec3 translation) {
  const auto original =
      std::find_if(scene->instances.begin(), scene->instances.end(),
                   [&](const Instance& instance) { return instance.node == object; });
  const int mesh = original->mesh;
  const int node = AddNode(scene, name, translation);
  scene->instances.push_back({mesh, node});
  return node;
}

void Animate(Scene* scene, int node, const std::function<Transform(float)>& pose) {
  AnimationChannel translation;
  translation.node = node;
  translation.property = AnimatedProperty::kTranslation;
  AnimationChannel rotation;
  rotation.node = node;
  rotation.property = AnimatedProperty::kRotation;
  for (int k = 0; k < kBuiltinKeys; ++k) {
    const float time = static_cast<float>(k) / kBuiltinKeysPerSecond;
    const Transform place =
        pose(Ease(static_cast<float>(k) / static_cast<float>(kBuiltinKeys - 1)));
    translation.times.push_back(time);
    translation.values.emplace_back(place.translation, 0.0f);
    rotation.times.push_back(time);
    rotation.values.push_back(place.rotation);
  }
  scene->nodes[static_cast<size_t>(node)].local = pose(0.0f);
  scene->animation.push_back(std::move(translation));
  scene->animation.push_back(std::move(rotation));
}

vec4 RotationAbout(vec3 axis, float radians) {
  return {std::sin(0.5f * radians) * axis, std::cos(0.5f * radians)};
}

vec4 RotationY(float radians) {
  return RotationAbout(vec3(0.0f, 1.0f, 0.0f), radians);
}

Transform LookAt(vec3 eye, vec3 target) {
  const vec3 back = glm::normalize(eye - target);
  const vec3 right = glm::normalize(glm::cross(vec3(0.0f, 1.0f, 0.0f), back));
  const glm::quat q = glm::normalize(glm::quat_cast(mat3(right, glm::cross(back, right), back)));
  Transform pose;
  pose.translation = eye;
  pose.rotation = vec4(q.x, q.y, q.z, q.w);
  return pose;
}

void AddAnimatedCamera(Scene* scene, float yfov, const std::function<Transform(float)>& pose) {
  Camera camera;
  camera.name = "camera";
  camera.node = AddNode(scene, "camera", vec3(0.0f));
  camera.yfov = yfov;
  camera.aspect = 16.0f / 9.0f;
  scene->cameras.push_back(std::move(camera));
  Animate(scene, scene->cameras.back().node, pose);
}

void AddSwingingCamera(Scene* scene, vec3 target, vec2 distance, float slope) {
  constexpr float kFieldOfView = 0.61f;
  constexpr float kSwing = 0.07f;  // radians to either side
  AddAnimatedCamera(scene, kFieldOfView, [=](float t) {
    const float angle = glm::mix(-kSwing, kSwing, t);
    const float along = glm::mix(distance.x, distance.y, t);
    const vec3 offset(std::sin(angle) * along, slope * along, std::cos(angle) * along);
    return LookAt(target + offset, target);
  });
}

void AddRoomSides(Scene* scene, vec3 corner, vec3 size, const RoomSides& sides) {
  const vec3 x(size.x, 0.0f, 0.0f);
  const vec3 y(0.0f, size.y, 0.0f);
  const vec3 z(0.0f, 0.0f, size.z);
  const auto add = [&](const char* name, vec3 origin, vec3 u, vec3 v, const RoomSide& side) {
    AddObject(scene, name, MakeQuad(origin, u, v, side.repeats, side.material), vec3(0.0f));
  };
  add("floor", corner, z, x, sides.floor);
  add("ceiling", corner + y, x, z, sides.ceiling);
  add("back wall", corner, x, y, sides.back);
  add("left wall", corner + z, -z, y, sides.left);
  add("right wall", corner + x, z, y, sides.right);
  add("front wall", corner + z + x, -x, y, sides.front);
}

void AddTiledGround(Scene* scene, float roughness, uint32_t seed) {
  const int tiles =
      AddTexturedMaterial(scene,
                          MakeTiles("ground", 1024, 8, vec3(0.46f, 0.42f, 0.36f),
                                    vec3(0.20f, 0.20f, 0.21f), vec3(0.12f, 0.11f, 0.10f), seed),
                          roughness);
  constexpr float kHalf = 40.0f;
  constexpr float kMetresPerTexture = 4.0f;
  AddObject(scene, "ground",
            MakeQuad(vec3(-kHalf, 0.0f, -kHalf), vec3(0.0f, 0.0f, 2.0f * kHalf),
                     vec3(2.0f * kHalf, 0.0f, 0.0f), vec2(2.0f * kHalf / kMetresPerTexture), tiles),
            vec3(0.0f));
}

}  // namespace stillray

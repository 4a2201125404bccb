// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A hall without a roof between two storeys of arches, in sunlight. Curtains hang between the
/// columns; most of the hall is lit by light reflected from the sunlit side.
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "scene/builtin.h"

namespace stillray {

namespace {

// Metres. x runs across the hall, z along it.
constexpr float kPi = 3.14159265f;
constexpr int kBays = 6;
constexpr float kBay = 3.0f;
constexpr float kHalfLength = 0.5f * kBays * kBay;
constexpr float kColumnsX = 3.0f;   // x of the columns' axes
constexpr float kOuterX = 5.6f;     // x of the outer walls
constexpr float kSpringing = 3.6f;  // springing line of the lower arches
constexpr float kGallery = 5.3f;    // floor of the upper storey
constexpr float kUpperSpringing = 6.9f;
constexpr float kRoof = 8.5f;
constexpr float kThickness = 0.6f;  // thickness of the walls on the columns

struct Stones {
  int floor = -1;
  int wall = -1;
  int column = -1;
  int trim = -1;
  int wood = -1;
};

Stones AddStones(Scene* scene) {
  Stones stones;
  stones.floor =
      AddTexturedMaterial(scene,
                          MakeTiles("floor", 1024, 6, vec3(0.60f, 0.54f, 0.45f),
                                    vec3(0.40f, 0.27f, 0.20f), vec3(0.24f, 0.21f, 0.18f), 211),
                          0.3f);
  stones.wall = AddTexturedMaterial(
      scene,
      MakeBricks("ashlar", 1024, 10, vec3(0.62f, 0.55f, 0.44f), vec3(0.46f, 0.41f, 0.34f), 223),
      0.9f);
  stones.column = AddTexturedMaterial(
      scene,
      MakeMottled("columns", 512, 4, vec3(0.68f, 0.63f, 0.55f), vec3(0.55f, 0.48f, 0.39f), 227),
      0.6f);
  stones.trim = AddTexturedMaterial(
      scene, MakeMottled("trim", 512, 6, vec3(0.70f, 0.66f, 0.58f), vec3(0.60f, 0.55f, 0.46f), 229),
      0.8f);
  stones.wood = AddTexturedMaterial(
      scene,
      MakePlanks("beams", 1024, 8, vec3(0.42f, 0.28f, 0.17f), vec3(0.20f, 0.12f, 0.07f), 233),
      0.7f);
  return stones;
}

void AddVertex(Mesh* mesh, vec3 position, vec3 normal, vec2 uv) {
  mesh->positions.push_back(position);
  mesh->normals.push_back(normal);
  mesh->uv[0].push_back(uv);
}

/// Corners are counter-clockwise from the front.
void AddQuad(Mesh* mesh, const std::array<vec3, 4>& corners, const std::array<vec3, 4>& normals,
             const std::array<vec2, 4>& uv) {
  const auto first = static_cast<uint32_t>(mesh->positions.size());
  for (size_t i = 0; i < 4; ++i) {
    AddVertex(mesh, corners[i], normals[i], uv[i]);
  }
  mesh->indices.insert(mesh->indices.end(),
                       {first, first + 1, first + 2, first, first + 2, first + 3});
}

/// A wall in the xy plane, `thickness` thick, with a round arch of `radius` over each bay. Between
/// the arches it has piers of width `pier` that end at `springing`. x = 0 is the middle of the
/// first pier.
struct Arcade {
  int bays = 1;
  float bay = 3.0f;
  float radius = 1.2f;
  float springing = 0.0f;
  float top = 0.0f;
  float thickness = 0.5f;
  float texture = 3.0f;  ///< units per texture
};

/// Both faces of the wall between two points of its lower edge and its top.
void AddWallStrip(const Arcade& arcade, vec2 left, vec2 right, Mesh* mesh) {
  const float half = 0.5f * arcade.thickness;
  const auto uv = [&](vec2 p) { return vec2(p.x, arcade.top - p.y) / arcade.texture; };
  const vec2 left_top(left.x, arcade.top);
  const vec2 right_top(right.x, arcade.top);
  const vec3 front(0.0f, 0.0f, 1.0f);
  AddQuad(mesh, {vec3(left, half), vec3(right, half), vec3(right_top, half), vec3(left_top, half)},
          {front, front, front, front}, {uv(left), uv(right), uv(right_top), uv(left_top)});
  AddQuad(mesh,
          {vec3(right, -half), vec3(left, -half), vec3(left_top, -half), vec3(right_top, -half)},
          {-front, -front, -front, -front}, {uv(right), uv(left), uv(left_top), uv(right_top)});
}

/// The underside between two points of the lower edge.
void AddUnderside(const Arcade& arcade, vec2 left, vec2 right, vec2 left_normal, vec2 right_normal,
                  float along, Mesh* mesh) {
  const float half = 0.5f * arcade.thickness;
  const float u0 = along / arcade.texture;
  const float u1 = (along + glm::length(right - left)) / arcade.texture;
  const float v = arcade.thickness / arcade.texture;
  AddQuad(mesh, {vec3(left, -half), vec3(right, -half), vec3(right, half), vec3(left, half)},
          {vec3(left_normal, 0.0f), vec3(right_normal, 0.0f), vec3(right_normal, 0.0f),
           vec3(left_normal, 0.0f)},
          {vec2(u0, 0.0f), vec2(u1, 0.0f), vec2(u1, v), vec2(u0, v)});
}

Mesh MakeArcade(const Arcade& arcade, int material) {
  constexpr int kSegments = 48;
  const vec2 down(0.0f, -1.0f);
  Mesh mesh;
  mesh.material = material;
  const float half_pier = 0.5f * arcade.bay - arcade.radius;
  for (int bay = 0; bay <= arcade.bays; ++bay) {
    const float x = static_cast<float>(bay) * arcade.bay;
    const vec2 left(x - half_pier, arcade.springing);
    const vec2 right(x + half_pier, arcade.springing);
    AddWallStrip(arcade, left, right, &mesh);
    AddUnderside(arcade, left, right, down, down, 0.0f, &mesh);
    if (bay == arcade.bays) {
      break;
    }
    const vec2 centre(x + 0.5f * arcade.bay, arcade.springing);
    const auto outward = [](int i) {
      const float angle = kPi * (1.0f - static_cast<float>(i) / kSegments);
      // Exactly vertical at both ends, where the next wall begins.
      return i == 0           ? vec2(-1.0f, 0.0f)
             : i == kSegments ? vec2(1.0f, 0.0f)
                              : vec2(std::cos(angle), std::sin(angle));
    };
    for (int i = 0; i < kSegments; ++i) {
      const vec2 a = outward(i);
      const vec2 b = outward(i + 1);
      AddWallStrip(arcade, centre + arcade.radius * a, centre + arcade.radius * b, &mesh);
      AddUnderside(arcade, centre + arcade.radius * a, centre + arcade.radius * b, -a, -b,
                   kPi * arcade.radius * static_cast<float>(i) / kSegments, &mesh);
    }
  }
  return mesh;
}

/// Rounds of the base, a shaft that narrows upwards, and a capital that widens under the arch.
Mesh MakeColumn(int material) {
  std::vector<vec2> curve;
  const auto round = [&](float radius, float y, float size, int steps) {
    for (int i = 0; i <= steps; ++i) {
      const float angle = kPi * (static_cast<float>(i) / static_cast<float>(steps) - 0.5f);
      curve.emplace_back(radius + size * std::cos(angle), y + size * (1.0f + std::sin(angle)));
    }
  };
  round(0.33f, 0.20f, 0.055f, 10);
  curve.emplace_back(0.325f, 0.32f);
  curve.emplace_back(0.305f, 0.345f);
  round(0.30f, 0.36f, 0.03f, 8);
  curve.emplace_back(0.29f, 0.43f);
  constexpr int kShaft = 16;
  for (int i = 0; i <= kShaft; ++i) {
    const float t = static_cast<float>(i) / kShaft;
    curve.emplace_back(0.275f - 0.045f * t * t, 0.46f + 2.62f * t);
  }
  round(0.235f, 3.09f, 0.025f, 8);
  curve.emplace_back(0.235f, 3.15f);
  constexpr int kBell = 12;
  for (int i = 0; i <= kBell; ++i) {
    const float t = static_cast<float>(i) / kBell;
    curve.emplace_back(0.235f + 0.135f * (1.0f - std::sqrt(1.0f - 0.96f * t * t)),
                       3.16f + 0.26f * t);
  }
  curve.emplace_back(0.37f, 3.47f);
  return MakeLathe(curve, 64, vec2(3.0f, 1.0f), material);
}

/// Adds a row of instances of a mesh, one per pier, at distance `x` from the middle.
void AddPiers(Scene* scene, const std::string& name, const Mesh& mesh, float x, float y) {
  int first = -1;
  for (int i = 0; i <= kBays; ++i) {
    const vec3 place(x, y, -kHalfLength + kBay * static_cast<float>(i));
    if (i == 0) {
      first = AddObject(scene, name, mesh, place);
    } else {
      AddCopy(scene, name, first, place);
    }
  }
}

/// Columns with arches, and the gallery on top of them. `side` is -1 or 1.
void AddSide(Scene* scene, const Stones& stones, float side) {
  const float x = side * kColumnsX;
  AddPiers(scene, "plinth", MakeBox(vec3(0.80f, 0.20f, 0.80f), 0.5f, stones.trim), x, 0.0f);
  AddPiers(scene, "column", MakeColumn(stones.column), x, 0.0f);
  AddPiers(scene, "abacus", MakeBox(vec3(0.80f, kSpringing - 3.46f, 0.80f), 0.5f, stones.trim), x,
           3.46f);
  AddPiers(scene, "upper pier",
           MakeBox(vec3(0.5f, kUpperSpringing - kGallery, 0.5f), 0.5f, stones.column), x, kGallery);
  AddPiers(scene, "upper abacus", MakeBox(vec3(0.66f, 0.12f, 0.66f), 0.5f, stones.trim), x,
           kUpperSpringing - 0.12f);
  Arcade lower;
  lower.bays = kBays;
  lower.bay = kBay;
  lower.radius = 1.18f;
  lower.springing = kSpringing;
  lower.top = kGallery - 0.25f;
  lower.thickness = kThickness;
  Arcade upper = lower;
  upper.radius = 1.22f;
  upper.springing = kUpperSpringing;
  upper.top = kRoof - 0.2f;
  upper.thickness = 0.46f;
  const vec3 end(x, 0.0f, kHalfLength);
  for (const auto& [name, arcade] : {std::pair<const char*, Arcade>{"lower arches", lower},
                                     std::pair<const char*, Arcade>{"upper arches", upper}}) {
    const int node = AddObject(scene, name, MakeArcade(arcade, stones.wall), end);
    scene->nodes[static_cast<size_t>(node)].local.rotation = RotationY(0.5f * kPi);
  }
  const float length = 2.0f * kHalfLength;
  // From the outer wall to the edge of the nave.
  const float width = kOuterX - kColumnsX + 0.5f * kThickness + 0.08f;
  const float middle = side * (kOuterX - 0.5f * width);
  AddObject(scene, "gallery", MakeBox(vec3(width, 0.25f, length), 0.4f, stones.trim),
            vec3(middle, kGallery - 0.25f, 0.0f));
  AddObject(scene, "eaves", MakeBox(vec3(width + 0.12f, 0.2f, length), 0.4f, stones.trim),
            vec3(middle - side * 0.06f, kRoof - 0.2f, 0.0f));
  AddObject(scene, "ledge", MakeBox(vec3(0.09f, 0.10f, length), 0.4f, stones.trim),
            vec3(side * (kColumnsX - 0.5f * kThickness - 0.045f), kGallery - 0.42f, 0.0f));
  AddObject(
      scene, "ceiling",
      MakeQuad(vec3(middle - 0.5f * width, kGallery - 0.26f, -kHalfLength), vec3(width, 0.0f, 0.0f),
               vec3(0.0f, 0.0f, length), vec2(width, length) / 2.4f, stones.wood),
      vec3(0.0f));
  const vec3 up(0.0f, kRoof, 0.0f);
  const vec3 along(0.0f, 0.0f, side * length);
  AddObject(scene, "outer wall",
            MakeQuad(vec3(side * kOuterX, 0.0f, -side * kHalfLength), along, up,
                     vec2(length, kRoof) / 3.0f, stones.wall),
            vec3(0.0f));
}

/// The floor, and the walls at both ends with a portal in one.
void AddEnds(Scene* scene, const Stones& stones) {
  const float length = 2.0f * kHalfLength;
  const float width = 2.0f * kOuterX;
  const vec3 x(width, 0.0f, 0.0f);
  const vec3 y(0.0f, kRoof, 0.0f);
  const vec3 back(-kOuterX, 0.0f, -kHalfLength);
  const vec3 front(kOuterX, 0.0f, kHalfLength);
  AddObject(scene, "floor",
            MakeQuad(back, vec3(0.0f, 0.0f, length), x, vec2(length, width) / 3.0f, stones.floor),
            vec3(0.0f));
  AddObject(scene, "back wall", MakeQuad(back, x, y, vec2(width, kRoof) / 3.0f, stones.wall),
            vec3(0.0f));
  AddObject(scene, "front wall", MakeQuad(front, -x, y, vec2(width, kRoof) / 3.0f, stones.wall),
            vec3(0.0f));
  Arcade portal;
  portal.bay = 2.9f;
  portal.radius = 1.1f;
  portal.springing = 2.6f;
  portal.top = 4.3f;
  portal.thickness = 0.5f;
  const float z = -kHalfLength + 0.25f;
  AddObject(scene, "portal", MakeArcade(portal, stones.trim), vec3(-1.45f, 0.0f, z));
  for (const float at : {-1.45f, 1.45f}) {
    AddObject(scene, "portal pier", MakeBox(vec3(0.7f, 2.6f, 0.5f), 0.4f, stones.trim),
              vec3(at, 0.0f, z));
  }
  AddObject(scene, "portal roof", MakeBox(vec3(3.8f, 0.16f, 0.66f), 0.4f, stones.trim),
            vec3(0.0f, 4.3f, z + 0.05f));
  AddObject(scene, "door",
            MakeQuad(vec3(-1.2f, 0.0f, -kHalfLength + 0.01f), vec3(2.4f, 0.0f, 0.0f),
                     vec3(0.0f, 4.0f, 0.0f), vec2(1.0f, 1.6f), stones.wood),
            vec3(0.0f));
}

/// A curtain that hangs from y = 0 in the yz plane, gathered on its rod.
Mesh MakeCurtain(vec2 size, float phase, int material) {
  constexpr float kFolds = 7.0f;
  return MakePatch(
      192, 48,
      [=](float u, float v) {
        const float hang = 1.0f - v;
        const float along = 2.0f * kPi * kFolds * u + 0.5f * std::sin(5.0f * v + phase);
        const float fold = std::sin(along + phase) + 0.4f * std::sin(0.5f * along + 3.0f * v);
        return vec3((0.05f + 0.045f * hang) * fold, (v - 1.0f) * size.y,
                    (0.5f - u) * size.x * (0.92f + 0.08f * hang));
      },
      size / 0.8f, material);
}

void AddCurtains(Scene* scene) {
  const int brass = AddMaterial(scene, "brass", vec3(0.88f, 0.70f, 0.38f), 1.0f, 0.3f);
  struct Cloth {
    const char* name;
    vec3 light;
    vec3 dark;
  };
  const std::array<Cloth, 3> cloths = {{
      {"red velvet", vec3(0.46f, 0.06f, 0.05f), vec3(0.30f, 0.03f, 0.03f)},
      {"green velvet", vec3(0.11f, 0.26f, 0.12f), vec3(0.06f, 0.17f, 0.08f)},
      {"blue velvet", vec3(0.10f, 0.19f, 0.48f), vec3(0.05f, 0.11f, 0.33f)},
  }};
  std::array<int, 3> materials{};
  for (size_t i = 0; i < cloths.size(); ++i) {
    const auto seed = static_cast<uint32_t>(241 + i);
    materials[i] = AddTexturedMaterial(
        scene, MakeMottled(cloths[i].name, 256, 6, cloths[i].light, cloths[i].dark, seed), 0.9f);
    scene->materials.back().double_sided = true;
  }
  const vec2 size(2.1f, 2.5f);
  constexpr float kRod = 3.3f;
  for (int i = 0; i < 2 * kBays; ++i) {
    const bool left = i < kBays;
    const int bay = i % kBays;
    // Every other arch stays open, the first ones on the left.
    if (bay % 2 != (left ? 1 : 0)) {
      continue;
    }
    const float phase = 1.7f * static_cast<float>(i);
    const vec3 place(left ? -kColumnsX : kColumnsX, kRod,
                     kHalfLength - kBay * (static_cast<float>(bay) + 0.5f));
    const vec3 half(0.0f, 0.0f, 0.5f * kBay - 0.2f);
    AddObject(scene, fmt::format("rod {}", i + 1),
              MakePatch(
                  16, 1,
                  [=](float u, float v) {
                    const float angle = 2.0f * kPi * u;
                    return glm::mix(-half, half, v) +
                           0.02f * vec3(std::cos(angle), std::sin(angle), 0.0f);
                  },
                  vec2(1.0f), brass),
              place);
    const int curtain =
        AddObject(scene, fmt::format("curtain {}", i + 1),
                  MakeCurtain(size, phase, materials[static_cast<size_t>(bay / 2)]), place);
    Animate(scene, curtain, [=](float t) {
      constexpr float kSwing = 0.07f;
      Transform pose;
      pose.translation = place;
      pose.rotation =
          RotationAbout(vec3(0.0f, 0.0f, 1.0f), kSwing * std::sin(2.0f * kPi * 1.5f * t + phase));
      return pose;
    });
  }
}

/// Adds sunlight over the right eaves, which lights the left half of the hall.
void AddSun(Scene* scene) {
  scene->environment.radiance = vec3(0.62f, 0.78f, 1.02f);
  PunctualLight sun;
  sun.name = "sun";
  sun.type = LightType::kDirectional;
  sun.intensity = vec3(11.5f, 10.0f, 8.0f);
  sun.node = AddNode(scene, "sun", vec3(0.0f));
  const vec3 towards_sun(0.35f, 0.85f, 0.36f);
  scene->nodes.back().local = LookAt(20.0f * towards_sun, vec3(0.0f));
  scene->lights.push_back(std::move(sun));
}

}  // namespace

Scene MakeColonnadeScene() {
  Scene scene;
  const Stones stones = AddStones(&scene);
  AddSide(&scene, stones, -1.0f);
  AddSide(&scene, stones, 1.0f);
  AddEnds(&scene, stones);
  AddCurtains(&scene);
  AddSun(&scene);
  constexpr float kFieldOfView = 0.95f;
  AddAnimatedCamera(&scene, kFieldOfView, [](float t) {
    const vec3 eye = glm::mix(vec3(1.5f, 1.75f, 8.2f), vec3(1.0f, 1.95f, 6.9f), t);
    return LookAt(eye, glm::mix(vec3(-1.1f, 2.7f, -2.0f), vec3(-1.3f, 2.8f, -2.0f), t));
  });
  return scene;
}

}  // namespace stillray

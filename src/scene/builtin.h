// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The built-in scenes and their components.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "stillray/scene.h"

namespace stillray {

Scene MakeCornellScene();
Scene MakeSpheresScene();
Scene MakeLightsScene();
Scene MakeMirrorsScene();
Scene MakeMaterialsScene();
Scene MakeThinScene();
Scene MakeFaustScene();
Scene MakeColonnadeScene();
Scene MakeCarScene();

// Shapes. All normals point outward, all faces are counter-clockwise from outside.

/// The parallelogram origin + s * edge_u + t * edge_v, facing cross(edge_u, edge_v); texture
/// coordinates (s, t) * uv_scale.
Mesh MakeQuad(vec3 origin, vec3 edge_u, vec3 edge_v, vec2 uv_scale, int material);
/// A box on the plane y = 0, centred over the origin. Each face has `repeats` textures per unit
/// length.
Mesh MakeBox(vec3 size, float repeats, int material);
/// A sphere about the origin, with a seam at u = 0.
Mesh MakeSphere(float radius, int slices, int stacks, int material);
/// A cylinder with a lid that stands on y = 0 about the y axis.
Mesh MakeCylinder(float radius, float height, int slices, vec2 uv_scale, int material);
/// The curved surface point(u, v), u and v in 0..1, of columns x rows quads, that faces
/// cross(d point / du, d point / dv); texture coordinates (u, v) * uv_scale. `point` is also
/// evaluated slightly outside 0..1.
Mesh MakePatch(int columns, int rows, const std::function<vec3(float, float)>& point, vec2 uv_scale,
               int material);
/// An open tube along centre(t), t in 0..1, which is nowhere parallel to the z axis.
Mesh MakeTube(const std::function<vec3(float)>& centre, float radius, int sides, int segments,
              int material);
/// The surface of revolution of a curve of (radius, y) about the y axis; outward faces run from
/// bottom to top. Corners of the curve up to 40 degrees are rounded by their normals. Texture
/// coordinates (turns, length of the curve) * uv_scale.
Mesh MakeLathe(const std::vector<vec2>& curve, int slices, vec2 uv_scale, int material);
/// The closed surface distance(p) = 0 inside `bounds`, from a grid of cubic cells of side `cell`.
/// `distance` is negative inside, with an error of at most a factor of 2. Features smaller than a
/// cell are lost. Texture coordinates (x, z). Evaluates `distance` in parallel.
Mesh MakeIsosurface(const Aabb& bounds, float cell, const std::function<float(vec3)>& distance,
                    int material);
/// Appends a mesh of the same material.
void AppendMesh(Mesh* mesh, const Mesh& other, vec3 offset);

// Textures of size x size texels that repeat without seams.

/// Staggered planks along v, in `columns` columns, with grain and dark joints.
Texture MakePlanks(const std::string& name, int size, int columns, vec3 light, vec3 dark,
                   uint32_t seed);
/// Square tiles with joints, each of its own shade.
Texture MakeTiles(const std::string& name, int size, int tiles, vec3 tile, vec3 other, vec3 joint,
                  uint32_t seed);
/// Bricks in stretcher bond: `rows` rows, half as many bricks in a row.
Texture MakeBricks(const std::string& name, int size, int rows, vec3 brick, vec3 mortar,
                   uint32_t seed);
/// Stone or plaster: soft patches of both colours, `patches` along a side, with fine grain.
Texture MakeMottled(const std::string& name, int size, int patches, vec3 light, vec3 dark,
                    uint32_t seed);
/// A blue sky with a large soft sun, and a dull ground.
Environment MakeSky();

// Assembling a scene. All functions return the new element's index.

int AddMaterial(Scene* scene, const std::string& name, vec3 colour, float metallic,
                float roughness);
int AddTexturedMaterial(Scene* scene, Texture texture, float roughness);
int AddLightMaterial(Scene* scene, const std::string& name, vec3 radiance);
int AddNode(Scene* scene, const std::string& name, vec3 translation);
/// Adds a mesh on its own node at `translation`; returns the node's index.
int AddObject(Scene* scene, const std::string& name, Mesh mesh, vec3 translation);
/// Adds a mesh on its own node below a parent node, whose space `translation` is in.
int AddChild(Scene* scene, const std::string& name, Mesh mesh, vec3 translation, int parent);
/// Adds another instance of the mesh of `object`, a node returned by AddObject.
int AddCopy(Scene* scene, const std::string& name, int object, vec3 translation);

/// A side of a room: its material, and the texture's repeats along its width and height.
struct RoomSide {
  int material = 0;
  vec2 repeats{1.0f};
};

struct RoomSides {
  RoomSide floor;
  RoomSide ceiling;
  RoomSide back;
  RoomSide left;
  RoomSide right;
  RoomSide front;
};

/// Adds the six sides of a box, facing inwards, as objects: "floor", "ceiling", "back wall", ...
/// \param corner the bottom left back corner
void AddRoomSides(Scene* scene, vec3 corner, vec3 size, const RoomSides& sides);
/// Adds a large square of tiles on the plane y = 0.
void AddTiledGround(Scene* scene, float roughness, uint32_t seed);

/// The animation of the built-in scenes: 120 keyframes, 30 per second.
inline constexpr int kBuiltinKeys = 120;
inline constexpr float kBuiltinKeysPerSecond = 30.0f;

/// Animates a node: `pose` maps progress 0..1, eased at both ends, to the node's transform.
void Animate(Scene* scene, int node, const std::function<Transform(float)>& pose);
/// Rotation about an axis of unit length.
vec4 RotationAbout(vec3 axis, float radians);
/// Rotation about the y axis.
vec4 RotationY(float radians);
/// A pose at `eye` whose -z points to `target`, upright.
Transform LookAt(vec3 eye, vec3 target);
/// Adds a camera with its own animated node.
void AddAnimatedCamera(Scene* scene, float yfov, const std::function<Transform(float)>& pose);
/// Adds a camera that swings about `target` by 0.07 radians to either side.
/// \param distance  horizontal distance at the beginning and at the end
/// \param slope     height of the camera above the target, as a fraction of the distance
void AddSwingingCamera(Scene* scene, vec3 target, vec2 distance, float slope);

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A scene as plain data: the subset of glTF 2.0 that the path tracer renders. Axes as in glTF:
/// right-handed, y up, cameras look along their node's -z; lengths in scene units.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "stillray/image.h"
#include "stillray/status.h"
#include "stillray/vec.h"

namespace stillray {

enum class Wrap : uint8_t { kRepeat, kMirror, kClamp };

/// 8-bit RGBA texels, rows from the top. Whether RGB is sRGB-encoded depends on the slot that uses
/// the texture (glTF 2.0, 3.9.2): base colour and emissive are, the others are linear.
struct Texture {
  std::string name;
  int width = 0;
  int height = 0;
  std::vector<uint8_t> texels;  ///< width * height * 4 bytes
  Wrap wrap_u = Wrap::kRepeat;
  Wrap wrap_v = Wrap::kRepeat;
  bool nearest = false;  ///< no interpolation
};

/// A use of a texture. `transform` maps the mesh's (u, v, 1) to texture coordinates
/// (KHR_texture_transform); (0,0) is the texture's top left.
struct TextureRef {
  int texture = -1;  ///< index into Scene::textures; -1 = none
  int uv_set = 0;    ///< 0 or 1
  mat3 transform = mat3(1.0f);
};

enum class AlphaMode : uint8_t { kOpaque, kMask, kBlend };

/// glTF metallic-roughness material with the supported extensions. All colours linear.
struct Material {
  std::string name;
  vec4 base_color = vec4(1.0f);
  TextureRef base_color_texture;  ///< sRGB
  float metallic = 1.0f;
  float roughness = 1.0f;                 ///< perceptual; GGX alpha is its square
  TextureRef metallic_roughness_texture;  ///< linear; G roughness, B metallic
  TextureRef normal_texture;              ///< linear, tangent space
  float normal_scale = 1.0f;
  vec3 emission = vec3(0.0f);   ///< emissiveFactor x KHR_materials_emissive_strength: radiance
  TextureRef emissive_texture;  ///< sRGB
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;        ///< also: emits from both faces
  float transmission = 0.0f;        ///< KHR_materials_transmission
  TextureRef transmission_texture;  ///< linear, R
  float ior = 1.5f;                 ///< KHR_materials_ior
  /// KHR_materials_volume present with thickness > 0: the mesh bounds a solid, rays refract.
  /// Otherwise the surface is an infinitely thin sheet: transmitted rays keep their direction.
  bool solid = false;
  vec3 attenuation_color = vec3(1.0f);
  float attenuation_distance = std::numeric_limits<float>::infinity();
  /// KHR_materials_volume_scatter, of solids: multiple-scattering albedo, 0 to 1 (0 = no
  /// scattering), and mean cosine of the scattering angle, -1 to 1 exclusive. The attenuation above
  /// then includes absorption and scattering.
  vec3 multiscatter_color = vec3(0.0f);
  float scatter_anisotropy = 0.0f;
  /// KHR_materials_specular: weight and colour of a dielectric's reflection. The colour applies at
  /// normal incidence and may be above 1. Transmission keeps the reflection of its ior.
  float specular = 1.0f;
  TextureRef specular_texture;  ///< linear, A
  vec3 specular_color = vec3(1.0f);
  TextureRef specular_color_texture;  ///< sRGB
  /// KHR_materials_clearcoat: a dielectric coat of ior 1.5 above all other layers.
  float clearcoat = 0.0f;
  TextureRef clearcoat_texture;  ///< linear, R
  float clearcoat_roughness = 0.0f;
  TextureRef clearcoat_roughness_texture;  ///< linear, G
  /// Linear, tangent space; without it the coat has the mesh's normals, not `normal_texture`.
  TextureRef clearcoat_normal_texture;
  float clearcoat_normal_scale = 1.0f;
  /// KHR_materials_sheen: a layer of fibres below the clear coat and above all other layers.
  vec3 sheen_color = vec3(0.0f);
  TextureRef sheen_color_texture;  ///< sRGB
  float sheen_roughness = 0.0f;
  TextureRef sheen_roughness_texture;  ///< linear, A
  /// KHR_materials_diffuse_transmission: the fraction of diffuse reflection that is transmitted
  /// instead, 0 to 1, and its colour.
  float diffuse_transmission = 0.0f;
  TextureRef diffuse_transmission_texture;  ///< linear, A
  vec3 diffuse_transmission_color = vec3(1.0f);
  TextureRef diffuse_transmission_color_texture;  ///< sRGB
  /// KHR_materials_anisotropy: strength, 0 to 1, of the stretching of metallic and dielectric
  /// reflections along a direction at `anisotropy_rotation` radians from the mesh's tangent towards
  /// its bitangent. Transmission and the clear coat are isotropic.
  float anisotropy = 0.0f;
  float anisotropy_rotation = 0.0f;
  /// Linear; RG the direction by tangent and bitangent, -1 to 1, before the rotation; B strength.
  TextureRef anisotropy_texture;
  /// KHR_materials_iridescence: weight, 0 to 1, of a thin film on the metal, the dielectric or the
  /// glass, below the clear coat and the sheen.
  float iridescence = 0.0f;
  TextureRef iridescence_texture;  ///< linear, R
  float iridescence_ior = 1.3f;    ///< of the film, at least 1
  /// Thickness of the film in nanometres: the texture interpolates between `min` and `max`; `max`
  /// without a texture.
  float iridescence_thickness_min = 100.0f;
  float iridescence_thickness_max = 400.0f;
  TextureRef iridescence_thickness_texture;  ///< linear, G

  bool emits() const { return emission.x > 0 || emission.y > 0 || emission.z > 0; }
};

/// Vertex offsets of a morph target. `vertices`: indices of the moved vertices; the other arrays
/// have the same size or are empty.
struct MorphTarget {
  std::vector<uint32_t> vertices;  ///< increasing
  std::vector<vec3> positions;
  std::vector<vec3> normals;
  std::vector<vec3> tangents;
};

/// Triangles with one material (a glTF primitive). All per-vertex arrays have the size of
/// `positions` or are empty, except `normals`, which are always given. If the mesh deforms,
/// positions, normals and tangents describe the rest pose.
struct Mesh {
  std::string name;
  std::vector<vec3> positions;
  std::vector<vec3> normals;  ///< unit length
  /// Unit length, w = handedness; given where the material has a normal map or anisotropy.
  std::vector<vec4> tangents;
  std::vector<vec2> uv[2];
  std::vector<vec4> colors;       ///< linear, multiplied into the base colour
  std::vector<uint32_t> indices;  ///< three per triangle, counter-clockwise seen from the front
  int material = -1;              ///< index into Scene::materials (never -1 in a loaded scene)
  std::vector<MorphTarget> targets;
  int influences = 0;            ///< joints per vertex, for skins; 0: none
  std::vector<uint16_t> joints;  ///< `influences` per vertex: indices into Skin::joints
  std::vector<float> weights;    ///< of these joints: >= 0, sum 1 for each vertex
  bool flat_normals = false;     ///< normals are recomputed per triangle when the mesh deforms
};

/// Local transform of a node as glTF stores it.
struct Transform {
  vec3 translation = vec3(0.0f);
  vec4 rotation = vec4(0.0f, 0.0f, 0.0f, 1.0f);  ///< unit quaternion x, y, z, w
  vec3 scale = vec3(1.0f);
  mat4 ToMatrix() const;
};

/// A node of the scene graph.
struct Node {
  std::string name;
  int parent = -1;          ///< index into Scene::nodes; -1: none
  Transform local;          ///< relative to the parent
  bool has_matrix = false;  ///< `matrix` replaces `local`
  mat4 matrix = mat4(1.0f);
  /// Weights of the morph targets of the node's meshes, before animation; empty: all 0.
  std::vector<float> weights;
};

/// Nodes that move the vertices of meshes (glTF 2.0, 3.7.3).
struct Skin {
  std::string name;
  std::vector<int> joints;         ///< indices into Scene::nodes, at least one
  std::vector<mat4> inverse_bind;  ///< per joint: from the mesh's rest pose to the joint's space
};

/// A mesh placed in the scene. Its id in Guides::id is its index in Scene::instances + 1.
struct Instance {
  int mesh = -1;  ///< index into Scene::meshes
  int node = -1;  ///< index into Scene::nodes
  /// Index into Scene::skins; -1: none. With a skin the mesh follows the joints, and the transform
  /// of its node is ignored.
  int skin = -1;
};

/// A thin lens (docs/lens.md). With radius 0 and f_number 0 the camera is a pinhole.
struct Lens {
  float radius = 0.0f;    ///< of the aperture, scene units
  float f_number = 0.0f;  ///< > 0: the radius is f / (2 f_number) metres, with f for a 36 mm sensor
  float focus = 0.0f;     ///< depth of the plane of focus, <= infinity; 0: of the image centre
  int blades = 0;         ///< corners of the aperture, a regular polygon in the circle; 0: a circle
  float rotation = 0.0f;  ///< of the first corner from the right, anticlockwise, degrees
  int mask = -1;  ///< index into Scene::textures, whose brightness is the aperture's transmittance;
                  ///< -1: none
};

/// Largest width or height of a lens mask, in texels.
inline constexpr int kMaxLensMaskSide = 2048;
inline constexpr int kMaxBlades = 32;

/// A perspective camera; looks along its node's -z.
struct Camera {
  std::string name;
  int node = -1;        ///< index into Scene::nodes
  float yfov = 0.8f;    ///< vertical angle of view, radians
  float aspect = 0.0f;  ///< width / height that the camera was framed for; 0 = not given
  Lens lens = {};
};

enum class LightType : uint8_t { kPoint, kSpot, kDirectional };

/// KHR_lights_punctual. Intensity: radiant intensity (point, spot) or irradiance (directional) in
/// the scene's units, without photometric conversion. Emits along its node's -z. Range in scene
/// units, cone angles in radians from the axis.
struct PunctualLight {
  std::string name;
  LightType type = LightType::kPoint;
  int node = -1;
  vec3 intensity = vec3(0.0f);
  float range = std::numeric_limits<float>::infinity();
  float inner_cone_angle = 0.0f;
  float outer_cone_angle = 0.7853982f;
};

enum class Interpolation : uint8_t { kStep, kLinear, kCubicSpline };
enum class AnimatedProperty : uint8_t { kTranslation, kRotation, kScale, kWeights };

/// Keyframes of one property of one node. For kCubicSpline each key has three values: in-tangent,
/// value, out-tangent. The first value holds before the first key, the last after the last key.
struct AnimationChannel {
  int node = -1;  ///< index into Scene::nodes
  AnimatedProperty property = AnimatedProperty::kTranslation;
  Interpolation interpolation = Interpolation::kLinear;
  std::vector<float> times;  ///< seconds, strictly increasing
  std::vector<vec4> values;  ///< empty for kWeights
  /// For kWeights, instead of `values`: for each value as many weights as Node::weights has.
  std::vector<float> weights = {};
};

/// Light from infinitely far away.
struct Environment {
  vec3 radiance = vec3(0.0f);  ///< constant radiance; multiplied with `map` if there is one
  /// Equirectangular radiance, empty if none: u = 0.5 + atan2(x, -z) / (2 pi), v = acos(y) / pi, so
  /// that the centre of the map is at -z and its upper edge at +y.
  Image3 map;
};

struct Scene {
  std::string name;
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;  ///< parents precede children
  std::vector<Skin> skins;
  std::vector<Instance> instances;
  std::vector<Camera> cameras;  ///< at least one in a loaded scene: one is added if needed
  std::vector<PunctualLight> lights;
  std::vector<AnimationChannel> animation;
  Environment environment;
  std::vector<std::string> warnings;  ///< parts omitted or corrected while loading, one line each
  /// Checksum of all files of the scene. 0: not read from files.
  uint64_t checksum = 0;

  size_t TriangleCount() const;    ///< including all instances
  double AnimationLength() const;  ///< seconds; the last keyframe's time, 0 without animation
};

/// World transforms of all nodes at `seconds`, in the order of Scene::nodes.
std::vector<mat4> NodeTransforms(const Scene& scene, double seconds);

/// Weights of the morph targets of a node's meshes at `seconds`, as many as Node::weights has.
std::vector<float> MorphWeights(const Scene& scene, int node, double seconds);

/// An axis-aligned bounding box in world space; empty if min > max.
struct Aabb {
  vec3 min = vec3(std::numeric_limits<float>::infinity());
  vec3 max = vec3(-std::numeric_limits<float>::infinity());
};
/// Bounds of all instances at `seconds`.
Aabb SceneBounds(const Scene& scene, double seconds);

/// Called from time to time during long work, from several threads at once. Return false to cancel.
using KeepGoing = std::function<bool()>;

/// Reads a .gltf or .glb file and all files that it references. Supported extensions:
/// KHR_lights_punctual, KHR_materials_anisotropy, _clearcoat, _diffuse_transmission,
/// _emissive_strength, _ior, _iridescence, _sheen, _specular, _transmission, _unlit (as emission),
/// _volume, _volume_scatter, KHR_mesh_quantization, KHR_texture_transform, EXT_texture_webp. Also
/// scenes[i].extras.environment = {"type": "constant", "radiance": [r, g, b]} and
/// cameras[i].extras.lens (docs/lens.md). All animations are merged. A file without a camera gets a
/// camera that frames the whole scene, a file without any light an environment of radiance 1;
/// Scene::warnings lists both, and all parts omitted or corrected. Textures are at most 16384
/// texels wide and high. Nodes may mirror (negative determinant): front faces are then the
/// clockwise ones, as in glTF 2.0 (3.7.4). Skins have up to 8 joints per vertex.
/// \return kNotFound, kBadData (naming the file, the element and the fault) or kUnsupported (a
///     required extension that stillray lacks, by name), kCancelled
Result<Scene> LoadGltf(const std::string& path, const KeepGoing& keep_going = {});

/// As LoadGltf, from memory (a .glb, or .gltf text); external files are read from `base_folder`, or
/// rejected if it is empty. Safe on any bytes.
Result<Scene> LoadGltfFromMemory(const uint8_t* data, size_t size, const std::string& base_folder,
                                 const KeepGoing& keep_going = {});

/// Reads a Wavefront .obj file with its material libraries and textures, all in its folder. Groups
/// and materials become meshes, one node for each group; polygons become triangles; missing normals
/// are computed from the smoothing groups. Missing materials and textures are warnings, as is a
/// camera or light added as in LoadGltf. docs/scenes.md has the conversion of materials.
/// \return kNotFound, kBadData (naming the file, the line and the fault), kUnsupported (this build
///     has no OBJ), kCancelled
Result<Scene> LoadObj(const std::string& path, const KeepGoing& keep_going = {});

/// Makes a built-in scene: "cornell", "spheres", "lights", "materials", "mirrors", "thin",
/// "faust", "colonnade", "car".
/// \return kNotFound with the list of names if there is no such scene
Result<Scene> MakeBuiltinScene(const std::string& name);
std::vector<std::string> BuiltinSceneNames();

/// Reads an image (PNG, JPEG, WebP) as the lens mask of all cameras.
/// \return kNotFound, kBadData, kUnsupported (larger than kMaxLensMaskSide), kInvalidArgument (the
///     image is black): the scene is then unchanged
Status SetLensMask(const std::string& path, Scene* scene);

/// Loads a scene; `spec` is "builtin:NAME" or the path of a .gltf, .glb or .obj file. Errors as of
/// MakeBuiltinScene, LoadGltf and LoadObj.
Result<Scene> LoadScene(const std::string& spec, const KeepGoing& keep_going = {});

}  // namespace stillray

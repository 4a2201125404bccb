// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "scene/gltf_import.h"

namespace stillray {

namespace {

constexpr uint64_t kNearest = 9728;
constexpr uint64_t kClampToEdge = 33071;
constexpr uint64_t kMirroredRepeat = 33648;
constexpr uint64_t kRepeat = 10497;

Wrap ReadWrap(const JsonView& sampler, const char* key) {
  const uint64_t mode = sampler.Count(key, kRepeat);
  switch (mode) {
    case kRepeat:
      return Wrap::kRepeat;
    case kMirroredRepeat:
      return Wrap::kMirror;
    case kClampToEdge:
      return Wrap::kClamp;
    default:
      sampler.Fail(key, fmt::format("{} is none of glTF's wrap modes", mode));
      return Wrap::kRepeat;
  }
}

/// The image of a glTF texture; -1 after a failure.
int ImageOfTexture(GltfImport* import, const JsonView& texture) {
  const size_t images = import->Root().Size("images");
  const JsonView webp = texture.Extension("EXT_texture_webp");
  int image = webp.Index("source", images, "images");
  if (image < 0) {
    image = texture.Index("source", images, "images");
  }
  if (image < 0) {
    const std::vector<std::string> extensions = texture.Object("extensions").Keys();
    if (extensions.empty()) {
      texture.Fail("source", "missing, so the texture has no picture");
    } else {
      import->log.Fail(Status::Unsupported(
          fmt::format("{}: its picture is given only through {}", texture.path(),
                      Printable(fmt::format("{}", fmt::join(extensions, ", "))))));
    }
  }
  return image;
}

}  // namespace

int UseTexture(GltfImport* import, int gltf_texture) {
  const JsonView root = import->Root();
  const JsonView view = root.Item("textures", static_cast<size_t>(gltf_texture));
  const int image = ImageOfTexture(import, view);
  const int sampler_index = view.Index("sampler", root.Size("samplers"), "samplers");
  if (!import->log.ok()) {
    return -1;
  }
  Texture texture;
  if (sampler_index >= 0) {
    const JsonView sampler = root.Item("samplers", static_cast<size_t>(sampler_index));
    texture.wrap_u = ReadWrap(sampler, "wrapS");
    texture.wrap_v = ReadWrap(sampler, "wrapT");
    texture.nearest = sampler.Count("magFilter", 0) == kNearest;
  }
  const JsonView image_view = root.Item("images", static_cast<size_t>(image));
  texture.name = view.String("name", image_view.String("name", image_view.path()));
  const auto [known, is_new] =
      import->texture_of_use.try_emplace({image, texture.wrap_u, texture.wrap_v, texture.nearest},
                                         static_cast<int>(import->scene.textures.size()));
  if (is_new) {
    import->scene.textures.push_back(std::move(texture));
    import->image_of_texture.push_back(image);
  }
  return known->second;
}

namespace {

/// KHR_texture_transform: translation * rotation * scale. The rotation turns coordinates
/// counter-clockwise as seen with v down, as in the extension's text and examples; its GLSL lines
/// have the other sign.
mat3 ReadTextureTransform(const JsonView& transform) {
  vec2 offset(0.0f);
  vec2 scale(1.0f);
  transform.Numbers("offset", &offset.x, 2);
  transform.Numbers("scale", &scale.x, 2);
  const float rotation = transform.Number("rotation", 0.0f);
  const float c = std::cos(rotation);
  const float s = std::sin(rotation);
  return mat3(vec3(c * scale.x, -s * scale.x, 0.0f), vec3(s * scale.y, c * scale.y, 0.0f),
              vec3(offset, 1.0f));
}

TextureRef ReadTextureRef(GltfImport* import, const JsonView& info) {
  TextureRef ref;
  if (!info.exists()) {
    return ref;
  }
  const int index = info.Index("index", import->Root().Size("textures"), "textures");
  if (index < 0) {
    info.Fail("index", "missing");
    return ref;
  }
  const JsonView transform = info.Extension("KHR_texture_transform");
  const uint64_t uv_set = transform.Count("texCoord", info.Count("texCoord", 0));
  ref.transform = ReadTextureTransform(transform);
  if (uv_set > 1) {
    info.Warn("texCoord", fmt::format("set {} is not supported (0 and 1 are), the texture is left "
                                      "out",
                                      uv_set));
    return ref;
  }
  ref.uv_set = static_cast<int>(uv_set);
  ref.texture = import->log.ok() ? UseTexture(import, index) : -1;
  return ref;
}

AlphaMode ReadAlphaMode(const JsonView& material) {
  const std::string mode = material.String("alphaMode", "OPAQUE");
  if (mode == "MASK") {
    return AlphaMode::kMask;
  }
  if (mode == "BLEND") {
    return AlphaMode::kBlend;
  }
  if (mode != "OPAQUE") {
    material.Fail("alphaMode", fmt::format("'{}' is not OPAQUE, MASK or BLEND", Printable(mode)));
  }
  return AlphaMode::kOpaque;
}

void Clamp01(const JsonView& view, const char* key, float* values, size_t n) {
  for (size_t i = 0; i < n; ++i) {
    const float clamped = glm::clamp(values[i], 0.0f, 1.0f);
    if (clamped != values[i]) {
      view.Warn(key, fmt::format("{} is outside 0..1, {} is used", values[i], clamped));
      values[i] = clamped;
    }
  }
}

void ReadMetallicRoughness(GltfImport* import, const JsonView& pbr, Material* material) {
  if (pbr.Numbers("baseColorFactor", &material->base_color.x, 4)) {
    Clamp01(pbr, "baseColorFactor", &material->base_color.x, 4);
  }
  material->base_color_texture = ReadTextureRef(import, pbr.Object("baseColorTexture"));
  material->metallic = pbr.NumberIn("metallicFactor", 1.0f, 0.0f, 1.0f);
  material->roughness = pbr.NumberIn("roughnessFactor", 1.0f, 0.0f, 1.0f);
  material->metallic_roughness_texture =
      ReadTextureRef(import, pbr.Object("metallicRoughnessTexture"));
}

void ReadEmission(GltfImport* import, const JsonView& view, Material* material) {
  vec3 factor(0.0f);
  if (view.Numbers("emissiveFactor", &factor.x, 3)) {
    Clamp01(view, "emissiveFactor", &factor.x, 3);
  }
  const float strength =
      view.Extension("KHR_materials_emissive_strength")
          .NumberIn("emissiveStrength", 1.0f, 0.0f, std::numeric_limits<float>::max());
  material->emission = factor * strength;
  const vec3 e = material->emission;
  if (!std::isfinite(e.x + e.y + e.z)) {
    view.Fail("emissiveFactor",
              fmt::format("times an emissiveStrength of {:g} is beyond a 32-bit float", strength));
  }
  material->emissive_texture = ReadTextureRef(import, view.Object("emissiveTexture"));
}

void ReadTransmission(GltfImport* import, const JsonView& view, Material* material) {
  const JsonView transmission = view.Extension("KHR_materials_transmission");
  material->transmission = transmission.NumberIn("transmissionFactor", 0.0f, 0.0f, 1.0f);
  material->transmission_texture =
      ReadTextureRef(import, transmission.Object("transmissionTexture"));
  // KHR_materials_ior allows 0 ("Fresnel term 1", a relic of specular-glossiness) and >= 1.
  constexpr float kMaxIor = 10.0f;
  material->ior = view.Extension("KHR_materials_ior").NumberIn("ior", 1.5f, 1.0f, kMaxIor);
  const JsonView volume = view.Extension("KHR_materials_volume");
  material->solid = volume.Number("thicknessFactor", 0.0f) > 0.0f;
  if (volume.Numbers("attenuationColor", &material->attenuation_color.x, 3)) {
    Clamp01(volume, "attenuationColor", &material->attenuation_color.x, 3);
  }
  if (volume.Has("attenuationDistance")) {
    const float distance = volume.Number("attenuationDistance", 0.0f);
    if (distance > 0.0f) {
      material->attenuation_distance = distance;
    } else {
      volume.Warn("attenuationDistance", fmt::format("{} is left out", distance));
    }
  }
}

/// Drafts of the extension have two names for the colour.
void ReadVolumeScatter(const JsonView& view, Material* material) {
  // An anisotropy of 1 is a delta phase function, which does not scatter.
  constexpr float kMostAnisotropy = 0.999f;
  const JsonView scatter = view.Extension("KHR_materials_volume_scatter");
  const char* key =
      scatter.Has("multiscatterColorFactor") ? "multiscatterColorFactor" : "multiscatterColor";
  if (scatter.Numbers(key, &material->multiscatter_color.x, 3)) {
    Clamp01(scatter, key, &material->multiscatter_color.x, 3);
  }
  material->scatter_anisotropy =
      scatter.NumberIn("scatterAnisotropy", 0.0f, -kMostAnisotropy, kMostAnisotropy);
  if (scatter.Has("multiscatterColorTexture")) {
    scatter.Warn("multiscatterColorTexture",
                 "is left out: what fills a body is the same everywhere");
  }
  const bool fills =
      material->solid && std::isfinite(material->attenuation_distance) &&
      dot(material->multiscatter_color, vec3(1.0f) - material->attenuation_color) > 0.0f;
  if (material->multiscatter_color != vec3(0.0f) && !fills) {
    scatter.Warn(key,
                 "scatters no light without thicknessFactor, attenuationDistance and an "
                 "attenuationColor below 1 of KHR_materials_volume");
  }
}

/// Reads a colour factor whose only upper limit is the range of float.
void ReadStrength(const JsonView& view, const char* key, vec3* colour) {
  if (!view.Numbers(key, &colour->x, 3)) {
    return;
  }
  for (int c = 0; c < 3; ++c) {
    if ((*colour)[c] < 0.0f) {
      view.Warn(key, fmt::format("{} is below 0, 0 is used", (*colour)[c]));
      (*colour)[c] = 0.0f;
    }
  }
}

void ReadSpecular(GltfImport* import, const JsonView& view, Material* material) {
  const JsonView specular = view.Extension("KHR_materials_specular");
  material->specular = specular.NumberIn("specularFactor", 1.0f, 0.0f, 1.0f);
  material->specular_texture = ReadTextureRef(import, specular.Object("specularTexture"));
  ReadStrength(specular, "specularColorFactor", &material->specular_color);
  material->specular_color_texture =
      ReadTextureRef(import, specular.Object("specularColorTexture"));
}

void ReadClearcoat(GltfImport* import, const JsonView& view, Material* material) {
  const JsonView coat = view.Extension("KHR_materials_clearcoat");
  material->clearcoat = coat.NumberIn("clearcoatFactor", 0.0f, 0.0f, 1.0f);
  material->clearcoat_texture = ReadTextureRef(import, coat.Object("clearcoatTexture"));
  material->clearcoat_roughness = coat.NumberIn("clearcoatRoughnessFactor", 0.0f, 0.0f, 1.0f);
  material->clearcoat_roughness_texture =
      ReadTextureRef(import, coat.Object("clearcoatRoughnessTexture"));
  const JsonView normal = coat.Object("clearcoatNormalTexture");
  material->clearcoat_normal_texture = ReadTextureRef(import, normal);
  material->clearcoat_normal_scale = normal.Number("scale", 1.0f);
}

void ReadSheen(GltfImport* import, const JsonView& view, Material* material) {
  const JsonView sheen = view.Extension("KHR_materials_sheen");
  if (sheen.Numbers("sheenColorFactor", &material->sheen_color.x, 3)) {
    Clamp01(sheen, "sheenColorFactor", &material->sheen_color.x, 3);
  }
  material->sheen_color_texture = ReadTextureRef(import, sheen.Object("sheenColorTexture"));
  material->sheen_roughness = sheen.NumberIn("sheenRoughnessFactor", 0.0f, 0.0f, 1.0f);
  material->sheen_roughness_texture = ReadTextureRef(import, sheen.Object("sheenRoughnessTexture"));
}

void ReadDiffuseTransmission(GltfImport* import, const JsonView& view, Material* material) {
  const JsonView diffuse = view.Extension("KHR_materials_diffuse_transmission");
  material->diffuse_transmission = diffuse.NumberIn("diffuseTransmissionFactor", 0.0f, 0.0f, 1.0f);
  material->diffuse_transmission_texture =
      ReadTextureRef(import, diffuse.Object("diffuseTransmissionTexture"));
  if (diffuse.Numbers("diffuseTransmissionColorFactor", &material->diffuse_transmission_color.x,
                      3)) {
    Clamp01(diffuse, "diffuseTransmissionColorFactor", &material->diffuse_transmission_color.x, 3);
  }
  material->diffuse_transmission_color_texture =
      ReadTextureRef(import, diffuse.Object("diffuseTransmissionColorTexture"));
}

void ReadAnisotropy(GltfImport* import, const JsonView& view, Material* material) {
  const JsonView anisotropy = view.Extension("KHR_materials_anisotropy");
  material->anisotropy = anisotropy.NumberIn("anisotropyStrength", 0.0f, 0.0f, 1.0f);
  material->anisotropy_rotation = anisotropy.Number("anisotropyRotation", 0.0f);
  material->anisotropy_texture = ReadTextureRef(import, anisotropy.Object("anisotropyTexture"));
}

void ReadIridescence(GltfImport* import, const JsonView& view, Material* material) {
  // Far beyond the thickness of visible interference.
  constexpr float kThickest = 1e6f;
  constexpr float kMostIor = 10.0f;
  const JsonView film = view.Extension("KHR_materials_iridescence");
  material->iridescence = film.NumberIn("iridescenceFactor", 0.0f, 0.0f, 1.0f);
  material->iridescence_texture = ReadTextureRef(import, film.Object("iridescenceTexture"));
  material->iridescence_ior = film.NumberIn("iridescenceIor", 1.3f, 1.0f, kMostIor);
  material->iridescence_thickness_min =
      film.NumberIn("iridescenceThicknessMinimum", 100.0f, 0.0f, kThickest);
  material->iridescence_thickness_max =
      film.NumberIn("iridescenceThicknessMaximum", 400.0f, 0.0f, kThickest);
  material->iridescence_thickness_texture =
      ReadTextureRef(import, film.Object("iridescenceThicknessTexture"));
}

/// KHR_materials_unlit, where the base colour is independent of lighting: implemented as the
/// emission of a black surface without reflection (index of refraction 1).
void MakeUnlit(const JsonView& view, Material* material) {
  view.log()->Warn("KHR_materials_unlit: unlit materials are shown as emission");
  material->emission = vec3(material->base_color);
  material->emissive_texture = material->base_color_texture;
  material->base_color = vec4(vec3(0.0f), material->base_color.w);
  material->metallic = 0.0f;
  material->roughness = 1.0f;
  material->metallic_roughness_texture = {};
  material->ior = 1.0f;
}

Material ReadMaterial(GltfImport* import, const JsonView& view) {
  Material material;
  material.name = view.String("name");
  ReadMetallicRoughness(import, view.Object("pbrMetallicRoughness"), &material);
  const JsonView normal = view.Object("normalTexture");
  material.normal_texture = ReadTextureRef(import, normal);
  material.normal_scale = normal.Number("scale", 1.0f);
  ReadEmission(import, view, &material);
  material.alpha_mode = ReadAlphaMode(view);
  material.alpha_cutoff = view.Number("alphaCutoff", 0.5f);
  material.double_sided = view.Bool("doubleSided", false);
  ReadTransmission(import, view, &material);
  ReadVolumeScatter(view, &material);
  ReadSpecular(import, view, &material);
  ReadClearcoat(import, view, &material);
  ReadSheen(import, view, &material);
  ReadDiffuseTransmission(import, view, &material);
  ReadAnisotropy(import, view, &material);
  ReadIridescence(import, view, &material);
  if (view.Extension("KHR_materials_unlit").exists()) {
    MakeUnlit(view, &material);
  }
  return material;
}

}  // namespace

void ImportMaterials(GltfImport* import) {
  const JsonView root = import->Root();
  const size_t count = root.Size("materials");
  for (size_t i = 0; i < count && import->log.ok(); ++i) {
    import->scene.materials.push_back(ReadMaterial(import, root.Item("materials", i)));
  }
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include "scene/obj_import.h"

namespace stillray {

namespace {

enum Purpose : int { kColourAndAlpha, kEmission, kRoughnessAndMetal, kNormalMap };

/// Inserted after every newmtl: unspecified values of a material remain negative.
constexpr std::string_view kNotGiven =
    "Kd -1 -1 -1\nKs -1 -1 -1\nKe -1 -1 -1\nNs -1\nNi -1\nPr -1\nPm -1\nillum -1\nTf -1 -1 -1\n";

constexpr float kNeutralColour = 0.8f;

/// Normalises the text of an MTL file for the parser.
std::string PrepareMtl(const std::vector<uint8_t>& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::string out;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find_first_of("\r\n", at), text.size());
    std::string_view line = text.substr(at, end - at);
    at = end + 1;
    const size_t begin = line.find_first_not_of(" \t");
    line.remove_prefix(std::min(begin, line.size()));
    const size_t last = line.find_last_not_of(std::string_view(" \t\0", 3));
    line = line.substr(0, last == line.npos ? 0 : last + 1);
    // The parser stops at a zero byte.
    if (line.empty() || line.find('\0') != line.npos) {
      continue;
    }
    out.append(line);
    out.push_back('\n');
    if (line.starts_with("newmtl ") || line.starts_with("newmtl\t")) {
      out.append(kNotGiven);
    }
  }
  return out;
}

/// `value` clamped to low..high; `missing` if it is unspecified.
float Given(float value, float missing, float low, float high) {
  return value < 0.0f || !std::isfinite(value) ? missing : std::clamp(value, low, high);
}

vec3 GivenColour(const tinyobj::real_t* value, float missing, float high) {
  return {Given(value[0], missing, 0.0f, high), Given(value[1], missing, 0.0f, high),
          Given(value[2], missing, 0.0f, high)};
}

float Largest(vec3 colour) {
  return std::max({colour.x, colour.y, colour.z});
}

class Converter {
 public:
  Converter(ObjImport* import, const tinyobj::material_t& source)
      : import_(import), source_(source) {}

  Material Convert();

 private:
  void ConvertReflection();
  void ConvertTransparency();
  void ConvertTextures();
  void ConvertRelief();
  void WarnAboutTheRest();

  /// Illumination models 6 and 7 refract. Model 4 is ignored: exporters write it for all materials.
  bool Refracts() const { return source_.illum == 6 || source_.illum == 7; }
  ObjPicture* Picture(const std::string& file, const char* statement);
  bool Afford(ObjPicture* first, ObjPicture* second, Texture* texture);
  template <typename Texel>
  TextureRef Use(Purpose purpose, ObjPicture* first, ObjPicture* second,
                 const tinyobj::texture_option_t& option, const Texel& texel);
  TextureRef UsePlain(Purpose purpose, const std::string& file, const char* statement,
                      const tinyobj::texture_option_t& option);
  void Combine(const std::string& colour, const std::string& alpha);
  void CombineSurface();
  void Warn(const std::string& text) {
    import_->log.Warn(fmt::format("material '{}': {}", Printable(source_.name), text));
  }

  ObjImport* import_;
  const tinyobj::material_t& source_;
  Material out_;
};

Material Converter::Convert() {
  out_.name = source_.name;
  out_.double_sided = true;
  ConvertReflection();
  ConvertTransparency();
  ConvertTextures();
  ConvertRelief();
  WarnAboutTheRest();
  return std::move(out_);
}

/// Metalness and roughness are specified (Pm, Pr) or derived from Phong's model: specular without
/// diffuse reflection is metal, and the exponent Ns gives the width of the lobe.
void Converter::ConvertReflection() {
  const bool textured = !source_.diffuse_texname.empty();
  const vec3 diffuse = GivenColour(source_.diffuse, textured ? 1.0f : kNeutralColour, 1.0f);
  const vec3 specular = GivenColour(source_.specular, 0.0f, 1.0f);
  const bool has_specular = Largest(specular) > 0.0f && source_.illum != 0 && source_.illum != 1;
  const bool metal = has_specular && Largest(diffuse) == 0.0f && !textured;
  out_.metallic = Given(source_.metallic, metal ? 1.0f : 0.0f, 0.0f, 1.0f);
  out_.base_color = vec4(metal && source_.metallic < 0.0f ? specular : diffuse, 1.0f);
  // Walter et al. 2007: a Phong exponent of 2 / alpha^2 - 2 corresponds to the lobe width alpha,
  // which is the square of the perceptual roughness.
  const float exponent = Given(source_.shininess, 0.0f, 0.0f, 1e12f);
  const float from_exponent = has_specular ? std::sqrt(std::sqrt(2.0f / (exponent + 2.0f))) : 1.0f;
  out_.roughness = Given(source_.roughness, from_exponent, 0.0f, 1.0f);
  out_.ior = Given(source_.ior, 1.5f, 1.0f, 10.0f);
  if (source_.ior < 1.01f && !Refracts()) {
    // Many exporters write 1 for "unset", which would remove the highlight.
    out_.ior = 1.5f;
  }
  const float most = 1e30f;
  out_.emission =
      GivenColour(source_.emission, source_.emissive_texname.empty() ? 0.0f : 1.0f, most);
}

void Converter::ConvertTransparency() {
  const float opacity =
      std::isfinite(source_.dissolve) ? std::clamp(source_.dissolve, 0.0f, 1.0f) : 1.0f;
  if (Refracts()) {
    out_.transmission = opacity < 1.0f ? 1.0f - opacity : 1.0f;
    const vec3 filter = GivenColour(source_.transmittance, 1.0f, 1.0f);
    out_.base_color = vec4(Largest(filter) > 0.0f ? filter : vec3(1.0f), 1.0f);
    out_.metallic = 0.0f;
    out_.solid = true;
    out_.double_sided = false;
    return;
  }
  if (opacity < 1.0f) {
    out_.base_color.w = opacity;
    out_.alpha_mode = AlphaMode::kBlend;
  }
}

/// The image of a file; nullptr, with a warning, if it cannot be read.
ObjPicture* Converter::Picture(const std::string& file, const char* statement) {
  if (file.empty()) {
    return nullptr;
  }
  const auto [at, is_new] = import_->pictures.try_emplace(file);
  if (is_new) {
    const auto read = [&]() -> Result<ObjPicture> {
      Result<std::vector<uint8_t>> bytes = import_->files(file);
      if (!bytes.ok()) {
        return bytes.status();
      }
      import_->checksum = AddFileToChecksum(*bytes, import_->checksum);
      const Result<ImageInfo> info = InspectImage(*bytes);
      if (!info.ok()) {
        return info.status();
      }
      STILLRAY_RETURN_IF_ERROR(import_->texture_budget.Take(*info, bytes->size()));
      Result<std::vector<uint8_t>> texels = DecodeImage(*bytes, *info);
      if (!texels.ok()) {
        return texels.status();
      }
      return ObjPicture{file, info->width, info->height, std::move(texels).value(), false};
    };
    Result<ObjPicture> picture = read();
    if (picture.ok()) {
      at->second = std::move(picture).value();
    } else {
      Warn(fmt::format("{} '{}' is left out: {}", statement, Printable(file),
                       picture.status().message()));
    }
  }
  return at->second ? &*at->second : nullptr;
}

/// Converts options -s and -o, which scale and translate texture coordinates with v up.
mat3 TextureTransform(const tinyobj::texture_option_t& option) {
  const auto sane = [](float value, float otherwise) {
    return std::isfinite(value) && std::abs(value) < 1e6f ? value : otherwise;
  };
  const vec2 scale(sane(option.scale[0], 1.0f), sane(option.scale[1], 1.0f));
  const vec2 offset(sane(option.origin_offset[0], 0.0f), sane(option.origin_offset[1], 0.0f));
  return mat3(vec3(scale.x, 0.0f, 0.0f), vec3(0.0f, scale.y, 0.0f),
              vec3(offset.x, 1.0f - scale.y - offset.y, 1.0f));
}

const uint8_t* TexelAt(const ObjPicture* picture, int x, int y, const Texture& texture) {
  static constexpr uint8_t kWhite[4] = {255, 255, 255, 255};
  if (picture == nullptr) {
    return kWhite;
  }
  const auto scaled = [](int i, int size, int of) {
    return static_cast<size_t>(static_cast<int64_t>(i) * size / of);
  };
  const size_t row = scaled(y, picture->height, texture.height);
  const size_t column = scaled(x, picture->width, texture.width);
  return &picture->texels[4 * (row * static_cast<size_t>(picture->width) + column)];
}

/// Gives the texture the size of the larger image. The budget covers one texture per image of its
/// own size; additional textures, and larger ones combined from two images, are charged.
bool Converter::Afford(ObjPicture* first, ObjPicture* second, Texture* texture) {
  for (const ObjPicture* picture : {first, second}) {
    if (picture != nullptr) {
      texture->width = std::max(texture->width, picture->width);
      texture->height = std::max(texture->height, picture->height);
    }
  }
  bool paid = false;
  for (ObjPicture* picture : {first, second}) {
    if (picture != nullptr) {
      paid = paid || (!picture->is_used && picture->width == texture->width &&
                      picture->height == texture->height);
      picture->is_used = true;
    }
  }
  if (paid) {
    return true;
  }
  ImageInfo info;
  info.width = texture->width;
  info.height = texture->height;
  const Status taken = import_->texture_budget.Take(info, 0);
  if (!taken.ok()) {
    Warn(fmt::format("a texture is left out: {}", taken.message()));
  }
  return taken.ok();
}

/// A reference to the texture with texels texel(first, second), where one image may be missing;
/// created unless a texture of these files and purpose exists.
template <typename Texel>
TextureRef Converter::Use(Purpose purpose, ObjPicture* first, ObjPicture* second,
                          const tinyobj::texture_option_t& option, const Texel& texel) {
  const Wrap wrap = option.clamp ? Wrap::kClamp : Wrap::kRepeat;
  const std::string first_file = first == nullptr ? "" : first->file;
  const std::string second_file = second == nullptr ? "" : second->file;
  const auto [at, is_new] =
      import_->texture_of_use.try_emplace({purpose, first_file, second_file, wrap}, -1);
  if (is_new) {
    Texture texture;
    texture.name = first == nullptr ? second_file : first_file;
    texture.wrap_u = wrap;
    texture.wrap_v = wrap;
    if (!Afford(first, second, &texture)) {
      return {};
    }
    texture.texels.resize(static_cast<size_t>(texture.width) * static_cast<size_t>(texture.height) *
                          4);
    uint8_t* out = texture.texels.data();
    for (int y = 0; y < texture.height; ++y) {
      for (int x = 0; x < texture.width; ++x, out += 4) {
        texel(TexelAt(first, x, y, texture), TexelAt(second, x, y, texture), out);
      }
    }
    at->second = static_cast<int>(import_->scene.textures.size());
    import_->scene.textures.push_back(std::move(texture));
  }
  TextureRef ref;
  ref.texture = at->second;
  ref.transform = TextureTransform(option);
  return ref;
}

TextureRef Converter::UsePlain(Purpose purpose, const std::string& file, const char* statement,
                               const tinyobj::texture_option_t& option) {
  ObjPicture* picture = Picture(file, statement);
  if (picture == nullptr) {
    return {};
  }
  return Use(purpose, picture, nullptr, option,
             [](const uint8_t* texel, const uint8_t* /*none*/, uint8_t* out) {
               std::copy_n(texel, 4, out);
             });
}

bool HasAlpha(const ObjPicture& picture) {
  for (size_t i = 3; i < picture.texels.size(); i += 4) {
    if (picture.texels[i] != 255) {
      return true;
    }
  }
  return false;
}

/// The opacity of map_d is the image's alpha channel if present, else its brightness. The alpha of
/// map_Kd is opacity only if map_d references it.
void Converter::Combine(const std::string& colour, const std::string& alpha) {
  ObjPicture* rgb = Picture(colour, "map_Kd");
  ObjPicture* mask = Picture(alpha, "map_d");
  if (mask == nullptr && rgb == nullptr) {
    return;
  }
  const bool from_alpha = mask != nullptr && HasAlpha(*mask);
  out_.base_color_texture = Use(
      kColourAndAlpha, rgb, mask, rgb != nullptr ? source_.diffuse_texopt : source_.alpha_texopt,
      [&](const uint8_t* c, const uint8_t* m, uint8_t* out) {
        std::copy_n(c, 3, out);
        // The mean of white is white: no mask, no transparency.
        out[3] = from_alpha ? m[3] : static_cast<uint8_t>((m[0] + m[1] + m[2] + 1) / 3);
      });
  if (mask != nullptr && out_.base_color_texture.texture >= 0) {
    out_.alpha_mode = AlphaMode::kBlend;
  }
}

/// Combines map_Pr and map_Pm in the green and blue channels of one texture.
void Converter::CombineSurface() {
  ObjPicture* rough = Picture(source_.roughness_texname, "map_Pr");
  ObjPicture* metal = Picture(source_.metallic_texname, "map_Pm");
  if (rough == nullptr && metal == nullptr) {
    return;
  }
  out_.metallic_roughness_texture =
      Use(kRoughnessAndMetal, rough, metal,
          rough != nullptr ? source_.roughness_texopt : source_.metallic_texopt,
          [](const uint8_t* r, const uint8_t* m, uint8_t* out) {
            out[0] = 255;
            out[1] = r[0];
            out[2] = m[0];
            out[3] = 255;
          });
  if (out_.metallic_roughness_texture.texture < 0) {
    return;
  }
  // The default factor of a map is 1.
  out_.roughness = rough != nullptr ? Given(source_.roughness, 1.0f, 0.0f, 1.0f) : out_.roughness;
  out_.metallic = metal != nullptr ? Given(source_.metallic, 1.0f, 0.0f, 1.0f) : out_.metallic;
}

void Converter::ConvertTextures() {
  Combine(source_.diffuse_texname, source_.alpha_texname);
  CombineSurface();
  out_.emissive_texture =
      UsePlain(kEmission, source_.emissive_texname, "map_Ke", source_.emissive_texopt);
  if (!source_.emissive_texname.empty() && out_.emissive_texture.texture < 0 &&
      source_.emission[0] < 0.0f) {
    out_.emission = vec3(0.0f);
  }
}

/// Whether an image is a normal map instead of a height map: not grey, and mostly blue.
bool IsNormalMap(const ObjPicture& picture) {
  uint64_t blue = 0;
  uint64_t colour = 0;
  for (size_t i = 0; i < picture.texels.size(); i += 4) {
    const uint8_t* t = &picture.texels[i];
    blue += t[2];
    colour += static_cast<uint64_t>(std::max({t[0], t[1], t[2]}) - std::min({t[0], t[1], t[2]}));
  }
  const uint64_t count = picture.texels.size() / 4;
  return blue > 150 * count && colour > 20 * count;
}

void Converter::ConvertRelief() {
  const auto strength = [](const tinyobj::texture_option_t& option) {
    return std::isfinite(option.bump_multiplier) ? option.bump_multiplier : 1.0f;
  };
  if (!source_.normal_texname.empty()) {
    out_.normal_texture =
        UsePlain(kNormalMap, source_.normal_texname, "norm", source_.normal_texopt);
    out_.normal_scale = strength(source_.normal_texopt);
    return;
  }
  const ObjPicture* picture = Picture(source_.bump_texname, "bump");
  if (picture == nullptr) {
    return;
  }
  if (IsNormalMap(*picture)) {
    out_.normal_texture = UsePlain(kNormalMap, source_.bump_texname, "bump", source_.bump_texopt);
    out_.normal_scale = strength(source_.bump_texopt);
  } else {
    Warn(fmt::format("bump '{}' is left out: it holds heights, and only normal maps are supported",
                     Printable(source_.bump_texname)));
  }
}

void Converter::WarnAboutTheRest() {
  if (!source_.displacement_texname.empty()) {
    Warn(fmt::format("displacement '{}' is left out", Printable(source_.displacement_texname)));
  }
  if (!source_.specular_texname.empty() || !source_.specular_highlight_texname.empty()) {
    Warn("map_Ks and map_Ns are left out");
  }
  if (source_.sheen > 0.0f || source_.clearcoat_thickness > 0.0f || source_.anisotropy != 0.0f) {
    Warn("sheen, clear coat and anisotropy are left out");
  }
}

/// Reads all materials of the libraries. Of several materials with one name the first is used.
std::vector<tinyobj::material_t> ReadLibraries(ObjImport* import,
                                               std::map<std::string, int>* by_name) {
  std::vector<tinyobj::material_t> materials;
  for (const std::vector<std::string>& names : import->text.libraries) {
    // "a b.mtl" is one file or two; the second only if there is no such file.
    const Result<std::vector<uint8_t>> whole = import->files(names.front());
    const bool is_whole = whole.ok() || names.size() == 1;
    for (size_t i = is_whole ? 0 : 1; i < (is_whole ? 1 : names.size()); ++i) {
      const Result<std::vector<uint8_t>> bytes =
          is_whole ? std::move(whole) : import->files(names[i]);
      if (!bytes.ok()) {
        import->log.Warn(fmt::format("mtllib '{}' is left out: {}", Printable(names[i]),
                                     bytes.status().message()));
        continue;
      }
      import->checksum = AddFileToChecksum(*bytes, import->checksum);
      std::istringstream text(PrepareMtl(*bytes));
      std::string warning;
      std::string error;
      tinyobj::LoadMtl(by_name, &materials, &text, &warning, &error);
    }
  }
  return materials;
}

}  // namespace

Material NeutralObjMaterial(const std::string& name) {
  Material material;
  material.name = name;
  material.base_color = vec4(vec3(kNeutralColour), 1.0f);
  material.metallic = 0.0f;
  material.double_sided = true;
  return material;
}

void ImportObjMaterials(ObjImport* import) {
  std::map<std::string, int> by_name;
  const std::vector<tinyobj::material_t> materials = ReadLibraries(import, &by_name);
  for (const std::string& name : import->text.materials) {
    if (import->keep_going && !import->keep_going()) {
      import->log.Fail(Status::Cancelled());
      return;
    }
    import->material_of_name.push_back(static_cast<int>(import->scene.materials.size()));
    const auto found = by_name.find(name);
    if (found != by_name.end()) {
      import->scene.materials.push_back(
          Converter(import, materials[static_cast<size_t>(found->second)]).Convert());
    } else {
      import->log.Warn(
          fmt::format("material '{}' is in no material library, grey is used", Printable(name)));
      import->scene.materials.push_back(NeutralObjMaterial(name));
    }
  }
  import->pictures.clear();
}

}  // namespace stillray

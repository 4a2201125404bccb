// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/gltf_builder.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>

#include <gtest/gtest.h>

namespace stillray::test {

namespace {

void AppendU32(std::vector<uint8_t>* bytes, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes->push_back(static_cast<uint8_t>(value >> shift));
  }
}

}  // namespace

std::string Base64(const std::vector<uint8_t>& bytes) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t left = bytes.size() - i;
    const uint32_t group = static_cast<uint32_t>(bytes[i]) << 16 |
                           (left > 1 ? static_cast<uint32_t>(bytes[i + 1]) << 8 : 0) |
                           (left > 2 ? static_cast<uint32_t>(bytes[i + 2]) : 0);
    text += digits[group >> 18];
    text += digits[(group >> 12) & 63];
    text += left > 1 ? digits[(group >> 6) & 63] : '=';
    text += left > 2 ? digits[group & 63] : '=';
  }
  return text;
}

size_t GltfBuilder::Components(const std::string& type) {
  if (type == "SCALAR" || type == "MAT4") {
    return type == "MAT4" ? 16 : 1;
  }
  return static_cast<size_t>(type[3] - '0');
}

int GltfBuilder::AddView(const std::vector<uint8_t>& bytes) {
  buffer_.resize((buffer_.size() + 3) / 4 * 4);
  const size_t offset = buffer_.size();
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  return Add("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}});
}

int GltfBuilder::AddViewAccessor(int view, int component_type, const std::string& type,
                                 size_t count, bool normalized) {
  nlohmann::json accessor = {
      {"bufferView", view}, {"componentType", component_type}, {"type", type}, {"count", count}};
  if (normalized) {
    accessor["normalized"] = true;
  }
  return Add("accessors", accessor);
}

int GltfBuilder::Add(const char* array, const nlohmann::json& element) {
  nlohmann::json& list = json[array];
  list.push_back(element);
  return static_cast<int>(list.size()) - 1;
}

nlohmann::json& GltfBuilder::AddPrimitive(const nlohmann::json& primitive) {
  const int mesh = Add("meshes", {{"primitives", nlohmann::json::array({primitive})}});
  Add("nodes", {{"mesh", mesh}});
  return json["meshes"].back()["primitives"][0];
}

nlohmann::json& GltfBuilder::AddTriangle() {
  const int positions = AddFloats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  return AddPrimitive({{"attributes", {{"POSITION", positions}}}});
}

void GltfBuilder::UseMaterial(const nlohmann::json& material) {
  json["meshes"].back()["primitives"].back()["material"] = Add("materials", material);
}

int GltfBuilder::AddTexture(const std::vector<uint8_t>& picture, const std::string& mime) {
  const int view = AddView(picture);
  const int image = Add("images", {{"bufferView", view}, {"mimeType", mime}});
  return Add("textures", {{"source", image}});
}

std::string GltfBuilder::Text() const {
  nlohmann::json document = json;
  if (!buffer_.empty() && !document.contains("buffers")) {
    document["buffers"].push_back(
        {{"byteLength", buffer_.size()},
         {"uri", "data:application/octet-stream;base64," + Base64(buffer_)}});
  }
  return document.dump();
}

std::vector<uint8_t> GltfBuilder::Glb() const {
  nlohmann::json document = json;
  document["buffers"].push_back({{"byteLength", buffer_.size()}});
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<uint8_t> binary = buffer_;
  binary.resize((binary.size() + 3) / 4 * 4);
  std::vector<uint8_t> glb = {'g', 'l', 'T', 'F'};
  AppendU32(&glb, 2);
  AppendU32(&glb, static_cast<uint32_t>(12 + 8 + text.size() + 8 + binary.size()));
  AppendU32(&glb, static_cast<uint32_t>(text.size()));
  glb.insert(glb.end(), {'J', 'S', 'O', 'N'});
  glb.insert(glb.end(), text.begin(), text.end());
  AppendU32(&glb, static_cast<uint32_t>(binary.size()));
  glb.insert(glb.end(), {'B', 'I', 'N', 0});
  glb.insert(glb.end(), binary.begin(), binary.end());
  return glb;
}

Result<Scene> GltfBuilder::Load(const std::string& base_folder) const {
  return LoadText(Text(), base_folder);
}

Result<Scene> LoadText(const std::string& text, const std::string& base_folder) {
  return LoadGltfFromMemory(reinterpret_cast<const uint8_t*>(text.data()), text.size(),
                            base_folder);
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern =
      (std::filesystem::temp_directory_path() / "stillray_scene_test_XXXXXX").string();
  const char* made = mkdtemp(pattern.data());
  EXPECT_NE(made, nullptr) << "cannot make a folder like " << pattern;
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string TemporaryFolder::Write(const std::string& name,
                                   const std::vector<uint8_t>& bytes) const {
  const std::string path = path_ + "/" + name;
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  EXPECT_TRUE(out.good()) << path;
  return path;
}

std::string TemporaryFolder::Write(const std::string& name, const std::string& text) const {
  return Write(name, std::vector<uint8_t>(text.begin(), text.end()));
}

}  // namespace stillray::test

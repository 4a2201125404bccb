// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/scene_outline.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace stillray::view {
namespace {

constexpr size_t kMostBytes = size_t{64} << 20;
constexpr uint32_t kMagic = 0x46546c67;  // "glTF", little endian
// Bytes of the file header and the header of the first chunk, the JSON.
constexpr size_t kHeader = 20;

uint32_t Word(const char* bytes) {
  const auto byte = [&](int i) { return uint32_t{static_cast<uint8_t>(bytes[i])} << (8 * i); };
  return byte(0) | byte(1) | byte(2) | byte(3);
}

/// The JSON text of a .glb or .gltf file; empty if there is none.
std::string ReadContents(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return "";  // reading a pipe would consume it
  }
  std::ifstream file(path, std::ios::binary);
  char header[kHeader];
  if (!file.read(header, kHeader)) {
    return "";
  }
  const bool binary = Word(header) == kMagic;
  size_t size = kMostBytes;
  if (binary) {
    size = std::min<size_t>(Word(header + 12), kMostBytes);
  } else {
    file.seekg(0);
  }
  std::string text;
  constexpr size_t kPiece = size_t{1} << 20;  // reading in pieces bounds memory by the file size
  while (text.size() < size && file) {
    const size_t before = text.size();
    text.resize(std::min(size, before + kPiece));
    file.read(text.data() + before, static_cast<std::streamsize>(text.size() - before));
    text.resize(before + static_cast<size_t>(file.gcount()));
  }
  return text;
}

size_t Count(const nlohmann::json& contents, const char* name) {
  const auto found = contents.find(name);
  return found != contents.end() && found->is_array() ? found->size() : 0;
}

std::string Counted(size_t count, const char* one) {
  return fmt::format("{} {}{}", count, one,
                     count == 1                         ? ""
                     : one[std::strlen(one) - 1] == 'h' ? "es"
                                                        : "s");
}

}  // namespace

SceneOutline OutlineOf(const std::string& path) {
  const nlohmann::json contents = nlohmann::json::parse(ReadContents(path), nullptr, false);
  if (!contents.is_object()) {
    return {};
  }
  return {Count(contents, "textures"), Count(contents, "meshes")};
}

std::string ToText(const SceneOutline& outline) {
  std::string text = outline.textures > 0 ? Counted(outline.textures, "texture") : "";
  if (outline.meshes > 0) {
    text += (text.empty() ? "" : " and ") + Counted(outline.meshes, "mesh");
  }
  return text;
}

}  // namespace stillray::view

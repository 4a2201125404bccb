// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Small glTF files for tests, put together in memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "stillray/scene.h"

namespace stillray::test {

inline constexpr int kGltfByte = 5120;
inline constexpr int kGltfUnsignedByte = 5121;
inline constexpr int kGltfShort = 5122;
inline constexpr int kGltfUnsignedShort = 5123;
inline constexpr int kGltfUnsignedInt = 5125;
inline constexpr int kGltfFloat = 5126;

std::string Base64(const std::vector<uint8_t>& bytes);

/// The JSON may be changed freely between calls: tests set the properties under test.
class GltfBuilder {
 public:
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}};

  /// Appends raw bytes to the buffer as a bufferView; its index.
  int AddView(const std::vector<uint8_t>& bytes);
  /// An accessor of `type` ("VEC3", ...) over all of `values`; its index.
  template <typename T>
  int AddAccessor(const std::vector<T>& values, int component_type, const std::string& type,
                  bool normalized = false) {
    const uint8_t* bytes = reinterpret_cast<const uint8_t*>(values.data());
    const int view = AddView({bytes, bytes + values.size() * sizeof(T)});
    return AddViewAccessor(view, component_type, type, values.size() / Components(type),
                           normalized);
  }
  int AddFloats(const std::vector<float>& values, const std::string& type) {
    return AddAccessor(values, kGltfFloat, type);
  }
  int AddViewAccessor(int view, int component_type, const std::string& type, size_t count,
                      bool normalized = false);

  /// A mesh with one primitive, on a node of its own, in the scene; the primitive's JSON.
  nlohmann::json& AddPrimitive(const nlohmann::json& primitive);
  /// The triangle (0,0,0) (1,0,0) (0,1,0) with nothing but positions.
  nlohmann::json& AddTriangle();
  /// Appends to an array of the root; the index.
  int Add(const char* array, const nlohmann::json& element);
  /// Gives the last primitive this material.
  void UseMaterial(const nlohmann::json& material);
  /// A texture that shows an embedded picture; its index.
  int AddTexture(const std::vector<uint8_t>& picture, const std::string& mime);

  /// .gltf text with the buffer inline.
  std::string Text() const;
  std::vector<uint8_t> Glb() const;

  Result<Scene> Load(const std::string& base_folder = "") const;

 private:
  static size_t Components(const std::string& type);
  std::vector<uint8_t> buffer_;
};

Result<Scene> LoadText(const std::string& text, const std::string& base_folder = "");

/// A folder of its own that is removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }
  /// Writes a file; its path.
  std::string Write(const std::string& name, const std::vector<uint8_t>& bytes) const;
  std::string Write(const std::string& name, const std::string& text) const;

 private:
  std::string path_;
};

}  // namespace stillray::test

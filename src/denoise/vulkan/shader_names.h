// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Names in the interfaces of the compute shaders, which are missing in their optimised code.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stillray::vulkan {

/// Read once from the text that the build generates (cmake/ShaderNames.cmake). Shader names exclude
/// the precision: "Atrous". Functions return "" if there is no name.
class ShaderNames {
 public:
  static const ShaderNames& Get();

  /// The name of the shader's file, without its extension.
  std::string FileOf(const std::string& shader) const;
  std::string ImageAt(const std::string& shader, uint32_t set, uint32_t binding) const;
  /// The structure of a block.
  std::string BlockAt(const std::string& shader, uint32_t set, uint32_t binding) const;
  std::string PushBlock(const std::string& shader) const;
  std::string Constant(const std::string& shader, uint32_t id) const;

  struct Member {
    std::string name;   ///< "atrous.edges.sigma_n"
    std::string block;  ///< the structure that contains it
  };
  /// \param structure  of BlockAt or PushBlock
  /// \param path       as in gpu::BlockMember
  Member MemberAt(const std::string& shader, const std::string& structure,
                  std::span<const uint32_t> path) const;

  /// The trailing comment of a declaration.
  /// \param where  a structure, or the name of a shader's file without extension
  std::string Note(const std::string& where, const std::string& name) const;

 private:
  using Place = std::pair<uint32_t, uint32_t>;  ///< set and binding
  struct Structure {
    std::string name;
    std::vector<std::pair<std::string, std::string>> members;  ///< names and types
  };
  struct OfShader {
    std::string file;
    std::map<uint32_t, std::string> constants;
    std::map<Place, std::string> images;
    std::map<Place, std::string> blocks;
    std::string push;
    std::map<std::string, Structure> structures;
  };

  explicit ShaderNames(std::string_view text);
  void Take(const std::string& line, OfShader** shader);
  /// Finds a name of a shader; names common to all shaders are stored with the first shader.
  template <typename Key, typename Value>
  const Value* Find(const std::string& shader, std::map<Key, Value> OfShader::*list,
                    const Key& key) const;

  std::string first_;
  std::map<std::string, OfShader> shaders_;
  std::map<std::pair<std::string, std::string>, std::string> notes_;
};

}  // namespace stillray::vulkan

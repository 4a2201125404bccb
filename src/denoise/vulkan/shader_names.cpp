// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/shader_names.h"

#include <sstream>

namespace stillray::vulkan {

namespace shaders {
extern const char kShaderNames[];
}

const ShaderNames& ShaderNames::Get() {
  static const ShaderNames names{shaders::kShaderNames};
  return names;
}

ShaderNames::ShaderNames(std::string_view text) {
  std::istringstream lines{std::string(text)};
  OfShader* shader = nullptr;
  for (std::string line; std::getline(lines, line);) {
    Take(line, &shader);
  }
}

void ShaderNames::Take(const std::string& line, OfShader** shader) {
  std::istringstream words(line);
  std::string kind;
  words >> kind;
  if (kind == "shader") {
    std::string name;
    words >> name;
    first_ = first_.empty() ? name : first_;
    *shader = &shaders_[name];
    words >> (*shader)->file;
  } else if (kind == "constant") {
    uint32_t id = 0;
    words >> id;
    words >> (*shader)->constants[id];
  } else if (kind == "image" || kind == "block") {
    Place place;
    std::string name;
    words >> place.first >> place.second >> name;
    (kind == "image" ? (*shader)->images : (*shader)->blocks)[place] = name;
  } else if (kind == "push") {
    words >> (*shader)->push;
  } else if (kind == "struct") {
    std::string id;
    words >> id;
    Structure& structure = (*shader)->structures[id];
    words >> structure.name;
    for (std::string member; words >> member;) {
      const size_t colon = member.find(':');
      structure.members.emplace_back(member.substr(0, colon), member.substr(colon + 1));
    }
  } else if (kind == "note") {
    std::pair<std::string, std::string> of;
    words >> of.first >> of.second >> std::ws;
    std::getline(words, notes_[of]);
  }
}

template <typename Key, typename Value>
const Value* ShaderNames::Find(const std::string& shader, std::map<Key, Value> OfShader::*list,
                               const Key& key) const {
  for (const std::string& name : {shader, first_}) {
    const auto of_shader = shaders_.find(name);
    if (of_shader == shaders_.end()) {
      continue;
    }
    const auto found = (of_shader->second.*list).find(key);
    if (found != (of_shader->second.*list).end()) {
      return &found->second;
    }
  }
  return nullptr;
}

std::string ShaderNames::ImageAt(const std::string& shader, uint32_t set, uint32_t binding) const {
  const std::string* name = Find(shader, &OfShader::images, Place(set, binding));
  return name != nullptr ? *name : "";
}

std::string ShaderNames::BlockAt(const std::string& shader, uint32_t set, uint32_t binding) const {
  const std::string* name = Find(shader, &OfShader::blocks, Place(set, binding));
  return name != nullptr ? *name : "";
}

std::string ShaderNames::FileOf(const std::string& shader) const {
  const auto found = shaders_.find(shader);
  return found != shaders_.end() ? found->second.file : "";
}

std::string ShaderNames::PushBlock(const std::string& shader) const {
  for (const std::string& name : {shader, first_}) {
    const auto found = shaders_.find(name);
    if (found != shaders_.end() && !found->second.push.empty()) {
      return found->second.push;
    }
  }
  return "";
}

std::string ShaderNames::Constant(const std::string& shader, uint32_t id) const {
  const std::string* name = Find(shader, &OfShader::constants, id);
  return name != nullptr ? *name : "";
}

ShaderNames::Member ShaderNames::MemberAt(const std::string& shader, const std::string& structure,
                                          std::span<const uint32_t> path) const {
  Member member;
  std::string type = structure;
  for (const uint32_t index : path) {
    const Structure* found = Find(shader, &OfShader::structures, type);
    if (found == nullptr || index >= found->members.size()) {
      return {};
    }
    member.name += (member.name.empty() ? "" : ".") + found->members[index].first;
    member.block = found->name;
    type = found->members[index].second;
  }
  return member;
}

std::string ShaderNames::Note(const std::string& where, const std::string& name) const {
  const auto found = notes_.find({where, name});
  return found != notes_.end() ? found->second : "";
}

}  // namespace stillray::vulkan

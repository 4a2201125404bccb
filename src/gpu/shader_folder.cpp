// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/shader_folder.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>

#include <fmt/format.h>

#include "gpu/embedded_shader.h"

namespace stillray::gpu {
namespace {

/// Filled before main by static objects in the generated shader sources.
std::map<const uint32_t*, std::string>& Names() {
  static std::map<const uint32_t*, std::string> names;
  return names;
}

std::filesystem::path Folder() {
  const char* folder = std::getenv(kShaderFolderVariable);
  return folder != nullptr ? folder : "";
}

std::filesystem::path FileOf(const std::string& name) {
  return Folder() / (name + ".spv");
}

bool IsThere(const std::filesystem::path& file) {
  std::error_code error;
  return std::filesystem::exists(file, error);
}

/// Checks that the words are a header and complete instructions that end with a function: drivers
/// do not validate, and crash.
Status CheckModule(const std::string& file, size_t bytes, std::span<const uint32_t> words) {
  constexpr uint32_t kMagic = 0x07230203;
  constexpr size_t kHeaderWords = 5;
  if (bytes % sizeof(uint32_t) != 0 || words.size() <= kHeaderWords) {
    return Status::BadData(fmt::format(
        "{}: {} has {} bytes, expected SPIR-V: whole words of 4 bytes, more than {} of them",
        kShaderFolderVariable, file, bytes, kHeaderWords));
  }
  if (words[0] != kMagic) {
    return Status::BadData(fmt::format("{}: {} begins with {:#010x}, expected SPIR-V: {:#010x}",
                                       kShaderFolderVariable, file, words[0], kMagic));
  }
  for (size_t at = kHeaderWords; at < words.size();) {
    const size_t length = words[at] >> 16;
    if (length == 0 || length > words.size() - at) {
      return Status::BadData(
          fmt::format("{}: {} is damaged: the instruction at word {} has {} words, {} are left",
                      kShaderFolderVariable, file, at, length, words.size() - at));
    }
    at += length;
  }
  // A module ends with OpFunctionEnd.
  constexpr uint32_t kFunctionEnd = 0x00010038;
  if (words.back() != kFunctionEnd) {
    return Status::BadData(fmt::format(
        "{}: {} is damaged: its last word is {:#010x}, expected the end of a function: {:#010x}",
        kShaderFolderVariable, file, words.back(), kFunctionEnd));
  }
  return Status::Ok();
}

}  // namespace

EmbeddedShader::EmbeddedShader(const char* name, const std::uint32_t* code) {
  Names()[code] = name;
}

Result<std::vector<uint32_t>> ReplacementOf(std::span<const uint32_t> code) {
  const std::filesystem::path folder = Folder();
  if (folder.empty()) {
    return std::vector<uint32_t>();
  }
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    return Status::NotFound(fmt::format("{} is '{}', expected a folder with .spv files",
                                        kShaderFolderVariable, folder.string()));
  }
  const auto name = Names().find(code.data());
  if (name == Names().end() || !IsThere(FileOf(name->second))) {
    return std::vector<uint32_t>();
  }
  const std::filesystem::path path = FileOf(name->second);
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.is_open() || file.bad()) {
    return Status::Io(fmt::format("{}: {} cannot be read", kShaderFolderVariable, path.string()));
  }
  std::vector<uint32_t> words(bytes.size() / sizeof(uint32_t));
  std::memcpy(words.data(), bytes.data(), words.size() * sizeof(uint32_t));
  STILLRAY_RETURN_IF_ERROR(CheckModule(path.string(), bytes.size(), words));
  return words;
}

std::string EmbeddedNameOf(std::span<const uint32_t> code) {
  const auto name = Names().find(code.data());
  return name != Names().end() ? name->second : "";
}

std::vector<std::string> ReplacedShaders() {
  std::vector<std::string> replaced;
  if (Folder().empty()) {
    return replaced;
  }
  for (const auto& [code, name] : Names()) {
    if (IsThere(FileOf(name))) {
      replaced.push_back(name);
    }
  }
  std::sort(replaced.begin(), replaced.end());
  return replaced;
}

}  // namespace stillray::gpu

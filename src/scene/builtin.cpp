// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/builtin.h"

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "core/lower_case.h"
#include "core/nearest_names.h"
#include "scene/import_log.h"

namespace stillray {

namespace {

struct Builtin {
  const char* name;
  Scene (*make)();
};

constexpr std::array<Builtin, 9> kBuiltins = {{
    {"cornell", &MakeCornellScene},
    {"spheres", &MakeSpheresScene},
    {"lights", &MakeLightsScene},
    {"materials", &MakeMaterialsScene},
    {"mirrors", &MakeMirrorsScene},
    {"thin", &MakeThinScene},
    {"faust", &MakeFaustScene},
    {"colonnade", &MakeColonnadeScene},
    {"car", &MakeCarScene},
}};

constexpr std::string_view kBuiltinPrefix = "builtin:";

}  // namespace

std::vector<std::string> BuiltinSceneNames() {
  std::vector<std::string> names;
  for (const Builtin& builtin : kBuiltins) {
    names.emplace_back(builtin.name);
  }
  return names;
}

Result<Scene> MakeBuiltinScene(const std::string& name) {
  for (const Builtin& builtin : kBuiltins) {
    if (name == builtin.name) {
      Scene scene = builtin.make();
      scene.name = name;
      return scene;
    }
  }
  const std::string meant = DidYouMeanOneOf(name, BuiltinSceneNames());
  return Status::NotFound(fmt::format(
      "there is no built-in scene '{}'{}", Printable(name),
      meant.empty() ? fmt::format("; there are {}", fmt::join(BuiltinSceneNames(), ", ")) : meant));
}

namespace {

/// Suggests a built-in scene for a misspelt name that is not a file: "cornell", "bultin:cornell".
std::string MeantBuiltin(const std::string& spec) {
  std::vector<std::string> names;
  for (const std::string& name : BuiltinSceneNames()) {
    if (name == spec) {
      return fmt::format(", did you mean {}{}?", kBuiltinPrefix, name);
    }
    names.push_back(std::string(kBuiltinPrefix) + name);
  }
  return DidYouMeanOneOf(spec, names);
}

Result<Scene> LoadSceneFile(const std::string& path, const KeepGoing& keep_going) {
  return LowerExtension(path) == ".obj" ? LoadObj(path, keep_going) : LoadGltf(path, keep_going);
}

}  // namespace

Result<Scene> LoadScene(const std::string& spec, const KeepGoing& keep_going) {
  if (spec.compare(0, kBuiltinPrefix.size(), kBuiltinPrefix) == 0) {
    return MakeBuiltinScene(spec.substr(kBuiltinPrefix.size()));
  }
  Result<Scene> scene = LoadSceneFile(spec, keep_going);
  const std::string meant = scene.ok() ? "" : MeantBuiltin(spec);
  std::error_code error;
  if (!meant.empty() && !std::filesystem::exists(spec, error)) {
    return Status::NotFound(fmt::format("{}: no such file{}", Printable(spec), meant));
  }
  return scene;
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/builtin.h"

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "core/lower_case.h"
#include "scene/import_log.h"

namespace stillray {

namespace {

struct Builtin {
  const char* name;
  Scene (*make)();
};

constexpr std::array<Builtin, 8> kBuiltins = {{
    {"cornell", &MakeCornellScene},
    {"spheres", &MakeSpheresScene},
    {"lights", &MakeLightsScene},
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
  return Status::NotFound(fmt::format("there is no built-in scene '{}'; there are {}",
                                      Printable(name), fmt::join(BuiltinSceneNames(), ", ")));
}

Result<Scene> LoadScene(const std::string& spec, const KeepGoing& keep_going) {
  if (spec.compare(0, kBuiltinPrefix.size(), kBuiltinPrefix) == 0) {
    return MakeBuiltinScene(spec.substr(kBuiltinPrefix.size()));
  }
  if (LowerExtension(spec) == ".obj") {
    return LoadObj(spec, keep_going);
  }
  return LoadGltf(spec, keep_going);
}

}  // namespace stillray

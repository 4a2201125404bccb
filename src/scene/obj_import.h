// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Import of Wavefront OBJ and MTL. The steps, one file each, share one state and run in order of
/// declaration, until an error is logged.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "scene/import_common.h"
#include "scene/import_log.h"
#include "stillray/scene.h"

namespace stillray {

/// Returns the bytes of a file next to the OBJ file, by its name in the OBJ or MTL file.
using ObjFiles = std::function<Result<std::vector<uint8_t>>(const std::string& name)>;

/// Whether this build reads OBJ.
bool ReadsObj();

/// Imports OBJ text; safe on any bytes.
Result<Scene> ImportObj(std::span<const uint8_t> bytes, const ObjFiles& files,
                        const KeepGoing& keep_going);

/// Normalised OBJ text for the parser.
struct ObjText {
  std::string text;                    ///< only v, vt, vn, f, g, s and usemtl, by number
  std::vector<std::string> materials;  ///< names, by number
  std::vector<std::vector<std::string>> libraries;  ///< per mtllib line, the names to try in order
  std::vector<std::string> groups;                  ///< names, by number
};

/// Validates and normalises every line: the parser itself reads invalid numbers as zero, and does
/// not check indices.
Status CheckObjText(std::span<const uint8_t> bytes, ImportLog* log, ObjText* out);

/// A decoded image.
struct ObjPicture {
  std::string file;
  int width = 0;
  int height = 0;
  std::vector<uint8_t> texels;
  bool is_used = false;  ///< used by a texture
};

struct ObjImport {
  ImportLog log;
  Scene scene;
  ObjFiles files;
  KeepGoing keep_going;
  ObjText text;
  std::vector<int> material_of_name;  ///< ObjText::materials -> Scene::materials
  /// Images read so far; empty for unreadable images, each of which has one warning.
  std::map<std::string, std::optional<ObjPicture>> pictures;
  /// Purpose, both source files and wrap mode -> Scene::textures.
  std::map<std::tuple<int, std::string, std::string, Wrap>, int> texture_of_use;
  TextureBudget texture_budget;
  uint64_t checksum = 0;
};

/// Reads the libraries and converts the used materials.
void ImportObjMaterials(ObjImport* import);

void ImportObjMeshes(ObjImport* import);

/// The material of faces without a material.
Material NeutralObjMaterial(const std::string& name);

}  // namespace stillray

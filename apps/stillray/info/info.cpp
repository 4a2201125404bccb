// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray info: describes a file.
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/commands.h"
#include "common/device_option.h"
#include "common/json_output.h"
#include "info/info_picture.h"
#include "info/info_scene.h"
#include "io/sequence.h"
#include "quality/picture_file.h"
#include "stillray/io.h"
#include "stillray/scene.h"

namespace stillray {

namespace {

struct InfoOptions {
  std::string file;
  AovOptions aovs;
  bool has_file = false;
  bool devices = false;
  std::string json_path;
};

struct Description {
  std::string text;
  nlohmann::ordered_json json;
};

Result<Description> Describe(const std::string& file, const AovOptions& aovs) {
  if (file.empty()) {
    return Status::InvalidArgument("the name of the file is empty");
  }
  if (LooksLikeScene(file)) {
    const Result<Scene> scene = LoadScene(file);
    if (!scene.ok()) {
      return scene.status();
    }
    return Description{SceneText(file, *scene), SceneJson(file, *scene)};
  }
  const Result<PictureInfo> picture = DescribePicture(file, aovs);
  if (picture.ok()) {
    return Description{PictureText(*picture), PictureJson(*picture)};
  }
  if (picture.status().code() == StatusCode::kNotFound && IsSequenceName(file)) {
    const Result<std::vector<FrameFile>> files = FindFrameFiles(file, kPictureEndings);
    if (!files.ok()) {
      return files.status();
    }
    return Status::NotFound(fmt::format("{}: info takes one file, not a sequence of {}, such as {}",
                                        file, files->size(), files->front().path));
  }
  return picture.status();
}

Status Print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    return Status::Io(fmt::format("standard output: could not be written: {}",
                                  std::generic_category().message(errno)));
  }
  return Status::Ok();
}

Status RunInfo(const InfoOptions& options) {
  if (options.devices == options.has_file) {
    return Status::InvalidArgument("info takes a file, or --devices");
  }
  const Result<Description> description = options.devices
                                              ? Description{DevicesText(), DevicesJson()}
                                              : Describe(options.file, options.aovs);
  if (!description.ok()) {
    return description.status();
  }
  if (options.json_path.empty()) {
    return Print(description->text);
  }
  const std::string json = JsonText(description->json, 2);
  if (options.json_path == "-") {
    return Print(json);
  }
  STILLRAY_RETURN_IF_ERROR(WriteFileAtomically(options.json_path, json.data(), json.size()));
  return Print(description->text);
}

}  // namespace

void AddInfoCommand(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "info", "Describe a picture (EXR, HDR, PNG, JPEG) or a scene (glTF, built-in)");
  auto options = std::make_shared<InfoOptions>();
  const CLI::Option* file = command->add_option(
      "FILE", options->file, "Picture, .gltf, .glb or .obj file, or builtin:NAME");
  command->add_option("--view-layer", options->aovs.view_layer,
                      "For EXR files of several view layers: the one to list");
  command->add_flag("--devices", options->devices,
                    "Instead of a file: list the values of --device");
  command->add_option("--json", options->json_path,
                      "Write everything as JSON to this file too; - for JSON alone on standard "
                      "output");
  command->footer(
      "Examples:\n"
      "  stillray info frame.0001.exr\n"
      "  stillray info kitchen.glb\n"
      "  stillray info builtin:cornell --json cornell.json\n"
      "  stillray info --devices");
  command->callback([options, file, exit_code] {
    options->has_file = file->count() > 0;
    const Status status = RunInfo(*options);
    *exit_code = status.ok() ? kExitOk : ReportError(status);
  });
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "core/printable.h"
#include "core/status_prefix.h"
#include "scene/data_uri.h"
#include "scene/image_decode.h"
#include "stillray/scene.h"

namespace stillray {
namespace {

bool IsBlack(const Texture& mask) {
  for (size_t i = 0; i + 3 < mask.texels.size(); i += 4) {
    const uint8_t* t = mask.texels.data() + i;
    if (t[3] != 0 && (t[0] | t[1] | t[2]) != 0) {
      return false;
    }
  }
  return true;
}

Result<Texture> ReadMask(const std::string& path) {
  const Result<std::vector<uint8_t>> bytes = ReadFileBytes(path);
  STILLRAY_RETURN_IF_ERROR(bytes.status());
  const Result<ImageInfo> info = InspectImage(*bytes);
  if (!info.ok()) {
    return PrefixStatus(Printable(path), info.status());
  }
  if (std::max(info->width, info->height) > kMaxLensMaskSide) {
    return Status::Unsupported(fmt::format("{}: {}x{} pixels, a lens mask has up to {} a side",
                                           Printable(path), info->width, info->height,
                                           kMaxLensMaskSide));
  }
  Result<std::vector<uint8_t>> texels = DecodeImage(*bytes, *info);
  if (!texels.ok()) {
    return PrefixStatus(Printable(path), texels.status());
  }
  Texture mask;
  mask.name = std::filesystem::path(path).filename().string();
  mask.width = info->width;
  mask.height = info->height;
  mask.texels = std::move(*texels);
  if (IsBlack(mask)) {
    return Status::InvalidArgument(
        fmt::format("{}: the picture is black, no light would pass this lens", Printable(path)));
  }
  return mask;
}

}  // namespace

Status SetLensMask(const std::string& path, Scene* scene) {
  Result<Texture> mask = ReadMask(path);
  STILLRAY_RETURN_IF_ERROR(mask.status());
  for (Camera& camera : scene->cameras) {
    camera.lens.mask = static_cast<int>(scene->textures.size());
  }
  scene->textures.push_back(std::move(*mask));
  return Status::Ok();
}

}  // namespace stillray

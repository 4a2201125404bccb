// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "core/status_prefix.h"
#include "scene/gltf_import.h"
#include "scene/image_decode.h"
#include "scene/import_common.h"

namespace stillray {

namespace {

struct EncodedTexture {
  ByteSpan bytes;
  ImageInfo info;
};

/// "texture 'NAME' (images[3])": the name of a texture in messages.
std::string TextureLabel(const GltfImport& import, size_t texture) {
  return fmt::format("texture '{}' (images[{}])", Printable(import.scene.textures[texture].name),
                     import.image_of_texture[texture]);
}

/// Finds the encoded image of a texture.
Status FindBytes(GltfImport* import, size_t texture, ByteSpan* bytes) {
  ImportLog log;
  const JsonView image = import->document.Root(&log).Item(
      "images", static_cast<size_t>(import->image_of_texture[texture]));
  if (image.Has("uri")) {
    const std::vector<uint8_t>* file = LoadUri(image, &import->document);
    if (file != nullptr) {
      *bytes = *file;
    }
    return log.status();
  }
  const JsonView root = import->document.Root(&log);
  const int view = image.Index("bufferView", root.Size("bufferViews"), "bufferViews");
  if (view < 0) {
    image.Fail(nullptr, "has neither a uri nor a bufferView");
    return log.status();
  }
  OpenBufferView(import->document, &log, static_cast<size_t>(view), image.path(), bytes, nullptr);
  return log.status();
}

/// The file name of a damaged image, for messages.
std::string FileName(GltfImport* import, size_t texture) {
  ImportLog ignored;
  const JsonView image = import->document.Root(&ignored).Item(
      "images", static_cast<size_t>(import->image_of_texture[texture]));
  const std::string uri = image.String("uri");
  return uri.empty() || uri.compare(0, 5, "data:") == 0 ? "" : " in " + Printable(uri);
}

bool Inspect(GltfImport* import, std::vector<EncodedTexture>* encoded) {
  TextureBudget budget;
  for (size_t i = 0; i < encoded->size(); ++i) {
    EncodedTexture& texture = (*encoded)[i];
    const std::string label = TextureLabel(*import, i);
    const Status found = FindBytes(import, i, &texture.bytes);
    if (!found.ok()) {
      import->log.Fail(PrefixStatus(label, found));
      return false;
    }
    const Result<ImageInfo> info = InspectImage(texture.bytes);
    if (!info.ok()) {
      import->log.Fail(PrefixStatus(label + FileName(import, i), info.status()));
      return false;
    }
    texture.info = *info;
    const Status taken = budget.Take(*info, texture.bytes.size());
    if (!taken.ok()) {
      import->log.Fail(PrefixStatus(label, taken));
      return false;
    }
  }
  return true;
}

}  // namespace

void ImportTextures(GltfImport* import) {
  std::vector<EncodedTexture> encoded(import->scene.textures.size());
  if (!Inspect(import, &encoded)) {
    return;
  }
  std::vector<Status> results(encoded.size());
  tbb::parallel_for(size_t{0}, encoded.size(), [&](size_t i) {
    if (!import->GoesOn()) {
      results[i] = Status::Cancelled();
      return;
    }
    Result<std::vector<uint8_t>> texels = DecodeImage(encoded[i].bytes, encoded[i].info);
    if (!texels.ok()) {
      results[i] = texels.status();
      return;
    }
    Texture& texture = import->scene.textures[i];
    texture.width = encoded[i].info.width;
    texture.height = encoded[i].info.height;
    texture.texels = std::move(texels).value();
  });
  if (import->cancelled) {
    import->log.Fail(Status::Cancelled());
    return;
  }
  for (size_t i = 0; i < results.size(); ++i) {
    if (!results[i].ok()) {
      import->log.Fail(PrefixStatus(TextureLabel(*import, i) + FileName(import, i), results[i]));
      return;
    }
  }
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/gltf_document.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "core/status_prefix.h"
#include "scene/data_uri.h"

namespace stillray {

namespace {

constexpr uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr uint32_t kBinChunk = 0x004E4942;   // "BIN\0"
constexpr size_t kGlbHeaderBytes = 12;
constexpr size_t kChunkHeaderBytes = 8;
/// glTF nests a dozen levels deep; deeper files could overflow the stack.
constexpr int kMaxJsonDepth = 256;

uint32_t ReadU32(ByteSpan bytes, size_t offset) {
  return static_cast<uint32_t>(bytes[offset]) | static_cast<uint32_t>(bytes[offset + 1]) << 8 |
         static_cast<uint32_t>(bytes[offset + 2]) << 16 |
         static_cast<uint32_t>(bytes[offset + 3]) << 24;
}

/// Finds the chunks of a .glb (glTF 2.0, 4.4). Unknown chunks are skipped, as required.
Status SplitGlb(ByteSpan bytes, ByteSpan* text, GltfDocument* document) {
  if (bytes.size() < kGlbHeaderBytes + kChunkHeaderBytes) {
    return Status::BadData(
        fmt::format("truncated .glb: {} bytes do not hold a header", bytes.size()));
  }
  const uint32_t version = ReadU32(bytes, 4);
  if (version != 2) {
    return Status::Unsupported(
        fmt::format("binary glTF version {}: stillray reads version 2", version));
  }
  const size_t length = ReadU32(bytes, 8);
  if (length > bytes.size()) {
    return Status::BadData(fmt::format("truncated .glb: its header says {} bytes, there are {}",
                                       length, bytes.size()));
  }
  size_t offset = kGlbHeaderBytes;
  for (int chunk = 0; offset + kChunkHeaderBytes <= length; ++chunk) {
    const size_t chunk_bytes = ReadU32(bytes, offset);
    const uint32_t type = ReadU32(bytes, offset + 4);
    offset += kChunkHeaderBytes;
    if (chunk_bytes > length - offset) {
      return Status::BadData(fmt::format("damaged .glb: chunk {} says {} bytes, {} are left", chunk,
                                         chunk_bytes, length - offset));
    }
    if ((chunk == 0) != (type == kJsonChunk)) {
      return Status::BadData("damaged .glb: its first chunk, and no other, must be JSON");
    }
    if (type == kJsonChunk) {
      *text = bytes.subspan(offset, chunk_bytes);
    } else if (type == kBinChunk && !document->has_binary_chunk) {
      document->has_binary_chunk = true;
      document->binary_chunk = bytes.subspan(offset, chunk_bytes);
    }
    offset += chunk_bytes;
  }
  if (text->empty()) {
    return Status::BadData("damaged .glb: it has no JSON chunk");
  }
  return Status::Ok();
}

Status CheckDepth(ByteSpan text) {
  int depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const uint8_t c = text[i];
    if (in_string) {
      if (c == '\\') {
        ++i;
      } else if (c == '"') {
        in_string = false;
      }
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxJsonDepth) {
        return Status::BadData(
            fmt::format("byte {} of the JSON: nested deeper than {} levels", i, kMaxJsonDepth));
      }
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return Status::Ok();
}

Status CheckVersion(const GltfDocument& document) {
  ImportLog log;
  const JsonView asset = document.Root(&log).Object("asset");
  if (!asset.exists()) {
    return log.ok() ? Status::BadData("asset: missing, so this is no glTF") : log.status();
  }
  const std::string version = asset.String("version");
  const std::string min_version = asset.String("minVersion", "2.0");
  STILLRAY_RETURN_IF_ERROR(log.status());
  if (version.substr(0, 2) != "2.") {
    return Status::Unsupported(
        fmt::format("asset.version: glTF version '{}', stillray reads 2.0", Printable(version)));
  }
  if (min_version != "2.0") {
    return Status::Unsupported(
        fmt::format("asset.minVersion: glTF version '{}' is needed, stillray reads 2.0",
                    Printable(min_version)));
  }
  return Status::Ok();
}

}  // namespace

Status ParseGltf(ByteSpan bytes, const std::string& base_folder, GltfDocument* document) {
  if (bytes.empty()) {
    return Status::BadData("the file is empty");
  }
  document->base_folder = base_folder;
  document->total_bytes = bytes.size();
  ByteSpan text = bytes;
  if (bytes.size() >= 4 && ReadU32(bytes, 0) == kGlbMagic) {
    STILLRAY_RETURN_IF_ERROR(SplitGlb(bytes, &text, document));
  }
  STILLRAY_RETURN_IF_ERROR(CheckDepth(text));
  try {
    document->json = nlohmann::json::parse(text.begin(), text.end());
  } catch (const nlohmann::json::exception& error) {
    return Status::BadData(fmt::format("not valid JSON: {}", Printable(error.what())));
  }
  if (!document->json.is_object()) {
    return Status::BadData("the JSON is not an object");
  }
  return CheckVersion(*document);
}

const std::vector<uint8_t>* LoadUri(const JsonView& owner, GltfDocument* document) {
  const std::string uri = owner.String("uri");
  if (!owner.log()->ok()) {
    return nullptr;
  }
  const bool inlined = IsDataUri(uri);
  std::string key = "data:" + owner.path();  // cannot collide with a file path
  if (!inlined) {
    Result<std::string> path = ResolveUri(uri, document->base_folder);
    if (!path.ok()) {
      owner.Fail("uri", path.status().message());
      return nullptr;
    }
    key = *path;
  }
  const auto known = document->files.find(key);
  if (known != document->files.end()) {
    return known->second.get();
  }
  Result<std::vector<uint8_t>> bytes = inlined ? DecodeDataUri(uri) : ReadFileBytes(key);
  if (!bytes.ok()) {
    owner.log()->Fail(PrefixStatus(owner.path() + ".uri", bytes.status()));
    return nullptr;
  }
  if (!inlined) {
    document->total_bytes += bytes->size();
  }
  auto& slot = document->files[key];
  slot = std::make_unique<std::vector<uint8_t>>(std::move(bytes).value());
  return slot.get();
}

void LoadBuffers(GltfDocument* document, ImportLog* log) {
  const JsonView root = document->Root(log);
  const size_t count = root.Size("buffers");
  for (size_t i = 0; i < count && log->ok(); ++i) {
    const JsonView buffer = root.Item("buffers", i);
    const uint64_t length = buffer.Count("byteLength", 0);
    ByteSpan bytes;
    if (buffer.Has("uri")) {
      const std::vector<uint8_t>* file = LoadUri(buffer, document);
      if (file == nullptr) {
        return;
      }
      bytes = *file;
    } else if (i == 0 && document->has_binary_chunk) {
      bytes = document->binary_chunk;
    } else if (length != 0) {
      // KHR_mesh compression extensions leave such buffers as fallbacks; without those extensions
      // they must be unused, and read as empty.
      log->Warn(fmt::format("buffers[{}]: has no data", i));
      document->buffers.emplace_back();
      continue;
    }
    if (length > bytes.size()) {
      buffer.Fail("byteLength", fmt::format("says {} bytes, there are {}", length, bytes.size()));
      return;
    }
    document->buffers.push_back(bytes.first(length));
  }
}

bool OpenBufferView(const GltfDocument& document, ImportLog* log, size_t index,
                    const std::string& user, ByteSpan* bytes, size_t* stride) {
  const JsonView root = document.Root(log);
  const JsonView view = root.Item("bufferViews", index);
  if (!view.exists()) {
    log->Fail(Status::BadData(fmt::format("{}: bufferViews[{}] does not exist, there are {}", user,
                                          index, root.Size("bufferViews"))));
    return false;
  }
  const int buffer = view.Index("buffer", document.buffers.size(), "buffers");
  const uint64_t offset = view.Count("byteOffset", 0);
  const uint64_t length = view.Count("byteLength", 0);
  const uint64_t step = view.Count("byteStride", 0);
  if (log->ok() && buffer < 0) {
    view.Fail("buffer", "missing");
  }
  if (!log->ok()) {
    return false;
  }
  const ByteSpan data = document.buffers[static_cast<size_t>(buffer)];
  if (length == 0 || offset > data.size() || length > data.size() - offset) {
    view.Fail(nullptr, fmt::format("bytes {} to {} do not lie in buffers[{}], which has {}", offset,
                                   offset + length, buffer, data.size()));
    return false;
  }
  if (step != 0 && (step < 4 || step > 252 || step % 4 != 0)) {
    view.Fail("byteStride", fmt::format("{} is not one of 4, 8, ... 252", step));
    return false;
  }
  *bytes = data.subspan(offset, length);
  if (stride != nullptr) {
    *stride = step;
  }
  return true;
}

}  // namespace stillray

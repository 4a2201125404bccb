// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The outer layer of a glTF file: container, JSON and buffers (glTF 2.0, 3.6 and 4.4).
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "scene/import_log.h"
#include "scene/json_view.h"
#include "stillray/status.h"

namespace stillray {

using ByteSpan = std::span<const uint8_t>;

/// The JSON and buffers of a glTF file. References the input bytes, which must outlive it.
struct GltfDocument {
  nlohmann::json json;
  std::string base_folder;  ///< folder of the file; empty: no external files
  bool has_binary_chunk = false;
  ByteSpan binary_chunk;
  std::vector<ByteSpan> buffers;  ///< each truncated to its byteLength
  /// Contents of files and data URIs, by path or by the URI's owner; `buffers` points into these.
  std::map<std::string, std::unique_ptr<std::vector<uint8_t>>> files;
  size_t total_bytes = 0;  ///< bytes of the document and all referenced files, each counted once

  JsonView Root(ImportLog* log) const { return {&json, "", log}; }
};

/// Splits a .glb into its chunks or reads `bytes` as .gltf text, parses the JSON, and requires glTF
/// version 2. Buffers are not read yet.
/// \return kBadData, kUnsupported (glTF 1)
Status ParseGltf(ByteSpan bytes, const std::string& base_folder, GltfDocument* document);

/// Fills GltfDocument::buffers.
void LoadBuffers(GltfDocument* document, ImportLog* log);

/// The data of a "uri" member; read only once if referenced several times.
/// \return nullptr after a failure, which is logged with the view's path
const std::vector<uint8_t>* LoadUri(const JsonView& owner, GltfDocument* document);

/// Checks bufferViews[index] and returns its bytes.
/// \param user    name of the referencing element, for error messages
/// \param stride  [out] byteStride, 0 if not given; may be nullptr
/// \return false after a failure, which is logged
bool OpenBufferView(const GltfDocument& document, ImportLog* log, size_t index,
                    const std::string& user, ByteSpan* bytes, size_t* stride);

}  // namespace stillray

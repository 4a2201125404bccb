// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/data_uri.h"

#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "core/base64.h"
#include "scene/import_log.h"

namespace stillray {

namespace fs = std::filesystem;

namespace {

int HexDigit(char c) {
  if (c >= '0' && c <= '9') {
    return c - '0';
  }
  if (c >= 'a' && c <= 'f') {
    return c - 'a' + 10;
  }
  if (c >= 'A' && c <= 'F') {
    return c - 'A' + 10;
  }
  return -1;
}

std::optional<std::string> PercentDecode(const std::string& text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    if (i + 2 >= text.size()) {
      return std::nullopt;
    }
    const int high = HexDigit(text[i + 1]);
    const int low = HexDigit(text[i + 2]);
    if (high < 0 || low < 0 || (high == 0 && low == 0)) {
      return std::nullopt;
    }
    out += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return out;
}

/// RFC 3986, 3.1: a letter, then letters, digits, '+', '-', '.', then ':'.
bool HasScheme(const std::string& uri) {
  const size_t colon = uri.find(':');
  if (colon == std::string::npos || colon == 0) {
    return false;
  }
  for (size_t i = 0; i < colon; ++i) {
    const char c = uri[i];
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    const bool other = (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
    if (!letter && (i == 0 || !other)) {
      return false;
    }
  }
  return true;
}

}  // namespace

bool IsDataUri(std::string_view uri) {
  return uri.substr(0, 5) == "data:";
}

Result<std::vector<uint8_t>> DecodeDataUri(std::string_view uri) {
  constexpr std::string_view kMarker = ";base64";
  const size_t comma = uri.find(',');
  if (comma == std::string_view::npos) {
    return Status::BadData("the data URI has no comma, so no data");
  }
  const std::string_view header = uri.substr(0, comma);
  if (header.size() < kMarker.size() || header.substr(header.size() - kMarker.size()) != kMarker) {
    return Status::BadData("the data URI is not base64");
  }
  return DecodeBase64(uri.substr(comma + 1));
}

Result<std::string> ResolveUri(const std::string& uri, const std::string& base_folder) {
  if (HasScheme(uri)) {
    return Status::BadData(
        fmt::format("'{}' is not a relative path: only local files are read", Printable(uri)));
  }
  const std::optional<std::string> decoded = PercentDecode(uri);
  if (!decoded || decoded->empty()) {
    return Status::BadData(fmt::format("'{}' is not a valid relative path", Printable(uri)));
  }
  if (base_folder.empty()) {
    return Status::BadData(fmt::format(
        "external file '{}' cannot be read: the scene has no folder of its own", Printable(uri)));
  }
  const fs::path relative = fs::path(*decoded).lexically_normal();
  if (relative.is_absolute() || (!relative.empty() && *relative.begin() == "..")) {
    return Status::BadData(
        fmt::format("'{}' lies outside the folder of the scene", Printable(uri)));
  }
  return (fs::path(base_folder) / relative).string();
}

Result<std::vector<uint8_t>> ReadFileBytes(const std::string& path) {
  const std::string name = Printable(path);
  std::error_code error;
  const fs::file_status file = fs::status(path, error);
  if (!fs::exists(file)) {
    if (error && error != std::errc::no_such_file_or_directory) {
      return Status::Io(fmt::format("{}: {}", name, error.message()));
    }
    return Status::NotFound(fmt::format("{}: no such file", name));
  }
  if (!fs::is_regular_file(file)) {
    // Reading a pipe or a device could block forever.
    return Status::BadData(fmt::format("{}: not an ordinary file", name));
  }
  const uintmax_t size = fs::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  if (error || !in) {
    return Status::Io(fmt::format("{}: cannot be opened for reading", name));
  }
  std::vector<uint8_t> bytes(size);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (static_cast<uintmax_t>(in.gcount()) != size) {
    return Status::Io(
        fmt::format("{}: read {} bytes where {} were expected", name, in.gcount(), size));
  }
  return bytes;
}

}  // namespace stillray

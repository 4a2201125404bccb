// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Typed JSON reader; every error is reported with its location, such as
/// "meshes[3].primitives[0].material".
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "scene/import_log.h"

namespace stillray {

/// A JSON object, or an empty view: missing members have their default. Members of a wrong type or
/// out of range are logged as errors, and their default is returned so that reading can continue.
class JsonView {
 public:
  JsonView() = default;
  JsonView(const nlohmann::json* object, std::string path, ImportLog* log)
      : object_(object), path_(std::move(path)), log_(log) {}

  bool exists() const { return object_ != nullptr; }
  const std::string& path() const { return path_; }
  ImportLog* log() const { return log_; }
  /// A copy of this view that reports to another log.
  JsonView WithLog(ImportLog* log) const { return {object_, path_, log}; }

  bool Has(const char* key) const { return Find(key) != nullptr; }
  /// Whether the member is an object; never an error.
  bool IsObject(const char* key) const;
  /// Names of the members, sorted.
  std::vector<std::string> Keys() const;

  JsonView Object(const char* key) const;
  /// The member `name` of the member "extensions".
  JsonView Extension(const char* name) const;
  /// Length of the array `key`; 0 if missing.
  size_t Size(const char* key) const;
  /// The i-th object of the array `key`; i < Size(key).
  JsonView Item(const char* key, size_t i) const;

  bool Bool(const char* key, bool fallback) const;
  std::string String(const char* key, const std::string& fallback = "") const;
  /// The i-th string of the array `key`.
  std::string StringItem(const char* key, size_t i) const;
  /// A finite number that a float can hold.
  float Number(const char* key, float fallback) const;
  /// A finite number, clamped to lo..hi with a warning if it is out of range.
  float NumberIn(const char* key, float fallback, float lo, float hi) const;
  /// Integer >= 0 (and below 2^53, the exact range of JSON numbers).
  uint64_t Count(const char* key, uint64_t fallback) const;
  /// Index into the array `what` ("accessors", ...) with `limit` elements; -1 if missing.
  int Index(const char* key, size_t limit, const char* what) const;
  std::vector<int> Indices(const char* key, size_t limit, const char* what) const;
  /// Array of exactly `n` finite numbers; false, with `out` unchanged, if missing or invalid.
  bool Numbers(const char* key, float* out, size_t n) const;

  /// Reports "PATH.key: message" (PATH alone if `key` is null) as damaged data.
  void Fail(const char* key, const std::string& message) const;
  void Warn(const char* key, const std::string& message) const;

 private:
  const nlohmann::json* Find(const char* key) const;
  const nlohmann::json* FindArray(const char* key) const;
  std::string Where(const char* key) const;
  void WrongType(const std::string& where, const char* expected, const nlohmann::json& got) const;
  bool ReadNumber(const nlohmann::json& value, const std::string& where, float* out) const;
  bool ReadWhole(const nlohmann::json& value, const std::string& where, uint64_t* out) const;
  int ReadIndex(const nlohmann::json& value, const std::string& where, size_t limit,
                const char* what) const;

  const nlohmann::json* object_ = nullptr;
  std::string path_;
  ImportLog* log_ = nullptr;
};

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/json_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace stillray {

using nlohmann::json;

namespace {

constexpr double kMaxWhole = 9007199254740992.0;  // 2^53

std::string ItemPath(const std::string& array, size_t i) {
  return fmt::format("{}[{}]", array, i);
}

}  // namespace

const json* JsonView::Find(const char* key) const {
  if (object_ == nullptr) {
    return nullptr;
  }
  const auto it = object_->find(key);
  return it == object_->end() ? nullptr : &*it;
}

const json* JsonView::FindArray(const char* key) const {
  const json* value = Find(key);
  if (value != nullptr && !value->is_array()) {
    WrongType(Where(key), "an array", *value);
    return nullptr;
  }
  return value;
}

std::string JsonView::Where(const char* key) const {
  if (key == nullptr) {
    return path_;
  }
  return path_.empty() ? key : path_ + "." + key;
}

void JsonView::Fail(const char* key, const std::string& message) const {
  log_->Fail(Status::BadData(Where(key) + ": " + message));
}

void JsonView::Warn(const char* key, const std::string& message) const {
  log_->Warn(Where(key) + ": " + message);
}

void JsonView::WrongType(const std::string& where, const char* expected, const json& got) const {
  log_->Fail(
      Status::BadData(fmt::format("{}: expected {}, found {}", where, expected, got.type_name())));
}

std::vector<std::string> JsonView::Keys() const {
  std::vector<std::string> keys;
  if (object_ != nullptr) {
    for (auto it = object_->begin(); it != object_->end(); ++it) {
      keys.push_back(it.key());
    }
  }
  return keys;
}

bool JsonView::IsObject(const char* key) const {
  const json* value = Find(key);
  return value != nullptr && value->is_object();
}

JsonView JsonView::Extension(const char* name) const {
  return Object("extensions").Object(name);
}

JsonView JsonView::Object(const char* key) const {
  const json* value = Find(key);
  if (value == nullptr) {
    return {nullptr, Where(key), log_};
  }
  if (!value->is_object()) {
    WrongType(Where(key), "an object", *value);
    return {nullptr, Where(key), log_};
  }
  return {value, Where(key), log_};
}

size_t JsonView::Size(const char* key) const {
  const json* array = FindArray(key);
  return array == nullptr ? 0 : array->size();
}

JsonView JsonView::Item(const char* key, size_t i) const {
  const json* array = FindArray(key);
  const std::string path = ItemPath(Where(key), i);
  if (array == nullptr || i >= array->size()) {
    return {nullptr, path, log_};
  }
  const json& value = (*array)[i];
  if (!value.is_object()) {
    WrongType(path, "an object", value);
    return {nullptr, path, log_};
  }
  return {&value, path, log_};
}

bool JsonView::Bool(const char* key, bool fallback) const {
  const json* value = Find(key);
  if (value == nullptr) {
    return fallback;
  }
  if (!value->is_boolean()) {
    WrongType(Where(key), "true or false", *value);
    return fallback;
  }
  return value->get<bool>();
}

std::string JsonView::String(const char* key, const std::string& fallback) const {
  const json* value = Find(key);
  if (value == nullptr) {
    return fallback;
  }
  if (!value->is_string()) {
    WrongType(Where(key), "a string", *value);
    return fallback;
  }
  return value->get<std::string>();
}

std::string JsonView::StringItem(const char* key, size_t i) const {
  const json* array = FindArray(key);
  if (array == nullptr || i >= array->size()) {
    return "";
  }
  if (!(*array)[i].is_string()) {
    WrongType(ItemPath(Where(key), i), "a string", (*array)[i]);
    return "";
  }
  return (*array)[i].get<std::string>();
}

bool JsonView::ReadNumber(const json& value, const std::string& where, float* out) const {
  if (!value.is_number()) {
    WrongType(where, "a number", value);
    return false;
  }
  const double number = value.get<double>();
  if (!(std::abs(number) <= static_cast<double>(std::numeric_limits<float>::max()))) {
    log_->Fail(Status::BadData(fmt::format("{}: {} is too large for a float", where, number)));
    return false;
  }
  *out = static_cast<float>(number);
  return true;
}

bool JsonView::ReadWhole(const json& value, const std::string& where, uint64_t* out) const {
  if (!value.is_number()) {
    WrongType(where, "a whole number", value);
    return false;
  }
  const double number = value.get<double>();
  if (!(number >= 0 && number < kMaxWhole) || number != std::floor(number)) {
    log_->Fail(
        Status::BadData(fmt::format("{}: expected a whole number >= 0, found {}", where, number)));
    return false;
  }
  *out = static_cast<uint64_t>(number);
  return true;
}

float JsonView::Number(const char* key, float fallback) const {
  const json* value = Find(key);
  float number = fallback;
  if (value != nullptr) {
    ReadNumber(*value, Where(key), &number);
  }
  return number;
}

float JsonView::NumberIn(const char* key, float fallback, float lo, float hi) const {
  const float number = Number(key, fallback);
  const float clamped = std::clamp(number, lo, hi);
  if (number != clamped) {
    Warn(key, fmt::format("{} is outside {}..{}, {} is used", number, lo, hi, clamped));
  }
  return clamped;
}

uint64_t JsonView::Count(const char* key, uint64_t fallback) const {
  const json* value = Find(key);
  uint64_t number = fallback;
  if (value != nullptr) {
    ReadWhole(*value, Where(key), &number);
  }
  return number;
}

int JsonView::ReadIndex(const json& value, const std::string& where, size_t limit,
                        const char* what) const {
  uint64_t index = 0;
  if (!ReadWhole(value, where, &index)) {
    return -1;
  }
  if (index >= limit || index > static_cast<uint64_t>(std::numeric_limits<int>::max())) {
    log_->Fail(Status::BadData(fmt::format("{}: index {} is out of range, the file has {} {}",
                                           where, index, limit, what)));
    return -1;
  }
  return static_cast<int>(index);
}

int JsonView::Index(const char* key, size_t limit, const char* what) const {
  const json* value = Find(key);
  return value == nullptr ? -1 : ReadIndex(*value, Where(key), limit, what);
}

std::vector<int> JsonView::Indices(const char* key, size_t limit, const char* what) const {
  std::vector<int> indices;
  if (const json* array = FindArray(key)) {
    for (size_t i = 0; i < array->size() && log_->ok(); ++i) {
      indices.push_back(ReadIndex((*array)[i], ItemPath(Where(key), i), limit, what));
    }
  }
  return indices;
}

bool JsonView::Numbers(const char* key, float* out, size_t n) const {
  const json* array = FindArray(key);
  if (array == nullptr) {
    return false;
  }
  if (array->size() != n) {
    Fail(key, fmt::format("expected {} numbers, found {}", n, array->size()));
    return false;
  }
  std::vector<float> numbers(n);
  for (size_t i = 0; i < n; ++i) {
    if (!ReadNumber((*array)[i], ItemPath(Where(key), i), &numbers[i])) {
      return false;
    }
  }
  std::copy(numbers.begin(), numbers.end(), out);
  return true;
}

}  // namespace stillray

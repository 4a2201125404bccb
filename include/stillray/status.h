// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Errors of callers and of the environment, as values: the fault, its location, the value found
/// and the value expected. The libraries return these and never print, exit or throw across their
/// API.
#pragma once

#include <optional>
#include <string>
#include <utility>

namespace stillray {

enum class StatusCode {
  kOk = 0,
  kInvalidArgument,  ///< a caller's error: sizes that differ, a value out of range, an unknown name
  kNotFound,         ///< a file, folder or name that does not exist
  kBadData,          ///< a file or buffer whose content is damaged or inconsistent
  kUnsupported,      ///< valid, but not supported by stillray or this machine
  kIo,               ///< reading or writing failed: permissions, full disk, broken pipe
  kOutOfMemory,
  kCancelled,  ///< cancelled by the caller
  kInternal,   ///< a defect of stillray itself
};

/// Success, or an error with a one-line message that a user can act on.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(StatusCode code, std::string message) : code_(code), message_(std::move(message)) {}

  static Status Ok() { return {}; }
  static Status InvalidArgument(std::string m) {
    return {StatusCode::kInvalidArgument, std::move(m)};
  }
  static Status NotFound(std::string m) { return {StatusCode::kNotFound, std::move(m)}; }
  static Status BadData(std::string m) { return {StatusCode::kBadData, std::move(m)}; }
  static Status Unsupported(std::string m) { return {StatusCode::kUnsupported, std::move(m)}; }
  static Status Io(std::string m) { return {StatusCode::kIo, std::move(m)}; }
  static Status OutOfMemory(std::string m) { return {StatusCode::kOutOfMemory, std::move(m)}; }
  static Status Cancelled() { return {StatusCode::kCancelled, "cancelled"}; }
  static Status Internal(std::string m) { return {StatusCode::kInternal, std::move(m)}; }

  bool ok() const { return code_ == StatusCode::kOk; }
  StatusCode code() const { return code_; }
  const std::string& message() const { return message_; }

 private:
  StatusCode code_ = StatusCode::kOk;
  std::string message_;
};

/// A value, or the Status that explains its absence.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}         // NOLINT: implicit on purpose
  Result(Status status) : status_(std::move(status)) {  // NOLINT: implicit on purpose
    if (status_.ok()) {
      status_ = Status::Internal("a Result was made from an ok Status without a value");
    }
  }

  bool ok() const { return value_.has_value(); }
  const Status& status() const { return status_; }
  /// The value. Only valid when ok().
  T& value() & { return *value_; }
  const T& value() const& { return *value_; }
  T&& value() && { return std::move(*value_); }
  T* operator->() { return &*value_; }
  const T* operator->() const { return &*value_; }
  T& operator*() & { return *value_; }
  const T& operator*() const& { return *value_; }

 private:
  std::optional<T> value_;
  Status status_;
};

}  // namespace stillray

/// Returns the Status of `expression` from the enclosing function unless it is ok.
#define STILLRAY_RETURN_IF_ERROR(expression)                                          \
  do {                                                                                \
    if (::stillray::Status stillray_status_ = (expression); !stillray_status_.ok()) { \
      return stillray_status_;                                                        \
    }                                                                                 \
  } while (false)

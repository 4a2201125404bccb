// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Common code of all functions of the C API: one call at a time per object, messages of failures,
/// no exceptions across the API, and structs that may grow.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <exception>
#include <new>
#include <string>

#include <fmt/format.h>

#include "stillray/status.h"
#include "stillray/stillray.h"

namespace stillray::capi {

inline constexpr char kBusyMessage[] =
    "this denoiser is at work on a frame: wait for it, or use one per thread";

/// The message of calls without an object.
inline std::string& ThreadMessage() {
  thread_local std::string message;
  return message;
}

/// The object whose last call by this thread was rejected because another call was running on it.
/// The object's own message belongs to the running call.
inline const void*& RefusedObject() {
  thread_local const void* object = nullptr;
  return object;
}

/// Prevents concurrent calls on one object, including calls from its progress callback.
class Occupancy {
 public:
  /// \return whether the object was free; Leave() must follow then
  bool Enter() {
    int free = kFree;
    return state_.compare_exchange_strong(free, kBusy, std::memory_order_acquire);
  }
  /// \return whether the object was released meanwhile and must be deleted now
  bool Leave() {
    int busy = kBusy;
    return !state_.compare_exchange_strong(busy, kFree, std::memory_order_acq_rel);
  }
  /// \return whether the object may be deleted now; else Leave() returns true later
  bool Release() { return state_.exchange(kReleased, std::memory_order_acq_rel) == kFree; }

 private:
  enum { kFree, kBusy, kReleased };
  std::atomic<int> state_ = kFree;
};

inline stillray_error Fail(StatusCode code, const char* text, std::string* message) {
  try {
    *message = text;
  } catch (...) {
    message->clear();  // no memory for a message: only the code is returned
  }
  return static_cast<stillray_error>(code);
}

/// Runs `body`, which returns a Status, and stores the message of a failure. Catches all
/// exceptions.
template <typename Body>
stillray_error Guard(std::string* message, const Body& body) {
  try {
    const Status status = body();
    if (status.ok()) {
      return STILLRAY_OK;
    }
    return Fail(status.code(), status.message().c_str(), message);
  } catch (const std::bad_alloc&) {
    return Fail(StatusCode::kOutOfMemory, "out of memory", message);
  } catch (const std::exception& e) {
    return Fail(StatusCode::kInternal, e.what(), message);
  } catch (...) {
    return Fail(StatusCode::kInternal, "unknown exception", message);
  }
}

inline Status IsNull(const char* what) {
  return Status::InvalidArgument(fmt::format("{} is NULL", what));
}

/// Runs `body` on an object that has `occupancy` and `message`, unless another call is running.
template <typename Object, typename Body>
stillray_error WithObject(Object* object, const Body& body) {
  if (object == nullptr) {
    return Guard(&ThreadMessage(), [] { return IsNull("denoiser"); });
  }
  if (!object->occupancy.Enter()) {
    RefusedObject() = object;
    return STILLRAY_ERROR_BUSY;
  }
  RefusedObject() = nullptr;
  const stillray_error error = Guard(&object->message, body);
  if (object->occupancy.Leave()) {
    delete object;
  }
  return error;
}

/// Deletes the object, or leaves the deletion to the running call.
template <typename Object>
void Release(Object* object) {
  if (object != nullptr && object->occupancy.Release()) {
    delete object;
  }
}

/// The message of the last failed call.
template <typename Object>
const char* MessageOf(const Object* object) {
  if (object == nullptr) {
    return ThreadMessage().c_str();
  }
  if (RefusedObject() == object || !object->occupancy.Enter()) {
    return kBusyMessage;
  }
  const char* message = object->message.c_str();
  object->occupancy.Leave();
  return message;
}

/// Larger than any struct of any version: a larger size is uninitialised memory.
inline constexpr size_t kLargestStruct = 4096;

/// Whether the caller has set struct_size.
template <typename Struct>
Status CheckStruct(const Struct* given, const char* name, const char* type) {
  if (given == nullptr) {
    return IsNull(name);
  }
  if (given->struct_size < sizeof(given->struct_size) || given->struct_size > kLargestStruct) {
    return Status::InvalidArgument(
        fmt::format("{}->struct_size is {}, expected sizeof({})", name, given->struct_size, type));
  }
  return Status::Ok();
}

/// Writes the members of the caller's struct; members of a newer header than the library's are set
/// to zero.
template <typename Struct>
void WriteStruct(const Struct& values, Struct* to) {
  const size_t size = to->struct_size;
  constexpr size_t kFirst = sizeof(size_t);
  auto* bytes = reinterpret_cast<unsigned char*>(to);
  std::memset(bytes + kFirst, 0, size - kFirst);
  std::memcpy(bytes + kFirst, reinterpret_cast<const unsigned char*>(&values) + kFirst,
              std::min(size, sizeof(Struct)) - kFirst);
}

/// Reads the caller's struct: members missing in an older header are zero.
/// \return kUnsupported if a member that this library does not have is not zero
template <typename Struct>
Status ReadStruct(const Struct* given, const char* name, const char* type, Struct* values) {
  STILLRAY_RETURN_IF_ERROR(CheckStruct(given, name, type));
  const size_t size = given->struct_size;
  const auto* bytes = reinterpret_cast<const unsigned char*>(given);
  for (size_t i = sizeof(Struct); i < size; ++i) {
    if (bytes[i] != 0) {
      return Status::Unsupported(
          fmt::format("{0} sets what this library does not have: {1} has {2} bytes there, {3} "
                      "here",
                      name, type, size, sizeof(Struct)));
    }
  }
  *values = Struct();
  std::memcpy(values, given, std::min(size, sizeof(Struct)));
  return Status::Ok();
}

}  // namespace stillray::capi

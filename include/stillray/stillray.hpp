// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The C API as C++ classes that release their handles, with errors that must be checked.
/// Header-only, C++17, links only the C API; throws only std::bad_alloc, from its strings. See
/// stillray.h for meaning, units, ranges and errors of each function.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "stillray/stillray.h"

namespace stillray::api {

/// The outcome of a call: a code and a message.
struct [[nodiscard]] Error {
  stillray_error code = STILLRAY_OK;
  std::string message;

  bool ok() const { return code == STILLRAY_OK; }
};

/// The image format of values of type T.
template <typename T>
constexpr stillray_format FormatOf() {
  static_assert(
      std::is_same_v<T, float> || std::is_same_v<T, uint16_t> || std::is_same_v<T, uint32_t>,
      "images are float, uint16_t (bits of a half) or uint32_t (ids)");
  return std::is_same_v<T, float>      ? STILLRAY_FORMAT_FLOAT
         : std::is_same_v<T, uint16_t> ? STILLRAY_FORMAT_HALF
                                       : STILLRAY_FORMAT_UINT32;
}

template <typename T>
stillray_image Interleaved(T* data, int channels, int width, int height) {
  return stillray_interleaved(data, FormatOf<T>(), channels, width, height);
}
template <typename T>
stillray_image Planar(T* data, int channels, int width, int height) {
  return stillray_planar(data, FormatOf<T>(), channels, width, height);
}

/// The device that filters, and its CPU threads. Empty until Create().
class Device {
 public:
  /// \param threads  0: one per processor
  /// \param name     "cpu", "vulkan", "vulkan:N", "auto": see stillray_device_create_on
  Error Create(int threads = 0, const char* name = "cpu") {
    stillray_device* made = nullptr;
    const stillray_error code =
        stillray_device_create_on(STILLRAY_ABI_VERSION, threads, name, &made);
    handle_.reset(made);
    return {code, code == STILLRAY_OK ? "" : stillray_error_message(nullptr)};
  }
  stillray_device* handle() const { return handle_.get(); }
  int threads() const { return stillray_device_threads(handle()); }
  std::string description() const { return stillray_device_description(handle()); }

 private:
  struct Release {
    void operator()(stillray_device* d) const { stillray_device_release(d); }
  };
  std::unique_ptr<stillray_device, Release> handle_;
};

/// The denoiser of one sequence. Empty until Create(); every call on an empty object is an error.
class Denoiser {
 public:
  Error Create(const Device& device, const char* preset = "default") {
    stillray_denoiser* made = nullptr;
    const stillray_error code = stillray_denoiser_create(device.handle(), preset, &made);
    handle_.reset(made);
    progress_.reset();
    return {code, code == STILLRAY_OK ? "" : stillray_error_message(nullptr)};
  }
  stillray_denoiser* handle() const { return handle_.get(); }

  Error SetPreset(const char* name) { return Check(stillray_denoiser_set_preset(handle(), name)); }
  Error Set(const char* name, const std::string& value) {
    return Check(stillray_denoiser_set(handle(), name, value.c_str()));
  }
  Error Get(const char* name, std::string* value) {
    const char* text = nullptr;
    Error error = Check(stillray_denoiser_get(handle(), name, &text));
    if (error.ok()) {
      *value = text;
    }
    return error;
  }

  Error SetInput(const char* name, const stillray_image& image) {
    return Check(stillray_denoiser_set_input(handle(), name, &image));
  }
  Error RemoveInput(const char* name) {
    return Check(stillray_denoiser_set_input(handle(), name, nullptr));
  }
  Error SetOutput(const char* name, const stillray_image& image) {
    return Check(stillray_denoiser_set_output(handle(), name, &image));
  }
  Error RemoveOutput(const char* name) {
    return Check(stillray_denoiser_set_output(handle(), name, nullptr));
  }
  std::vector<std::string> OutputNames() const {
    std::vector<std::string> names;
    for (size_t i = 0; i < stillray_denoiser_output_count(handle()); ++i) {
      names.emplace_back(stillray_denoiser_output_name(handle(), i));
    }
    return names;
  }
  /// See stillray_denoiser_set_jitter: enables temporal antialiasing.
  Error SetJitter(float x, float y) { return Check(stillray_denoiser_set_jitter(handle(), x, y)); }
  /// See stillray_denoiser_set_focal_pixels: needed by depth_weight=position.
  Error SetFocalPixels(float focal_pixels) {
    return Check(stillray_denoiser_set_focal_pixels(handle(), focal_pixels));
  }
  /// \param progress  receives 0..1, returns whether to continue; must not throw; empty: no
  ///     callback
  Error SetProgress(std::function<bool(double)> progress) {
    auto kept = std::make_unique<std::function<bool(double)>>(std::move(progress));
    const bool any = static_cast<bool>(*kept);
    Error error = Check(stillray_denoiser_set_progress(
        handle(),
        any ? +[](void* user, double fraction) {
          return (*static_cast<std::function<bool(double)>*>(user))(fraction) ? 0 : 1;
        }
            : nullptr,
        kept.get()));
    if (error.ok()) {
      progress_ = std::move(kept);
    }
    return error;
  }

  Error Execute() { return Check(stillray_denoiser_execute(handle())); }
  Error SetFrameIndex(int64_t index) {
    return Check(stillray_denoiser_set_frame_index(handle(), index));
  }

  /// Copies the inputs as the next frame of a sequence that is denoised with light of later frames
  /// too: see stillray_denoiser_push.
  Error Push(stillray_cut cut = STILLRAY_CUT_FIND) {
    return Check(stillray_denoiser_push(handle(), cut));
  }
  Error Finish() { return Check(stillray_denoiser_finish(handle())); }
  /// \param pulled  set to whether a frame was ready and written to the outputs
  Error Pull(bool* pulled) {
    int32_t any = 0;
    Error error = Check(stillray_denoiser_pull(handle(), &any));
    *pulled = any != 0;
    return error;
  }
  /// \param waiting  initialised with STILLRAY_WAITING_INIT
  Error GetWaiting(stillray_waiting* waiting) {
    return Check(stillray_denoiser_waiting(handle(), waiting));
  }
  /// \param need  initialised with STILLRAY_MEMORY_NEED_INIT
  Error GetMemoryNeed(stillray_memory_need* need) {
    return Check(stillray_denoiser_memory_need(handle(), need));
  }

  Error Resize(int width, int height) {
    return Check(stillray_denoiser_resize(handle(), width, height));
  }
  Error Reset() { return Check(stillray_denoiser_reset(handle())); }
  Error SaveHistory(std::vector<uint8_t>* bytes) {
    size_t size = 0;
    Error error = Check(stillray_denoiser_save_history(handle(), nullptr, 0, &size));
    if (error.ok()) {
      bytes->resize(size);
      error = Check(stillray_denoiser_save_history(handle(), bytes->data(), size, &size));
    }
    return error;
  }
  Error RestoreHistory(const std::vector<uint8_t>& bytes) {
    return Check(stillray_denoiser_restore_history(handle(), bytes.data(), bytes.size()));
  }
  /// A warning about the last frame; usually empty.
  std::string Warning() const { return stillray_denoiser_warning(handle()); }
  /// \param statistics  initialised with STILLRAY_STATISTICS_INIT
  Error GetStatistics(stillray_statistics* statistics) {
    return Check(stillray_denoiser_statistics(handle(), statistics));
  }

 private:
  struct Release {
    void operator()(stillray_denoiser* d) const { stillray_denoiser_release(d); }
  };
  Error Check(stillray_error code) const {
    return {code, code == STILLRAY_OK ? "" : stillray_error_message(handle())};
  }

  std::unique_ptr<std::function<bool(double)>> progress_;
  std::unique_ptr<stillray_denoiser, Release> handle_;
};

}  // namespace stillray::api

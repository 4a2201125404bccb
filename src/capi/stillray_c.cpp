// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "stillray/stillray.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>
#include <tbb/info.h>

#include "capi/calls.h"
#include "capi/session.h"

struct stillray_device {
  std::shared_ptr<stillray::capi::Workplace> place;
};

struct stillray_denoiser {
  stillray_denoiser(std::shared_ptr<stillray::capi::Workplace> place,
                    const stillray::Settings& settings)
      : session(std::move(place), settings) {}
  mutable stillray::capi::Occupancy occupancy;
  stillray::capi::Session session;
  std::string message;                    ///< of the last failed call
  std::string value;                      ///< last result of get()
  std::string warning;                    ///< last result of warning()
  std::vector<std::string> output_names;  ///< owns the last results of output_name()
};

namespace stillray::capi {
namespace {

constexpr int kMaxThreads = 1024;

static_assert(static_cast<int>(StatusCode::kInvalidArgument) == STILLRAY_ERROR_INVALID_ARGUMENT);
static_assert(static_cast<int>(StatusCode::kNotFound) == STILLRAY_ERROR_NOT_FOUND);
static_assert(static_cast<int>(StatusCode::kBadData) == STILLRAY_ERROR_BAD_DATA);
static_assert(static_cast<int>(StatusCode::kUnsupported) == STILLRAY_ERROR_UNSUPPORTED);
static_assert(static_cast<int>(StatusCode::kIo) == STILLRAY_ERROR_IO);
static_assert(static_cast<int>(StatusCode::kOutOfMemory) == STILLRAY_ERROR_OUT_OF_MEMORY);
static_assert(static_cast<int>(StatusCode::kCancelled) == STILLRAY_ERROR_CANCELLED);
static_assert(static_cast<int>(StatusCode::kInternal) == STILLRAY_ERROR_INTERNAL);

/// Runs `body` on the denoiser; if it throws, history restarts.
template <typename Body>
stillray_error With(stillray_denoiser* denoiser, const Body& body) {
  return WithObject(denoiser, [&]() -> Status {
    try {
      return body(denoiser->session);
    } catch (...) {
      denoiser->session.Abandon();
      throw;
    }
  });
}

Status OutOfRange(const char* what, size_t index, size_t count) {
  return Status::InvalidArgument(
      fmt::format("there is no {} {}, expected 0 to {}", what, index, count - 1));
}

}  // namespace
}  // namespace stillray::capi

using stillray::Result;
using stillray::Settings;
using stillray::Status;
using stillray::capi::CheckStruct;
using stillray::capi::Guard;
using stillray::capi::IsNull;
using stillray::capi::Session;
using stillray::capi::ThreadMessage;
using stillray::capi::With;
using stillray::capi::WriteStruct;

extern "C" {

uint32_t stillray_abi_version(void) {
  return STILLRAY_ABI_VERSION;
}

const char* stillray_version(void) {
  return STILLRAY_VERSION;
}

const char* stillray_error_name(int error) {
  switch (error) {
    case STILLRAY_OK:
      return "ok";
    case STILLRAY_ERROR_INVALID_ARGUMENT:
      return "invalid argument";
    case STILLRAY_ERROR_NOT_FOUND:
      return "not found";
    case STILLRAY_ERROR_BAD_DATA:
      return "bad data";
    case STILLRAY_ERROR_UNSUPPORTED:
      return "unsupported";
    case STILLRAY_ERROR_IO:
      return "input or output failed";
    case STILLRAY_ERROR_OUT_OF_MEMORY:
      return "out of memory";
    case STILLRAY_ERROR_CANCELLED:
      return "cancelled";
    case STILLRAY_ERROR_INTERNAL:
      return "internal error";
    case STILLRAY_ERROR_BUSY:
      return "busy";
    default:
      return "unknown error";
  }
}

stillray_image stillray_interleaved(void* data, int32_t format, int32_t channels, int32_t width,
                                    int32_t height) {
  return {data, format, channels, width, height, 0, 0, 0};
}

stillray_image stillray_planar(void* data, int32_t format, int32_t channels, int32_t width,
                               int32_t height) {
  const ptrdiff_t bytes = format == STILLRAY_FORMAT_HALF ? 2 : 4;
  return {data, format, channels, width, height, bytes, width * bytes, width * bytes * height};
}

size_t stillray_input_count(void) {
  return stillray::capi::Inputs().size();
}

stillray_error stillray_input_at(size_t index, stillray_input_info* info) {
  return Guard(&ThreadMessage(), [&] {
    STILLRAY_RETURN_IF_ERROR(CheckStruct(info, "info", "stillray_input_info"));
    const auto inputs = stillray::capi::Inputs();
    if (index >= inputs.size()) {
      return stillray::capi::OutOfRange("input", index, inputs.size());
    }
    WriteStruct(inputs[index], info);
    return Status::Ok();
  });
}

size_t stillray_parameter_count(void) {
  return stillray::Parameters().size();
}

stillray_error stillray_parameter_at(size_t index, stillray_parameter* parameter) {
  return Guard(&ThreadMessage(), [&] {
    STILLRAY_RETURN_IF_ERROR(CheckStruct(parameter, "parameter", "stillray_parameter"));
    const auto parameters = stillray::Parameters();
    if (index >= parameters.size()) {
      return stillray::capi::OutOfRange("parameter", index, parameters.size());
    }
    // Static text; the table itself is constant.
    static const std::vector<std::string> defaults = [] {
      std::vector<std::string> texts;
      for (const stillray::Parameter& p : stillray::Parameters()) {
        texts.push_back(stillray::GetParameter(Settings(), p.name).value());
      }
      return texts;
    }();
    const stillray::Parameter& p = parameters[index];
    const stillray_parameter values = {sizeof(values),
                                       p.name,
                                       p.help,
                                       p.group,
                                       p.unit,
                                       static_cast<stillray_parameter_type>(p.type),
                                       p.min,
                                       p.max,
                                       defaults[index].c_str(),
                                       p.choices.empty() ? nullptr : p.choices.data(),
                                       p.choices.size()};
    WriteStruct(values, parameter);
    return Status::Ok();
  });
}

size_t stillray_preset_count(void) {
  return stillray::PresetNames().size();
}

const char* stillray_preset_name(size_t index) {
  const auto names = stillray::PresetNames();
  return index < names.size() ? names[index].data() : nullptr;  // made of literals
}

stillray_error stillray_device_create(uint32_t abi_version, int32_t threads,
                                      stillray_device** device) {
  return stillray_device_create_on(abi_version, threads, "cpu", device);
}

stillray_error stillray_device_create_on(uint32_t abi_version, int32_t threads, const char* name,
                                         stillray_device** device) {
  return Guard(&ThreadMessage(), [&] {
    if (device == nullptr) {
      return IsNull("device");
    }
    *device = nullptr;
    if (abi_version != STILLRAY_ABI_VERSION) {
      return Status::Unsupported(
          fmt::format("the program was compiled for ABI version {}, this library has {}",
                      abi_version, STILLRAY_ABI_VERSION));
    }
    if (threads < 0 || threads > stillray::capi::kMaxThreads) {
      return Status::InvalidArgument(
          fmt::format("threads is {}, expected 0 to {}", threads, stillray::capi::kMaxThreads));
    }
    if (name == nullptr) {
      return IsNull("name");
    }
    const Result<stillray::Device> opened = stillray::Device::Open(name);
    STILLRAY_RETURN_IF_ERROR(opened.status());
    // More threads than processors have no benefit, and TBB would print a warning.
    const int processors = tbb::info::default_concurrency();
    const int count = threads != 0 ? std::min<int>(threads, processors) : processors;
    *device = new stillray_device{std::make_shared<stillray::capi::Workplace>(count, *opened)};
    return Status::Ok();
  });
}

const char* stillray_device_description(const stillray_device* device) {
  return device != nullptr ? device->place->device.description().c_str() : "";
}

void stillray_device_release(stillray_device* device) {
  delete device;
}

int32_t stillray_device_threads(const stillray_device* device) {
  return device != nullptr ? device->place->threads : 0;
}

stillray_error stillray_denoiser_create(stillray_device* device, const char* preset,
                                        stillray_denoiser** denoiser) {
  return Guard(&ThreadMessage(), [&] {
    if (denoiser == nullptr) {
      return IsNull("denoiser");
    }
    *denoiser = nullptr;
    if (device == nullptr) {
      return IsNull("device");
    }
    const Result<Settings> settings =
        stillray::PresetSettings(preset != nullptr ? preset : "default");
    if (!settings.ok()) {
      return settings.status();
    }
    *denoiser = new stillray_denoiser(device->place, settings.value());
    return Status::Ok();
  });
}

void stillray_denoiser_release(stillray_denoiser* denoiser) {
  stillray::capi::Release(denoiser);
}

const char* stillray_error_message(const stillray_denoiser* denoiser) {
  return stillray::capi::MessageOf(denoiser);
}

stillray_error stillray_denoiser_set_preset(stillray_denoiser* denoiser, const char* preset) {
  return With(denoiser, [&](Session& session) {
    if (preset == nullptr) {
      return IsNull("preset");
    }
    const Result<Settings> settings = stillray::PresetSettings(preset);
    if (!settings.ok()) {
      return settings.status();
    }
    session.SetSettings(settings.value());
    return Status::Ok();
  });
}

stillray_error stillray_denoiser_set(stillray_denoiser* denoiser, const char* name,
                                     const char* value) {
  return With(denoiser, [&](Session& session) {
    if (name == nullptr || value == nullptr) {
      return IsNull(name == nullptr ? "name" : "value");
    }
    Settings settings = session.settings();
    STILLRAY_RETURN_IF_ERROR(stillray::SetParameter(&settings, name, value));
    session.SetSettings(settings);
    return Status::Ok();
  });
}

stillray_error stillray_denoiser_get(stillray_denoiser* denoiser, const char* name,
                                     const char** value) {
  return With(denoiser, [&](Session& session) {
    if (name == nullptr || value == nullptr) {
      return IsNull(name == nullptr ? "name" : "value");
    }
    *value = nullptr;
    Result<std::string> text = stillray::GetParameter(session.settings(), name);
    if (!text.ok()) {
      return text.status();
    }
    denoiser->value = std::move(text.value());
    *value = denoiser->value.c_str();
    return Status::Ok();
  });
}

stillray_error stillray_denoiser_set_input(stillray_denoiser* denoiser, const char* name,
                                           const stillray_image* image) {
  return With(denoiser, [&](Session& session) {
    return name == nullptr ? IsNull("name") : session.SetInput(name, image);
  });
}

stillray_error stillray_denoiser_set_output(stillray_denoiser* denoiser, const char* name,
                                            const stillray_image* image) {
  return With(denoiser, [&](Session& session) {
    return name == nullptr ? IsNull("name") : session.SetOutput(name, image);
  });
}

size_t stillray_denoiser_output_count(stillray_denoiser* denoiser) {
  size_t count = 0;
  With(denoiser, [&](Session& session) {
    count = session.OutputNames().size();
    return Status::Ok();
  });
  return count;
}

const char* stillray_denoiser_output_name(stillray_denoiser* denoiser, size_t index) {
  const char* name = nullptr;
  With(denoiser, [&](Session& session) {
    denoiser->output_names = session.OutputNames();
    if (index < denoiser->output_names.size()) {
      name = denoiser->output_names[index].c_str();
    }
    return Status::Ok();
  });
  return name;
}

stillray_error stillray_denoiser_set_jitter(stillray_denoiser* denoiser, float jitter_x,
                                            float jitter_y) {
  return With(denoiser, [&](Session& session) { return session.SetJitter(jitter_x, jitter_y); });
}

stillray_error stillray_denoiser_set_focal_pixels(stillray_denoiser* denoiser, float focal_pixels) {
  return With(denoiser, [&](Session& session) { return session.SetFocalPixels(focal_pixels); });
}

stillray_error stillray_denoiser_set_progress(stillray_denoiser* denoiser,
                                              stillray_progress progress, void* user) {
  return With(denoiser, [&](Session& session) {
    session.SetProgress(progress, user);
    return Status::Ok();
  });
}

stillray_error stillray_denoiser_execute(stillray_denoiser* denoiser) {
  return With(denoiser, [](Session& session) { return session.Execute(); });
}

stillray_error stillray_denoiser_set_frame_index(stillray_denoiser* denoiser, int64_t index) {
  return With(denoiser, [&](Session& session) {
    session.SetFrameIndex(index);
    return Status::Ok();
  });
}

stillray_error stillray_denoiser_push(stillray_denoiser* denoiser, int32_t cut) {
  return With(denoiser, [&](Session& session) { return session.Push(cut); });
}

stillray_error stillray_denoiser_finish(stillray_denoiser* denoiser) {
  return With(denoiser, [](Session& session) {
    session.Finish();
    return Status::Ok();
  });
}

stillray_error stillray_denoiser_pull(stillray_denoiser* denoiser, int32_t* pulled) {
  return With(denoiser, [&](Session& session) {
    if (pulled == nullptr) {
      return IsNull("pulled");
    }
    bool any = false;
    const Status status = session.Pull(&any);
    *pulled = any ? 1 : 0;
    return status;
  });
}

stillray_error stillray_denoiser_waiting(stillray_denoiser* denoiser, stillray_waiting* waiting) {
  return With(denoiser, [&](Session& session) {
    STILLRAY_RETURN_IF_ERROR(CheckStruct(waiting, "waiting", "stillray_waiting"));
    WriteStruct(session.Waiting(), waiting);
    return Status::Ok();
  });
}

stillray_error stillray_denoiser_memory_need(stillray_denoiser* denoiser,
                                             stillray_memory_need* need) {
  return With(denoiser, [&](Session& session) {
    STILLRAY_RETURN_IF_ERROR(CheckStruct(need, "need", "stillray_memory_need"));
    stillray_memory_need values = STILLRAY_MEMORY_NEED_INIT;
    STILLRAY_RETURN_IF_ERROR(session.MemoryNeed(&values));
    WriteStruct(values, need);
    return Status::Ok();
  });
}

stillray_error stillray_denoiser_resize(stillray_denoiser* denoiser, int32_t width,
                                        int32_t height) {
  return With(denoiser, [&](Session& session) { return session.Resize(width, height); });
}

stillray_error stillray_denoiser_reset(stillray_denoiser* denoiser) {
  return With(denoiser, [](Session& session) {
    session.Reset();
    return Status::Ok();
  });
}

stillray_error stillray_denoiser_save_history(stillray_denoiser* denoiser, void* buffer,
                                              size_t capacity, size_t* size) {
  return With(denoiser, [&](Session& session) {
    if (size == nullptr) {
      return IsNull("size");
    }
    *size = 0;
    const Result<std::vector<uint8_t>> bytes = session.SaveHistory();
    if (!bytes.ok()) {
      return bytes.status();
    }
    *size = bytes->size();
    if (buffer == nullptr) {
      return Status::Ok();
    }
    if (capacity < bytes->size()) {
      return Status::InvalidArgument(
          fmt::format("buffer has {} bytes, history needs {}", capacity, bytes->size()));
    }
    std::memcpy(buffer, bytes->data(), bytes->size());
    return Status::Ok();
  });
}

stillray_error stillray_denoiser_restore_history(stillray_denoiser* denoiser, const void* buffer,
                                                 size_t size) {
  return With(denoiser, [&](Session& session) {
    if (buffer == nullptr) {
      return IsNull("buffer");
    }
    return session.RestoreHistory({static_cast<const uint8_t*>(buffer), size});
  });
}

stillray_error stillray_denoiser_statistics(stillray_denoiser* denoiser,
                                            stillray_statistics* statistics) {
  return With(denoiser, [&](Session& session) {
    STILLRAY_RETURN_IF_ERROR(CheckStruct(statistics, "statistics", "stillray_statistics"));
    WriteStruct(session.Statistics(), statistics);
    return Status::Ok();
  });
}

const char* stillray_denoiser_warning(stillray_denoiser* denoiser) {
  const char* warning = "";
  With(denoiser, [&](Session& session) {
    denoiser->warning = session.warning();
    warning = denoiser->warning.c_str();
    return Status::Ok();
  });
  return warning;
}

}  // extern "C"

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "stillray/vulkan.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "capi/calls.h"
#include "capi/camera_access.h"
#include "stillray/vulkan.hpp"

struct stillray_vulkan_denoiser {
  mutable stillray::capi::Occupancy occupancy;
  stillray_vulkan_allocator allocator = {};  // before the denoiser, which calls it
  std::optional<stillray::VulkanDenoiser> denoiser;
  std::string message;
};

namespace stillray::capi {
namespace {

static_assert(STILLRAY_VULKAN_INDIRECT_TRANSMISSION ==
              static_cast<int>(SignalKind::kIndirectTransmission));

Status CheckGiven(const void* pointer, const char* name) {
  return pointer != nullptr ? Status::Ok() : IsNull(name);
}

Result<VulkanOptions> OptionsOf(const stillray_vulkan_options& o) {
  VulkanOptions options;
  const Result<Settings> preset = PresetSettings(o.preset != nullptr ? o.preset : "default");
  STILLRAY_RETURN_IF_ERROR(preset.status());
  options.settings = *preset;
  for (size_t i = 0; o.settings != nullptr && i < o.setting_count; ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckGiven(o.settings[i], "a setting"));
    STILLRAY_RETURN_IF_ERROR(AssignParameter(&options.settings, o.settings[i]));
  }
  options.width = o.width;
  options.height = o.height;
  options.transmission = o.transmission != 0;
  options.precision = o.full_precision != 0 ? DevicePrecision::kFloat : DevicePrecision::kHalf;
  options.timestamps = o.timestamps != 0;
  options.incomplete_guides = o.incomplete_guides != 0;
  options.virtual_guides = o.virtual_guides != 0;
  options.hit_distances = o.hit_distances != 0;
  options.frames_in_flight = o.frames_in_flight;
  options.debug_labels = o.debug_labels != 0;
  options.share_with = o.share_with != nullptr ? &*o.share_with->denoiser : nullptr;
  return options;
}

/// Calls the allocator in C. \param user  stillray_vulkan_allocator
VkResult Allocate(void* user, const VkMemoryRequirements* need, VulkanMemoryBlock* block) {
  const auto& allocator = *static_cast<const stillray_vulkan_allocator*>(user);
  stillray_vulkan_memory_block in_c = {};
  const VkResult result = allocator.allocate(allocator.user, need, &in_c);
  *block = {in_c.memory, in_c.offset, in_c.handle};
  return result;
}
void Free(void* user, const VulkanMemoryBlock* block) {
  const auto& allocator = *static_cast<const stillray_vulkan_allocator*>(user);
  const stillray_vulkan_memory_block in_c = {block->memory, block->offset, block->handle};
  allocator.free(allocator.user, &in_c);
}

/// \param allocator  [out] the context's allocator; must outlive objects created from the result
VulkanContext ContextOf(const stillray_vulkan_context& c, stillray_vulkan_allocator* allocator) {
  VulkanContext context = {c.instance, c.physical_device, c.device, c.get_instance_proc_addr,
                           c.pipeline_cache};
  *allocator = c.allocator;
  context.allocator = {allocator, c.allocator.allocate != nullptr ? &Allocate : nullptr,
                       c.allocator.free != nullptr ? &Free : nullptr};
  return context;
}

VulkanFrame FrameOf(const stillray_vulkan_frame& f) {
  const auto image = [&](int slot) {
    return VulkanImage{f.images[slot].view, f.images[slot].layout};
  };
  VulkanFrame frame;
  frame.index = f.index;
  frame.samples_per_pixel = f.samples_per_pixel;
  frame.colour_is_half = f.colour_is_half != 0;
  frame.jitter_x = f.jitter_x;
  frame.jitter_y = f.jitter_y;
  frame.focal_pixels = f.focal_pixels;
  frame.width = f.width;
  frame.height = f.height;
  for (int k = 0; k < kSignalKindCount; ++k) {
    frame.lights[k] = image(STILLRAY_VULKAN_DIRECT_DIFFUSE + k);
    frame.second_moments[k] = image(STILLRAY_VULKAN_SECOND_MOMENT + k);
  }
  frame.depth = image(STILLRAY_VULKAN_DEPTH);
  frame.normal = image(STILLRAY_VULKAN_NORMAL);
  frame.id = image(STILLRAY_VULKAN_ID);
  frame.motion = image(STILLRAY_VULKAN_MOTION);
  frame.albedo = image(STILLRAY_VULKAN_ALBEDO);
  frame.specular_albedo = image(STILLRAY_VULKAN_SPECULAR_ALBEDO);
  frame.transmission_albedo = image(STILLRAY_VULKAN_TRANSMISSION_ALBEDO);
  frame.emission = image(STILLRAY_VULKAN_EMISSION);
  frame.background = image(STILLRAY_VULKAN_BACKGROUND);
  frame.samples = image(STILLRAY_VULKAN_SAMPLES);
  frame.roughness = image(STILLRAY_VULKAN_ROUGHNESS);
  frame.confidence = image(STILLRAY_VULKAN_CONFIDENCE);
  frame.previous_normal = image(STILLRAY_VULKAN_PREVIOUS_NORMAL);
  frame.reflection = {
      image(STILLRAY_VULKAN_REFLECTION_DEPTH), image(STILLRAY_VULKAN_REFLECTION_NORMAL),
      image(STILLRAY_VULKAN_REFLECTION_MOTION), image(STILLRAY_VULKAN_REFLECTION_ID),
      image(STILLRAY_VULKAN_REFLECTION_ALBEDO)};
  frame.refraction = {
      image(STILLRAY_VULKAN_REFRACTION_DEPTH), image(STILLRAY_VULKAN_REFRACTION_NORMAL),
      image(STILLRAY_VULKAN_REFRACTION_MOTION), image(STILLRAY_VULKAN_REFRACTION_ID),
      image(STILLRAY_VULKAN_REFRACTION_ALBEDO)};
  frame.hit_distance = image(STILLRAY_VULKAN_HIT_DISTANCE);
  frame.camera = f.camera != nullptr ? ReadCamera(*f.camera) : CameraMatrices();
  frame.previous_camera =
      f.previous_camera != nullptr ? ReadCamera(*f.previous_camera) : CameraMatrices();
  frame.colour = image(STILLRAY_VULKAN_COLOUR);
  frame.display = image(STILLRAY_VULKAN_DISPLAY);
  for (int s = 0; s < kVulkanSignals; ++s) {
    frame.filtered[s] = image(STILLRAY_VULKAN_FILTERED + s);
  }
  return frame;
}

/// Rejects images of slots that only later versions define.
Status CheckSlots(const stillray_vulkan_frame& frame) {
  for (int slot = STILLRAY_VULKAN_SLOT_COUNT; slot < STILLRAY_VULKAN_SLOT_ROOM; ++slot) {
    if (frame.images[slot].view != VK_NULL_HANDLE) {
      return Status::InvalidArgument(
          fmt::format("frame {}: images[{}] is given, expected images up to {}", frame.index, slot,
                      STILLRAY_VULKAN_SLOT_COUNT - 1));
    }
  }
  return Status::Ok();
}

/// Empty while another call on the denoiser is running.
std::vector<StageTime> TimesOf(const stillray_vulkan_denoiser* denoiser) {
  std::vector<StageTime> times;
  if (denoiser != nullptr && denoiser->occupancy.Enter()) {
    times = denoiser->denoiser->timings();
    denoiser->occupancy.Leave();
  }
  return times;
}

template <typename Body>
stillray_error WithDenoiser(stillray_vulkan_denoiser* denoiser, const Body& body) {
  return WithObject(denoiser, [&] { return body(&*denoiser->denoiser); });
}

/// Common to both functions that take options. \param allocator  [out] the context's allocator;
/// must outlive objects created from the result
Status Read(const stillray_vulkan_context* context, const stillray_vulkan_options* options,
            stillray_vulkan_allocator* allocator, VulkanContext* context_out,
            VulkanOptions* options_out) {
  stillray_vulkan_context c;
  stillray_vulkan_options o;
  STILLRAY_RETURN_IF_ERROR(ReadStruct(context, "context", "stillray_vulkan_context", &c));
  STILLRAY_RETURN_IF_ERROR(ReadStruct(options, "options", "stillray_vulkan_options", &o));
  Result<VulkanOptions> understood = OptionsOf(o);
  STILLRAY_RETURN_IF_ERROR(understood.status());
  *context_out = ContextOf(c, allocator);
  *options_out = std::move(understood.value());
  return Status::Ok();
}

}  // namespace
}  // namespace stillray::capi

using namespace stillray;        // NOLINT: the functions below stand at global scope
using namespace stillray::capi;  // NOLINT

extern "C" {

stillray_error stillray_vulkan_memory_need(const stillray_vulkan_context* context,
                                           const stillray_vulkan_options* options,
                                           stillray_vulkan_memory* need) {
  return Guard(&ThreadMessage(), [&]() -> Status {
    stillray_vulkan_allocator allocator;
    VulkanContext c;
    VulkanOptions o;
    STILLRAY_RETURN_IF_ERROR(Read(context, options, &allocator, &c, &o));
    STILLRAY_RETURN_IF_ERROR(CheckStruct(need, "need", "stillray_vulkan_memory"));
    const Result<DeviceMemory> memory = VulkanDenoiser::MemoryNeed(c, o);
    STILLRAY_RETURN_IF_ERROR(memory.status());
    const stillray_vulkan_memory values = {sizeof(values), memory->allocations, memory->resources,
                                           memory->bytes, memory->largest};
    WriteStruct(values, need);
    return Status::Ok();
  });
}

stillray_error stillray_vulkan_create(uint32_t abi_version, const stillray_vulkan_context* context,
                                      const stillray_vulkan_options* options,
                                      stillray_vulkan_denoiser** denoiser) {
  return Guard(&ThreadMessage(), [&]() -> Status {
    STILLRAY_RETURN_IF_ERROR(CheckGiven(denoiser, "denoiser"));
    *denoiser = nullptr;
    if (abi_version != STILLRAY_ABI_VERSION) {
      return Status::Unsupported(
          fmt::format("ABI version is {}, this library has {}", abi_version, STILLRAY_ABI_VERSION));
    }
    VulkanContext c;
    VulkanOptions o;
    auto handle = std::make_unique<stillray_vulkan_denoiser>();
    STILLRAY_RETURN_IF_ERROR(Read(context, options, &handle->allocator, &c, &o));
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(c, o);
    STILLRAY_RETURN_IF_ERROR(made.status());
    handle->denoiser.emplace(std::move(made.value()));
    *denoiser = handle.release();
    return Status::Ok();
  });
}

void stillray_vulkan_release(stillray_vulkan_denoiser* denoiser) {
  Release(denoiser);
}

stillray_error stillray_vulkan_record(stillray_vulkan_denoiser* denoiser, VkCommandBuffer commands,
                                      const stillray_vulkan_frame* frame) {
  return WithDenoiser(denoiser, [&](VulkanDenoiser* d) {
    stillray_vulkan_frame f;
    STILLRAY_RETURN_IF_ERROR(ReadStruct(frame, "frame", "stillray_vulkan_frame", &f));
    STILLRAY_RETURN_IF_ERROR(CheckSlots(f));
    return d->Record(commands, FrameOf(f));
  });
}

stillray_error stillray_vulkan_set(stillray_vulkan_denoiser* denoiser, const char* name,
                                   const char* value) {
  return WithDenoiser(denoiser, [&](VulkanDenoiser* d) {
    STILLRAY_RETURN_IF_ERROR(CheckGiven(name, "name"));
    STILLRAY_RETURN_IF_ERROR(CheckGiven(value, "value"));
    Settings settings = d->settings();
    STILLRAY_RETURN_IF_ERROR(SetParameter(&settings, name, value));
    return d->SetSettings(settings);
  });
}

stillray_error stillray_vulkan_reset(stillray_vulkan_denoiser* denoiser) {
  return WithDenoiser(denoiser, [](VulkanDenoiser* d) {
    d->Reset();
    return Status::Ok();
  });
}

stillray_error stillray_vulkan_forget_images(stillray_vulkan_denoiser* denoiser) {
  return WithDenoiser(denoiser, [](VulkanDenoiser* d) { return d->ForgetImages(); });
}

double stillray_vulkan_filter_ms(const stillray_vulkan_denoiser* denoiser) {
  const std::vector<StageTime> times = TimesOf(denoiser);
  double sum = 0;
  for (const StageTime& time : times) {
    sum += time.milliseconds;
  }
  return times.empty() ? -1 : sum;
}

size_t stillray_vulkan_stage_times(const stillray_vulkan_denoiser* denoiser,
                                   stillray_vulkan_stage_time* times, size_t room) {
  const std::vector<StageTime> found = TimesOf(denoiser);
  for (size_t i = 0; i < std::min(times != nullptr ? room : 0, found.size()); ++i) {
    times[i] = {};
    found[i].name.copy(times[i].name, sizeof(times[i].name) - 1);
    times[i].milliseconds = found[i].milliseconds;
  }
  return found.size();
}

const char* stillray_vulkan_error_message(const stillray_vulkan_denoiser* denoiser) {
  return MessageOf(denoiser);
}

}  // extern "C"

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/vulkan/embedded_frame.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/reflections.h"
#include "denoise/frame_check.h"
#include "denoise/vulkan/device_inputs.h"

namespace stillray::vulkan {
namespace {

ImageRef RefOf(const VulkanImage& image) {
  return {image.view, image.layout};
}

bool IsGiven(const VulkanImage& image) {
  return image.view != VK_NULL_HANDLE;
}

}  // namespace

FrameFacts FactsOf(const VulkanFrame& frame, int width, int height) {
  FrameFacts facts;
  facts.index = frame.index;
  facts.width = width;
  facts.height = height;
  facts.focal_pixels = frame.focal_pixels;
  facts.jitter_x = frame.jitter_x;
  facts.jitter_y = frame.jitter_y;
  for (uint32_t k = 0; k < kSignalKindCount; ++k) {
    facts.lights |= IsGiven(frame.lights[k]) ? 1u << k : 0u;
    facts.second_moments |= IsGiven(frame.second_moments[k]) ? 1u << k : 0u;
  }
  facts.second_moments &= facts.lights;
  facts.albedos = (IsGiven(frame.albedo) ? 1u : 0u) | (IsGiven(frame.specular_albedo) ? 2u : 0u) |
                  (IsGiven(frame.transmission_albedo) ? 4u : 0u);
  facts.has_samples = IsGiven(frame.samples);
  facts.has_id = IsGiven(frame.id);
  facts.has_emission = IsGiven(frame.emission);
  facts.has_background = IsGiven(frame.background);
  facts.has_roughness = IsGiven(frame.roughness);
  facts.has_confidence = IsGiven(frame.confidence);
  facts.has_previous_normal = IsGiven(frame.previous_normal);
  facts.has_reflection = IsGiven(frame.reflection.depth) || IsGiven(frame.hit_distance);
  facts.has_refraction = IsGiven(frame.refraction.depth);
  facts.samples_per_pixel = frame.samples_per_pixel;
  facts.is_displayed = IsGiven(frame.display);
  return facts;
}

FrameInputs InputsOf(const VulkanFrame& frame) {
  FrameInputs in = CommonInputs(frame, RefOf);
  in.confidence = RefOf(frame.confidence);
  in.colour = RefOf(frame.colour);
  in.colour_is_half = frame.colour_is_half;
  in.display = RefOf(frame.display);
  static_assert(kVulkanSignals == static_cast<int>(kMostGroups));
  for (size_t s = 0; s < kMostGroups; ++s) {
    in.filtered[s] = RefOf(frame.filtered[s]);
  }
  return in;
}

namespace {

const VulkanVirtualGuides& ImageOf(const VulkanFrame& frame, GuideSource source) {
  return source == GuideSource::kReflection ? frame.reflection : frame.refraction;
}

/// Whether virtual guides are computed from hit distances.
bool HasHits(const VulkanFrame& frame, GuideSource source) {
  return source == GuideSource::kReflection && IsGiven(frame.hit_distance);
}

Status WithFrame(const VulkanFrame& frame, const Status& status) {
  return Status::InvalidArgument(fmt::format("frame {}: {}", frame.index, status.message()));
}

/// Checks hit distances, which replace depth and motion of the virtual images.
Status CheckHits(const VulkanFrame& frame) {
  for (const auto& [image, name] :
       {std::pair{&frame.reflection.depth, "depth"}, {&frame.reflection.motion, "motion"}}) {
    if (IsGiven(*image)) {
      return Status::InvalidArgument(
          fmt::format("frame {}: image 'reflection.{}' is given beside 'hit_distance', from which "
                      "it follows: expected one of them",
                      frame.index, name));
    }
  }
  return Status::Ok();
}

}  // namespace

Result<VirtualInputs> VirtualInputsOf(const VulkanFrame& frame, GuideSource source, int width,
                                      int height) {
  const VulkanVirtualGuides& seen = ImageOf(frame, source);
  VirtualInputs inputs = {RefOf(seen.depth), RefOf(seen.normal), RefOf(seen.motion), RefOf(seen.id),
                          RefOf(seen.albedo)};
  if (HasHits(frame, source)) {
    const Result<HitCamera> camera =
        MakeHitCamera(frame.camera, frame.previous_camera, width, height);
    if (!camera.ok()) {
      return WithFrame(frame, camera.status());
    }
    inputs.hit_distance = RefOf(frame.hit_distance);
    inputs.hit_camera = *camera;
  }
  return inputs;
}

Status CheckVirtualGuides(const VulkanFrame& frame, GuideSource source) {
  const bool reflected = source == GuideSource::kReflection;
  const std::string name = reflected ? "reflection" : "refraction";
  const VulkanVirtualGuides& seen = ImageOf(frame, source);
  const bool has_hits = HasHits(frame, source);
  const std::pair<const VulkanImage*, std::string> needed[] = {
      {&seen.normal, name + ".normal"},
      {&seen.motion, name + ".motion"},
      {&seen.albedo, name + ".albedo"},
      {&frame.motion, "motion"},
      {&frame.roughness, "roughness"},
      {&frame.albedo, "albedo"},
      {reflected ? &frame.specular_albedo : &frame.transmission_albedo,
       reflected ? "specular_albedo" : "transmission_albedo"}};
  for (const auto& [image, of] : needed) {
    const bool is_of_image = of.starts_with(name);
    if (!IsGiven(*image) && !(has_hits && is_of_image)) {
      return Status::InvalidArgument(fmt::format("frame {}: image '{}' is not given, beside '{}'",
                                                 frame.index, of,
                                                 has_hits ? "hit_distance" : name + ".depth"));
    }
  }
  if (has_hits) {
    return CheckHits(frame);
  }
  return IsGiven(frame.id) && !IsGiven(seen.id)
             ? Status::InvalidArgument(fmt::format(
                   "frame {}: image '{}.id' is not given, beside 'id'", frame.index, name))
             : Status::Ok();
}

Status CheckFrame(const VulkanFrame& frame, const Settings& settings, bool transmission,
                  bool fills_guides, bool jittered) {
  const auto missing = [&](const char* name) {
    return Status::InvalidArgument(
        fmt::format("frame {}: image '{}' is not given", frame.index, name));
  };
  const auto given = [&](SignalKind kind) { return IsGiven(frame.lights[static_cast<int>(kind)]); };
  const bool diffuse = given(SignalKind::kDirectDiffuse) || given(SignalKind::kIndirectDiffuse);
  const bool specular = given(SignalKind::kDirectSpecular) || given(SignalKind::kIndirectSpecular);
  const bool through =
      given(SignalKind::kDirectTransmission) || given(SignalKind::kIndirectTransmission);
  if (!diffuse && !specular && !through) {
    return Status::InvalidArgument(
        fmt::format("frame {}: there are no lights to denoise", frame.index));
  }
  if (through != transmission) {
    return Status::InvalidArgument(
        fmt::format("frame {}: transmission signals are {}given, but the denoiser was made {} them",
                    frame.index, through ? "" : "not ", transmission ? "with" : "without"));
  }
  if (!IsGiven(frame.depth)) {
    return missing("depth");
  }
  if (!IsGiven(frame.normal)) {
    return missing("normal");
  }
  if ((settings.temporal || AntialiasesInTime(settings, jittered) || fills_guides) &&
      !IsGiven(frame.motion)) {
    return missing("motion");
  }
  if (fills_guides && !IsGiven(frame.samples)) {
    return missing("samples");
  }
  if (settings.demodulate && diffuse && !IsGiven(frame.albedo)) {
    return missing("albedo");
  }
  if (settings.demodulate && specular && !IsGiven(frame.specular_albedo)) {
    return missing("specular_albedo");
  }
  if (settings.demodulate && through && !IsGiven(frame.transmission_albedo)) {
    return missing("transmission_albedo");
  }
  if (!IsGiven(frame.colour)) {
    return missing("colour");
  }
  if (!(std::abs(frame.jitter_x) <= 0.5f) || !(std::abs(frame.jitter_y) <= 0.5f)) {
    return Status::InvalidArgument(
        fmt::format("frame {}: jitter is ({}, {}), expected -0.5 to 0.5 for each", frame.index,
                    frame.jitter_x, frame.jitter_y));
  }
  if (!(frame.samples_per_pixel >= 0)) {
    return Status::InvalidArgument(fmt::format("frame {}: samples_per_pixel is {}, expected >= 0",
                                               frame.index, frame.samples_per_pixel));
  }
  return CheckFocalLength(frame.index, frame.focal_pixels, settings);
}

Status CheckOutputs(const VulkanFrame& frame, int most_width, int most_height,
                    std::span<const SignalGroup> groups, const LayerList& layers) {
  const bool fits = frame.width >= 0 && frame.height >= 0 && frame.width <= most_width &&
                    frame.height <= most_height && (frame.width == 0) == (frame.height == 0);
  if (!fits) {
    return Status::InvalidArgument(
        fmt::format("frame {}: it is {}x{}, expected 1x1 to {}x{}, or 0x0 for the latter",
                    frame.index, frame.width, frame.height, most_width, most_height));
  }
  for (size_t s = 0; s < kMostGroups; ++s) {
    if (!IsGiven(frame.filtered[s])) {
      continue;
    }
    if (s >= groups.size()) {
      return Status::InvalidArgument(
          fmt::format("frame {}: image 'filtered[{}]' is given, but there are {} signals",
                      frame.index, s, groups.size()));
    }
    for (const PlannedLayer& layer : layers) {
      if (layer.guides == GuideSource::kSurface) {
        continue;
      }
      if (std::ranges::any_of(groups[s].kinds,
                              [&](SignalKind kind) { return IsLightOf(layer.guides, kind); })) {
        return Status::InvalidArgument(fmt::format(
            "frame {}: image 'filtered[{}]' is given, but the light of the signal '{}' has virtual "
            "guides",
            frame.index, s, groups[s].name));
      }
    }
  }
  return Status::Ok();
}

}  // namespace stillray::vulkan

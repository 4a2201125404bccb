// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/frame_check.h"

#include <algorithm>

#include <fmt/format.h>

#include "denoise/filter_parameters.h"
#include "denoise/signal_groups.h"

namespace stillray {
namespace {

constexpr int kMaxSide = 32768;

/// The name of a plane in messages, put together only where there is one.
struct PlaneName {
  const char* image;
  int channel = -1;  ///< -1: the image has one
  const char* part = "";

  std::string text() const {
    return channel < 0 ? fmt::format("{}{}", image, part) : fmt::format("{}[{}]", image, channel);
  }
};

template <typename T>
Status CheckPlane(const Frame& frame, const Plane<T>& plane, const PlaneName& name, bool required) {
  if (plane.empty()) {
    return required ? Status::InvalidArgument(
                          fmt::format("frame {}: image '{}' is missing, expected {}x{}",
                                      frame.index, name.text(), frame.width, frame.height))
                    : Status::Ok();
  }
  if (plane.width() != frame.width || plane.height() != frame.height) {
    return Status::InvalidArgument(fmt::format("frame {}: image '{}' is {}x{}, expected {}x{}",
                                               frame.index, name.text(), plane.width(),
                                               plane.height(), frame.width, frame.height));
  }
  return Status::Ok();
}

template <int N>
Status CheckPlanes(const Frame& frame, const Planes<float, N>& planes, const char* name,
                   bool required) {
  bool any = false;
  for (int i = 0; i < N; ++i) {
    any = any || !planes[i].empty();
  }
  for (int i = 0; i < N; ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckPlane(frame, planes[i], {name, i}, required || any));
  }
  return Status::Ok();
}

/// Whether there is light that is divided by this guide.
bool DividesLight(const Frame& frame, const Image3& albedo) {
  return std::any_of(frame.signals.begin(), frame.signals.end(), [&](const Signal& signal) {
    return &AlbedoOf(frame.guides, signal.kind) == &albedo;
  });
}

}  // namespace

Status CheckFrame(const Frame& frame, const Settings& settings, bool jittered) {
  if (frame.width < 1 || frame.height < 1 || frame.width > kMaxSide || frame.height > kMaxSide) {
    return Status::InvalidArgument(fmt::format("frame {}: size is {}x{}, expected 1x1 to {}x{}",
                                               frame.index, frame.width, frame.height, kMaxSide,
                                               kMaxSide));
  }
  if (frame.signals.empty()) {
    return Status::InvalidArgument(
        fmt::format("frame {}: there are no signals to denoise", frame.index));
  }
  for (size_t i = 0; i < frame.signals.size(); ++i) {
    const Signal& signal = frame.signals[i];
    const char* name = SignalName(signal.kind);
    for (size_t j = 0; j < i; ++j) {
      if (frame.signals[j].kind == signal.kind) {
        return Status::InvalidArgument(
            fmt::format("frame {}: signal '{}' is given twice", frame.index, name));
      }
    }
    STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, signal.radiance, name, true));
    STILLRAY_RETURN_IF_ERROR(
        CheckPlane(frame, signal.second_moment, {name, -1, ".second_moment"}, false));
  }
  const Guides& g = frame.guides;
  const bool needs_motion = settings.temporal || AntialiasesInTime(settings, jittered);
  STILLRAY_RETURN_IF_ERROR(CheckPlane(frame, g.depth, {"depth"}, true));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, g.normal, "normal", true));
  STILLRAY_RETURN_IF_ERROR(
      CheckPlanes(frame, g.albedo, "albedo", settings.demodulate && DividesLight(frame, g.albedo)));
  STILLRAY_RETURN_IF_ERROR(
      CheckPlanes(frame, g.specular_albedo, "specular_albedo",
                  settings.demodulate && DividesLight(frame, g.specular_albedo)));
  STILLRAY_RETURN_IF_ERROR(
      CheckPlanes(frame, g.transmission_albedo, "transmission_albedo",
                  settings.demodulate && DividesLight(frame, g.transmission_albedo)));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, g.motion, "motion", needs_motion));
  STILLRAY_RETURN_IF_ERROR(CheckPlane(frame, g.id, {"id"}, false));
  STILLRAY_RETURN_IF_ERROR(CheckPlane(frame, g.roughness, {"roughness"}, false));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, frame.emission, "emission", false));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, frame.background, "background", false));
  return CheckPlane(frame, frame.samples, {"samples"}, false);
}

}  // namespace stillray

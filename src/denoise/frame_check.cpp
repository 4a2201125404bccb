// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/frame_check.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "core/guides.h"
#include "denoise/fill_guides/fill_guides.h"
#include "denoise/signal_groups.h"

namespace stillray {
namespace {

constexpr int kMaxSide = 32768;

/// The name of a plane in messages; the text is built only for a message.
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
  if (!any) {
    return CheckPlane(frame, planes[0], {name}, required);
  }
  for (int i = 0; i < N; ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckPlane(frame, planes[i], {name, i}, true));
  }
  return Status::Ok();
}

/// Checks that motion is given if the history or antialias uses it.
Status CheckMotion(const Frame& frame, const Settings& settings, MotionUse use) {
  const Image2& motion = frame.guides.motion;
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, motion, "motion", false));
  if (!motion.empty()) {
    return Status::Ok();
  }
  const bool fills = settings.fill_guides && HasIncompleteGuides(frame);
  if (!use.any() && !fills) {
    return Status::Ok();
  }
  const char* who = use.temporal && use.antialias ? "'temporal' and 'antialias' follow"
                    : use.temporal                ? "'temporal' follows"
                    : use.antialias               ? "'antialias' follows"
                                                  : "'fill_guides' follows";
  return Status::InvalidArgument(
      fmt::format("frame {}: image 'motion' is missing, expected {}x{}: {} it from frame to frame "
                  "(zero where nothing moves; 'off' needs none)",
                  frame.index, frame.width, frame.height, who));
}

/// The names of virtual guides in messages.
struct VirtualNames {
  const char* depth;
  const char* normal;
  const char* albedo;
  const char* motion;
  const char* id;
};
constexpr VirtualNames kReflection = {"reflection_depth", "reflection_normal", "reflection_albedo",
                                      "reflection_motion", "reflection_id"};
constexpr VirtualNames kRefraction = {"refraction_depth", "refraction_normal", "refraction_albedo",
                                      "refraction_motion", "refraction_id"};

/// Checks virtual guides: depth is required, motion too if there is a history.
Status CheckVirtualGuides(const Frame& frame, const VirtualGuides& guides,
                          const VirtualNames& names, MotionUse use) {
  const bool any = guides.bytes() > 0;
  if (any && guides.empty()) {
    return Status::InvalidArgument(
        fmt::format("frame {}: image '{}' is missing, expected {}x{}: virtual guides are used "
                    "where it is positive",
                    frame.index, names.depth, frame.width, frame.height));
  }
  STILLRAY_RETURN_IF_ERROR(CheckPlane(frame, guides.depth, {names.depth}, false));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, guides.normal, names.normal, false));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, guides.albedo, names.albedo, false));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, guides.motion, names.motion, any && use.temporal));
  return CheckPlane(frame, guides.id, {names.id}, false);
}

/// Calls `in_row` for rows, starting from the middle of the image, where surfaces are more likely
/// than at the top, until it returns true.
template <typename InRow>
bool AnyRow(const Frame& frame, const InRow& in_row) {
  for (int i = 0; i < frame.height; ++i) {
    if (in_row((i + frame.height / 2) % frame.height)) {
      return true;
    }
  }
  return false;
}

bool HasSurface(const Frame& frame) {
  return AnyRow(frame, [&](int y) {
    const float* depth = frame.guides.depth.Row(y);
    int any = 0;  // a sum without early exit, which the compiler vectorises
    for (int x = 0; x < frame.width; ++x) {
      any |= static_cast<int>(IsSurface(depth[x]));
    }
    return any != 0;
  });
}

/// With fewer invalid pixels than 1 in this many, a frame of sky is considered damaged, not of
/// another depth convention.
constexpr int64_t kDamagedPart = 100;

/// Checks for another depth convention: no pixel has a surface, and many depths are negative or
/// NaN.
Status CheckDepth(const Frame& frame) {
  if (HasSurface(frame)) {
    return Status::Ok();
  }
  int64_t negative = 0;
  int64_t nan = 0;
  for (int y = 0; y < frame.height; ++y) {
    const float* depth = frame.guides.depth.Row(y);
    for (int x = 0; x < frame.width; ++x) {
      negative += depth[x] < 0 ? 1 : 0;
      nan += std::isnan(depth[x]) ? 1 : 0;
    }
  }
  if (kDamagedPart * (negative + nan) < int64_t{frame.width} * frame.height ||
      negative + nan == 0) {
    return Status::Ok();
  }
  return Status::InvalidArgument(
      negative >= nan
          ? fmt::format("frame {}: all depths are negative ({} pixels), expected linear view-space "
                        "z > 0: negate the z of OpenGL's view space",
                        frame.index, negative)
          : fmt::format(
                "frame {}: all depths are NaN ({} pixels), expected linear view-space z > 0",
                frame.index, nan));
}

bool IsZeroEverywhere(const Frame& frame, const Image3& image) {
  return !AnyRow(frame, [&](int y) {
    int any = 0;
    for (const Image1& plane : image.channel) {
      const float* row = plane.Row(y);
      for (int x = 0; x < frame.width; ++x) {
        any |= static_cast<int>(row[x] != 0);
      }
    }
    return any != 0;
  });
}

bool IsFiniteAnywhere(const Frame& frame, const Image2& image) {
  return AnyRow(frame, [&](int y) {
    int any = 0;
    for (int x = 0; x < frame.width; ++x) {
      any |= static_cast<int>(std::isfinite(image[0](x, y)) && std::isfinite(image[1](x, y)));
    }
    return any != 0;
  });
}

int64_t CountSurfaces(const Frame& frame) {
  int64_t count = 0;
  for (int y = 0; y < frame.height; ++y) {
    const float* depth = frame.guides.depth.Row(y);
    count += std::count_if(depth, depth + frame.width, IsSurface);
  }
  return count;
}

}  // namespace

Status CheckSize(const Frame& frame) {
  if (frame.width < 1 || frame.height < 1 || frame.width > kMaxSide || frame.height > kMaxSide) {
    return Status::InvalidArgument(fmt::format("frame {}: size is {}x{}, expected 1x1 to {}x{}",
                                               frame.index, frame.width, frame.height, kMaxSide,
                                               kMaxSide));
  }
  return Status::Ok();
}

Status CheckFocalLength(int64_t frame, float focal_pixels, const Settings& settings) {
  if (!(focal_pixels >= 0) || !std::isfinite(focal_pixels)) {
    return Status::InvalidArgument(fmt::format(
        "frame {}: focal_pixels is {}, expected a number > 0, or 0: unknown", frame, focal_pixels));
  }
  if (settings.depth_weight == DepthWeight::kPosition && focal_pixels == 0) {
    return Status::InvalidArgument(fmt::format(
        "frame {}: depth_weight=position needs the focal length of the frame: give files with "
        "worldToCamera and worldToNDC of a perspective camera without shift, or a file of cameras "
        "(--cameras), or call stillray_denoiser_set_focal_pixels (Frame::focal_pixels)",
        frame));
  }
  return Status::Ok();
}

Status CheckFrame(const Frame& frame, const Settings& settings, MotionUse use) {
  STILLRAY_RETURN_IF_ERROR(CheckSize(frame));
  STILLRAY_RETURN_IF_ERROR(CheckFocalLength(frame.index, frame.focal_pixels, settings));
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
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, g.previous_normal, "previous_normal", false));
  STILLRAY_RETURN_IF_ERROR(CheckPlane(frame, g.id, {"id"}, false));
  STILLRAY_RETURN_IF_ERROR(CheckPlane(frame, g.roughness, {"roughness"}, false));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, frame.emission, "emission", false));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes(frame, frame.background, "background", false));
  STILLRAY_RETURN_IF_ERROR(CheckPlane(frame, frame.samples, {"samples"}, false));
  STILLRAY_RETURN_IF_ERROR(CheckPlane(frame, frame.confidence, {"confidence"}, false));
  STILLRAY_RETURN_IF_ERROR(CheckMotion(frame, settings, use));
  STILLRAY_RETURN_IF_ERROR(CheckVirtualGuides(frame, frame.reflection, kReflection, use));
  STILLRAY_RETURN_IF_ERROR(CheckVirtualGuides(frame, frame.refraction, kRefraction, use));
  return CheckDepth(frame);
}

OddValues FindOddValues(const Frame& frame, MotionUse use) {
  OddValues odd;
  if (IsZeroEverywhere(frame, frame.guides.normal) && HasSurface(frame)) {
    odd.bad_guides = CountSurfaces(frame);
    odd.warning = fmt::format(
        "frame {}: image 'normal' is zero at every surface, expected unit length (or no such "
        "image): nothing is filtered",
        frame.index);
  } else if (use.any() && !IsFiniteAnywhere(frame, frame.guides.motion)) {
    odd.warning = fmt::format(
        "frame {}: image 'motion' is not finite at any pixel, expected pixels: no history is found",
        frame.index);
  }
  return odd;
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// One noisy frame of a renderer: radiance split into signals, guides, and radiance that is not
/// filtered (emission, background). Conventions of all of stillray:
///  - pixel (0,0) is the top left, x runs right, y down; pixel centres lie at +0.5
///  - radiance is linear and scene-referred, in any unit, >= 0, without exposure
///  - empty planes mean "not given"
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray {

/// The kind of light in a signal. Diffuse signals are divided by `albedo` before filtering,
/// specular ones by `specular_albedo`, transmitted ones by `transmission_albedo`.
enum class SignalKind : uint8_t {
  kDirectDiffuse,     ///< direct light, diffusely reflected
  kIndirectDiffuse,   ///< light from other surfaces, diffusely reflected
  kDirectSpecular,    ///< direct light, specularly reflected or refracted
  kIndirectSpecular,  ///< light from other surfaces, specularly reflected or refracted
  /// Light transmitted through the first surface, for renderers that separate it from reflection.
  /// stillray's path tracer separates it in frames with virtual guides, for smooth glass and
  /// alpha-blended surfaces; otherwise transmitted light is part of the specular signals.
  kDirectTransmission,
  kIndirectTransmission,
};
inline constexpr int kSignalKindCount = 6;

/// The name of a kind in files and on the command line: "direct_diffuse", ...
const char* SignalName(SignalKind kind);

/// One component of the radiance: width x height, scene-linear RGB, the mean of this frame's
/// samples, albedo included.
struct Signal {
  SignalKind kind = SignalKind::kDirectDiffuse;
  Image3 radiance;
  /// Mean over this frame's samples of luminance(sample / max(albedo, kAlbedoFloor))^2, Rec. 709:
  /// the second moment within the pixel. Empty where every pixel has at most one sample, or if
  /// unknown: the denoiser then estimates it from neighbouring pixels (with limit_history only, and
  /// not for frames on a device).
  Image1 second_moment;
};

/// Noise-free properties of the surface visible at each pixel; all planes are width x height.
struct Guides {
  /// Linear view-space z, > 0; +infinity where the ray left the scene; 0 where guides are unknown.
  Image1 depth;
  Image3 normal;               ///< world space, unit length; zero where there is no surface
  Image3 albedo;               ///< linear diffuse reflectance
  Image3 specular_albedo;      ///< linear specular reflectance towards the viewer (Fresnel and
                               ///< roughness included)
  Image3 transmission_albedo;  ///< linear transmittance; only needed with transmission signals
  Image2 motion;  ///< pixels, without jitter: the point visible at p was at p + motion(p) one frame
                  ///< ago
  Plane<uint32_t> id;  ///< constant for a surface over all frames; 0 where there is no surface
  /// World-space normal of the same surface point one frame ago, for the consistency test of
  /// reprojection: rotating surfaces keep their history. Zero, or empty: equal to `normal`.
  Image3 previous_normal;
  Image1 roughness;  ///< perceptual roughness, 0..1
};

/// Guides of the virtual image in a mirror or a pane of glass: of the surface hit after smooth
/// reflections, or after smooth refractions, placed on the pixel's ray at a distance equal to the
/// length of the whole path. Behind a planar mirror the virtual image is the scene reflected at the
/// mirror's plane. Signals with virtual guides use them in place of the guides of the visible
/// surface for reprojection, edge-stopping functions and limit_history, and are also divided by the
/// albedo of the hit surface.
struct VirtualGuides {
  /// Linear view-space z of the virtual image, > 0; +infinity for the sky; 0 where there is no
  /// virtual image: Guides are used there. Empty: no virtual image anywhere.
  Image1 depth;
  /// World space, unit length; mirrored or not, but consistent over all pixels that show one hit
  /// surface. Empty or zero: the normal of the mirror.
  Image3 normal;
  Image3 albedo;  ///< of the hit surface, sum of all lobes; empty: white
  Image2 motion;  ///< of the virtual image: pixels, as Guides::motion. Required with `temporal`
  Plane<uint32_t> id;  ///< of the hit surface; empty: the id of the mirror

  bool empty() const { return depth.empty(); }
  size_t bytes() const {
    return depth.bytes() + normal.bytes() + albedo.bytes() + motion.bytes() + id.bytes();
  }
};

struct Frame;

// Planes of a frame, as bit flags.
inline constexpr uint32_t kLightPlanes = 1;  ///< signals, samples, emission, background
inline constexpr uint32_t kGuidePlanes = 2;  ///< all of Guides and VirtualGuides, confidence
inline constexpr uint32_t kAllPlanes = kLightPlanes | kGuidePlanes;

/// The planes of a frame in the memory of the device that traced it. They do not change while
/// another reference to this object exists: a renderer reuses it only if it holds the only
/// reference. Thread-safe.
class FrameOnDevice {
 public:
  virtual ~FrameOnDevice() = default;
  /// Copies the selected planes to `host` and resizes them there; planes that the frame lacks
  /// become empty. Other planes of `host` are unchanged.
  /// \param planes  kLightPlanes, kGuidePlanes or both
  /// \return kOutOfMemory, or errors of the device
  virtual Status Download(uint32_t planes, Frame* host) const = 0;
  virtual uint64_t bytes() const = 0;  ///< of device memory
  /// Whether the frame has virtual guides of specular light, which Download copies.
  virtual bool has_reflection() const { return false; }
  /// Whether the frame has virtual guides of transmitted light, which Download copies.
  virtual bool has_refraction() const { return false; }
};

/// All data of one frame. Planes that are not empty are width x height.
struct Frame {
  int width = 0;      ///< pixels
  int height = 0;     ///< pixels
  int64_t index = 0;  ///< number of the frame
  /// All rays of this frame went through (x + 0.5 + jitter_x, y + 0.5 + jitter_y); in -0.5..0.5.
  /// With Antialias::kAuto the first jitter that is not zero starts temporal antialiasing.
  float jitter_x = 0;
  float jitter_y = 0;
  /// Focal length in pixels: width / (2 tan(horizontal angle of view / 2)), of a perspective camera
  /// with square pixels whose optical axis passes through the image centre. 0: unknown, or another
  /// camera. Required by DepthWeight::kPosition.
  float focal_pixels = 0;
  std::vector<Signal> signals;
  Guides guides;
  VirtualGuides reflection;  ///< of the specular signals
  VirtualGuides refraction;  ///< of the transmission signals
  /// Confidence in the accumulated radiance of each pixel, 0..1: factor of the history length of
  /// all signals. 0 drops the history, for example where a light was switched or a shadow moved.
  /// Reprojection does not depend on it. Values are clamped; NaN counts as 1, and in
  /// DenoisedFrame::bad_guides. Empty: 1 everywhere.
  Image1 confidence;
  Image3 emission;    ///< radiance emitted by the first surface: added after filtering
  Image3 background;  ///< radiance of rays that left the scene: neither filtered nor accumulated
  Image1
      /// number of samples of each pixel in this frame; 0: missing. Empty: 1 everywhere
      samples;
  /// Signal::second_moment was estimated by stillray from neighbouring pixels: the noise of a
  /// single pixel is unknown (affects keep_samples).
  bool has_estimated_moments = false;
  /// The planes in device memory, if the renderer left them there (RenderSettings::on_device): the
  /// planes of this struct are then empty, but `signals` has an entry for each kind. A denoiser on
  /// that device reads them in place; other denoisers, and OnHost, copy them to the host.
  std::shared_ptr<FrameOnDevice> on_device;

  /// The signal of this kind, or nullptr.
  const Signal* Find(SignalKind kind) const;
};

/// Returns a frame whose `planes` are in host memory: `frame` itself, or, if it is on a device,
/// `room`, to which they are copied. Planes of `room` that have the right size are reused.
/// \return errors of FrameOnDevice::Download
Result<const Frame*> OnHost(const Frame& frame, Frame* room, uint32_t planes = kAllPlanes);

/// Bytes of all planes, including planes on a device.
size_t FrameBytes(const Frame& frame);

/// The sum of signals, emission and background: the unfiltered image, scene-linear RGB.
Image3 SumOfLight(const Frame& frame);

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// One noisy frame as a renderer hands it over: light split into signals, guides, and the light
/// that needs no filter. Conventions are the same everywhere in stillray:
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

/// Which light a signal holds. Diffuse signals are divided by `albedo` before filtering, specular
/// ones by `specular_albedo`, transmitted ones by `transmission_albedo`.
enum class SignalKind : uint8_t {
  kDirectDiffuse,    ///< light that reached the first surface straight from a light, diffusely
                     ///< reflected
  kIndirectDiffuse,  ///< diffusely reflected light that met other surfaces before
  kDirectSpecular,   ///< light from a light, reflected or refracted specularly at the first surface
  kIndirectSpecular,  ///< specularly reflected or refracted light that met other surfaces before
  /// Light through the first surface, of renderers that tell it from reflections. stillray's own
  /// counts it as specular.
  kDirectTransmission,
  kIndirectTransmission,
};
inline constexpr int kSignalKindCount = 6;

/// The name of a kind in files and on the command line: "direct_diffuse", ...
const char* SignalName(SignalKind kind);

/// One kind of light, summed over nothing else: width x height, scene-linear RGB radiance, the mean
/// of this frame's samples. Albedo is still multiplied in.
struct Signal {
  SignalKind kind = SignalKind::kDirectDiffuse;
  Image3 radiance;
  /// Mean over this frame's samples of luminance(sample / max(albedo, kAlbedoFloor))^2, Rec. 709:
  /// the second moment within the pixel. Empty when every pixel has at most one sample.
  Image1 second_moment;
};

/// What is known of the surface seen by each pixel, free of noise.
struct Guides {
  /// Linear view-space z, > 0; +infinity where the ray left the scene; 0 where no guide is known.
  Image1 depth;
  Image3 normal;               ///< world space, unit length; zero where there is no surface
  Image3 albedo;               ///< linear diffuse reflectance
  Image3 specular_albedo;      ///< linear specular reflectance towards the viewer (Fresnel and
                               ///< roughness included)
  Image3 transmission_albedo;  ///< linear transmittance; only needed with transmission signals
  Image2
      motion;  ///< pixels, without jitter: the point seen at p was at p + motion(p) one frame ago
  Plane<uint32_t> id;  ///< same surface, same number, in every frame; 0 where there is no surface
  Image1 roughness;    ///< perceptual roughness, 0..1
};

struct Frame;

/// Planes of a frame, as bits.
inline constexpr uint32_t kLightPlanes = 1;  ///< signals, samples, emission, background
inline constexpr uint32_t kGuidePlanes = 2;  ///< all of Guides
inline constexpr uint32_t kAllPlanes = kLightPlanes | kGuidePlanes;

/// The pixels of a frame on the device that traced it. They stay as they are as long as anybody
/// holds this: a renderer writes its next frame over them only if nobody but it does. Calls from
/// several threads at once are safe.
class FrameOnDevice {
 public:
  virtual ~FrameOnDevice() = default;
  /// Brings pixels to the host, into those `planes` of `host`, which get their size; planes that
  /// the frame does not have are made empty. All else of `host` is left as it is.
  /// \param planes  kLightPlanes, kGuidePlanes or both
  /// \return kOutOfMemory, or what happened to the device
  virtual Status Download(uint32_t planes, Frame* host) const = 0;
  virtual uint64_t bytes() const = 0;  ///< of device memory
};

struct Frame {
  int width = 0;
  int height = 0;
  int64_t index = 0;
  /// All rays of this frame went through (x + 0.5 + jitter_x, y + 0.5 + jitter_y); in -0.5..0.5.
  /// The denoiser antialiases in time where this is not zero (Antialias::kAuto).
  float jitter_x = 0;
  float jitter_y = 0;
  std::vector<Signal> signals;
  Guides guides;
  Image3 emission;    ///< light that the first surface itself emits: added after filtering
  Image3 background;  ///< light of rays that left the scene: passed through, never blended
  Image1
      samples;  ///< samples that each pixel got in this frame; 0 = missing. Empty: one everywhere
  /// Where the pixels are, if a renderer left them on its device (RenderSettings::on_device): all
  /// planes are empty then, but `signals` has an entry for each kind of light. A denoiser on that
  /// device reads them there, others bring them to the host; OnHost does so for anyone else.
  std::shared_ptr<FrameOnDevice> on_device;

  /// The signal of this kind, or nullptr.
  const Signal* Find(SignalKind kind) const;
};

/// The frame with these `planes` on the host: `frame` itself, unless it lies on a device; then
/// `room`, into which they are brought. Planes of `room` that have their size already are used
/// again.
/// \return as FrameOnDevice::Download
Result<const Frame*> OnHost(const Frame& frame, Frame* room, uint32_t planes = kAllPlanes);

/// Bytes of all planes, of those on a device too.
size_t FrameBytes(const Frame& frame);

/// Signals, emission and background added up: the picture as rendered, before any filter.
Image3 SumOfLight(const Frame& frame);

}  // namespace stillray

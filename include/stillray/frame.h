// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// One noisy frame of a renderer: light split into signals, guides, and the light that needs no
/// filter. Conventions are the same everywhere in stillray:
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
  kIndirectDiffuse,   ///< diffusely reflected light of other surfaces
  kDirectSpecular,    ///< direct light, specularly reflected or refracted
  kIndirectSpecular,  ///< specularly reflected or refracted light of other surfaces
  /// Light transmitted through the first surface, for renderers that separate it from reflection.
  /// stillray's path tracer does so in frames with virtual guides, for smooth glass and
  /// alpha-blended surfaces; otherwise it counts as specular.
  kDirectTransmission,
  kIndirectTransmission,
};
inline constexpr int kSignalKindCount = 6;

/// The name of a kind in files and on the command line: "direct_diffuse", ...
const char* SignalName(SignalKind kind);

/// One kind of light: width x height, scene-linear RGB radiance, the mean of this frame's samples,
/// multiplied by albedo.
struct Signal {
  SignalKind kind = SignalKind::kDirectDiffuse;
  Image3 radiance;
  /// Mean over this frame's samples of luminance(sample / max(albedo, kAlbedoFloor))^2, Rec. 709:
  /// the second moment within the pixel. Empty where every pixel has at most one sample, or where
  /// it is unknown: the denoiser then estimates it from the pixels around (with limit_history only,
  /// and not for frames on a device).
  Image1 second_moment;
};

/// Noise-free properties of the surface seen by each pixel.
struct Guides {
  /// Linear view-space z, > 0; +infinity where the ray left the scene; 0 where guides are unknown.
  Image1 depth;
  Image3 normal;               ///< world space, unit length; zero where there is no surface
  Image3 albedo;               ///< linear diffuse reflectance
  Image3 specular_albedo;      ///< linear specular reflectance towards the viewer (Fresnel and
                               ///< roughness included)
  Image3 transmission_albedo;  ///< linear transmittance; only needed with transmission signals
  Image2
      motion;  ///< pixels, without jitter: the point seen at p was at p + motion(p) one frame ago
  Plane<uint32_t> id;  ///< same surface, same number, in every frame; 0 where there is no surface
  /// World-space normal that the same point of the surface had one frame ago, for the test of its
  /// history: surfaces that turn keep theirs. Zero: as `normal`, as it is everywhere if empty.
  Image3 previous_normal;
  Image1 roughness;  ///< perceptual roughness, 0..1
};

/// Guides of the virtual image that a mirror or a pane of glass shows: of the point that a ray
/// meets after smooth reflections, or after smooth refractions, placed where the eye sees it. That
/// is on the pixel's ray, as far away as the whole path is long. Behind a planar mirror this is the
/// world, reflected at its plane. Signals with virtual guides use them in place of the surface's
/// own for reprojection, edges and limit_history, and are also divided by the albedo of what is
/// seen.
struct VirtualGuides {
  /// Linear view-space z of the image, > 0; +infinity where the sky is seen; 0 where the surface
  /// shows no image: its own guides are used there. Empty: no image anywhere.
  Image1 depth;
  /// World space, unit length, in the same frame of reference for all pixels that show one surface
  /// (mirrored or not). Empty or zero: that of the mirror.
  Image3 normal;
  Image3 albedo;       ///< of the surface seen, all its lobes together; empty: white
  Image2 motion;       ///< of the image: pixels, as Guides::motion. Needed where histories are.
  Plane<uint32_t> id;  ///< of the surface seen; empty: that of the mirror

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

/// The pixels of a frame on the device that traced it. They do not change while a reference to this
/// object exists: a renderer reuses it for another frame only if it holds the only reference. Calls
/// from several threads at once are safe.
class FrameOnDevice {
 public:
  virtual ~FrameOnDevice() = default;
  /// Copies pixels to those `planes` of `host`, which are resized; planes that the frame lacks
  /// become empty. Other planes of `host` are unchanged.
  /// \param planes  kLightPlanes, kGuidePlanes or both
  /// \return kOutOfMemory, or errors of the device
  virtual Status Download(uint32_t planes, Frame* host) const = 0;
  virtual uint64_t bytes() const = 0;  ///< of device memory
  /// Whether the frame has virtual guides of specular light, which Download copies.
  virtual bool has_reflection() const { return false; }
  /// ... of transmitted light.
  virtual bool has_refraction() const { return false; }
};

struct Frame {
  int width = 0;
  int height = 0;
  int64_t index = 0;
  /// All rays of this frame went through (x + 0.5 + jitter_x, y + 0.5 + jitter_y); in -0.5..0.5.
  /// With Antialias::kAuto the first jitter that is not zero starts temporal antialiasing.
  float jitter_x = 0;
  float jitter_y = 0;
  /// Distance of the picture plane from the camera, in pixels: width / (2 tan(horizontal angle of
  /// view / 2)). The optical axis passes through the centre of the picture, and pixels are square.
  /// 0: unknown, or the camera is no such perspective. DepthWeight::kPosition needs it.
  float focal_pixels = 0;
  std::vector<Signal> signals;
  Guides guides;
  VirtualGuides reflection;  ///< of the specular signals
  VirtualGuides refraction;  ///< of the transmission signals
  /// How far the light of the last frame still holds at the point that a pixel shows, 0 to 1: the
  /// length that its history counts for is multiplied by it, in all signals. 0: that history is
  /// dropped, as where a lamp was switched or a shadow moved. Surfaces are found again as without
  /// it. Values are clamped; NaN counts as 1, and as a bad guide. Empty: 1 everywhere.
  Image1 confidence;
  Image3 emission;    ///< light emitted by the first surface: added after filtering
  Image3 background;  ///< light of rays that left the scene: passed through, never blended
  Image1
      /// number of samples of each pixel in this frame; 0 = missing. Empty: one everywhere
      samples;
  /// Second moments are estimates from the pixels around: a pixel's own noise is not known
  /// (keep_samples). Set where stillray has estimated them.
  bool has_estimated_moments = false;
  /// The pixels, if a renderer left them on its device (RenderSettings::on_device): then all planes
  /// are empty, but `signals` has an entry for each kind of light. A denoiser on that device reads
  /// them there, others copy them to the host; OnHost does the same for other uses.
  std::shared_ptr<FrameOnDevice> on_device;

  /// The signal of this kind, or nullptr.
  const Signal* Find(SignalKind kind) const;
};

/// The frame with these `planes` on the host: `frame` itself, unless it is on a device; then
/// `room`, to which they are copied. Planes of `room` that have the right size are reused.
/// \return errors of FrameOnDevice::Download
Result<const Frame*> OnHost(const Frame& frame, Frame* room, uint32_t planes = kAllPlanes);

/// Bytes of all planes, of those on a device too.
size_t FrameBytes(const Frame& frame);

/// The sum of signals, emission and background: the picture as rendered, without filtering.
Image3 SumOfLight(const Frame& frame);

}  // namespace stillray

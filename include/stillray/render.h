// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer: renders one time of an animated scene to a noisy Frame with guides.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "stillray/frame.h"
#include "stillray/parameter.h"
#include "stillray/scene.h"
#include "stillray/status.h"

namespace stillray {

enum class SamplerKind : uint8_t {
  kSobol,     ///< Owen-scrambled Sobol', decorrelated per pixel and frame
  kHalton16,  ///< cycles of the 16 Halton points of SVGF (section 3), rotated per pixel and cycle
  kZSobol,    ///< Owen-scrambled Sobol', stratified over blocks of 8x8 pixels and over time, for
              ///< less noise after a filter (Ahmed and Wonka 2020); equal to kSobol above 2 spp
};

/// The pixels with guides, emission and background in frames with less than one path per pixel.
enum class GuideCoverage : uint8_t {
  kFull,    ///< all pixels: every frame traces the primary rays of all pixels
  kSparse,  ///< pixels with a path in this frame; elsewhere all are 0, including depth
};

/// Sampling of lights. All modes have the same expected value, except that kNone lacks lights
/// without extent.
enum class LightSampling : uint8_t {
  kNone,   ///< BSDF sampling alone, without shadow rays; lights without extent (point, spot,
           ///< directional) contribute nothing
  kBsdf,   ///< as kNone, plus shadow rays to lights without extent
  kLight,  ///< light sampling (shadow rays); BSDF sampling only after ideally smooth surfaces
  kMis,    ///< both, combined by multiple importance sampling
};

/// Limits of RenderSettings; kMaxCycle: number of frames in which every pixel is sampled once.
inline constexpr int kMaxCycle = 256;
inline constexpr int kMaxSpp = 65536;
inline constexpr int kMaxSide = 32768;
inline constexpr int kMaxLightCandidates = 64;
inline constexpr float kMaxClamp = 1e6f;
inline constexpr float kMaxAperture = 1e6f;
inline constexpr float kMaxFocus = 1e6f;
inline constexpr float kMinFNumber = 0.1f;
inline constexpr float kMaxFNumber = 1e3f;

/// Size of the frames, and everything that RenderParameters() lists with range, unit and help. The
/// initialisers are the defaults.
struct RenderSettings {
  int width = 1280;  ///< pixels, 1..kMaxSide
  int height = 720;  ///< pixels, 1..kMaxSide
  int spp = 1;       ///< paths per pixel and frame, 1..kMaxSpp
  /// Frames per path: each frame traces 1 / cycle of the pixels, evenly distributed, and frames
  /// k * cycle ... k * cycle + cycle - 1 trace every pixel once. 1..kMaxCycle; above 1 only with
  /// spp 1. Frame::samples is then 1 where a path was traced and 0, like all signals, elsewhere.
  int cycle = 1;
  GuideCoverage guides = GuideCoverage::kFull;  ///< only used if cycle is above 1
  int bounces = 4;  ///< scattering events of a path after the first surface, 1..32 (1: as in SVGF)
  uint64_t seed = 0;  ///< of all random numbers
  SamplerKind sampler = SamplerKind::kZSobol;
  /// All rays of a frame pass through the same point of their pixels, which moves from frame to
  /// frame (Halton 2,3, period 16), for temporal antialiasing. Off: always the centre.
  bool jitter = true;
  /// Averages base colour textures over the pixel where a surface is visible directly, or with
  /// `virtual_guides` by smooth reflection or refraction: fine textures do not alias. The mean over
  /// the points of a pixel stays the same. Only with `jitter`, and not in references.
  bool filter_textures = true;
  /// Path-space regularisation (SVGF, section 3): roughens surfaces that a path hits after a rough
  /// surface. Fewer fireflies, dimmer caustics.
  bool regularise = false;
  LightSampling light_sampling = LightSampling::kMis;
  /// Candidates for each shadow ray, of which one is chosen in proportion to its contribution
  /// (resampled importance sampling, Talbot et al. 2005), 1..kMaxLightCandidates. Surfaces after
  /// the first use half as many.
  int light_candidates = 4;
  /// Upper limit of the largest RGB component of one ray's contribution to a sample, in radiance,
  /// 0..kMaxClamp; 0: none. Directly visible emission and background are not clamped. Biased:
  /// images become darker, references too.
  float clamp_radiance = 0.0f;
  /// Overrides of the scene camera's lens; unset: the scene's value.
  std::optional<float> aperture;  ///< Lens::radius, 0..kMaxAperture; not together with f_number
  std::optional<float> f_number;  ///< Lens::f_number, kMinFNumber..kMaxFNumber
  std::optional<float> focus;     ///< Lens::focus: 0..kMaxFocus
  std::optional<int> blades;      ///< Lens::blades: 0, or 3..kMaxBlades; also without a mask then
  std::optional<float> blade_rotation;  ///< Lens::rotation, -180..180
  /// Renders Frame::reflection for smooth surfaces, and Frame::refraction with transmission signals
  /// for glass and alpha-blended surfaces. Takes extra rays, and at refracting pixels a second path
  /// for each sample. Ignored with sparse guides and with a lens that has an aperture.
  bool virtual_guides = true;
  /// Leaves frames on the renderer's device (Frame::on_device) while memory lasts, for a denoiser
  /// on the same device. Ignored by renderers on the CPU, whose frames are on the host.
  bool on_device = false;

  bool operator==(const RenderSettings&) const = default;
};

/// The table of settings, in the order of docs/render_settings.md, which is generated from it: all
/// members of RenderSettings but width, height and on_device; "spp" stands for spp and cycle.
std::span<const Parameter> RenderParameters();

/// Sets one row of the table from text: numbers in decimal, flags on/off/true/false/1/0, choices by
/// name, "spp" as "4", "1/8" or "0.125".
/// \return kInvalidArgument naming the setting, the value and the allowed ones; `settings` is then
///     unchanged
Status SetRenderParameter(RenderSettings* settings, std::string_view name, std::string_view value);

/// The value as text that SetRenderParameter reads back.
/// \return kInvalidArgument for an unknown name
Result<std::string> GetRenderParameter(const RenderSettings& settings, std::string_view name);

/// \return kInvalidArgument naming the first setting that is out of range
Status ValidateRenderSettings(const RenderSettings& settings);

/// Whether radiance has the same expected value with both settings, so that a history accumulated
/// with `a` remains valid with `b`. Sampling may differ; paths and the lens may not.
bool SameLight(const RenderSettings& a, const RenderSettings& b);

/// Signals of a rendered frame: direct and indirect, diffuse and specular, in the order of
/// SignalKind. With RenderSettings::virtual_guides, frames of scenes with glass or alpha-blended
/// surfaces also have both transmission signals.
inline constexpr int kTracedSignalCount = 4;
inline constexpr int kMostTracedSignals = kSignalKindCount;

/// A camera at any position.
struct CameraPose {
  /// Camera to world; in camera space the viewing direction is -z and y is up (as in glTF). Scale
  /// is ignored.
  mat4 world_from_camera = mat4(1.0f);
  float yfov = 0.8f;  ///< vertical angle of view, radians; above 0, below pi
};

/// The animation times of this and the previous frame, and the camera.
struct RenderMoment {
  int64_t frame_index = 0;      ///< seed of this frame's random numbers (and of the jitter)
  double seconds = 0;           ///< of this frame
  double previous_seconds = 0;  ///< of the previous frame, to which motion vectors point
  int camera = 0;               ///< index into Scene::cameras
  /// Replaces the scene's camera.
  std::optional<CameraPose> pose;
  /// Pose in the previous frame, to which motion vectors point; only with `pose`. Unset: the camera
  /// is static.
  std::optional<CameraPose> previous_pose;
};

/// Milliseconds of the phases of a frame, and numbers of rays.
struct RenderTimings {
  double update_ms = 0;  ///< transforms, light tables, top level of the BVH
  double clear_ms = 0;   ///< with `cycle`: choosing pixels, and clearing the others
  double primary_ms = 0;
  double bounce_ms = 0;
  double shadow_ms = 0;
  double shade_ms = 0;
  double image_ms = 0;  ///< virtual guides: rays and shading
  double copy_ms = 0;   ///< of renderers on a device: downloading the frame
  uint64_t primary_rays = 0;
  uint64_t bounce_rays = 0;
  uint64_t image_rays = 0;  ///< of virtual guides
  uint64_t shadow_rays = 0;
  /// Number of discarded contributions: NaN, infinite or negative. A value above 0 indicates a
  /// defect of the scene (NaN in its data) or of stillray.
  uint64_t dropped = 0;
};

/// Receives the progress of a long call, 0..1; return false to cancel. Called from one thread at a
/// time.
using RenderProgress = std::function<bool(double fraction)>;

/// A scene prepared for tracing. Not thread-safe; its calls use all threads of the pool. Equal
/// scenes, settings and moments give equal bits, for any number of threads.
class Renderer {
 public:
  /// Builds the BVH and the light tables. `scene` must outlive the renderer and must not change.
  /// \param keep_going  called from time to time, from any thread; return false to cancel
  /// \return kInvalidArgument naming the setting that is out of range, or the inconsistent element
  ///     of the scene; kUnsupported if the ray tracer cannot run; kOutOfMemory; kCancelled
  static Result<std::unique_ptr<Renderer>> Create(const Scene& scene,
                                                  const RenderSettings& settings,
                                                  const KeepGoing& keep_going = {});
  virtual ~Renderer() = default;

  /// Changes settings from the next frame on without preparing the scene again. The random numbers
  /// of a pixel depend on its sample index, which is computed from frame_index, spp and cycle:
  /// change the seed if spp or cycle change within a sequence, or the same samples may recur.
  /// \return kInvalidArgument naming the setting that is out of range; no setting changes then
  virtual Status SetSettings(const RenderSettings& settings) = 0;
  virtual const RenderSettings& settings() const = 0;

  /// Renders one frame: signals, guides, emission, background. `frame` may hold any earlier frame,
  /// whose memory is reused. With `cycle`, only the pixels set before are cleared in a reused
  /// frame: do not write to its planes. Images on the device are reused if there is no other
  /// reference to them.
  /// \return kInvalidArgument: `frame` is null, or the moment is out of range; kOutOfMemory;
  ///     kCancelled; errors of the device
  Status RenderFrame(const RenderMoment& moment, Frame* frame, const RenderProgress& progress = {});

  /// Renders the reference image of the same moment by accumulating `spp` paths per pixel, with
  /// random numbers independent of RenderFrame's; converges to the expected value of
  /// SumOfLight(frame). With `jitter`, samples are spread evenly over the pixel (box filter); else
  /// all pass through its centre. Uses SamplerKind::kSobol, whatever `sampler` is.
  /// \return as RenderFrame; also kInvalidArgument if `spp` is below 1
  Status RenderReference(const RenderMoment& moment, int spp, Image3* radiance,
                         const RenderProgress& progress = {});

  /// Times of the last RenderFrame or RenderReference, summed over threads where work was shared.
  virtual const RenderTimings& timings() const = 0;
  /// Bytes of the scene's acceleration structure and tables.
  virtual size_t memory_bytes() const = 0;

 private:
  /// The implementations of RenderFrame and RenderReference, with valid arguments. They may throw
  /// std::bad_alloc.
  virtual Status TraceFrame(const RenderMoment& moment, Frame* frame,
                            const RenderProgress& progress) = 0;
  virtual Status TraceReference(const RenderMoment& moment, int spp, Image3* radiance,
                                const RenderProgress& progress) = 0;
};

}  // namespace stillray

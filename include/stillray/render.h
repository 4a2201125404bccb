// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer: a scene and a moment in, one noisy Frame with its guides out.
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
};

/// Where guides, emission and background are known in frames of less than one path per pixel.
enum class GuideCoverage : uint8_t {
  kFull,    ///< everywhere: every frame follows the primary rays of all pixels
  kSparse,  ///< where the frame traced a path; elsewhere they are all 0, depth too
};

/// Frames that a sample may take at most to reach every pixel.
inline constexpr int kMaxCycle = 256;
inline constexpr int kMaxSpp = 65536;
inline constexpr int kMaxSide = 32768;

/// Size of the frames, and everything that RenderParameters() lists with range, unit and help. The
/// initialisers are the defaults.
struct RenderSettings {
  int width = 1280;  ///< pixels, 1..kMaxSide
  int height = 720;  ///< pixels, 1..kMaxSide
  int spp = 1;       ///< paths per pixel and frame, 1..kMaxSpp
  /// Frames per path: each frame traces 1 / cycle of the pixels, well spread, and frames
  /// k * cycle ... k * cycle + cycle - 1 trace every pixel once. 1..kMaxCycle; above 1 only with
  /// spp 1. Frame::samples is then 1 where a path was traced and 0, like all signals, elsewhere.
  int cycle = 1;
  GuideCoverage guides = GuideCoverage::kFull;  ///< only matters where cycle is above 1
  int bounces = 4;  ///< surfaces a path may scatter at after the first one, 1..32 (1: as in SVGF)
  uint64_t seed = 0;
  SamplerKind sampler = SamplerKind::kSobol;
  /// All rays of a frame pass through one point of their pixels that moves from frame to frame
  /// (Halton 2,3, period 16), so that antialiasing can resolve edges. Off: always the centre.
  bool jitter = true;
  /// Path-space regularisation (SVGF, section 3): surfaces that a path meets after a rough one are
  /// treated as rougher than they are. Fewer fireflies, dimmer caustics.
  bool regularise = false;
  /// A renderer on a device leaves its frames there (Frame::on_device) as long as there is memory
  /// for them: for a denoiser on the same device. Frames are on the host without, and from
  /// renderers on the CPU.
  bool on_device = false;
};

/// The table of the settings of paths and samples, in the order of docs/render_settings.md, which
/// is made from it. All members of RenderSettings but width, height and on_device; "spp" stands for
/// spp and cycle.
std::span<const Parameter> RenderParameters();

/// Sets one row of the table from text: numbers in decimal, flags on/off/true/false/1/0, choices by
/// name, "spp" as "4", "1/8" or "0.125".
/// \return kInvalidArgument naming the setting, the value and what is allowed; `settings` is then
///         unchanged
Status SetRenderParameter(RenderSettings* settings, std::string_view name, std::string_view value);

/// The value as text that SetRenderParameter reads back.
/// \return kInvalidArgument for an unknown name
Result<std::string> GetRenderParameter(const RenderSettings& settings, std::string_view name);

/// \return kInvalidArgument naming the first setting that is out of range
Status ValidateRenderSettings(const RenderSettings& settings);

/// Whether light has the same expected value with both settings, so that frames of one may go on
/// with the history of the other. Sampling may differ, `bounces` and `regularise` may not.
bool SameLight(const RenderSettings& a, const RenderSettings& b);

/// Signals of a rendered frame: direct and indirect, diffuse and specular, in that order of
/// SignalKind.
inline constexpr int kTracedSignalCount = 4;

/// A camera that stands anywhere.
struct CameraPose {
  /// Camera to world: looks along -z, y is up (as cameras of glTF do). Scale does not matter.
  mat4 world_from_camera = mat4(1.0f);
  float yfov = 0.8f;  ///< vertical angle of view, radians; above 0, below pi
};

/// What is to be seen: two moments of the scene's animation.
struct RenderMoment {
  int64_t frame_index = 0;      ///< picks the random numbers (and the jitter) of this frame
  double seconds = 0;           ///< of this frame
  double previous_seconds = 0;  ///< of the frame before, to which motion vectors point
  int camera = 0;               ///< index into Scene::cameras
  /// Takes the place of the scene's camera.
  std::optional<CameraPose> pose;
  /// Of the frame before, to which motion vectors point; only with `pose`. Without: the camera
  /// stands still.
  std::optional<CameraPose> previous_pose;
};

struct RenderTimings {
  double update_ms = 0;  ///< transforms, light tables, top level of the BVH
  double clear_ms = 0;   ///< with `cycle`: choosing pixels, and zero where no path is traced
  double primary_ms = 0;
  double bounce_ms = 0;
  double shadow_ms = 0;
  double shade_ms = 0;
  double copy_ms = 0;  ///< of renderers on a device: its results into the frame
  uint64_t primary_rays = 0;
  uint64_t bounce_rays = 0;
  uint64_t shadow_rays = 0;
  /// Contributions that were not finite or negative, and left out. Anything but 0 is a defect of
  /// the scene (NaN in its data) or of stillray.
  uint64_t dropped = 0;
};

/// Progress of a long call in 0..1; return false to cancel. Called from one thread at a time.
using RenderProgress = std::function<bool(double fraction)>;

/// Holds a scene ready to be traced. Not thread-safe; its calls use all threads of the pool. The
/// same scene, settings and moment give the same bits, whatever the number of threads.
class Renderer {
 public:
  /// Builds the BVH and the light tables. `scene` must outlive the renderer and stay as it is.
  /// \param keep_going  called now and then, from any thread; return false to cancel
  /// \return kInvalidArgument naming the setting that is out of range, or the element of the scene
  ///         that contradicts itself; kUnsupported if the ray tracer cannot run; kOutOfMemory;
  ///         kCancelled
  static Result<std::unique_ptr<Renderer>> Create(const Scene& scene,
                                                  const RenderSettings& settings,
                                                  const KeepGoing& keep_going = {});
  virtual ~Renderer() = default;

  /// Other settings from the next frame on; the scene need not be prepared again. The random
  /// numbers of a pixel follow the number of its sample, which is counted from frame_index, spp and
  /// cycle: where spp or cycle change in the middle of a sequence, change the seed as well, or the
  /// same samples may come again.
  /// \return kInvalidArgument naming the setting that is out of range; all stay as they were
  virtual Status SetSettings(const RenderSettings& settings) = 0;
  virtual const RenderSettings& settings() const = 0;

  /// Renders one frame: signals, guides, emission, background. `frame` may be any. With
  /// `cycle`, one that comes back is only cleared where it was set: do not write to its planes.
  /// Images on the device are used again if nobody else holds them.
  virtual Status RenderFrame(const RenderMoment& moment, Frame* frame,
                             const RenderProgress& progress = {}) = 0;

  /// Renders the converged picture of the same moment by plain accumulation of `spp` paths per
  /// pixel with random numbers independent of RenderFrame's: what a frame's light adds up to in the
  /// limit. With `jitter`, samples spread evenly over the pixel (box filter); else all go through
  /// its centre. Draws from SamplerKind::kSobol, whatever `sampler` is.
  virtual Status RenderReference(const RenderMoment& moment, int spp, Image3* radiance,
                                 const RenderProgress& progress = {}) = 0;

  /// Of the last RenderFrame or RenderReference, summed over threads where work was shared.
  virtual const RenderTimings& timings() const = 0;
  /// Bytes held by the scene's acceleration structure and tables.
  virtual size_t memory_bytes() const = 0;
};

}  // namespace stillray

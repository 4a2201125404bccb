// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer: a scene and a moment in, one noisy Frame with its guides out.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "stillray/frame.h"
#include "stillray/scene.h"
#include "stillray/status.h"

namespace stillray {

enum class SamplerKind : uint8_t {
  kSobol,     ///< Owen-scrambled Sobol', decorrelated per pixel and frame
  kHalton16,  ///< the 16 Halton points that SVGF (section 3) cycles through, rotated per pixel
};

struct RenderSettings {
  int width = 1280;  ///< pixels, 1..32768
  int height = 720;  ///< pixels, 1..32768
  int spp = 1;       ///< paths per pixel and frame, 1..65536
  int bounces = 4;   ///< surfaces a path may scatter at after the first one, 1..32 (1: as in SVGF)
  uint64_t seed = 0;
  SamplerKind sampler = SamplerKind::kSobol;
  /// All rays of a frame pass through one point of their pixels that moves from frame to frame
  /// (Halton 2,3, period 16), so that antialiasing can resolve edges. Off: always the centre.
  bool jitter = true;
  /// Path-space regularisation (SVGF, section 3): surfaces that a path meets after a rough one are
  /// treated as rougher than they are. Fewer fireflies, dimmer caustics.
  bool regularise = false;
};

/// Signals of a rendered frame: direct and indirect, diffuse and specular, in that order of
/// SignalKind.
inline constexpr int kTracedSignalCount = 4;

/// What is to be seen: two moments of the scene's animation.
struct RenderMoment {
  int64_t frame_index = 0;      ///< picks the random numbers (and the jitter) of this frame
  double seconds = 0;           ///< of this frame
  double previous_seconds = 0;  ///< of the frame before, to which motion vectors point
  int camera = 0;               ///< index into Scene::cameras
};

struct RenderTimings {
  double update_ms = 0;  ///< transforms, light tables, top level of the BVH
  double primary_ms = 0;
  double bounce_ms = 0;
  double shadow_ms = 0;
  double shade_ms = 0;
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
  /// \return kInvalidArgument naming the setting that is out of range, or the element of the scene
  ///         that contradicts itself; kUnsupported if the ray tracer cannot run; kOutOfMemory
  static Result<std::unique_ptr<Renderer>> Create(const Scene& scene,
                                                  const RenderSettings& settings);
  virtual ~Renderer() = default;

  /// Renders one frame: signals, guides, emission, background.
  virtual Status RenderFrame(const RenderMoment& moment, Frame* frame,
                             const RenderProgress& progress = {}) = 0;

  /// Renders the converged picture of the same moment by plain accumulation of `spp` paths per
  /// pixel with random numbers independent of RenderFrame's: what a frame's light adds up to in the
  /// limit. With `jitter`, samples spread evenly over the pixel (box filter); else all go through
  /// its centre.
  virtual Status RenderReference(const RenderMoment& moment, int spp, Image3* radiance,
                                 const RenderProgress& progress = {}) = 0;

  /// Of the last RenderFrame or RenderReference, summed over threads where work was shared.
  virtual const RenderTimings& timings() const = 0;
  /// Bytes held by the scene's acceleration structure and tables.
  virtual size_t memory_bytes() const = 0;
};

}  // namespace stillray

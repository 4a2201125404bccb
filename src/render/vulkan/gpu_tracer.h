// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Wavefront path tracing of batches of pixels in compute shaders, with guides; GpuAccel may trace
/// the rays by ray tracing pipelines. The counterpart of TraceSample on the CPU, with equal steps,
/// random numbers and lights.
///
/// All paths of a batch advance step by step, with separate dispatches for shading, shadow rays and
/// next hits. Rays are traced by dedicated shaders that evaluate only the opacity of materials, so
/// that compute shaders and ray tracing pipelines are interchangeable; surviving paths are
/// compacted between the steps.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "gpu/timestamps.h"
#include "render/virtual_image.h"
#include "render/vulkan/gpu_accel.h"
#include "render/vulkan/gpu_lights.h"
#include "render/vulkan/trace_shared.h"
#include "render/vulkan/visibility.h"

namespace stillray::render {

/// Names of timed parts of the device time.
inline constexpr const char* kTimeRaster = "trace: rasterised hits";
inline constexpr const char* kTimeGuides = "trace: guides";
inline constexpr const char* kTimeImages = "trace: virtual guides";
inline constexpr const char* kTimeShade = "trace: shading";
inline constexpr const char* kTimeShadows = "trace: shadow rays";
inline constexpr const char* kTimeBounces = "trace: bounce rays";
inline constexpr const char* kTimeStore = "trace: storing";

/// Optional outputs and features of frames beside radiance and surface guides.
struct TracerParts {
  bool lens = false;       ///< a lens, with guides per sample
  bool images = false;     ///< virtual guides
  bool separates = false;  ///< transmitted light is separate, and has virtual guides
  bool to_host = false;    ///< results are copied to the host

  friend bool operator==(const TracerParts&, const TracerParts&) = default;
  bool Include(const TracerParts& others) const {
    return (lens || !others.lens) && (images || !others.images) &&
           (separates || !others.separates) && (to_host || !others.to_host);
  }
};

/// Not thread-safe.
class GpuTracer {
 public:
  /// \param device, accel, lights, visibility  must outlive this; without `visibility` (nullptr)
  ///     all primary rays are traced
  /// \param parts        features for which memory is allocated
  /// \param most_pixels  maximum pixels of a batch; reduced by the device's limits on storage
  ///     buffers and dispatches
  static Result<std::unique_ptr<GpuTracer>> Create(gpu::Device* device, const GpuAccel* accel,
                                                   const GpuLights* lights,
                                                   const Visibility* visibility,
                                                   uint32_t most_pixels, const TracerParts& parts);

  /// Bytes of device memory per pixel of a batch.
  static size_t BytesPerPixel(const TracerParts& parts);
  /// Maximum number of pixels of a batch, a multiple of kGroupSize.
  uint32_t capacity() const { return capacity_; }
  const TracerParts& parts() const { return parts_; }
  /// Mapped array of capacity() pixel positions for a `listed` batch: x in the lower 16 bits, y in
  /// the upper.
  uint32_t* listed_pixels() { return static_cast<uint32_t*>(listed_->mapped); }

  /// Begins a submission with the state common to its batches. Earlier commands must have finished.
  /// RecordNextBatch is called between two batches.
  /// \param resumes  the first batch continues the unfinished paths of the last submission
  void RecordBegin(VkCommandBuffer commands, const GpuFrame& frame, bool resumes,
                   gpu::Timestamps* times);
  /// Separates two batches: later commands overwrite the buffers of the previous batch, whose
  /// results must have been stored.
  void RecordNextBatch(VkCommandBuffer commands) const { Wait(commands); }
  /// Rasterises the visible triangles, for frames with GpuFrame::rasterised.
  void RecordVisibility(VkCommandBuffer commands, const GpuFrame& frame);
  /// Computes the guides of the batch and the first hits of its paths; with a lens, for the batch's
  /// sample.
  Status RecordGuides(VkCommandBuffer commands, const GpuBatch& batch);
  /// Computes the virtual guides of the batch, after its guides. Only if parts() include images,
  /// and without a lens.
  Status RecordImages(VkCommandBuffer commands, const GpuBatch& batch);
  /// Options of RecordSample.
  struct SampleOptions {
    /// Number of steps to record, at least 1. If a path needs more, counters().left is above 0:
    /// later commands of the submission have had no effect, and the next submission resumes these
    /// paths.
    int steps = 0;
    int most_steps = 0;  ///< maximum number of steps of a path (MostSteps)
    /// 0: the sample starts; otherwise it resumes paths after this many steps.
    int resumed_steps = 0;
    int resumed_part = 0;    ///< part of the sample to resume; earlier parts are finished
    bool first = false;      ///< starts new sums with this sample
    bool single = false;     ///< the only sample, without a lens: it is not added to sums
    bool reference = false;  ///< needs no guides
    bool separates = false;  ///< GpuFrame::signal_count is kAllSignals
  };
  /// Traces one sample of the batch, whose guides have been computed.
  Status RecordSample(VkCommandBuffer commands, const GpuBatch& batch,
                      const SampleOptions& options);
  /// Begins a timed part of the submission.
  void Mark(VkCommandBuffer commands, const char* name);
  /// Results of a batch.
  struct Results {
    bool guides = false;
    ImageKinds images;
    bool sums = false;
    bool single = false;  ///< sums are the radiance of a single sample (SampleOptions::single)
    uint32_t signals = kSurfaceSignals;  ///< GpuFrame::signal_count
  };
  /// Ends the submission: copies its counters and, with TracerParts::to_host, the results of the
  /// last batch to the host.
  void RecordEnd(VkCommandBuffer commands, const GpuBatch& batch, const Results& copied);

  /// Results of the last submission, valid after it has finished and Invalidate was called.
  Status Invalidate() const { return arena_.Invalidate(); }
  const GpuGuides* guides() const { return static_cast<const GpuGuides*>(host_guides_->mapped); }
  const GpuImage* reflections() const { return static_cast<const GpuImage*>(host_images_->mapped); }
  const GpuImage* refractions() const { return reflections() + capacity_; }
  const GpuSignal* sums() const { return static_cast<const GpuSignal*>(host_sums_->mapped); }
  const GpuCounters& counters() const {
    return *static_cast<const GpuCounters*>(host_counters_->mapped);
  }
  /// Makes listed_pixels() visible to the device.
  Status Flush() const { return arena_.Flush(); }

  gpu::MemoryUse memory() const { return arena_.Need(); }
  /// Device buffers of the current batch, in the order of its pixels, for shaders that process the
  /// results.
  const gpu::Buffer& device_guides() const { return *buffers_[kGuides]; }
  const gpu::Buffer& device_images() const { return *buffers_[kImages]; }
  const gpu::Buffer& device_sums(const Results& of) const {
    return *buffers_[of.single ? kLightOfSamples : kSums];
  }
  const gpu::Buffer& device_listed() const { return *listed_; }

  static constexpr gpu::SetShape kShape = {0, 0, 1, 15};

 private:
  /// Bindings of trace.glsl.
  enum Binding : size_t {
    kFrame,
    kPaths,
    kRays,
    kHits,
    kShadows,
    kLists,
    kQueues,
    kGuides,
    kFirstHits,
    kLightOfSamples,
    kSums,
    kListed,
    kVisible,
    kLensSums,
    kImages,
    kPathParts,
    kBindingCount
  };
  enum Shader : size_t {
    kFindGuides,
    kFindImages,
    kStartPaths,
    kStartReference,
    kShade,
    kTraceShadows,
    kTraceNext,
    kCrossMedia,
    kAdvance,
    kAddSamples,
    kAddReference,
    kShaderCount
  };

  GpuTracer(gpu::Device* device, const GpuAccel* accel, const GpuLights* lights,
            const Visibility* visibility)
      : device_(device),
        accel_(accel),
        lights_(lights),
        visibility_(visibility),
        arena_(&device->context()),
        sets_(&device->context()) {}
  Status CheckLimits() const;
  /// Bytes of the per-pixel record in every buffer; 0 for buffers without per-pixel records.
  static std::array<size_t, kBindingCount> RecordBytes(const TracerParts& parts);
  uint32_t MostPixels() const;
  Status AddBuffers();
  Result<std::vector<VkDescriptorSetLayout>> Layouts();
  Status MakeHardwarePipelines();
  void BindHardware(VkCommandBuffer commands, Shader shader, const GpuBatch& batch) const;
  Status RecordStart(VkCommandBuffer commands, GpuBatch batch, bool reference);
  Status RecordPart(VkCommandBuffer commands, GpuBatch batch, const SampleOptions& options,
                    int first_step);
  Status RecordResumption(VkCommandBuffer commands, GpuBatch batch, int steps);
  Status RecordNextHits(VkCommandBuffer commands, const GpuBatch& batch);
  Status Bind(VkCommandBuffer commands, Shader shader, const GpuBatch& batch);
  Status Dispatch(VkCommandBuffer commands, Shader shader, const GpuBatch& batch);
  Status DispatchQueue(VkCommandBuffer commands, Shader shader, const GpuBatch& batch,
                       uint32_t queue);
  void Wait(VkCommandBuffer commands) const;

  gpu::Device* device_;
  const GpuAccel* accel_;
  const GpuLights* lights_;
  const Visibility* visibility_;
  uint32_t capacity_ = 0;
  std::array<uint32_t, 2> constants_{};  // GpuAccel::constants
  TracerParts parts_;
  gpu::Arena arena_;
  gpu::DescriptorSets sets_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  std::array<std::optional<gpu::Pipeline>, kShaderCount> pipelines_;  // created when first used
  // Null if traced in compute shaders.
  std::array<std::unique_ptr<gpu::RayPipeline>, kShaderCount> by_hardware_;
  std::array<const gpu::Buffer*, kBindingCount> buffers_{};
  const gpu::Buffer* listed_ = nullptr;
  const gpu::Buffer* host_guides_ = nullptr;
  const gpu::Buffer* host_images_ = nullptr;
  const gpu::Buffer* host_sums_ = nullptr;
  const gpu::Buffer* host_counters_ = nullptr;
  gpu::Timestamps* times_ = nullptr;  // timestamps of the submission being recorded
};

/// Maximum number of surfaces on a path: the first, the last, `bounces` between them, and the free
/// events if any surface is transparent or refracts.
int MostSteps(const Scene& scene, int bounces);

}  // namespace stillray::render

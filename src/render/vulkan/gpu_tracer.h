// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Guides and paths of batches of pixels in compute shaders, except for rays that GpuAccel traces
/// in hardware: the counterpart of TraceSample on the CPU, with the same steps, random numbers and
/// lights.
///
/// A batch advances in common steps, each in separate dispatches: shading, shadow rays, next hits.
/// Rays are traced by shaders that do nothing else and evaluate only the opacity of materials, so
/// that both ways of tracing are interchangeable; surviving paths are compacted between the steps.
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

/// Names of parts of the device time.
inline constexpr const char* kTimeRaster = "trace: rasterised hits";
inline constexpr const char* kTimeGuides = "trace: guides";
inline constexpr const char* kTimeImages = "trace: virtual guides";
inline constexpr const char* kTimeShade = "trace: shading";
inline constexpr const char* kTimeShadows = "trace: shadow rays";
inline constexpr const char* kTimeBounces = "trace: bounce rays";
inline constexpr const char* kTimeStore = "trace: storing";

/// What frames may have beside the light and the guides of their surfaces.
struct TracerParts {
  bool lens = false;       ///< a lens, whose samples have guides of their own
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
  ///     all camera rays are traced
  /// \param parts        that there is memory for
  /// \param most_pixels  of a batch; fewer if the device's storage buffers or dispatches are small
  static Result<std::unique_ptr<GpuTracer>> Create(gpu::Device* device, const GpuAccel* accel,
                                                   const GpuLights* lights,
                                                   const Visibility* visibility,
                                                   uint32_t most_pixels, const TracerParts& parts);

  /// Bytes of the device's memory for each pixel of a batch.
  static size_t BytesPerPixel(const TracerParts& parts);
  /// Pixels of a batch, a multiple of kGroupSize.
  uint32_t capacity() const { return capacity_; }
  const TracerParts& parts() const { return parts_; }
  /// Mapped positions of the pixels of a batch that is `listed`: x in the lower half, y in the
  /// upper. Of size capacity().
  uint32_t* listed_pixels() { return static_cast<uint32_t*>(listed_->mapped); }

  /// Begins a submission with the state common to its batches. Earlier commands must have finished.
  /// RecordNextBatch is called between two batches.
  /// \param resumes  the first batch is that whose paths the last submission has left
  void RecordBegin(VkCommandBuffer commands, const GpuFrame& frame, bool resumes,
                   gpu::Timestamps* times);
  /// What follows overwrites the buffers of the batch before, whose results have been stored.
  void RecordNextBatch(VkCommandBuffer commands) const { Wait(commands); }
  /// Rasterises the visible triangles, for the batches of a frame with `rasterised`.
  void RecordVisibility(VkCommandBuffer commands, const GpuFrame& frame);
  /// Guides of the batch, and the starting points of its paths; with a lens those of the batch's
  /// sample.
  Status RecordGuides(VkCommandBuffer commands, const GpuBatch& batch);
  /// Virtual guides of the batch, after its guides. Only if parts() have them, and without a lens.
  Status RecordImages(VkCommandBuffer commands, const GpuBatch& batch);
  /// How RecordSample traces.
  struct SampleOptions {
    /// Number to record, at least 1. If a path has more, counters().left is above 0: then nothing
    /// later in the submission was done, and the next one resumes these paths.
    int steps = 0;
    int most_steps = 0;      ///< that a path may have (MostSteps)
    int resumed_steps = 0;   ///< 0: the sample begins; else paths are left after so many
    int resumed_part = 0;    ///< of the sample; those before are finished
    bool first = false;      ///< starts new sums with this sample
    bool single = false;     ///< the only one, without a lens: it is not added to sums
    bool reference = false;  ///< needs no guides
    bool separates = false;  ///< GpuFrame::signal_count is kAllSignals
  };
  /// One sample of the batch, whose guides are known.
  Status RecordSample(VkCommandBuffer commands, const GpuBatch& batch,
                      const SampleOptions& options);
  /// Begins a timed part of the submission.
  void Mark(VkCommandBuffer commands, const char* name);
  /// Results of a batch.
  struct Results {
    bool guides = false;
    ImageKinds images;
    bool sums = false;
    bool single = false;  ///< the sums are the light of a sample that was not added (SampleOptions)
    uint32_t signals = kSurfaceSignals;  ///< GpuFrame::signal_count
  };
  /// Copies results of the last batch (only if parts() have them on the host) and the counters of
  /// the submission to the host; ends it.
  void RecordEnd(VkCommandBuffer commands, const GpuBatch& batch, const Results& copied);

  /// Of the last submission, after it has finished and Invalidate was called.
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
  /// Buffers of the current batch, in the order of its pixels, for shaders that process the
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
  /// Bytes of each pixel's record in every buffer; 0 for those of another size.
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
  std::array<uint32_t, 2> constants_{};  // of GpuAccel
  TracerParts parts_;
  gpu::Arena arena_;
  gpu::DescriptorSets sets_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  std::array<std::optional<gpu::Pipeline>, kShaderCount> pipelines_;  // created when first used
  std::array<std::unique_ptr<gpu::RayPipeline>, kShaderCount> by_hardware_;  // or null
  std::array<const gpu::Buffer*, kBindingCount> buffers_{};
  const gpu::Buffer* listed_ = nullptr;
  const gpu::Buffer* host_guides_ = nullptr;
  const gpu::Buffer* host_images_ = nullptr;
  const gpu::Buffer* host_sums_ = nullptr;
  const gpu::Buffer* host_counters_ = nullptr;
  gpu::Timestamps* times_ = nullptr;  // of the submission being recorded
};

/// Maximum number of surfaces on a path: `bounces` beside the first and the last one, and the free
/// events if any surface is transparent or refracts.
int MostSteps(const Scene& scene, int bounces);

}  // namespace stillray::render

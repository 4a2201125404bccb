// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The denoiser on Vulkan: records the stages, in order, into a command buffer, and owns their
/// history. It uses no queue and no host memory.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "denoise/vulkan/fill_guides/fill_guides.h"
#include "denoise/vulkan/parameters.h"
#include "denoise/vulkan/pass_recorder.h"

namespace stillray::vulkan {

/// Receives intermediate images while a frame is recorded.
class FrameObserver {
 public:
  virtual ~FrameObserver() = default;
  /// \param name  "noisy", "fetched", "compared", "joined" (moments before the future is merged),
  ///     "accumulated", "moments", "variance", "weightsN", "wavelet", "filtered", "aliased";
  ///     "temporal" and "atrousN" are composed images
  virtual bool Wants(std::string_view name) const = 0;
  /// Called between barriers; may copy from the image.
  virtual void Keep(VkCommandBuffer commands, std::string_view name, const gpu::Image& image) = 0;
};

/// Largest number of residue classes (modulo the step) that share a workgroup of the wavelet's
/// tiles: see atrous.comp.
inline constexpr int kMostTileResidues = 2;

/// Push constants of a wavelet level.
struct LevelPush {
  int32_t step = 1;
  int32_t level = 0;
  int32_t box = 0;
  int32_t pilot_signals = 0;
};

struct PipelineOptions {
  Settings settings;
  int width = 0;
  int height = 0;
  bool transmission = false;  ///< frames have transmission signals
  Storage storage = Storage::kHalf;
  bool timed = true;          ///< the queue supports timestamps, and they are requested
  bool fills_guides = false;  ///< frames may have unknown guides, for any set of images
  /// Largest number of unfinished frames on the device, if input images are used for one frame
  /// only; 0: input images recur.
  uint32_t in_flight = 0;
};

class FramePipeline {
 public:
  /// Creates all images, pipelines and descriptor pools.
  static Result<std::unique_ptr<FramePipeline>> Create(const gpu::DeviceContext* context,
                                                       const PipelineOptions& options);
  /// The memory that Create allocates.
  static Result<gpu::MemoryUse> Need(const gpu::DeviceContext* context,
                                     const PipelineOptions& options);

  /// Allocates memory for a frame with unknown guides, if necessary. The device must have finished
  /// all recorded commands.
  Status PrepareFilling(const FrameFacts& facts);

  /// Adds the commands of one frame, which may have unknown guides only after PrepareFilling, or
  /// with `fills_guides`. Allocates nothing once inputs and history recur. After an error, or if
  /// the commands are not executed, the caller must clear the list and return to the checkpoint
  /// from before the call.
  /// \param plan      from MakePlan with progress()
  /// \param observer  may be nullptr
  /// \param future    history of the later frames, if the plan runs merge_future: part of the
  ///     wavelet's input, but not of the history
  Status Record(gpu::CommandList* commands, const FramePlan& plan, const FrameFacts& facts,
                const FrameInputs& inputs, FrameObserver* observer,
                const FutureImages* future = nullptr);
  /// Adds the commands of a frame of a sequence that is processed backward: its radiance is
  /// accumulated, and no image is made. Compiles a shader on the first call.
  /// \param future  receives the history of the later frames; unchanged without history
  Status RecordBackward(gpu::CommandList* commands, const FramePlan& plan, const FrameFacts& facts,
                        const FrameInputs& inputs, const FutureImages& future);

  struct Size {
    int width = 0;
    int height = 0;
  };
  /// All state that recording a frame changes.
  struct Checkpoint {
    FrameImages images;
    SequenceProgress progress;
    FillGuidesPass::Progress filling;
    Size size;
    std::optional<Size> resized_from;
    uint32_t frames = 0;
  };
  Checkpoint checkpoint() const;
  void GoBackTo(const Checkpoint& checkpoint);

  /// Sets the size of the next frames, at most that of the images; the history is resampled. Must
  /// be called before the plan of the next frame is made.
  void Resize(int width, int height);
  /// Whether frames with these settings and size use the existing images.
  bool Fits(const Settings& settings, int width, int height, bool transmission) const;
  /// Sets the settings from the next frame on, for which Fits must be true. Creates missing
  /// pipelines.
  Status SetSettings(const Settings& settings);
  /// Discards all history.
  void Reset();
  /// Must be called before input images are destroyed, once the device no longer uses them.
  Status ForgetInputs() { return sets_.Clear(); }

  gpu::MemoryUse memory() const;
  /// Least number of bytes that the passes of the last frame transfer: see PassRecorder::bytes.
  uint64_t pass_bytes() const { return pass_bytes_; }
  /// Sets whether the next frames measure the times of their stages, if the pipeline is `timed`.
  /// Measuring may serialise the stages on the device.
  void MeasureStages(bool measures) { measures_ = measures; }
  /// Times of the newest finished frame that measured them.
  std::vector<gpu::DeviceTime> times() const { return times_.Read(); }
  const FrameImages& images() const { return images_; }
  std::span<const SignalGroup> groups() const { return groups_; }
  const Shape& shape() const { return shape_; }
  /// The size of the images: the largest frame size.
  Size most() const { return of_images_; }
  /// nullptr if no frame had unknown guides.
  const FillGuidesPass* fill_guides() const { return fill_guides_.get(); }
  FillGuidesPass* fill_guides() { return fill_guides_.get(); }
  const SequenceProgress& progress() const { return progress_; }
  /// Continues from a restored history, already written to the images: see saved_history.h.
  void GoOnFrom(const SequenceProgress& progress) { progress_ = progress; }
  /// Transitions all images to their layout, once, and clears the state.
  void PrepareImages(VkCommandBuffer commands);
  bool has_transmission() const { return transmission_; }
  bool by_channel() const { return groups_.front().channel >= 0; }

 private:
  explicit FramePipeline(const gpu::DeviceContext* context);
  /// nullptr if the frame measures no times.
  gpu::Timestamps* Times() { return timed_ && measures_ ? &times_ : nullptr; }
  static FillGuidesPass::Options FillGuidesOptions(const PipelineOptions& options);
  Status MakePipelines(const Settings& settings);
  Status MakeFillGuidesPass(const FillGuidesPass::Options& options);
  PassRecorder BeginPasses(gpu::CommandList* commands);
  void EndPasses(const FramePlan& plan, PassRecorder* recorder);
  void UploadParameters(PassRecorder* recorder, const FrameParameters& parameters);
  void UseInputs(const FramePlan& plan, const FrameFacts& facts, const FrameInputs& inputs,
                 FrameParameters* parameters, PassRecorder* recorder);
  void BeginFrame(const FramePlan& plan, const FrameFacts& facts, const FrameInputs& inputs,
                  PassRecorder* recorder);
  void ResampleHistory(Size before, PassRecorder* recorder);
  void StoreSignals(const FrameInputs& inputs, PassRecorder* recorder);
  void UseSize(Size size);
  void GatherLight(const FramePlan& plan, PassRecorder* recorder);
  void Reproject(PassRecorder* recorder);
  bool JoinsAccumulation(const FramePlan& plan) const;
  void ReprojectAndAccumulate(PassRecorder* recorder);
  void FetchHistory(const FramePlan& plan, PassRecorder* recorder);
  void LimitHistory(const FramePlan& plan, PassRecorder* recorder);
  void Accumulate(const FramePlan& plan, PassRecorder* recorder);
  void MergeFuture(const FutureImages& future, PassRecorder* recorder);
  void BeginFilter(const FramePlan& plan, PassRecorder* recorder);
  const gpu::Image* RunPilot(int level, int signals, PassRecorder* recorder);
  void RunLevels(const FramePlan& plan, PassRecorder* recorder);
  void KeepSamples(PassRecorder* recorder);
  void KeepMirrors(PassRecorder* recorder);
  const gpu::Image* SampleSquares() const;
  void BlendSamples(const char* stage, PassRecorder* recorder);
  void Compose(const gpu::Image* light, PassRecorder* recorder);
  void FollowLight(const FramePlan& plan, PassRecorder* recorder);
  void Finish(const FramePlan& plan, PassRecorder* recorder);
  void Keep(PassRecorder* recorder, std::string_view name, const gpu::Image* image);
  void KeepPicture(PassRecorder* recorder, std::string_view name, const gpu::Image* light);
  /// \param pilot_signals  FramePlan::pilot_signals
  /// \param compared   whether it is a level of limit_history
  /// \param output  kAtrousLight, kAtrousSums or kAtrousPilot
  std::array<uint32_t, 7> AtrousConstants(const AtrousLevel& level, int pilot_signals = 0,
                                          bool compared = false, int output = kAtrousLight) const;
  Groups CoarseGrid() const;
  /// One level of the wavelet, by the variant that suits the device.
  /// \param width, height  of the images
  void RunAtrous(int width, int height, std::initializer_list<const gpu::Image*> images,
                 const LevelPush& push, std::span<const uint32_t> constants,
                 PassRecorder* recorder);
  Status MakeAtrousPipelines(const Settings& settings);
  Status MakeAtrous(std::span<const uint32_t> constants);
  void RunComparedLevels(const char* stage, int levels, PassRecorder* recorder);
  void RunWideLevel(PassRecorder* recorder);
  void BeginEnergy(PassRecorder* recorder);
  void RestoreEnergy(const gpu::Image* out, PassRecorder* recorder);

  const gpu::DeviceContext* context_;
  bool timed_ = true;
  bool measures_ = true;
  uint32_t edge_kinds_ = 0;  ///< STILLRAY_ATROUS_... of the settings
  Shape shape_;              ///< of the frames; the size may be smaller than that of the images
  Size of_images_;           ///< the largest frames
  std::optional<Size> resized_from_;  ///< the size of the history, until it is resampled
  std::span<const SignalGroup> groups_;
  bool transmission_ = false;
  Groups grid_;
  bool uses_tiles_ = false;  // the wavelet runs by tiles: see atrous.comp
  gpu::Arena arena_;
  gpu::DescriptorSets sets_;
  gpu::Timestamps times_;
  std::unique_ptr<Pipelines> pipelines_;
  FrameImages images_;
  std::unique_ptr<FillGuidesPass> fill_guides_;
  SequenceProgress progress_;
  uint32_t frames_ = 0;  ///< recorded
  uint64_t pass_bytes_ = 0;
  bool prepared_ = false;

  // The frame in progress.
  FrameObserver* observer_ = nullptr;
  HistoryImages known_;  ///< input of the wavelet: the history, possibly merged with the future
  const gpu::Image* light_ = nullptr;  ///< input of the next level; after the last one, the result
  std::array<gpu::Image, kMostGroups> filtered_;  ///< of FrameInputs
};

}  // namespace stillray::vulkan

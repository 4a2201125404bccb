// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// fill_guides on Vulkan: its images and passes. See denoise/fill_guides/fill_guides.h.
#pragma once

#include <array>
#include <memory>

#include "denoise/vulkan/frame_shared.h"
#include "denoise/vulkan/parameters.h"
#include "denoise/vulkan/pass_recorder.h"

namespace stillray::vulkan {

/// Number of colour images that are filled in addition to geometry; bits of
/// FillGuidesPass::ColoursOf.
inline constexpr int kGuideColours = 5;

class FillGuidesPass {
 public:
  struct Options {
    int width = 0;
    int height = 0;
    Storage storage = Storage::kHalf;
    bool has_id = true;
    uint32_t colours = 0;  ///< colours that frames may have
  };

  /// \param pipelines, \param sets  must outlive this object; shaders are compiled here
  static Result<std::unique_ptr<FillGuidesPass>> Create(const gpu::DeviceContext* context,
                                                        Pipelines* pipelines,
                                                        const Options& options);
  static Result<gpu::MemoryUse> Need(const gpu::DeviceContext* context, const Options& options);

  /// Bit 0: albedo, 1: specular albedo, 2: transmission albedo, 3: emission, 4: background.
  static uint32_t ColoursOf(const FrameFacts& facts);
  /// Whether the images suffice for the frame.
  bool Fits(const FrameFacts& facts) const;

  /// Sets the parameters of the shaders. Discards held guides if the frame has a different set of
  /// images.
  void Begin(const FrameFacts& facts, FrameParameters* parameters);
  /// Records the passes; the frame's inputs must be in use.
  /// \return the inputs, with the filled images replacing those of the frame
  FrameInputs Record(PassRecorder* recorder, const FrameInputs& inputs, const gpu::Buffer& state);
  /// Sets the size of the next frames, at most that of the options. Discards held guides if the
  /// size changes.
  void Resize(int width, int height);
  /// Discards held guides.
  void Reset() { progress_.kinds.any = false; }

  /// The images of held() that the next frame reads.
  struct Kinds {
    bool any = false;
    bool id = false;
    uint32_t colours = 0;
  };
  const Kinds& kinds() const { return progress_.kinds; }
  /// Restores held guides whose images the caller has written to held(); they must fit.
  void Restore(const Kinds& kinds) { progress_.kinds = kinds; }
  /// Transitions all images to their layout, and initialises marks, once.
  void PrepareImages(VkCommandBuffer commands);

  gpu::MemoryUse memory() const { return arena_.Need(); }

  /// Images of the last frame, for tests. normal.w: 1 where known, 0 where filled.
  struct Held {
    const gpu::Image* depth = nullptr;
    const gpu::Image* normal = nullptr;
    const gpu::Image* id = nullptr;
    std::array<const gpu::Image*, kGuideColours> colour = {};
  };
  const Held& held() const { return progress_.now; }
  /// State passed from a frame to the next one.
  struct Progress {
    Held now;
    Held before;
    Kinds kinds;
    uint32_t stamp = 0;  ///< of the last frame
  };
  const Progress& progress() const { return progress_; }
  /// Undoes frames that were not recorded.
  void GoBackTo(const Progress& progress) { progress_ = progress; }
  const gpu::Image& motion() const { return *motion_; }

 private:
  explicit FillGuidesPass(const gpu::DeviceContext* context) : context_(context), arena_(context) {}
  Status AddAll(const Options& options);
  void PrepareMemory(PassRecorder* recorder, const gpu::Buffer& state);
  void FillPyramid(PassRecorder* recorder, bool of_motion) const;

  const gpu::DeviceContext* context_;
  gpu::Arena arena_;
  Options options_;
  Progress progress_;
  const gpu::Image* motion_ = nullptr;
  const gpu::Buffer* cells_ = nullptr;
  const gpu::Buffer* rejected_ = nullptr;
  bool prepared_ = false;
};

}  // namespace stillray::vulkan

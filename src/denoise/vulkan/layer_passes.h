// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The passes that split a frame with virtual guides into two parts: a layer of reflected or
/// transmitted light, and the remaining frame ("rest"). A FramePipeline denoises each: the layer
/// first, whose image is added to the emission of the rest. With two layers, the frame of the
/// second one's RecordRest (and FactsOfRest, InputsOfRest) is the rest of the first. See
/// layered_denoiser.h.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/hit_distance_shared.h"
#include "denoise/plan.h"
#include "denoise/vulkan/frame_images.h"
#include "denoise/vulkan/pass_recorder.h"
#include "gpu/pipeline.h"
#include "gpu/timestamps.h"

namespace stillray::vulkan {

/// Virtual guides, on the device: see VirtualGuides.
struct VirtualInputs {
  ImageRef depth;
  ImageRef normal;  ///< none: the normal of the surface
  ImageRef motion;
  ImageRef id;      ///< read if the frame has ids; none: the id of the surface
  ImageRef albedo;  ///< none: white
  /// If given, depth and motion are computed from it, and `depth` and `motion` are not read.
  ImageRef hit_distance = {};
  HitCamera hit_camera = {};
};

struct LayerShape {
  int width = 0;
  int height = 0;
  bool previous_normals = false;
  bool second_moments = false;  ///< of the layer's direct and indirect radiance, if both are given
  bool with_picture = false;    ///< allocate the layer's output image, written by the caller
  bool with_hits = false;       ///< allocate the images for VirtualInputs::hit_distance

  friend bool operator==(const LayerShape&, const LayerShape&) = default;
};

/// The images of both parts that differ from those of the frame.
struct LayerImages {
  explicit LayerImages(const gpu::DeviceContext* context) : arena(context) {}

  gpu::Arena arena;
  bool used = false;  ///< image layouts are set
  // Of the layer:
  const gpu::Image* depth = nullptr;
  const gpu::Image* normal = nullptr;
  const gpu::Image* motion = nullptr;
  const gpu::Image* id = nullptr;
  const gpu::Image* roughness = nullptr;
  const gpu::Image* albedo = nullptr;
  const gpu::Image* previous_normal = nullptr;  ///< LayerShape::previous_normals
  const gpu::Image* direct_moment = nullptr;    ///< LayerShape::second_moments
  const gpu::Image* indirect_moment = nullptr;  ///< LayerShape::second_moments
  const gpu::Image* picture = nullptr;          ///< LayerShape::with_picture
  const gpu::Image* hit_depth = nullptr;        ///< LayerShape::with_hits
  const gpu::Image* hit_motion = nullptr;       ///< LayerShape::with_hits
  // Of the rest:
  const gpu::Image* picture_motion = nullptr;
  const gpu::Image* emission = nullptr;
};

/// A shader of LayerPasses; all its resources are in set 0.
struct LayerShader {
  const char* stage = "";  ///< in timings
  std::span<const uint32_t> code;
  uint32_t reads = 0;
  uint32_t writes = 0;
  uint32_t push_bytes = 0;
};
std::vector<LayerShader> LayerShaders();

class LayerPasses {
 public:
  /// The memory that Prepare allocates. Allocates nothing itself.
  static Result<gpu::MemoryUse> Need(const gpu::DeviceContext* context, const LayerShape& shape);
  /// Compiles the shaders.
  /// \param source       of the layer's guides: kReflection or kRefraction
  /// \param context      must outlive this
  /// \param timed        the queue supports timestamps, and they are requested
  /// \param in_flight    as PipelineOptions::in_flight
  static Result<std::unique_ptr<LayerPasses>> Create(const gpu::DeviceContext* context,
                                                     GuideSource source, bool timed,
                                                     uint32_t in_flight);
  LayerPasses(const LayerPasses&) = delete;
  LayerPasses& operator=(const LayerPasses&) = delete;

  /// Makes images for frames of this shape, if necessary.
  Status Prepare(const LayerShape& shape);
  /// Sets the size of the next frames, at most that of the images.
  void Resize(int width, int height);
  /// Discards the descriptor sets of input images, which the device must no longer use.
  Status ForgetInputs() { return sets_.Clear(); }

  /// Adds the passes that write the layer's guides; errors as in FramePipeline::Record. Required:
  /// depth and motion of `seen`, or its hit distance; the frame's motion, roughness, albedo, and
  /// the layer's divisor albedo.
  Status RecordLayer(gpu::CommandList* commands, const FrameFacts& facts, const FrameInputs& frame,
                     const VirtualInputs& seen, const SelectGuidesParameters& select);
  /// Writes emission and motion of the rest. \param picture  the denoised image of the layer
  Status RecordRest(gpu::CommandList* commands, const FrameFacts& facts, const FrameInputs& frame,
                    const ImageRef& picture);

  /// Facts and inputs of both parts, from those of the frame. Outputs are those of the frame.
  FrameFacts FactsOfLayer(const FrameFacts& frame) const;
  FrameInputs InputsOfLayer(const FrameInputs& frame) const;
  FrameFacts FactsOfRest(const FrameFacts& frame) const;
  FrameInputs InputsOfRest(const FrameFacts& facts, const FrameInputs& frame) const;

  /// Undoes the passes of a frame that was not recorded. \param frames  number of frames recorded
  /// before it
  void GoBackTo(uint32_t frames) { frames_ = frames; }
  uint32_t frames() const { return frames_; }

  /// nullptr before Prepare.
  const std::shared_ptr<LayerImages>& images() const { return images_; }
  gpu::MemoryUse memory() const;
  /// Adds the times of the newest frame that the device has finished.
  void AddTimes(std::vector<StageTime>* times) const;

 private:
  enum Pass : size_t { kSelectGuides, kRescaleMoments, kAddLayer, kPlaceHits, kPassCount };

  LayerPasses(const gpu::DeviceContext* context, GuideSource source, bool timed)
      : context_(context),
        source_(source),
        timed_(timed),
        sets_(context),
        layer_times_(context),
        rest_times_(context) {}

  Status MakePipelines();
  Status PlaceHits(gpu::CommandList* commands, const ImageRef& depth, VirtualInputs* seen);
  bool HasPreviousNormals(const FrameFacts& frame) const;
  bool RescalesMoments(const FrameFacts& frame) const;
  bool SumsImages(const FrameFacts& frame) const;
  Status Run(gpu::CommandList* commands, Pass pass, std::span<const ImageRef> images,
             std::span<const std::byte> push);
  void Begin(gpu::CommandList* commands, Pass pass, gpu::Timestamps* times);
  void End(gpu::CommandList* commands, gpu::Timestamps* times);
  void PrepareImages(VkCommandBuffer commands);

  const gpu::DeviceContext* context_;
  GuideSource source_;
  bool timed_;
  uint32_t frames_ = 0;  ///< recorded
  gpu::DescriptorSets sets_;
  gpu::Timestamps layer_times_;
  gpu::Timestamps rest_times_;
  std::array<std::optional<gpu::Pipeline>, kPassCount> pipelines_;
  LayerShape shape_;  ///< of the images
  int width_ = 0;     ///< of the frames
  int height_ = 0;
  std::shared_ptr<LayerImages> images_;
};

}  // namespace stillray::vulkan

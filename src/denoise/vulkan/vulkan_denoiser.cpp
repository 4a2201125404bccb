// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "stillray/vulkan.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "denoise/frame_check.h"
#include "denoise/stage_timer.h"
#include "denoise/vulkan/device_inputs.h"
#include "denoise/vulkan/frame_pipeline.h"
#include "denoise/vulkan/layer_passes.h"
#include "gpu/shared_pipelines.h"

namespace stillray {
namespace {

using vulkan::FrameInputs;
using vulkan::FramePipeline;
using vulkan::ImageRef;

ImageRef RefTo(const VulkanImage& image) {
  return {image.view, image.layout};
}

bool IsGiven(const VulkanImage& image) {
  return image.view != VK_NULL_HANDLE;
}

FrameFacts FactsOf(const VulkanFrame& frame, const vulkan::Shape& shape) {
  FrameFacts facts;
  facts.index = frame.index;
  facts.width = shape.width;
  facts.height = shape.height;
  facts.focal_pixels = frame.focal_pixels;
  facts.jittered = IsJittered(frame.jitter_x, frame.jitter_y);
  for (uint32_t k = 0; k < kSignalKindCount; ++k) {
    facts.lights |= IsGiven(frame.lights[k]) ? 1u << k : 0u;
    facts.second_moments |= IsGiven(frame.second_moments[k]) ? 1u << k : 0u;
  }
  facts.second_moments &= facts.lights;
  facts.albedos = (IsGiven(frame.albedo) ? 1u : 0u) | (IsGiven(frame.specular_albedo) ? 2u : 0u) |
                  (IsGiven(frame.transmission_albedo) ? 4u : 0u);
  facts.has_samples = IsGiven(frame.samples);
  facts.has_id = IsGiven(frame.id);
  facts.has_emission = IsGiven(frame.emission);
  facts.has_background = IsGiven(frame.background);
  facts.has_roughness = IsGiven(frame.roughness);
  facts.has_confidence = IsGiven(frame.confidence);
  facts.has_previous_normal = IsGiven(frame.previous_normal);
  facts.has_reflection = IsGiven(frame.reflection.depth);
  facts.samples_per_pixel = frame.samples_per_pixel;
  facts.is_displayed = IsGiven(frame.display);
  return facts;
}

FrameInputs InputsOf(const VulkanFrame& frame) {
  FrameInputs in;
  for (size_t k = 0; k < kSignalKindCount; ++k) {
    in.lights[k] = RefTo(frame.lights[k]);
    in.second_moments[k] = RefTo(frame.second_moments[k]);
  }
  in.depth = RefTo(frame.depth);
  in.normal = RefTo(frame.normal);
  in.id = RefTo(frame.id);
  in.motion = RefTo(frame.motion);
  in.albedos[0] = RefTo(frame.albedo);
  in.albedos[1] = RefTo(frame.specular_albedo);
  in.albedos[2] = RefTo(frame.transmission_albedo);
  in.emission = RefTo(frame.emission);
  in.background = RefTo(frame.background);
  in.samples = RefTo(frame.samples);
  in.roughness = RefTo(frame.roughness);
  in.confidence = RefTo(frame.confidence);
  in.previous_normal = RefTo(frame.previous_normal);
  in.colour = RefTo(frame.colour);
  in.colour_is_half = frame.colour_is_half;
  in.display = RefTo(frame.display);
  return in;
}

vulkan::VirtualInputs VirtualInputsOf(const VulkanVirtualGuides& seen) {
  return {RefTo(seen.depth), RefTo(seen.normal), RefTo(seen.motion), RefTo(seen.id),
          RefTo(seen.albedo)};
}

/// Checks that all images are given that a layer of reflected light needs.
Status CheckReflection(const VulkanFrame& frame) {
  const std::pair<const VulkanImage*, const char*> needed[] = {
      {&frame.reflection.normal, "reflection.normal"},
      {&frame.reflection.motion, "reflection.motion"},
      {&frame.reflection.albedo, "reflection.albedo"},
      {&frame.motion, "motion"},
      {&frame.roughness, "roughness"},
      {&frame.albedo, "albedo"},
      {&frame.specular_albedo, "specular_albedo"}};
  for (const auto& [image, name] : needed) {
    if (!IsGiven(*image)) {
      return Status::InvalidArgument(fmt::format(
          "frame {}: image '{}' is not given, beside 'reflection.depth'", frame.index, name));
    }
  }
  return IsGiven(frame.id) && !IsGiven(frame.reflection.id)
             ? Status::InvalidArgument(fmt::format(
                   "frame {}: image 'reflection.id' is not given, beside 'id'", frame.index))
             : Status::Ok();
}

/// Checks that all images that the settings need are given. \param jittered  this frame or one
/// before it was
Status CheckFrame(const VulkanFrame& frame, const Settings& settings, bool transmission,
                  bool fills_guides, bool jittered) {
  const auto missing = [&](const char* name) {
    return Status::InvalidArgument(
        fmt::format("frame {}: image '{}' is not given", frame.index, name));
  };
  const auto given = [&](SignalKind kind) { return IsGiven(frame.lights[static_cast<int>(kind)]); };
  const bool diffuse = given(SignalKind::kDirectDiffuse) || given(SignalKind::kIndirectDiffuse);
  const bool specular = given(SignalKind::kDirectSpecular) || given(SignalKind::kIndirectSpecular);
  const bool through =
      given(SignalKind::kDirectTransmission) || given(SignalKind::kIndirectTransmission);
  if (!diffuse && !specular && !through) {
    return Status::InvalidArgument(
        fmt::format("frame {}: there are no lights to denoise", frame.index));
  }
  if (through != transmission) {
    return Status::InvalidArgument(
        fmt::format("frame {}: transmission signals are {}given, but the denoiser was made {} them",
                    frame.index, through ? "" : "not ", transmission ? "with" : "without"));
  }
  if (!IsGiven(frame.depth)) {
    return missing("depth");
  }
  if (!IsGiven(frame.normal)) {
    return missing("normal");
  }
  if ((settings.temporal || AntialiasesInTime(settings, jittered) || fills_guides) &&
      !IsGiven(frame.motion)) {
    return missing("motion");
  }
  if (fills_guides && !IsGiven(frame.samples)) {
    return missing("samples");
  }
  if (settings.demodulate && diffuse && !IsGiven(frame.albedo)) {
    return missing("albedo");
  }
  if (settings.demodulate && specular && !IsGiven(frame.specular_albedo)) {
    return missing("specular_albedo");
  }
  if (settings.demodulate && through && !IsGiven(frame.transmission_albedo)) {
    return missing("transmission_albedo");
  }
  if (!IsGiven(frame.colour)) {
    return missing("colour");
  }
  if (!(std::abs(frame.jitter_x) <= 0.5f) || !(std::abs(frame.jitter_y) <= 0.5f)) {
    return Status::InvalidArgument(
        fmt::format("frame {}: jitter is ({}, {}), expected -0.5 to 0.5 for each", frame.index,
                    frame.jitter_x, frame.jitter_y));
  }
  if (!(frame.samples_per_pixel >= 0)) {
    return Status::InvalidArgument(fmt::format("frame {}: samples_per_pixel is {}, expected >= 0",
                                               frame.index, frame.samples_per_pixel));
  }
  return CheckFocalLength(frame.index, frame.focal_pixels, settings);
}

vulkan::PipelineOptions PipelineOptionsOf(const VulkanOptions& o) {
  vulkan::PipelineOptions options;
  options.settings = o.settings;
  options.width = o.width;
  options.height = o.height;
  options.transmission = o.transmission;
  options.storage =
      o.precision == DevicePrecision::kFloat ? vulkan::Storage::kFloat : vulkan::Storage::kHalf;
  options.timed = o.timestamps;
  options.fills_guides = o.incomplete_guides;
  return options;
}

vulkan::PipelineOptions LayerOptionsOf(const VulkanOptions& o) {
  vulkan::PipelineOptions options = PipelineOptionsOf(o);
  options.settings = SettingsOfLayer(o.settings);
  options.transmission = false;
  return options;
}

vulkan::LayerShape LayerShapeOf(const VulkanOptions& o) {
  return {.width = o.width,
          .height = o.height,
          .previous_normals = true,
          .second_moments = true,
          .with_picture = true};
}

/// Frames whose images may differ from each other, as of FramePipeline.
constexpr uint32_t kMostFrames = 128;

/// The filter of reflected light, and the passes between it and that of the rest.
struct ReflectionLayer {
  std::unique_ptr<vulkan::LayerPasses> passes;
  std::unique_ptr<FramePipeline> pipeline;
  bool was_used = false;  ///< by the last frame

  static Result<gpu::MemoryUse> Need(const gpu::DeviceContext* context, const VulkanOptions& o) {
    Result<gpu::MemoryUse> need = FramePipeline::Need(context, LayerOptionsOf(o));
    STILLRAY_RETURN_IF_ERROR(need.status());
    const Result<gpu::MemoryUse> of_passes = vulkan::LayerPasses::Need(context, LayerShapeOf(o));
    STILLRAY_RETURN_IF_ERROR(of_passes.status());
    *need += *of_passes;
    return need;
  }

  static Result<std::unique_ptr<ReflectionLayer>> Create(const gpu::DeviceContext* context,
                                                         const VulkanOptions& o) {
    auto layer = std::make_unique<ReflectionLayer>();
    Result<std::unique_ptr<vulkan::LayerPasses>> passes =
        vulkan::LayerPasses::Create(context, o.timestamps, kMostFrames);
    STILLRAY_RETURN_IF_ERROR(passes.status());
    layer->passes = std::move(*passes);
    STILLRAY_RETURN_IF_ERROR(layer->passes->Prepare(LayerShapeOf(o)));
    Result<std::unique_ptr<FramePipeline>> pipeline =
        FramePipeline::Create(context, LayerOptionsOf(o));
    STILLRAY_RETURN_IF_ERROR(pipeline.status());
    layer->pipeline = std::move(*pipeline);
    return layer;
  }

  /// Records the filter of reflected light, and what makes the rest of facts and inputs.
  Status Record(VkCommandBuffer commands, const Settings& settings,
                const vulkan::VirtualInputs& seen, FrameFacts* facts, FrameInputs* inputs) {
    STILLRAY_RETURN_IF_ERROR(
        passes->RecordLayer(commands, *facts, *inputs, seen, settings.virtual_roughness));
    const ImageRef picture = vulkan::RefTo(passes->images()->picture);
    const FrameFacts of_layer = passes->FactsOfLayer(*facts);
    FrameInputs layer_inputs = passes->InputsOfLayer(*inputs);
    layer_inputs.colour = picture;
    layer_inputs.colour_is_half = false;
    layer_inputs.display = {};
    const FramePlan plan = MakePlan(SettingsOfLayer(settings), of_layer, pipeline->progress());
    STILLRAY_RETURN_IF_ERROR(pipeline->Record(commands, plan, of_layer, layer_inputs, nullptr));
    STILLRAY_RETURN_IF_ERROR(passes->RecordRest(commands, *facts, *inputs, picture));
    *inputs = passes->InputsOfRest(*inputs);
    *facts = passes->FactsOfRest(*facts);
    return Status::Ok();
  }
};

/// Adds times to those of the same names.
void AddTimes(const std::vector<gpu::DeviceTime>& more, std::vector<StageTime>* times) {
  for (const gpu::DeviceTime& time : more) {
    AddTime({time.name, time.milliseconds}, times);
  }
}

Result<gpu::DeviceContext> ContextOf(const VulkanContext& c) {
  if (c.instance == VK_NULL_HANDLE || c.physical_device == VK_NULL_HANDLE ||
      c.device == VK_NULL_HANDLE || c.get_instance_proc_addr == nullptr) {
    return Status::InvalidArgument(
        "Vulkan: instance, physical_device, device and get_instance_proc_addr must be given");
  }
  return gpu::MakeContext(c.get_instance_proc_addr, c.instance, c.physical_device, c.device);
}

DeviceMemory MemoryOf(const gpu::MemoryUse& use) {
  return {use.allocations, use.resources, use.bytes, use.largest};
}

}  // namespace

struct VulkanDenoiser::Impl {
  explicit Impl(const gpu::DeviceContext& device) : context(device), pipelines(&context) {
    context.pipelines = &pipelines;
  }

  gpu::DeviceContext context;
  gpu::SharedPipelines pipelines;  // of this alone, so that none outlives the renderer's device
  Settings settings;
  bool incomplete_guides = false;
  std::unique_ptr<FramePipeline> pipeline;
  std::unique_ptr<ReflectionLayer> layer;  // nullptr without VulkanOptions::virtual_guides

  bool FillsGuides() const { return incomplete_guides && settings.fill_guides; }
  Result<bool> UsesLayer(const VulkanFrame& frame, const FrameFacts& facts) const;
  void Reset();
};

/// Whether the frame has a layer of reflected light, whose images were checked.
Result<bool> VulkanDenoiser::Impl::UsesLayer(const VulkanFrame& frame,
                                             const FrameFacts& facts) const {
  if (!facts.has_reflection) {
    return false;
  }
  if (layer == nullptr) {
    return Status::InvalidArgument(fmt::format(
        "frame {}: virtual guides are given, but the denoiser was made without them", frame.index));
  }
  STILLRAY_RETURN_IF_ERROR(CheckReflection(frame));
  return LayersOf(settings, facts).count > 1;
}

void VulkanDenoiser::Impl::Reset() {
  pipeline->Reset();
  if (layer != nullptr) {
    layer->pipeline->Reset();
  }
}

VulkanDenoiser::VulkanDenoiser(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VulkanDenoiser::VulkanDenoiser(VulkanDenoiser&&) noexcept = default;
VulkanDenoiser& VulkanDenoiser::operator=(VulkanDenoiser&&) noexcept = default;
VulkanDenoiser::~VulkanDenoiser() = default;

Result<DeviceMemory> VulkanDenoiser::MemoryNeed(const VulkanContext& context,
                                                const VulkanOptions& options) {
  const Result<gpu::DeviceContext> made = ContextOf(context);
  STILLRAY_RETURN_IF_ERROR(made.status());
  Result<gpu::MemoryUse> need = FramePipeline::Need(&*made, PipelineOptionsOf(options));
  STILLRAY_RETURN_IF_ERROR(need.status());
  if (options.virtual_guides) {
    const Result<gpu::MemoryUse> more = ReflectionLayer::Need(&*made, options);
    STILLRAY_RETURN_IF_ERROR(more.status());
    *need += *more;
  }
  return MemoryOf(*need);
}

Result<VulkanDenoiser> VulkanDenoiser::Create(const VulkanContext& context,
                                              const VulkanOptions& options) {
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(options.settings));
  STILLRAY_RETURN_IF_ERROR(CheckDeviceSettings(options.settings));
  const Result<gpu::DeviceContext> made = ContextOf(context);
  STILLRAY_RETURN_IF_ERROR(made.status());
  auto impl = std::make_unique<Impl>(*made);
  impl->settings = options.settings;
  impl->incomplete_guides = options.incomplete_guides;
  Result<std::unique_ptr<FramePipeline>> pipeline =
      FramePipeline::Create(&impl->context, PipelineOptionsOf(options));
  STILLRAY_RETURN_IF_ERROR(pipeline.status());
  impl->pipeline = std::move(pipeline.value());
  if (options.virtual_guides) {
    Result<std::unique_ptr<ReflectionLayer>> layer =
        ReflectionLayer::Create(&impl->context, options);
    STILLRAY_RETURN_IF_ERROR(layer.status());
    impl->layer = std::move(*layer);
  }
  return VulkanDenoiser(std::move(impl));
}

Status VulkanDenoiser::Record(VkCommandBuffer commands, const VulkanFrame& frame) {
  if (commands == VK_NULL_HANDLE) {
    return Status::InvalidArgument("Vulkan: the command buffer is not given");
  }
  FrameFacts facts = FactsOf(frame, impl_->pipeline->shape());
  const bool jittered = facts.jittered || impl_->pipeline->progress().jittered;
  STILLRAY_RETURN_IF_ERROR(CheckFrame(frame, impl_->settings, impl_->pipeline->has_transmission(),
                                      impl_->FillsGuides(), jittered));
  facts.has_incomplete_guides = impl_->FillsGuides();
  const Result<bool> uses_layer = impl_->UsesLayer(frame, facts);
  STILLRAY_RETURN_IF_ERROR(uses_layer.status());
  FrameInputs inputs = InputsOf(frame);
  ReflectionLayer* const layer = impl_->layer.get();
  if (layer != nullptr && layer->was_used != *uses_layer) {
    impl_->Reset();  // each history has another part of the light
    layer->was_used = *uses_layer;
  }
  if (*uses_layer) {
    STILLRAY_RETURN_IF_ERROR(layer->Record(commands, impl_->settings,
                                           VirtualInputsOf(frame.reflection), &facts, &inputs));
  }
  const FramePlan plan = MakePlan(impl_->settings, facts, impl_->pipeline->progress());
  return impl_->pipeline->Record(commands, plan, facts, inputs, nullptr);
}

Status VulkanDenoiser::SetSettings(const Settings& settings) {
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(settings));
  STILLRAY_RETURN_IF_ERROR(CheckDeviceSettings(settings));
  const auto fits = [](const FramePipeline& pipeline, const Settings& s) {
    return pipeline.Fits(s, pipeline.shape().width, pipeline.shape().height,
                         pipeline.has_transmission());
  };
  FramePipeline& pipeline = *impl_->pipeline;
  FramePipeline* const of_layer = impl_->layer != nullptr ? impl_->layer->pipeline.get() : nullptr;
  if (!fits(pipeline, settings) ||
      (of_layer != nullptr && !fits(*of_layer, SettingsOfLayer(settings)))) {
    return Status::InvalidArgument(
        "these settings need other images than the denoiser was made with: make another one");
  }
  STILLRAY_RETURN_IF_ERROR(pipeline.SetSettings(settings));
  if (of_layer != nullptr) {
    STILLRAY_RETURN_IF_ERROR(of_layer->SetSettings(SettingsOfLayer(settings)));
  }
  if (NeedsNewHistory(impl_->settings, settings)) {
    impl_->Reset();
  }
  impl_->settings = settings;
  return Status::Ok();
}

const Settings& VulkanDenoiser::settings() const {
  return impl_->settings;
}

void VulkanDenoiser::Reset() {
  impl_->Reset();
}

Status VulkanDenoiser::ForgetImages() {
  if (impl_->layer != nullptr) {
    STILLRAY_RETURN_IF_ERROR(impl_->layer->passes->ForgetInputs());
    STILLRAY_RETURN_IF_ERROR(impl_->layer->pipeline->ForgetInputs());
  }
  return impl_->pipeline->ForgetInputs();
}

DeviceMemory VulkanDenoiser::memory() const {
  gpu::MemoryUse use = impl_->pipeline->memory();
  if (impl_->layer != nullptr) {
    use += impl_->layer->pipeline->memory();
    use += impl_->layer->passes->memory();
  }
  return MemoryOf(use);
}

std::vector<StageTime> VulkanDenoiser::timings() const {
  std::vector<StageTime> times;
  AddTimes(impl_->pipeline->times(), &times);
  if (impl_->layer != nullptr && impl_->layer->was_used) {
    AddTimes(impl_->layer->pipeline->times(), &times);
    impl_->layer->passes->AddTimes(&times);
  }
  return times;
}

}  // namespace stillray

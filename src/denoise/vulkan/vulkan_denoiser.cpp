// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "stillray/vulkan.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "denoise/stage_timer.h"
#include "denoise/vulkan/device_inputs.h"
#include "denoise/vulkan/embedded_frame.h"
#include "denoise/vulkan/embedded_options.h"
#include "denoise/vulkan/frame_pipeline.h"
#include "denoise/vulkan/layer_passes.h"
#include "gpu/shared_pipelines.h"

namespace stillray {
namespace {

using vulkan::FrameInputs;
using vulkan::FramePipeline;
using vulkan::ImageRef;
using vulkan::LayerOptionsOf;
using vulkan::LayerShapeOf;
using vulkan::PipelineOptionsOf;

constexpr int kMostInFlight = 64;

/// The filter of a layer of reflected or transmitted light, and the passes between this filter and
/// that of the rest.
struct VirtualLayer {
  GuideSource source;
  std::unique_ptr<vulkan::LayerPasses> passes;
  std::unique_ptr<FramePipeline> pipeline;
  bool was_used = false;  ///< by the last frame

  static Result<gpu::MemoryUse> Need(const gpu::DeviceContext* context, GuideSource source,
                                     const VulkanOptions& o) {
    Result<gpu::MemoryUse> need = FramePipeline::Need(context, LayerOptionsOf(o, source));
    STILLRAY_RETURN_IF_ERROR(need.status());
    const Result<gpu::MemoryUse> of_passes =
        vulkan::LayerPasses::Need(context, LayerShapeOf(o, source));
    STILLRAY_RETURN_IF_ERROR(of_passes.status());
    *need += *of_passes;
    return need;
  }

  static Result<std::unique_ptr<VirtualLayer>> Create(const gpu::DeviceContext* context,
                                                      GuideSource source, const VulkanOptions& o) {
    auto layer = std::make_unique<VirtualLayer>();
    layer->source = source;
    Result<std::unique_ptr<vulkan::LayerPasses>> passes = vulkan::LayerPasses::Create(
        context, source, o.timestamps, static_cast<uint32_t>(o.frames_in_flight));
    STILLRAY_RETURN_IF_ERROR(passes.status());
    layer->passes = std::move(*passes);
    STILLRAY_RETURN_IF_ERROR(layer->passes->Prepare(LayerShapeOf(o, source)));
    Result<std::unique_ptr<FramePipeline>> pipeline =
        FramePipeline::Create(context, LayerOptionsOf(o, source));
    STILLRAY_RETURN_IF_ERROR(pipeline.status());
    layer->pipeline = std::move(*pipeline);
    return layer;
  }

  /// Records the filter of the layer.
  /// \param facts, inputs  of the frame
  Status Record(gpu::CommandList* commands, const Settings& settings,
                const vulkan::VirtualInputs& seen, const FrameFacts& facts,
                const FrameInputs& inputs) {
    STILLRAY_RETURN_IF_ERROR(
        passes->RecordLayer(commands, facts, inputs, seen, SelectGuidesOf(settings, source)));
    const FrameFacts of_layer = passes->FactsOfLayer(facts);
    FrameInputs layer_inputs = passes->InputsOfLayer(inputs);
    layer_inputs.colour = picture();
    layer_inputs.colour_is_half = false;
    layer_inputs.display = {};
    std::fill(std::begin(layer_inputs.filtered), std::end(layer_inputs.filtered), ImageRef());
    const FramePlan plan = MakePlan(SettingsOfLayer(settings), of_layer, pipeline->progress());
    return pipeline->Record(commands, plan, of_layer, layer_inputs, nullptr);
  }

  /// Records the passes that make the rest.
  /// \param facts, inputs  [in,out] of the frame, or of the rest of another layer
  Status RecordRest(gpu::CommandList* commands, FrameFacts* facts, FrameInputs* inputs) {
    STILLRAY_RETURN_IF_ERROR(passes->RecordRest(commands, *facts, *inputs, picture()));
    *inputs = passes->InputsOfRest(*facts, *inputs);
    *facts = passes->FactsOfRest(*facts);
    return Status::Ok();
  }

 private:
  ImageRef picture() const { return vulkan::RefTo(passes->images()->picture); }
};

/// The layers that frames may have with these options.
std::vector<GuideSource> LayersOf(const VulkanOptions& options) {
  std::vector<GuideSource> sources;
  if (options.virtual_guides) {
    sources.push_back(GuideSource::kReflection);
    if (options.transmission) {
      sources.push_back(GuideSource::kRefraction);
    }
  }
  return sources;
}

/// Adds each time to the entry with its name.
void AddTimes(const std::vector<gpu::DeviceTime>& more, std::vector<StageTime>* times) {
  for (const gpu::DeviceTime& time : more) {
    AddTime({time.name, time.milliseconds}, times);
  }
}

gpu::MemorySource SourceOf(const VulkanAllocator& a) {
  gpu::MemorySource source;
  source.allocate = [a](const VkMemoryRequirements& need, gpu::OwnedMemory* memory) {
    VulkanMemoryBlock block;
    const VkResult result = a.allocate(a.user, &need, &block);
    *memory = {block.memory, block.offset, block.handle};
    return result;
  };
  source.free = [a](const gpu::OwnedMemory& memory) {
    const VulkanMemoryBlock block = {memory.memory, memory.offset, memory.handle};
    a.free(a.user, &block);
  };
  return source;
}

/// Pipelines shared by the denoisers on one renderer's device; separate from those of stillray's
/// own devices, so that none outlives the renderer's device.
struct PipelinesOfDevice {
  explicit PipelinesOfDevice(const gpu::DeviceContext& device)
      : context(device), pipelines(&context) {}

  gpu::DeviceContext context;
  gpu::SharedPipelines pipelines;
};

Result<gpu::DeviceContext> ContextOf(const VulkanContext& c) {
  if (c.instance == VK_NULL_HANDLE || c.physical_device == VK_NULL_HANDLE ||
      c.device == VK_NULL_HANDLE || c.get_instance_proc_addr == nullptr) {
    return Status::InvalidArgument(
        "Vulkan: instance, physical_device, device and get_instance_proc_addr must be given");
  }
  if ((c.allocator.allocate == nullptr) != (c.allocator.free == nullptr)) {
    return Status::InvalidArgument(
        "Vulkan: the allocator has one of the functions allocate and free, expected both or none");
  }
  Result<gpu::DeviceContext> made =
      gpu::MakeContext(c.get_instance_proc_addr, c.instance, c.physical_device, c.device);
  STILLRAY_RETURN_IF_ERROR(made.status());
  made->pipeline_cache = c.pipeline_cache;
  if (c.allocator.allocate != nullptr) {
    made->memory_source = SourceOf(c.allocator);
  }
  return made;
}

/// Adds the functions of VK_EXT_debug_utils.
Status LoadLabels(const VulkanContext& c, gpu::DeviceContext* to) {
  const auto get = reinterpret_cast<PFN_vkGetDeviceProcAddr>(
      c.get_instance_proc_addr(c.instance, "vkGetDeviceProcAddr"));
  if (!gpu::LoadLabelFunctions(get, c.device, &to->vk).ok()) {
    return Status::Unsupported("debug_labels: the instance was created without VK_EXT_debug_utils");
  }
  return Status::Ok();
}

Status CheckOptions(const VulkanContext& context, const VulkanOptions& o,
                    const gpu::DeviceContext* shared) {
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(o.settings));
  STILLRAY_RETURN_IF_ERROR(CheckDeviceSettings(o.settings));
  if (o.frames_in_flight < 0 || o.frames_in_flight > kMostInFlight) {
    return Status::InvalidArgument(
        fmt::format("frames_in_flight is {}, expected 0 to {}", o.frames_in_flight, kMostInFlight));
  }
  if (o.hit_distances && !o.virtual_guides) {
    return Status::InvalidArgument("hit_distances is set without virtual_guides, expected both");
  }
  return shared == nullptr || shared->device == context.device
             ? Status::Ok()
             : Status::InvalidArgument("share_with is a denoiser on another device");
}

DeviceMemory MemoryOf(const gpu::MemoryUse& use) {
  return {use.allocations, use.resources, use.bytes, use.largest};
}

}  // namespace

struct VulkanDenoiser::Impl {
  Impl(const gpu::DeviceContext& device, std::shared_ptr<PipelinesOfDevice> shared, bool labels)
      : context(device), pipelines(std::move(shared)), commands(&context, labels) {
    context.pipelines = &pipelines->pipelines;
  }

  /// All state that recording a frame changes.
  struct Checkpoint {
    FramePipeline::Checkpoint pipeline;
    struct OfLayer {
      FramePipeline::Checkpoint pipeline;
      uint32_t frames;
      bool was_used;
    };
    std::vector<OfLayer> layers;
  };

  gpu::DeviceContext context;
  std::shared_ptr<PipelinesOfDevice> pipelines;
  gpu::CommandList commands;  // of the current frame
  Settings settings;
  bool incomplete_guides = false;
  bool hit_distances = false;
  std::unique_ptr<FramePipeline> pipeline;
  std::vector<std::unique_ptr<VirtualLayer>> layers;  // none without VulkanOptions::virtual_guides

  bool FillsGuides() const { return incomplete_guides && settings.fill_guides; }
  Status CheckLayers(const VulkanFrame& frame, const FrameFacts& facts) const;
  bool UseLayers(const FrameFacts& facts);
  Status RecordLayers(const VulkanFrame& frame, FrameFacts* facts, FrameInputs* inputs);
  Status AddFrame(const VulkanFrame& frame, FrameFacts facts);
  Checkpoint checkpoint() const;
  void GoBackTo(const Checkpoint& checkpoint);
  void Resize(int width, int height);
  void Reset();
};

/// Checks the images of the frame's layers.
Status VulkanDenoiser::Impl::CheckLayers(const VulkanFrame& frame, const FrameFacts& facts) const {
  for (const GuideSource source : {GuideSource::kReflection, GuideSource::kRefraction}) {
    const bool reflected = source == GuideSource::kReflection;
    if (!(reflected ? facts.has_reflection : facts.has_refraction)) {
      continue;
    }
    const bool expected = std::any_of(layers.begin(), layers.end(),
                                      [&](const auto& layer) { return layer->source == source; });
    if (!expected) {
      return Status::InvalidArgument(
          fmt::format("frame {}: virtual guides of {} light are given, but the denoiser was made "
                      "without {}",
                      frame.index, reflected ? "reflected" : "transmitted",
                      layers.empty() ? "virtual guides" : "transmission signals"));
    }
    STILLRAY_RETURN_IF_ERROR(vulkan::CheckVirtualGuides(frame, source));
  }
  return hit_distances || frame.hit_distance.view == VK_NULL_HANDLE
             ? Status::Ok()
             : Status::InvalidArgument(
                   fmt::format("frame {}: image 'hit_distance' is given, but the denoiser was made "
                               "without hit_distances",
                               frame.index));
}

/// Selects the layers of the frame. \return whether they differ from those of the last frame
bool VulkanDenoiser::Impl::UseLayers(const FrameFacts& facts) {
  const LayerList used = LayersOf(settings, facts);
  bool differ = false;
  for (const auto& layer : layers) {
    const bool uses = std::any_of(used.begin(), used.end(), [&](const PlannedLayer& planned) {
      return planned.guides == layer->source;
    });
    differ = differ || layer->was_used != uses;
    layer->was_used = uses;
  }
  return differ;
}

/// Records the filters of the layers. \param facts, inputs  [in,out] of the frame, then of the rest
Status VulkanDenoiser::Impl::RecordLayers(const VulkanFrame& frame, FrameFacts* facts,
                                          FrameInputs* inputs) {
  for (const auto& layer : layers) {
    if (layer->was_used) {
      const Result<vulkan::VirtualInputs> seen =
          vulkan::VirtualInputsOf(frame, layer->source, facts->width, facts->height);
      STILLRAY_RETURN_IF_ERROR(seen.status());
      STILLRAY_RETURN_IF_ERROR(layer->Record(&commands, settings, *seen, *facts, *inputs));
    }
  }
  for (const auto& layer : layers) {
    if (layer->was_used) {
      STILLRAY_RETURN_IF_ERROR(layer->RecordRest(&commands, facts, inputs));
    }
  }
  return Status::Ok();
}

/// Adds the commands of the frame to the list.
Status VulkanDenoiser::Impl::AddFrame(const VulkanFrame& frame, FrameFacts facts) {
  Resize(facts.width, facts.height);
  if (UseLayers(facts)) {
    Reset();  // the histories contain other parts of the radiance
  }
  FrameInputs inputs = vulkan::InputsOf(frame);
  STILLRAY_RETURN_IF_ERROR(RecordLayers(frame, &facts, &inputs));
  const FramePlan plan = MakePlan(settings, facts, pipeline->progress());
  return pipeline->Record(&commands, plan, facts, inputs, nullptr);
}

VulkanDenoiser::Impl::Checkpoint VulkanDenoiser::Impl::checkpoint() const {
  Checkpoint now = {pipeline->checkpoint(), {}};
  for (const auto& layer : layers) {
    now.layers.push_back({layer->pipeline->checkpoint(), layer->passes->frames(), layer->was_used});
  }
  return now;
}

void VulkanDenoiser::Impl::GoBackTo(const Checkpoint& checkpoint) {
  commands.Clear();
  pipeline->GoBackTo(checkpoint.pipeline);
  for (size_t i = 0; i < layers.size(); ++i) {
    layers[i]->pipeline->GoBackTo(checkpoint.layers[i].pipeline);
    layers[i]->passes->GoBackTo(checkpoint.layers[i].frames);
    layers[i]->passes->Resize(checkpoint.pipeline.size.width, checkpoint.pipeline.size.height);
    layers[i]->was_used = checkpoint.layers[i].was_used;
  }
}

void VulkanDenoiser::Impl::Resize(int width, int height) {
  pipeline->Resize(width, height);
  for (const auto& layer : layers) {
    layer->pipeline->Resize(width, height);
    layer->passes->Resize(width, height);
  }
}

void VulkanDenoiser::Impl::Reset() {
  pipeline->Reset();
  for (const auto& layer : layers) {
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
  for (const GuideSource source : LayersOf(options)) {
    const Result<gpu::MemoryUse> more = VirtualLayer::Need(&*made, source, options);
    STILLRAY_RETURN_IF_ERROR(more.status());
    *need += *more;
  }
  return MemoryOf(*need);
}

Result<VulkanDenoiser> VulkanDenoiser::Create(const VulkanContext& context,
                                              const VulkanOptions& options) {
  const Impl* other = options.share_with != nullptr ? options.share_with->impl_.get() : nullptr;
  STILLRAY_RETURN_IF_ERROR(
      CheckOptions(context, options, other != nullptr ? &other->context : nullptr));
  Result<gpu::DeviceContext> made = ContextOf(context);
  STILLRAY_RETURN_IF_ERROR(made.status());
  if (options.debug_labels) {
    STILLRAY_RETURN_IF_ERROR(LoadLabels(context, &*made));
  }
  auto impl = std::make_unique<Impl>(
      *made, other != nullptr ? other->pipelines : std::make_shared<PipelinesOfDevice>(*made),
      options.debug_labels);
  impl->settings = options.settings;
  impl->incomplete_guides = options.incomplete_guides;
  impl->hit_distances = options.hit_distances;
  Result<std::unique_ptr<FramePipeline>> pipeline =
      FramePipeline::Create(&impl->context, PipelineOptionsOf(options));
  STILLRAY_RETURN_IF_ERROR(pipeline.status());
  impl->pipeline = std::move(pipeline.value());
  for (const GuideSource source : LayersOf(options)) {
    Result<std::unique_ptr<VirtualLayer>> layer =
        VirtualLayer::Create(&impl->context, source, options);
    STILLRAY_RETURN_IF_ERROR(layer.status());
    impl->layers.push_back(std::move(*layer));
  }
  return VulkanDenoiser(std::move(impl));
}

Status VulkanDenoiser::Record(VkCommandBuffer commands, const VulkanFrame& frame) {
  if (commands == VK_NULL_HANDLE) {
    return Status::InvalidArgument("Vulkan: the command buffer is not given");
  }
  const FramePipeline::Size most = impl_->pipeline->most();
  FrameFacts facts = frame.width > 0 ? vulkan::FactsOf(frame, frame.width, frame.height)
                                     : vulkan::FactsOf(frame, most.width, most.height);
  const bool jittered = IsJittered(facts) || impl_->pipeline->progress().jittered;
  STILLRAY_RETURN_IF_ERROR(vulkan::CheckFrame(
      frame, impl_->settings, impl_->pipeline->has_transmission(), impl_->FillsGuides(), jittered));
  facts.has_incomplete_guides = impl_->FillsGuides();
  STILLRAY_RETURN_IF_ERROR(impl_->CheckLayers(frame, facts));
  STILLRAY_RETURN_IF_ERROR(vulkan::CheckOutputs(
      frame, most.width, most.height, impl_->pipeline->groups(), LayersOf(impl_->settings, facts)));
  const Impl::Checkpoint before = impl_->checkpoint();
  const Status added = impl_->AddFrame(frame, facts);
  if (!added.ok()) {
    impl_->GoBackTo(before);
    return added;
  }
  impl_->commands.Record(commands);
  return Status::Ok();
}

Status VulkanDenoiser::SetSettings(const Settings& settings) {
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(settings));
  STILLRAY_RETURN_IF_ERROR(CheckDeviceSettings(settings));
  const auto fits = [](const FramePipeline& pipeline, const Settings& s) {
    return pipeline.Fits(s, pipeline.most().width, pipeline.most().height,
                         pipeline.has_transmission());
  };
  FramePipeline& pipeline = *impl_->pipeline;
  const Settings of_layer = SettingsOfLayer(settings);
  if (!fits(pipeline, settings) ||
      !std::all_of(impl_->layers.begin(), impl_->layers.end(),
                   [&](const auto& layer) { return fits(*layer->pipeline, of_layer); })) {
    return Status::InvalidArgument(
        "these settings need other images than the denoiser was made with: make another one");
  }
  STILLRAY_RETURN_IF_ERROR(pipeline.SetSettings(settings));
  for (const auto& layer : impl_->layers) {
    STILLRAY_RETURN_IF_ERROR(layer->pipeline->SetSettings(of_layer));
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
  for (const auto& layer : impl_->layers) {
    STILLRAY_RETURN_IF_ERROR(layer->passes->ForgetInputs());
    STILLRAY_RETURN_IF_ERROR(layer->pipeline->ForgetInputs());
  }
  return impl_->pipeline->ForgetInputs();
}

DeviceMemory VulkanDenoiser::memory() const {
  gpu::MemoryUse use = impl_->pipeline->memory();
  for (const auto& layer : impl_->layers) {
    use += layer->pipeline->memory();
    use += layer->passes->memory();
  }
  return MemoryOf(use);
}

std::vector<StageTime> VulkanDenoiser::timings() const {
  std::vector<StageTime> times;
  AddTimes(impl_->pipeline->times(), &times);
  for (const auto& layer : impl_->layers) {
    if (layer->was_used) {
      AddTimes(layer->pipeline->times(), &times);
      layer->passes->AddTimes(&times);
    }
  }
  return times;
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/gpu_tracer.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>

#include <fmt/format.h>

namespace stillray::render {
namespace shaders {
#define STILLRAY_SHADER(name)           \
  extern const std::uint32_t k##name[]; \
  extern const std::size_t k##name##Words;
STILLRAY_SHADER(FindGuides)
STILLRAY_SHADER(FindImages)
STILLRAY_SHADER(StartPaths)
STILLRAY_SHADER(StartReference)
STILLRAY_SHADER(Shade)
STILLRAY_SHADER(TraceShadows)
STILLRAY_SHADER(TraceNext)
STILLRAY_SHADER(CrossMedia)
STILLRAY_SHADER(Advance)
STILLRAY_SHADER(AddSamples)
STILLRAY_SHADER(AddReference)
#undef STILLRAY_SHADER
}  // namespace shaders

namespace {

struct ShaderCode {
  const char* name;
  std::span<const uint32_t> code;
};

/// In the order of GpuTracer's enumerators.
ShaderCode CodeOf(size_t shader) {
  const ShaderCode codes[] = {
      {"find_guides", {shaders::kFindGuides, shaders::kFindGuidesWords}},
      {"find_images", {shaders::kFindImages, shaders::kFindImagesWords}},
      {"start_paths", {shaders::kStartPaths, shaders::kStartPathsWords}},
      {"start_reference", {shaders::kStartReference, shaders::kStartReferenceWords}},
      {"shade", {shaders::kShade, shaders::kShadeWords}},
      {"trace_shadows", {shaders::kTraceShadows, shaders::kTraceShadowsWords}},
      {"trace_next", {shaders::kTraceNext, shaders::kTraceNextWords}},
      {"cross_media", {shaders::kCrossMedia, shaders::kCrossMediaWords}},
      {"advance", {shaders::kAdvance, shaders::kAdvanceWords}},
      {"add_samples", {shaders::kAddSamples, shaders::kAddSamplesWords}},
      {"add_reference", {shaders::kAddReference, shaders::kAddReferenceWords}},
  };
  return codes[shader];
}

constexpr size_t kQueueBytes = kQueueCount * sizeof(GpuQueue) + sizeof(GpuProgress);

bool LetsThrough(const Material& material) {
  return material.transmission > 0.0f || material.alpha_mode != AlphaMode::kOpaque;
}

}  // namespace

int MostSteps(const Scene& scene, int bounces) {
  const bool any_free = std::any_of(scene.materials.begin(), scene.materials.end(), LetsThrough);
  return bounces + 2 + (any_free ? kMaxFreeEvents : 0);
}

Status GpuTracer::CheckLimits() const {
  const gpu::DeviceContext& c = device_->context();
  const VkPhysicalDeviceLimits& limits = c.limits;
  const uint32_t needed =
      gpu::StorageBuffersOf(c, GpuAccel::kSceneShape) +
      gpu::StorageBuffersOf(c, GpuLights::kShape) + gpu::StorageBuffersOf(c, kShape) +
      (accel_->hardware() != nullptr ? gpu::StorageBuffersOf(c, HardwareScene::kShape) : 0);
  const uint32_t offered =
      std::min(limits.maxPerStageDescriptorStorageBuffers, limits.maxDescriptorSetStorageBuffers);
  if (offered < needed) {
    return Status::Unsupported(
        fmt::format("{}: tracing paths needs {} storage buffers in a shader, the device offers {}",
                    device_->info().name, needed, offered));
  }
  return Status::Ok();
}

std::array<size_t, GpuTracer::kBindingCount> GpuTracer::RecordBytes(const TracerParts& parts) {
  const size_t signals = parts.separates ? kAllSignals : kSurfaceSignals;
  std::array<size_t, kBindingCount> bytes = {};
  bytes[kPaths] = sizeof(GpuPath);
  bytes[kPathParts] = sizeof(GpuPathParts);
  bytes[kRays] = sizeof(GpuRay);
  bytes[kHits] = sizeof(GpuHit);
  bytes[kShadows] = sizeof(GpuShadow);
  bytes[kLists] = 2 * sizeof(uint32_t);
  bytes[kGuides] = sizeof(GpuGuides);
  bytes[kFirstHits] = sizeof(GpuHit);
  bytes[kLightOfSamples] = signals * sizeof(GpuSignal);
  bytes[kSums] = signals * sizeof(GpuSignal);
  bytes[kLensSums] = parts.lens ? sizeof(LensGuides) : 0;
  bytes[kImages] = parts.images ? (parts.separates ? 2 : 1) * sizeof(GpuImage) : 0;
  return bytes;
}

size_t GpuTracer::BytesPerPixel(const TracerParts& parts) {
  const std::array<size_t, kBindingCount> bytes = RecordBytes(parts);
  return std::accumulate(bytes.begin(), bytes.end(), size_t{0});
}

/// Maximum pixels of a batch, from the device's limits on storage buffer size and workgroup count.
uint32_t GpuTracer::MostPixels() const {
  const VkPhysicalDeviceLimits& limits = device_->context().limits;
  const std::array<size_t, kBindingCount> bytes = RecordBytes(parts_);
  const uint64_t of_buffers =
      limits.maxStorageBufferRange / *std::max_element(bytes.begin(), bytes.end());
  const uint64_t of_groups = uint64_t{limits.maxComputeWorkGroupCount[0]} * kGroupSize;
  return static_cast<uint32_t>(std::min({of_buffers, of_groups, uint64_t{1} << 31}));
}

Status GpuTracer::AddBuffers() {
  const size_t n = capacity_;
  const size_t n_host = parts_.to_host ? n : 1;
  const std::array<size_t, kBindingCount> bytes = RecordBytes(parts_);
  constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  const VkBufferUsageFlags queue_usage =
      kStorage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
      (accel_->hardware() != nullptr ? VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT : 0);
  struct Want {
    Binding binding;
    VkBufferUsageFlags usage = kStorage;
    size_t bytes = 0;  // total size; 0: one record per pixel
  };
  const Want wants[] = {
      {kFrame, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, sizeof(GpuFrame)},
      {kPaths},
      {kRays},
      {kHits},
      {kShadows},
      {kLists},
      {kQueues, queue_usage, kQueueBytes + sizeof(GpuCounters)},
      {kGuides},
      {kFirstHits},
      {kLightOfSamples},
      {kSums},
      {kLensSums},
      {kImages},
      {kPathParts},
  };
  constexpr size_t kUnused = std::max(sizeof(LensGuides), 2 * sizeof(GpuImage));
  for (const Want& want : wants) {
    const size_t of_pixels = std::max(n * bytes[want.binding], kUnused);
    const Result<const gpu::Buffer*> buffer = arena_.AddBuffer(
        want.bytes > 0 ? want.bytes : of_pixels, want.usage, gpu::BufferPlace::kDevice);
    STILLRAY_RETURN_IF_ERROR(buffer.status());
    buffers_[want.binding] = *buffer;
  }
  const auto add_host = [&](size_t bytes, VkBufferUsageFlags usage, gpu::BufferPlace place,
                            const gpu::Buffer** out) {
    const Result<const gpu::Buffer*> buffer = arena_.AddBuffer(bytes, usage, place);
    if (buffer.ok()) {
      *out = *buffer;
    }
    return buffer.status();
  };
  STILLRAY_RETURN_IF_ERROR(
      add_host(n * sizeof(uint32_t), kStorage, gpu::BufferPlace::kUpload, &listed_));
  STILLRAY_RETURN_IF_ERROR(
      add_host(n_host * sizeof(GpuGuides), 0, gpu::BufferPlace::kDownload, &host_guides_));
  STILLRAY_RETURN_IF_ERROR(add_host(std::max(n_host * bytes[kImages], kUnused), 0,
                                    gpu::BufferPlace::kDownload, &host_images_));
  STILLRAY_RETURN_IF_ERROR(
      add_host(n_host * bytes[kSums], 0, gpu::BufferPlace::kDownload, &host_sums_));
  STILLRAY_RETURN_IF_ERROR(
      add_host(sizeof(GpuCounters), 0, gpu::BufferPlace::kDownload, &host_counters_));
  buffers_[kListed] = listed_;
  // Not read without visibility.
  buffers_[kVisible] = visibility_ != nullptr ? &visibility_->triangles() : listed_;
  return arena_.Allocate();
}

Result<std::unique_ptr<GpuTracer>> GpuTracer::Create(gpu::Device* device, const GpuAccel* accel,
                                                     const GpuLights* lights,
                                                     const Visibility* visibility,
                                                     uint32_t most_pixels,
                                                     const TracerParts& parts) {
  std::unique_ptr<GpuTracer> tracer(new GpuTracer(device, accel, lights, visibility));
  tracer->constants_ = accel->constants();
  tracer->parts_ = parts;
  STILLRAY_RETURN_IF_ERROR(tracer->CheckLimits());
  tracer->capacity_ =
      std::max(std::min(most_pixels, tracer->MostPixels()) / kGroupSize, 1u) * kGroupSize;
  STILLRAY_RETURN_IF_ERROR(tracer->AddBuffers());
  // `sets_` also creates the layouts of the other classes' sets, for the pipelines.
  const Result<VkDescriptorSet> set = tracer->sets_.CreateSingle(kShape, tracer->buffers_);
  STILLRAY_RETURN_IF_ERROR(set.status());
  tracer->set_ = *set;
  if (accel->hardware() != nullptr) {
    STILLRAY_RETURN_IF_ERROR(tracer->MakeHardwarePipelines());
  }
  return tracer;
}

/// Descriptor set layouts of all shaders.
Result<std::vector<VkDescriptorSetLayout>> GpuTracer::Layouts() {
  std::vector<VkDescriptorSetLayout> layouts;
  for (const gpu::SetShape& shape : {GpuAccel::kSceneShape, GpuLights::kShape, kShape}) {
    const Result<VkDescriptorSetLayout> layout = sets_.Layout(shape);
    STILLRAY_RETURN_IF_ERROR(layout.status());
    layouts.push_back(*layout);
  }
  return layouts;
}

/// Created in advance, since their creation submits commands.
Status GpuTracer::MakeHardwarePipelines() {
  Result<std::vector<VkDescriptorSetLayout>> layouts = Layouts();
  STILLRAY_RETURN_IF_ERROR(layouts.status());
  const Result<VkDescriptorSetLayout> own = sets_.Layout(HardwareScene::kShape);
  STILLRAY_RETURN_IF_ERROR(own.status());
  layouts->push_back(*own);
  for (const auto& [shader, hardware] : {std::pair{kFindGuides, HardwareShader::kFindGuides},
                                         std::pair{kFindImages, HardwareShader::kFindImages},
                                         std::pair{kTraceShadows, HardwareShader::kTraceShadows},
                                         std::pair{kTraceNext, HardwareShader::kTraceNext}}) {
    if (shader == kFindImages && !parts_.images) {
      continue;
    }
    Result<std::unique_ptr<gpu::RayPipeline>> made =
        MakeHardwarePipeline(device_, hardware, *layouts, sizeof(GpuBatch), constants_);
    STILLRAY_RETURN_IF_ERROR(made.status());
    by_hardware_[shader] = std::move(*made);
  }
  return Status::Ok();
}

/// Records a barrier between all earlier writes and later accesses.
void GpuTracer::Wait(VkCommandBuffer commands) const {
  gpu::MemoryBarrier(
      device_->context(), commands, device_->context().shader_stages, VK_ACCESS_SHADER_WRITE_BIT,
      device_->context().shader_stages | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT,
      VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT);
}

void GpuTracer::Mark(VkCommandBuffer commands, const char* name) {
  if (times_ != nullptr) {
    times_->Mark(commands, name);
  }
}

Status GpuTracer::Bind(VkCommandBuffer commands, Shader shader, const GpuBatch& batch) {
  const gpu::DeviceContext& c = device_->context();
  std::optional<gpu::Pipeline>& pipeline = pipelines_[shader];
  if (!pipeline) {
    const Result<std::vector<VkDescriptorSetLayout>> layouts = Layouts();
    STILLRAY_RETURN_IF_ERROR(layouts.status());
    const ShaderCode code = CodeOf(shader);
    Result<gpu::Pipeline> made =
        gpu::Pipeline::Create(&c, {code.name, code.code, *layouts, sizeof(GpuBatch), constants_});
    STILLRAY_RETURN_IF_ERROR(made.status());
    pipeline = std::move(*made);
  }
  const std::array<VkDescriptorSet, 3> bound = {accel_->scene_set(), lights_->set(), set_};
  c.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->handle());
  c.vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->layout(), 0,
                             static_cast<uint32_t>(bound.size()), bound.data(), 0, nullptr);
  c.vk.CmdPushConstants(commands, pipeline->layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(batch),
                        &batch);
  return Status::Ok();
}

void GpuTracer::BindHardware(VkCommandBuffer commands, Shader shader, const GpuBatch& batch) const {
  const std::array<VkDescriptorSet, 4> bound = {accel_->scene_set(), lights_->set(), set_,
                                                accel_->hardware()->set()};
  by_hardware_[shader]->Bind(commands, bound, &batch, sizeof(batch));
}

/// Dispatches one thread per pixel of the batch, or a single thread for kAdvance.
Status GpuTracer::Dispatch(VkCommandBuffer commands, Shader shader, const GpuBatch& batch) {
  if (by_hardware_[shader] != nullptr) {
    BindHardware(commands, shader, batch);
    by_hardware_[shader]->Trace(commands, batch.count);
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(Bind(commands, shader, batch));
  const uint32_t groups = shader == kAdvance ? 1 : (batch.count + kGroupSize - 1) / kGroupSize;
  device_->context().vk.CmdDispatch(commands, groups, 1, 1);
  return Status::Ok();
}

Status GpuTracer::DispatchQueue(VkCommandBuffer commands, Shader shader, const GpuBatch& batch,
                                uint32_t queue) {
  if (by_hardware_[shader] != nullptr) {
    BindHardware(commands, shader, batch);
    if (device_->context().ray_tracing.indirect) {
      by_hardware_[shader]->TraceIndirect(
          commands,
          buffers_[kQueues]->address + queue * sizeof(GpuQueue) + offsetof(GpuQueue, count));
    } else {
      by_hardware_[shader]->Trace(commands, batch.count);  // threads beyond the queue return
    }
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(Bind(commands, shader, batch));
  device_->context().vk.CmdDispatchIndirect(commands, buffers_[kQueues]->buffer,
                                            queue * sizeof(GpuQueue));
  return Status::Ok();
}

void GpuTracer::RecordBegin(VkCommandBuffer commands, const GpuFrame& frame, bool resumes,
                            gpu::Timestamps* times) {
  const gpu::DeviceContext& c = device_->context();
  times_ = times;
  if (times_ != nullptr) {
    times_->Begin(commands);
  }
  gpu::MemoryBarrier(c, commands, c.shader_stages, VK_ACCESS_SHADER_WRITE_BIT,
                     VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT);
  c.vk.CmdUpdateBuffer(commands, buffers_[kFrame]->buffer, 0, sizeof(frame), &frame);
  const VkDeviceSize kept = resumes ? kQueueBytes : 0;
  c.vk.CmdFillBuffer(commands, buffers_[kQueues]->buffer, kept, buffers_[kQueues]->size - kept, 0);
  gpu::MemoryBarrier(
      c, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, c.shader_stages,
      VK_ACCESS_UNIFORM_READ_BIT | VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT);
}

void GpuTracer::RecordVisibility(VkCommandBuffer commands, const GpuFrame& frame) {
  Mark(commands, kTimeRaster);
  visibility_->Record(commands, {frame.view, frame.point});
}

Status GpuTracer::RecordGuides(VkCommandBuffer commands, const GpuBatch& batch) {
  Mark(commands, kTimeGuides);
  STILLRAY_RETURN_IF_ERROR(Dispatch(commands, kFindGuides, batch));
  Wait(commands);
  return Status::Ok();
}

Status GpuTracer::RecordImages(VkCommandBuffer commands, const GpuBatch& batch) {
  Mark(commands, kTimeImages);
  STILLRAY_RETURN_IF_ERROR(Dispatch(commands, kFindImages, batch));
  Wait(commands);
  return Status::Ok();
}

Status GpuTracer::RecordStart(VkCommandBuffer commands, GpuBatch batch, bool reference) {
  Mark(commands, kTimeGuides);
  STILLRAY_RETURN_IF_ERROR(Dispatch(commands, reference ? kStartReference : kStartPaths, batch));
  Wait(commands);
  batch.phase = kPhaseStart;
  STILLRAY_RETURN_IF_ERROR(Dispatch(commands, kAdvance, batch));
  Wait(commands);
  return Status::Ok();
}

/// Records the next hits of the paths that survive the step of GpuBatch::phase.
Status GpuTracer::RecordNextHits(VkCommandBuffer commands, const GpuBatch& batch) {
  const uint32_t next = kQueueActive + 1 - batch.phase;
  Mark(commands, kTimeBounces);
  STILLRAY_RETURN_IF_ERROR(DispatchQueue(commands, kTraceNext, batch, next));
  if (accel_->scene().with_media()) {
    Wait(commands);
    STILLRAY_RETURN_IF_ERROR(DispatchQueue(commands, kCrossMedia, batch, next));
  }
  Wait(commands);
  return Status::Ok();
}

/// Records the steps of the paths of GpuBatch::part from `first_step` on.
Status GpuTracer::RecordPart(VkCommandBuffer commands, GpuBatch batch, const SampleOptions& options,
                             int first_step) {
  for (int step = first_step; step < options.steps; ++step) {
    const auto parity = static_cast<uint32_t>(step % 2);
    const bool is_last = step + 1 == options.steps;
    const uint32_t end = !is_last                             ? 0
                         : options.steps < options.most_steps ? kPhaseMayStop
                                                              : kPhaseEnd;
    batch.phase = parity;
    Mark(commands, kTimeShade);
    STILLRAY_RETURN_IF_ERROR(DispatchQueue(commands, kShade, batch, kQueueActive + parity));
    Wait(commands);
    batch.phase = parity + end;
    STILLRAY_RETURN_IF_ERROR(Dispatch(commands, kAdvance, batch));
    Wait(commands);
    batch.phase = parity;
    Mark(commands, kTimeShadows);
    STILLRAY_RETURN_IF_ERROR(DispatchQueue(commands, kTraceShadows, batch, kQueueShadow + parity));
    if (is_last) {
      Wait(commands);
    } else {
      STILLRAY_RETURN_IF_ERROR(RecordNextHits(commands, batch));
    }
  }
  return Status::Ok();
}

/// Resumes paths that were unfinished after `steps` steps.
Status GpuTracer::RecordResumption(VkCommandBuffer commands, GpuBatch batch, int steps) {
  const auto parity = static_cast<uint32_t>(steps % 2);
  batch.phase = kPhaseResume + parity;
  STILLRAY_RETURN_IF_ERROR(Dispatch(commands, kAdvance, batch));
  Wait(commands);
  batch.phase = 1 - parity;
  return RecordNextHits(commands, batch);
}

Status GpuTracer::RecordSample(VkCommandBuffer commands, const GpuBatch& batch,
                               const SampleOptions& options) {
  GpuBatch of_part = batch;
  const uint32_t parts = options.separates ? 2 : 1;
  const auto resumed = static_cast<uint32_t>(options.resumed_part);
  for (of_part.part = resumed; of_part.part < parts; ++of_part.part) {
    const int done = of_part.part == resumed ? options.resumed_steps : 0;
    STILLRAY_RETURN_IF_ERROR(done > 0 ? RecordResumption(commands, of_part, done)
                                      : RecordStart(commands, of_part, options.reference));
    STILLRAY_RETURN_IF_ERROR(RecordPart(commands, of_part, options, done));
  }
  if (options.single) {
    return Status::Ok();
  }
  Mark(commands, kTimeShade);
  of_part.phase = options.first ? kPhaseFirstSample : kPhaseNextSample;
  STILLRAY_RETURN_IF_ERROR(
      Dispatch(commands, options.reference ? kAddReference : kAddSamples, of_part));
  Wait(commands);
  return Status::Ok();
}

void GpuTracer::RecordEnd(VkCommandBuffer commands, const GpuBatch& batch, const Results& copied) {
  const gpu::DeviceContext& c = device_->context();
  if (times_ != nullptr) {
    times_->End(commands);
    times_ = nullptr;
  }
  gpu::MemoryBarrier(c, commands, c.shader_stages, VK_ACCESS_SHADER_WRITE_BIT,
                     VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
  const auto copy = [&](const gpu::Buffer* from, const gpu::Buffer* to,
                        const VkBufferCopy& region) {
    c.vk.CmdCopyBuffer(commands, from->buffer, to->buffer, 1, &region);
  };
  if (copied.guides) {
    copy(buffers_[kGuides], host_guides_, {0, 0, batch.count * sizeof(GpuGuides)});
  }
  const size_t of_images = batch.count * sizeof(GpuImage);
  const size_t refractions = capacity_ * sizeof(GpuImage);
  if (copied.images.reflection) {
    copy(buffers_[kImages], host_images_, {0, 0, of_images});
  }
  if (copied.images.refraction) {
    copy(buffers_[kImages], host_images_, {refractions, refractions, of_images});
  }
  if (copied.sums) {
    copy(&device_sums(copied), host_sums_,
         {0, 0, batch.count * copied.signals * sizeof(GpuSignal)});
  }
  copy(buffers_[kQueues], host_counters_, {kQueueBytes, 0, sizeof(GpuCounters)});
  gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                     VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
}

}  // namespace stillray::render

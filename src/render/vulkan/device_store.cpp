// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/device_store.h"

#include <span>
#include <utility>
#include <vector>

#include "render/frame_store.h"

namespace stillray::render {

namespace shaders {
#define STILLRAY_SHADER(name)           \
  extern const std::uint32_t k##name[]; \
  extern const std::size_t k##name##Words;
STILLRAY_SHADER(StoreLight)
STILLRAY_SHADER(StoreMoments)
STILLRAY_SHADER(StoreListed)
STILLRAY_SHADER(StoreGuides)
STILLRAY_SHADER(StoreColours)
STILLRAY_SHADER(StorePreviousNormals)
STILLRAY_SHADER(StoreTransmission)
STILLRAY_SHADER(StoreVirtualGuides)
#undef STILLRAY_SHADER
}  // namespace shaders

namespace {

struct ShaderCode {
  const char* name;
  std::span<const uint32_t> code;
  uint32_t images;
  uint32_t buffers = 2;  ///< values, the list of pixels, and further inputs
};

/// In the order of DeviceStore's enumerators.
ShaderCode CodeOf(size_t shader) {
  const ShaderCode codes[] = {
      {"store_light", {shaders::kStoreLight, shaders::kStoreLightWords}, 2},
      {"store_light with moments", {shaders::kStoreMoments, shaders::kStoreMomentsWords}, 4},
      {"store_light of a list", {shaders::kStoreListed, shaders::kStoreListedWords}, 3},
      {"store_guides", {shaders::kStoreGuides, shaders::kStoreGuidesWords}, 5},
      {"store_guides of colours", {shaders::kStoreColours, shaders::kStoreColoursWords}, 4},
      {"store_guides of previous normals",
       {shaders::kStorePreviousNormals, shaders::kStorePreviousNormalsWords},
       1,
       3},
      {"store_guides of transmitted light",
       {shaders::kStoreTransmission, shaders::kStoreTransmissionWords},
       1},
      {"store_virtual_guides",
       {shaders::kStoreVirtualGuides, shaders::kStoreVirtualGuidesWords},
       5},
  };
  return codes[shader];
}

/// Maximum descriptor sets per frame: three for signals, four for guides, two for virtual guides.
constexpr uint32_t kMostSets = 9;
constexpr gpu::SetShape kMostDescriptors = {0, 3 * 4 + (5 + 4 + 1 + 1) + 2 * 5, 0,
                                            kMostSets * 2 + 1};

struct StorePush {
  GpuBatch batch;
  float scale;
  uint32_t signal_count;
  uint32_t first_signal;
  uint32_t first_image;
};

/// Number of signals per dispatch of store_light.
constexpr uint32_t kSignalPair = 2;

bool IsSparse(const RenderSettings& settings) {
  return settings.cycle > 1;
}

bool HasSparseGuides(const RenderSettings& settings) {
  return IsSparse(settings) && settings.guides == GuideCoverage::kSparse;
}

}  // namespace

Status DeviceStore::Begin(const RenderSettings& settings, bool previous_normals,
                          const ImageKinds& images, const RenderMoment& moment, Frame* frame) {
  settings_ = settings;
  begun_ = false;
  target_ = std::dynamic_pointer_cast<gpu::DeviceFrame>(std::exchange(frame->on_device, nullptr));
  const gpu::FrameShape shape = {.width = settings.width,
                                 .height = settings.height,
                                 .second_moments = settings.spp > 1,
                                 .samples = settings.spp > 1 || IsSparse(settings),
                                 .previous_normals = previous_normals,
                                 .reflection = images.reflection,
                                 .transmission = images.refraction};
  const bool suits = target_ != nullptr && target_.use_count() == 1 &&
                     target_->device() == device_ && target_->shape() == shape;
  if (!suits) {
    target_.reset();  // released first, since memory may not suffice for both
    Result<std::shared_ptr<gpu::DeviceFrame>> made = gpu::DeviceFrame::Create(device_, shape);
    const StatusCode code = made.status().code();
    if (code == StatusCode::kOutOfMemory || code == StatusCode::kInvalidArgument) {
      return Status::Ok();
    }
    STILLRAY_RETURN_IF_ERROR(made.status());
    target_ = std::move(*made);
  }
  if (!has_pool_) {
    STILLRAY_RETURN_IF_ERROR(sets_.CreatePool(kMostSets, kMostDescriptors));
    has_pool_ = true;
  }
  // Images and buffers of the tracer may have been recreated with identical handles.
  STILLRAY_RETURN_IF_ERROR(sets_.Clear());
  DescribeFrame(settings, moment, images.refraction, frame);
  return Status::Ok();
}

void DeviceStore::Clear(VkCommandBuffer commands, const gpu::Image* image, float value) const {
  VkClearColorValue colour = {};
  // Images have one channel or the value 0, whose bits also are the integer id 0.
  colour.float32[0] = value;
  const VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  device_->context().vk.CmdClearColorImage(commands, image->image, VK_IMAGE_LAYOUT_GENERAL, &colour,
                                           1, &all);
}

/// Ensures that every pixel of every image is written: pixels outside the batches are cleared.
void DeviceStore::RecordBegin(VkCommandBuffer commands) {
  begun_ = true;
  target_->RecordBegin(commands);
  const gpu::FrameImages& i = target_->images();
  if (settings_.spp > 1) {
    Clear(commands, i.samples, static_cast<float>(settings_.spp));
  }
  if (IsSparse(settings_)) {
    Clear(commands, i.samples, 0);
    for (const gpu::Image* light : target_->lights()) {
      Clear(commands, light, 0);
    }
  }
  if (HasSparseGuides(settings_)) {
    for (const gpu::Image* image : {i.depth, i.normal, i.albedo, i.specular_albedo, i.motion, i.id,
                                    i.roughness, i.emission, i.background}) {
      Clear(commands, image, 0);
    }
    if (i.previous_normal != nullptr) {
      Clear(commands, i.previous_normal, 0);
    }
  }
  gpu::MemoryBarrier(device_->context(), commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                     VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                     VK_ACCESS_SHADER_WRITE_BIT);
}

/// Runs a shader with one thread per pixel of the batch.
Status DeviceStore::Run(VkCommandBuffer commands, Shader shader,
                        std::vector<const gpu::Image*> images, const Source& source,
                        const GpuBatch& batch) {
  const gpu::DeviceContext& c = device_->context();
  const ShaderCode code = CodeOf(shader);
  const gpu::SetShape shape = {0, code.images, 0, code.buffers};
  std::optional<gpu::Pipeline>& pipeline = pipelines_[shader];
  if (!pipeline) {
    const Result<VkDescriptorSetLayout> layout = sets_.Layout(shape);
    STILLRAY_RETURN_IF_ERROR(layout.status());
    Result<gpu::Pipeline> made =
        gpu::Pipeline::Create(&c, {code.name, code.code, {&*layout, 1}, sizeof(StorePush), {}});
    STILLRAY_RETURN_IF_ERROR(made.status());
    pipeline = std::move(*made);
  }
  gpu::SetContent content;
  for (const gpu::Image* image : images) {
    content.images.push_back(image->view);
  }
  for (const gpu::Buffer* buffer : source.buffers) {
    content.buffers.push_back(buffer->buffer);
  }
  const Result<VkDescriptorSet> set = sets_.Find(shape, content);
  STILLRAY_RETURN_IF_ERROR(set.status());
  const StorePush push = {batch, 1.0f / static_cast<float>(settings_.spp),
                          static_cast<uint32_t>(target_->lights().size()), source.first_signal,
                          source.first_image};
  c.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->handle());
  c.vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->layout(), 0, 1,
                             &*set, 0, nullptr);
  c.vk.CmdPushConstants(commands, pipeline->layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(push),
                        &push);
  c.vk.CmdDispatch(commands, (batch.count + kGroupSize - 1) / kGroupSize, 1, 1);
  return Status::Ok();
}

Status DeviceStore::StoreGuides(VkCommandBuffer commands, const GpuTracer& tracer,
                                const gpu::Buffer& instances, const GpuBatch& batch) {
  const gpu::FrameImages& i = target_->images();
  const gpu::Buffer& listed = tracer.device_listed();
  const gpu::Buffer& values = tracer.device_guides();
  STILLRAY_RETURN_IF_ERROR(Run(commands, kStoreGuides,
                               {i.depth, i.normal, i.motion, i.id, i.roughness},
                               {{&values, &listed}}, batch));
  STILLRAY_RETURN_IF_ERROR(Run(commands, kStoreColours,
                               {i.albedo, i.specular_albedo, i.emission, i.background},
                               {{&values, &listed}}, batch));
  if (i.transmission_albedo != nullptr) {
    STILLRAY_RETURN_IF_ERROR(
        Run(commands, kStoreTransmission, {i.transmission_albedo}, {{&values, &listed}}, batch));
  }
  return i.previous_normal == nullptr ? Status::Ok()
                                      : Run(commands, kStorePreviousNormals, {i.previous_normal},
                                            {{&values, &listed, &instances}}, batch);
}

Status DeviceStore::StoreImages(VkCommandBuffer commands, const GpuTracer& tracer,
                                const GpuBatch& batch, const ImageKinds& kinds) {
  const gpu::FrameImages& i = target_->images();
  const auto store = [&](const gpu::VirtualImages& v, uint32_t first) {
    return Run(
        commands, kStoreVirtualGuides, {v.depth, v.normal, v.albedo, v.motion, v.id},
        {.buffers = {&tracer.device_images(), &tracer.device_listed()}, .first_image = first},
        batch);
  };
  if (kinds.reflection) {
    STILLRAY_RETURN_IF_ERROR(store(i.reflection, 0));
  }
  return kinds.refraction ? store(i.refraction, tracer.capacity()) : Status::Ok();
}

Status DeviceStore::StoreLight(VkCommandBuffer commands, const GpuTracer& tracer,
                               const gpu::Buffer& sums, const GpuBatch& batch) {
  const gpu::FrameImages& i = target_->images();
  for (uint32_t first = 0; first < target_->lights().size(); first += kSignalPair) {
    std::vector<const gpu::Image*> images = {i.lights[first], i.lights[first + 1]};
    Shader shader = kStoreLight;
    if (IsSparse(settings_)) {
      shader = kStoreListed;
      images.push_back(i.samples);
    } else if (settings_.spp > 1) {
      shader = kStoreMoments;
      images.push_back(i.second_moments[first]);
      images.push_back(i.second_moments[first + 1]);
    }
    STILLRAY_RETURN_IF_ERROR(
        Run(commands, shader, std::move(images),
            {.buffers = {&sums, &tracer.device_listed()}, .first_signal = first}, batch));
  }
  return Status::Ok();
}

Status DeviceStore::Record(VkCommandBuffer commands, GpuTracer* tracer,
                           const gpu::Buffer& instances, const GpuBatch& batch,
                           const GpuTracer::Results& stored) {
  tracer->Mark(commands, kTimeStore);
  if (!begun_) {
    RecordBegin(commands);
  }
  // Full frames have already stored the guides of pixels with a path.
  if (stored.guides && (batch.listed == 0 || HasSparseGuides(settings_))) {
    STILLRAY_RETURN_IF_ERROR(StoreGuides(commands, *tracer, instances, batch));
  }
  STILLRAY_RETURN_IF_ERROR(StoreImages(commands, *tracer, batch, stored.images));
  if (stored.sums) {
    STILLRAY_RETURN_IF_ERROR(StoreLight(commands, *tracer, tracer->device_sums(stored), batch));
  }
  target_->RecordEnd(commands);
  return Status::Ok();
}

Status DeviceStore::End(int64_t paths, Frame* frame) {
  if (!active()) {
    return Status::Ok();
  }
  if (!begun_) {  // a frame without any batch
    const gpu::FairLock lock = device_->Lock();
    const Result<VkCommandBuffer> commands = device_->Begin();
    STILLRAY_RETURN_IF_ERROR(commands.status());
    RecordBegin(*commands);
    target_->RecordEnd(*commands);
    STILLRAY_RETURN_IF_ERROR(device_->Run());
  }
  const int64_t pixels = int64_t{settings_.width} * settings_.height;
  target_->samples_per_pixel =
      static_cast<float>(static_cast<double>(paths) * settings_.spp / static_cast<double>(pixels));
  target_->has_incomplete_guides = HasSparseGuides(settings_) && paths < pixels;
  frame->on_device = std::exchange(target_, nullptr);
  return Status::Ok();
}

}  // namespace stillray::render

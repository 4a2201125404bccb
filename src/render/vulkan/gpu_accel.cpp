// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/gpu_accel.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "render/vulkan/device_arrays.h"

namespace stillray::render {
namespace shaders {
extern const std::uint32_t kFirstHits[];
extern const std::size_t kFirstHitsWords;
extern const std::uint32_t kTransmittance[];
extern const std::size_t kTransmittanceWords;
}  // namespace shaders

namespace {

constexpr uint32_t kGroupSize = 64;  // local_size_x of the shader
constexpr gpu::SetShape kBatchShape = {0, 0, 0, 2};
/// Maximum number of ray and hit buffer pairs in use.
constexpr uint32_t kMostBatches = 64;
/// Bindings of scene.glsl.
constexpr size_t kNodes = 0;
constexpr size_t kTriangles = 1;
constexpr size_t kPlacements = 2;
constexpr size_t kInstances = 3;
constexpr size_t kWords = 7;
/// Host arrays in the order of the bindings.
using Arrays = std::array<HostArray, GpuAccel::kSceneShape.buffers>;

Arrays ArraysOf(const GpuScene& scene) {
  return {
      MakeArray("BVH nodes", scene.nodes()),       MakeArray("triangles", scene.triangles()),
      MakeArray("placements", scene.placements()), MakeArray("instances", scene.instances()),
      MakeArray("materials", scene.materials()),   MakeArray("sizes of textures", scene.textures()),
      MakeArray("texels", scene.texels()),         MakeArray("vertices and indices", scene.words()),
      MakeArray("energy tables", scene.energies())};
}

/// Data that Update changes: a range of a binding's buffer.
struct MovingPart {
  size_t binding;
  const void* data;
  size_t offset;  // offset in the buffer
  size_t bytes;
};

template <typename T>
MovingPart MakePart(size_t binding, const std::vector<T>& values, size_t first, size_t count) {
  return {binding, values.data() + first, first * sizeof(T), count * sizeof(T)};
}

/// All dynamic ranges, in the order of the staging buffer; their sizes are constant.
std::array<MovingPart, 6> MovingParts(const GpuScene& scene) {
  const size_t node = scene.first_deforming_node();
  const size_t triangle = scene.first_deforming_triangle();
  return {
      MakePart(kNodes, scene.nodes(), 0, scene.top_node_count()),
      MakePart(kNodes, scene.nodes(), node, scene.nodes().size() - node),
      MakePart(kTriangles, scene.triangles(), triangle, scene.triangles().size() - triangle),
      MakePart(kWords, scene.words(), scene.first_deforming_word(), scene.deforming_word_count()),
      MakePart(kPlacements, scene.placements(), 0, scene.placements().size()),
      MakePart(kInstances, scene.instances(), 0, scene.instances().size())};
}

/// Maximum rays per launch of a ray tracing pipeline: the device's limit on the launch width.
uint64_t MostRaysOfALaunch(const gpu::DeviceContext& c) {
  return std::min<uint64_t>(
      c.ray_tracing.most_rays,
      uint64_t{c.limits.maxComputeWorkGroupCount[0]} * c.limits.maxComputeWorkGroupSize[0]);
}

}  // namespace

bool TracesByUnits(const gpu::DeviceInfo& info) {
  return info.is_gpu && info.ray_tracing.offered && info.ray_tracing.queries;
}

bool DrawsFirstHits(const gpu::DeviceInfo& info, FirstHits wanted) {
  const bool emulates = info.is_gpu && info.ray_tracing.offered && !info.ray_tracing.queries;
  return wanted == FirstHits::kDraw || (wanted == FirstHits::kAuto && !emulates);
}

bool SamplesTextures(const gpu::DeviceInfo& info, TextureWay wanted) {
  return wanted == TextureWay::kSampled || (wanted == TextureWay::kAuto && info.is_gpu);
}

Result<bool> UsesHardware(const gpu::Device& device, TracingWay way) {
  const bool offered = device.context().ray_tracing.offered;
  if (way == TracingWay::kHardware && !offered) {
    return Status::Unsupported(
        fmt::format("{}: the driver does not trace rays by hardware: it lacks "
                    "VK_KHR_ray_tracing_pipeline or what that needs",
                    device.info().name));
  }
  return way == TracingWay::kHardware || (way == TracingWay::kAuto && TracesByUnits(device.info()));
}

/// With kAuto, textures that do not fit into an image are read exactly.
Status GpuAccel::ChooseAtlas(const std::vector<Texture>& textures, TextureWay way) {
  if (textures.empty() || !SamplesTextures(device_->info(), way)) {
    return Status::Ok();
  }
  const VkPhysicalDeviceLimits& limits = device_->context().limits;
  Result<TextureAtlas> atlas = PlanAtlas(textures, static_cast<int>(limits.maxImageDimension2D),
                                         static_cast<int>(limits.maxImageArrayLayers));
  if (atlas.ok()) {
    atlas_ = std::move(*atlas);
  } else if (way == TextureWay::kSampled) {
    return Status::Unsupported(
        fmt::format("{}: {}", device_->info().name, atlas.status().message()));
  }
  return Status::Ok();
}

Status GpuAccel::CheckLimits() const {
  const VkPhysicalDeviceLimits& limits = device_->context().limits;
  const uint32_t needed = kSceneShape.buffers + kBatchShape.buffers +
                          (use_hardware_ ? HardwareScene::kShape.buffers : 0);
  const uint32_t offered =
      std::min(limits.maxPerStageDescriptorStorageBuffers, limits.maxDescriptorSetStorageBuffers);
  if (offered < needed) {
    return Status::Unsupported(
        fmt::format("{}: tracing rays needs {} storage buffers in a shader, the device offers {}",
                    device_->info().name, needed, offered));
  }
  return CheckArraySizes(*device_, ArraysOf(*scene_));
}

Status GpuAccel::AddBuffers() {
  // Minimum buffer size: no buffer is empty, and every structure fits.
  constexpr size_t kLeast = 256;
  const Arrays arrays = ArraysOf(*scene_);
  for (size_t i = 0; i < arrays.size(); ++i) {
    const VkBufferUsageFlags for_hardware =
        use_hardware_ && i == kTriangles ? HardwareScene::kTriangleUsage : 0;
    const Result<const gpu::Buffer*> buffer = arena_.AddBuffer(
        std::max(arrays[i].bytes, kLeast), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | for_hardware,
        gpu::BufferPlace::kDevice);
    if (!buffer.ok()) {
      return buffer.status();
    }
    buffers_[i] = *buffer;
  }
  const TextureAtlas atlas = atlas_.value_or(TextureAtlas());
  const Result<const gpu::Image*> image =
      arena_.AddTextures(atlas.width, atlas.height, atlas.layers);
  STILLRAY_RETURN_IF_ERROR(image.status());
  texture_image_ = *image;
  size_t moving = kLeast;
  for (const MovingPart& part : MovingParts(*scene_)) {
    moving += part.bytes;
  }
  const Result<const gpu::Buffer*> staging = arena_.AddBuffer(moving, 0, gpu::BufferPlace::kUpload);
  if (!staging.ok()) {
    return staging.status();
  }
  staging_ = *staging;
  return arena_.Allocate();
}

Status GpuAccel::MakePipelines() {
  const gpu::DeviceContext& c = device_->context();
  STILLRAY_RETURN_IF_ERROR(sets_.CreatePool(
      kMostBatches + 1, {.buffers = kSceneShape.buffers + kMostBatches * kBatchShape.buffers,
                         .textures = kSceneShape.textures}));
  const Result<VkDescriptorSetLayout> scene = sets_.Layout(kSceneShape);
  const Result<VkDescriptorSetLayout> batch = sets_.Layout(kBatchShape);
  if (!scene.ok() || !batch.ok()) {
    return scene.ok() ? batch.status() : scene.status();
  }
  const std::array<VkDescriptorSetLayout, 2> layouts = {*scene, *batch};
  Result<gpu::Pipeline> first_hits =
      gpu::Pipeline::Create(&c, {"first_hits",
                                 {shaders::kFirstHits, shaders::kFirstHitsWords},
                                 layouts,
                                 sizeof(uint32_t),
                                 constants_});
  Result<gpu::Pipeline> transmittance =
      gpu::Pipeline::Create(&c, {"transmittance",
                                 {shaders::kTransmittance, shaders::kTransmittanceWords},
                                 layouts,
                                 sizeof(uint32_t),
                                 constants_});
  if (!first_hits.ok() || !transmittance.ok()) {
    return first_hits.ok() ? transmittance.status() : first_hits.status();
  }
  first_hits_ = std::move(*first_hits);
  transmittance_ = std::move(*transmittance);
  gpu::SetContent content;
  for (const gpu::Buffer* buffer : buffers_) {
    content.buffers.push_back(buffer->buffer);
  }
  content.textures = {texture_image_->view, texture_image_->srgb_view};
  const Result<VkDescriptorSet> set = sets_.Find(kSceneShape, content);
  if (set.ok()) {
    scene_set_ = *set;
  }
  return set.status();
}

/// Creates the acceleration structures and the ray tracing pipelines.
Status GpuAccel::MakeHardware() {
  Result<std::unique_ptr<HardwareScene>> hardware =
      HardwareScene::Create(device_, *scene_, *buffers_[kTriangles]);
  STILLRAY_RETURN_IF_ERROR(hardware.status());
  hardware_ = std::move(*hardware);
  std::vector<VkDescriptorSetLayout> layouts;
  for (const gpu::SetShape& shape : {kSceneShape, kBatchShape, HardwareScene::kShape}) {
    const Result<VkDescriptorSetLayout> layout = sets_.Layout(shape);
    STILLRAY_RETURN_IF_ERROR(layout.status());
    layouts.push_back(*layout);
  }
  for (const auto& [shader, out] :
       {std::pair{HardwareShader::kFirstHits, &hardware_first_hits_},
        std::pair{HardwareShader::kTransmittance, &hardware_transmittance_}}) {
    Result<std::unique_ptr<gpu::RayPipeline>> pipeline =
        MakeHardwarePipeline(device_, shader, layouts, sizeof(uint32_t), constants_);
    STILLRAY_RETURN_IF_ERROR(pipeline.status());
    *out = std::move(*pipeline);
  }
  return Status::Ok();
}

gpu::MemoryUse GpuAccel::memory() const {
  gpu::MemoryUse use = arena_.Need();
  if (hardware_ != nullptr) {
    use += hardware_->memory();
  }
  return use;
}

void GpuAccel::FillStaging() {
  size_t offset = 0;
  for (const MovingPart& part : MovingParts(*scene_)) {
    if (part.bytes > 0) {
      std::memcpy(static_cast<char*>(staging_->mapped) + offset, part.data, part.bytes);
    }
    offset += part.bytes;
  }
}

Status GpuAccel::Update() {
  try {
    STILLRAY_RETURN_IF_ERROR(scene_->Update());
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("moving the instances of the BVH: out of memory");
  }
  FillStaging();
  if (hardware_ != nullptr) {
    STILLRAY_RETURN_IF_ERROR(hardware_->Update());
  }
  return arena_.Flush();
}

void GpuAccel::RecordUpdate(VkCommandBuffer commands) const {
  const gpu::DeviceContext& c = device_->context();
  gpu::MemoryBarrier(c, commands, c.shader_stages, 0, VK_PIPELINE_STAGE_TRANSFER_BIT, 0);
  size_t offset = 0;
  for (const MovingPart& part : MovingParts(*scene_)) {
    if (part.bytes > 0) {
      const VkBufferCopy region = {offset, part.offset, part.bytes};
      c.vk.CmdCopyBuffer(commands, staging_->buffer, buffers_[part.binding]->buffer, 1, &region);
    }
    offset += part.bytes;
  }
  gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                     c.shader_stages, VK_ACCESS_SHADER_READ_BIT);
  if (hardware_ != nullptr) {
    hardware_->RecordUpdate(commands);
  }
}

Status GpuAccel::Record(VkCommandBuffer commands, const gpu::Pipeline& pipeline,
                        const gpu::RayPipeline* by_hardware, const gpu::Buffer& rays,
                        const gpu::Buffer& results, size_t result_size, uint32_t count) {
  const gpu::DeviceContext& c = device_->context();
  if (rays.size < count * sizeof(GpuRay) || results.size < count * result_size) {
    return Status::InvalidArgument(
        fmt::format("tracing {} rays: buffers of {} and {} bytes were given, expected {} and {}",
                    count, rays.size, results.size, count * sizeof(GpuRay), count * result_size));
  }
  const uint32_t groups = (count + kGroupSize - 1) / kGroupSize;
  const uint32_t columns = std::min(groups, c.limits.maxComputeWorkGroupCount[0]);
  const uint32_t rows = groups == 0 ? 0 : (groups + columns - 1) / columns;
  const bool too_many = by_hardware != nullptr ? count > MostRaysOfALaunch(c)
                                               : rows > c.limits.maxComputeWorkGroupCount[1];
  if (std::max(rays.size, results.size) > c.limits.maxStorageBufferRange || too_many) {
    return Status::InvalidArgument(fmt::format(
        "tracing {} rays: buffers of {} and {} bytes were given, but {} reads storage "
        "buffers of at most {}",
        count, rays.size, results.size, device_->info().name, c.limits.maxStorageBufferRange));
  }
  const Result<VkDescriptorSet> set =
      sets_.Find(kBatchShape, {{}, {}, {rays.buffer, results.buffer}});
  if (!set.ok() || groups == 0) {
    return set.status();
  }
  if (by_hardware != nullptr) {
    const std::array<VkDescriptorSet, 3> bound = {scene_set_, *set, hardware_->set()};
    by_hardware->Bind(commands, bound, &count, sizeof(count));
    by_hardware->Trace(commands, count);
    return Status::Ok();
  }
  const std::array<VkDescriptorSet, 2> bound = {scene_set_, *set};
  c.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.handle());
  c.vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout(), 0,
                             static_cast<uint32_t>(bound.size()), bound.data(), 0, nullptr);
  c.vk.CmdPushConstants(commands, pipeline.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(count),
                        &count);
  c.vk.CmdDispatch(commands, columns, rows, 1);
  return Status::Ok();
}

Status GpuAccel::RecordFirstHits(VkCommandBuffer commands, const gpu::Buffer& rays,
                                 const gpu::Buffer& hits, uint32_t count) {
  return Record(commands, first_hits_, hardware_first_hits_.get(), rays, hits, sizeof(GpuHit),
                count);
}

Status GpuAccel::RecordTransmittance(VkCommandBuffer commands, const gpu::Buffer& rays,
                                     const gpu::Buffer& lights, uint32_t count) {
  return Record(commands, transmittance_, hardware_transmittance_.get(), rays, lights,
                3 * sizeof(float), count);
}

Result<std::unique_ptr<GpuAccel>> GpuAccel::Create(gpu::Device* device, const SceneState& state,
                                                   TracingWay way, TextureWay textures) {
  const Result<bool> use_hardware = UsesHardware(*device, way);
  STILLRAY_RETURN_IF_ERROR(use_hardware.status());
  std::unique_ptr<GpuAccel> accel(new GpuAccel(device));
  accel->use_hardware_ = *use_hardware;
  STILLRAY_RETURN_IF_ERROR(accel->ChooseAtlas(state.scene().textures, textures));
  Result<std::unique_ptr<GpuScene>> scene =
      GpuScene::Create(state, accel->atlas_ ? &*accel->atlas_ : nullptr);
  if (!scene.ok()) {
    return scene.status();
  }
  accel->scene_ = std::move(*scene);
  accel->constants_ = {accel->scene_->with_layers() ? 1u : 0u, accel->atlas_ ? 1u : 0u};
  STILLRAY_RETURN_IF_ERROR(accel->CheckLimits());
  STILLRAY_RETURN_IF_ERROR(accel->AddBuffers());
  accel->FillStaging();
  STILLRAY_RETURN_IF_ERROR(accel->arena_.Flush());
  STILLRAY_RETURN_IF_ERROR(UploadArrays(device, ArraysOf(*accel->scene_), accel->buffers_));
  STILLRAY_RETURN_IF_ERROR(UploadAtlas(device, state.scene().textures,
                                       accel->atlas_.value_or(TextureAtlas()),
                                       *accel->texture_image_));
  STILLRAY_RETURN_IF_ERROR(accel->MakePipelines());
  if (accel->use_hardware_) {
    STILLRAY_RETURN_IF_ERROR(accel->MakeHardware());
  }
  return accel;
}

}  // namespace stillray::render

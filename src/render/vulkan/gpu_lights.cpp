// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/gpu_lights.h"

#include <algorithm>
#include <cstring>
#include <new>

#include "render/vulkan/device_arrays.h"

namespace stillray::render {
namespace {

/// Bindings of lights.glsl.
enum Binding : size_t { kShapes, kEntries, kAreas, kFirstAreas, kPunctuals, kSums, kTexels };

/// Layout of the uniform block.
struct Shapes {
  EnvironmentShape environment;
  LightShape lights;
};

constexpr uint32_t kNoArea = 0xffffffffu;
/// Minimum buffer size: no buffer is empty, and every structure fits.
constexpr size_t kLeastBytes = 256;

std::vector<float> TexelsOf(const Environment& environment) {
  std::vector<float> texels;
  const Image3& map = environment.map;
  texels.reserve(3 * static_cast<size_t>(map.width()) * static_cast<size_t>(map.height()));
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        texels.push_back(map[c](x, y));
      }
    }
  }
  return texels;
}

std::vector<uint32_t> FirstAreasOf(const LightSet& lights) {
  std::vector<uint32_t> out;
  for (const int64_t first : lights.first_areas()) {
    out.push_back(first < 0 ? kNoArea : static_cast<uint32_t>(first));
  }
  return out;
}

/// Data that Update changes; array sizes are constant.
struct MovingPart {
  Binding binding;
  const void* data;
  size_t bytes;
};

std::array<MovingPart, 3> MovingArrays(const LightSet& lights) {
  return {
      MovingPart{kEntries, lights.entries().data(), lights.entries().size() * sizeof(AliasEntry)},
      MovingPart{kAreas, lights.areas().data(), lights.areas().size() * sizeof(AreaLight)},
      MovingPart{kPunctuals, lights.punctuals().data(),
                 lights.punctuals().size() * sizeof(PunctualSource)}};
}

}  // namespace

Status GpuLights::AddBuffers(const std::vector<float>& texels) {
  const size_t most_punctuals = lights_.most_punctuals();
  const size_t most_entries = lights_.areas().size() + most_punctuals;
  const std::array<size_t, kBufferCount> sizes = {
      sizeof(Shapes),
      most_entries * sizeof(AliasEntry),
      lights_.areas().size() * sizeof(AreaLight),
      lights_.first_areas().size() * sizeof(uint32_t),
      most_punctuals * sizeof(PunctualSource),
      lights_.environment().sums().size() * sizeof(float),
      texels.size() * sizeof(float)};
  for (size_t i = 0; i < sizes.size(); ++i) {
    const Result<const gpu::Buffer*> buffer = arena_.AddBuffer(
        std::max(sizes[i], kLeastBytes),
        i == kShapes ? VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
        gpu::BufferPlace::kDevice);
    STILLRAY_RETURN_IF_ERROR(buffer.status());
    buffers_[i] = *buffer;
  }
  const Result<const gpu::Buffer*> staging =
      arena_.AddBuffer(sizes[kShapes] + sizes[kEntries] + sizes[kAreas] + sizes[kPunctuals], 0,
                       gpu::BufferPlace::kUpload);
  STILLRAY_RETURN_IF_ERROR(staging.status());
  staging_ = *staging;
  return arena_.Allocate();
}

Status GpuLights::Update() {
  const Shapes shapes = {lights_.arrays().environment, lights_.arrays()};
  auto* to = static_cast<char*>(staging_->mapped);
  std::memcpy(to, &shapes, sizeof(shapes));
  to += sizeof(shapes);
  for (const MovingPart& part : MovingArrays(lights_)) {
    if (part.bytes > 0) {
      std::memcpy(to, part.data, part.bytes);
    }
    to += part.bytes;
  }
  return arena_.Flush();
}

void GpuLights::RecordUpdate(VkCommandBuffer commands) const {
  const gpu::DeviceContext& c = device_->context();
  gpu::MemoryBarrier(c, commands, c.shader_stages, 0, VK_PIPELINE_STAGE_TRANSFER_BIT, 0);
  size_t offset = 0;
  const auto copy = [&](Binding binding, size_t bytes) {
    if (bytes > 0) {
      const VkBufferCopy region = {offset, 0, bytes};
      c.vk.CmdCopyBuffer(commands, staging_->buffer, buffers_[binding]->buffer, 1, &region);
    }
    offset += bytes;
  };
  copy(kShapes, sizeof(Shapes));
  for (const MovingPart& part : MovingArrays(lights_)) {
    copy(part.binding, part.bytes);
  }
  gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                     c.shader_stages, VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_UNIFORM_READ_BIT);
}

Result<std::unique_ptr<GpuLights>> GpuLights::Create(gpu::Device* device, const LightSet& lights,
                                                     const Environment& environment) {
  try {
    std::unique_ptr<GpuLights> made(new GpuLights(device, lights));
    const std::vector<float> texels = TexelsOf(environment);
    const std::vector<uint32_t> first_areas = FirstAreasOf(lights);
    const std::array<HostArray, 5> arrays = {
        MakeArray("emissive triangles", lights.areas()), MakeArray("instances", first_areas),
        MakeArray("sums of the environment map", lights.environment().sums()),
        MakeArray("environment map", texels), MakeArray("lights", lights.entries())};
    STILLRAY_RETURN_IF_ERROR(CheckArraySizes(*device, arrays));
    STILLRAY_RETURN_IF_ERROR(made->AddBuffers(texels));
    const std::array<const gpu::Buffer*, 3> targets = {
        made->buffers_[kFirstAreas], made->buffers_[kSums], made->buffers_[kTexels]};
    STILLRAY_RETURN_IF_ERROR(
        UploadArrays(device, std::array{arrays[1], arrays[2], arrays[3]}, targets));
    const Result<VkDescriptorSet> set = made->sets_.CreateSingle(kShape, made->buffers_);
    STILLRAY_RETURN_IF_ERROR(set.status());
    made->set_ = *set;
    STILLRAY_RETURN_IF_ERROR(made->Update());
    return made;
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("arranging the lights for the GPU: out of memory");
  }
}

}  // namespace stillray::render

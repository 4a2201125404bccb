// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Runs a compute shader of a test: an array of inputs in, an array of results out.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <vector>

#include "gpu/device.h"
#include "gpu/memory.h"
#include "gpu/pipeline.h"

namespace stillray::render {

/// A shader with groups of 64 threads, and its sets in the order of their numbers: one of its own,
/// of the buffers of inputs and of results, and one of the scene or of the lights.
struct TestedShader {
  const char* name;
  std::span<const uint32_t> code;
  uint32_t own_set;  ///< 0 or 1
  gpu::SetShape other_shape;
  VkDescriptorSet other_set;
  std::span<const uint32_t> constants = {};
};

/// One thread for each input. \param begin  records what must happen before
template <typename Output, typename Input>
std::vector<Output> RunShader(
    gpu::Device* device, const TestedShader& shader, const std::vector<Input>& inputs,
    const std::function<void(VkCommandBuffer)>& begin = [](VkCommandBuffer) {}) {
  const gpu::DeviceContext& c = device->context();
  constexpr gpu::SetShape kShape = {.buffers = 2};
  gpu::Arena arena(&c);
  gpu::DescriptorSets sets(&c);
  const auto add = [&](size_t bytes, gpu::BufferPlace place) {
    return *arena.AddBuffer(bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, place);
  };
  const gpu::Buffer* const buffers[] = {
      add(inputs.size() * sizeof(Input), gpu::BufferPlace::kUpload),
      add(inputs.size() * sizeof(Output), gpu::BufferPlace::kDownload)};
  EXPECT_TRUE(arena.Allocate().ok());
  VkDescriptorSet bound[] = {shader.other_set, shader.other_set};
  bound[shader.own_set] = *sets.CreateSingle(kShape, buffers);
  VkDescriptorSetLayout layouts[2];
  layouts[shader.own_set] = *sets.Layout(kShape);
  layouts[1 - shader.own_set] = *sets.Layout(shader.other_shape);
  const Result<gpu::Pipeline> pipeline =
      gpu::Pipeline::Create(&c, {shader.name, shader.code, layouts, 0, shader.constants});
  EXPECT_TRUE(pipeline.ok()) << pipeline.status().message();
  std::memcpy(buffers[0]->mapped, inputs.data(), inputs.size() * sizeof(Input));
  EXPECT_TRUE(arena.Flush().ok());
  const VkCommandBuffer commands = *device->Begin();
  begin(commands);
  c.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->handle());
  c.vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->layout(), 0, 2,
                             bound, 0, nullptr);
  c.vk.CmdDispatch(commands, (static_cast<uint32_t>(inputs.size()) + 63) / 64, 1, 1);
  gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
                     VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
  EXPECT_TRUE(device->Run().ok());
  EXPECT_TRUE(arena.Invalidate().ok());
  std::vector<Output> outputs(inputs.size());
  std::memcpy(static_cast<void*>(outputs.data()), buffers[1]->mapped,
              outputs.size() * sizeof(Output));
  return outputs;
}

}  // namespace stillray::render

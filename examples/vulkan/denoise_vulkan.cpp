// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray within a renderer's Vulkan frame: a compute shader renders a noisy picture and its
// guides, and the denoiser filters it, both in one command buffer, without a copy.
//
//   denoise_vulkan [FOLDER]     writes noisy.ppm and denoised.ppm there; prints the errors of both
#include <vulkan/vulkan.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "noisy_scene.h"
#include "stillray/vulkan.hpp"

namespace {

constexpr uint32_t kWidth = 320;
constexpr uint32_t kHeight = 180;
constexpr int kFrames = 32;

void Check(VkResult result, const char* what) {
  if (result != VK_SUCCESS) {
    std::fprintf(stderr, "%s failed: %d\n", what, static_cast<int>(result));
    std::exit(result == VK_ERROR_INCOMPATIBLE_DRIVER ? 77 : 1);  // 77: nothing to run on
  }
}

/// The renderer's objects. It ends with the program, so that most are left to the device.
struct Renderer {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  uint32_t family = 0;
  VkCommandPool pool = VK_NULL_HANDLE;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkFence fence = VK_NULL_HANDLE;
};

void MakeDevice(Renderer* r) {
  VkApplicationInfo application = {};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.apiVersion = VK_API_VERSION_1_1;
  VkInstanceCreateInfo instance = {};
  instance.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  instance.pApplicationInfo = &application;
  Check(vkCreateInstance(&instance, nullptr, &r->instance), "vkCreateInstance");
  uint32_t count = 1;
  const VkResult found = vkEnumeratePhysicalDevices(r->instance, &count, &r->physical);
  Check(count == 0               ? VK_ERROR_INCOMPATIBLE_DRIVER
        : found == VK_INCOMPLETE ? VK_SUCCESS
                                 : found,
        "vkEnumeratePhysicalDevices");
  uint32_t families = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(r->physical, &families, nullptr);
  std::vector<VkQueueFamilyProperties> properties(families);
  vkGetPhysicalDeviceQueueFamilyProperties(r->physical, &families, properties.data());
  while (r->family < families && (properties[r->family].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0) {
    ++r->family;
  }
  const float priority = 1;
  VkDeviceQueueCreateInfo queue = {};
  queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
  queue.queueFamilyIndex = r->family;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkPhysicalDeviceFeatures features = {};
  features.shaderStorageImageExtendedFormats = VK_TRUE;  // the denoiser needs it
  VkDeviceCreateInfo device = {};
  device.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  device.queueCreateInfoCount = 1;
  device.pQueueCreateInfos = &queue;
  device.pEnabledFeatures = &features;
  Check(vkCreateDevice(r->physical, &device, nullptr, &r->device), "vkCreateDevice");
  vkGetDeviceQueue(r->device, r->family, 0, &r->queue);
  VkCommandPoolCreateInfo pool = {};
  pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = r->family;
  Check(vkCreateCommandPool(r->device, &pool, nullptr, &r->pool), "vkCreateCommandPool");
  VkCommandBufferAllocateInfo buffer = {};
  buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  buffer.commandPool = r->pool;
  buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  buffer.commandBufferCount = 1;
  Check(vkAllocateCommandBuffers(r->device, &buffer, &r->commands), "vkAllocateCommandBuffers");
  VkFenceCreateInfo fence = {};
  fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
  Check(vkCreateFence(r->device, &fence, nullptr, &r->fence), "vkCreateFence");
}

VkDeviceMemory Allocate(const Renderer& r, const VkMemoryRequirements& need,
                        VkMemoryPropertyFlags flags) {
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(r.physical, &memory);
  VkMemoryAllocateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  info.allocationSize = need.size;
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    if ((need.memoryTypeBits >> i & 1u) != 0 &&
        (memory.memoryTypes[i].propertyFlags & flags) == flags) {
      info.memoryTypeIndex = i;
      break;
    }
  }
  VkDeviceMemory made = VK_NULL_HANDLE;
  Check(vkAllocateMemory(r.device, &info, nullptr, &made), "vkAllocateMemory");
  return made;
}

struct Image {
  VkImage image = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
};

Image MakeImage(const Renderer& r, VkFormat format) {
  Image made;
  VkImageCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {kWidth, kHeight, 1};
  info.mipLevels = info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.usage =
      VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  Check(vkCreateImage(r.device, &info, nullptr, &made.image), "vkCreateImage");
  VkMemoryRequirements need;
  vkGetImageMemoryRequirements(r.device, made.image, &need);
  made.memory = Allocate(r, need, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  Check(vkBindImageMemory(r.device, made.image, made.memory, 0), "vkBindImageMemory");
  VkImageViewCreateInfo view = {};
  view.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
  view.image = made.image;
  view.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view.format = format;
  view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  Check(vkCreateImageView(r.device, &view, nullptr, &made.view), "vkCreateImageView");
  return made;
}

/// The outputs of the scene's shader, in the order of its bindings.
struct GBuffer {
  Image light, depth, normal, albedo, motion;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  VkDescriptorSet set = VK_NULL_HANDLE;
  VkPipelineLayout pipeline_layout = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;
};

GBuffer MakeGBuffer(const Renderer& r) {
  GBuffer g;
  g.light = MakeImage(r, VK_FORMAT_R16G16B16A16_SFLOAT);
  g.depth = MakeImage(r, VK_FORMAT_R32_SFLOAT);
  g.normal = MakeImage(r, VK_FORMAT_R16G16B16A16_SFLOAT);
  g.albedo = MakeImage(r, VK_FORMAT_R16G16B16A16_SFLOAT);
  g.motion = MakeImage(r, VK_FORMAT_R16G16_SFLOAT);
  const Image* images[] = {&g.light, &g.depth, &g.normal, &g.albedo, &g.motion};
  VkDescriptorSetLayoutBinding bindings[5];
  for (uint32_t i = 0; i < 5; ++i) {
    bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  }
  VkDescriptorSetLayoutCreateInfo layout = {};
  layout.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  layout.bindingCount = 5;
  layout.pBindings = bindings;
  Check(vkCreateDescriptorSetLayout(r.device, &layout, nullptr, &g.layout), "layout");
  const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 5};
  VkDescriptorPoolCreateInfo pool = {};
  pool.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
  pool.maxSets = 1;
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  Check(vkCreateDescriptorPool(r.device, &pool, nullptr, &g.pool), "vkCreateDescriptorPool");
  VkDescriptorSetAllocateInfo set = {};
  set.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
  set.descriptorPool = g.pool;
  set.descriptorSetCount = 1;
  set.pSetLayouts = &g.layout;
  Check(vkAllocateDescriptorSets(r.device, &set, &g.set), "vkAllocateDescriptorSets");
  for (uint32_t i = 0; i < 5; ++i) {
    const VkDescriptorImageInfo shown = {VK_NULL_HANDLE, images[i]->view, VK_IMAGE_LAYOUT_GENERAL};
    VkWriteDescriptorSet write = {};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = g.set;
    write.dstBinding = i;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    write.pImageInfo = &shown;
    vkUpdateDescriptorSets(r.device, 1, &write, 0, nullptr);
  }
  const VkPushConstantRange push = {VK_SHADER_STAGE_COMPUTE_BIT, 0, 8};
  VkPipelineLayoutCreateInfo pipeline_layout = {};
  pipeline_layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  pipeline_layout.setLayoutCount = 1;
  pipeline_layout.pSetLayouts = &g.layout;
  pipeline_layout.pushConstantRangeCount = 1;
  pipeline_layout.pPushConstantRanges = &push;
  Check(vkCreatePipelineLayout(r.device, &pipeline_layout, nullptr, &g.pipeline_layout), "layout");
  VkShaderModuleCreateInfo code = {};
  code.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  code.codeSize = sizeof(kNoisyScene);
  code.pCode = kNoisyScene;
  VkShaderModule module = VK_NULL_HANDLE;
  Check(vkCreateShaderModule(r.device, &code, nullptr, &module), "vkCreateShaderModule");
  VkComputePipelineCreateInfo pipeline = {};
  pipeline.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  pipeline.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  pipeline.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  pipeline.stage.module = module;
  pipeline.stage.pName = "main";
  pipeline.layout = g.pipeline_layout;
  Check(vkCreateComputePipelines(r.device, VK_NULL_HANDLE, 1, &pipeline, nullptr, &g.pipeline),
        "vkCreateComputePipelines");
  vkDestroyShaderModule(r.device, module, nullptr);
  return g;
}

void Barrier(VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags written,
             VkPipelineStageFlags to, VkAccessFlags read) {
  VkMemoryBarrier memory = {};
  memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  memory.srcAccessMask = written;
  memory.dstAccessMask = read;
  vkCmdPipelineBarrier(commands, from, to, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

void ToGeneral(VkCommandBuffer commands, const Image& image) {
  VkImageMemoryBarrier barrier = {};
  barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
  barrier.dstAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
  barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image.image;
  barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT,
                       VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 0, nullptr, 0, nullptr, 1,
                       &barrier);
}

/// Four halves per pixel, read by the host.
struct Readback {
  VkBuffer buffer = VK_NULL_HANDLE;
  const uint16_t* values = nullptr;
};

Readback MakeReadback(const Renderer& r) {
  Readback made;
  VkBufferCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = VkDeviceSize{kWidth} * kHeight * 8;
  info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  Check(vkCreateBuffer(r.device, &info, nullptr, &made.buffer), "vkCreateBuffer");
  VkMemoryRequirements need;
  vkGetBufferMemoryRequirements(r.device, made.buffer, &need);
  const VkDeviceMemory memory =
      Allocate(r, need, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  Check(vkBindBufferMemory(r.device, made.buffer, memory, 0), "vkBindBufferMemory");
  void* mapped = nullptr;
  Check(vkMapMemory(r.device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
  made.values = static_cast<const uint16_t*>(mapped);
  return made;
}

float HalfToFloat(uint16_t half) {
  const int exponent = half >> 10 & 31;
  const float fraction = static_cast<float>(half & 1023) / 1024.0f;
  const float size =
      exponent == 0 ? std::ldexp(fraction, -14) : std::ldexp(1.0f + fraction, exponent - 15);
  return (half & 0x8000) != 0 ? -size : size;
}

std::vector<float> Values(const Readback& readback) {
  std::vector<float> rgb;
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) {
    for (uint32_t c = 0; c < 3; ++c) {
      rgb.push_back(HalfToFloat(readback.values[4 * i + c]));
    }
  }
  return rgb;
}

double RmsError(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    sum += (static_cast<double>(a[i]) - b[i]) * (static_cast<double>(a[i]) - b[i]);
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

void WritePpm(const std::string& path, const std::vector<float>& rgb) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) {
    std::fprintf(stderr, "%s cannot be written\n", path.c_str());
    std::exit(1);
  }
  std::fprintf(file, "P6 %u %u 255\n", kWidth, kHeight);
  for (const float value : rgb) {
    std::fputc(static_cast<int>(255.0f * std::pow(std::fmin(value, 1.0f), 1 / 2.2f) + 0.5f), file);
  }
  std::fclose(file);
}

/// Records the scene, the filter and the copy of a picture; runs all and waits.
template <typename Record>
void RunFrame(const Renderer& r, const Record& record) {
  VkCommandBufferBeginInfo begin = {};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  Check(vkBeginCommandBuffer(r.commands, &begin), "vkBeginCommandBuffer");
  record(r.commands);
  Check(vkEndCommandBuffer(r.commands), "vkEndCommandBuffer");
  VkSubmitInfo submit = {};
  submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &r.commands;
  Check(vkQueueSubmit(r.queue, 1, &submit, r.fence), "vkQueueSubmit");
  Check(vkWaitForFences(r.device, 1, &r.fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  Check(vkResetFences(r.device, 1, &r.fence), "vkResetFences");
}

void RenderScene(const GBuffer& g, VkCommandBuffer commands, uint32_t frame, bool noisy) {
  const uint32_t push[] = {frame, noisy ? 1u : 0u};
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, g.pipeline);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, g.pipeline_layout, 0, 1, &g.set,
                          0, nullptr);
  vkCmdPushConstants(commands, g.pipeline_layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(push),
                     push);
  vkCmdDispatch(commands, (kWidth + 7) / 8, (kHeight + 7) / 8, 1);
}

void CopyOut(VkCommandBuffer commands, const Image& image, const Readback& readback) {
  Barrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
          VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
  VkBufferImageCopy region = {};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {kWidth, kHeight, 1};
  vkCmdCopyImageToBuffer(commands, image.image, VK_IMAGE_LAYOUT_GENERAL, readback.buffer, 1,
                         &region);
  Barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? std::string(argv[1]) + "/" : "";
  Renderer r;
  MakeDevice(&r);
  const GBuffer g = MakeGBuffer(r);
  const Image colour = MakeImage(r, VK_FORMAT_R16G16B16A16_SFLOAT);
  const Readback readback = MakeReadback(r);
  RunFrame(r, [&](VkCommandBuffer commands) {
    for (const Image* image : {&g.light, &g.depth, &g.normal, &g.albedo, &g.motion, &colour}) {
      ToGeneral(commands, *image);
    }
  });

  const stillray::VulkanContext context = {r.instance, r.physical, r.device,
                                           &vkGetInstanceProcAddr};
  stillray::VulkanOptions options;
  options.settings = stillray::PresetSettings("default").value();
  options.settings.signals = stillray::SignalGrouping::kSingle;
  options.width = kWidth;
  options.height = kHeight;
  const auto need = stillray::VulkanDenoiser::MemoryNeed(context, options);
  auto made = stillray::VulkanDenoiser::Create(context, options);
  if (!need.ok() || !made.ok()) {
    const std::string& message = need.ok() ? made.status().message() : need.status().message();
    std::fprintf(stderr, "%s\n", message.c_str());
    return 1;
  }
  stillray::VulkanDenoiser denoiser = std::move(made.value());
  std::printf("the denoiser takes %.1f MB in %u allocations\n",
              static_cast<double>(need->bytes) / 1e6, need->allocations);

  stillray::VulkanFrame frame;
  frame.lights[static_cast<int>(stillray::SignalKind::kDirectDiffuse)] = {g.light.view};
  frame.depth = {g.depth.view};
  frame.normal = {g.normal.view};
  frame.albedo = {g.albedo.view};
  frame.motion = {g.motion.view};
  frame.colour = {colour.view};
  frame.colour_is_half = true;
  std::vector<float> noisy;
  for (int i = 0; i < kFrames; ++i) {
    RunFrame(r, [&](VkCommandBuffer commands) {
      RenderScene(g, commands, static_cast<uint32_t>(i), true);
      Barrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
              VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT);
      frame.index = i;
      const stillray::Status recorded = denoiser.Record(commands, frame);
      if (!recorded.ok()) {
        std::fprintf(stderr, "%s\n", recorded.message().c_str());
        std::exit(1);
      }
      CopyOut(commands, colour, readback);
    });
  }
  const std::vector<float> denoised = Values(readback);
  RunFrame(r, [&](VkCommandBuffer commands) {
    RenderScene(g, commands, kFrames, true);
    CopyOut(commands, g.light, readback);
  });
  noisy = Values(readback);
  RunFrame(r, [&](VkCommandBuffer commands) {
    RenderScene(g, commands, 0, false);
    CopyOut(commands, g.light, readback);
  });
  const std::vector<float> clean = Values(readback);
  std::printf("rms error: noisy %.4f denoised %.4f\n", RmsError(noisy, clean),
              RmsError(denoised, clean));
  WritePpm(folder + "noisy.ppm", noisy);
  WritePpm(folder + "denoised.ppm", denoised);
  return 0;
}

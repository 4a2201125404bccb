// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray within a renderer's Vulkan frame: a compute shader renders a noisy image and its guides,
// and the denoiser filters it, both in one command buffer, without a copy. Three frames are in
// flight, including during changes of the resolution.
//
//   denoise_vulkan [FOLDER]     writes noisy.ppm and denoised.ppm there; prints the errors of both,
//                               and those around the changes of the resolution
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

// The largest frame; images have this size.
constexpr uint32_t kWidth = 320;
constexpr uint32_t kHeight = 180;
constexpr int kFrames = 64;
constexpr int kInFlight = 3;

struct Size {
  uint32_t width;
  uint32_t height;
};

/// Dynamic resolution: frames 24 to 39 are smaller.
constexpr int kSmaller = 24;
constexpr int kLargeAgain = 40;
Size SizeOf(int frame) {
  return frame >= kSmaller && frame < kLargeAgain ? Size{256, 144} : Size{kWidth, kHeight};
}

void Check(VkResult result, const char* what) {
  if (result != VK_SUCCESS) {
    std::fprintf(stderr, "%s failed: %d\n", what, static_cast<int>(result));
    std::exit(result == VK_ERROR_INCOMPATIBLE_DRIVER ? 77 : 1);  // 77: skipped, no device
  }
}

/// The renderer's Vulkan objects. Most are not destroyed, since the program ends with the renderer.
struct Renderer {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  uint32_t family = 0;
  VkCommandPool pool = VK_NULL_HANDLE;
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
  features.shaderStorageImageExtendedFormats = VK_TRUE;  // required by the denoiser
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

constexpr uint32_t kGuides = 5;

/// The shader that renders the scene.
struct Scene {
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  VkPipelineLayout pipeline_layout = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;
};

struct ScenePush {
  uint32_t frame;
  uint32_t noisy;
  Size size;
};

Scene MakeScene(const Renderer& r) {
  Scene scene;
  VkDescriptorSetLayoutBinding bindings[kGuides];
  for (uint32_t i = 0; i < kGuides; ++i) {
    bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  }
  VkDescriptorSetLayoutCreateInfo layout = {};
  layout.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  layout.bindingCount = kGuides;
  layout.pBindings = bindings;
  Check(vkCreateDescriptorSetLayout(r.device, &layout, nullptr, &scene.layout), "layout");
  const VkPushConstantRange push = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(ScenePush)};
  VkPipelineLayoutCreateInfo pipeline_layout = {};
  pipeline_layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  pipeline_layout.setLayoutCount = 1;
  pipeline_layout.pSetLayouts = &scene.layout;
  pipeline_layout.pushConstantRangeCount = 1;
  pipeline_layout.pPushConstantRanges = &push;
  Check(vkCreatePipelineLayout(r.device, &pipeline_layout, nullptr, &scene.pipeline_layout),
        "layout");
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
  pipeline.layout = scene.pipeline_layout;
  Check(vkCreateComputePipelines(r.device, VK_NULL_HANDLE, 1, &pipeline, nullptr, &scene.pipeline),
        "vkCreateComputePipelines");
  vkDestroyShaderModule(r.device, module, nullptr);
  return scene;
}

/// The outputs of the scene's shader, in the order of its bindings.
struct GBuffer {
  Image light, depth, normal, albedo, motion;
  VkDescriptorSet set = VK_NULL_HANDLE;
};

GBuffer MakeGBuffer(const Renderer& r, const Scene& scene) {
  GBuffer g;
  g.light = MakeImage(r, VK_FORMAT_R16G16B16A16_SFLOAT);
  g.depth = MakeImage(r, VK_FORMAT_R32_SFLOAT);
  g.normal = MakeImage(r, VK_FORMAT_R16G16B16A16_SFLOAT);
  g.albedo = MakeImage(r, VK_FORMAT_R16G16B16A16_SFLOAT);
  g.motion = MakeImage(r, VK_FORMAT_R16G16_SFLOAT);
  const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, kGuides};
  VkDescriptorPoolCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
  info.maxSets = 1;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  Check(vkCreateDescriptorPool(r.device, &info, nullptr, &pool), "vkCreateDescriptorPool");
  VkDescriptorSetAllocateInfo set = {};
  set.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
  set.descriptorPool = pool;
  set.descriptorSetCount = 1;
  set.pSetLayouts = &scene.layout;
  Check(vkAllocateDescriptorSets(r.device, &set, &g.set), "vkAllocateDescriptorSets");
  const Image* images[kGuides] = {&g.light, &g.depth, &g.normal, &g.albedo, &g.motion};
  for (uint32_t i = 0; i < kGuides; ++i) {
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

/// Readback buffer with four halves per pixel of a frame.
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

std::vector<float> Values(const Readback& readback, Size size) {
  std::vector<float> rgb;
  for (uint32_t i = 0; i < size.width * size.height; ++i) {
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

/// A frame in flight, with separate images.
struct Flight {
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkFence fence = VK_NULL_HANDLE;
  GBuffer guides;
  Image colour;
  Readback readback;
  int frame = -1;  ///< number of the unfinished frame; -1: none
};

void Begin(const Flight& flight) {
  VkCommandBufferBeginInfo begin = {};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  Check(vkBeginCommandBuffer(flight.commands, &begin), "vkBeginCommandBuffer");
}

void Submit(const Renderer& r, const Flight& flight) {
  Check(vkEndCommandBuffer(flight.commands), "vkEndCommandBuffer");
  VkSubmitInfo submit = {};
  submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &flight.commands;
  Check(vkQueueSubmit(r.queue, 1, &submit, flight.fence), "vkQueueSubmit");
}

void Wait(const Renderer& r, const Flight& flight) {
  Check(vkWaitForFences(r.device, 1, &flight.fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  Check(vkResetFences(r.device, 1, &flight.fence), "vkResetFences");
}

Flight MakeFlight(const Renderer& r, const Scene& scene) {
  Flight flight;
  VkCommandBufferAllocateInfo buffer = {};
  buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  buffer.commandPool = r.pool;
  buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  buffer.commandBufferCount = 1;
  Check(vkAllocateCommandBuffers(r.device, &buffer, &flight.commands), "vkAllocateCommandBuffers");
  VkFenceCreateInfo fence = {};
  fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
  Check(vkCreateFence(r.device, &fence, nullptr, &flight.fence), "vkCreateFence");
  flight.guides = MakeGBuffer(r, scene);
  flight.colour = MakeImage(r, VK_FORMAT_R16G16B16A16_SFLOAT);
  flight.readback = MakeReadback(r);
  const GBuffer& g = flight.guides;
  Begin(flight);
  for (const Image& image : {g.light, g.depth, g.normal, g.albedo, g.motion, flight.colour}) {
    ToGeneral(flight.commands, image);
  }
  Submit(r, flight);
  Wait(r, flight);
  return flight;
}

void RenderScene(const Scene& scene, const Flight& flight, const ScenePush& push) {
  vkCmdBindPipeline(flight.commands, VK_PIPELINE_BIND_POINT_COMPUTE, scene.pipeline);
  vkCmdBindDescriptorSets(flight.commands, VK_PIPELINE_BIND_POINT_COMPUTE, scene.pipeline_layout, 0,
                          1, &flight.guides.set, 0, nullptr);
  vkCmdPushConstants(flight.commands, scene.pipeline_layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                     sizeof(push), &push);
  vkCmdDispatch(flight.commands, (push.size.width + 7) / 8, (push.size.height + 7) / 8, 1);
}

void CopyOut(const Flight& flight, const Image& image, Size size) {
  Barrier(flight.commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
          VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
  VkBufferImageCopy region = {};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {size.width, size.height, 1};
  vkCmdCopyImageToBuffer(flight.commands, image.image, VK_IMAGE_LAYOUT_GENERAL,
                         flight.readback.buffer, 1, &region);
  Barrier(flight.commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
}

/// Renders the scene without the denoiser.
std::vector<float> Light(const Renderer& r, const Scene& scene, const Flight& flight,
                         const ScenePush& push) {
  Begin(flight);
  RenderScene(scene, flight, push);
  CopyOut(flight, flight.guides.light, push.size);
  Submit(r, flight);
  Wait(r, flight);
  return Values(flight.readback, push.size);
}

void RecordFrame(const Scene& scene, const Flight& flight, int index,
                 stillray::VulkanDenoiser* denoiser) {
  const Size size = SizeOf(index);
  RenderScene(scene, flight, {static_cast<uint32_t>(index), 1, size});
  Barrier(flight.commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
          VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT);
  const GBuffer& g = flight.guides;
  stillray::VulkanFrame frame;
  frame.index = index;
  frame.width = static_cast<int>(size.width);
  frame.height = static_cast<int>(size.height);
  frame.lights[static_cast<int>(stillray::SignalKind::kDirectDiffuse)] = {g.light.view};
  frame.depth = {g.depth.view};
  frame.normal = {g.normal.view};
  frame.albedo = {g.albedo.view};
  frame.motion = {g.motion.view};
  frame.colour = {flight.colour.view};
  frame.colour_is_half = true;
  const stillray::Status recorded = denoiser->Record(flight.commands, frame);
  if (!recorded.ok()) {
    std::fprintf(stderr, "%s\n", recorded.message().c_str());
    std::exit(1);
  }
  CopyOut(flight, flight.colour, size);
}

stillray::VulkanDenoiser MakeDenoiser(const Renderer& r) {
  const stillray::VulkanContext context = {r.instance, r.physical, r.device,
                                           &vkGetInstanceProcAddr};
  stillray::VulkanOptions options;
  options.settings = stillray::PresetSettings("default").value();
  options.settings.signals = stillray::SignalGrouping::kSingle;
  options.width = kWidth;
  options.height = kHeight;
  options.frames_in_flight = kInFlight;
  const auto need = stillray::VulkanDenoiser::MemoryNeed(context, options);
  auto made = stillray::VulkanDenoiser::Create(context, options);
  if (!need.ok() || !made.ok()) {
    const std::string& message = need.ok() ? made.status().message() : need.status().message();
    std::fprintf(stderr, "%s\n", message.c_str());
    std::exit(1);
  }
  std::printf("the denoiser takes %.1f MB in %u allocations\n",
              static_cast<double>(need->bytes) / 1e6, need->allocations);
  return std::move(made.value());
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? std::string(argv[1]) + "/" : "";
  Renderer r;
  MakeDevice(&r);
  const Scene scene = MakeScene(r);
  std::vector<Flight> flights;
  for (int i = 0; i < kInFlight; ++i) {
    flights.push_back(MakeFlight(r, scene));
  }
  stillray::VulkanDenoiser denoiser = MakeDenoiser(r);
  std::vector<std::vector<float>> pictures(kFrames);
  for (int i = 0; i < kFrames + kInFlight; ++i) {
    Flight& flight = flights[static_cast<size_t>(i % kInFlight)];
    if (flight.frame >= 0) {  // waits for the oldest frame in flight, whose images are then reused
      Wait(r, flight);
      pictures[static_cast<size_t>(flight.frame)] = Values(flight.readback, SizeOf(flight.frame));
      flight.frame = -1;
    }
    if (i < kFrames) {
      flight.frame = i;
      Begin(flight);
      RecordFrame(scene, flight, i, &denoiser);
      Submit(r, flight);
    }
  }
  const auto clean = [&](Size size) { return Light(r, scene, flights[0], {0, 0, size}); };
  for (const int i : {0, kSmaller - 1, kSmaller, kLargeAgain - 1, kLargeAgain}) {
    const Size size = SizeOf(i);
    std::printf("frame %d, %ux%u: rms %.4f\n", i, size.width, size.height,
                RmsError(pictures[static_cast<size_t>(i)], clean(size)));
  }
  const Size size = {kWidth, kHeight};
  const std::vector<float> noisy = Light(r, scene, flights[0], {kFrames, 1, size});
  std::printf("rms error: noisy %.4f denoised %.4f\n", RmsError(noisy, clean(size)),
              RmsError(pictures.back(), clean(size)));
  WritePpm(folder + "noisy.ppm", noisy);
  WritePpm(folder + "denoised.ppm", pictures.back());
  return 0;
}

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The filter as an engine without the library runs it: from nothing but the files of a pack of
/// `stillray shaders`. Memory and functions of Vulkan are those of the test's device.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "gpu/memory.h"

namespace stillray::test {

/// The caller's image of each name.
using PackImages = std::map<std::string, VkImageView>;

class PackedFilter {
 public:
  using Json = nlohmann::json;
  /// Bits of members of parameters, by their buffers.
  using Values = std::map<std::string, std::map<std::string, uint32_t>>;

  PackedFilter(const gpu::DeviceContext* context, const std::filesystem::path& folder)
      : c_(*context), arena_(context), folder_(folder) {
    table_ = Json::parse(std::ifstream(folder / "shaders.json"));
    frames_ = Json::parse(std::ifstream(folder / "frames.json"));
    MakeResources();
    MakePool();
  }
  PackedFilter(const PackedFilter&) = delete;
  PackedFilter& operator=(const PackedFilter&) = delete;

  ~PackedFilter() {
    for (const auto& [key, pipeline] : pipelines_) {
      c_.vk.DestroyPipeline(c_.device, pipeline.handle, nullptr);
      c_.vk.DestroyPipelineLayout(c_.device, pipeline.layout, nullptr);
      for (const VkDescriptorSetLayout set : pipeline.sets) {
        c_.vk.DestroyDescriptorSetLayout(c_.device, set, nullptr);
      }
    }
    c_.vk.DestroyDescriptorPool(c_.device, pool_, nullptr);
  }

  const Json& frames() const { return frames_; }
  size_t pipelines() const { return pipelines_.size(); }

  /// Records frame n, or frame 0 to begin anew.
  /// \param parameters  values of members that differ from those of the pack
  void Record(VkCommandBuffer commands, size_t n, const PackImages& own, const Values& parameters) {
    const size_t from = frames_["repeats_from"];
    const size_t period = frames_["period"];
    const size_t index = n < from ? n : from + (n - from) % period;
    for (const Json& command : frames_["frames"][index]) {
      const std::string kind = command["command"];
      if (kind == "dispatch") {
        Dispatch(commands, command, own);
      } else if (kind == "barrier") {
        Barrier(commands, command, {});
      } else if (kind == "transition") {
        // Once; later the last frame may still read what this one writes.
        Barrier(commands, has_begun_ ? AnyBarrier() : command,
                has_begun_ ? Json::array() : command["images"]);
      } else if (kind == "fill") {
        c_.vk.CmdFillBuffer(commands, buffers_.at(command["buffer"])->buffer, command["offset"],
                            command["bytes"], command["value"]);
      } else {
        ASSERT_EQ(kind, "update");
        Update(commands, command, parameters);
      }
    }
    has_begun_ = true;
  }

 private:
  struct Pipeline {
    VkPipeline handle = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    std::vector<VkDescriptorSetLayout> sets;
  };

  const Json& AnyBarrier() const {
    const Json& commands = frames_["frames"][0];
    return *std::find_if(commands.begin(), commands.end(),
                         [](const Json& command) { return command["command"] == "barrier"; });
  }

  static VkFormat FormatOf(const std::string& name) {
    const std::map<std::string, VkFormat> formats = {
        {"R8G8B8A8_UNORM", VK_FORMAT_R8G8B8A8_UNORM},
        {"R16_UNORM", VK_FORMAT_R16_UNORM},
        {"R16_SFLOAT", VK_FORMAT_R16_SFLOAT},
        {"R16G16B16A16_SFLOAT", VK_FORMAT_R16G16B16A16_SFLOAT},
        {"R32_UINT", VK_FORMAT_R32_UINT},
        {"R32_SFLOAT", VK_FORMAT_R32_SFLOAT},
        {"R32G32_SFLOAT", VK_FORMAT_R32G32_SFLOAT},
        {"R32G32_UINT", VK_FORMAT_R32G32_UINT},
        {"R32G32B32A32_UINT", VK_FORMAT_R32G32B32A32_UINT},
        {"R32G32B32A32_SFLOAT", VK_FORMAT_R32G32B32A32_SFLOAT}};
    return formats.at(name);
  }

  static std::vector<std::byte> BytesOf(const std::string& hex) {
    std::vector<std::byte> bytes;
    for (size_t i = 0; i + 1 < hex.size(); i += 2) {
      bytes.push_back(static_cast<std::byte>(std::stoi(hex.substr(i, 2), nullptr, 16)));
    }
    return bytes;
  }

  static VkPipelineStageFlags StagesOf(const Json& names) {
    VkPipelineStageFlags stages = 0;
    for (const std::string name : names) {
      stages |= name == "TOP_OF_PIPE"      ? VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT
                : name == "COMPUTE_SHADER" ? VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT
                                           : VK_PIPELINE_STAGE_TRANSFER_BIT;
    }
    return stages;
  }

  static VkAccessFlags AccessOf(const Json& names) {
    const std::map<std::string, VkAccessFlagBits> bits = {
        {"SHADER_READ", VK_ACCESS_SHADER_READ_BIT},
        {"SHADER_WRITE", VK_ACCESS_SHADER_WRITE_BIT},
        {"UNIFORM_READ", VK_ACCESS_UNIFORM_READ_BIT},
        {"TRANSFER_READ", VK_ACCESS_TRANSFER_READ_BIT},
        {"TRANSFER_WRITE", VK_ACCESS_TRANSFER_WRITE_BIT}};
    VkAccessFlags access = 0;
    for (const std::string name : names) {
      access |= bits.at(name);
    }
    return access;
  }

  void MakeResources() {
    for (const Json& image : frames_["images"]) {
      const std::string role = image["role"];
      if (role != "input" && role != "output") {
        images_[image["name"]] = arena_
                                     .AddImage(FormatOf(image["format"]), image["width"],
                                               image["height"], image["layers"])
                                     .value();
      }
    }
    for (const Json& buffer : frames_["buffers"]) {
      const bool uniform = buffer["name"].get<std::string>().ends_with("parameters");
      buffers_[buffer["name"]] = arena_
                                     .AddBuffer(buffer["bytes"],
                                                uniform ? VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT
                                                        : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                                gpu::BufferPlace::kDevice)
                                     .value();
    }
    const Status allocated = arena_.Allocate();
    ASSERT_TRUE(allocated.ok()) << allocated.message();
  }

  void MakePool() {
    constexpr uint32_t kMost = 4096;  // two for each dispatch
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 32 * kMost},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 8 * kMost},
                                          {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, kMost},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 4 * kMost}};
    VkDescriptorPoolCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    info.maxSets = kMost;
    info.poolSizeCount = static_cast<uint32_t>(std::size(sizes));
    info.pPoolSizes = sizes;
    ASSERT_EQ(c_.vk.CreateDescriptorPool(c_.device, &info, nullptr, &pool_), VK_SUCCESS);
  }

  const Json& ShaderOf(const std::string& name) const {
    for (const Json& shader : table_["shaders"]) {
      if (shader["name"] == name) {
        return shader;
      }
    }
    throw std::runtime_error("the table has no shader " + name);
  }

  /// Types of the bindings of a set, from 0 on.
  static std::vector<VkDescriptorType> TypesOf(const Json& set) {
    std::vector<VkDescriptorType> types;
    for (const auto& [name, type] :
         {std::pair{"sampled_images", VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE},
          std::pair{"storage_images", VK_DESCRIPTOR_TYPE_STORAGE_IMAGE},
          std::pair{"uniform_buffers", VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
          std::pair{"storage_buffers", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}}) {
      types.insert(types.end(), set[name].get<size_t>(), type);
    }
    return types;
  }

  VkDescriptorSetLayout MakeLayout(const Json& set) const {
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (const VkDescriptorType type : TypesOf(set)) {
      bindings.push_back(
          {static_cast<uint32_t>(bindings.size()), type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    }
    VkDescriptorSetLayoutCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    info.bindingCount = static_cast<uint32_t>(bindings.size());
    info.pBindings = bindings.data();
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    EXPECT_EQ(c_.vk.CreateDescriptorSetLayout(c_.device, &info, nullptr, &layout), VK_SUCCESS);
    return layout;
  }

  VkShaderModule LoadModule(const std::string& file) const {
    std::ifstream stream(folder_ / file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    std::vector<uint32_t> words(bytes.size() / sizeof(uint32_t));
    std::memcpy(words.data(), bytes.data(), bytes.size());
    VkShaderModuleCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    info.codeSize = bytes.size();
    info.pCode = words.data();
    VkShaderModule module = VK_NULL_HANDLE;
    EXPECT_EQ(c_.vk.CreateShaderModule(c_.device, &info, nullptr, &module), VK_SUCCESS);
    return module;
  }

  const Pipeline& Find(const Json& command) {
    const std::string key = command["shader"].get<std::string>() + command["constants"].dump();
    const auto known = pipelines_.find(key);
    if (known != pipelines_.end()) {
      return known->second;
    }
    const Json& shader = ShaderOf(command["shader"]);
    Pipeline made;
    for (const Json& set : shader["sets"]) {
      made.sets.push_back(MakeLayout(set));
    }
    const VkPushConstantRange push = {VK_SHADER_STAGE_COMPUTE_BIT, 0, shader["push_bytes"]};
    VkPipelineLayoutCreateInfo layout = {};
    layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    layout.setLayoutCount = static_cast<uint32_t>(made.sets.size());
    layout.pSetLayouts = made.sets.data();
    layout.pushConstantRangeCount = push.size > 0 ? 1 : 0;
    layout.pPushConstantRanges = &push;
    EXPECT_EQ(c_.vk.CreatePipelineLayout(c_.device, &layout, nullptr, &made.layout), VK_SUCCESS);
    made.handle = MakePipeline(command, shader, made.layout);
    return pipelines_.emplace(key, std::move(made)).first->second;
  }

  VkPipeline MakePipeline(const Json& command, const Json& shader, VkPipelineLayout layout) const {
    std::vector<VkSpecializationMapEntry> entries;
    std::vector<uint32_t> values;
    for (const Json& constant : command["constants"]) {
      const auto offset = static_cast<uint32_t>(values.size() * sizeof(uint32_t));
      entries.push_back({constant["id"], offset, sizeof(uint32_t)});
      values.push_back(constant["value"]);
    }
    const VkSpecializationInfo constants = {static_cast<uint32_t>(entries.size()), entries.data(),
                                            values.size() * sizeof(uint32_t), values.data()};
    VkComputePipelineCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = LoadModule(shader["file"]);
    info.stage.pName = "main";
    info.stage.pSpecializationInfo = &constants;
    info.layout = layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    EXPECT_EQ(c_.vk.CreateComputePipelines(c_.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
              VK_SUCCESS);
    c_.vk.DestroyShaderModule(c_.device, info.stage.module, nullptr);
    return pipeline;
  }

  VkDescriptorSet MakeSet(const Json& shape, VkDescriptorSetLayout layout, const Json& resources,
                          const PackImages& own) const {
    VkDescriptorSetAllocateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    info.descriptorPool = pool_;
    info.descriptorSetCount = 1;
    info.pSetLayouts = &layout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    EXPECT_EQ(c_.vk.AllocateDescriptorSets(c_.device, &info, &set), VK_SUCCESS);
    const std::vector<VkDescriptorType> types = TypesOf(shape);
    EXPECT_EQ(types.size(), resources.size());
    for (uint32_t i = 0; i < types.size(); ++i) {
      const std::string name = resources[i];
      VkWriteDescriptorSet write = {};
      write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
      write.dstSet = set;
      write.dstBinding = i;
      write.descriptorCount = 1;
      write.descriptorType = types[i];
      VkDescriptorImageInfo image = {VK_NULL_HANDLE, VK_NULL_HANDLE, VK_IMAGE_LAYOUT_GENERAL};
      VkDescriptorBufferInfo buffer = {VK_NULL_HANDLE, 0, VK_WHOLE_SIZE};
      if (buffers_.contains(name)) {
        buffer.buffer = buffers_.at(name)->buffer;
        write.pBufferInfo = &buffer;
      } else {
        image.imageView = images_.contains(name) ? images_.at(name)->view : own.at(name);
        write.pImageInfo = &image;
      }
      c_.vk.UpdateDescriptorSets(c_.device, 1, &write, 0, nullptr);
    }
    return set;
  }

  void Dispatch(VkCommandBuffer commands, const Json& command, const PackImages& own) {
    const Pipeline& pipeline = Find(command);
    const Json& shader = ShaderOf(command["shader"]);
    std::vector<VkDescriptorSet> sets;
    for (size_t i = 0; i < pipeline.sets.size(); ++i) {
      sets.push_back(MakeSet(shader["sets"][i], pipeline.sets[i], command["sets"][i], own));
    }
    c_.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.handle);
    c_.vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout, 0,
                                static_cast<uint32_t>(sets.size()), sets.data(), 0, nullptr);
    if (command.contains("push")) {
      const std::vector<std::byte> push = BytesOf(command["push"]["data"]);
      c_.vk.CmdPushConstants(commands, pipeline.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                             static_cast<uint32_t>(push.size()), push.data());
    }
    const Json& groups = command["groups"];
    c_.vk.CmdDispatch(commands, groups[0], groups[1], groups[2]);
  }

  void Barrier(VkCommandBuffer commands, const Json& command, const Json& images) const {
    VkMemoryBarrier memory = {};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    memory.srcAccessMask = AccessOf(command["written"]);
    memory.dstAccessMask = AccessOf(command["used"]);
    std::vector<VkImageMemoryBarrier> transitions;
    for (const std::string name : images) {
      VkImageMemoryBarrier to_general = {};
      to_general.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
      to_general.srcAccessMask = memory.srcAccessMask;
      to_general.dstAccessMask = memory.dstAccessMask;
      to_general.newLayout = VK_IMAGE_LAYOUT_GENERAL;
      to_general.srcQueueFamilyIndex = to_general.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
      to_general.image = images_.at(name)->image;
      to_general.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
      transitions.push_back(to_general);
    }
    c_.vk.CmdPipelineBarrier(commands, StagesOf(command["from"]), StagesOf(command["to"]), 0,
                             images.empty() ? 1 : 0, &memory, 0, nullptr,
                             static_cast<uint32_t>(transitions.size()), transitions.data());
  }

  void Update(VkCommandBuffer commands, const Json& command, const Values& parameters) {
    std::vector<std::byte> bytes = BytesOf(command["data"]);
    const auto own = parameters.find(command["buffer"]);
    for (const auto& [name, value] :
         own != parameters.end() ? own->second : std::map<std::string, uint32_t>()) {
      const uint32_t offset = OffsetOf(name);
      std::memcpy(bytes.data() + offset, &value, sizeof(value));
    }
    c_.vk.CmdUpdateBuffer(commands, buffers_.at(command["buffer"])->buffer, command["offset"],
                          bytes.size(), bytes.data());
  }

  uint32_t OffsetOf(const std::string& parameter) const {
    for (const Json& block : table_["blocks"]) {
      for (const Json& member : block["members"]) {
        if (block["name"] == "FrameParameters" && member["name"] == parameter) {
          return member["offset"];
        }
      }
    }
    throw std::runtime_error("there is no parameter " + parameter);
  }

  const gpu::DeviceContext& c_;
  gpu::Arena arena_;
  std::filesystem::path folder_;
  Json table_;
  Json frames_;
  std::map<std::string, const gpu::Image*> images_;
  std::map<std::string, const gpu::Buffer*> buffers_;
  std::map<std::string, Pipeline> pipelines_;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  bool has_begun_ = false;
};

}  // namespace stillray::test

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/schedule_commands.h"

#include <algorithm>
#include <set>
#include <utility>

#include "core/check.h"

namespace stillray::vulkan {
namespace {

using gpu::DryCommand;
using gpu::DryDevice;

std::string KindName(VkDescriptorType type) {
  switch (type) {
    case VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE:
      return "sampled_image";
    case VK_DESCRIPTOR_TYPE_STORAGE_IMAGE:
      return "storage_image";
    case VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER:
      return "uniform_buffer";
    default:
      STILLRAY_CHECK_EQ(type, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
      return "storage_buffer";
  }
}

bool IsImage(VkDescriptorType type) {
  return type == VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE || type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
}

std::vector<std::string> StageNames(VkPipelineStageFlags stages) {
  std::vector<std::string> names;
  for (const auto& [bit, name] : {std::pair{VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, "TOP_OF_PIPE"},
                                  std::pair{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, "COMPUTE_SHADER"},
                                  std::pair{VK_PIPELINE_STAGE_TRANSFER_BIT, "TRANSFER"}}) {
    if ((stages & bit) != 0) {
      names.emplace_back(name);
      stages &= ~static_cast<VkPipelineStageFlags>(bit);
    }
  }
  STILLRAY_CHECK_EQ(stages, 0u);
  return names;
}

std::vector<std::string> AccessNames(VkAccessFlags access) {
  std::vector<std::string> names;
  for (const auto& [bit, name] : {std::pair{VK_ACCESS_SHADER_READ_BIT, "SHADER_READ"},
                                  std::pair{VK_ACCESS_SHADER_WRITE_BIT, "SHADER_WRITE"},
                                  std::pair{VK_ACCESS_UNIFORM_READ_BIT, "UNIFORM_READ"},
                                  std::pair{VK_ACCESS_TRANSFER_READ_BIT, "TRANSFER_READ"},
                                  std::pair{VK_ACCESS_TRANSFER_WRITE_BIT, "TRANSFER_WRITE"}}) {
    if ((access & bit) != 0) {
      names.emplace_back(name);
      access &= ~static_cast<VkAccessFlags>(bit);
    }
  }
  STILLRAY_CHECK_EQ(access, 0u);
  return names;
}

/// Finds shaders by their code.
class ShadersByCode {
 public:
  explicit ShadersByCode(const ShaderTable& table) : table_(table) {}

  const std::string& Find(const std::vector<uint32_t>& code) const {
    const auto found = std::ranges::find_if(table_.shaders, [&](const PackedShader& shader) {
      return std::ranges::equal(shader.code, code);
    });
    STILLRAY_CHECK(found != table_.shaders.end());
    return found->name;
  }

 private:
  const ShaderTable& table_;
};

/// Translates the commands of a dry device, with names in place of numbers.
class Translator {
 public:
  Translator(const DryDevice& dry, const FrameSchedule& schedule, const ShaderTable& table)
      : dry_(dry), schedule_(schedule) {
    const ShadersByCode shaders(table);
    for (const DryDevice::Pipeline& pipeline : dry.pipelines()) {
      shaders_.push_back(shaders.Find(pipeline.code));
    }
  }

  std::vector<ScheduleCommand> Translate(const std::vector<DryCommand>& commands) const {
    std::vector<ScheduleCommand> translated;
    for (const DryCommand& c : commands) {
      const bool continues = c.kind == DryCommand::Kind::kTransition && !translated.empty() &&
                             translated.back().kind == ScheduleCommand::Kind::kTransition;
      if (continues) {
        translated.back().images.push_back(schedule_.images[c.image].name);
      } else {
        translated.push_back(Translate(c));
      }
    }
    return translated;
  }

 private:
  ScheduleCommand Translate(const DryCommand& c) const {
    ScheduleCommand to;
    to.part = c.part;
    to.bytes = c.bytes;
    switch (c.kind) {
      case DryCommand::Kind::kDispatch:
        AddDispatch(c, &to);
        break;
      case DryCommand::Kind::kTransition:
        STILLRAY_CHECK_EQ(c.layout, VK_IMAGE_LAYOUT_GENERAL);
        to.images = {schedule_.images[c.image].name};
        [[fallthrough]];
      case DryCommand::Kind::kBarrier:
        to.kind = c.kind == DryCommand::Kind::kBarrier ? ScheduleCommand::Kind::kBarrier
                                                       : ScheduleCommand::Kind::kTransition;
        to.from = StageNames(c.from);
        to.to = StageNames(c.to);
        to.written = AccessNames(c.written);
        to.used = AccessNames(c.used);
        break;
      case DryCommand::Kind::kFill:
      case DryCommand::Kind::kUpdate:
        to.kind = c.kind == DryCommand::Kind::kFill ? ScheduleCommand::Kind::kFill
                                                    : ScheduleCommand::Kind::kUpdate;
        to.buffer = schedule_.buffers[c.buffer].name;
        to.offset = c.offset;
        to.size = c.size;
        to.value = c.value;
        break;
    }
    return to;
  }

  void AddDispatch(const DryCommand& c, ScheduleCommand* to) const {
    const DryDevice::Pipeline& pipeline = dry_.pipelines()[c.pipeline];
    to->shader = shaders_[c.pipeline];
    to->constants = pipeline.constants;
    to->groups = {c.groups[0], c.groups[1], c.groups[2]};
    for (size_t set = 0; set < pipeline.sets.size(); ++set) {
      for (const gpu::DryDescriptor& d : c.sets[set]) {
        const std::string& resource = IsImage(d.type) ? schedule_.images[d.resource].name
                                                      : schedule_.buffers[d.resource].name;
        to->bindings.push_back({static_cast<uint32_t>(set), d.binding, KindName(d.type), resource});
      }
    }
  }

  const DryDevice& dry_;
  const FrameSchedule& schedule_;
  std::vector<std::string> shaders_;  ///< of the pipelines
};

/// Finds the resources that a frame reads before writing, and those that it writes.
class HistoryFinder {
 public:
  explicit HistoryFinder(const ShaderTable& table) : table_(table) {}

  void Add(const std::vector<ScheduleCommand>& frame, const FrameSchedule& schedule) {
    std::set<std::string> written;
    for (const ScheduleCommand& c : frame) {
      AddReads(c, written);
      AddWrites(c, schedule, &written);
    }
    ever_written_.insert(written.begin(), written.end());
  }

  bool IsHistory(const std::string& name) const {
    return read_first_.contains(name) && ever_written_.contains(name);
  }

 private:
  /// The shader's use of a binding; nullptr: unused.
  const PackBinding* UseOf(const ScheduleCommand& c, const ScheduleBinding& b) const {
    const auto shader = std::ranges::find(table_.shaders, c.shader, &PackedShader::name);
    STILLRAY_CHECK(shader != table_.shaders.end());
    const auto found = std::ranges::find_if(shader->bindings, [&](const PackBinding& of_shader) {
      return of_shader.set == b.set && of_shader.binding == b.binding;
    });
    return found != shader->bindings.end() ? &*found : nullptr;
  }

  void AddReads(const ScheduleCommand& c, const std::set<std::string>& written) {
    for (const ScheduleBinding& b : c.bindings) {
      const PackBinding* use = UseOf(c, b);
      if (use != nullptr && use->reads && !written.contains(b.resource)) {
        read_first_.insert(b.resource);
      }
    }
  }

  void AddWrites(const ScheduleCommand& c, const FrameSchedule& schedule,
                 std::set<std::string>* written) const {
    for (const ScheduleBinding& b : c.bindings) {
      const PackBinding* use = UseOf(c, b);
      if (use != nullptr && use->writes) {
        written->insert(b.resource);
      }
    }
    const auto buffer = std::ranges::find(schedule.buffers, c.buffer, &ScheduleBuffer::name);
    if (buffer != schedule.buffers.end() && c.size == buffer->bytes) {
      written->insert(c.buffer);  // as a whole
    }
  }

  const ShaderTable& table_;
  std::set<std::string> read_first_;
  std::set<std::string> ever_written_;
};

}  // namespace

std::string FormatName(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R8G8B8A8_UNORM:
      return "R8G8B8A8_UNORM";
    case VK_FORMAT_R16_UNORM:
      return "R16_UNORM";
    case VK_FORMAT_R16_SFLOAT:
      return "R16_SFLOAT";
    case VK_FORMAT_R16G16B16A16_SFLOAT:
      return "R16G16B16A16_SFLOAT";
    case VK_FORMAT_R32_UINT:
      return "R32_UINT";
    case VK_FORMAT_R32_SFLOAT:
      return "R32_SFLOAT";
    case VK_FORMAT_R32G32_UINT:
      return "R32G32_UINT";
    case VK_FORMAT_R32G32_SFLOAT:
      return "R32G32_SFLOAT";
    case VK_FORMAT_R32G32B32A32_UINT:
      return "R32G32B32A32_UINT";
    case VK_FORMAT_R32G32B32A32_SFLOAT:
      return "R32G32B32A32_SFLOAT";
    default:
      STILLRAY_CHECK_EQ(format, VK_FORMAT_UNDEFINED);
      return "";
  }
}

std::vector<ScheduleCommand> TranslateCommands(const std::vector<DryCommand>& commands,
                                               const DryDevice& dry, const FrameSchedule& schedule,
                                               const ShaderTable& table) {
  return Translator(dry, schedule, table).Translate(commands);
}

void MarkHistory(const ShaderTable& table, FrameSchedule* schedule) {
  HistoryFinder finder(table);
  for (size_t i = schedule->repeats_from; i < schedule->frames.size(); ++i) {
    finder.Add(schedule->frames[i], *schedule);
  }
  for (ScheduleImage& image : schedule->images) {
    image.is_history = image.role == "internal" && finder.IsHistory(image.name);
  }
  for (ScheduleBuffer& buffer : schedule->buffers) {
    buffer.is_history = finder.IsHistory(buffer.name);
  }
}

}  // namespace stillray::vulkan

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "shaders/pack_json.h"

#include <algorithm>
#include <cstring>
#include <string>

#include <fmt/format.h>

#include "common/command_line.h"
#include "common/json_output.h"

namespace stillray {
namespace {

using Json = nlohmann::ordered_json;

Json MemberJson(const PackMember& m) {
  Json json = {{"name", m.name}, {"type", m.type}, {"offset", m.offset}, {"bytes", m.bytes}};
  if (!m.note.empty()) {
    json["note"] = m.note;
  }
  return json;
}

Json MembersJson(const std::vector<PackMember>& members) {
  Json list = Json::array();
  for (const PackMember& member : members) {
    list.push_back(MemberJson(member));
  }
  return list;
}

/// Converts the 32 bits of a constant or member to a value of its type.
Json ValueJson(const std::string& type, uint32_t bits) {
  if (type == "bool") {
    return bits != 0;
  }
  if (type == "float") {
    float value = 0;
    std::memcpy(&value, &bits, sizeof(value));
    return JsonNumber(static_cast<double>(value));
  }
  return type == "uint" ? Json(bits) : Json(static_cast<int32_t>(bits));
}

Json ConstantJson(const PackConstant& c) {
  Json json = {
      {"id", c.id}, {"name", c.name}, {"type", c.type}, {"default", ValueJson(c.type, c.value)}};
  if (!c.note.empty()) {
    json["note"] = c.note;
  }
  return json;
}

Json SetJson(const PackSet& set) {
  return {{"sampled_images", set.sampled_images},
          {"storage_images", set.storage_images},
          {"uniform_buffers", set.uniform_buffers},
          {"storage_buffers", set.storage_buffers}};
}

Json BindingJson(const PackBinding& b) {
  const bool image = b.kind == "sampled_image" || b.kind == "storage_image";
  Json json = {{"set", b.set}, {"binding", b.binding}, {"kind", b.kind}};
  json[image ? "name" : "block"] = b.name;
  json["access"] = b.reads && b.writes ? "read_write" : b.writes ? "write" : "read";
  if (image) {
    json["texels"] = b.texels;
    json["view"] = b.is_array ? "2d_array" : "2d";
  }
  if (!b.format.empty()) {
    json["format"] = b.format;
  }
  if (!b.note.empty()) {
    json["note"] = b.note;
  }
  return json;
}

Json ShaderJson(const PackedShader& s) {
  Json json = {{"name", s.name},
               {"file", s.name + ".spv"},
               {"stage", s.stage},
               {"precision", s.precision},
               {"normals", s.normals},
               {"local_size", s.local_size},
               {"shared_bytes", s.shared_bytes},
               {"constants", Json::array()},
               {"push_bytes", s.push_bytes},
               {"push", MembersJson(s.push)},
               {"sets", Json::array()},
               {"bindings", Json::array()}};
  for (const PackConstant& constant : s.constants) {
    json["constants"].push_back(ConstantJson(constant));
  }
  for (const PackSet& set : s.sets) {
    json["sets"].push_back(SetJson(set));
  }
  for (const PackBinding& binding : s.bindings) {
    json["bindings"].push_back(BindingJson(binding));
  }
  return json;
}

std::string Hex(const std::vector<std::byte>& bytes) {
  std::string text;
  for (const std::byte b : bytes) {
    text += fmt::format("{:02x}", static_cast<unsigned>(b));
  }
  return text;
}

/// The values of members in the bytes of a block; members beyond the bytes are omitted.
Json ValuesJson(const std::vector<PackMember>& members, const std::vector<std::byte>& bytes) {
  Json values = Json::object();
  for (const PackMember& m : members) {
    if (m.bytes == sizeof(uint32_t) && m.offset + m.bytes <= bytes.size()) {
      uint32_t bits = 0;
      std::memcpy(&bits, bytes.data() + m.offset, sizeof(bits));
      values[m.name] = ValueJson(m.type, bits);
    }
  }
  return values;
}

class CommandWriter {
 public:
  explicit CommandWriter(const ShaderTable& table) : table_(table) {}

  Json Write(const ScheduleCommand& c) const {
    switch (c.kind) {
      case ScheduleCommand::Kind::kDispatch:
        return Dispatch(c);
      case ScheduleCommand::Kind::kBarrier:
      case ScheduleCommand::Kind::kTransition:
        return Barrier(c);
      case ScheduleCommand::Kind::kFill:
        return {{"command", "fill"},
                {"buffer", c.buffer},
                {"offset", c.offset},
                {"bytes", c.size},
                {"value", c.value}};
      case ScheduleCommand::Kind::kUpdate:
        break;
    }
    Json json = {
        {"command", "update"}, {"buffer", c.buffer}, {"offset", c.offset}, {"data", Hex(c.bytes)}};
    const auto block = std::ranges::find(table_.blocks, "FrameParameters", &PackBlock::name);
    if (c.buffer.ends_with("parameters") && block != table_.blocks.end()) {
      json["values"] = ValuesJson(block->members, c.bytes);
    }
    return json;
  }

 private:
  static Json Barrier(const ScheduleCommand& c) {
    const bool transition = c.kind == ScheduleCommand::Kind::kTransition;
    Json json = {{"command", transition ? "transition" : "barrier"},
                 {"from", c.from},
                 {"to", c.to},
                 {"written", c.written},
                 {"used", c.used}};
    if (transition) {
      json["old_layout"] = "UNDEFINED";
      json["new_layout"] = "GENERAL";
      json["images"] = c.images;
    }
    return json;
  }

  Json Dispatch(const ScheduleCommand& c) const {
    const auto shader = std::ranges::find(table_.shaders, c.shader, &PackedShader::name);
    Json json = {{"command", "dispatch"},
                 {"part", c.part},
                 {"shader", c.shader},
                 {"groups", c.groups},
                 {"constants", Json::array()}};
    for (const auto& [id, value] : c.constants) {
      json["constants"].push_back({{"id", id}, {"value", value}});
    }
    if (!c.bytes.empty()) {
      json["push"] = {{"data", Hex(c.bytes)}, {"values", ValuesJson(shader->push, c.bytes)}};
    }
    json["sets"] = std::vector<Json>(shader->sets.size(), Json::array());  // some are empty
    for (const ScheduleBinding& b : c.bindings) {
      json["sets"][b.set].push_back(b.resource);
    }
    return json;
  }

  const ShaderTable& table_;
};

Json ImageJson(const ScheduleImage& image) {
  Json json = {{"name", image.name}, {"role", image.role}};
  if (!image.format.empty()) {
    json["format"] = image.format;
  }
  json["width"] = image.width;
  json["height"] = image.height;
  json["layers"] = image.layers;
  json["history"] = image.is_history;
  return json;
}

}  // namespace

Json TableJson(const ShaderTable& table) {
  Json json = {
      {"version", STILLRAY_VERSION},
      {"set_order", {"sampled_images", "storage_images", "uniform_buffers", "storage_buffers"}},
      {"blocks", Json::array()},
      {"shaders", Json::array()}};
  for (const PackBlock& block : table.blocks) {
    json["blocks"].push_back({{"name", block.name}, {"members", MembersJson(block.members)}});
  }
  for (const PackedShader& shader : table.shaders) {
    json["shaders"].push_back(ShaderJson(shader));
  }
  return json;
}

Json ScheduleJson(const FrameSchedule& schedule, const ScheduleOptions& options,
                  const ShaderTable& table, const std::string& preset) {
  Json json = {{"version", STILLRAY_VERSION},
               {"command_line", CommandLine()},
               {"preset", preset},
               {"width", options.width},
               {"height", options.height},
               {"precision", options.precision == DevicePrecision::kHalf ? "half" : "float"},
               {"images", Json::array()},
               {"buffers", Json::array()},
               {"members_of", schedule.members_of},
               {"repeats_from", schedule.repeats_from},
               {"period", schedule.period},
               {"frames", Json::array()}};
  for (const ScheduleImage& image : schedule.images) {
    json["images"].push_back(ImageJson(image));
  }
  for (const ScheduleBuffer& buffer : schedule.buffers) {
    json["buffers"].push_back(
        {{"name", buffer.name}, {"bytes", buffer.bytes}, {"history", buffer.is_history}});
  }
  const CommandWriter writer(table);
  for (const std::vector<ScheduleCommand>& frame : schedule.frames) {
    Json commands = Json::array();
    for (const ScheduleCommand& command : frame) {
      commands.push_back(writer.Write(command));
    }
    json["frames"].push_back(std::move(commands));
  }
  return json;
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "shaders/pack_text.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/command_line.h"

namespace stillray {
namespace {

/// Supplement to kHowTo, see FillGuidesPass.
constexpr const char* kHowToFill = R"(
Unknown guides: `ghost_stamp` is the number of the frame in the sequence, from 1 on. `shift_x` and `shift_y` are the
fractions of 0.7548776662466927 and 0.5698402909980532 times the index modulo 65536. `has_held` is 0 in the first frame.
)";

constexpr const char* kHowTo = R"(
## Run a frame

1. Create the images and buffers below, with the usages sampled, storage and transfer destination; buffers are
   storage buffers, those named parameters uniform buffers too. Inputs may have any format that shaders read as float (`id`:
   R32_UINT) with enough channels; outputs have the format given here.
2. For each shader of the frames create a pipeline: the descriptor sets have the bindings of its `sets` in
   `shaders.json`, from 0 on in the order sampled images, storage images, uniform buffers, storage buffers; push
   constants begin at 0. Specialisation constants are those of the dispatch. Push constants of the shader without a
   value in a dispatch are not read.
3. Frame n has the commands of `frames[n]` in `frames.json`; from the last one on, those from `repeats_from` on come
   again, with the period given there. `sets` of a dispatch names the resources of all bindings.
4. Formats, stages and accesses are those of Vulkan, without prefix and `_BIT`; `written` and `used` are the accesses before
   and after a memory barrier. All images are in the layout GENERAL: transitions in the first frame bring the filter's own
   images there. Inputs must be visible to compute shaders before the frame, which write the outputs.
5. Parameters of each frame are the update's `data`, and its `values` by name. `members_of` lists the members that
   change with a property of a frame, by buffer: set them before the update. `jitter_x`, `jitter_y` and `focal_pixels` are the values
   of stillray's Frame; `tonemap.frame`, the index, seeds the dither of the display.
6. To begin anew after a cut, start with frame 0 again: with a barrier like the others in place of its transitions.

After another size or other settings, inputs or outputs, make another pack: formats, constants and passes may differ.
)";

std::string Pixels(const ScheduleImage& image) {
  return fmt::format("{} x {}{}", image.width, image.height,
                     image.layers > 0 ? fmt::format(" x {}", image.layers) : "");
}

std::string ResourcesText(const FrameSchedule& schedule) {
  std::string text =
      "\n## Images\n\nWidth x height, and x layers of arrays. History: a frame may read what an "
      "earlier one has written.\nPlaceholders are bound where there is no image.\n\n"
      "| image | | format | pixels | history |\n|---|---|---|---|---|\n";
  for (const ScheduleImage& image : schedule.images) {
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n", image.name, image.role,
                        image.format.empty() ? "any" : image.format, Pixels(image),
                        image.is_history ? "yes" : "");
  }
  text += "\n## Buffers\n\n| buffer | bytes | history |\n|---|---|---|\n";
  for (const ScheduleBuffer& buffer : schedule.buffers) {
    text += fmt::format("| `{}` | {} | {} |\n", buffer.name, buffer.bytes,
                        buffer.is_history ? "yes" : "");
  }
  return text;
}

/// The resources used by a dispatch.
std::string UsesText(const ScheduleCommand& c, const FrameSchedule& schedule,
                     const ShaderTable& table) {
  const auto shader = std::ranges::find(table.shaders, c.shader, &PackedShader::name);
  std::vector<std::string> uses;
  for (const PackBinding& use : shader->bindings) {
    const auto bound = std::ranges::find_if(c.bindings, [&](const ScheduleBinding& b) {
      return b.set == use.set && b.binding == use.binding;
    });
    const auto image = std::ranges::find(schedule.images, bound->resource, &ScheduleImage::name);
    const bool stands_for_none = image != schedule.images.end() && image->role == "placeholder";
    // All dispatches use the parameters.
    if (!stands_for_none && !bound->resource.ends_with("parameters")) {
      const char* arrow = use.writes && use.reads ? "<-> " : use.writes ? "-> " : "";
      uses.push_back(arrow + bound->resource);
    }
  }
  return fmt::format("{}", fmt::join(uses, ", "));
}

std::string CommandText(const ScheduleCommand& c, const FrameSchedule& schedule,
                        const ShaderTable& table) {
  switch (c.kind) {
    case ScheduleCommand::Kind::kDispatch:
      return fmt::format("| {} | `{}` | {} x {} | {} |\n", c.part, c.shader, c.groups[0],
                         c.groups[1], UsesText(c, schedule, table));
    case ScheduleCommand::Kind::kBarrier:
      return "| | barrier | | |\n";
    case ScheduleCommand::Kind::kTransition:
      return fmt::format("| | transition of {} images | | |\n", c.images.size());
    case ScheduleCommand::Kind::kFill:
      return fmt::format("| | fill | | -> {}, {} bytes from {} |\n", c.buffer, c.size, c.offset);
    case ScheduleCommand::Kind::kUpdate:
      return fmt::format("| | update | | -> {} |\n", c.buffer);
  }
  return "";
}

std::string FramesText(const FrameSchedule& schedule, const ShaderTable& table) {
  std::string text;
  for (size_t i = 0; i < schedule.frames.size(); ++i) {
    text += fmt::format(
        "\n## Frame {}\n\n| stage | command | groups | resources; -> written, <-> read and written "
        "|\n|---|---|---|---|\n",
        i);
    for (const ScheduleCommand& command : schedule.frames[i]) {
      text += CommandText(command, schedule, table);
    }
  }
  return text;
}

std::string ShadersText(const ShaderTable& table) {
  std::string text =
      "\n## Shaders\n\nAll shaders of the filter; `shaders.json` has their bindings. Shared memory "
      "is that "
      "with the constants' defaults.\n\n"
      "| shader | stage | workgroup | push constants, bytes | constants | shared memory, bytes |\n"
      "|---|---|---|---|---|---|\n";
  for (const PackedShader& s : table.shaders) {
    std::vector<std::string> constants;
    for (const PackConstant& c : s.constants) {
      constants.push_back(fmt::format("{} {}", c.id, c.name));
    }
    text +=
        fmt::format("| `{}` | {} | {} x {} | {} | {} | {} |\n", s.name, s.stage, s.local_size[0],
                    s.local_size[1], s.push_bytes, fmt::join(constants, ", "), s.shared_bytes);
  }
  return text;
}

}  // namespace

std::string PackText(const ShaderTable& table, const FrameSchedule& schedule,
                     const ScheduleOptions& options, const std::string& preset) {
  const std::string repeats =
      schedule.period == 1 ? fmt::format("frame {} comes again and again", schedule.repeats_from)
                           : fmt::format("frames {} to {} come again and again",
                                         schedule.repeats_from, schedule.frames.size() - 1);
  return fmt::format(
             "# Shaders of stillray {}\n\nMade by `{}`: preset {}, frames of {} x {}; {}.\n",
             STILLRAY_VERSION, CommandLine(), preset, options.width, options.height, repeats) +
         kHowTo + (options.incomplete_guides ? kHowToFill : "") + ResourcesText(schedule) +
         FramesText(schedule, table) + ShadersText(table);
}

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The schedule of frames: a VulkanDenoiser records them on a device that executes nothing.
#include <algorithm>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/check.h"
#include "core/nearest_names.h"
#include "denoise/shader_pack.h"
#include "denoise/vulkan/resource_names.h"
#include "denoise/vulkan/schedule_commands.h"
#include "gpu/dry_device.h"
#include "stillray/vulkan.hpp"

namespace stillray {
namespace vulkan::frame_schedule {
namespace {

using gpu::DryCommand;
using gpu::DryDevice;

/// Frames after which the images that swap must be back; sparse frames feed back at other times.
constexpr size_t kMostFrames = 64;

/// In the order of ScheduleInputNames.
struct InputImage {
  std::string_view name;
  VulkanImage& (*of)(VulkanFrame* frame);
};
template <SignalKind kKind>
VulkanImage& LightOf(VulkanFrame* frame) {
  return frame->lights[static_cast<size_t>(kKind)];
}
template <SignalKind kKind>
VulkanImage& MomentOf(VulkanFrame* frame) {
  return frame->second_moments[static_cast<size_t>(kKind)];
}
template <VulkanImage VulkanFrame::*kMember>
VulkanImage& ImageOf(VulkanFrame* frame) {
  return frame->*kMember;
}
template <size_t kSignal>
VulkanImage& FilteredOf(VulkanFrame* frame) {
  return frame->filtered[kSignal];
}

constexpr InputImage kInputs[] = {
    {"direct_diffuse", LightOf<SignalKind::kDirectDiffuse>},
    {"indirect_diffuse", LightOf<SignalKind::kIndirectDiffuse>},
    {"direct_specular", LightOf<SignalKind::kDirectSpecular>},
    {"indirect_specular", LightOf<SignalKind::kIndirectSpecular>},
    {"direct_transmission", LightOf<SignalKind::kDirectTransmission>},
    {"indirect_transmission", LightOf<SignalKind::kIndirectTransmission>},
    {"direct_diffuse.second_moment", MomentOf<SignalKind::kDirectDiffuse>},
    {"indirect_diffuse.second_moment", MomentOf<SignalKind::kIndirectDiffuse>},
    {"direct_specular.second_moment", MomentOf<SignalKind::kDirectSpecular>},
    {"indirect_specular.second_moment", MomentOf<SignalKind::kIndirectSpecular>},
    {"direct_transmission.second_moment", MomentOf<SignalKind::kDirectTransmission>},
    {"indirect_transmission.second_moment", MomentOf<SignalKind::kIndirectTransmission>},
    {"depth", ImageOf<&VulkanFrame::depth>},
    {"normal", ImageOf<&VulkanFrame::normal>},
    {"id", ImageOf<&VulkanFrame::id>},
    {"motion", ImageOf<&VulkanFrame::motion>},
    {"albedo", ImageOf<&VulkanFrame::albedo>},
    {"specular_albedo", ImageOf<&VulkanFrame::specular_albedo>},
    {"transmission_albedo", ImageOf<&VulkanFrame::transmission_albedo>},
    {"emission", ImageOf<&VulkanFrame::emission>},
    {"background", ImageOf<&VulkanFrame::background>},
    {"samples", ImageOf<&VulkanFrame::samples>},
    {"roughness", ImageOf<&VulkanFrame::roughness>},
    {"confidence", ImageOf<&VulkanFrame::confidence>},
    {"previous_normal", ImageOf<&VulkanFrame::previous_normal>}};
constexpr InputImage kOutputs[] = {{"colour", ImageOf<&VulkanFrame::colour>},
                                   {"colour_half", ImageOf<&VulkanFrame::colour>},
                                   {"display", ImageOf<&VulkanFrame::display>},
                                   {"filtered_0", FilteredOf<0>},
                                   {"filtered_1", FilteredOf<1>},
                                   {"filtered_2", FilteredOf<2>},
                                   {"filtered_3", FilteredOf<3>}};
static_assert(kVulkanSignals == 4);

template <size_t kCount>
std::array<std::string_view, kCount> NamesOf(const InputImage (&images)[kCount]) {
  std::array<std::string_view, kCount> names;
  std::ranges::transform(images, names.begin(), &InputImage::name);
  return names;
}

bool Contains(const std::vector<std::string>& list, std::string_view name) {
  return std::ranges::find(list, name) != list.end();
}

Status CheckNames(const std::vector<std::string>& given, std::span<const std::string_view> known,
                  const char* what) {
  for (const std::string& name : given) {
    if (std::ranges::find(known, name) == known.end()) {
      const std::string meant = DidYouMean(name, known);
      return Status::InvalidArgument(fmt::format(
          "'{}' is no {}{}", name, what,
          meant.empty() ? fmt::format("; expected some of {}", fmt::join(known, ", ")) : meant));
    }
    if (std::ranges::count(given, name) > 1) {
      return Status::InvalidArgument(fmt::format("the {} '{}' is given twice", what, name));
    }
  }
  return Status::Ok();
}

Status CheckOptions(const ScheduleOptions& o) {
  STILLRAY_RETURN_IF_ERROR(CheckNames(o.inputs, ScheduleInputNames(), "input image"));
  STILLRAY_RETURN_IF_ERROR(CheckNames(o.outputs, ScheduleOutputNames(), "output image"));
  return Contains(o.outputs, "colour") && Contains(o.outputs, "colour_half")
             ? Status::InvalidArgument(
                   "the output images 'colour' and 'colour_half' are given, expected one of them")
             : Status::Ok();
}

bool HasTransmission(const ScheduleOptions& o) {
  return Contains(o.inputs, "direct_transmission") || Contains(o.inputs, "indirect_transmission");
}

VulkanOptions OptionsOf(const ScheduleOptions& o) {
  VulkanOptions options;
  options.settings = o.settings;
  options.width = o.width;
  options.height = o.height;
  options.transmission = HasTransmission(o);
  options.precision = o.precision;
  options.incomplete_guides = o.incomplete_guides;
  options.debug_labels = true;
  return options;
}

/// A denoiser on a dry device, and the frames that it has recorded.
class Recording {
 public:
  explicit Recording(const ScheduleOptions& options)
      : options_(options), dry_(std::make_unique<DryDevice>(options.shared_memory)) {}

  Status Begin() {
    AddInputs();
    const VulkanContext context = {dry_->instance(), dry_->physical(), dry_->device(),
                                   DryDevice::get_instance_proc_addr()};
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(context, OptionsOf(options_));
    STILLRAY_RETURN_IF_ERROR(made.status());
    denoiser_ = std::make_unique<VulkanDenoiser>(std::move(*made));
    return Status::Ok();
  }

  /// The properties of frames, which may be changed between them.
  VulkanFrame* frame() { return &frame_; }

  Result<std::vector<DryCommand>> Record() {
    STILLRAY_RETURN_IF_ERROR(denoiser_->Record(dry_->commands(), frame_));
    ++frame_.index;
    return dry_->TakeCommands();
  }

  const DryDevice& dry() const { return *dry_; }
  /// Images of the caller, the first ones of the device.
  const std::vector<ScheduleImage>& own_images() const { return own_; }

 private:
  void AddInputs() {
    for (const InputImage& input : kInputs) {
      if (Contains(options_.inputs, input.name)) {
        AddOwn(input, "input", VK_FORMAT_UNDEFINED);
      }
    }
    frame_.colour_is_half = Contains(options_.outputs, "colour_half");
    const VkFormat of_colour =
        frame_.colour_is_half ? VK_FORMAT_R16G16B16A16_SFLOAT : VK_FORMAT_R32G32B32A32_SFLOAT;
    for (const InputImage& output : kOutputs) {
      if (Contains(options_.outputs, output.name)) {
        AddOwn(output, "output", output.name == "display" ? VK_FORMAT_R8G8B8A8_UNORM : of_colour);
      }
    }
    frame_.samples_per_pixel = options_.samples_per_pixel;
    frame_.focal_pixels = options_.focal_pixels;
    if (options_.jittered) {
      // Any offset: frames have their own.
      frame_.jitter_x = 0.25f;
      frame_.jitter_y = -0.125f;
    }
  }

  void AddOwn(const InputImage& image, const char* role, VkFormat format) {
    const auto width = static_cast<uint32_t>(options_.width);
    const auto height = static_cast<uint32_t>(options_.height);
    image.of(&frame_) = {dry_->AddImage({format, 0, width, height, 1, false}),
                         VK_IMAGE_LAYOUT_GENERAL};
    own_.push_back({std::string(image.name), FormatName(format), width, height, 0, role});
  }

  ScheduleOptions options_;
  std::unique_ptr<DryDevice> dry_;
  std::vector<ScheduleImage> own_;
  VulkanFrame frame_;
  std::unique_ptr<VulkanDenoiser> denoiser_;
};

Status AddResources(const ScheduleOptions& options, const Recording& recording,
                    FrameSchedule* schedule) {
  const Result<ResourceNames> names = NameResources(options, HasTransmission(options));
  STILLRAY_RETURN_IF_ERROR(names.status());
  schedule->images = recording.own_images();
  const std::vector<DryDevice::Image>& images = recording.dry().images();
  const size_t own = schedule->images.size();
  STILLRAY_CHECK_EQ(images.size(), own + names->images.size());
  for (size_t i = own; i < images.size(); ++i) {
    const DryDevice::Image& image = images[i];
    const std::string& name = names->images[i - own];
    const bool stands_for_none = name.starts_with("no_") || name.starts_with("nothing");
    schedule->images.push_back({name, FormatName(image.format), image.width, image.height,
                                image.is_array ? image.layers : 0,
                                stands_for_none ? "placeholder" : "internal"});
  }
  const std::vector<DryDevice::Buffer>& buffers = recording.dry().buffers();
  STILLRAY_CHECK_EQ(buffers.size(), names->buffers.size());
  for (size_t i = 0; i < buffers.size(); ++i) {
    schedule->buffers.push_back({names->buffers[i], buffers[i].size});
  }
  return Status::Ok();
}

/// Whether two frames differ in nothing but the values of their parameters.
bool AreAlike(const std::vector<ScheduleCommand>& a, const std::vector<ScheduleCommand>& b) {
  return std::ranges::equal(a, b, [](ScheduleCommand x, ScheduleCommand y) {
    if (x.kind == ScheduleCommand::Kind::kUpdate && y.kind == x.kind) {
      x.bytes.clear();
      y.bytes.clear();
    }
    return x == y;
  });
}

/// Finds where frames begin to repeat, and leaves those before and one period.
/// \return whether they do
bool FindPeriod(FrameSchedule* schedule) {
  std::vector<std::vector<ScheduleCommand>>& frames = schedule->frames;
  for (size_t from = 0; from < frames.size() / 2; ++from) {
    for (size_t period = 1; from + 2 * period <= frames.size(); ++period) {
      bool repeats = true;
      for (size_t i = from; repeats && i + period < frames.size(); ++i) {
        repeats = AreAlike(frames[i], frames[i + period]);
      }
      if (repeats) {
        schedule->repeats_from = from;
        schedule->period = period;
        frames.resize(from + period);
        return true;
      }
    }
  }
  return false;
}

std::vector<std::byte> ParametersOf(const std::vector<DryCommand>& commands) {
  for (const DryCommand& c : commands) {
    if (c.kind == DryCommand::Kind::kUpdate) {
      return c.bytes;
    }
  }
  return {};
}

/// The parameters of the second frame of a sequence after a change of its properties.
Result<std::vector<std::byte>> ParametersAfter(const ScheduleOptions& options,
                                               void (*change)(VulkanFrame*)) {
  Recording recording(options);
  STILLRAY_RETURN_IF_ERROR(recording.Begin());
  STILLRAY_RETURN_IF_ERROR(recording.Record().status());
  change(recording.frame());
  const Result<std::vector<DryCommand>> commands = recording.Record();
  STILLRAY_RETURN_IF_ERROR(commands.status());
  return ParametersOf(*commands);
}

/// Members of the parameters whose bytes differ.
std::vector<std::string> DifferentMembers(const std::vector<std::byte>& a,
                                          const std::vector<std::byte>& b,
                                          const ShaderTable& table) {
  const auto block = std::ranges::find(table.blocks, "FrameParameters", &PackBlock::name);
  STILLRAY_CHECK(block != table.blocks.end());
  std::vector<std::string> names;
  for (const PackMember& m : block->members) {
    if (std::memcmp(a.data() + m.offset, b.data() + m.offset, m.bytes) != 0) {
      names.push_back(m.name);
    }
  }
  return names;
}

/// Members that differ between frames of the same commands, but for those of the index.
std::vector<std::string> MembersOfNumber(const std::vector<std::vector<DryCommand>>& frames,
                                         const FrameSchedule& schedule, const ShaderTable& table) {
  std::set<std::string> members;
  for (size_t i = schedule.repeats_from; i + schedule.period < frames.size(); ++i) {
    const std::vector<std::string> differ =
        DifferentMembers(ParametersOf(frames[i]), ParametersOf(frames[i + schedule.period]), table);
    members.insert(differ.begin(), differ.end());
  }
  for (const std::string& of_index : schedule.members_of.at("index")) {
    members.erase(of_index);
  }
  return {members.begin(), members.end()};
}

Status FindMembers(const ScheduleOptions& options, const ShaderTable& table,
                   FrameSchedule* schedule) {
  const Result<std::vector<std::byte>> before = ParametersAfter(options, [](VulkanFrame*) {});
  STILLRAY_RETURN_IF_ERROR(before.status());
  using Change = void (*)(VulkanFrame*);
  const std::pair<const char*, Change> changes[] = {
      {"index", [](VulkanFrame* f) { f->index += 100; }},
      {"jitter_x", [](VulkanFrame* f) { f->jitter_x += 0.0625f; }},
      {"jitter_y", [](VulkanFrame* f) { f->jitter_y += 0.0625f; }},
      {"focal_pixels", [](VulkanFrame* f) { f->focal_pixels += 100; }},
      {"samples_per_pixel", [](VulkanFrame* f) { f->samples_per_pixel *= 1.5f; }}};
  for (const auto& [property, change] : changes) {
    const Result<std::vector<std::byte>> after = ParametersAfter(options, change);
    STILLRAY_RETURN_IF_ERROR(after.status());
    schedule->members_of[property] = DifferentMembers(*before, *after, table);
  }
  return Status::Ok();
}

}  // namespace
}  // namespace vulkan::frame_schedule

std::span<const std::string_view> ScheduleInputNames() {
  static const auto names = vulkan::frame_schedule::NamesOf(vulkan::frame_schedule::kInputs);
  return names;
}

std::span<const std::string_view> ScheduleOutputNames() {
  static const auto names = vulkan::frame_schedule::NamesOf(vulkan::frame_schedule::kOutputs);
  return names;
}

Result<FrameSchedule> MakeFrameSchedule(const ScheduleOptions& options) {
  using namespace vulkan::frame_schedule;
  STILLRAY_RETURN_IF_ERROR(CheckOptions(options));
  const Result<ShaderTable> table = MakeShaderTable();
  STILLRAY_RETURN_IF_ERROR(table.status());
  Recording recording(options);
  STILLRAY_RETURN_IF_ERROR(recording.Begin());
  std::vector<std::vector<gpu::DryCommand>> frames;
  while (frames.size() < kMostFrames) {
    Result<std::vector<gpu::DryCommand>> commands = recording.Record();
    STILLRAY_RETURN_IF_ERROR(commands.status());
    frames.push_back(std::move(*commands));
  }
  FrameSchedule schedule;
  STILLRAY_RETURN_IF_ERROR(AddResources(options, recording, &schedule));
  for (const std::vector<gpu::DryCommand>& commands : frames) {
    schedule.frames.push_back(
        vulkan::TranslateCommands(commands, recording.dry(), schedule, *table));
  }
  if (!FindPeriod(&schedule)) {
    return Status::InvalidArgument(
        fmt::format("with {} samples per pixel the commands of {} frames do not repeat: expected 1 "
                    "or more, or a fraction 1/n",
                    options.samples_per_pixel, kMostFrames));
  }
  vulkan::MarkHistory(*table, &schedule);
  STILLRAY_RETURN_IF_ERROR(FindMembers(options, *table, &schedule));
  schedule.members_of["number"] = MembersOfNumber(frames, schedule, *table);
  return schedule;
}

}  // namespace stillray

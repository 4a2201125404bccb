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

/// Number of frames within which the swapped images must recur; with sparse frames feedback has
/// other periods.
constexpr size_t kMostFrames = 64;

/// An input image; entries are in the order of ScheduleInputNames.
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
template <VulkanVirtualGuides VulkanFrame::*kGuides, VulkanImage VulkanVirtualGuides::*kMember>
VulkanImage& SeenOf(VulkanFrame* frame) {
  return (frame->*kGuides).*kMember;
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
    {"previous_normal", ImageOf<&VulkanFrame::previous_normal>},
    {"reflection.depth", SeenOf<&VulkanFrame::reflection, &VulkanVirtualGuides::depth>},
    {"reflection.normal", SeenOf<&VulkanFrame::reflection, &VulkanVirtualGuides::normal>},
    {"reflection.motion", SeenOf<&VulkanFrame::reflection, &VulkanVirtualGuides::motion>},
    {"reflection.id", SeenOf<&VulkanFrame::reflection, &VulkanVirtualGuides::id>},
    {"reflection.albedo", SeenOf<&VulkanFrame::reflection, &VulkanVirtualGuides::albedo>},
    {"refraction.depth", SeenOf<&VulkanFrame::refraction, &VulkanVirtualGuides::depth>},
    {"refraction.normal", SeenOf<&VulkanFrame::refraction, &VulkanVirtualGuides::normal>},
    {"refraction.motion", SeenOf<&VulkanFrame::refraction, &VulkanVirtualGuides::motion>},
    {"refraction.id", SeenOf<&VulkanFrame::refraction, &VulkanVirtualGuides::id>},
    {"refraction.albedo", SeenOf<&VulkanFrame::refraction, &VulkanVirtualGuides::albedo>}};
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

bool HasAny(const ScheduleOptions& o, std::string_view prefix) {
  return std::ranges::any_of(o.inputs,
                             [&](const std::string& name) { return name.starts_with(prefix); });
}

bool HasTransmission(const ScheduleOptions& o) {
  return Contains(o.inputs, "direct_transmission") || Contains(o.inputs, "indirect_transmission");
}

Status CheckOptions(const ScheduleOptions& o) {
  STILLRAY_RETURN_IF_ERROR(CheckNames(o.inputs, ScheduleInputNames(), "input image"));
  STILLRAY_RETURN_IF_ERROR(CheckNames(o.outputs, ScheduleOutputNames(), "output image"));
  for (const std::string seen : {"reflection.", "refraction."}) {
    if (HasAny(o, seen) && !Contains(o.inputs, seen + "depth")) {
      return Status::InvalidArgument(
          fmt::format("the input image '{}depth' is not given, beside others of '{}'", seen, seen));
    }
  }
  return Contains(o.outputs, "colour") && Contains(o.outputs, "colour_half")
             ? Status::InvalidArgument(
                   "the output images 'colour' and 'colour_half' are given, expected one of them")
             : Status::Ok();
}

VulkanOptions OptionsOf(const ScheduleOptions& o) {
  VulkanOptions options;
  options.settings = o.settings;
  options.width = o.width;
  options.height = o.height;
  options.transmission = HasTransmission(o);
  options.precision = o.precision;
  options.incomplete_guides = o.incomplete_guides;
  options.virtual_guides = HasAny(o, "reflection.") || HasAny(o, "refraction.");
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

  /// The properties of the next frames, which may be changed between frames.
  VulkanFrame* frame() { return &frame_; }

  Result<std::vector<DryCommand>> Record() {
    STILLRAY_RETURN_IF_ERROR(denoiser_->Record(dry_->commands(), frame_));
    ++frame_.index;
    return dry_->TakeCommands();
  }

  const DryDevice& dry() const { return *dry_; }
  /// Images of the caller, which are the first images of the device.
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
      // Arbitrary offsets, which real frames replace.
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

/// Whether the image is a placeholder of FrameImages.
bool StandsForNone(std::string_view name) {
  constexpr std::string_view kLayer = "_layer.";
  const size_t layer = name.find(kLayer);
  name.remove_prefix(layer != std::string_view::npos ? layer + kLayer.size() : 0);
  return name.starts_with("no_") || name.starts_with("nothing");
}

Status AddResources(const ScheduleOptions& options, const Recording& recording,
                    FrameSchedule* schedule) {
  const Result<ResourceNames> names = NameResources(OptionsOf(options), options.shared_memory);
  STILLRAY_RETURN_IF_ERROR(names.status());
  schedule->images = recording.own_images();
  const std::vector<DryDevice::Image>& images = recording.dry().images();
  const size_t own = schedule->images.size();
  STILLRAY_CHECK_EQ(images.size(), own + names->images.size());
  for (size_t i = own; i < images.size(); ++i) {
    const DryDevice::Image& image = images[i];
    const std::string& name = names->images[i - own];
    schedule->images.push_back({name, FormatName(image.format), image.width, image.height,
                                image.is_array ? image.layers : 0,
                                StandsForNone(name) ? "placeholder" : "internal"});
  }
  const std::vector<DryDevice::Buffer>& buffers = recording.dry().buffers();
  STILLRAY_CHECK_EQ(buffers.size(), names->buffers.size());
  for (size_t i = 0; i < buffers.size(); ++i) {
    schedule->buffers.push_back({names->buffers[i], buffers[i].size});
  }
  return Status::Ok();
}

/// Whether two frames differ only in the values of their parameters.
bool AreAlike(const std::vector<ScheduleCommand>& a, const std::vector<ScheduleCommand>& b) {
  return std::ranges::equal(a, b, [](ScheduleCommand x, ScheduleCommand y) {
    if (x.kind == ScheduleCommand::Kind::kUpdate && y.kind == x.kind) {
      x.bytes.clear();
      y.bytes.clear();
    }
    return x == y;
  });
}

/// Finds where frames begin to repeat, and keeps the frames before and one period.
/// \return whether frames repeat
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

/// Bytes of each buffer of parameters.
using Parameters = std::map<std::string, std::vector<std::byte>>;

Parameters ParametersOf(const std::vector<DryCommand>& commands, const FrameSchedule& schedule) {
  Parameters parameters;
  for (const DryCommand& c : commands) {
    if (c.kind == DryCommand::Kind::kUpdate) {
      parameters[schedule.buffers[c.buffer].name] = c.bytes;
    }
  }
  return parameters;
}

/// The parameters of the second frame of a sequence after a change of its properties.
Result<Parameters> ParametersAfter(const ScheduleOptions& options, const FrameSchedule& schedule,
                                   void (*change)(VulkanFrame*)) {
  Recording recording(options);
  STILLRAY_RETURN_IF_ERROR(recording.Begin());
  STILLRAY_RETURN_IF_ERROR(recording.Record().status());
  change(recording.frame());
  const Result<std::vector<DryCommand>> commands = recording.Record();
  STILLRAY_RETURN_IF_ERROR(commands.status());
  return ParametersOf(*commands, schedule);
}

/// Adds the members of the parameters whose bytes differ.
void AddDifferentMembers(const Parameters& a, const Parameters& b, const ShaderTable& table,
                         MembersOfBuffers* members) {
  const auto block = std::ranges::find(table.blocks, "FrameParameters", &PackBlock::name);
  STILLRAY_CHECK(block != table.blocks.end());
  for (const auto& [buffer, bytes] : a) {
    for (const PackMember& m : block->members) {
      const std::vector<std::byte>& others = b.at(buffer);
      if (std::memcmp(bytes.data() + m.offset, others.data() + m.offset, m.bytes) != 0) {
        (*members)[buffer].insert(m.name);
      }
    }
  }
}

/// Members that differ between frames with equal commands, except those that depend on the index.
MembersOfBuffers MembersOfNumber(const std::vector<std::vector<DryCommand>>& frames,
                                 const FrameSchedule& schedule, const ShaderTable& table) {
  MembersOfBuffers members;
  for (size_t i = schedule.repeats_from; i + schedule.period < frames.size(); ++i) {
    AddDifferentMembers(ParametersOf(frames[i], schedule),
                        ParametersOf(frames[i + schedule.period], schedule), table, &members);
  }
  for (const auto& [buffer, of_index] : schedule.members_of.at("index")) {
    for (const std::string& member : of_index) {
      members[buffer].erase(member);
    }
  }
  std::erase_if(members, [](const auto& of_buffer) { return of_buffer.second.empty(); });
  return members;
}

Status FindMembers(const ScheduleOptions& options, const ShaderTable& table,
                   FrameSchedule* schedule) {
  const Result<Parameters> before = ParametersAfter(options, *schedule, [](VulkanFrame*) {});
  STILLRAY_RETURN_IF_ERROR(before.status());
  using Change = void (*)(VulkanFrame*);
  const std::pair<const char*, Change> changes[] = {
      {"index", [](VulkanFrame* f) { f->index += 100; }},
      {"jitter_x", [](VulkanFrame* f) { f->jitter_x += 0.0625f; }},
      {"jitter_y", [](VulkanFrame* f) { f->jitter_y += 0.0625f; }},
      {"focal_pixels", [](VulkanFrame* f) { f->focal_pixels += 100; }},
      {"samples_per_pixel", [](VulkanFrame* f) { f->samples_per_pixel *= 1.5f; }}};
  for (const auto& [property, change] : changes) {
    const Result<Parameters> after = ParametersAfter(options, *schedule, change);
    STILLRAY_RETURN_IF_ERROR(after.status());
    AddDifferentMembers(*before, *after, table, &schedule->members_of[property]);
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

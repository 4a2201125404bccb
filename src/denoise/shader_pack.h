// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The compute shaders of the denoiser and the commands of its frames as data, for engines that run
/// them without this library. Made from the code that the library itself runs, without a device.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/denoise.hpp"

namespace stillray {

/// A value in a block: parameters, state, or push constants.
struct PackMember {
  std::string name;     ///< in structures of the block: "atrous.edges.sigma_n"
  std::string type;     ///< "int", "float[4]", "vec4[]": of unknown length
  uint32_t offset = 0;  ///< bytes
  uint32_t bytes = 0;   ///< 0: of unknown length
  std::string note;     ///< from the source; empty: none

  friend bool operator==(const PackMember&, const PackMember&) = default;
};

struct PackBlock {
  std::string name;
  std::vector<PackMember> members;
};

struct PackBinding {
  uint32_t set = 0;
  uint32_t binding = 0;
  std::string kind;  ///< "sampled_image", "storage_image", "uniform_buffer", "storage_buffer"
  std::string name;  ///< of the image, or of the block
  bool reads = false;
  bool writes = false;
  std::string texels;     ///< of images: "float", "uint"
  std::string format;     ///< of storage images, as in GLSL; empty: any
  bool is_array = false;  ///< the view has layers
  std::string note;
};

struct PackConstant {
  uint32_t id = 0;
  std::string name;
  std::string type;
  uint32_t value = 0;  ///< default
  std::string note;
};

/// Descriptors of a set: bindings from 0 on, in this order. All are in the layout, whether or not
/// the shader uses them.
struct PackSet {
  uint32_t sampled_images = 0;
  uint32_t storage_images = 0;
  uint32_t uniform_buffers = 0;
  uint32_t storage_buffers = 0;
};

struct PackedShader {
  std::string name;       ///< "AtrousHalf"; its file is "AtrousHalf.spv"
  std::string stage;      ///< of the denoiser: docs/denoiser.md
  std::string precision;  ///< of the images between stages: "half", "float", "any"
  std::string normals;    ///< of surfaces: "octahedral", "plain", "any"
  std::span<const uint32_t> code;
  std::array<uint32_t, 3> local_size = {1, 1, 1};
  uint32_t shared_bytes = 0;  ///< of a workgroup, with the constants' defaults
  std::vector<PackConstant> constants;
  uint32_t push_bytes = 0;
  std::vector<PackMember> push;
  std::vector<PackSet> sets;
  std::vector<PackBinding> bindings;  ///< that the shader uses
};

struct ShaderTable {
  std::vector<PackedShader> shaders;
  std::vector<PackBlock> blocks;
};

/// All shaders of the filter.
/// \return kUnsupported if stillray was built without Vulkan; kInvalidArgument while
///     STILLRAY_SHADER_DIR replaces shaders
Result<ShaderTable> MakeShaderTable();

/// What frames are like.
struct ScheduleOptions {
  Settings settings;
  int width = 0;
  int height = 0;
  DevicePrecision precision = DevicePrecision::kHalf;
  std::vector<std::string> inputs;   ///< names of ScheduleInputNames
  std::vector<std::string> outputs;  ///< names of ScheduleOutputNames; "colour" or "colour_half"
  float samples_per_pixel = 1;
  float focal_pixels = 0;
  bool jittered = false;           ///< rays miss the pixels' centres, as for temporal antialiasing
  bool incomplete_guides = false;  ///< as in VulkanOptions
  /// Bytes of shared memory that a workgroup may have: decides between the wavelet's variants.
  uint32_t shared_memory = 32768;
};

std::span<const std::string_view> ScheduleInputNames();
std::span<const std::string_view> ScheduleOutputNames();

struct ScheduleImage {
  std::string name;
  std::string format;  ///< of Vulkan, without VK_FORMAT_; empty for inputs: any that fits
  uint32_t width = 0;
  uint32_t height = 0;
  uint32_t layers = 0;  ///< 0: a plain image, not an array of one
  /// "input", "output", "internal", or "placeholder": bound where there is no image.
  std::string role;
  bool is_history = false;  ///< a frame may read what an earlier one has written
};

struct ScheduleBuffer {
  std::string name;
  uint64_t bytes = 0;
  bool is_history = false;
};

struct ScheduleBinding {
  uint32_t set = 0;
  uint32_t binding = 0;
  std::string kind;      ///< as PackBinding::kind
  std::string resource;  ///< an image or a buffer

  friend bool operator==(const ScheduleBinding&, const ScheduleBinding&) = default;
};

struct ScheduleCommand {
  enum class Kind : uint8_t { kDispatch, kBarrier, kTransition, kFill, kUpdate };
  Kind kind = Kind::kDispatch;
  std::string part;  ///< stage, as in timings
  // A dispatch:
  std::string shader;
  std::map<uint32_t, uint32_t> constants;
  std::array<uint32_t, 3> groups = {1, 1, 1};
  std::vector<ScheduleBinding> bindings;
  // A barrier, or a transition of images from undefined content: names of Vulkan's bits, without
  // VK_PIPELINE_STAGE_, VK_ACCESS_ and _BIT.
  std::vector<std::string> from, to;
  std::vector<std::string> written, used;
  std::vector<std::string> images;
  // Of a buffer:
  std::string buffer;
  uint64_t offset = 0;
  uint64_t size = 0;
  uint32_t value = 0;            ///< of a fill, of each 4 bytes
  std::vector<std::byte> bytes;  ///< of an update; push constants of a dispatch

  friend bool operator==(const ScheduleCommand&, const ScheduleCommand&) = default;
};

/// Members of FrameParameters, by the buffer that has them: that of the frame, and of the layers of
/// virtual guides.
using MembersOfBuffers = std::map<std::string, std::set<std::string>>;

struct FrameSchedule {
  std::vector<ScheduleImage> images;
  std::vector<ScheduleBuffer> buffers;
  /// Frame n from `repeats_from` on has the commands of frame repeats_from + (n - repeats_from) %
  /// period, but for the parameters that change by themselves.
  std::vector<std::vector<ScheduleCommand>> frames;
  size_t repeats_from = 0;
  size_t period = 1;
  /// Members of the parameters that change with a property of the frame: "index", "jitter_x",
  /// "jitter_y", "focal_pixels", "samples_per_pixel"; and with "number", that of the frame in the
  /// sequence.
  std::map<std::string, MembersOfBuffers> members_of;
};

/// The commands of the first frames of a sequence, until they repeat. Works as VulkanDenoiser on a
/// device with these options, and checks them in the same way.
/// \return kInvalidArgument naming what is wrong; kUnsupported if stillray was built without Vulkan
Result<FrameSchedule> MakeFrameSchedule(const ScheduleOptions& options);

}  // namespace stillray

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The compute shaders of the denoiser and the commands of its frames as data, for engines that run
/// them without this library. Derived from the code that the library itself executes; needs no
/// device.
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

/// A member of a block: parameters, state, or push constants.
struct PackMember {
  std::string name;     ///< path in the block: "atrous.edges.sigma_n"
  std::string type;     ///< "int", "float[4]", "vec4[]" (runtime-sized)
  uint32_t offset = 0;  ///< bytes
  uint32_t bytes = 0;   ///< 0: runtime-sized
  std::string note;     ///< comment of the declaration in the source; may be empty

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
  std::string texels;     ///< component type of images: "float", "uint"
  std::string format;     ///< format of storage images, as in GLSL; empty: any
  bool is_array = false;  ///< the view is an array
  std::string note;
};

struct PackConstant {
  uint32_t id = 0;
  std::string name;
  std::string type;
  uint32_t value = 0;  ///< default
  std::string note;
};

/// Descriptors of a set, with bindings from 0 in the order of the members. The layout includes
/// those that the shader does not use.
struct PackSet {
  uint32_t sampled_images = 0;
  uint32_t storage_images = 0;
  uint32_t uniform_buffers = 0;
  uint32_t storage_buffers = 0;
};

struct PackedShader {
  std::string name;       ///< e.g. "AtrousHalf"; the file is "AtrousHalf.spv"
  std::string stage;      ///< stage of the denoiser: docs/denoiser.md
  std::string precision;  ///< storage of images between stages: "half", "float", "any"
  std::string normals;    ///< storage of surface normals: "octahedral", "plain", "any"
  std::span<const uint32_t> code;
  std::array<uint32_t, 3> local_size = {1, 1, 1};
  uint32_t shared_bytes = 0;  ///< per workgroup, with the default constants
  std::vector<PackConstant> constants;
  uint32_t push_bytes = 0;
  std::vector<PackMember> push;
  std::vector<PackSet> sets;
  std::vector<PackBinding> bindings;  ///< the bindings that the shader uses
};

struct ShaderTable {
  std::vector<PackedShader> shaders;
  std::vector<PackBlock> blocks;
};

/// All shaders of the filter.
/// \return kUnsupported if stillray was built without Vulkan; kInvalidArgument while
///     STILLRAY_SHADER_DIR replaces shaders
Result<ShaderTable> MakeShaderTable();

/// Properties of the frames of a schedule.
struct ScheduleOptions {
  Settings settings;
  int width = 0;
  int height = 0;
  DevicePrecision precision = DevicePrecision::kHalf;
  std::vector<std::string> inputs;   ///< names of ScheduleInputNames
  std::vector<std::string> outputs;  ///< names of ScheduleOutputNames; "colour" or "colour_half"
  float samples_per_pixel = 1;
  float focal_pixels = 0;
  bool jittered = false;  ///< rays are offset from pixel centres, for temporal antialiasing
  bool incomplete_guides = false;  ///< see VulkanOptions
  /// Limit of shared memory per workgroup, bytes; selects the variant of the wavelet.
  uint32_t shared_memory = 32768;
};

std::span<const std::string_view> ScheduleInputNames();
std::span<const std::string_view> ScheduleOutputNames();

struct ScheduleImage {
  std::string name;
  std::string format;  ///< Vulkan format without VK_FORMAT_; empty for inputs: any suitable format
  uint32_t width = 0;
  uint32_t height = 0;
  uint32_t layers = 0;  ///< 0: not an array
  /// "input", "output", "internal", or "placeholder": bound in place of an absent image.
  std::string role;
  bool is_history = false;  ///< a frame may read values that an earlier frame has written
};

struct ScheduleBuffer {
  std::string name;
  uint64_t bytes = 0;
  bool is_history = false;
};

struct ScheduleBinding {
  uint32_t set = 0;
  uint32_t binding = 0;
  std::string kind;      ///< see PackBinding::kind
  std::string resource;  ///< name of an image or a buffer

  friend bool operator==(const ScheduleBinding&, const ScheduleBinding&) = default;
};

struct ScheduleCommand {
  enum class Kind : uint8_t { kDispatch, kBarrier, kTransition, kFill, kUpdate };
  Kind kind = Kind::kDispatch;
  std::string part;  ///< stage name, as in timings
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
  uint32_t value = 0;            ///< of a fill, per 4 bytes
  std::vector<std::byte> bytes;  ///< of an update; push constants of a dispatch

  friend bool operator==(const ScheduleCommand&, const ScheduleCommand&) = default;
};

/// Members of FrameParameters, by buffer: one of the frame, and one of each layer of virtual
/// guides.
using MembersOfBuffers = std::map<std::string, std::set<std::string>>;

struct FrameSchedule {
  std::vector<ScheduleImage> images;
  std::vector<ScheduleBuffer> buffers;
  /// From `repeats_from` on, frame n has the commands of frame repeats_from + (n - repeats_from) %
  /// period, except for the parameters in `members_of`.
  std::vector<std::vector<ScheduleCommand>> frames;
  size_t repeats_from = 0;
  size_t period = 1;
  /// Members of the parameters that change with a property of the frame: "index", "jitter_x",
  /// "jitter_y", "focal_pixels", "samples_per_pixel"; and "number", the position of the frame in
  /// the sequence.
  std::map<std::string, MembersOfBuffers> members_of;
};

/// The commands of the first frames of a sequence, until they repeat: those of VulkanDenoiser with
/// these options, which are checked as VulkanDenoiser checks them.
/// \return kInvalidArgument naming what is wrong; kUnsupported if stillray was built without Vulkan
Result<FrameSchedule> MakeFrameSchedule(const ScheduleOptions& options);

}  // namespace stillray

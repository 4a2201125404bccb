// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/output_reader.h"

#include <cmath>
#include <cstring>

#include "core/colour_shared.h"
#include "core/half.h"
#include "denoise/stages/accumulate.h"
#include "denoise/stages/limit_history_shared.h"
#include "denoise/stages/prefilter_variance.h"
#include "denoise/stages/reproject_shared.h"

namespace stillray::vulkan {
namespace {

/// Must equal kLeastDeviation of common.glsl.
constexpr float kLeastDeviation = 1e-4f;

/// The source images of an output.
std::vector<const char*> SourcesOf(const std::string& name) {
  const std::string kind = name.substr(0, name.find('.'));
  if (kind == "disocclusion") {
    return {"fetched", "surface"};
  }
  if (kind == "limit") {
    return {"fetched", "compared"};
  }
  if (kind == "ratio") {
    return {"compared"};
  }
  if (kind == "history" || kind == "moment_mean" || kind == "moment_variance") {
    return {"moments"};
  }
  if (kind == "filtered_variance") {
    return {"wavelet"};
  }
  if (kind == "smoothed_variance") {
    return {"variance"};
  }
  if (kind == "alpha") {
    return {"noisy", "joined"};
  }
  for (const char* known :
       {"temporal", "aliased",  "noisy",    "accumulated", "filtered", "variance",
        "atrous1",  "atrous2",  "atrous3",  "atrous4",     "atrous5",  "atrous6",
        "atrous7",  "atrous8",  "weights1", "weights2",    "weights3", "weights4",
        "weights5", "weights6", "weights7", "weights8"}) {
    if (kind == known) {
      return {known};
    }
  }
  return {};
}

bool IsPicture(std::string_view name) {
  return name == "temporal" || name == "aliased" || name.substr(0, 6) == "atrous";
}

float Variance(float deviation) {
  return deviation * deviation;
}

}  // namespace

Result<std::unique_ptr<OutputReader>> OutputReader::Create(const gpu::DeviceContext* context,
                                                           const FramePipeline& pipeline,
                                                           std::vector<std::string> names) {
  std::unique_ptr<OutputReader> made(new OutputReader(context));
  made->shape_ = pipeline.shape();
  made->names_ = std::move(names);
  const Shape& shape = made->shape_;
  const auto pixels =
      static_cast<VkDeviceSize>(shape.width) * static_cast<VkDeviceSize>(shape.height);
  const VkDeviceSize bytes_of_light = shape.storage == Storage::kHalf ? 8 : 16;
  const VkDeviceSize bytes_of_surface = shape.octahedral ? 8 : 16;
  for (const std::string& name : made->names_) {
    for (const char* source : SourcesOf(name)) {
      if (made->kept_.contains(source)) {
        continue;
      }
      const bool is_surface = std::string_view(source) == "surface";
      const VkDeviceSize layers =
          IsPicture(source) || is_surface ? 1 : static_cast<VkDeviceSize>(shape.signals);
      const VkDeviceSize texel = is_surface ? bytes_of_surface : bytes_of_light;
      const Result<const gpu::Buffer*> buffer =
          made->arena_.AddBuffer(pixels * layers * texel, 0, gpu::BufferPlace::kDownload);
      STILLRAY_RETURN_IF_ERROR(buffer.status());
      made->kept_[source] = {*buffer, false};
    }
  }
  if (!made->kept_.empty()) {
    STILLRAY_RETURN_IF_ERROR(made->arena_.Allocate());
  }
  return made;
}

void OutputReader::BeginFrame() {
  for (auto& [name, kept] : kept_) {
    kept.copied = false;
  }
}

bool OutputReader::Wants(std::string_view name) const {
  return kept_.contains(name);
}

void OutputReader::Keep(VkCommandBuffer commands, std::string_view name, const gpu::Image& image) {
  Kept& kept = kept_.find(name)->second;
  kept.copied = true;
  VkBufferImageCopy region = {};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0,
                             static_cast<uint32_t>(image.layers > 0 ? image.layers : 1)};
  region.imageExtent = {static_cast<uint32_t>(shape_.width), static_cast<uint32_t>(shape_.height),
                        1};
  context_->vk.CmdCopyImageToBuffer(commands, image.image, VK_IMAGE_LAYOUT_GENERAL,
                                    kept.buffer->buffer, 1, &region);
}

void OutputReader::Finish(VkCommandBuffer commands, const FramePipeline& pipeline) {
  if (Wants("surface")) {
    Keep(commands, "surface", *pipeline.images().guides.surface);
  }
}

float OutputReader::Load(const std::string& name, int layer, int channel, int x, int y) const {
  const void* data = kept_.find(name)->second.buffer->mapped;
  const size_t i =
      ((static_cast<size_t>(layer) * static_cast<size_t>(shape_.height) + static_cast<size_t>(y)) *
           static_cast<size_t>(shape_.width) +
       static_cast<size_t>(x)) *
          4 +
      static_cast<size_t>(channel);
  if (shape_.storage == Storage::kHalf) {
    return FloatFromHalf(static_cast<const uint16_t*>(data)[i]);
  }
  return static_cast<const float*>(data)[i];
}

void OutputReader::ReadPicture(const std::string& name, const FrameState& state,
                               NamedImage* out) const {
  for (int c = 0; c < 3; ++c) {
    Image1 plane(shape_.width, shape_.height);
    for (int y = 0; y < shape_.height; ++y) {
      for (int x = 0; x < shape_.width; ++x) {
        plane(x, y) = Load(name, 0, c, x, y) / state.picture_exposure;
      }
    }
    out->channels.push_back(std::move(plane));
  }
}

void OutputReader::ReadDisocclusion(bool had_history, NamedImage* out) const {
  Image1 mask(shape_.width, shape_.height);
  const auto* surface = static_cast<const uint32_t*>(kept_.find("surface")->second.buffer->mapped);
  const size_t words = shape_.octahedral ? 2 : 4;
  for (int y = 0; y < shape_.height; ++y) {
    for (int x = 0; x < shape_.width; ++x) {
      const size_t i =
          static_cast<size_t>(y) * static_cast<size_t>(shape_.width) + static_cast<size_t>(x);
      const bool is_surface = surface[i * words] != 0;
      const bool found = had_history && Load("fetched", 0, 2, x, y) >= 0;
      mask(x, y) = is_surface && !found ? 1.0f : 0.0f;
    }
  }
  out->channels.push_back(std::move(mask));
}

void OutputReader::ReadSignal(const std::string& kind, int signal, const FrameState& state,
                              const FramePlan& plan, const Image1* confidence,
                              NamedImage* out) const {
  const float exposure = state.exposure[signal];
  const bool rec601 = plan.demodulate.luminance_rec601 != 0;
  const auto add = [&](const auto& value) {
    Image1 plane(shape_.width, shape_.height);
    for (int y = 0; y < shape_.height; ++y) {
      for (int x = 0; x < shape_.width; ++x) {
        plane(x, y) = value(x, y);
      }
    }
    out->channels.push_back(std::move(plane));
  };
  const auto load = [&](const char* name, int channel, int x, int y) {
    return Load(name, signal, channel, x, y);
  };
  if (kind == "variance") {
    add([&](int x, int y) {
      const float deviation = load("variance", 3, x, y);
      return deviation < 0 ? 0.0f : Variance(deviation / exposure);
    });
  } else if (kind == "smoothed_variance") {
    const auto valid = [&](int x, int y) {
      const bool inside = x >= 0 && y >= 0 && x < shape_.width && y < shape_.height;
      return inside && load("variance", 3, x, y) >= 0 ? 1.0f : 0.0f;
    };
    const auto variance = [&](int x, int y) {
      return valid(x, y) > 0 ? Variance(load("variance", 3, x, y) / exposure) : 0.0f;
    };
    // The image holds the variance before smooth_variance.
    const bool smoothed =
        plan.prefilter_variance.prefilter_variance != 0 || plan.runs.smooth_variance;
    const int radius = smoothed ? 1 : 0;
    add([&](int x, int y) {
      return valid(x, y) > 0 ? SmoothedVariance(variance, valid, radius, x, y) : 0.0f;
    });
  } else if (kind == "alpha") {
    add([&](int x, int y) {
      const float given = confidence != nullptr ? (*confidence)(x, y) : 1.0f;
      return UsedAlpha(plan.accumulate, std::max(load("joined", 2, x, y), 0.0f),
                       load("noisy", 3, x, y), UsedConfidence(given, std::isnan(given)));
    });
  } else if (kind.starts_with("weights")) {
    add([&](int x, int y) { return load(kind.c_str(), 0, x, y); });
  } else if (kind == "filtered_variance") {
    add([&](int x, int y) {
      const float deviation = load("wavelet", 3, x, y);
      return -deviation > 0 && -deviation < 1.001f * kLeastDeviation
                 ? 0.0f
                 : Variance(deviation / exposure);
    });
  } else if (kind == "history") {
    add([&](int x, int y) { return std::max(load("moments", 2, x, y), 0.0f); });
  } else if (kind == "moment_mean") {
    add([&](int x, int y) { return load("moments", 0, x, y) / exposure; });
  } else if (kind == "moment_variance") {
    add([&](int x, int y) { return Variance(load("moments", 1, x, y) / exposure); });
  } else if (kind == "limit") {
    add([&](int x, int y) {
      const float length = std::max(load("fetched", 2, x, y), 0.0f);
      return !plan.runs.reproject
                 ? length
                 : LimitedLength(length, load("fetched", 3, x, y), load("compared", 1, x, y),
                                 plan.limit_history.limit_gain);
    });
  } else if (kind == "ratio") {
    add([&](int x, int y) { return load("compared", 0, x, y); });
  } else {
    const char* name = kind.c_str();
    add([&](int x, int y) { return load(name, 1, x, y) / exposure; });
    add([&](int x, int y) {
      const float l = load(name, 0, x, y);
      const float r = load(name, 1, x, y);
      const float b = load(name, 2, x, y);
      return (rec601 ? Green601(l, r, b) : Green709(l, r, b)) / exposure;
    });
    add([&](int x, int y) { return load(name, 2, x, y) / exposure; });
  }
}

Status OutputReader::Read(const FramePipeline& pipeline, const FrameState& state,
                          const FramePlan& plan, const Image1* confidence,
                          std::vector<NamedImage>* images) const {
  STILLRAY_RETURN_IF_ERROR(arena_.Invalidate());
  const bool had_history = plan.runs.reproject;
  const std::span<const SignalGroup> groups = pipeline.groups();
  for (const std::string& name : names_) {
    const std::string kind = name.substr(0, name.find('.'));
    bool complete = true;
    for (const char* source : SourcesOf(name)) {
      const bool spare = kind == "disocclusion" && !had_history;
      complete = complete && (kept_.find(source)->second.copied || spare);
    }
    if (!complete) {
      continue;  // the stage did not run
    }
    NamedImage image = {name, {}};
    if (kind == "disocclusion") {
      ReadDisocclusion(had_history, &image);
    } else if (IsPicture(kind)) {
      ReadPicture(name, state, &image);
    }
    for (size_t i = 0; i < groups.size() && image.channels.empty(); ++i) {
      if (name == kind + "." + groups[i].name) {
        ReadSignal(kind, static_cast<int>(i), state, plan, confidence, &image);
      }
    }
    if (!image.channels.empty()) {
      images->push_back(std::move(image));
    }
  }
  return Status::Ok();
}

}  // namespace stillray::vulkan

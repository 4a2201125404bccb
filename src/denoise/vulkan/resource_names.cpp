// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/resource_names.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/check.h"
#include "denoise/vulkan/embedded_options.h"
#include "denoise/vulkan/frame_pipeline.h"
#include "denoise/vulkan/layer_passes.h"
#include "gpu/dry_device.h"
#include "gpu/shared_pipelines.h"

namespace stillray::vulkan {
namespace {

using gpu::DryDevice;

/// \param prefix  of all names
void NameImages(const FrameImages& i, const std::string& prefix, const DryDevice& dry,
                ResourceNames* names) {
  const auto name = [&](const gpu::Image* image, const char* text) {
    if (image != nullptr && names->images[dry.ImageOf(image->view)].empty()) {
      names->images[dry.ImageOf(image->view)] = prefix + text;
    }
  };
  // Placeholders first.
  name(i.nothing, "nothing");
  name(i.nothing_scalar, "nothing_scalar");
  name(i.nothing_fraction, "nothing_fraction");
  name(i.no_input, "no_input");
  name(i.no_ids, "no_ids");
  name(i.no_float_output, "no_float_output");
  name(i.no_half_output, "no_half_output");
  name(i.no_display, "no_display");
  name(i.history.colour, "history.colour");
  name(i.history.behind, "history.behind");
  name(i.history.moments, "history.moments");
  name(i.history.compressed, "history.compressed");
  name(i.fetched.colour, "fetched.colour");
  name(i.fetched.behind, "fetched.behind");
  name(i.fetched.moments, "fetched.moments");
  name(i.fetched.compressed, "fetched.compressed");
  name(i.noisy, "noisy");
  name(i.unclamped, "unclamped");
  name(i.within, "within");
  name(i.coarse.surface, "coarse.surface");
  name(i.coarse.detail, "coarse.detail");
  name(i.compared[0], "compared_0");
  name(i.compared[1], "compared_1");
  name(i.compressed_light, "compressed_light");
  name(i.wide, "wide");
  name(i.ratio, "ratio");
  name(i.wavelet[0], "wavelet_0");
  name(i.wavelet[1], "wavelet_1");
  name(i.luminance_factor, "luminance_factor");
  name(i.guides.surface, "guides_0.surface");
  name(i.guides.detail, "guides_0.detail");
  name(i.previous_guides.surface, "guides_1.surface");
  name(i.previous_guides.detail, "guides_1.detail");
  name(i.turn2, "turn2");
  name(i.picture, "picture");
  name(i.scratch, "scratch");
  name(i.shown, "shown");
  name(i.albedo, "albedo_sum");
  name(i.albedo_range, "albedo_range");
  name(i.albedo_before, "albedo_sum_0");
  name(i.albedo_out, "albedo_sum_1");
  name(i.followed, "followed_0");
  name(i.followed_before, "followed_1");
  name(i.changes, "changes");
  name(i.followed_ratio, "followed_ratio");
  const auto name_buffer = [&](const gpu::Buffer* buffer, const char* text) {
    names->buffers[DryDevice::IndexOf(buffer->buffer)] = prefix + text;
  };
  name_buffer(i.parameters, "parameters");
  name_buffer(i.state, "state");
  name_buffer(i.partials, "partials");
  name_buffer(i.history_sums, "history_sums");
}

void NameHeld(const FillGuidesPass::Held& held, const std::string& prefix, const DryDevice& dry,
              ResourceNames* names) {
  constexpr const char* kColours[kGuideColours] = {"albedo", "specular_albedo",
                                                   "transmission_albedo", "emission", "background"};
  const auto name = [&](const gpu::Image* image, const std::string& text) {
    names->images[dry.ImageOf(image->view)] = prefix + text;
  };
  name(held.depth, "depth");
  name(held.normal, "normal");
  name(held.id, "id");
  for (size_t k = 0; k < held.colour.size(); ++k) {
    name(held.colour[k], kColours[k]);
  }
}

void NameFilling(const FillGuidesPass& filling, const std::string& prefix, const DryDevice& dry,
                 ResourceNames* names) {
  NameHeld(filling.progress().now, prefix + "held_0.", dry, names);
  NameHeld(filling.progress().before, prefix + "held_1.", dry, names);
  names->images[dry.ImageOf(filling.motion().view)] = prefix + "filled_motion";
  // Buffers without a name so far, in the order of their creation.
  for (const char* name : {"pyramid", "rejected_guides"}) {
    const auto unnamed = std::ranges::find(names->buffers, "");
    STILLRAY_CHECK(unnamed != names->buffers.end());
    *unnamed = prefix + name;
  }
}

void NameLayer(const LayerImages& i, const std::string& prefix, const DryDevice& dry,
               ResourceNames* names) {
  const auto name = [&](const gpu::Image* image, const char* text) {
    names->images[dry.ImageOf(image->view)] = prefix + text;
  };
  name(i.depth, "selected_depth");
  name(i.normal, "selected_normal");
  name(i.motion, "selected_motion");
  name(i.id, "selected_id");
  name(i.roughness, "selected_roughness");
  name(i.albedo, "selected_albedo");
  name(i.previous_normal, "selected_previous_normal");
  name(i.direct_moment, "direct_moment");
  name(i.indirect_moment, "indirect_moment");
  name(i.picture, "layer_picture");
  name(i.picture_motion, "picture_motion");
  name(i.emission, "rest_emission");
}

/// Creates the resources of VulkanDenoiser::Create, and names them.
class Namer {
 public:
  Namer(const gpu::DeviceContext* context, const DryDevice& dry, const VulkanOptions& options)
      : context_(context), dry_(dry), options_(options) {}

  Status NameAll() {
    STILLRAY_RETURN_IF_ERROR(NamePipeline(PipelineOptionsOf(options_), ""));
    if (options_.virtual_guides) {
      STILLRAY_RETURN_IF_ERROR(NameLayerOf(GuideSource::kReflection, "reflection_layer."));
      if (options_.transmission) {
        STILLRAY_RETURN_IF_ERROR(NameLayerOf(GuideSource::kRefraction, "refraction_layer."));
      }
    }
    STILLRAY_CHECK(std::ranges::count(names_.images, "") == 0 &&
                   std::ranges::count(names_.buffers, "") == 0);
    return Status::Ok();
  }

  ResourceNames Take() { return std::move(names_); }

 private:
  void MakeRoom() {
    names_.images.resize(dry_.images().size());
    names_.buffers.resize(dry_.buffers().size());
  }

  Status NamePipeline(const PipelineOptions& options, const std::string& prefix) {
    const Result<std::unique_ptr<FramePipeline>> made = FramePipeline::Create(context_, options);
    STILLRAY_RETURN_IF_ERROR(made.status());
    MakeRoom();
    NameImages((*made)->images(), prefix, dry_, &names_);
    if ((*made)->fill_guides() != nullptr) {
      NameFilling(*(*made)->fill_guides(), prefix, dry_, &names_);
    }
    return Status::Ok();
  }

  Status NameLayerOf(GuideSource source, const std::string& prefix) {
    const Result<std::unique_ptr<LayerPasses>> passes =
        LayerPasses::Create(context_, source, false, 0);
    STILLRAY_RETURN_IF_ERROR(passes.status());
    STILLRAY_RETURN_IF_ERROR((*passes)->Prepare(LayerShapeOf(options_, source)));
    MakeRoom();
    NameLayer(*(*passes)->images(), prefix, dry_, &names_);
    return NamePipeline(LayerOptionsOf(options_, source), prefix);
  }

  const gpu::DeviceContext* context_;
  const DryDevice& dry_;
  const VulkanOptions& options_;
  ResourceNames names_;
};

}  // namespace

Result<ResourceNames> NameResources(const VulkanOptions& options, uint32_t shared_memory) {
  DryDevice dry(shared_memory);
  Result<gpu::DeviceContext> context = gpu::MakeContext(
      DryDevice::get_instance_proc_addr(), dry.instance(), dry.physical(), dry.device());
  STILLRAY_RETURN_IF_ERROR(context.status());
  gpu::SharedPipelines pipelines(&*context);
  context->pipelines = &pipelines;
  Namer namer(&*context, dry, options);
  STILLRAY_RETURN_IF_ERROR(namer.NameAll());
  return namer.Take();
}

}  // namespace stillray::vulkan

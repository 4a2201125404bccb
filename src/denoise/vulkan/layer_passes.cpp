// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/vulkan/layer_passes.h"

#include <algorithm>
#include <utility>

#include "denoise/vulkan/device_inputs.h"

namespace stillray::vulkan {

namespace shaders {
#define STILLRAY_SHADER(name)           \
  extern const std::uint32_t k##name[]; \
  extern const std::size_t k##name##Words;
STILLRAY_SHADER(SelectGuides)
STILLRAY_SHADER(RescaleMoments)
STILLRAY_SHADER(AddLayer)
STILLRAY_SHADER(PlaceHits)
#undef STILLRAY_SHADER
}  // namespace shaders

namespace {

/// The signal kinds and the albedo of a layer.
struct LayerLights {
  size_t direct;
  size_t indirect;
  size_t albedo;  ///< index in FrameInputs::albedos

  uint32_t bits() const { return 1u << direct | 1u << indirect; }
};
constexpr LayerLights kReflected = {static_cast<size_t>(SignalKind::kDirectSpecular),
                                    static_cast<size_t>(SignalKind::kIndirectSpecular), 1};
constexpr LayerLights kTransmitted = {static_cast<size_t>(SignalKind::kDirectTransmission),
                                      static_cast<size_t>(SignalKind::kIndirectTransmission), 2};

const LayerLights& LightsOf(GuideSource source) {
  return source == GuideSource::kReflection ? kReflected : kTransmitted;
}
const LayerLights& OtherLights(GuideSource source) {
  return source == GuideSource::kReflection ? kTransmitted : kReflected;
}

/// Push constants of select_guides.comp.
struct SelectPush {
  float virtual_roughness = 0;
  float image_normal = 1;
  float virtual_motion_roughness = 0;
  int32_t has_other_albedo = 0;
  int32_t has_previous_normal = 0;
  int32_t has_id = 0;
  int32_t has_image_albedo = 0;
  int32_t width = 0;
  int32_t height = 0;
};

/// Push constants of rescale_moments.comp.
struct RescalePush {
  int32_t width = 0;
  int32_t height = 0;
};

/// Push constants of add_layer.comp.
struct AddPush {
  int32_t has_id = 0;
  int32_t has_emission = 0;
  int32_t has_length = 0;
  int32_t width = 0;
  int32_t height = 0;
};

constexpr uint32_t kMostMarks = 4;
/// Number of frames with different images for which the first descriptor pool suffices.
constexpr uint32_t kFramesOfAPool = 4;
constexpr VkPipelineStageFlags kCompute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
constexpr VkAccessFlags kReadAndWrite = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;

void WaitForWrites(gpu::CommandList* commands) {
  commands->Barrier(kCompute, VK_ACCESS_SHADER_WRITE_BIT, kCompute, kReadAndWrite);
}

template <typename Push>
std::span<const std::byte> BytesOf(const Push& push) {
  return std::as_bytes(std::span(&push, 1));
}

Status AddImages(const LayerShape& shape, LayerImages* to) {
  Status status;
  const auto add = [&](VkFormat format, const gpu::Image** image) {
    if (status.ok()) {
      const Result<const gpu::Image*> added =
          to->arena.AddImage(format, shape.width, shape.height, 0);
      status = added.status();
      *image = added.ok() ? *added : nullptr;
    }
  };
  constexpr VkFormat kColour = VK_FORMAT_R32G32B32A32_SFLOAT;
  constexpr VkFormat kScalar = VK_FORMAT_R32_SFLOAT;
  constexpr VkFormat kMotion = VK_FORMAT_R32G32_SFLOAT;
  add(kScalar, &to->depth);
  add(kColour, &to->normal);
  add(kMotion, &to->motion);
  add(VK_FORMAT_R32_UINT, &to->id);
  add(kScalar, &to->roughness);
  add(kColour, &to->albedo);
  if (shape.previous_normals) {
    add(kColour, &to->previous_normal);
  }
  if (shape.second_moments) {
    add(kScalar, &to->direct_moment);
    add(kScalar, &to->indirect_moment);
  }
  if (shape.with_picture) {
    add(kColour, &to->picture);
  }
  if (shape.with_hits) {
    add(kScalar, &to->hit_depth);
    add(kMotion, &to->hit_motion);
  }
  add(kMotion, &to->picture_motion);
  add(kColour, &to->emission);
  return status;
}

}  // namespace

/// The shaders, in the order of LayerPasses::Pass.
std::vector<LayerShader> LayerShaders() {
  return {
      {"select_guides",
       {shaders::kSelectGuides, shaders::kSelectGuidesWords},
       14,
       7,
       sizeof(SelectPush)},
      {"select_guides",
       {shaders::kRescaleMoments, shaders::kRescaleMomentsWords},
       6,
       2,
       sizeof(RescalePush)},
      {"add_layer", {shaders::kAddLayer, shaders::kAddLayerWords}, 7, 2, sizeof(AddPush)},
      {"select_guides", {shaders::kPlaceHits, shaders::kPlaceHitsWords}, 2, 2, sizeof(HitCamera)},
  };
}

namespace {
LayerShader InfoOf(size_t pass) {
  return LayerShaders()[pass];
}
}  // namespace

Result<gpu::MemoryUse> LayerPasses::Need(const gpu::DeviceContext* context,
                                         const LayerShape& shape) {
  LayerImages images(context);
  STILLRAY_RETURN_IF_ERROR(AddImages(shape, &images));
  return images.arena.Need();
}

Result<std::unique_ptr<LayerPasses>> LayerPasses::Create(const gpu::DeviceContext* context,
                                                         GuideSource source, bool timed,
                                                         uint32_t in_flight) {
  std::unique_ptr<LayerPasses> made(new LayerPasses(context, source, timed));
  gpu::SetShape all = {0, 0, 0, 0};
  for (size_t pass = 0; pass < kPassCount; ++pass) {
    all.sampled += InfoOf(pass).reads * kFramesOfAPool;
    all.stored += InfoOf(pass).writes * kFramesOfAPool;
  }
  STILLRAY_RETURN_IF_ERROR(made->sets_.CreatePool(kPassCount * kFramesOfAPool, all, in_flight));
  if (timed) {
    STILLRAY_RETURN_IF_ERROR(made->layer_times_.Create(kMostMarks, std::max(in_flight, 1u)));
    STILLRAY_RETURN_IF_ERROR(made->rest_times_.Create(kMostMarks, std::max(in_flight, 1u)));
  }
  STILLRAY_RETURN_IF_ERROR(made->MakePipelines());
  return made;
}

Status LayerPasses::MakePipelines() {
  for (size_t pass = 0; pass < kPassCount; ++pass) {
    const LayerShader info = InfoOf(pass);
    const Result<VkDescriptorSetLayout> layout = sets_.Layout({info.reads, info.writes, 0, 0});
    STILLRAY_RETURN_IF_ERROR(layout.status());
    Result<gpu::Pipeline> made = gpu::Pipeline::Create(
        context_, {info.stage, info.code, {&*layout, 1}, info.push_bytes, {}});
    STILLRAY_RETURN_IF_ERROR(made.status());
    pipelines_[pass] = *made;
  }
  return Status::Ok();
}

Status LayerPasses::Prepare(const LayerShape& shape) {
  if (images_ != nullptr && shape_ == shape) {
    return Status::Ok();
  }
  images_.reset();  // freed first, since both may not fit into memory
  auto made = std::make_shared<LayerImages>(context_);
  STILLRAY_RETURN_IF_ERROR(AddImages(shape, made.get()));
  STILLRAY_RETURN_IF_ERROR(made->arena.Allocate());
  images_ = std::move(made);
  shape_ = shape;
  Resize(shape.width, shape.height);
  return Status::Ok();
}

void LayerPasses::Resize(int width, int height) {
  width_ = width;
  height_ = height;
}

void LayerPasses::Begin(gpu::CommandList* commands, Pass pass, gpu::Timestamps* times) {
  if (timed_) {
    commands->BeginTimes(times, frames_);
  }
  commands->BeginPart(InfoOf(pass).stage, timed_ ? times : nullptr);
}

void LayerPasses::End(gpu::CommandList* commands, gpu::Timestamps* times) {
  commands->BeginPart({}, timed_ ? times : nullptr);
}

/// Runs a pass with one thread per pixel. \param images  first the images that the shader reads,
/// then those that it writes
Status LayerPasses::Run(gpu::CommandList* commands, Pass pass, std::span<const ImageRef> images,
                        std::span<const std::byte> push) {
  const LayerShader info = InfoOf(pass);
  const gpu::Pipeline& pipeline = *pipelines_[pass];
  gpu::SetContent content;
  for (const ImageRef& image : images) {
    content.images.push_back(image.view);
    content.layouts.push_back(image.layout);
  }
  const gpu::SetShape shape = {info.reads, info.writes, 0, 0};
  const Result<VkDescriptorSet> set = sets_.FindForFrame(shape, content);
  STILLRAY_RETURN_IF_ERROR(set.status());
  const Groups groups = GroupsFor(width_, height_);
  commands->Dispatch({pipeline.handle(), pipeline.layout(), {*set}, 1, groups.x, groups.y}, push);
  return Status::Ok();
}

/// Sets the layout of the images before the first frame.
void LayerPasses::PrepareImages(VkCommandBuffer commands) {
  LayerImages& images = *images_;
  if (!images.used) {
    images.used = true;
    images.arena.RecordFirstUse(commands, kCompute, kReadAndWrite);
  }
}

/// Computes depth and motion of the virtual images from hit distances, and stores their images in
/// `seen`.
Status LayerPasses::PlaceHits(gpu::CommandList* commands, const ImageRef& depth,
                              VirtualInputs* seen) {
  const ImageRef images[] = {depth, seen->hit_distance, RefTo(images_->hit_depth),
                             RefTo(images_->hit_motion)};
  STILLRAY_RETURN_IF_ERROR(Run(commands, kPlaceHits, images, BytesOf(seen->hit_camera)));
  WaitForWrites(commands);
  seen->depth = RefTo(images_->hit_depth);
  seen->motion = RefTo(images_->hit_motion);
  return Status::Ok();
}

Status LayerPasses::RecordLayer(gpu::CommandList* commands, const FrameFacts& facts,
                                const FrameInputs& from, const VirtualInputs& given,
                                const SelectGuidesParameters& select) {
  const LayerImages& to = *images_;
  VirtualInputs seen = given;
  ++frames_;
  sets_.BeginFrame(frames_);
  commands->Call([this](VkCommandBuffer into) { PrepareImages(into); });
  WaitForWrites(commands);  // the last frame's passes may still read these images
  Begin(commands, kSelectGuides, &layer_times_);
  if (seen.hit_distance.view != VK_NULL_HANDLE) {
    STILLRAY_RETURN_IF_ERROR(PlaceHits(commands, from.depth, &seen));
  }
  const bool has_previous = HasPreviousNormals(facts);
  // The shader needs images of the right format in place of absent ones.
  const ImageRef previous_from = has_previous ? from.previous_normal : from.normal;
  const gpu::Image* previous_to = has_previous ? to.previous_normal : to.normal;
  const LayerLights& lights = LightsOf(source_);
  const LayerLights& others = OtherLights(source_);
  const bool has_other = (facts.albedos >> others.albedo & 1u) != 0;
  const bool has_albedo = seen.albedo.view != VK_NULL_HANDLE;
  const ImageRef own_id = facts.has_id ? from.id : RefTo(to.id);
  const auto given_or = [](const ImageRef& image, const ImageRef& other) {
    return image.view != VK_NULL_HANDLE ? image : other;
  };
  const ImageRef images[] = {from.depth,
                             from.normal,
                             from.motion,
                             own_id,
                             from.roughness,
                             previous_from,
                             from.albedos[0],
                             from.albedos[lights.albedo],
                             has_other ? from.albedos[others.albedo] : from.albedos[0],
                             seen.depth,
                             given_or(seen.normal, from.normal),
                             seen.motion,
                             facts.has_id ? given_or(seen.id, own_id) : own_id,
                             given_or(seen.albedo, from.albedos[0]),
                             RefTo(to.depth),
                             RefTo(to.normal),
                             RefTo(to.motion),
                             RefTo(to.id),
                             RefTo(to.roughness),
                             RefTo(to.albedo),
                             RefTo(previous_to)};
  const SelectPush push = {select.virtual_roughness,
                           select.image_normal,
                           select.virtual_motion_roughness,
                           has_other ? 1 : 0,
                           has_previous ? 1 : 0,
                           facts.has_id ? 1 : 0,
                           has_albedo ? 1 : 0,
                           width_,
                           height_};
  STILLRAY_RETURN_IF_ERROR(Run(commands, kSelectGuides, images, BytesOf(push)));
  WaitForWrites(commands);
  if (RescalesMoments(facts)) {
    const ImageRef moments[] = {from.lights[lights.direct],
                                from.lights[lights.indirect],
                                from.second_moments[lights.direct],
                                from.second_moments[lights.indirect],
                                from.albedos[lights.albedo],
                                RefTo(to.albedo),
                                RefTo(to.direct_moment),
                                RefTo(to.indirect_moment)};
    STILLRAY_RETURN_IF_ERROR(
        Run(commands, kRescaleMoments, moments, BytesOf(RescalePush{width_, height_})));
    WaitForWrites(commands);
  }
  End(commands, &layer_times_);
  return Status::Ok();
}

Status LayerPasses::RecordRest(gpu::CommandList* commands, const FrameFacts& facts,
                               const FrameInputs& from, const ImageRef& picture) {
  const LayerImages& own = *images_;
  const ImageRef images[] = {from.depth,
                             from.motion,
                             facts.has_id ? from.id : RefTo(own.id),
                             facts.has_emission ? from.emission : RefTo(own.albedo),
                             RefTo(own.motion),
                             RefTo(own.albedo),
                             picture,
                             RefTo(own.picture_motion),
                             RefTo(own.emission)};
  const AddPush push = {facts.has_id ? 1 : 0, facts.has_emission ? 1 : 0,
                        facts.length_of_images ? 1 : 0, width_, height_};
  WaitForWrites(commands);  // writes of the layer's output image
  Begin(commands, kAddLayer, &rest_times_);
  STILLRAY_RETURN_IF_ERROR(Run(commands, kAddLayer, images, BytesOf(push)));
  WaitForWrites(commands);
  End(commands, &rest_times_);
  return Status::Ok();
}

bool LayerPasses::HasPreviousNormals(const FrameFacts& frame) const {
  return frame.has_previous_normal && images_->previous_normal != nullptr;
}

bool LayerPasses::RescalesMoments(const FrameFacts& frame) const {
  const uint32_t lights = LightsOf(source_).bits();
  return (frame.second_moments & frame.lights & lights) == lights &&
         images_->direct_moment != nullptr;
}

FrameFacts LayerPasses::FactsOfLayer(const FrameFacts& frame) const {
  FrameFacts facts = frame;
  const LayerLights& lights = LightsOf(source_);
  facts.lights &= lights.bits();
  facts.second_moments &= RescalesMoments(frame) ? lights.bits() : 0u;
  facts.has_previous_normal = HasPreviousNormals(frame);
  facts.albedos = 1u << lights.albedo;
  facts.has_emission = false;
  facts.has_background = false;
  facts.has_roughness = true;
  facts.has_reflection = false;
  facts.has_refraction = false;
  facts.albedo_of_images = false;
  facts.length_of_images = false;
  facts.keeps_length = true;
  facts.is_displayed = false;
  return facts;
}

FrameInputs LayerPasses::InputsOfLayer(const FrameInputs& frame) const {
  const LayerImages& own = *images_;
  FrameInputs inputs = frame;
  inputs.depth = RefTo(own.depth);
  inputs.normal = RefTo(own.normal);
  inputs.motion = RefTo(own.motion);
  inputs.id = RefTo(own.id);
  inputs.roughness = RefTo(own.roughness);
  const LayerLights& lights = LightsOf(source_);
  inputs.albedos[lights.albedo] = RefTo(own.albedo);
  inputs.previous_normal = RefTo(own.previous_normal);
  inputs.second_moments[lights.direct] = RefTo(own.direct_moment);
  inputs.second_moments[lights.indirect] = RefTo(own.indirect_moment);
  return inputs;
}

bool LayerPasses::SumsImages(const FrameFacts& frame) const {
  return source_ == GuideSource::kReflection &&
         SumsImageAlbedo(frame.albedos, frame.has_incomplete_guides);
}

FrameFacts LayerPasses::FactsOfRest(const FrameFacts& frame) const {
  FrameFacts facts = frame;
  const uint32_t lights = LightsOf(source_).bits();
  facts.black_lights |= frame.lights & lights;
  facts.second_moments &= ~lights;
  facts.has_emission = true;
  (source_ == GuideSource::kReflection ? facts.has_reflection : facts.has_refraction) = false;
  facts.albedo_of_images = facts.albedo_of_images || SumsImages(frame);
  facts.length_of_images = true;
  return facts;
}

FrameInputs LayerPasses::InputsOfRest(const FrameFacts& facts, const FrameInputs& frame) const {
  FrameInputs inputs = frame;
  if (SumsImages(facts)) {
    // Only for sum_albedo: the rest has no radiance that is divided by this albedo.
    inputs.albedos[LightsOf(source_).albedo] = RefTo(images_->albedo);
  }
  inputs.motion = RefTo(images_->picture_motion);
  inputs.emission = RefTo(images_->emission);
  return inputs;
}

gpu::MemoryUse LayerPasses::memory() const {
  return images_ != nullptr ? images_->arena.Need() : gpu::MemoryUse();
}

void LayerPasses::AddTimes(std::vector<StageTime>* times) const {
  for (const gpu::Timestamps* of_part : {&layer_times_, &rest_times_}) {
    for (const gpu::DeviceTime& time : of_part->Read()) {
      times->push_back({time.name, time.milliseconds});
    }
  }
}

}  // namespace stillray::vulkan

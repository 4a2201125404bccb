// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// clang-format off
// The order of the passes of one frame:
//
//   pass                 reads                               writes                    bytes per pixel read, written in halves; n signals
//   fill_guides          guides, samples, held guides        completed guides          see fill_guides/   (only where some are unknown)
//   resample_history     history, guides                     history                   16 + 18 n, 18 n  (only after the size changes, as the next)
//   resample_guides      guides, last image and albedo       guides, image, albedo     32, 32
//   measure_light        lights, albedos of every 16th pixel sums
//   prepare_guides       depth, normal, id, history          guides, sums              inputs + 8 n, 18
//   update_exposure      sums                                exposures, limit of negative light, scales
//   demodulate           lights, albedos, samples            new light                 inputs, 8 n
//   suppress_fireflies   new light                           new light                 8 n, 8 n  (only when clamped)
//   reproject            guides, history, confidence         fetched history           36 + 18 n, 18 n
//   update_compression   sums                                scales                    (the first frame, only for limit_history)
//   compare_history      new light, fetched history, guides  compared, half size       16 + 18 n, 4 + 4 n  (only for limit_history, as the next six)
//   atrous, 3 levels     compared, coarse guides             compared                  3 (4 + 2 n), 3 (2 n)
//   measure_change       compared                            compared, counts          2 n, 2 n
//   atrous, wide         compared, coarse guides             changes                   4 + 2 n, 2 n
//   correct_history      compared, changes                   compared, ratio           6 n, 3 n
//   atrous, 2 levels     compared, coarse guides             compared                  2 (4 + 2 n), 2 (2 n)
//   limit_history        compared, ratio, guides             limits                    18 + 22 n, 8 n
//   accumulate           new light, history, confidence      history                   26 n or 34 n, 18 n
//   (without limit_history reproject and accumulate are one pass: 36 + 24 n, 16 n)
//   merge_future         history, later frames               known history             48 n, 16 n  (only where the future is known)
//   estimate_variance    known history, guides               light of the wavelet      16 + 24 n, 8 n
//   smooth_variance      light of the wavelet                light of the wavelet      8 n, 8 n  (only for prefilter_variance=once)
//   per level:
//     pilot              light of the wavelet, guides        fetched history           16 + 16 n, 8 n  (atrous; first and second level)
//     prefilter_variance light of the wavelet                luminance factors         16 n, 2 n
//     atrous             light, luminance factors, guides    light of the wavelet      16 + 10 n, 8 n
//   clip_outliers        light                               light                     8 n, 8 n
//   restore_energy       light before and after, guides      light                     64 + 30 n, 12 n  (a pass before the levels; half the size)
//   keep_samples         new light, light, history           light                     4 + 108 n, 40 n  (only frames of several samples)
//   keep_mirrors         new light, light, roughness         light                     12 + 96 n, 40 n  (only where roughness is given)
//   store_signal         light                               output of a signal        8, 8 or 16  (only those requested)
//   remodulate           light, albedos, unfiltered light    image                     inputs + 8 n, 8
//   fxaa                 image, length                       image                     16, 8
//   follow_light         light, albedos, motion, of blocks   ratio of blocks           9 + inputs / 16, 2
//   sum_albedo           albedos                             albedo, range of blocks   inputs, 9  (only with taa_clamp=light)
//   spline_coefficients  last image, last albedo             light of the wavelet      16, 16  (only with taa_filter=spline)
//   antialias            image, last image, motion           image, albedo, output     inputs + 65, 16 + output
//   tonemap              image                               display                   8, 4
// clang-format on

#include "denoise/vulkan/frame_pipeline.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "denoise/stages/follow_light_shared.h"
#include "denoise/stages/keep_mirrors.h"
#include "denoise/stages/keep_samples.h"
#include "denoise/stages/limit_history.h"

namespace stillray::vulkan {
namespace {

/// Limits of a descriptor pool: for passes of two frames, one set for each combination of swapped
/// images.
constexpr uint32_t kMostSets = 512;
constexpr gpu::SetShape kMostDescriptors = {4096, 1024, 128, 256};
constexpr uint32_t kMostMarks = 128;

Status CheckSize(const gpu::DeviceContext& context, const PipelineOptions& o) {
  const uint32_t most = context.limits.maxImageDimension2D;
  const bool fits =
      o.width >= 1 && o.height >= 1 && static_cast<uint32_t>(std::max(o.width, o.height)) <= most;
  return fits ? Status::Ok()
              : Status::InvalidArgument(
                    fmt::format("frames are {}x{}, expected 1x1 to {}x{} on this device", o.width,
                                o.height, most, most));
}

/// Bytes of shared memory of the largest tile.
uint32_t TileBytes(int signals, int radius) {
  const int texels = (kGroupWidth + 2 * radius * kMostTileResidues) * (kGroupHeight + 2 * radius);
  return static_cast<uint32_t>(texels * (20 + 24 * signals));
}

/// STILLRAY_ATROUS selects the variant of the wavelet, for comparisons: `plain` or `tile`. By
/// default GPUs use tiles if shared memory is large enough; on software drivers, whose shared
/// memory is ordinary memory, tiles are slower.
Result<bool> ChooseTiles(const gpu::DeviceContext& context, int signals) {
  const char* given = std::getenv("STILLRAY_ATROUS");
  const std::string_view variant = given != nullptr ? given : "";
  if (!variant.empty() && variant != "plain" && variant != "tile") {
    return Status::InvalidArgument(
        fmt::format("STILLRAY_ATROUS is '{}', expected plain or tile", variant));
  }
  constexpr int kLargestRadius = 2;
  const bool fits = TileBytes(signals, kLargestRadius) <= context.limits.maxComputeSharedMemorySize;
  return fits && variant != "plain" && (variant == "tile" || !context.is_software);
}

}  // namespace

FramePipeline::FramePipeline(const gpu::DeviceContext* context)
    : context_(context), arena_(context), sets_(context), times_(context) {}

Result<gpu::MemoryUse> FramePipeline::Need(const gpu::DeviceContext* context,
                                           const PipelineOptions& o) {
  STILLRAY_RETURN_IF_ERROR(CheckSize(*context, o));
  gpu::Arena arena(context);
  const auto signals = static_cast<int>(GroupsOf(o.settings.signals, o.transmission).size());
  const Result<FrameImages> images =
      AddImages(ShapeOf(o.settings, o.width, o.height, signals, o.storage), &arena);
  STILLRAY_RETURN_IF_ERROR(images.status());
  gpu::MemoryUse need = arena.Need();
  if (o.fills_guides) {
    const Result<gpu::MemoryUse> more = FillGuidesPass::Need(context, FillGuidesOptions(o));
    STILLRAY_RETURN_IF_ERROR(more.status());
    need += *more;
  }
  return need;
}

/// Options of fill_guides with memory for all images that frames may have.
FillGuidesPass::Options FramePipeline::FillGuidesOptions(const PipelineOptions& o) {
  constexpr uint32_t kAll = (1u << kGuideColours) - 1;
  constexpr uint32_t kTransmission = 4;
  return {o.width, o.height, o.storage, true, o.transmission ? kAll : kAll & ~kTransmission};
}

Status FramePipeline::MakeFillGuidesPass(const FillGuidesPass::Options& options) {
  Result<std::unique_ptr<FillGuidesPass>> made =
      FillGuidesPass::Create(context_, pipelines_.get(), options);
  STILLRAY_RETURN_IF_ERROR(made.status());
  fill_guides_ = std::move(made.value());
  return Status::Ok();
}

Status FramePipeline::PrepareFilling(const FrameFacts& facts) {
  if (!facts.has_incomplete_guides || (fill_guides_ != nullptr && fill_guides_->Fits(facts))) {
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(sets_.Clear());
  fill_guides_.reset();
  return MakeFillGuidesPass({shape_.width, shape_.height, shape_.storage, facts.has_id,
                             FillGuidesPass::ColoursOf(facts)});
}

gpu::MemoryUse FramePipeline::memory() const {
  gpu::MemoryUse use = arena_.Need();
  if (fill_guides_ != nullptr) {
    use += fill_guides_->memory();
  }
  return use;
}

Result<std::unique_ptr<FramePipeline>> FramePipeline::Create(const gpu::DeviceContext* context,
                                                             const PipelineOptions& o) {
  STILLRAY_RETURN_IF_ERROR(CheckSize(*context, o));
  std::unique_ptr<FramePipeline> made(new FramePipeline(context));
  made->transmission_ = o.transmission;
  made->timed_ = o.timed;
  made->groups_ = GroupsOf(o.settings.signals, o.transmission);
  made->shape_ =
      ShapeOf(o.settings, o.width, o.height, static_cast<int>(made->groups_.size()), o.storage);
  made->of_images_ = {o.width, o.height};
  made->grid_ = GroupsFor(o.width, o.height);
  const Result<bool> tiles = ChooseTiles(*context, made->shape_.signals);
  STILLRAY_RETURN_IF_ERROR(tiles.status());
  made->uses_tiles_ = *tiles;
  Result<FrameImages> images = AddImages(made->shape_, &made->arena_);
  if (!images.ok()) {
    return images.status();
  }
  made->images_ = *images;
  STILLRAY_RETURN_IF_ERROR(made->arena_.Allocate());
  STILLRAY_RETURN_IF_ERROR(made->sets_.CreatePool(kMostSets, kMostDescriptors, o.in_flight));
  if (o.timed) {
    STILLRAY_RETURN_IF_ERROR(made->times_.Create(kMostMarks, std::max(o.in_flight, 1u)));
  }
  made->pipelines_ = std::make_unique<Pipelines>(context, o.storage, made->shape_.octahedral,
                                                 made->shape_.signals, &made->sets_);
  STILLRAY_RETURN_IF_ERROR(made->MakePipelines(o.settings));
  if (o.fills_guides) {
    STILLRAY_RETURN_IF_ERROR(made->MakeFillGuidesPass(FillGuidesOptions(o)));
  }
  return made;
}

Groups FramePipeline::CoarseGrid() const {
  return GroupsFor(CoarseSize(shape_.width), CoarseSize(shape_.height));
}

/// Compiles all shaders that the settings may use, so that none is compiled during recording.
Status FramePipeline::MakePipelines(const Settings& settings) {
  for (int i = 0; i <= static_cast<int>(Shader::kStoreSignal); ++i) {
    const auto shader = static_cast<Shader>(i);
    if (shader == Shader::kAtrous || shader == Shader::kAtrousTile) {
      continue;
    }
    const Result<const gpu::Pipeline*> made = pipelines_->Find(shader);
    STILLRAY_RETURN_IF_ERROR(made.status());
  }
  return MakeAtrousPipelines(settings);
}

bool FramePipeline::Fits(const Settings& settings, int width, int height, bool transmission) const {
  const std::span<const SignalGroup> groups = GroupsOf(settings.signals, transmission);
  Shape of_images = shape_;
  of_images.width = of_images_.width;
  of_images.height = of_images_.height;
  return groups.data() == groups_.data() && transmission == transmission_ &&
         ShapeOf(settings, width, height, static_cast<int>(groups.size()), shape_.storage) ==
             of_images;
}

void FramePipeline::UseSize(Size size) {
  shape_.width = size.width;
  shape_.height = size.height;
  grid_ = GroupsFor(size.width, size.height);
  if (fill_guides_ != nullptr) {
    fill_guides_->Resize(size.width, size.height);
  }
}

void FramePipeline::Resize(int width, int height) {
  if (width == shape_.width && height == shape_.height) {
    return;
  }
  if (!resized_from_.has_value()) {
    resized_from_ = Size{shape_.width, shape_.height};
  }
  UseSize({width, height});
  progress_.has_followed = false;
}

Status FramePipeline::SetSettings(const Settings& settings) {
  return MakePipelines(settings);
}

void FramePipeline::Reset() {
  progress_ = SequenceProgress();
  if (fill_guides_ != nullptr) {
    fill_guides_->Reset();
  }
}

void FramePipeline::PrepareImages(VkCommandBuffer commands) {
  if (prepared_) {
    return;
  }
  prepared_ = true;
  arena_.RecordFirstUse(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                        VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT);
  context_->vk.CmdFillBuffer(commands, images_.state->buffer, 0, VK_WHOLE_SIZE, 0);
  context_->vk.CmdFillBuffer(commands, images_.partials->buffer, 0, VK_WHOLE_SIZE, 0);
}

void FramePipeline::UploadParameters(PassRecorder* recorder, const FrameParameters& parameters) {
  recorder->Barrier();  // the previous frame may still read them
  recorder->commands()->Update(images_.parameters->buffer, 0,
                               std::as_bytes(std::span(&parameters, 1)));
  static_assert(offsetof(FrameState, bad_guides) ==
                offsetof(FrameState, non_finite) + 2 * sizeof(uint32_t));
  recorder->commands()->Fill(images_.state->buffer, offsetof(FrameState, non_finite),
                             3 * sizeof(uint32_t), 0);
}

void FramePipeline::Keep(PassRecorder* recorder, std::string_view name, const gpu::Image* image) {
  if (observer_ != nullptr && observer_->Wants(name)) {
    recorder->Barrier();
    recorder->commands()->Call([observer = observer_, name, image](VkCommandBuffer commands) {
      observer->Keep(commands, name, *image);
    });
  }
}

/// Composes an image from the current signals, for the observer only.
void FramePipeline::KeepPicture(PassRecorder* recorder, std::string_view name,
                                const gpu::Image* light) {
  if (observer_ != nullptr && observer_->Wants(name)) {
    const int32_t counts = 0;
    recorder->Run(Shader::kRemodulate, grid_, {light, images_.scratch}, counts);
    Keep(recorder, name, images_.scratch);
  }
}

/// Runs demodulate and suppress_fireflies.
void FramePipeline::GatherLight(const FramePlan& plan, PassRecorder* recorder) {
  const FrameImages& i = images_;
  const bool clamps = plan.runs.clamp_fireflies;
  recorder->Run(Shader::kDemodulate, grid_, {clamps ? i.unclamped : i.noisy, i.within});
  if (clamps) {
    recorder->Run(Shader::kSuppressFireflies, grid_, {i.unclamped, i.noisy});
  }
  Keep(recorder, "noisy", i.noisy);
}

void FramePipeline::Reproject(PassRecorder* recorder) {
  const FrameImages& i = images_;
  const HistoryImages& h = i.history;
  const HistoryImages& f = i.fetched;
  recorder->Run(
      Shader::kReproject, grid_,
      {i.guides.surface, i.guides.detail, i.previous_guides.surface, i.previous_guides.detail,
       h.colour, h.behind, h.moments, h.compressed, f.colour, f.behind, f.moments, f.compressed});
  Keep(recorder, "fetched", f.moments);
}

/// Whether reproject and accumulate are one pass: no pass reads the fetched history between them.
bool FramePipeline::JoinsAccumulation(const FramePlan& plan) const {
  const bool observed = observer_ != nullptr && observer_->Wants("fetched");
  return plan.runs.reproject && !plan.runs.limit_history && !shape_.with_compressed && !observed;
}

void FramePipeline::ReprojectAndAccumulate(PassRecorder* recorder) {
  const FrameImages& i = images_;
  const HistoryImages& h = i.history;
  const HistoryImages& f = i.fetched;
  recorder->Run(Shader::kReprojectAccumulate, grid_,
                {i.guides.surface, i.guides.detail, i.previous_guides.surface,
                 i.previous_guides.detail, h.colour, h.behind, h.moments, h.compressed, i.noisy,
                 i.within, f.colour, f.behind, f.moments});
  std::swap(images_.history, images_.fetched);
}

/// Runs levels on the coarse grid, alternating between the first and the second image.
/// \param stage  stage name for timings
void FramePipeline::RunComparedLevels(const char* stage, int levels, PassRecorder* recorder) {
  const FrameImages& i = images_;
  for (int level = 0; level < levels; ++level) {
    const LevelPush push = {ComparedLevel(level).step, level, 1};
    recorder->CountAs(stage);
    RunAtrous(CoarseSize(shape_.width), CoarseSize(shape_.height),
              {i.coarse.surface, i.coarse.detail, i.compared[level & 1], i.luminance_factor,
               i.nothing, i.turn2, i.compared[(level & 1) ^ 1]},
              push, AtrousConstants(ComparedLevel(level), 0, true), recorder);
  }
}

/// Averages the changes in the first image of the coarse grid to the wide change.
void FramePipeline::RunWideLevel(PassRecorder* recorder) {
  const FrameImages& i = images_;
  const LevelPush push = {kWideLevel.step, 0, 1};
  recorder->CountAs("limit_history");
  RunAtrous(CoarseSize(shape_.width), CoarseSize(shape_.height),
            {i.coarse.surface, i.coarse.detail, i.compared[0], i.luminance_factor, i.nothing,
             i.turn2, i.wide},
            push, AtrousConstants(kWideLevel, 0, true), recorder);
}

/// Runs limit_history, and writes ratio and bias to the second image of the wavelet.
void FramePipeline::LimitHistory(const FramePlan& plan, PassRecorder* recorder) {
  const FrameImages& i = images_;
  recorder->Run(
      Shader::kCompareHistory, CoarseGrid(),
      {i.guides.surface, i.guides.detail, i.noisy, i.fetched.moments, i.fetched.compressed,
       i.coarse.surface, i.coarse.detail, i.compared[0], i.compressed_light});
  static_assert(kCorrectHistoryLevels % 2 == 1 && kLimitHistoryLevels % 2 == 0,
                "the results lie in the second and in the first image, that of the first of two "
                "levels in the second");
  if (plan.limit_history.correct_history != 0) {
    RunComparedLevels("limit_history", kCorrectHistoryLevels, recorder);
    if (plan.limit_history.wide_signals > 0 || plan.runs.find_moving_light) {
      recorder->Run(Shader::kMeasureChange, CoarseGrid(), {i.compared[1], i.compared[0]});
    }
    if (plan.limit_history.wide_signals > 0) {
      RunWideLevel(recorder);
    }
  }
  recorder->Run(Shader::kCorrectHistory, CoarseGrid(),
                {i.compared[1], i.compressed_light, i.wide, i.ratio, i.compared[0]});
  RunComparedLevels("limit_history", kLimitHistoryLevels, recorder);
  recorder->Run(Shader::kLimitHistory, grid_,
                {i.guides.surface, i.guides.detail, i.coarse.surface, i.compared[0], i.compared[1],
                 i.ratio, i.noisy, i.wavelet[1]});
  Keep(recorder, "compared", i.wavelet[1]);
}

void FramePipeline::Accumulate(const FramePlan& plan, PassRecorder* recorder) {
  const FrameImages& i = images_;
  const HistoryImages& h = i.history;
  const HistoryImages& f = i.fetched;
  const int32_t push = plan.runs.limit_history ? 1 : 0;
  recorder->Run(Shader::kAccumulate, grid_,
                {i.noisy, i.within, f.colour, f.behind, f.moments, f.compressed, i.wavelet[1],
                 h.colour, h.behind, h.moments, h.compressed},
                push);
}

/// Runs merge_future; overwrites the fetched history, which is no longer read.
void FramePipeline::MergeFuture(const FutureImages& future, PassRecorder* recorder) {
  const HistoryImages& h = images_.history;
  known_.colour = images_.fetched.colour;
  known_.moments = images_.fetched.moments;
  recorder->Run(Shader::kMergeFuture, grid_,
                {h.colour, h.moments, future.light, future.moments, known_.colour, known_.moments});
}

void FramePipeline::Compose(const gpu::Image* light, PassRecorder* recorder) {
  const int32_t counts = 1;
  recorder->Run(Shader::kRemodulate, grid_, {light, images_.picture}, counts);
  Keep(recorder, "aliased", images_.picture);
}

/// Runs follow_light: the change of the radiance since the last frame.
void FramePipeline::FollowLight(const FramePlan& plan, PassRecorder* recorder) {
  std::swap(images_.followed, images_.followed_before);
  const FrameImages& i = images_;
  const Groups blocks = GroupsFor(FollowSize(shape_.width), FollowSize(shape_.height));
  const int32_t has_before = plan.has_followed ? 1 : 0;
  recorder->Run(
      Shader::kFollowLight, blocks,
      {i.guides.surface, light_, i.history.moments, i.followed_before, i.followed, i.changes},
      has_before);
  recorder->Run(Shader::kFollowChange, blocks,
                {i.guides.surface, i.guides.detail, i.changes, i.followed_ratio});
}

void FramePipeline::Finish(const FramePlan& plan, PassRecorder* recorder) {
  const FrameImages& i = images_;
  if (plan.runs.fxaa) {
    recorder->Run(Shader::kFxaa, grid_, {i.picture, i.history.moments, i.scratch});
    std::swap(images_.picture, images_.scratch);
  }
  if (plan.has_picture && plan.antialias.follow_light != 0) {
    FollowLight(plan, recorder);
  }
  if (plan.antialias.clamp_light != 0) {
    recorder->Run(Shader::kSumAlbedo, grid_, {i.albedo, i.albedo_range});
  }
  const auto& coefficients = i.wavelet;  // no longer read
  if (plan.has_picture && plan.antialias.resampling == kSpline) {
    recorder->Run(Shader::kSplineCoefficients, grid_, {i.shown, coefficients[0]});
    if (plan.has_albedo) {
      recorder->Run(Shader::kSplineCoefficients, grid_, {i.albedo_before, coefficients[1]});
    }
  }
  const int32_t has_albedo = plan.has_albedo ? 1 : 0;
  recorder->Run(Shader::kAntialias, grid_,
                {i.guides.surface, i.guides.detail, i.history.moments, i.picture, i.shown,
                 coefficients[0], i.followed_ratio, i.albedo, i.albedo_range, i.albedo_before,
                 coefficients[1], i.previous_guides.surface, i.scratch, i.albedo_out},
                has_albedo);
  std::swap(images_.shown, images_.scratch);
  if (plan.antialias.clamp_light != 0) {
    std::swap(images_.albedo_before, images_.albedo_out);
  }
}

/// Sets parameters and inputs, and runs fill_guides if some guides are unknown.
void FramePipeline::UseInputs(const FramePlan& plan, const FrameFacts& facts,
                              const FrameInputs& inputs, FrameParameters* parameters,
                              PassRecorder* recorder) {
  const bool fills = plan.runs.fill_guides && fill_guides_ != nullptr;
  if (fills) {
    fill_guides_->Begin(facts, parameters);
  } else if (fill_guides_ != nullptr) {
    fill_guides_->Reset();
  }
  UploadParameters(recorder, *parameters);
  recorder->UseFrame(inputs, images_);
  if (fills) {
    recorder->UseFrame(fill_guides_->Record(recorder, inputs, *images_.state), images_);
  }
}

/// Resamples the history, and the images that antialias keeps, to the size of this frame.
void FramePipeline::ResampleHistory(Size before, PassRecorder* recorder) {
  FrameImages& i = images_;
  recorder->Run(Shader::kResampleHistory, grid_,
                {i.previous_guides.surface, i.history.colour, i.history.behind, i.history.moments,
                 i.history.compressed, i.fetched.colour, i.fetched.behind, i.fetched.moments,
                 i.fetched.compressed},
                before);
  // The images for this frame's guides are still free.
  recorder->Run(Shader::kResampleGuides, grid_,
                {i.previous_guides.surface, i.previous_guides.detail, i.shown, i.albedo_before,
                 i.guides.surface, i.guides.detail, i.scratch, i.albedo_out},
                before);
  std::swap(i.history, i.fetched);
  std::swap(i.guides, i.previous_guides);
  std::swap(i.shown, i.scratch);
  if (shape_.with_albedo) {
    std::swap(i.albedo_before, i.albedo_out);
  }
}

/// Copies the requested signals to the caller's images.
void FramePipeline::StoreSignals(const FrameInputs& inputs, PassRecorder* recorder) {
  for (size_t s = 0; s < groups_.size(); ++s) {
    if (inputs.filtered[s].view == VK_NULL_HANDLE) {
      continue;
    }
    gpu::Image& out = filtered_[s];
    out.view = inputs.filtered[s].view;
    const gpu::Image* const as_float = inputs.colour_is_half ? images_.no_float_output : &out;
    const gpu::Image* const as_half = inputs.colour_is_half ? &out : images_.no_half_output;
    const auto push = static_cast<int32_t>(s);
    recorder->Run(Shader::kStoreSignal, grid_, {light_, as_float, as_half}, push);
  }
}

/// All passes before reprojection.
void FramePipeline::BeginFrame(const FramePlan& plan, const FrameFacts& facts,
                               const FrameInputs& inputs, PassRecorder* recorder) {
  recorder->commands()->Call([this](VkCommandBuffer commands) { PrepareImages(commands); });
  std::swap(images_.guides, images_.previous_guides);
  FrameParameters parameters = MakeParameters(plan, facts, shape_);
  parameters.colour_is_half = inputs.colour_is_half ? 1 : 0;
  UseInputs(plan, facts, inputs, &parameters, recorder);
  if (resized_from_.has_value() && (plan.runs.reproject || plan.has_picture)) {
    ResampleHistory(*resized_from_, recorder);
  }
  resized_from_.reset();
  const Groups measured =
      GroupsFor((shape_.width + parameters.measure_stride - 1) / parameters.measure_stride,
                (shape_.height + parameters.measure_stride - 1) / parameters.measure_stride);
  // The few workgroups of measure_light run in parallel with prepare_guides.
  recorder->Run(Shader::kMeasureLight, measured, {});
  recorder->UseBuffers({images_.history_sums});
  recorder->Run(
      Shader::kPrepareGuides, grid_,
      {images_.history.colour, images_.guides.surface, images_.guides.detail, images_.turn2});
  const std::array<uint32_t, 2> groups = {measured.count(), grid_.count()};
  recorder->Run(Shader::kUpdateExposure, {1, 1}, {}, groups);
  GatherLight(plan, recorder);
  if (shape_.with_compressed && !plan.runs.reproject) {
    recorder->Run(Shader::kUpdateCompression, {1, 1}, {}, grid_.count());
  }
}

/// Fetches the history of this frame's pixels, and runs limit_history.
void FramePipeline::FetchHistory(const FramePlan& plan, PassRecorder* recorder) {
  if (plan.runs.reproject) {
    Reproject(recorder);
  }
  if (plan.runs.limit_history) {
    LimitHistory(plan, recorder);
  }
}

PassRecorder FramePipeline::BeginPasses(gpu::CommandList* commands) {
  sets_.BeginFrame(frames_);
  if (Times() != nullptr) {
    commands->BeginTimes(&times_, frames_);
  }
  return {pipelines_.get(), &sets_, Times(), commands};
}

void FramePipeline::EndPasses(const FramePlan& plan, PassRecorder* recorder) {
  recorder->EndParts();
  pass_bytes_ = recorder->bytes();
  progress_ = plan.after;
  ++frames_;
}

FramePipeline::Checkpoint FramePipeline::checkpoint() const {
  return {images_,
          progress_,
          fill_guides_ != nullptr ? fill_guides_->progress() : FillGuidesPass::Progress(),
          {shape_.width, shape_.height},
          resized_from_,
          frames_};
}

void FramePipeline::GoBackTo(const Checkpoint& checkpoint) {
  UseSize(checkpoint.size);
  resized_from_ = checkpoint.resized_from;
  images_ = checkpoint.images;
  progress_ = checkpoint.progress;
  if (fill_guides_ != nullptr) {
    fill_guides_->GoBackTo(checkpoint.filling);
  }
  frames_ = checkpoint.frames;
}

Status FramePipeline::RecordBackward(gpu::CommandList* commands, const FramePlan& plan,
                                     const FrameFacts& facts, const FrameInputs& inputs,
                                     const FutureImages& future) {
  PassRecorder recorder = BeginPasses(commands);
  BeginFrame(plan, facts, inputs, &recorder);
  FetchHistory(plan, &recorder);
  if (plan.runs.reproject) {
    const int32_t push = plan.runs.limit_history ? 1 : 0;
    const HistoryImages& f = images_.fetched;
    recorder.Run(Shader::kShortenHistory, grid_,
                 {f.colour, f.moments, images_.wavelet[1], future.light, future.moments}, push);
  }
  Accumulate(plan, &recorder);
  EndPasses(plan, &recorder);
  return recorder.status();
}

Status FramePipeline::Record(gpu::CommandList* commands, const FramePlan& plan,
                             const FrameFacts& facts, const FrameInputs& inputs,
                             FrameObserver* observer, const FutureImages* future) {
  observer_ = observer;
  PassRecorder recorder = BeginPasses(commands);
  BeginFrame(plan, facts, inputs, &recorder);
  if (JoinsAccumulation(plan)) {
    ReprojectAndAccumulate(&recorder);
  } else {
    FetchHistory(plan, &recorder);
    Accumulate(plan, &recorder);
  }
  known_ = images_.history;
  Keep(&recorder, "joined", known_.moments);
  if (plan.runs.merge_future) {
    MergeFuture(*future, &recorder);
  }
  Keep(&recorder, "accumulated", known_.colour);
  Keep(&recorder, "moments", known_.moments);
  KeepPicture(&recorder, "temporal", known_.colour);
  light_ = known_.colour;
  if (plan.runs.wavelet) {
    BeginFilter(plan, &recorder);
    RunLevels(plan, &recorder);
  }
  if (plan.runs.keep_samples) {
    KeepSamples(&recorder);
  }
  if (plan.runs.keep_mirrors) {
    KeepMirrors(&recorder);
  }
  Keep(&recorder, "filtered", light_);
  StoreSignals(inputs, &recorder);
  Compose(light_, &recorder);
  Finish(plan, &recorder);
  if (plan.runs.tonemap) {
    recorder.Run(Shader::kTonemap, grid_, {images_.shown});
  }
  EndPasses(plan, &recorder);
  observer_ = nullptr;
  return recorder.status();
}

}  // namespace stillray::vulkan

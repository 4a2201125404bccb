// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/vulkan_renderer.h"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "render/base_colour.h"
#include "render/lights.h"
#include "render/moment.h"
#include "render/pixel_order.h"
#include "render/previous_normals.h"
#include "render/scene_check.h"
#include "render/trace_context.h"
#include "render/virtual_image.h"
#include "render/vulkan/batch_store.h"
#include "render/vulkan/device_store.h"
#include "render/vulkan/picture_tracer.h"
#include "render/vulkan/submission_pace.h"

namespace stillray::render {
namespace {

/// Maximum number of samples of batches per submission, which bounds the number of timestamps.
constexpr int kMostSamples = 16;
constexpr uint32_t kMostMarks = 4096;

GpuView MakeGpuView(const CameraView& view) {
  return {view.position, view.half_width,  view.right,        view.half_height,
          view.up,       view.width,       view.forward,      view.height,
          view.shift,    view.lens_radius, view.inverse_focus};
}

/// The outputs of a batch.
struct BatchPlan {
  bool guides = false;
  ImageKinds images;          // virtual guides
  bool finds_images = false;  // they are found, also if they are no output
  bool reference = false;
  uint64_t first_sample = 0;
  int samples = 0;
};

/// The work of one submission for a batch: guides if no sample is `done` yet, then a number of
/// samples, and the results after the last sample.
struct BatchWork {
  GpuBatch batch = {};
  BatchPlan plan;
  int done = 0;
  int samples = 0;
  // Above 0: resumes unfinished paths of the first sample after this many steps of resumed_part.
  int resumed_steps = 0;
  int resumed_part = 0;

  bool is_last() const { return done + samples == plan.samples; }
  int steps() const { return std::max(samples, 1); }  // guides alone count as one sample
  double paths() const { return static_cast<double>(batch.count) * steps(); }
};

class VulkanRenderer final : public Renderer {
 public:
  VulkanRenderer(const Scene& scene, const RenderSettings& settings,
                 std::shared_ptr<gpu::Device> device, const VulkanRenderOptions& options)
      : device_(std::move(device)),
        tracer_options_{DrawsFirstHits(device_->info(), options.first_hits), options.most_pixels},
        way_(options.way),
        textures_(options.textures),
        settings_(settings),
        any_transmission_(AnyTransmission(scene)),
        images_(ImagesOfScene(scene)),
        state_(scene),
        lights_(state_),
        device_store_(device_),
        times_(&device_->context()),
        pace_(options.submission_ms) {}

  Status Build();
  Status MakePicture(const RenderSettings& settings);
  Status SetSettings(const RenderSettings& settings) override;
  const RenderSettings& settings() const override { return settings_; }
  const RenderTimings& timings() const override { return timings_; }
  size_t memory_bytes() const override {
    return state_.memory_bytes() + lights_.memory_bytes() + accel_->memory().bytes +
           gpu_lights_->memory().bytes + picture_->memory_bytes();
  }

 private:
  Status TraceFrame(const RenderMoment& moment, Frame* frame,
                    const RenderProgress& progress) override;
  Status TraceReference(const RenderMoment& moment, int spp, Image3* radiance,
                        const RenderProgress& progress) override;
  /// Whether primary hits may be rasterised, which needs a single centre of projection.
  bool MayDraw() const { return picture_->draws() && frame_.view.lens_radius <= 0.0f; }
  GpuTracer* tracer() const { return picture_->tracer(); }
  Status MoveTo(const RenderMoment& moment);
  TracerParts PartsFor(const RenderSettings& settings) const;
  Status AllowHostResults();
  /// Kinds of virtual guides of frames with the cameras of SetCameras.
  ImageKinds ShownImages() const {
    return WantedImages(settings_, images_, frame_.view.lens_radius > 0.0f);
  }
  void SetCameras(const RenderMoment& moment);
  void SetSampling(vec2 jitter, SampleStream stream);
  void FilterTextures();
  BatchResults ResultsOf(const BatchPlan& plan) const;
  template <typename Store>
  Status ForTiles(const BatchPlan& plan, ProgressMeter* meter, const Store& store);
  Status TraceBatch(const GpuBatch& batch, const BatchPlan& plan, ProgressMeter* meter);
  Status Add(const BatchWork& work, ProgressMeter* meter);
  Status Flush(ProgressMeter* meter);
  void SelectSample(uint64_t sample, GpuBatch* batch) const;
  int MostPaths() const;
  /// Whether the plan has a single sample whose radiance replaces the sums. Not with a lens, which
  /// also sums guides, nor for references, which also store rounding errors.
  bool HasSingleSample(const BatchPlan& plan) const {
    return plan.samples == 1 && !plan.reference && frame_.view.lens_radius <= 0.0f;
  }
  GpuTracer::Results ResultsAfter(const BatchWork& work) const;
  Status Record(VkCommandBuffer commands, const BatchWork& work, int steps);
  int MostSteps() const { return render::MostSteps(state_.scene(), settings_.bounces); }
  int PartsOfSamples() const { return frame_.signal_count == kAllSignals ? 2 : 1; }
  Status Submit(const std::vector<BatchWork>& works, int steps);
  std::vector<BatchWork> WorkLeft(const std::vector<BatchWork>& works, int steps) const;
  void ReadTimes();
  Status BeginFrame(const RenderMoment& moment, Frame* frame);
  Status RenderWhole(const RenderMoment& moment, Frame* frame, const RenderProgress& progress);
  Status RenderPart(const RenderMoment& moment, Frame* frame, const RenderProgress& progress);
  std::vector<PixelPosition> ChoosePixels(const PixelOrder& order, Frame* frame);
  void StorePixels(const PixelPosition* pixels, size_t count, Frame* frame);

  std::shared_ptr<gpu::Device> device_;
  PictureTracerOptions tracer_options_;
  TracingWay way_;
  TextureWay textures_;
  RenderSettings settings_;
  bool any_transmission_;
  ImageKinds images_;  // virtual images that the scene may contain
  SceneState state_;
  LightSet lights_;
  std::unique_ptr<GpuAccel> accel_;
  std::unique_ptr<GpuLights> gpu_lights_;
  std::unique_ptr<PictureTracer> picture_;
  DeviceStore device_store_;
  gpu::Timestamps times_;
  GpuFrame frame_ = {};
  float focal_pixels_ = 0;                     ///< focal length of the camera of frame_
  SamplerKind sampler_ = SamplerKind::kSobol;  // sampler of frame_
  // whether the visible triangles of this frame have been rasterised
  bool visible_ = false;
  bool accel_moved_ = true;  // whether instances have moved since the last upload
  bool lights_moved_ = true;
  double previous_seconds_ = 0;
  SubmissionPace pace_;
  StepForecast forecast_;
  std::vector<BatchWork> pending_;  // work of the next submission
  RenderTimings timings_;
  SparseFrameWriter sparse_;
};

Status VulkanRenderer::Build() {
  state_.Update(0.0, 0.0);
  lights_.Update(true);
  Result<std::unique_ptr<GpuAccel>> accel =
      GpuAccel::Create(device_.get(), state_, way_, textures_);
  STILLRAY_RETURN_IF_ERROR(accel.status());
  accel_ = std::move(*accel);
  Result<std::unique_ptr<GpuLights>> lights =
      GpuLights::Create(device_.get(), lights_, state_.scene().environment);
  STILLRAY_RETURN_IF_ERROR(lights.status());
  gpu_lights_ = std::move(*lights);
  if (device_->has_timestamps()) {
    STILLRAY_RETURN_IF_ERROR(times_.Create(kMostMarks));
  }
  picture_ = std::make_unique<PictureTracer>(device_.get(), accel_.get(), gpu_lights_.get(),
                                             &state_, tracer_options_);
  return MakePicture(settings_);
}

TracerParts VulkanRenderer::PartsFor(const RenderSettings& settings) const {
  const ImageKinds images = WantedImages(settings, images_, false);
  return {MayHaveLens(state_.scene(), settings), images.any(), images.refraction,
          !settings.on_device};
}

/// Allocates host results, for references and for frames whose images do not fit into device
/// memory.
Status VulkanRenderer::AllowHostResults() {
  TracerParts parts = tracer()->parts();
  if (parts.to_host) {
    return Status::Ok();
  }
  parts.to_host = true;
  return picture_->Make(settings_.width, settings_.height, parts);
}

Status VulkanRenderer::MakePicture(const RenderSettings& settings) {
  return picture_->Make(settings.width, settings.height, PartsFor(settings));
}

Status VulkanRenderer::SetSettings(const RenderSettings& settings) {
  STILLRAY_RETURN_IF_ERROR(ValidateRenderSettings(settings));
  const RenderSettings before = settings_;
  settings_ = settings;
  const TracerParts parts = PartsFor(settings);
  const bool same = settings.width == before.width && settings.height == before.height &&
                    parts == PartsFor(before);
  if (same || picture_->HasRoomFor(settings.width, settings.height, parts)) {
    return Status::Ok();
  }
  const Status made = MakePicture(settings);
  if (!made.ok()) {
    settings_ = before;
    STILLRAY_RETURN_IF_ERROR(MakePicture(before));
  }
  return made;
}

Status VulkanRenderer::MoveTo(const RenderMoment& moment) {
  STILLRAY_RETURN_IF_ERROR(CheckMoment(state_.scene(), moment));
  if (tracer() == nullptr) {  // memory was insufficient when the settings changed
    STILLRAY_RETURN_IF_ERROR(MakePicture(settings_));
  }
  timings_ = RenderTimings();
  pending_.clear();  // work of a frame that failed
  forecast_.NextFrame();
  const PhaseTimer timer(&timings_.update_ms);
  const bool moved = state_.Update(moment.seconds, moment.previous_seconds);
  STILLRAY_RETURN_IF_ERROR(CheckPlaces(state_, moment));
  // The device also needs the previous transforms.
  const bool other_past =
      moment.previous_seconds != previous_seconds_ && !state_.scene().animation.empty();
  previous_seconds_ = moment.previous_seconds;
  if (moved || other_past) {
    STILLRAY_RETURN_IF_ERROR(accel_->Update());
    accel_moved_ = true;
  }
  if (lights_.Update(moved)) {
    STILLRAY_RETURN_IF_ERROR(gpu_lights_->Update());
    lights_moved_ = true;
  }
  return Status::Ok();
}

void VulkanRenderer::SetCameras(const RenderMoment& moment) {
  CameraPair cameras = CamerasOf(state_, moment, settings_.width, settings_.height);
  const Lens lens = LensOf(state_.scene(), settings_, moment.camera);
  SetLens(state_, lens, &cameras);
  frame_ = {};
  frame_.lens_shape = MakeLensArrays(lens, accel_->scene().lens_masks());
  frame_.lens_mask = accel_->scene().LensMaskWords(lens.mask);
  visible_ = false;
  focal_pixels_ = FocalPixels(cameras.now);
  frame_.view = MakeGpuView(cameras.now);
  frame_.previous = MakeGpuView(cameras.before);
}

void VulkanRenderer::SetSampling(vec2 jitter, SampleStream stream) {
  frame_.point = vec2(0.5f) + jitter;
  frame_.width = static_cast<uint32_t>(settings_.width);
  frame_.height = static_cast<uint32_t>(settings_.height);
  sampler_ = SamplerOf(stream, settings_.sampler, settings_.spp);
  frame_.sampler_kind = static_cast<uint32_t>(sampler_);
  frame_.stream_seed = StreamSeed(settings_.seed, stream);
  frame_.bounces = settings_.bounces;
  frame_.regularise = settings_.regularise ? 1 : 0;
  frame_.light_sampling = static_cast<int>(settings_.light_sampling);
  frame_.light_candidates = settings_.light_candidates;
  frame_.clamp_radiance = settings_.clamp_radiance;
  frame_.ends_are_opaque = any_transmission_ ? 0 : 1;
  frame_.spread_points = settings_.jitter ? 1 : 0;
  frame_.with_squares = settings_.spp > 1 ? 1 : 0;
}

/// Averages textures over the pixels of the current frame if requested.
void VulkanRenderer::FilterTextures() {
  const ImageKinds shown = ShownImages();
  frame_.filters_textures = FiltersTextures(settings_, state_.scene()) ? 1 : 0;
  frame_.filtered_images = 0;
  if (frame_.filters_textures != 0 && shown.any()) {
    frame_.filtered_images = shown.refraction ? 2 : 1;
  }
}

void VulkanRenderer::ReadTimes() {
  for (const gpu::DeviceTime& time : times_.Read()) {
    double& sum = time.name == kTimeGuides || time.name == kTimeRaster ? timings_.primary_ms
                  : time.name == kTimeImages                           ? timings_.image_ms
                  : time.name == kTimeShadows                          ? timings_.shadow_ms
                  : time.name == kTimeBounces                          ? timings_.bounce_ms
                  : time.name == kTimeStore                            ? timings_.copy_ms
                                                                       : timings_.shade_ms;
    sum += time.milliseconds;
  }
  const GpuCounters& counters = tracer()->counters();
  timings_.primary_rays += counters.primary_rays;
  timings_.bounce_rays += counters.bounce_rays;
  timings_.image_rays += counters.image_rays;
  timings_.shadow_rays += counters.shadow_rays;
  timings_.dropped += counters.dropped;
  if (counters.parts + counters.left > 0) {
    forecast_.Used(static_cast<int>(counters.steps));
  }
}

void VulkanRenderer::SelectSample(uint64_t sample, GpuBatch* batch) const {
  const uint64_t window = SampleWindow(sampler_, sample);
  batch->sample_index = SampleIndex(sample);
  batch->window_low = static_cast<uint32_t>(window);
  batch->window_high = static_cast<uint32_t>(window >> 32);
}

GpuTracer::Results VulkanRenderer::ResultsAfter(const BatchWork& work) const {
  if (!work.is_last()) {
    return {};
  }
  return {.guides = work.plan.guides,
          .images = work.plan.images,
          .sums = work.plan.samples > 0,
          .single = HasSingleSample(work.plan),
          .signals = frame_.signal_count};
}

Status VulkanRenderer::Record(VkCommandBuffer commands, const BatchWork& work, int steps) {
  const BatchPlan& plan = work.plan;
  GpuBatch batch = work.batch;
  // With a lens each sample has its own guides.
  SelectSample(plan.first_sample + static_cast<uint64_t>(work.done), &batch);
  const bool begins = work.done == 0 && work.resumed_steps == 0;
  if (plan.guides && begins) {
    STILLRAY_RETURN_IF_ERROR(tracer()->RecordGuides(commands, batch));
  }
  if (plan.finds_images && begins) {
    STILLRAY_RETURN_IF_ERROR(tracer()->RecordImages(commands, batch));
  }
  for (int s = work.done; s < work.done + work.samples; ++s) {
    const bool resumes = s == work.done && work.resumed_steps > 0;
    SelectSample(plan.first_sample + static_cast<uint64_t>(s), &batch);
    if (plan.guides && s > 0 && !resumes && frame_.view.lens_radius > 0.0f) {
      STILLRAY_RETURN_IF_ERROR(tracer()->RecordGuides(commands, batch));
    }
    STILLRAY_RETURN_IF_ERROR(
        tracer()->RecordSample(commands, batch,
                               {.steps = steps,
                                .most_steps = MostSteps(),
                                .resumed_steps = resumes ? work.resumed_steps : 0,
                                .resumed_part = resumes ? work.resumed_part : 0,
                                .first = s == 0,
                                .single = HasSingleSample(plan),
                                .reference = plan.reference,
                                .separates = PartsOfSamples() > 1}));
  }
  if (device_store_.active() && work.is_last()) {
    STILLRAY_RETURN_IF_ERROR(device_store_.Record(commands, tracer(), accel_->device_instances(),
                                                  batch, ResultsAfter(work)));
  }
  return Status::Ok();
}

/// Submits the works in sequence; the results of the last work may be copied to the host.
Status VulkanRenderer::Submit(const std::vector<BatchWork>& works, int steps) {
  const gpu::FairLock lock = device_->Lock();
  const Result<VkCommandBuffer> commands = device_->Begin();
  STILLRAY_RETURN_IF_ERROR(commands.status());
  if (accel_moved_) {
    accel_->RecordUpdate(*commands);
  }
  if (lights_moved_) {
    gpu_lights_->RecordUpdate(*commands);
  }
  const bool resumes = works.front().resumed_steps > 0;
  tracer()->RecordBegin(*commands, frame_, resumes, device_->has_timestamps() ? &times_ : nullptr);
  if (frame_.rasterised != 0 && !visible_) {
    tracer()->RecordVisibility(*commands, frame_);
  }
  double paths = 0;
  for (const BatchWork& work : works) {
    if (paths > 0) {
      tracer()->RecordNextBatch(*commands);
    }
    STILLRAY_RETURN_IF_ERROR(Record(*commands, work, steps));
    paths += work.paths();
  }
  tracer()->RecordEnd(*commands, works.back().batch,
                      device_store_.active() ? GpuTracer::Results() : ResultsAfter(works.back()));
  const Clock::time_point start = Clock::now();
  STILLRAY_RETURN_IF_ERROR(device_->Run());
  if (!resumes) {  // otherwise most of the work was done before
    pace_.Adapt(paths, MillisecondsSince(start),
                static_cast<double>(tracer()->capacity()) * kMostSamples);
  }
  accel_moved_ = false;
  lights_moved_ = false;
  visible_ = frame_.rasterised != 0;
  STILLRAY_RETURN_IF_ERROR(tracer()->Invalidate());
  ReadTimes();
  return Status::Ok();
}

Status VulkanRenderer::TraceBatch(const GpuBatch& batch, const BatchPlan& plan,
                                  ProgressMeter* meter) {
  BatchWork work = {batch, plan, 0, 0};
  do {
    const int fit = static_cast<int>(
        std::min(pace_.paths() / static_cast<double>(batch.count), double{kMostSamples}));
    work.samples = std::clamp(fit, std::min(plan.samples, 1), plan.samples - work.done);
    STILLRAY_RETURN_IF_ERROR(Add(work, meter));
    work.done += work.samples;
  } while (work.done < plan.samples);
  return Status::Ok();
}

/// Adds work to the next submission. Submits pending work first if the sum would be too large, and
/// afterwards if it is large enough. The host copy of results holds one batch.
Status VulkanRenderer::Add(const BatchWork& work, ProgressMeter* meter) {
  double paths = 0;
  int steps = 0;
  for (const BatchWork& other : pending_) {
    paths += other.paths();
    steps += other.steps();
  }
  if (paths + work.paths() > pace_.paths() || steps + work.steps() > kMostSamples) {
    STILLRAY_RETURN_IF_ERROR(Flush(meter));
    paths = 0;
  }
  pending_.push_back(work);
  const bool to_host = work.is_last() && !device_store_.active();
  return to_host || pace_.IsEnough(paths + work.paths()) ? Flush(meter) : Status::Ok();
}

/// The unfinished part of the last submission, which consisted of `works` with `steps` steps per
/// path.
std::vector<BatchWork> VulkanRenderer::WorkLeft(const std::vector<BatchWork>& works,
                                                int steps) const {
  const int parts = PartsOfSamples();
  auto finished = static_cast<int>(tracer()->counters().parts);
  auto stopped = works.begin();
  while (std::next(stopped) != works.end() && finished >= stopped->samples * parts) {
    finished -= stopped->samples * parts;
    ++stopped;
  }
  std::vector<BatchWork> left(stopped, works.end());
  left.front().done += finished / parts;
  left.front().samples -= finished / parts;
  left.front().resumed_part = finished % parts;
  left.front().resumed_steps = steps;
  return left;
}

Status VulkanRenderer::Flush(ProgressMeter* meter) {
  if (pending_.empty()) {
    return Status::Ok();
  }
  const std::vector<BatchWork> works = std::exchange(pending_, {});
  const int steps = forecast_.Planned(MostSteps());
  STILLRAY_RETURN_IF_ERROR(Submit(works, steps));
  if (tracer()->counters().left > 0) {
    STILLRAY_RETURN_IF_ERROR(Submit(WorkLeft(works, steps), MostSteps()));
  }
  for (const BatchWork& work : works) {
    meter->Finish(work.paths());
  }
  return meter->cancelled() ? Status::Cancelled() : Status::Ok();
}

/// Maximum paths of a batch.
int VulkanRenderer::MostPaths() const {
  return static_cast<int>(std::min(pace_.paths(), static_cast<double>(tracer()->capacity())));
}

/// Results of the last batch in host memory.
BatchResults VulkanRenderer::ResultsOf(const BatchPlan& plan) const {
  BatchResults results;
  results.guides = plan.guides ? tracer()->guides() : nullptr;
  results.reflections = plan.images.reflection ? tracer()->reflections() : nullptr;
  results.refractions = plan.images.refraction ? tracer()->refractions() : nullptr;
  results.signals = frame_.signal_count;
  results.sums = plan.samples > 0 ? tracer()->sums() : nullptr;
  results.spp = std::max(plan.samples, 1);
  return results;
}

/// Covers the image with rectangles of a size suitable for one submission.
template <typename Store>
Status VulkanRenderer::ForTiles(const BatchPlan& plan, ProgressMeter* meter, const Store& store) {
  constexpr int kBlock = static_cast<int>(kBlockSize);
  const int columns = RoundUpToBlocks(settings_.width);
  for (int y = 0; y < settings_.height;) {
    const int most = MostPaths();
    const int width = std::min(columns, most / kBlock / kBlock * kBlock);
    const int height =
        std::min(RoundUpToBlocks(settings_.height - y), most / width / kBlock * kBlock);
    for (int x = 0; x < settings_.width; x += width) {
      GpuBatch batch = {};
      batch.x = x;
      batch.y = y;
      batch.width = std::min(width, columns - x);
      batch.count = static_cast<uint32_t>(batch.width) * static_cast<uint32_t>(height);
      STILLRAY_RETURN_IF_ERROR(TraceBatch(batch, plan, meter));
      if (!device_store_.active()) {
        const PhaseTimer timer(&timings_.copy_ms);
        store(batch);
      }
    }
    y += height;
  }
  return Status::Ok();
}

double WorkOf(const RenderSettings& settings, double samples) {
  return static_cast<double>(RoundUpToBlocks(settings.width)) * RoundUpToBlocks(settings.height) *
         samples;
}

/// Begins a frame in device memory if requested and memory suffices, otherwise in host memory.
Status VulkanRenderer::BeginFrame(const RenderMoment& moment, Frame* frame) {
  device_store_.Drop();
  SetCameras(moment);
  if (settings_.on_device) {
    STILLRAY_RETURN_IF_ERROR(
        device_store_.Begin(settings_, state_.may_turn(), ShownImages(), moment, frame));
  }
  if (!device_store_.active()) {
    STILLRAY_RETURN_IF_ERROR(AllowHostResults());
    PrepareFrame(settings_, moment, ShownImages().refraction, frame);
    PreparePreviousNormals(state_, frame);
    PrepareVirtualGuides(settings_, ShownImages(), frame);
  }
  frame_.signal_count = ShownImages().refraction ? kAllSignals : kSurfaceSignals;
  frame_.shows_reflection = ShownImages().reflection ? 1 : 0;
  FilterTextures();
  frame->focal_pixels = focal_pixels_;
  SetSampling(vec2(frame->jitter_x, frame->jitter_y), SampleStream::kFrames);
  return Status::Ok();
}

Status VulkanRenderer::RenderWhole(const RenderMoment& moment, Frame* frame,
                                   const RenderProgress& progress) {
  sparse_.Forget();
  STILLRAY_RETURN_IF_ERROR(BeginFrame(moment, frame));
  frame_.rasterised = MayDraw() ? 1 : 0;
  BatchPlan plan;
  plan.guides = true;
  plan.images = ShownImages();
  plan.finds_images = plan.images.any();
  plan.samples = settings_.spp;
  plan.first_sample =
      static_cast<uint64_t>(moment.frame_index) * static_cast<uint64_t>(settings_.spp);
  ProgressMeter meter(progress, WorkOf(settings_, settings_.spp));
  STILLRAY_RETURN_IF_ERROR(ForTiles(
      plan, &meter, [&](const GpuBatch& batch) { StoreBatch(batch, ResultsOf(plan), frame); }));
  STILLRAY_RETURN_IF_ERROR(Flush(&meter));
  return device_store_.End(int64_t{settings_.width} * settings_.height, frame);
}

/// Returns the pixels to trace; clears all other pixels of the host planes.
std::vector<PixelPosition> VulkanRenderer::ChoosePixels(const PixelOrder& order, Frame* frame) {
  const PhaseTimer timer(&timings_.clear_ms);
  std::vector<PixelPosition> chosen;
  std::vector<PixelPosition> of_region;
  for (int y = 0; y < settings_.height; y += kSparseRegion.height) {
    for (int x = 0; x < settings_.width; x += kSparseRegion.width) {
      const Tile region = {x, y, std::min(kSparseRegion.width, settings_.width - x),
                           std::min(kSparseRegion.height, settings_.height - y)};
      if (!device_store_.active()) {
        sparse_.Clear(region, frame);
      }
      order.Collect(region, &of_region);
      chosen.insert(chosen.end(), of_region.begin(), of_region.end());
    }
  }
  return chosen;
}

void VulkanRenderer::StorePixels(const PixelPosition* pixels, size_t count, Frame* frame) {
  const PhaseTimer timer(&timings_.copy_ms);
  for (size_t i = 0; i < count; ++i) {
    const auto [x, y] = pixels[i];
    const Tile region = {x - x % kSparseRegion.width, y - y % kSparseRegion.height, 0, 0};
    const GpuSignal* first = tracer()->sums() + i * frame_.signal_count;
    sparse_.Store(region, x, y, LightOf(first, frame_.signal_count),
                  GuidesOf(tracer()->guides()[i]), frame);
  }
}

Status VulkanRenderer::RenderPart(const RenderMoment& moment, Frame* frame,
                                  const RenderProgress& progress) {
  sparse_.Begin(settings_, *frame);
  STILLRAY_RETURN_IF_ERROR(BeginFrame(moment, frame));
  const bool full = settings_.guides == GuideCoverage::kFull;
  // Sparse guides are too few to justify rasterising the whole scene.
  frame_.rasterised = full && MayDraw() ? 1 : 0;
  const PixelOrder order(settings_.cycle, settings_.seed, moment.frame_index);
  const std::vector<PixelPosition> chosen = ChoosePixels(order, frame);
  ProgressMeter meter(progress,
                      (full ? WorkOf(settings_, 1) : 0.0) + static_cast<double>(chosen.size()));
  BatchPlan plan;
  plan.guides = true;
  plan.first_sample = static_cast<uint64_t>(order.cycle_index());
  if (full) {
    plan.images = ShownImages();
    plan.finds_images = plan.images.any();
    STILLRAY_RETURN_IF_ERROR(ForTiles(
        plan, &meter, [&](const GpuBatch& batch) { StoreBatch(batch, ResultsOf(plan), frame); }));
    plan.images = ImageKinds();
    plan.finds_images = frame_.filtered_images > 0;  // for the paths
  }
  plan.samples = 1;
  for (size_t done = 0; done < chosen.size();) {
    if (done > 0) {
      STILLRAY_RETURN_IF_ERROR(Flush(&meter));  // the pending work reads the list
    }
    const size_t count = std::min(chosen.size() - done, static_cast<size_t>(MostPaths()));
    for (size_t i = 0; i < count; ++i) {
      const auto [x, y] = chosen[done + i];
      tracer()->listed_pixels()[i] = static_cast<uint32_t>(x) | static_cast<uint32_t>(y) << 16;
    }
    STILLRAY_RETURN_IF_ERROR(tracer()->Flush());
    GpuBatch batch = {};
    batch.width = static_cast<int>(kBlockSize);
    batch.count = static_cast<uint32_t>(count);
    batch.listed = 1;
    STILLRAY_RETURN_IF_ERROR(TraceBatch(batch, plan, &meter));
    if (!device_store_.active()) {
      StorePixels(chosen.data() + done, count, frame);
    }
    done += count;
  }
  STILLRAY_RETURN_IF_ERROR(Flush(&meter));
  if (!device_store_.active()) {
    sparse_.End(*frame);
  }
  return device_store_.End(static_cast<int64_t>(chosen.size()), frame);
}

Status VulkanRenderer::TraceFrame(const RenderMoment& moment, Frame* frame,
                                  const RenderProgress& progress) {
  STILLRAY_RETURN_IF_ERROR(MoveTo(moment));
  STILLRAY_RETURN_IF_ERROR(settings_.cycle > 1 ? RenderPart(moment, frame, progress)
                                               : RenderWhole(moment, frame, progress));
  if (frame->on_device == nullptr) {
    const PhaseTimer timer(&timings_.copy_ms);
    StorePreviousNormals(state_, frame);
  }
  return Status::Ok();
}

Status VulkanRenderer::TraceReference(const RenderMoment& moment, int spp, Image3* radiance,
                                      const RenderProgress& progress) {
  STILLRAY_RETURN_IF_ERROR(MoveTo(moment));
  device_store_.Drop();
  STILLRAY_RETURN_IF_ERROR(AllowHostResults());
  ResizeImage(radiance, settings_.width, settings_.height);
  SetCameras(moment);
  frame_.signal_count = kSurfaceSignals;
  SetSampling(vec2(0.0f), SampleStream::kReference);
  BatchPlan plan;
  plan.reference = true;
  plan.samples = spp;
  ProgressMeter meter(progress, WorkOf(settings_, spp));
  return ForTiles(plan, &meter, [&](const GpuBatch& batch) {
    StoreReference(batch, tracer()->sums(), spp, radiance);
  });
}

}  // namespace

Result<std::unique_ptr<Renderer>> CreateVulkanRenderer(const Scene& scene,
                                                       const RenderSettings& settings,
                                                       std::shared_ptr<gpu::Device> device,
                                                       const VulkanRenderOptions& options) {
  STILLRAY_RETURN_IF_ERROR(ValidateRenderSettings(settings));
  STILLRAY_RETURN_IF_ERROR(CheckScene(scene));
  try {
    auto renderer = std::make_unique<VulkanRenderer>(scene, settings, std::move(device), options);
    STILLRAY_RETURN_IF_ERROR(renderer->Build());
    return std::unique_ptr<Renderer>(std::move(renderer));
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("preparing the scene for the GPU: out of memory");
  }
}

}  // namespace stillray::render

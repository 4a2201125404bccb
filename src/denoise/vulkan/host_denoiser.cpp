// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/host_denoiser.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/parallel.h"
#include "denoise/fill_guides/fill_guides.h"
#include "denoise/frame_check.h"
#include "denoise/signal_groups.h"
#include "denoise/stage_timer.h"
#include "denoise/vulkan/device_inputs.h"
#include "denoise/vulkan/frame_download.h"
#include "denoise/vulkan/frame_upload.h"
#include "denoise/vulkan/future_exchange.h"
#include "denoise/vulkan/layer_split.h"
#include "denoise/vulkan/output_reader.h"
#include "denoise/vulkan/saved_history.h"
#include "denoise/vulkan/shared_pictures.h"

namespace stillray::vulkan {
namespace {

class HostDenoiser : public DenoiserBackend {
 public:
  HostDenoiser(std::shared_ptr<gpu::Device> device, const Settings& settings, Storage storage)
      : device_(std::move(device)),
        settings_(settings),
        storage_(storage),
        pictures_(device_),
        passes_(&device_->context()) {}

  Status Denoise(const Frame& frame, std::span<const SignalHistory> future,
                 DenoisedFrame* out) override;
  Status Accumulate(const Frame& frame, std::vector<SignalHistory>* future) override;
  void ShowImages(const ShownImages& images) override { shown_ = images; }
  Status ReadLength(Image1* length) override { return download_->ReadLength(length); }
  Status SetSettings(const Settings& settings) override;
  void SetOutputs(std::vector<std::string> names) override {
    outputs_ = std::move(names);
    reader_.reset();
  }
  void SetResults(const Results& wanted) override { wanted_ = wanted; }
  Status ReadColour(Image3* colour) override;
  void Reset() override;
  size_t memory_bytes() const override;
  DeviceMemory device_memory() const override;
  Result<std::vector<uint8_t>> SaveHistory() override;
  Status RestoreHistory(std::span<const uint8_t> bytes) override;

 private:
  Result<FrameFacts> Take(const Frame& frame);
  SequenceProgress ProgressFor(const Frame& frame) const;
  Result<FrameFacts> TakeHere(const Frame& frame, const gpu::DeviceFrame& pixels);
  Result<FrameFacts> TakeImages(const Frame& frame, FrameFacts facts, const FrameInputs& inputs,
                                std::span<const std::shared_ptr<const void>> owners);
  Status PreparePipeline(int width, int height, bool transmission);
  Status PrepareFuture(const Frame& frame);
  Status PrepareWork(const Frame& frame, const FrameFacts& facts);
  Status PreparePicture(const Frame& frame);
  Status PrepareUpload(const Frame& frame, const FrameFacts& facts);
  Status PrepareDownload(const Frame& frame);
  void ChooseResults(const Frame& frame);
  Status MakeStateBuffer();
  Status AddPart();
  Status RecordPasses(VkCommandBuffer commands, const FramePipeline::Checkpoint& before,
                      const Status& added);
  Status Run(const FramePlan& plan, const FrameFacts& facts);
  Status RunBackward(const FramePlan& plan, const FrameFacts& facts);
  Status ReadResults(const Frame& frame, const FramePlan& plan, DenoisedFrame* out);

  std::shared_ptr<gpu::Device> device_;
  Settings settings_;
  Storage storage_;
  Results wanted_;
  Results results_;  ///< requested results of the current frame
  SharedPictures pictures_;
  std::shared_ptr<DevicePicture> shared_;  ///< destination of the shared result; nullptr: none
  bool has_result_ = false;                ///< `download_` has the output image of the last frame
  std::vector<std::string> outputs_;
  std::unique_ptr<gpu::Arena> state_memory_;
  const gpu::Buffer* state_ = nullptr;
  std::unique_ptr<FramePipeline> pipeline_;
  std::unique_ptr<FrameUpload> upload_;  ///< nullptr: frames are already on the device
  std::unique_ptr<FrameDownload> download_;
  std::unique_ptr<OutputReader> reader_;
  SeenFrames seen_;
  FrameInputs inputs_;         ///< of the current frame
  FramePart* part_ = nullptr;  ///< the current frame, if it is part of a frame on the device
  OddValues odd_;              ///< warnings about the values of the current frame
  ShownImages shown_;          ///< see ShowImages
  Frame from_elsewhere_;       ///< host copy of a frame on another device
  std::unique_ptr<FutureExchange> future_;  ///< nullptr until there is a future
  std::vector<double> row_sums_;
  gpu::CommandList passes_;
};

/// Makes a frame available to the device.
Result<FrameFacts> HostDenoiser::Take(const Frame& frame) {
  part_ = dynamic_cast<FramePart*>(frame.on_device.get());
  if (part_ != nullptr) {
    return TakeImages(frame, part_->facts, part_->inputs, part_->owners);
  }
  if (const gpu::DeviceFrame* here = gpu::FrameOn(*device_, frame); here != nullptr) {
    return TakeHere(frame, *here);
  }
  const Result<const Frame*> host = OnHost(frame, &from_elsewhere_);
  STILLRAY_RETURN_IF_ERROR(host.status());
  const Frame& f = **host;
  FrameFacts facts = FactsOf(f);
  facts.has_roughness =
      facts.has_roughness && (settings_.mirror_roughness > 0 || settings_.limit_history);
  const MotionUse use = UseOfMotion(settings_, IsJittered(facts), ProgressFor(f));
  STILLRAY_RETURN_IF_ERROR(CheckFrame(f, settings_, use));
  odd_ = FindOddValues(f, use);
  facts.has_incomplete_guides = settings_.fill_guides && HasIncompleteGuides(f);
  facts.albedo_of_images = shown_.depth != nullptr;
  facts.length_of_images = shown_.length != nullptr;
  facts.keeps_length = true;  // for ReadLength
  facts.samples_per_pixel = SamplesPerPixel(f, &row_sums_);
  STILLRAY_RETURN_IF_ERROR(PrepareWork(f, facts));
  STILLRAY_RETURN_IF_ERROR(PrepareUpload(f, facts));
  STILLRAY_RETURN_IF_ERROR(upload_->Write(f, shown_));
  inputs_ = upload_->inputs();
  return facts;
}

/// The progress of the sequence, or of a new sequence if the history does not fit the frame.
SequenceProgress HostDenoiser::ProgressFor(const Frame& f) const {
  const bool fits =
      pipeline_ != nullptr && pipeline_->Fits(settings_, f.width, f.height, HasTransmission(f));
  return fits ? pipeline_->progress() : SequenceProgress();
}

/// Uses the images of a frame on this device as inputs.
Result<FrameFacts> HostDenoiser::TakeHere(const Frame& frame, const gpu::DeviceFrame& pixels) {
  STILLRAY_RETURN_IF_ERROR(CheckSize(frame, pixels));
  const std::shared_ptr<const void> owner = frame.on_device;
  return TakeImages(frame, FactsOf(frame, pixels), InputsOf(pixels), {&owner, 1});
}

/// \param owners  owners of all images
Result<FrameFacts> HostDenoiser::TakeImages(const Frame& frame, FrameFacts facts,
                                            const FrameInputs& inputs,
                                            std::span<const std::shared_ptr<const void>> owners) {
  STILLRAY_RETURN_IF_ERROR(CheckFocalLength(frame.index, facts.focal_pixels, settings_));
  odd_ = OddValues();
  facts.has_incomplete_guides = facts.has_incomplete_guides && settings_.fill_guides;
  STILLRAY_RETURN_IF_ERROR(PrepareWork(frame, facts));
  if (seen_.Add(owners) || upload_ != nullptr) {
    STILLRAY_RETURN_IF_ERROR(pipeline_->ForgetInputs());
    upload_.reset();
  }
  inputs_ = inputs;
  return facts;
}

Status HostDenoiser::PrepareUpload(const Frame& f, const FrameFacts& facts) {
  if (upload_ == nullptr || !upload_->Fits(f.width, f.height, facts)) {
    STILLRAY_RETURN_IF_ERROR(pipeline_->ForgetInputs());
    upload_.reset();
    Result<std::unique_ptr<FrameUpload>> made =
        FrameUpload::Create(&device_->context(), f.width, f.height, facts);
    STILLRAY_RETURN_IF_ERROR(made.status());
    upload_ = std::move(made.value());
  }
  return Status::Ok();
}

/// Creates a pipeline for frames of this size, if necessary.
Status HostDenoiser::PreparePipeline(int width, int height, bool transmission) {
  if (pipeline_ != nullptr && pipeline_->Fits(settings_, width, height, transmission)) {
    return Status::Ok();
  }
  reader_.reset();
  pipeline_.reset();  // freed first, since both may not fit into memory
  PipelineOptions options = {settings_,    width,    height,
                             transmission, storage_, device_->has_timestamps()};
  Result<std::unique_ptr<FramePipeline>> made = FramePipeline::Create(&device_->context(), options);
  STILLRAY_RETURN_IF_ERROR(made.status());
  pipeline_ = std::move(made.value());
  return Status::Ok();
}

/// Allocates the device's memory for frames like this one, if necessary.
Status HostDenoiser::PrepareWork(const Frame& f, const FrameFacts& facts) {
  STILLRAY_RETURN_IF_ERROR(PreparePipeline(f.width, f.height, HasTransmission(f)));
  return pipeline_->PrepareFilling(facts);
}

/// Allocates memory for the histories of later frames, if necessary.
Status HostDenoiser::PrepareFuture(const Frame& f) {
  const int signals = pipeline_->shape().signals;
  if (future_ != nullptr && future_->Fits(f.width, f.height, signals)) {
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(pipeline_->ForgetInputs());
  future_.reset();
  Result<std::unique_ptr<FutureExchange>> made =
      FutureExchange::Create(&device_->context(), f.width, f.height, signals);
  STILLRAY_RETURN_IF_ERROR(made.status());
  future_ = std::move(made.value());
  return Status::Ok();
}

/// Allocates memory for downloads of frames like this one, if necessary.
Status HostDenoiser::PreparePicture(const Frame& f) {
  STILLRAY_RETURN_IF_ERROR(PrepareDownload(f));
  if (reader_ == nullptr) {
    Result<std::unique_ptr<OutputReader>> made =
        OutputReader::Create(&device_->context(), *pipeline_, outputs_);
    STILLRAY_RETURN_IF_ERROR(made.status());
    reader_ = std::move(made.value());
  }
  return MakeStateBuffer();
}

Status HostDenoiser::PrepareDownload(const Frame& f) {
  if (download_ == nullptr || !download_->Fits(f.width, f.height)) {
    STILLRAY_RETURN_IF_ERROR(pipeline_->ForgetInputs());
    has_result_ = false;
    download_.reset();
    Result<std::unique_ptr<FrameDownload>> made =
        FrameDownload::Create(&device_->context(), f.width, f.height);
    STILLRAY_RETURN_IF_ERROR(made.status());
    download_ = std::move(made.value());
  }
  ChooseResults(f);
  return download_->Prepare(results_);
}

/// Selects the results of the frame: the image is downloaded if memory cannot be shared.
void HostDenoiser::ChooseResults(const Frame& f) {
  results_ = wanted_;
  shared_ = nullptr;
  if (wanted_.shared) {
    const Result<std::shared_ptr<DevicePicture>> picture = pictures_.Take(f.width, f.height);
    shared_ = picture.ok() ? *picture : nullptr;
    results_.shared = shared_ != nullptr;
    results_.display = wanted_.display || shared_ == nullptr;
  }
}

Status HostDenoiser::MakeStateBuffer() {
  if (state_ != nullptr) {
    return Status::Ok();
  }
  state_memory_ = std::make_unique<gpu::Arena>(&device_->context());
  const Result<const gpu::Buffer*> added =
      state_memory_->AddBuffer(sizeof(FrameState), 0, gpu::BufferPlace::kDownload);
  STILLRAY_RETURN_IF_ERROR(added.status());
  STILLRAY_RETURN_IF_ERROR(state_memory_->Allocate());
  state_ = *added;
  return Status::Ok();
}

/// Adds the passes that write the images of a frame's part.
Status HostDenoiser::AddPart() {
  return part_ != nullptr ? part_->record(&passes_) : Status::Ok();
}

/// Records the passes if all were added without error; else restores the state before the frame.
Status HostDenoiser::RecordPasses(VkCommandBuffer commands, const FramePipeline::Checkpoint& before,
                                  const Status& added) {
  if (!added.ok()) {
    passes_.Clear();
    pipeline_->GoBackTo(before);
    return added;
  }
  passes_.Record(commands);
  return Status::Ok();
}

Status HostDenoiser::Run(const FramePlan& plan, const FrameFacts& facts) {
  const gpu::DeviceFunctions& vk = device_->context().vk;
  const gpu::FairLock lock = device_->Lock();
  const Result<VkCommandBuffer> begun = device_->Begin();
  STILLRAY_RETURN_IF_ERROR(begun.status());
  const VkCommandBuffer commands = *begun;
  if (upload_ != nullptr) {
    upload_->Record(commands);
  }
  if (plan.runs.merge_future) {
    future_->Prepare(commands);
    future_->RecordUpload(commands);
  }
  download_->RecordUse(commands);
  FrameInputs images = inputs_;
  download_->ShowTo(&images);
  reader_->BeginFrame();
  const FutureImages* future = plan.runs.merge_future ? &future_->images() : nullptr;
  const FramePipeline::Checkpoint before = pipeline_->checkpoint();
  Status added = AddPart();
  if (added.ok()) {
    added = pipeline_->Record(&passes_, plan, facts, images, reader_.get(), future);
  }
  STILLRAY_RETURN_IF_ERROR(RecordPasses(commands, before, added));
  const auto barrier = [&](VkPipelineStageFlags from, VkAccessFlags written,
                           VkPipelineStageFlags to, VkAccessFlags read) {
    VkMemoryBarrier memory = {};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    memory.srcAccessMask = written;
    memory.dstAccessMask = read;
    vk.CmdPipelineBarrier(commands, from, to, 0, 1, &memory, 0, nullptr, 0, nullptr);
  };
  barrier(VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
          VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
  download_->Record(commands, results_);
  if (shared_ != nullptr) {
    download_->RecordShared(commands, device_->queue_family(), shared_->buffer());
  }
  reader_->Finish(commands, *pipeline_);
  const VkBufferCopy region = {0, 0, sizeof(FrameState)};
  vk.CmdCopyBuffer(commands, pipeline_->images().state->buffer, state_->buffer, 1, &region);
  barrier(VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
          VK_ACCESS_HOST_READ_BIT);
  return device_->Run();
}

/// Runs a frame of a sequence that is processed backward.
Status HostDenoiser::RunBackward(const FramePlan& plan, const FrameFacts& facts) {
  const gpu::FairLock lock = device_->Lock();
  const Result<VkCommandBuffer> commands = device_->Begin();
  STILLRAY_RETURN_IF_ERROR(commands.status());
  if (upload_ != nullptr) {
    upload_->Record(*commands);
  }
  future_->Prepare(*commands);
  const FramePipeline::Checkpoint before = pipeline_->checkpoint();
  Status added = AddPart();
  if (added.ok()) {
    added = pipeline_->RecordBackward(&passes_, plan, facts, inputs_, future_->images());
  }
  STILLRAY_RETURN_IF_ERROR(RecordPasses(*commands, before, added));
  future_->RecordDownload(*commands);
  return device_->Run();
}

Status HostDenoiser::ReadResults(const Frame& frame, const FramePlan& plan, DenoisedFrame* out) {
  STILLRAY_RETURN_IF_ERROR(state_memory_->Invalidate());
  FrameState state;
  std::memcpy(&state, state_->mapped, sizeof(state));
  out->non_finite = state.non_finite;
  out->negative = state.negative;
  out->bad_guides = state.bad_guides + odd_.bad_guides;
  out->warning = odd_.warning;
  for (const gpu::DeviceTime& time : pipeline_->times()) {
    out->timings.push_back({time.name, time.milliseconds});
  }
  const Image1* confidence = frame.confidence.empty() ? nullptr : &frame.confidence;
  STILLRAY_RETURN_IF_ERROR(reader_->Read(*pipeline_, state, plan, confidence, &out->images));
  out->shared = std::exchange(shared_, nullptr);
  return download_->Read(results_, out);
}

Status HostDenoiser::ReadColour(Image3* colour) {
  constexpr Results kColour = {};
  if (!has_result_) {
    return Status::NotFound("there is no finished frame to read");
  }
  STILLRAY_RETURN_IF_ERROR(download_->Prepare(kColour));
  {
    const gpu::FairLock lock = device_->Lock();
    const Result<VkCommandBuffer> begun = device_->Begin();
    STILLRAY_RETURN_IF_ERROR(begun.status());
    gpu::MemoryBarrier(device_->context(), *begun, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                       VK_ACCESS_SHADER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_ACCESS_TRANSFER_READ_BIT);
    download_->Record(*begun, kColour);
    gpu::MemoryBarrier(device_->context(), *begun, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                       VK_ACCESS_HOST_READ_BIT);
    STILLRAY_RETURN_IF_ERROR(device_->Run());
  }
  return download_->ReadColour(colour);
}

Status HostDenoiser::Denoise(const Frame& frame, std::span<const SignalHistory> future,
                             DenoisedFrame* out) {
  out->timings.clear();
  out->images.clear();
  Result<FrameFacts> facts = FrameFacts();
  {
    const StageTimer timer(&out->timings, kUploadStage);
    facts = Take(frame);
    STILLRAY_RETURN_IF_ERROR(facts.status());
    STILLRAY_RETURN_IF_ERROR(PreparePicture(frame));
    if (!future.empty()) {
      STILLRAY_RETURN_IF_ERROR(PrepareFuture(frame));
      STILLRAY_RETURN_IF_ERROR(future_->Write(future));
    }
  }
  facts->is_displayed = results_.display || results_.shared;
  facts->has_future = !future.empty();
  const FramePlan plan = MakePlan(settings_, *facts, pipeline_->progress());
  has_result_ = false;
  STILLRAY_RETURN_IF_ERROR(Run(plan, *facts));
  has_result_ = true;
  if (part_ != nullptr) {
    part_->picture = download_->picture();
  }
  return ReadResults(frame, plan, out);
}

Status HostDenoiser::SetSettings(const Settings& settings) {
  const bool begins_anew = NeedsNewHistory(settings_, settings);
  settings_ = settings;
  if (begins_anew) {
    Reset();
  }
  reader_.reset();
  return pipeline_ != nullptr &&
                 pipeline_->Fits(settings, pipeline_->shape().width, pipeline_->shape().height,
                                 pipeline_->has_transmission())
             ? pipeline_->SetSettings(settings)
             : Status::Ok();  // recreated with the next frame
}

Status HostDenoiser::Accumulate(const Frame& frame, std::vector<SignalHistory>* future) {
  Result<FrameFacts> facts = Take(frame);
  STILLRAY_RETURN_IF_ERROR(facts.status());
  STILLRAY_RETURN_IF_ERROR(PrepareFuture(frame));
  facts->is_backward = true;
  const FramePlan plan = MakePlan(settings_, *facts, pipeline_->progress());
  has_result_ = false;
  STILLRAY_RETURN_IF_ERROR(RunBackward(plan, *facts));
  if (plan.runs.reproject) {
    return future_->Read(future);
  }
  const auto signals = static_cast<size_t>(pipeline_->shape().signals);
  future->assign(signals, SignalHistory(frame.width, frame.height));
  return Status::Ok();
}

void HostDenoiser::Reset() {
  if (pipeline_ != nullptr) {
    pipeline_->Reset();
  }
}

DeviceMemory HostDenoiser::device_memory() const {
  gpu::MemoryUse sum;
  if (pipeline_ != nullptr) {
    sum += pipeline_->memory();
  }
  if (upload_ != nullptr) {
    sum += upload_->memory();
  }
  if (download_ != nullptr) {
    sum += download_->memory();
  }
  if (reader_ != nullptr) {
    sum += reader_->memory();
  }
  if (future_ != nullptr) {
    sum += future_->memory();
  }
  sum += pictures_.memory();
  if (state_memory_ != nullptr) {
    sum += state_memory_->Need();
  }
  return {sum.allocations, sum.resources, sum.bytes, sum.largest};
}

size_t HostDenoiser::memory_bytes() const {
  return device_memory().bytes;
}

Result<std::vector<uint8_t>> HostDenoiser::SaveHistory() {
  return vulkan::SaveHistory(device_.get(), pipeline_.get());
}

Status HostDenoiser::RestoreHistory(std::span<const uint8_t> bytes) {
  const Result<SavedHistory> saved = ReadSavedHistory(bytes, settings_, storage_);
  STILLRAY_RETURN_IF_ERROR(saved.status());
  has_result_ = false;
  STILLRAY_RETURN_IF_ERROR(PreparePipeline(saved->width, saved->height, saved->transmission));
  return vulkan::RestoreHistory(device_.get(), *saved, pipeline_.get());
}

}  // namespace

Result<std::unique_ptr<DenoiserBackend>> VulkanBackend::CreateDenoiser(const Settings& settings,
                                                                       DevicePrecision precision) {
  return std::unique_ptr<DenoiserBackend>(std::make_unique<HostDenoiser>(
      device_, settings, precision == DevicePrecision::kFloat ? Storage::kFloat : Storage::kHalf));
}

bool VulkanBackend::Holds(const Frame& frame) const {
  return gpu::FrameOn(*device_, frame) != nullptr;
}

Result<std::unique_ptr<FrameSplit>> VulkanBackend::CreateFrameSplit() {
  Result<std::unique_ptr<LayerSplit>> made = LayerSplit::Create(device_);
  STILLRAY_RETURN_IF_ERROR(made.status());
  return std::unique_ptr<FrameSplit>(std::move(made.value()));
}

}  // namespace stillray::vulkan

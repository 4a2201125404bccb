// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "capi/session.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include "capi/image_access.h"
#include "core/clock.h"
#include "core/colour.h"
#include "core/guides.h"
#include "core/parallel.h"
#include "denoise/signal_groups.h"

namespace stillray::capi {
namespace {

/// Polling interval of the progress callback: short for users, negligible load.
constexpr std::chrono::milliseconds kPoll(4);
/// Fractions of a frame's progress: reading inputs is negligible.
constexpr double kFilteringEnds = 0.95;

bool StartsWith(std::string_view name, std::string_view prefix) {
  return name.substr(0, prefix.size()) == prefix;
}

int ChannelsOf(std::string_view output) {
  if (output == "colour" || output == "temporal" || output == "aliased" ||
      StartsWith(output, "atrous") || StartsWith(output, "noisy.") ||
      StartsWith(output, "accumulated.") || StartsWith(output, "filtered.")) {
    return 3;
  }
  return 1;
}

Status UnknownName(const char* what, std::string_view name, const std::string& known) {
  return Status::InvalidArgument(
      fmt::format("unknown {0} '{1}'; {0}s are: {2}", what, name, known));
}

Status CheckSameSize(std::string_view name, const stillray_image& image, int width, int height,
                     std::string_view expected) {
  if (image.width == width && image.height == height) {
    return Status::Ok();
  }
  return Status::InvalidArgument(fmt::format("image '{}' is {}x{}, expected {}x{} as {}", name,
                                             image.width, image.height, width, height, expected));
}

double TotalMs(const std::vector<StageTime>& timings) {
  double sum = 0;
  for (const StageTime& stage : timings) {
    sum += stage.milliseconds;
  }
  return sum;
}

}  // namespace

std::vector<std::string> Session::OutputNames(const Settings& settings) {
  std::vector<std::string> names = {"colour", "history_length"};
  const bool with_variance = settings.wavelet == Wavelet::kSvgf;
  if (with_variance) {
    names.insert(names.begin() + 1, "variance");
  }
  for (std::string& name : Denoiser::OutputNames(settings)) {
    if (with_variance || (!StartsWith(name, "variance.") && !StartsWith(name, "filtered"))) {
      names.push_back(std::move(name));
    }
  }
  return names;
}

Status Session::CheckSize(std::string_view name, const stillray_image& image) const {
  if (width_ != 0 && (image.width != width_ || image.height != height_)) {
    return Status::InvalidArgument(fmt::format("image '{}' is {}x{}, expected {}x{} as resized to",
                                               name, image.width, image.height, width_, height_));
  }
  return Status::Ok();
}

Status Session::SetInput(std::string_view name, const stillray_image* image) {
  const stillray_input_info* info = FindInput(name);
  if (info == nullptr) {
    std::string known;
    for (const stillray_input_info& input : Inputs()) {
      known += known.empty() ? "" : ", ";
      known += input.name;
    }
    return UnknownName("input", name, known);
  }
  if (image == nullptr) {
    inputs_.erase(info->name);
    return Status::Ok();
  }
  stillray_image checked = *image;
  STILLRAY_RETURN_IF_ERROR(CheckImage(name, info->channels, IsId(name), &checked));
  STILLRAY_RETURN_IF_ERROR(CheckSize(name, checked));
  inputs_.insert_or_assign(info->name, checked);
  return Status::Ok();
}

Status Session::SetOutput(std::string_view name, const stillray_image* image) {
  if (image == nullptr) {
    const auto at = outputs_.find(name);
    if (at != outputs_.end()) {
      outputs_.erase(at);
      return Status::Ok();
    }
  }
  const std::vector<std::string> names = OutputNames();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    return UnknownName("output", name, fmt::format("{}", fmt::join(names, ", ")));
  }
  if (image == nullptr) {
    return Status::Ok();
  }
  stillray_image checked = *image;
  STILLRAY_RETURN_IF_ERROR(CheckImage(name, ChannelsOf(name), false, &checked));
  STILLRAY_RETURN_IF_ERROR(CheckSize(name, checked));
  outputs_.insert_or_assign(std::string(name), checked);
  return Status::Ok();
}

Status Session::SetJitter(float x, float y) {
  if (!(std::abs(x) <= 0.5f) || !(std::abs(y) <= 0.5f)) {
    return Status::InvalidArgument(
        fmt::format("jitter is ({}, {}), expected -0.5 to 0.5 for each", x, y));
  }
  jitter_x_ = x;
  jitter_y_ = y;
  return Status::Ok();
}

Status Session::SetFocalPixels(float focal_pixels) {
  if (!(focal_pixels >= 0) || !std::isfinite(focal_pixels)) {
    return Status::InvalidArgument(
        fmt::format("focal_pixels is {}, expected a number > 0, or 0: unknown", focal_pixels));
  }
  focal_pixels_ = focal_pixels;
  return Status::Ok();
}

void Session::SetProgress(stillray_progress progress, void* user) {
  progress_ = progress;
  progress_user_ = user;
}

Status Session::Prepare() {
  if (!engine_.has_value()) {
    Result<Denoiser> made = Denoiser::Create(settings_, place_->device);
    if (!made.ok()) {
      return made.status();
    }
    engine_.emplace(std::move(made.value()));
  }
  return engine_->SetSettings(settings_);
}

Status Session::CheckInputSizes(Frame* frame, std::string* first_name) const {
  if (inputs_.empty()) {
    return Status::InvalidArgument("no input is set");
  }
  // The first image in the order of the documentation sets the size: a signal, if there is any.
  const stillray_image* first = nullptr;
  std::string name_of_first;
  for (const stillray_input_info& info : Inputs()) {
    const auto at = inputs_.find(info.name);
    if (at != inputs_.end()) {
      first = &at->second;
      name_of_first = fmt::format("'{}'", info.name);
      break;
    }
  }
  for (const auto& [name, image] : inputs_) {
    STILLRAY_RETURN_IF_ERROR(
        CheckSameSize(name, image, first->width, first->height, name_of_first));
  }
  frame->width = first->width;
  frame->height = first->height;
  if (first_name != nullptr) {
    *first_name = std::move(name_of_first);
  }
  return Status::Ok();
}

Status Session::CheckOutputs(const Settings& settings, int width, int height,
                             std::string_view expected) const {
  if (outputs_.empty()) {
    return Status::InvalidArgument("no output is set");
  }
  const std::vector<std::string> names = OutputNames(settings);
  for (const auto& [name, image] : outputs_) {
    STILLRAY_RETURN_IF_ERROR(CheckSameSize(name, image, width, height, expected));
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      return UnknownName("output", name, fmt::format("{}", fmt::join(names, ", ")));
    }
  }
  return Status::Ok();
}

bool Session::Report(double fraction) const {
  return progress_ == nullptr || progress_(progress_user_, fraction) == 0;
}

Status Session::RefuseWhileFramesWait(const char* what) const {
  if (!two_way_.has_value() || two_way_->waiting() == 0) {
    return Status::Ok();
  }
  return Status::InvalidArgument(
      fmt::format("{} while frames wait ({}), expected that the sequence is finished and pulled "
                  "first, or a reset",
                  what, two_way_->waiting()));
}

/// The outputs that the engine must compute.
std::vector<std::string> Session::EngineOutputs() const {
  std::vector<std::string> wanted;
  for (const auto& [name, image] : outputs_) {
    if (name == "history_length") {
      wanted.push_back("history");
    } else if (name != "colour") {
      wanted.push_back(name);
    }
  }
  return wanted;
}

void Session::NumberFrame() {
  frame_.index = index_;
  frame_.jitter_x = jitter_x_;
  frame_.jitter_y = jitter_y_;
  frame_.focal_pixels = focal_pixels_;
}

Status Session::Execute() {
  STILLRAY_RETURN_IF_ERROR(RefuseWhileFramesWait("execute was called"));
  std::string first_input;
  STILLRAY_RETURN_IF_ERROR(CheckInputSizes(&frame_, &first_input));
  STILLRAY_RETURN_IF_ERROR(CheckOutputs(settings_, frame_.width, frame_.height, first_input));
  STILLRAY_RETURN_IF_ERROR(Prepare());
  NumberFrame();
  STILLRAY_RETURN_IF_ERROR(engine_->SetOutputs(EngineOutputs()));
  if (!Report(0.0)) {
    return Status::Cancelled();
  }
  place_->arena.execute([&] {
    LoadFrame(inputs_, &frame_);
    FillMissingGuides(settings_.demodulate, &frame_);
  });
  STILLRAY_RETURN_IF_ERROR(progress_ == nullptr ? Filter() : FilterWatched());
  last_filter_ms_ = TotalMs(result_.timings);
  place_->arena.execute([&] { WriteOutputs(settings_); });
  ++index_;
  // The frame is finished and its outputs are written: too late to cancel.
  Report(1.0);
  return Status::Ok();
}

Status Session::Filter() {
  Status status;
  place_->arena.execute([&] { status = engine_->Denoise(frame_, &result_); });
  return status;
}

Status Session::FilterWatched() {
  // Loops within the engine belong to this group, so that cancelling it ends them all.
  tbb::task_group_context group;
  std::future<Status> filtering = std::async(std::launch::async, [&] {
    Status status;
    place_->arena.execute([&] {
      tbb::parallel_for(
          0, 1, [&](int) { status = engine_->Denoise(frame_, &result_); }, group);
    });
    return status;
  });
  const Clock::time_point start = Clock::now();
  bool cancelled = false;
  while (filtering.wait_for(kPoll) != std::future_status::ready) {
    const double part =
        last_filter_ms_ > 0 ? std::min(1.0, MillisecondsSince(start) / last_filter_ms_) : 0;
    // Above 0, since 0 means that nothing has been filtered yet.
    if (!cancelled && !Report(std::max(0.01, kFilteringEnds * part))) {
      cancelled = true;
      group.cancel_group_execution();
    }
  }
  Status status = filtering.get();
  if (!status.ok()) {
    return status;  // rejected before any change
  }
  if (cancelled || !Report(kFilteringEnds)) {
    engine_.reset();  // half a frame is in its history
    return Status::Cancelled();
  }
  return Status::Ok();
}

Status Session::PrepareTwoWay() {
  if (settings_changed_) {
    STILLRAY_RETURN_IF_ERROR(RefuseWhileFramesWait("settings were changed"));
  }
  if (settings_changed_ || !two_way_.has_value()) {
    two_way_.reset();
    Result<TwoWayDenoiser> made = TwoWayDenoiser::Create(settings_, place_->device);
    STILLRAY_RETURN_IF_ERROR(made.status());
    two_way_.emplace(std::move(made.value()));
    settings_changed_ = false;
  }
  return Status::Ok();
}

Status Session::Push(int32_t cut) {
  if (cut < STILLRAY_CUT_FIND || cut > STILLRAY_CUT_NO) {
    return Status::InvalidArgument(fmt::format("cut is {}, expected {} to {}", cut,
                                               static_cast<int>(STILLRAY_CUT_FIND),
                                               static_cast<int>(STILLRAY_CUT_NO)));
  }
  STILLRAY_RETURN_IF_ERROR(CheckInputSizes(&frame_));
  STILLRAY_RETURN_IF_ERROR(PrepareTwoWay());
  NumberFrame();
  Status status;
  place_->arena.execute([&] {
    LoadFrame(inputs_, &frame_);
    Image2 next_motion;
    LoadNextMotion(inputs_, frame_, &next_motion);
    status = two_way_->Push(std::move(frame_), static_cast<Cut>(cut), std::move(next_motion));
  });
  index_ += status.ok() ? 1 : 0;
  return status;
}

void Session::Finish() {
  if (two_way_.has_value()) {
    two_way_->Finish();
  }
}

Status Session::Pull(bool* pulled) {
  *pulled = false;
  if (!two_way_.has_value() || !two_way_->ready()) {
    return Status::Ok();
  }
  const Frame& next = *two_way_->Next();
  STILLRAY_RETURN_IF_ERROR(CheckOutputs(two_way_->settings(), next.width, next.height,
                                        fmt::format("frame {}", next.index)));
  STILLRAY_RETURN_IF_ERROR(two_way_->SetOutputs(EngineOutputs()));
  if (!Report(0.0)) {
    return Status::Cancelled();
  }
  STILLRAY_RETURN_IF_ERROR(PullWatched());
  last_filter_ms_ = TotalMs(result_.timings);
  place_->arena.execute([&] { WriteOutputs(two_way_->settings()); });
  *pulled = true;
  return Status::Ok();
}

Status Session::PullWatched() {
  std::atomic<double> done = 0;
  std::atomic<bool> cancelled = false;
  std::future<Status> filtering = std::async(std::launch::async, [&] {
    Status status;
    place_->arena.execute([&] {
      status = two_way_
                   ->Pull(&result_, &frame_,
                          [&](double part) {
                            done = part;
                            return !cancelled;
                          })
                   .status();
    });
    return status;
  });
  while (filtering.wait_for(kPoll) != std::future_status::ready) {
    cancelled = cancelled || !Report(done);
  }
  return filtering.get();
}

stillray_waiting Session::Waiting() const {
  stillray_waiting waiting = STILLRAY_WAITING_INIT;
  const Frame* next = two_way_.has_value() ? two_way_->Next() : nullptr;
  if (next != nullptr) {
    waiting.frames = two_way_->waiting();
    waiting.ready = two_way_->ready() ? 1 : 0;
    waiting.width = next->width;
    waiting.height = next->height;
    waiting.index = next->index;
  }
  return waiting;
}

Status Session::MemoryNeed(stillray_memory_need* need) {
  Frame shape;
  STILLRAY_RETURN_IF_ERROR(CheckInputSizes(&shape));
  shape.jitter_x = jitter_x_;
  shape.jitter_y = jitter_y_;
  MarkImages(inputs_, &shape);
  Result<TwoWayMemory> memory = TwoWayMemory();
  place_->arena.execute([&] {
    memory = TwoWayDenoiser::MemoryNeed(settings_, shape, inputs_.contains("next_motion"),
                                        place_->device);
  });
  STILLRAY_RETURN_IF_ERROR(memory.status());
  *need = {sizeof(*need), memory->denoisers, memory->per_future, memory->per_frame, memory->most};
  return Status::Ok();
}

Image1 Session::VarianceOfPicture(const Settings& settings) const {
  Image1 sum(frame_.width, frame_.height);
  const Guides& g = frame_.guides;
  // The channels' noise is fully correlated, from the same samples: standard deviations add up, not
  // variances.
  const bool channels = settings.signals == SignalGrouping::kChannels;
  for (const SignalGroup& group : GroupsOf(settings.signals, HasTransmission(frame_))) {
    const std::string name = std::string("variance.") + group.name;
    const auto at = std::find_if(result_.images.begin(), result_.images.end(),
                                 [&](const NamedImage& image) { return image.name == name; });
    if (at == result_.images.end()) {
      continue;
    }
    std::vector<const Image3*> albedos;
    for (const auto& [used, albedo] :
         {std::pair{group.diffuse_albedo, &g.albedo},
          std::pair{group.specular_albedo, &g.specular_albedo},
          std::pair{group.transmission_albedo, &g.transmission_albedo}}) {
      if (used && settings.demodulate && !albedo->empty()) {
        albedos.push_back(albedo);
      }
    }
    ParallelRows(frame_.height, kBand, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        for (int x = 0; x < frame_.width; ++x) {
          float factor[3] = {1, 1, 1};
          for (int c = 0; c < 3 && !albedos.empty(); ++c) {
            float albedo = 0;
            for (const Image3* part : albedos) {
              albedo += (*part)[c](x, y);
            }
            factor[c] = std::max(kAlbedoFloor, albedo);  // in this order NaN gives the floor
          }
          for (int c = 0; c < 3; ++c) {
            factor[c] = group.channel < 0 || group.channel == c ? factor[c] : 0.0f;
          }
          const float luminance = Luminance709(factor[0], factor[1], factor[2]);
          const float variance = luminance * luminance * at->channels[0](x, y);
          const float deviation = std::sqrt(sum(x, y)) + std::sqrt(variance);
          sum(x, y) = channels ? deviation * deviation : sum(x, y) + variance;
        }
      }
    });
  }
  return sum;
}

Image1 Session::ShortestHistory() const {
  Image1 shortest(frame_.width, frame_.height);
  bool first = true;
  for (const NamedImage& image : result_.images) {
    if (!StartsWith(image.name, "history.")) {
      continue;
    }
    ParallelRows(frame_.height, kBand, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        for (int x = 0; x < frame_.width; ++x) {
          const float length = image.channels[0](x, y);
          shortest(x, y) = first ? length : std::min(shortest(x, y), length);
        }
      }
    });
    first = false;
  }
  return shortest;
}

void Session::WriteOutput(const Settings& settings, const std::string& name,
                          const stillray_image& image) {
  if (name == "variance") {
    WriteChannel(VarianceOfPicture(settings), 0, image);
    return;
  }
  if (name == "history_length") {
    WriteChannel(ShortestHistory(), 0, image);
    return;
  }
  const auto at = std::find_if(result_.images.begin(), result_.images.end(),
                               [&](const NamedImage& i) { return i.name == name; });
  for (int c = 0; c < ChannelsOf(name); ++c) {
    if (name == "colour") {
      WriteChannel(result_.colour[c], c, image);
    } else if (at != result_.images.end()) {
      WriteChannel(at->channels[static_cast<size_t>(c)], c, image);
    } else {
      ClearChannel(c, image);
    }
  }
}

void Session::WriteOutputs(const Settings& settings) {
  for (const auto& [name, image] : outputs_) {
    WriteOutput(settings, name, image);
  }
}

Status Session::Resize(int width, int height) {
  const bool any = width == 0 && height == 0;
  if (!any && (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)) {
    return Status::InvalidArgument(fmt::format("size is {}x{}, expected 1x1 to {}x{}, or 0x0",
                                               width, height, kMaxSide, kMaxSide));
  }
  inputs_.clear();
  outputs_.clear();
  width_ = width;
  height_ = height;
  if (frame_.width != width || frame_.height != height) {
    frame_ = Frame();
    result_ = DenoisedFrame();
    engine_.reset();
    two_way_.reset();
  }
  return Status::Ok();
}

void Session::Reset() {
  if (engine_.has_value()) {
    engine_->Reset();
  }
  if (two_way_.has_value()) {
    two_way_->Reset();
  }
}

Result<std::vector<uint8_t>> Session::SaveHistory() {
  STILLRAY_RETURN_IF_ERROR(RefuseWhileFramesWait("save_history was called"));
  STILLRAY_RETURN_IF_ERROR(Prepare());
  return engine_->SaveHistory();
}

Status Session::RestoreHistory(std::span<const uint8_t> bytes) {
  STILLRAY_RETURN_IF_ERROR(Prepare());
  return engine_->RestoreHistory(bytes);
}

stillray_statistics Session::Statistics() const {
  stillray_statistics s = STILLRAY_STATISTICS_INIT;
  s.non_finite = result_.non_finite;
  s.negative = result_.negative;
  s.bad_guides = result_.bad_guides;
  s.memory_bytes = (engine_.has_value() ? engine_->memory_bytes() : 0) +
                   (two_way_.has_value() ? two_way_->memory_bytes() : 0);
  s.filter_ms = last_filter_ms_;
  return s;
}

}  // namespace stillray::capi

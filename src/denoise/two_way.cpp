// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "stillray/two_way.hpp"

#include <algorithm>
#include <deque>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "core/guides.h"
#include "denoise/frame_check.h"
#include "denoise/future_blocks.h"
#include "denoise/next_motion.h"
#include "denoise/plan.h"
#include "denoise/shot_cuts.h"

namespace stillray {
namespace {

struct WaitingFrame {
  Frame frame;
  Image2 next_motion;
  bool continues = false;  ///< whether the previous frame shows the same shot
};

/// Copies the frame's planes to the host.
Status BringToHost(Frame* frame) {
  if (frame->on_device == nullptr) {
    return Status::Ok();
  }
  Frame host;
  STILLRAY_RETURN_IF_ERROR(OnHost(*frame, &host).status());
  *frame = std::move(host);
  return Status::Ok();
}

Status CheckNextMotion(const Frame& frame, const Image2& motion) {
  for (const Image1& plane : motion.channel) {
    const bool fits = plane.width() == frame.width && plane.height() == frame.height;
    if (!motion.empty() && !fits) {
      return Status::InvalidArgument(
          fmt::format("frame {}: image 'next_motion' is {}x{}, expected {}x{}", frame.index,
                      plane.width(), plane.height(), frame.width, frame.height));
    }
  }
  return Status::Ok();
}

bool SameSize(const Frame& a, const Frame& b) {
  return a.width == b.width && a.height == b.height;
}

Image2 MotionToNext(const WaitingFrame& now, const WaitingFrame& next) {
  const Guides& g = next.frame.guides;
  return now.next_motion.empty() ? ReverseMotion(g.motion, g.depth) : now.next_motion;
}

}  // namespace

struct TwoWayDenoiser::Impl {
  Impl(Denoiser forward_denoiser, FutureBlocks blocks)
      : forward(std::move(forward_denoiser)), futures(std::move(blocks)) {}

  Denoiser forward;
  FutureBlocks futures;
  std::deque<WaitingFrame> frames;  ///< the oldest first
  size_t first = 0;                 ///< position of frames.front() in the sequence
  bool finished = false;
  bool jittered = false;  ///< some frame of the sequence is jittered

  size_t pushed() const { return first + frames.size(); }
  Status CheckPush(const Frame& frame, bool may_continue) const;
  Status AccumulateBackward(const Progress& progress, double* done);
  void Restart();
};

/// Checks a frame as Denoiser does, but immediately, so that Push returns the error of its own
/// frame.
Status TwoWayDenoiser::Impl::CheckPush(const Frame& frame, bool may_continue) const {
  const bool shifts = jittered || IsJittered(frame.jitter_x, frame.jitter_y);
  return CheckFrame(frame, forward.settings(),
                    {may_continue, may_continue && AntialiasesInTime(forward.settings(), shifts)});
}

void TwoWayDenoiser::Impl::Restart() {
  frames.clear();
  first = 0;
  finished = jittered = false;
  forward.Reset();
  futures.Clear();
}

/// Accumulates the futures of the waiting frames, starting with the first.
/// \param done  [out] fraction of the call's work
Status TwoWayDenoiser::Impl::AccumulateBackward(const Progress& progress, double* done) {
  const FutureRange range = futures.Begin(first, pushed());
  const auto steps = static_cast<double>(range.look_end - range.begin + 1);
  for (size_t i = range.look_end; i-- > range.begin;) {
    if (progress && !progress(*done)) {
      return Status::Cancelled();
    }
    WaitingFrame& now = frames[i - first];
    const bool continues = i + 1 < range.look_end && frames[i + 1 - first].continues;
    FrameMotion motion;
    if (continues) {
      const WaitingFrame& next = frames[i + 1 - first];
      motion = MotionTowards(now.frame, next.frame, MotionToNext(now, next));
      SwapMotion(&motion, &now.frame);
    }
    const Status status = futures.Accumulate(i, now.frame, continues);
    if (continues) {
      SwapMotion(&motion, &now.frame);
    }
    STILLRAY_RETURN_IF_ERROR(status);
    *done += 1 / steps;
  }
  return Status::Ok();
}

TwoWayDenoiser::TwoWayDenoiser(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TwoWayDenoiser::TwoWayDenoiser(TwoWayDenoiser&&) noexcept = default;
TwoWayDenoiser& TwoWayDenoiser::operator=(TwoWayDenoiser&&) noexcept = default;
TwoWayDenoiser::~TwoWayDenoiser() = default;

Result<TwoWayDenoiser> TwoWayDenoiser::Create(const Settings& settings, const Device& device,
                                              const TwoWayOptions& options) {
  if (!settings.temporal) {
    return Status::InvalidArgument(
        "parameter 'temporal' is 'off', expected 'on': without history there is no light of the "
        "future either");
  }
  if (options.futures < 1 || options.futures > kFutureBlock) {
    return Status::InvalidArgument(
        fmt::format("futures is {}, expected 1 to {}", options.futures, kFutureBlock));
  }
  Result<Denoiser> forward = Denoiser::Create(settings, device, options.precision);
  STILLRAY_RETURN_IF_ERROR(forward.status());
  Result<Denoiser> backward = Denoiser::Create(settings, device, options.precision);
  STILLRAY_RETURN_IF_ERROR(backward.status());
  return TwoWayDenoiser(std::make_unique<Impl>(
      std::move(forward.value()), FutureBlocks(std::move(backward.value()), options.futures)));
}

Status TwoWayDenoiser::Push(Frame frame, Cut cut, Image2 next_motion) {
  Impl& d = *impl_;
  if (d.finished && !d.frames.empty()) {
    return Status::InvalidArgument(fmt::format(
        "frame {}: the sequence is finished and {} of its frames wait, expected that they are "
        "pulled first, or a reset",
        frame.index, d.frames.size()));
  }
  if (d.finished) {
    d.Restart();
  }
  STILLRAY_RETURN_IF_ERROR(CheckSize(frame));
  STILLRAY_RETURN_IF_ERROR(BringToHost(&frame));
  FillMissingGuides(d.forward.settings().demodulate, &frame);
  const Frame* before = d.frames.empty() ? nullptr : &d.frames.back().frame;
  bool continues = before != nullptr && cut != Cut::kYes && SameSize(frame, *before);
  STILLRAY_RETURN_IF_ERROR(d.CheckPush(frame, continues));
  STILLRAY_RETURN_IF_ERROR(CheckNextMotion(frame, next_motion));
  if (continues && cut == Cut::kFind) {
    continues = !IsCut(FindAgain(frame, before->guides));
  }
  d.jittered = d.jittered || IsJittered(frame.jitter_x, frame.jitter_y);
  d.frames.push_back({std::move(frame), std::move(next_motion), continues});
  return Status::Ok();
}

void TwoWayDenoiser::Finish() {
  impl_->finished = true;
}

bool TwoWayDenoiser::ready() const {
  return !impl_->frames.empty() &&
         (impl_->finished || impl_->pushed() >= FramesNeeded(impl_->first));
}

size_t TwoWayDenoiser::waiting() const {
  return impl_->frames.size();
}

const Frame* TwoWayDenoiser::Next() const {
  return impl_->frames.empty() ? nullptr : &impl_->frames.front().frame;
}

Result<bool> TwoWayDenoiser::Pull(DenoisedFrame* out, Frame* noisy, const Progress& progress) {
  if (!ready()) {
    return false;
  }
  Impl& d = *impl_;
  double done = 0;
  if (!d.futures.Holds(d.first)) {
    STILLRAY_RETURN_IF_ERROR(d.AccumulateBackward(progress, &done));
  }
  if (progress && !progress(done)) {
    return Status::Cancelled();
  }
  WaitingFrame& now = d.frames.front();
  if (!now.continues) {
    d.forward.Reset();
  }
  FutureLight& future = d.futures.At(d.first);
  STILLRAY_RETURN_IF_ERROR(d.forward.Denoise(now.frame, future, out));
  future = FutureLight();
  if (noisy != nullptr) {
    *noisy = std::move(now.frame);
  }
  d.frames.pop_front();
  ++d.first;
  return true;
}

void TwoWayDenoiser::Reset() {
  impl_->Restart();
}

Status TwoWayDenoiser::SetOutputs(const std::vector<std::string>& names) {
  return impl_->forward.SetOutputs(names);
}

void TwoWayDenoiser::SetResults(const Results& wanted) {
  impl_->forward.SetResults(wanted);
}

const Settings& TwoWayDenoiser::settings() const {
  return impl_->forward.settings();
}

const std::string& TwoWayDenoiser::remark() const {
  const std::string& backward = impl_->futures.backward().remark();
  return backward.empty() ? impl_->forward.remark() : backward;
}

size_t TwoWayDenoiser::memory_bytes() const {
  size_t bytes = impl_->forward.memory_bytes() + impl_->futures.memory_bytes();
  for (const WaitingFrame& waiting : impl_->frames) {
    bytes += FrameBytes(waiting.frame) + waiting.next_motion.bytes();
  }
  return bytes;
}

DeviceMemory TwoWayDenoiser::device_memory() const {
  DeviceMemory sum = impl_->forward.device_memory();
  const DeviceMemory backward = impl_->futures.backward().device_memory();
  sum.allocations += backward.allocations;
  sum.resources += backward.resources;
  sum.bytes += backward.bytes;
  sum.largest = std::max(sum.largest, backward.largest);
  return sum;
}

namespace {

/// A frame of `height` rows with the images of `like`: a mirror at one sample per pixel.
Frame MakeStrip(const Frame& like, int height) {
  const int width = like.width;
  Frame strip;
  strip.width = width;
  strip.height = height;
  strip.jitter_x = like.jitter_x;
  strip.jitter_y = like.jitter_y;
  strip.focal_pixels = static_cast<float>(width);  // arbitrary: memory does not depend on it
  const auto make = [&](const auto& given, auto* to) {
    if (!given.empty()) {
      *to = std::decay_t<decltype(*to)>(width, height);
    }
  };
  for (const Signal& signal : like.signals) {
    Signal made = {signal.kind, Image3(width, height), Image1()};
    make(signal.second_moment, &made.second_moment);
    strip.signals.push_back(std::move(made));
  }
  const Guides& g = like.guides;
  make(g.depth, &strip.guides.depth);
  make(g.normal, &strip.guides.normal);
  make(g.albedo, &strip.guides.albedo);
  make(g.specular_albedo, &strip.guides.specular_albedo);
  make(g.transmission_albedo, &strip.guides.transmission_albedo);
  make(g.id, &strip.guides.id);
  make(g.previous_normal, &strip.guides.previous_normal);
  make(g.roughness, &strip.guides.roughness);
  const auto make_image = [&](const VirtualGuides& given, VirtualGuides* to) {
    make(given.depth, &to->depth);
    make(given.normal, &to->normal);
    make(given.albedo, &to->albedo);
    make(given.motion, &to->motion);
    make(given.id, &to->id);
  };
  make_image(like.reflection, &strip.reflection);
  make_image(like.refraction, &strip.refraction);
  make(like.confidence, &strip.confidence);
  make(like.emission, &strip.emission);
  make(like.background, &strip.background);
  make(like.samples, &strip.samples);
  strip.guides.depth.Fill(1.0f);
  strip.guides.normal[2].Fill(1.0f);
  strip.samples.Fill(1.0f);
  strip.guides.motion = Image2(width, height);
  return strip;
}

/// Memory for frames of this height.
Result<TwoWayMemory> MeasureStrip(const Settings& settings, const Frame& like, bool next_motion,
                                  int height, const Device& device, DevicePrecision precision) {
  Frame strip = MakeStrip(like, height);
  FillMissingGuides(settings.demodulate, &strip);
  Result<Denoiser> backward = Denoiser::Create(settings, device, precision);
  STILLRAY_RETURN_IF_ERROR(backward.status());
  Result<Denoiser> forward = Denoiser::Create(settings, device, precision);
  STILLRAY_RETURN_IF_ERROR(forward.status());
  FutureLight future[2];
  for (FutureLight& light : future) {
    STILLRAY_RETURN_IF_ERROR(backward->Accumulate(strip, &light));
  }
  for (const FutureLight& light : future) {
    DenoisedFrame out;
    STILLRAY_RETURN_IF_ERROR(forward->Denoise(strip, light, &out));
  }
  TwoWayMemory memory;
  memory.denoisers = forward->memory_bytes() + backward->memory_bytes();
  memory.per_future = future[1].bytes();
  memory.per_frame = FrameBytes(strip) + (next_motion ? strip.guides.motion.bytes() : 0);
  return memory;
}

}  // namespace

Result<TwoWayMemory> TwoWayDenoiser::MemoryNeed(const Settings& settings, const Frame& like,
                                                bool next_motion, const Device& device,
                                                const TwoWayOptions& options) {
  STILLRAY_RETURN_IF_ERROR(Create(settings, device, options).status());
  STILLRAY_RETURN_IF_ERROR(CheckSize(like));
  // Both strips are taller than every border. Their heights differ from the frame's by multiples of
  // kRows, the number of rows for which some memory is counted together.
  constexpr int kRows = 8;
  const int low = kRows + like.height % kRows;
  const int high = low + kRows;
  const Result<TwoWayMemory> a =
      MeasureStrip(settings, like, next_motion, low, device, options.precision);
  STILLRAY_RETURN_IF_ERROR(a.status());
  const Result<TwoWayMemory> b =
      MeasureStrip(settings, like, next_motion, high, device, options.precision);
  STILLRAY_RETURN_IF_ERROR(b.status());
  const auto of_frame = [&](size_t of_low, size_t of_high) {
    const auto steps = static_cast<int64_t>((like.height - low) / kRows);
    const auto step = static_cast<int64_t>(of_high) - static_cast<int64_t>(of_low);
    return static_cast<size_t>(static_cast<int64_t>(of_low) + steps * step);
  };
  TwoWayMemory memory;
  memory.denoisers = of_frame(a->denoisers, b->denoisers);
  memory.per_future = of_frame(a->per_future, b->per_future);
  memory.per_frame = of_frame(a->per_frame, b->per_frame);
  memory.most =
      memory.denoisers + options.futures * memory.per_future + kMostWaiting * memory.per_frame;
  return memory;
}

}  // namespace stillray

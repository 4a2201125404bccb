// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoising of a sequence with light of past and future frames, for frames in memory: noisy frames
/// are pushed one by one, denoised frames are pulled in the same order after a delay. First frames
/// and disoccluded surfaces become as clean as other pixels. The result is bit-identical to
/// `stillray denoise --window both`.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "stillray/denoise.hpp"

namespace stillray {

/// Length of the blocks into which the sequence is divided, in frames.
inline constexpr size_t kFutureBlock = 16;
/// Number of frames after a block that must be known before it is ready, unless the sequence ends.
inline constexpr size_t kLookAhead = 16;
/// The maximum number of waiting frames if every ready frame is pulled before the next push.
inline constexpr size_t kMostWaiting = kFutureBlock + kLookAhead;

/// Whether a frame begins a new shot: no light is accumulated across the cut.
enum class Cut : uint8_t {
  kFind,  ///< a cut where hardly any surface of the previous frame is found again
  kYes,   ///< a cut; the frame's motion is not used
  kNo,    ///< no cut
};

struct TwoWayOptions {
  /// Number of FutureLight held at once, 1..kFutureBlock. Fewer take less memory and more time: the
  /// later frames are accumulated again for every part of a block. Results do not depend on it.
  size_t futures = kFutureBlock;
  DevicePrecision precision = DevicePrecision::kHalf;  ///< on devices other than the CPU
};

/// Memory of a TwoWayDenoiser, in bytes.
struct TwoWayMemory {
  size_t denoisers = 0;   ///< history and working memory of both directions
  size_t per_future = 0;  ///< of one FutureLight; TwoWayOptions::futures are held
  size_t per_frame = 0;   ///< of one waiting frame; kMostWaiting are held
  size_t most = 0;        ///< sum of all
};

/// One object denoises one sequence; one object must not be used by two threads at once.
///
/// Latency: the first block is ready when kMostWaiting frames are pushed, then one block for every
/// further kFutureBlock frames. Pull does the work: the first call of a block accumulates up to
/// kMostWaiting frames backward, the other calls denoise one frame each.
class TwoWayDenoiser {
 public:
  /// Called between frames with the completed fraction of the work, 0..1. \return false to cancel
  using Progress = std::function<bool(double)>;

  /// \return kInvalidArgument if the settings are not valid, or `temporal` is off: light of the
  ///     future needs a history
  static Result<TwoWayDenoiser> Create(const Settings& settings, const Device& device = Device(),
                                       const TwoWayOptions& options = TwoWayOptions());
  TwoWayDenoiser(TwoWayDenoiser&&) noexcept;
  TwoWayDenoiser& operator=(TwoWayDenoiser&&) noexcept;
  ~TwoWayDenoiser();

  /// Appends a frame to the sequence and takes its planes. A frame on a device is copied to the
  /// host. The first frame after a finished and pulled sequence begins a new sequence.
  /// \param frame  as for Denoiser::Denoise; motion is needed unless the frame begins a shot
  /// \param next_motion  motion towards the next frame, in pixels: the point visible at p is at p +
  ///     next_motion(p) one frame later. Empty: computed from the next frame's motion (see
  ///     ReverseMotion)
  /// \return kInvalidArgument naming the image that is missing or has a wrong size, or after
  ///         Finish() while frames wait; the sequence is then unchanged
  Status Push(Frame frame, Cut cut = Cut::kFind, Image2 next_motion = Image2());
  /// Ends the sequence with the last frame that was pushed: all waiting frames become ready.
  void Finish();

  /// Whether Pull has a frame to finish.
  bool ready() const;
  /// Frames that were pushed and not yet pulled.
  size_t waiting() const;
  /// The next frame to be pulled; nullptr if no frame waits.
  const Frame* Next() const;

  /// Finishes the next frame.
  /// \param out    the denoised image, and the outputs of SetOutputs
  /// \param noisy  if given: set to the frame that was pushed, with missing guides filled in. Its
  ///     planes can be reused for another Push
  /// \return false if no frame is ready; kCancelled if `progress` returned false: no frame is lost,
  ///     and another call repeats the work. Other errors as Denoiser::Denoise
  Result<bool> Pull(DenoisedFrame* out, Frame* noisy = nullptr,
                    const Progress& progress = Progress());

  /// Discards all waiting frames and all history: the next frame is the first of a sequence.
  void Reset();

  /// As the functions of Denoiser.
  Status SetOutputs(const std::vector<std::string>& names);
  void SetResults(const Results& wanted);
  const Settings& settings() const;
  const std::string& remark() const;

  /// Memory in use, in bytes: history, working memory, futures and waiting frames.
  size_t memory_bytes() const;
  /// The part of memory_bytes() on a device; zero on the CPU.
  DeviceMemory device_memory() const;

  /// Memory for frames like `like`, extrapolated from two strips of a few rows, as the planes of a
  /// denoiser grow linearly with rows. Exact on the CPU for frames with at least one sample per
  /// pixel, and with mirrors if they have a roughness; without mirrors a little less is held.
  /// Frames below one sample per pixel, or with unknown guides, take up to 400 bytes per pixel
  /// more, and ReverseMotion 16 while it runs.
  /// \param like  width, height and jitter of the frames; planes that are not empty mark the images
  ///     in use, their size and values are ignored
  /// \param next_motion  whether Push is called with `next_motion`
  /// \return errors as Create and Push
  static Result<TwoWayMemory> MemoryNeed(const Settings& settings, const Frame& like,
                                         bool next_motion = false, const Device& device = Device(),
                                         const TwoWayOptions& options = TwoWayOptions());

 private:
  struct Impl;
  explicit TwoWayDenoiser(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillray

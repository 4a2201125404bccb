// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoising of a sequence with light of the past and of the future, for frames in memory: noisy
/// frames are pushed one by one, finished ones are pulled in the same order, some later. First
/// frames and freshly uncovered surfaces come out as clean as the rest. The same frames and
/// settings give the bits of `stillray denoise --window both`.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "stillray/denoise.hpp"

namespace stillray {

/// Frames fall into blocks of this length, counted from the first, ...
inline constexpr size_t kFutureBlock = 16;
/// ... and a block is finished once so many frames behind it are known, or the sequence ends.
inline constexpr size_t kLookAhead = 16;
/// The most frames that wait if every ready frame is pulled before the next one is pushed.
inline constexpr size_t kMostWaiting = kFutureBlock + kLookAhead;

/// Whether a frame begins a new shot, over whose edge no light is carried.
enum class Cut : uint8_t {
  kFind,  ///< where hardly any surface of the frame before is found again
  kYes,   ///< motion is not used then
  kNo,
};

struct TwoWayOptions {
  /// Futures (light of later frames) held at once, 1..kFutureBlock. Fewer take less memory and more
  /// time: the frames behind are accumulated again for every part of a block. No bit depends on it.
  size_t futures = kFutureBlock;
  DevicePrecision precision = DevicePrecision::kHalf;  ///< on devices other than the CPU
};

/// Memory of a TwoWayDenoiser, in bytes.
struct TwoWayMemory {
  size_t denoisers = 0;   ///< history and working memory of both directions
  size_t per_future = 0;  ///< TwoWayOptions::futures of them are held
  size_t per_frame = 0;   ///< kMostWaiting of them are held
  size_t most = 0;        ///< all that together
};

/// One object denoises one sequence; one object must not be used by two threads at once.
///
/// Latency: the first frame is ready when kMostWaiting frames are pushed, then the whole block is;
/// from there on one block each time that another kFutureBlock frames are pushed. Pull does the
/// work: the first of a block accumulates up to kMostWaiting frames backward, the others denoise
/// one frame each.
class TwoWayDenoiser {
 public:
  /// Called between two frames of the work with the part of it that is done, 0..1. \return whether
  /// to go on
  using Progress = std::function<bool(double)>;

  /// \return kInvalidArgument if the settings are not valid, or `temporal` is off: without history
  ///         there is no light of the future either
  static Result<TwoWayDenoiser> Create(const Settings& settings, const Device& device = Device(),
                                       const TwoWayOptions& options = TwoWayOptions());
  TwoWayDenoiser(TwoWayDenoiser&&) noexcept;
  TwoWayDenoiser& operator=(TwoWayDenoiser&&) noexcept;
  ~TwoWayDenoiser();

  /// Appends a frame to the sequence and takes its planes. One that lies on a device is copied to
  /// the host. The first frame after a finished sequence has been pulled begins a new one.
  /// \param frame  as for Denoiser::Denoise; motion is needed unless the frame begins a shot
  /// \param next_motion  motion towards the next frame, in pixels: the point seen at p stands at
  ///        p + next_motion(p) one frame later. Empty: found from the next frame's own motion (see
  ///        ReverseMotion)
  /// \return kInvalidArgument naming the image that is missing or has a wrong size, or after
  ///         Finish() while frames wait; the sequence is then unchanged
  Status Push(Frame frame, Cut cut = Cut::kFind, Image2 next_motion = Image2());
  /// The sequence ends with the last frame that was pushed: all frames are ready.
  void Finish();

  /// Whether Pull has a frame to finish.
  bool ready() const;
  /// Frames that were pushed and not yet pulled.
  size_t waiting() const;
  /// The next frame to be pulled; nullptr where none waits.
  const Frame* Next() const;

  /// Finishes the next frame.
  /// \param out    the picture, and the outputs of SetOutputs
  /// \param noisy  if given: set to the frame that was pushed, with substitutes for missing
  ///     guides. Its planes can be filled and pushed again
  /// \return false if no frame is ready; kCancelled if `progress` requested it: nothing is lost,
  ///     and another call repeats the work. Other errors as Denoiser::Denoise
  Result<bool> Pull(DenoisedFrame* out, Frame* noisy = nullptr,
                    const Progress& progress = Progress());

  /// Drops all frames that wait and all history: the next frame is the first of a sequence.
  void Reset();

  /// As those of Denoiser.
  Status SetOutputs(const std::vector<std::string>& names);
  void SetResults(const Results& wanted);
  const Settings& settings() const;
  const std::string& remark() const;

  /// Memory held now: history, working memory, futures and frames that wait.
  size_t memory_bytes() const;
  /// The part of it on a device; zero on the CPU.
  DeviceMemory device_memory() const;

  /// Memory that frames like `like` will take, measured with two strips of a few rows: with every
  /// row the planes of a denoiser grow by the same number of bytes. Exact on the CPU for frames
  /// with one sample per pixel or more, and mirrors if they have a roughness; without mirrors a
  /// little less is held. Frames below one sample per pixel, or with unknown guides, take up to 400
  /// bytes per pixel more, and ReverseMotion 16 while it works.
  /// \param like  width, height and jitter of the frames; planes that are not empty say which
  ///        images there are, whatever their size and values
  /// \param next_motion  whether motion towards the next frame is pushed
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

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The interface between a Denoiser and its implementations on the CPU and on devices.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "denoise/guide_source.h"
#include "stillray/denoise.hpp"

namespace stillray {

struct SignalHistory;

/// Name of the host's part of a frame in the timings of a device.
inline constexpr const char* kUploadStage = "upload";

/// The images that mirrors and glass show in a part of a frame, of the frame's size.
struct ShownImages {
  const Image1* depth = nullptr;   ///< of FindImages, of reflections whose albedo is part of the
                                   ///< specular albedo: see sum_albedo; nullptr: none
  const Image1* length = nullptr;  ///< of TakeLengths, 0 where a pixel shows none; nullptr: none
};

/// One implementation of the denoiser. See the functions of Denoiser with the same names. Callers
/// have checked settings, names, the frame's size and its future, and replaced missing guides.
class DenoiserBackend {
 public:
  virtual ~DenoiserBackend() = default;
  /// \param future  one history per signal, of the frame's size, as Accumulate makes them; empty:
  ///                the frame's future is not known
  virtual Status Denoise(const Frame& frame, std::span<const SignalHistory> future,
                         DenoisedFrame* out) = 0;
  virtual Status Accumulate(const Frame& frame, std::vector<SignalHistory>* future) = 0;
  /// The images that the next frame to be denoised shows, until it has been denoised. Only for
  /// devices, as the next: of parts of a frame on the host (LayeredDenoiser).
  virtual void ShowImages(const ShownImages&) {}
  /// The number of samples in the light of the first signal of the last frame, whose colour was
  /// requested.
  virtual Status ReadLength(Image1*) {
    return Status::Unsupported("only denoisers on devices have lengths to read");
  }
  virtual Status SetSettings(const Settings& settings) = 0;
  virtual void SetResults(const Results& wanted) = 0;
  virtual Status ReadColour(Image3* colour) = 0;
  /// \param names  of single outputs, known to be valid
  virtual void SetOutputs(std::vector<std::string> names) = 0;
  virtual void Reset() = 0;
  virtual size_t memory_bytes() const = 0;
  virtual DeviceMemory device_memory() const = 0;
  virtual Result<std::vector<uint8_t>> SaveHistory() = 0;
  virtual Status RestoreHistory(std::span<const uint8_t> bytes) = 0;
};

/// Parts of a frame whose pixels a renderer left on the device, as frames that are on the device
/// too: layers of reflected and of transmitted light, and the rest. See LayeredDenoiser. Parts are
/// for denoisers on the same device: first the layers, which must exist until the rest has been
/// denoised, then the rest, before parts of another frame are made.
class FrameSplit {
 public:
  virtual ~FrameSplit() = default;
  /// Reflected or transmitted light with the guides of select_guides.
  /// \param frame  DeviceBackend::Holds it, and it has virtual guides of this source
  /// \return kOutOfMemory, or errors of the device
  virtual Result<Frame> MakeLayer(const Frame& frame, GuideSource source,
                                  const Settings& settings) = 0;
  /// The frame whose light in the layers that exist is black, with the motion of FollowImages; the
  /// pictures of its layers are part of its emission.
  virtual Result<Frame> MakeRest(const Frame& frame) = 0;
  /// Appends the device's times for all parts of the last frame.
  virtual void AddTimes(std::vector<StageTime>* times) const = 0;
  virtual DeviceMemory memory() const = 0;
};

/// An opened device other than the CPU.
class DeviceBackend {
 public:
  virtual ~DeviceBackend() = default;
  virtual Result<std::unique_ptr<DenoiserBackend>> CreateDenoiser(const Settings& settings,
                                                                  DevicePrecision precision) = 0;
  /// Whether a renderer left the frame's pixels on this device, for a FrameSplit.
  virtual bool Holds(const Frame&) const { return false; }
  virtual Result<std::unique_ptr<FrameSplit>> CreateFrameSplit() {
    return Status::Unsupported("frames on this device have no parts");
  }
};

struct Device::Impl {
  std::string description;
  std::string remark;
  std::shared_ptr<DeviceBackend> backend;  ///< nullptr: the CPU
  bool may_fall_back = false;              ///< chosen by "auto"
};

/// A device on an opened backend.
Device MakeDevice(std::shared_ptr<DeviceBackend> backend, std::string description);
/// The device's backend; nullptr: the CPU.
std::shared_ptr<DeviceBackend> BackendOf(const Device& device);

}  // namespace stillray

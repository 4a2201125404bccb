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

/// Name of the upload from the host in the timings of a device.
inline constexpr const char* kUploadStage = "upload";

/// The virtual images in mirrors and glass, for one part of a frame. Planes have the frame's size.
struct ShownImages {
  const Image1* depth = nullptr;  ///< output of FindImages: depth of reflections whose albedo is
                                  ///< part of the specular albedo (sum_albedo); nullptr: none
  const Image1* length =
      nullptr;  ///< output of TakeLengths, 0 without virtual image; nullptr: none
};

/// One implementation of the denoiser. See the functions of Denoiser with the same names.
/// Preconditions: settings, names, the frame's size and its future are checked, and missing guides
/// are replaced.
class DenoiserBackend {
 public:
  virtual ~DenoiserBackend() = default;
  /// \param future  output of Accumulate: one history per signal, of the frame's size; empty: the
  ///                frame's future is unknown
  virtual Status Denoise(const Frame& frame, std::span<const SignalHistory> future,
                         DenoisedFrame* out) = 0;
  virtual Status Accumulate(const Frame& frame, std::vector<SignalHistory>* future) = 0;
  /// Sets the virtual images of the next frame to be denoised; they must exist until it is
  /// denoised. Only for devices, for parts of a frame on the host (LayeredDenoiser).
  virtual void ShowImages(const ShownImages&) {}
  /// Reads the history length of the first signal in the last frame, whose colour must have been
  /// requested. Only for devices.
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

/// Splits a frame that a renderer left on the device into parts, which are frames on this device
/// too: the layers of reflected and of transmitted light, and the remaining frame ("rest"). See
/// LayeredDenoiser. Denoisers on the same device process first the layers, which must exist until
/// the rest has been denoised, then the rest, before parts of another frame are made.
class FrameSplit {
 public:
  virtual ~FrameSplit() = default;
  /// The layer of reflected or transmitted light, with the guides of select_guides.
  /// \param frame  DeviceBackend::Holds(frame) is true, and it has virtual guides of this source
  /// \return kOutOfMemory, or errors of the device
  virtual Result<Frame> MakeLayer(const Frame& frame, GuideSource source,
                                  const Settings& settings) = 0;
  /// The frame without the radiance of the layers made so far, with the motion of FollowImages; the
  /// denoised images of the layers are added to its emission.
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
  /// Whether the frame's pixels are on this device, as a FrameSplit requires.
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

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The interface between a Denoiser and its implementations on the CPU and on devices.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stillray/denoise.hpp"

namespace stillray {

struct SignalHistory;

/// Name of the host's part of a frame in the timings of a device.
inline constexpr const char* kUploadStage = "upload";

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

/// An opened device other than the CPU.
class DeviceBackend {
 public:
  virtual ~DeviceBackend() = default;
  virtual Result<std::unique_ptr<DenoiserBackend>> CreateDenoiser(const Settings& settings,
                                                                  DevicePrecision precision) = 0;
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

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// `stillray bench --fps`: whole frames per second of tracing alone, with the temporal stage, and
/// with all of SVGF, and the memory that each takes.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "common/trace_device.h"
#include "stillray/denoise.hpp"
#include "stillray/render.h"

namespace stillray {

/// Milliseconds of a part of one frame.
struct PartTime {
  double wall = 0;
  double device = 0;  ///< by the clock of the device that did it; 0: the CPU, or it has none
};

/// The device's own time of the last frame; 0 for the CPU.
double DeviceTimeOf(const DeviceRenderer& renderer);

class FramesBench {
 public:
  /// \param downloads  whether filtered pictures are copied from the device to the host
  explicit FramesBench(bool downloads) : downloads_(downloads) {}

  /// \param name      of the configuration
  /// \param settings  of its filter; nullptr: none, the noisy frames themselves
  Status Add(const std::string& name, const Settings* settings, const Device& device);

  /// A frame was traced: every configuration makes its picture of it.
  /// \param record  false: to warm up
  Status Run(const Frame& frame, const PartTime& traced, bool record);
  /// Bytes of the tracer, scene included.
  void SetTracerBytes(size_t bytes) { tracer_bytes_ = bytes; }

  std::string Table() const;
  nlohmann::ordered_json Json() const;

 private:
  struct PartTimes {
    std::vector<double> wall;
    std::vector<double> device;

    void Add(const PartTime& time);
  };
  struct Entry {
    std::string name;
    std::vector<Denoiser> denoiser;  ///< one, or none
    DenoisedFrame out;
    std::vector<double> frame_ms;  ///< tracing and filter
    PartTimes filter;
  };
  /// Memory; zero where it is not known.
  struct Part {
    std::string name;
    DeviceMemory memory;
  };
  std::vector<Part> Parts() const;

  bool downloads_;
  std::vector<Entry> entries_;
  PartTimes trace_;
  DeviceMemory frame_;  ///< the images of a frame
  size_t tracer_bytes_ = 0;
};

}  // namespace stillray

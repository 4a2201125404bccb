// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// `stillray bench --fps`: frame rates of tracing alone, with the temporal stage, and with complete
/// SVGF, and their memory use.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "common/trace_device.h"
#include "stillray/denoise.hpp"
#include "stillray/render.h"

namespace stillray {

/// Time of a part of one frame in milliseconds.
struct PartTime {
  double wall = 0;
  double device = 0;  ///< measured by device timestamps; 0: on the CPU, or without timestamps
};

/// The device's own time of the last frame; 0 for the CPU.
double DeviceTimeOf(const DeviceRenderer& renderer);

class FramesBench {
 public:
  /// \param downloads  whether denoised images are copied from the device to the host
  explicit FramesBench(bool downloads) : downloads_(downloads) {}

  /// \param name      name of the configuration
  /// \param settings  settings of its filter; nullptr: no filter, only the noisy frames
  Status Add(const std::string& name, const Settings* settings, const Device& device);

  /// Filters a traced frame with every configuration.
  /// \param record  false: warm-up frame
  Status Run(const Frame& frame, const PartTime& traced, bool record);
  /// Sets the memory of the path tracer in bytes, including the scene.
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
    std::vector<Denoiser> denoiser;  ///< at most one element
    DenoisedFrame out;
    std::vector<double> frame_ms;  ///< tracing and filter
    PartTimes filter;
  };
  /// Memory of a part; 0 if unknown.
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

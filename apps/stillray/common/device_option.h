// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Option `--device` of the subcommands that denoise.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "common/render_devices.h"
#include "stillray/denoise.hpp"

namespace CLI {
class App;
}

namespace stillray {

/// Adds --device and --verbose.
void AddDeviceOption(CLI::App* command, std::string* text, bool* verbose);
void AddVerboseOption(CLI::App* command, bool* verbose);

/// Opens the device and prints one line with its name on standard error; for the CPU with the
/// number of threads and the reason for the choice by "auto".
/// \param verbose  print a second line with the driver's message
/// \param work     activity in the message, such as "denoising"
Result<Device> OpenDeviceOption(const std::string& text, bool verbose, const std::string& work);

/// Adds --trace-device.
void AddTraceDeviceOption(CLI::App* command, std::string* text);

/// OpenDeviceOption for --device and --trace-device; prints one line, or two if they differ.
/// \param trace_device  empty: `device`
Result<RenderDevices> OpenRenderDevices(const std::string& device, const std::string& trace_device,
                                        bool verbose);

/// Prints once on standard error that a denoiser fell back to the CPU.
void TellFallBack(const Denoiser& denoiser, bool* told);

/// One line about a denoiser's memory on its device; empty for the CPU.
std::string DeviceMemoryLine(const DeviceMemory& memory);
nlohmann::ordered_json DeviceMemoryJson(const DeviceMemory& memory);

/// The output of `stillray info --devices`.
std::string DevicesText();
nlohmann::ordered_json DevicesJson();

}  // namespace stillray

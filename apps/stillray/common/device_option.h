// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// `--device` of the subcommands that denoise.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "stillray/denoise.hpp"

namespace CLI {
class App;
}

namespace stillray {

/// --device and --verbose.
void AddDeviceOption(CLI::App* command, std::string* text, bool* verbose);
void AddVerboseOption(CLI::App* command, bool* verbose);

/// Opens the device and says on standard error in one line which it is, and for the CPU with how
/// many threads and why "auto" chose it.
/// \param verbose  a second line gives the driver's own message
/// \param work     what is done there, such as "denoising"
Result<Device> OpenDeviceOption(const std::string& text, bool verbose, const std::string& work);

/// Says on standard error, once, that a denoiser came to work on the CPU after all.
void TellFallBack(const Denoiser& denoiser, bool* told);

/// One line about a denoiser's memory on its device; empty for the CPU.
std::string DeviceMemoryLine(const DeviceMemory& memory);
nlohmann::ordered_json DeviceMemoryJson(const DeviceMemory& memory);

/// What `stillray info --devices` prints.
std::string DevicesText();
nlohmann::ordered_json DevicesJson();

}  // namespace stillray

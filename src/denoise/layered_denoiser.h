// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>

#include "denoise/backend.h"

namespace stillray {

/// A denoiser on a device for frames with virtual guides, whose device code has the guides of
/// surfaces alone: reflected and refracted light are denoised as frames of their own, with the
/// guides of select_guides, and added to the picture before it is antialiased. The result is that
/// of the layers on the CPU. Frames without virtual guides go to `main` unchanged.
std::unique_ptr<DenoiserBackend> MakeLayeredDenoiser(const Settings& settings,
                                                     DevicePrecision precision,
                                                     std::shared_ptr<DeviceBackend> device,
                                                     std::unique_ptr<DenoiserBackend> main);

}  // namespace stillray

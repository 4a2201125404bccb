// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>

#include "denoise/backend.h"

namespace stillray {

/// A denoiser on a device for frames with virtual guides, built from denoisers that support only
/// the guides of surfaces: reflected and refracted light are denoised as separate frames, with the
/// guides of select_guides, and added to the image before it is antialiased. The result equals that
/// of the layers on the CPU. Frames without virtual guides are passed to `main` unchanged.
std::unique_ptr<DenoiserBackend> MakeLayeredDenoiser(const Settings& settings,
                                                     DevicePrecision precision,
                                                     std::shared_ptr<DeviceBackend> device,
                                                     std::unique_ptr<DenoiserBackend> main);

}  // namespace stillray

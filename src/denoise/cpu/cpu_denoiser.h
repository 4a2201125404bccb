// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>

#include "denoise/backend.h"

namespace stillray {

/// \param implementation  kCpu: SIMD and threads; kReference: scalar
std::unique_ptr<DenoiserBackend> MakeCpuDenoiser(const Settings& settings,
                                                 Backend implementation = Backend::kCpu);

}  // namespace stillray

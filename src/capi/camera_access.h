// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Cameras of the C API.
#pragma once

#include <algorithm>
#include <array>
#include <iterator>

#include "stillray/camera.h"
#include "stillray/stillray.h"

namespace stillray::capi {

inline CameraMatrices ReadCamera(const stillray_camera& camera) {
  std::array<double, 16> to_camera{};
  std::array<double, 16> projection{};
  std::copy(std::begin(camera.world_to_camera), std::end(camera.world_to_camera),
            to_camera.begin());
  std::copy(std::begin(camera.projection), std::end(camera.projection), projection.begin());
  return MatricesOf(to_camera, projection);
}

}  // namespace stillray::capi

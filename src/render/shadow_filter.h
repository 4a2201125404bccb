// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Describes the instances of a scene for its Accel: moving instances, and surfaces with
/// transmittance for shadow rays.
#pragma once

#include <vector>

#include "render/accel.h"
#include "render/scene_state.h"

namespace stillray::render {

/// Transmittance of shadow rays through alpha cut-outs, alpha-blended surfaces and smooth thin
/// sheets.
class SceneShadowFilter final : public ShadowFilter {
 public:
  /// \param state  must outlive this
  explicit SceneShadowFilter(const SceneState& state) : state_(state) {}
  vec3 Transmittance(const Hit& hit, vec3 direction) const override;

 private:
  const SceneState& state_;
};

/// Whether any part of the instance may be transparent to shadow rays.
bool IsSeeThrough(const PlacedInstance& instance);

/// The argument of Accel::Create, in the order of the scene's instances.
std::vector<AccelInstance> DescribeInstances(const SceneState& state);

}  // namespace stillray::render

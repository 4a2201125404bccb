// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Describes a scene to its BVH: moving instances, and surfaces that shadow rays pass.
#pragma once

#include <vector>

#include "render/accel.h"
#include "render/scene_state.h"

namespace stillray::render {

/// Shadow rays pass alpha cut-outs, blended surfaces and smooth thin sheets.
class SceneShadowFilter final : public ShadowFilter {
 public:
  /// \param state  must outlive this
  explicit SceneShadowFilter(const SceneState& state) : state_(state) {}
  vec3 Transmittance(const Hit& hit, vec3 direction) const override;

 private:
  const SceneState& state_;
};

/// Whether shadow rays may pass parts of the instance.
bool IsSeeThrough(const PlacedInstance& instance);

/// For Accel::Create, in the order of the scene's instances.
std::vector<AccelInstance> DescribeInstances(const SceneState& state);

}  // namespace stillray::render

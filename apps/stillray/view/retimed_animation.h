// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// An animation with two clocks: one for moving lights, one for everything else.
#pragma once

#include <vector>

#include "stillray/scene.h"

namespace stillray::view {

/// Time of both clocks, seconds.
struct AnimationTime {
  double all = 0;
  double lights = 0;
  bool operator==(const AnimationTime&) const = default;
};

/// A channel belongs to the lights if its node or a descendant emits light (a punctual light, or a
/// mesh with an emissive material) and none carries a camera.
///
/// If both clocks agree, the scene is unchanged. Otherwise its channels are replaced by channels
/// with two keys, at 0 s and 1 s, with the previous and the current values. The renderer reads the
/// channels in every frame; it must not run while they change.
class RetimedAnimation {
 public:
  /// \param scene  valid; must outlive this
  explicit RetimedAnimation(Scene* scene);

  bool has_lights() const { return has_lights_; }
  /// Nodes, cameras and animation of the unmodified scene, without meshes.
  const Scene& original() const { return original_; }
  /// Sets the scene to the times of the next frame and of the previous one.
  /// \param seconds, previous_seconds  [out] times to pass to the renderer
  void Set(const AnimationTime& now, const AnimationTime& before, double* seconds,
           double* previous_seconds);

 private:
  Scene* scene_;
  Scene original_;
  std::vector<Scene> probes_;    ///< one node with one channel each
  std::vector<bool> of_lights_;  ///< whether each channel belongs to the lights
  bool has_lights_ = false;
  bool replaced_ = false;
};

}  // namespace stillray::view

// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// An animation with two clocks: one of the lights that move, one of everything else.
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

/// A channel belongs to the lights if its node or one below it gives light (a punctual light, or a
/// mesh whose material emits) and no camera hangs on it.
///
/// Where both clocks agree, the scene is as it was loaded. Where they do not, its channels are
/// replaced by ones of two keys, 0 s and 1 s, that hold where everything was and is. The renderer
/// reads the channels anew with every frame; it must not be at work while they change.
class RetimedAnimation {
 public:
  /// \param scene  valid; must outlive this
  explicit RetimedAnimation(Scene* scene);

  bool has_lights() const { return has_lights_; }
  /// Nodes, cameras and animation as they were loaded; no meshes.
  const Scene& original() const { return original_; }
  /// Sets the scene to the time of the next frame and of the one before.
  /// \param seconds, previous_seconds  what the renderer is to be asked for
  void Set(const AnimationTime& now, const AnimationTime& before, double* seconds,
           double* previous_seconds);

 private:
  Scene* scene_;
  Scene original_;
  std::vector<Scene> probes_;    ///< one node with one channel each
  std::vector<bool> of_lights_;  ///< which channels
  bool has_lights_ = false;
  bool replaced_ = false;
};

}  // namespace stillray::view

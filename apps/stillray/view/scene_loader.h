// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Loads scenes on a separate thread. No call blocks.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "view/loaded_scene.h"

namespace stillray::view {

struct LoadState {
  bool loading = false;
  LoadPhase phase;
  double seconds = 0;  ///< seconds since the start
};

class SceneLoader {
 public:
  struct Outcome {
    Status status;
    std::unique_ptr<LoadedScene> scene;  ///< nullptr if it failed
  };

  /// \param changed  called from the loader's thread when state() has changed, with true when an
  ///     outcome is ready; must not call the loader
  explicit SceneLoader(std::function<void(bool finished)> changed);
  /// Does not wait for a file that is being read: the thread terminates later, and its result is
  /// discarded.
  ~SceneLoader();
  SceneLoader(const SceneLoader&) = delete;
  SceneLoader& operator=(const SceneLoader&) = delete;

  /// A later request replaces an earlier one.
  /// \param device  device that traces the scene
  void Load(const SceneRequest& request, const ViewSettings& settings,
            const Device& device = Device());
  LoadState state() const;
  /// Takes the outcome of the last request, if it is complete and has not been taken.
  std::optional<Outcome> Take();

  /// Number of running threads of destroyed loaders. While there are any, the program must not
  /// destroy shared state: wait for them, or end with _Exit.
  static int abandoned();
  static void WaitForAbandoned();

 private:
  struct Shared;
  static void Run(const std::shared_ptr<Shared>& shared);

  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace stillray::view

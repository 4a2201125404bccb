// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Loads scenes on a thread of its own. Every call returns at once.
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
  double seconds = 0;  ///< since it began
};

class SceneLoader {
 public:
  struct Outcome {
    Status status;
    std::unique_ptr<LoadedScene> scene;  ///< nullptr if it failed
  };

  /// \param changed  called from the loader's thread when there is something new in state(), with
  ///                 true when an outcome waits; must not call the loader
  explicit SceneLoader(std::function<void(bool finished)> changed);
  /// Does not wait for a file that is being read: what is at work then ends by itself, and what it
  /// has made is thrown away.
  ~SceneLoader();
  SceneLoader(const SceneLoader&) = delete;
  SceneLoader& operator=(const SceneLoader&) = delete;

  /// A later request takes the place of an earlier one.
  /// \param device  where the scene is to be traced
  void Load(const SceneRequest& request, const ViewSettings& settings,
            const Device& device = Device());
  LoadState state() const;
  /// Of the last request, once.
  std::optional<Outcome> Take();

  /// Threads of loaders that are gone which are still at work. While there are any, the program
  /// must not tear down what they use: wait for them, or end with _Exit.
  static int abandoned();
  static void WaitForAbandoned();

 private:
  struct Shared;
  static void Run(const std::shared_ptr<Shared>& shared);

  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace stillray::view
